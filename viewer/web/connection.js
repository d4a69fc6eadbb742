/* SPDX-License-Identifier: MIT */
/* The WebSocket: commands out, events and frames in, and again after it was lost.
 *
 * Moves of the camera and edits under a moving hand are not sent as they come but merged, and go out with the next animation frame: one
 * rotation, one pan, one `set` at most, however fast the mouse reports. */

const RETRY_MS = [300, 700, 1500, 3000, 5000];
/* What the server takes in one message. */
const MOST_BYTES = 2 ** 20,
    TOO_LONG = 'this is more than the server takes in one message (1 MiB)';

/** `whole` with the keys of `part`; objects in it are merged one level deep. */
export function mergeParts(whole, part) {
    const out = { ...whole };
    for (const [key, value] of Object.entries(part)) {
        const both = [out[key], value].every((v) => v && typeof v === 'object' && !Array.isArray(v));
        out[key] = both ? { ...out[key], ...value } : value;
    }
    return out;
}

export class Connection extends EventTarget {
    #socket = null;
    #nextId = 1;
    #nextGesture = 1;
    #waiting = new Map();
    #moves = new Map();
    #edit = null;
    #scheduled = false;
    #tries = 0;
    #timer = 0;
    #held = 0;
    #inputs = new Map();
    #inputTime = 0;
    #early = [];

    /** @param {() => object} greeting  the `hello` command, asked for at each connection */
    constructor(greeting) {
        super();
        this.greeting = greeting;
    }

    /** Also while an attempt is under way, which may hang: the new one takes its place. */
    connect() {
        if (this.open) return;
        clearTimeout(this.#timer);
        this.#forget();
        this.#tell('link', { state: 'connecting', tries: this.#tries });
        const address = new URL('socket', location.href);
        address.protocol = address.protocol === 'https:' ? 'wss:' : 'ws:';
        const socket = new WebSocket(address, 'pellucid-1');
        socket.binaryType = 'arraybuffer';
        socket.onopen = () => {
            this.#tries = 0;
            this.#held = 0;
            this.send(this.greeting()); /* before whatever else is asked for now */
            this.#tell('link', { state: 'open' });
        };
        socket.onmessage = (message) => this.#receive(message.data);
        socket.onclose = () => this.#lost(socket);
        this.#socket = socket;
    }

    /** Nothing more is heard of the socket that there was. */
    #forget() {
        if (!this.#socket) return;
        Object.assign(this.#socket, { onopen: null, onmessage: null, onclose: null });
        this.#socket.close();
    }

    get open() {
        return this.#socket?.readyState === WebSocket.OPEN;
    }

    /** Whoever listens is there now: what came before is told, and from now on all at once. */
    listen() {
        const early = this.#early;
        this.#early = null;
        for (const [type, detail] of early ?? []) this.#tell(type, detail);
    }

    #tell(type, detail) {
        if (this.#early) this.#early.push([type, detail]);
        else this.dispatchEvent(new CustomEvent(type, { detail }));
    }

    async #lost(socket) {
        for (const { reject } of this.#waiting.values()) reject(new Error('The connection was lost.'));
        this.#waiting.clear();
        this.#moves.clear();
        this.#inputs.clear();
        this.#edit = null;
        const wait = RETRY_MS[Math.min(this.#tries++, RETRY_MS.length - 1)];
        this.#tell('link', { state: 'lost', wait, tries: this.#tries });
        this.#timer = setTimeout(() => this.connect(), wait);
        /* A WebSocket does not tell why it was refused; a plain request does. */
        const answer = await fetch('./', { cache: 'no-store' }).catch(() => null);
        if (answer?.status === 403 && socket === this.#socket) this.#tell('link', { state: 'refused', wait });
    }

    #receive(data) {
        if (typeof data !== 'string') {
            const count = new DataView(data).getUint32(0, true);
            const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, count)));
            this.#tell('frame', { header, picture: new Uint8Array(data, 4 + count) });
            return;
        }
        this.#event(JSON.parse(data));
    }

    #event(event) {
        const asked = this.#waiting.get(event.id);
        if (asked && (event.event === asked.answer || event.event === 'error')) {
            this.#waiting.delete(event.id);
            if (event.event === 'error') asked.reject(Object.assign(new Error(event.message), { code: event.code }));
            else asked.resolve(event);
            return;
        }
        this.#tell('event', event);
    }

    /** Sends a command now; its id, or 0 where there is no connection. What waits to be merged goes first, so that order is kept. */
    send(command) {
        this.#flush();
        return this.#send(command);
    }

    #send(command) {
        if (!this.open) return 0;
        const id = this.#nextId++,
            text = JSON.stringify({ ...command, id });
        /* A longer one would end the connection without a word. */
        if (text.length * 3 > MOST_BYTES && new TextEncoder().encode(text).length > MOST_BYTES)
            queueMicrotask(() => this.#event({ event: 'error', id, do: command.do, message: TOO_LONG }));
        else this.#socket.send(text);
        return id;
    }

    /** A command with an answer: a promise of the event of that name; an `error` rejects it. */
    ask(command, answer) {
        return new Promise((resolve, reject) => {
            const id = this.send(command);
            if (id) this.#waiting.set(id, { answer, resolve, reject });
            else reject(new Error('There is no connection to the server.'));
        });
    }

    /** The frame was drawn: the server may send the next. */
    shown(frame) {
        if (this.open) this.#socket.send(JSON.stringify({ do: 'shown', frame }));
    }

    /** Ages in ms of the inputs that a frame is the first to show: those up to the command `id`. */
    latencies(id) {
        const now = performance.now(),
            shown = [...this.#inputs].filter(([key]) => key <= id);
        for (const [key] of shown) this.#inputs.delete(key);
        return shown.map(([, time]) => now - time);
    }

    newGesture() {
        return this.#nextGesture++;
    }

    /** The hand is down / up. Several hands (two inputs at once) hold once. */
    hold() {
        if (this.#held++ === 0) this.send({ do: 'hold' });
    }

    release() {
        if (this.#held > 0 && --this.#held === 0) this.send({ do: 'release' });
    }

    /** A move of the camera, merged with those of its kind until the next animation frame; `time`: of its input event. */
    move(kind, by, gesture, { at, time } = {}) {
        const before = this.#moves.get(kind);
        const sum = !before
            ? by
            : Array.isArray(by)
              ? [before.by[0] + by[0], before.by[1] + by[1]]
              : kind === 'zoom'
                ? before.by * by
                : before.by + by;
        this.#moves.set(kind, { do: kind, by: sum, gesture, ...(at ? { at } : {}) });
        this.#schedule(time);
    }

    /** A part of the scene, merged by its keys until the next animation frame. */
    edit(scene, gesture) {
        if (this.#edit && this.#edit.gesture !== gesture) this.#flush();
        this.#edit = { do: 'set', scene: mergeParts(this.#edit?.scene, scene), gesture };
        this.#schedule();
    }

    #schedule(time = performance.now()) {
        this.#inputTime ||= time;
        if (!this.#scheduled) {
            this.#scheduled = true;
            requestAnimationFrame(() => this.#flush());
        }
    }

    #flush() {
        this.#scheduled = false;
        const commands = [...this.#moves.values(), ...(this.#edit ? [this.#edit] : [])];
        this.#moves.clear();
        this.#edit = null;
        for (const command of commands) {
            const id = this.#send(command);
            if (id) this.#inputs.set(id, this.#inputTime);
        }
        this.#inputTime = 0;
    }
}
