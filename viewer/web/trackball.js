/* SPDX-License-Identifier: MIT */
/* VTK's trackball on a picture: left turns, middle or shift-left pans, right or wheel zooms, ctrl-left rolls. Two fingers pan, pinch
 * and roll. The camera itself turns in the session; here only fractions of the picture are told. */

const CLICK_PIXELS = 4;
const REST_MS = 220;
const TWICE_MS = 800;

/** Inputs without an end (wheel, repeated keys): the hand is down from the first on, and up once none came for a while. */
export class Burst {
    #timer = 0;
    #gesture = 0;

    constructor(connection) {
        this.connection = connection;
    }

    /** The gesture that an input now belongs to. */
    touch() {
        if (!this.#timer) {
            this.#gesture = this.connection.newGesture();
            this.connection.hold();
        }
        clearTimeout(this.#timer);
        this.#timer = setTimeout(() => {
            this.#timer = 0;
            this.connection.release();
        }, REST_MS);
        return this.#gesture;
    }
}

/** What a mouse button with these keys does, in VTK's words. */
export function action(button, event) {
    if (button === 1) return 'pan';
    if (button === 2) return 'zoom';
    if (event.ctrlKey || event.metaKey) return event.shiftKey ? 'zoom' : 'roll';
    return event.shiftKey ? 'pan' : 'rotate';
}

const mean = (points) => [0, 1].map((i) => points.reduce((sum, p) => sum + p[i], 0) / points.length);
const apart = ([a, b], aspect) => [(b[0] - a[0]) * aspect, b[1] - a[1]];

export class Trackball {
    #pointers = new Map();
    #gesture = 0;
    #action = '';
    #travel = 0;
    #down = null;
    #handled = -Infinity; /* when a handle over the picture was pressed last */

    /**
     * @param {Picture} picture
     * @param {Connection} connection
     * @param {{click: function(number[], Event), twice: function(number[]), hover: function(number[]|null)}} told  a click that moved
     *     nothing; a double click; where the pointer is
     */
    constructor(picture, connection, told) {
        this.picture = picture;
        this.connection = connection;
        this.told = told;
        this.burst = new Burst(connection);
        picture.addEventListener('pointerdown', (event) => this.#press(event));
        picture.addEventListener('pointermove', (event) => this.#drag(event));
        picture.addEventListener('pointerup', (event) => this.#lift(event));
        picture.addEventListener('pointercancel', (event) => this.#lift(event));
        picture.addEventListener('pointerleave', (event) => event.pointerType !== 'touch' && this.told.hover(null));
        picture.addEventListener('contextmenu', (event) => event.preventDefault());
        picture.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
        picture.addEventListener('dblclick', (event) => {
            /* The first click may have turned the handle from under the second. */
            const handle = event.target.closest('[data-handle]') || event.timeStamp - this.#handled < TWICE_MS;
            if (event.button === 0 && !handle) this.told.twice(this.picture.at(event));
        });
    }

    #press(event) {
        if (event.target.closest('[data-handle]')) {
            this.#handled = event.timeStamp;
            return;
        }
        this.picture.focus({ preventScroll: true });
        this.picture.setPointerCapture(event.pointerId);
        this.told.hover(null);
        this.#pointers.set(event.pointerId, this.picture.at(event));
        if (this.#pointers.size === 1) {
            this.#gesture = this.connection.newGesture();
            this.#action = event.pointerType === 'touch' ? 'rotate' : action(event.button, event);
            this.#travel = 0;
            this.#down = [event.clientX, event.clientY];
            this.connection.hold();
        }
        event.preventDefault();
    }

    #drag(event) {
        if (!this.#pointers.has(event.pointerId)) {
            if (event.pointerType !== 'touch' && !event.buttons) this.told.hover(this.picture.at(event));
            return;
        }
        const before = [...this.#pointers.values()];
        const last = this.#pointers.get(event.pointerId),
            now = this.picture.at(event);
        this.#travel = Math.max(this.#travel, Math.hypot(event.clientX - this.#down[0], event.clientY - this.#down[1]));
        if (this.#travel < CLICK_PIXELS && this.#pointers.size === 1)
            return; /* may yet be a click; nothing of the way is lost, as `last` stays */
        this.#pointers.set(event.pointerId, now);
        if (this.#pointers.size >= 2) this.#pinch(before, [...this.#pointers.values()], event.timeStamp);
        else this.#mouse(last, now, event.timeStamp);
    }

    #mouse(last, now, time) {
        const by = [now[0] - last[0], now[1] - last[1]];
        const { connection } = this;
        if (this.#action === 'zoom')
            /* VTK: 1.1 to the tenth for half the height */
            connection.move('zoom', 1.1 ** (-20 * by[1]), this.#gesture, { time });
        else if (this.#action === 'roll') connection.move('roll', this.#angle(last, now), this.#gesture, { time });
        else connection.move(this.#action, by, this.#gesture, { time });
    }

    /** Degrees between two places, seen from the middle of the picture, counter-clockwise. */
    #angle(from, to) {
        const aspect = this.picture.area.width / this.picture.area.height;
        const of = (p) => Math.atan2(0.5 - p[1], (p[0] - 0.5) * aspect);
        const turn = ((of(to) - of(from)) * 180) / Math.PI;
        return turn - 360 * Math.round(turn / 360);
    }

    #pinch(before, now, time) {
        const [from, to] = [before.slice(0, 2), now.slice(0, 2)];
        const aspect = this.picture.area.width / this.picture.area.height;
        const a = mean(from),
            b = mean(to),
            u = apart(from, aspect),
            v = apart(to, aspect);
        const { connection } = this,
            gesture = this.#gesture;
        connection.move('pan', [b[0] - a[0], b[1] - a[1]], gesture, { time });
        const ratio = Math.hypot(...v) / (Math.hypot(...u) || 1);
        if (Number.isFinite(ratio) && ratio > 0)
            connection.move('zoom', ratio, gesture, { at: b.map((x) => Math.min(Math.max(x, 0), 1)), time });
        const turn = ((Math.atan2(-v[1], v[0]) - Math.atan2(-u[1], u[0])) * 180) / Math.PI;
        connection.move('roll', turn - 360 * Math.round(turn / 360), gesture);
    }

    #lift(event) {
        if (!this.#pointers.delete(event.pointerId) || this.#pointers.size > 0) return;
        this.connection.release();
        if (event.type === 'pointerup' && event.pointerType !== 'touch') this.told.hover(this.picture.at(event));
        if (event.type === 'pointerup' && this.#travel < CLICK_PIXELS && this.#action === 'rotate')
            this.told.click(this.picture.at(event), event);
    }

    #wheel(event) {
        event.preventDefault();
        /* Lines and pages of some mice in pixels; a trackpad's pinch comes as a wheel with ctrl and small steps. */
        const steps = (event.deltaY * [1, 33, 400][event.deltaMode] * (event.ctrlKey ? 8 : 1)) / 100;
        this.connection.move('zoom', 1.1 ** -Math.min(Math.max(steps, -5), 5), this.burst.touch(), { time: event.timeStamp });
    }

    /** A key's move of the camera: kind and amount as in the protocol. */
    nudge(kind, by) {
        this.connection.move(kind, by, this.burst.touch());
    }
}
