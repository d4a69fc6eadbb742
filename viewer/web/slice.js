/* SPDX-License-Identifier: MIT */
/* One of the three slices, with the cross-hair over it. Left drag or finger moves the cross-hair, the wheel steps through, a right drag
 * sets window and level; middle or shift-left drag pans, ctrl and wheel or two fingers zoom; a double click makes it large. What lies where
 * is told by the frame's camera. */

import { attributes, clamp, h, svg } from './dom.js';
import { browsers } from './keys.js';
import { add, axisStep, directionName, dot, planeName, scale, sub, transform, unit, View } from './geometry.js';
import { get, set } from './store.js';
import { distance } from './measure.js';
import { updateScaleBar } from './overlay.js';

const NEAREST = 64; /* times the whole slice */
const CLICK_PIXELS = 4;
const KEYS = 'Page up and down step, arrows move the cross-hair, Space marks it, plus and minus zoom';
const NOTCH_PIXELS = 60; /* of a wheel, at least; a trackpad's small steps are added up to it */

export class Slice {
    #drag = null;
    #turned = 0;
    #touches = new Map();
    #lines = [0, 1].map(() => svg('line', { class: 'cross' }));
    #measures = svg('g', { class: 'measures' });
    #letters = ['left', 'right', 'top', 'bottom'].map((side) => h('span', { class: `side ${side}` }));
    #label = h('span', { class: 'slice-label' });
    #bar = h('div', { class: 'scale-bar', 'aria-hidden': 'true' });

    /** What is seen: {center, scale} as the protocol's `views` has it, or null for the whole slice. */
    seen = null;

    /** @param {Slices} slices  the three of them: cross-hair, window, what is sent */
    constructor(slices, axis) {
        this.slices = slices;
        this.axis = axis;
        this.picture = document.createElement('pel-picture');
        Object.assign(this.picture, { className: 'slice', tabIndex: 0 });
        this.picture.setAttribute('aria-label', `Slice across ${'ijk'[axis]}. ${KEYS}`);
        this.picture.setAttribute('role', 'application');
        this.svg = svg('svg', { class: 'overlay', 'aria-hidden': 'true' }, this.#lines, this.#measures);
        const others = [0, 1, 2].filter((i) => i !== axis);
        this.#lines.forEach((line, i) => line.classList.add(`axis-${others[i]}`));
        this.picture.append(this.svg, ...this.#letters, this.#label, this.#bar);
        this.picture.classList.add(`axis-${axis}`);
        this.#listen();
    }

    #listen() {
        const { picture, slices } = this;
        const on = (kinds, listener, options) => kinds.split(' ').forEach((kind) => picture.addEventListener(kind, listener, options));
        on('drawn', ({ detail }) => slices.at && slices.shown(this.axis, detail.id, this.view.focus));
        on('drawn resized', () => this.update());
        on('pointerdown', (event) => this.#press(event));
        on('pointermove', (event) => this.#move(event));
        on('pointerup pointercancel', (event) => this.#lift(event));
        on('pointerleave', (event) => event.pointerType !== 'touch' && slices.app.probe.hover(null));
        on('contextmenu', (event) => event.preventDefault());
        on('dblclick', () => slices.enlarge(this.axis));
        on('wheel', (event) => this.#wheel(event), { passive: false });
        on('keydown', (event) => this.#key(event));
    }

    /** The camera of the frame that is seen. */
    get view() {
        const header = this.picture.header;
        return header?.camera ? new View(header.camera, header.of[0] / header.of[1]) : null;
    }

    /** The camera that was asked for last; the frame that shows it may be on its way. */
    get #asked() {
        const view = this.view;
        if (view && this.seen) Object.assign(view, { focus: this.seen.center, scale: this.seen.scale });
        return view;
    }

    /** Half the height of the whole slice in the picture. */
    get #whole() {
        return this.fit ?? this.view.scale;
    }

    see(center, half) {
        const whole = this.#whole;
        this.seen = half < whole * 0.999 ? { center, scale: Math.max(half, whole / NEAREST) } : null;
        this.slices.changed();
    }

    /** Nearer by a factor; the place `at` of the picture stays where it is. */
    zoom(factor, at = [0.5, 0.5]) {
        const view = this.#asked;
        if (!view) return;
        const by = view.scale / clamp(view.scale / factor, this.#whole / NEAREST, this.#whole),
            fixed = view.unproject(...at);
        this.see(add(fixed, scale(sub(view.focus, fixed), 1 / by)), view.scale / by);
    }

    pan(by) {
        const view = this.#asked;
        if (view) this.see(add(view.focus, sub(view.unproject(0, 0), view.unproject(...by))), view.scale);
    }

    #press(event) {
        const { picture, slices } = this;
        if (!slices.at) return;
        picture.setPointerCapture(event.pointerId);
        picture.focus({ preventScroll: true });
        event.preventDefault();
        if (event.pointerType === 'touch') this.#touches.set(event.pointerId, picture.at(event));
        const kind =
            this.#touches.size > 1
                ? 'pinch'
                : event.button === 2
                  ? 'window'
                  : event.button === 1 || event.shiftKey
                    ? 'pan'
                    : get('tool') === 'measure'
                      ? 'measure'
                      : 'cross';
        if (!this.#drag) slices.app.connection.hold();
        /* The first finger of two did not mean the cross-hair. */
        if (kind === 'pinch' && this.#drag?.kind === 'cross') slices.goTo(this.#drag.index);
        const index = transform(slices.inverse, slices.at);
        this.#drag = { kind, index, from: [event.clientX, event.clientY], last: picture.at(event), window: slices.window, travel: 0 };
        if (kind === 'cross') this.#goTo(event);
    }

    #move(event) {
        const drag = this.#drag,
            at = this.picture.at(event);
        if (!drag) {
            if (event.pointerType !== 'touch') this.#hover(at);
            return;
        }
        drag.travel = Math.max(drag.travel, Math.hypot(event.clientX - drag.from[0], event.clientY - drag.from[1]));
        if (drag.kind === 'pinch') this.#pinch(event, at);
        else if (drag.kind === 'pan') this.pan(sub(at, drag.last));
        else if (drag.kind === 'window') this.#level(event);
        else if (drag.kind === 'cross') this.#goTo(event);
        drag.last = at;
    }

    #lift(event) {
        this.#touches.delete(event.pointerId);
        const drag = this.#drag;
        this.letGo();
        if (drag?.kind === 'measure' && drag.travel < CLICK_PIXELS && event.type === 'pointerup')
            this.slices.app.measureClick({ world: this.view.unproject(...drag.last) });
    }

    /** However a drag ends: what was put off until then is drawn at full quality. */
    letGo() {
        if (this.#drag) this.slices.app.connection.release();
        this.#drag = null;
    }

    #hover(at) {
        const inside = this.view && at.every((x) => x >= 0 && x <= 1);
        this.slices.app.probe.hover(inside ? { world: this.view.unproject(...at) } : null);
    }

    /** To the right widens the window, upwards brightens, as in radiology. */
    #level(event) {
        const [lo, hi] = this.#drag.window,
            [a, b] = get('volume').range;
        const width = Math.max(hi - lo + ((event.clientX - this.#drag.from[0]) / 300) * (b - a), (b - a) * 1e-3);
        const level = (lo + hi) / 2 + ((event.clientY - this.#drag.from[1]) / 300) * (b - a);
        this.slices.setWindow([level - width / 2, level + width / 2]);
    }

    #pinch(event, at) {
        const before = [...this.#touches.values()];
        this.#touches.set(event.pointerId, at);
        const now = [...this.#touches.values()];
        if (now.length < 2) return;
        const middle = ([a, b]) => scale(add(a, b), 0.5),
            aspect = this.picture.area.width / this.picture.area.height;
        const apart = ([a, b]) => Math.hypot((b[0] - a[0]) * aspect, b[1] - a[1]);
        this.pan(sub(middle(now), middle(before)));
        if (apart(before) > 0 && apart(now) > 0) this.zoom(apart(now) / apart(before), middle(now));
    }

    #wheel(event) {
        event.preventDefault();
        if (!event.ctrlKey && !event.metaKey) {
            this.#turn(event);
            return;
        }
        /* A trackpad's pinch comes as a wheel with ctrl and small steps. */
        const steps = (event.deltaY * [1, 33, 400][event.deltaMode]) / 100;
        this.slices.burst.touch();
        this.zoom(1.2 ** -clamp(Math.abs(event.deltaY) < 20 ? steps * 8 : steps, -4, 4), this.picture.at(event));
    }

    /** Steps with the wheel. With Shift some browsers tell a turn sideways. */
    #turn({ deltaX, deltaY, deltaMode, shiftKey }) {
        const by = (deltaY || deltaX) * [1, 33, 400][deltaMode];
        this.#turned = Math.abs(by) >= NOTCH_PIXELS ? by : this.#turned + by;
        if (Math.abs(this.#turned) < NOTCH_PIXELS) return;
        this.slices.burst.touch();
        this.slices.step(this.axis, -Math.sign(this.#turned) * (shiftKey ? 10 : 1));
        this.#turned = 0;
    }

    /** The cross-hair goes to the pointer, within this slice. */
    #goTo(event) {
        const view = this.view;
        if (!view) return;
        const { inverse, at } = this.slices;
        const index = transform(inverse, view.unproject(...this.picture.at(event)));
        index[this.axis] = transform(inverse, at)[this.axis];
        this.slices.goTo(index);
    }

    #key(event) {
        if (browsers(event)) return;
        const others = [0, 1, 2].filter((i) => i !== this.axis),
            far = event.shiftKey ? 10 : 1;
        const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
        const steps = { PageUp: [this.axis, 1], PageDown: [this.axis, -1] };
        const way = arrows[event.key];
        if (way || event.key in steps || '+=-'.includes(event.key)) this.slices.burst.touch();
        if (way && event.ctrlKey) this.pan(scale(way, -0.05));
        else if (way) this.#nudge(way, others, far);
        else if (event.key in steps) this.slices.step(steps[event.key][0], steps[event.key][1] * far);
        else if ('+='.includes(event.key)) this.zoom(1.25);
        else if (event.key === '-') this.zoom(0.8);
        else if (event.key === '0') this.slices.whole();
        else if (event.key === 'Enter') this.slices.enlarge(this.axis);
        else if (event.key === ' ') this.slices.app.measureClick({ world: this.slices.at }, true);
        else return;
        event.preventDefault();
        event.stopPropagation();
    }

    /** The cross-hair one voxel towards where the arrow points on the screen. */
    #nudge([x, y], others, far) {
        const view = this.view;
        if (!view) return;
        const towards = x !== 0 ? scale(view.right, x) : scale(view.up, -y);
        const along = others.map((i) => dot(unit(axisStep(this.slices.matrix, i)), towards));
        const best = Math.abs(along[0]) >= Math.abs(along[1]) ? 0 : 1;
        this.slices.step(others[best], Math.sign(along[best]) * far);
    }

    /** Cross-hair, distances, letters at the sides, the number of the slice, the scale. */
    update() {
        const view = this.view,
            { at, matrix, inverse } = this.slices,
            volume = get('volume');
        if (!view || !at || !matrix || !this.picture.clientWidth) return;
        if (!this.seen) this.fit = view.scale;
        const area = this.picture.area,
            pixels = (p) => {
                const [x, y] = view.project(p);
                return [area.x + x * area.width, area.y + y * area.height];
            };
        attributes(this.svg, { width: this.picture.clientWidth, height: this.picture.clientHeight });
        const others = [0, 1, 2].filter((i) => i !== this.axis),
            reach = 4 * Math.max(...volume.dims);
        this.#lines.forEach((line, i) => {
            /* the line of others[i]'s slice runs along the other axis */
            const along = scale(axisStep(matrix, others[1 - i]), reach);
            const [a, b] = [pixels(add(at, along)), pixels(add(at, scale(along, -1)))];
            attributes(line, { x1: a[0], y1: a[1], x2: b[0], y2: b[1] });
        });
        this.#distances(inverse, pixels);
        const sides = [scale(view.right, -1), view.right, view.up, scale(view.up, -1)];
        this.#letters.forEach((letter, i) => (letter.textContent = directionName(volume.space, sides[i])));
        /* The number of the slice that is seen; the one asked for may be on its way. */
        const index = Math.round(transform(inverse, view.focus)[this.axis]);
        this.#name(planeName(volume.space, axisStep(matrix, this.axis)), index, volume.dims[this.axis] - 1, view);
        updateScaleBar(this.#bar, view, this.picture);
    }

    /** The words in the corner, as many as there is room for beside the letter in the middle, and those for a reader of the screen. */
    #name(plane, index, last, view) {
        const { clientWidth } = this.picture,
            axis = 'ijk'[this.axis];
        const total = !plane || clientWidth > 290 ? ` / ${last}` : '',
            nearer = this.seen && clientWidth > (plane ? 340 : 240) ? `, × ${(this.#whole / view.scale).toFixed(1)}` : '';
        this.#label.textContent = `${plane || axis} ${index}${total}${nearer}`;
        attributes(this.picture, { 'aria-label': `${plane ? `${plane} slice (${axis})` : `Slice across ${axis}`}. ${KEYS}` });
    }

    /** Those that lie in this slice. */
    #distances(inverse, pixels) {
        const { list = [], first } = get('measures') ?? {};
        const here = transform(inverse, this.slices.at)[this.axis];
        const within = ({ world }) => Math.abs(transform(inverse, world)[this.axis] - here) < 0.75;
        const mark = (place) => svg('circle', { cx: pixels(place.world)[0], cy: pixels(place.world)[1], r: 4 });
        const marks = list
            .filter(({ from, to }) => within(from) && within(to))
            .flatMap(({ from, to }) => {
                const [a, b] = [pixels(from.world), pixels(to.world)];
                const text = { x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2 - 8, 'text-anchor': 'middle' };
                return [
                    svg('line', { x1: a[0], y1: a[1], x2: b[0], y2: b[1] }),
                    mark(from),
                    mark(to),
                    svg('text', text, distance(from, to)),
                ];
            });
        if (first && within(first)) marks.push(mark(first));
        this.#measures.replaceChildren(...marks);
    }
}
