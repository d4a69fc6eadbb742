/* SPDX-License-Identifier: MIT */
/* The probe under the pointer, and distances between two places that were clicked. */

import { button, field, h, short, svg } from './dom.js';
import { numberInput } from './controls.js';
import { length, sub } from './geometry.js';
import { get, set, watch } from './store.js';

const PAUSE_MS = 60;

/** Of lengths in the world, "" where the volume does not tell it. */
export const worldUnit = () => get('volume')?.units ?? '';

/** NaN, of samples that were not measured, comes as null. */
const valueOf = ({ value }) => (value === null ? 'no value' : `value ${short(value)}`);

/** Between the samples, as the value is. */
const voxelOf = ({ index }) => index?.map((x) => Number(x.toFixed(2))).join(', ');

/** What a probe found, as one line. */
export function describe(probe) {
    const index = voxelOf(probe),
        world = probe.world?.map((x) => short(x)).join(', ');
    return `${valueOf(probe)}   voxel ${index}   at ${world} ${worldUnit()}`;
}

/** Asks what is under the pointer, one question at a time; only the newest place, in the newest picture, matters. */
export class Probe {
    #busy = false;
    #place = null; /* where the pointer is */
    #due = false; /* it is to be asked what is there */
    #era = 0; /* answers to questions of an earlier one are no more true */
    #camera = '';

    constructor(app) {
        this.app = app;
        this.opacity = 0.1;
        watch(['volume'], () => this.hover(null));
        watch(['scene'], () => this.#place?.at && this.#again());
        app.picture.addEventListener('drawn', ({ detail }) => this.#drawn(detail));
    }

    /** @param {{at: number[]}|{world: number[]}|null} place  of the main picture, or in the world */
    hover(place) {
        this.#place = place && !place.at?.some((x) => x < 0 || x > 1) ? place : null;
        this.#due = Boolean(this.#place);
        if (!this.#place) this.#forget();
        else if (!this.#busy) this.#ask();
    }

    #forget() {
        this.#era++;
        set({ cursor: null });
    }

    #again() {
        this.#era++;
        this.hover(this.#place);
    }

    /** Under a pointer that rests the picture may move (keys, the wheel, another page): what was there is gone, what comes is asked for. */
    #drawn({ camera, quality }) {
        const now = JSON.stringify(camera);
        if (!this.#place?.at) this.#camera = now;
        if (now === this.#camera) return;
        this.#forget();
        this.#camera = quality === 'moving' ? '' : now; /* '': also where it comes back to where it was */
        if (quality === 'moving') return;
        this.#again();
    }

    async #ask() {
        this.#busy = true;
        while (this.#due && this.app.connection.open) {
            const era = this.#era;
            this.#due = false;
            const found = await this.find(this.#place).catch(() => null);
            if (era === this.#era) set({ cursor: found?.hit ? found : null });
            await new Promise((done) => setTimeout(done, PAUSE_MS));
        }
        this.#busy = false;
    }

    /** What is seen at a place of the picture, or is at a place of the world. */
    find(place) {
        return this.app.connection.ask({ do: 'probe', ...place, ...(place.at ? { opacity: this.opacity } : {}) }, 'probe');
    }
}

class Layer {
    group = svg('g', { class: 'measures' });

    update(view, toPixels) {
        const { list, first } = get('measures');
        const marks = [];
        for (const { from, to } of list) {
            const a = toPixels(from.world),
                b = toPixels(to.world);
            if (!a || !b) continue;
            const text = svg('text', { x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2 - 8, 'text-anchor': 'middle' }, distance(from, to));
            marks.push(
                svg('line', { x1: a[0], y1: a[1], x2: b[0], y2: b[1] }),
                ...[a, b].map((p) => svg('circle', { cx: p[0], cy: p[1], r: 4 })),
                text,
            );
        }
        const at = first && toPixels(first.world);
        if (at) marks.push(svg('circle', { cx: at[0], cy: at[1], r: 5 }));
        this.group.replaceChildren(...marks);
    }
}

export const distance = (from, to) => `${short(length(sub(to.world, from.world)))} ${worldUnit()}`.trim();

/** A click with the tool: the first place, then the second. `spoken`: told in words, for a hand on the keys. */
export async function measureClick(app, place, spoken = false) {
    const found = place.world ? { hit: true, ...place } : await app.guard(app.probe.find(place));
    if (!found) return;
    if (!found.hit) {
        app.messages.tell('Nothing is seen there. Click on the object.');
        return;
    }
    const { list, first } = get('measures');
    set({ measures: first ? { list: [...list, { from: first, to: found }], first: null } : { list, first: found } });
    if (spoken) app.messages.tell(first ? `Distance ${distance(first, found)}` : 'The first place is marked. Space marks the second.');
}

export function measurePanel(app) {
    set({ measures: { list: [], first: null } });
    app.overlay.addLayer(new Layer());
    const list = h('div', { class: 'stack' }),
        hint = h('p', { class: 'hint', role: 'status' });
    const tool = button('Measure a distance', () => set({ tool: get('tool') === 'measure' ? 'turn' : 'measure' }), {
        kind: 'small choice',
        icon: 'measure',
        title: 'Click two places in the picture (M)',
    });
    const found = h('dl', { class: 'facts' });
    watch(['measures', 'volume'], () => {
        const { list: all } = get('measures');
        list.replaceChildren(
            ...all.map((measure, i) =>
                h(
                    'div',
                    { class: 'card row' },
                    h('span', { class: 'grow' }, `${i + 1}: ${distance(measure.from, measure.to)}`),
                    button('', () => set({ measures: { list: all.filter((m) => m !== measure), first: null } }), {
                        icon: 'trash',
                        kind: 'plain',
                        title: 'Remove this distance',
                    }),
                ),
            ),
        );
        app.overlay.update();
    });
    watch(['tool', 'measures'], () => {
        const on = get('tool') === 'measure';
        tool.setAttribute('aria-pressed', String(on));
        app.picture.classList.toggle('measuring', on);
        hint.textContent = !on ? '' : get('measures').first ? 'Click the second place.' : 'Click the first place.';
    });
    watch(['volume'], () => set({ measures: { list: [], first: null } }));
    watch(['cursor'], () => {
        const cursor = get('cursor');
        const facts = cursor
            ? [
                  ['Value', cursor.value === null ? 'no value' : short(cursor.value, 6)],
                  ['Voxel', voxelOf(cursor)],
                  ['World', `${cursor.world.map((x) => short(x)).join(', ')} ${worldUnit()}`],
              ]
            : [
                  ['Value', '–'],
                  ['Voxel', '–'],
                  ['World', '–'],
              ];
        found.replaceChildren(...facts.flatMap(([name, text]) => [h('dt', {}, name), h('dd', {}, text)]));
    });
    set({ cursor: null });
    const opacity = numberInput({ minimum: 0, maximum: 1, label: 'Opacity at which the probe stops' }, (x) => (app.probe.opacity = x));
    opacity.update(app.probe.opacity);
    return h(
        'div',
        { class: 'stack' },
        h('h3', {}, 'Under the pointer'),
        found,
        field('Stops at opacity', opacity, { help: 'The probe goes along the ray until this much opacity is passed' }),
        h('h3', {}, 'Distances'),
        tool,
        hint,
        list,
    );
}
