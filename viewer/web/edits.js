/* SPDX-License-Identifier: MIT */
/* Changes of the scene: shown in the page at once, sent merged, and undone as one where a hand made them in one move. What the session says
 * of the scene meanwhile is older than the hand and waits until it rests. */

import { mergeParts } from './connection.js';
import { get, set } from './store.js';
import { Burst } from './trackball.js';

const REST_MS = 160;

/** `scene` with a part of it replaced. */
function merged(scene, part) {
    const out = mergeParts(scene, part);
    /* Colours that were moved are no longer the map that they came from. */
    if (part.transfer?.colors && !part.transfer.colormap) delete out.transfer.colormap;
    return out;
}

export class Edits {
    #gesture = 0;
    #state = null;
    #told = null;
    #timer = 0;

    constructor(connection) {
        this.connection = connection;
        this.keys = new Burst(connection);
    }

    /**
     * @param {object} part   keys of a scene file
     * @param {"start"|"move"|"end"|"key"} phase   "end" alone is a change of one step; "key": one press of a key, those that follow each
     *     other closely are one step
     */
    apply(part, phase = 'end') {
        if (!get('scene')) return;
        const dragged = phase === 'start' || phase === 'move';
        if (dragged && !this.#gesture) {
            this.#gesture = this.connection.newGesture();
            this.connection.hold();
        }
        set({ scene: merged(get('scene'), part) });
        this.connection.edit(part, this.#gesture || (phase === 'key' ? this.keys.touch() : this.connection.newGesture()));
        if (phase === 'end' && this.#gesture) {
            this.connection.release();
            this.#gesture = 0;
        }
        this.#rest();
    }

    #rest() {
        clearTimeout(this.#timer);
        this.#timer = setTimeout(() => {
            this.#timer = 0;
            if (this.#state && !this.#gesture) set(this.#state);
            else if (this.#gesture) this.#rest();
            this.#state = this.#gesture ? this.#state : null;
        }, REST_MS);
    }

    /** What the session says: taken now, or once the hand rests. */
    state(event) {
        const { scene, undo, redo } = event,
            rest = { undo, redo };
        this.#told = scene;
        if (this.#timer || this.#gesture) {
            this.#state = { scene, ...rest };
            set(rest);
        } else {
            set({ scene, ...rest });
        }
    }

    /** A change was refused: what is shown is again what the session has. */
    refused() {
        this.#state = null;
        if (this.#told) set({ scene: { ...this.#told } });
    }

    /** The connection was lost: no hand holds anything. */
    drop() {
        this.#gesture = 0;
        this.#state = null;
    }
}
