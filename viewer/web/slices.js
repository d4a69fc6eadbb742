/* SPDX-License-Identifier: MIT */
/* Three slices square to the volume's own axes, with a linked cross-hair: click or drag moves it, the wheel steps through, a right
 * drag sets window and level. What lies where is told by the camera of each slice's frame. */

import { attributes, button, clamp, field, h, short, svg } from './dom.js';
import { checkbox, numberInput, slider } from './controls.js';
import { add, axisStep, directionName, flat, invert, scale, transform, View } from './geometry.js';
import { get, set, watch } from './store.js';

const COLORS = ['#ff6b6b', '#6bd968', '#6fa8ff'];
const VIEWS = ['slice-i', 'slice-j', 'slice-k'];

/** A window that shows tissue: from the least value to where 99.5 % of what is not the background (the fullest bin) lie below. */
function usualWindow({ range, histogram }) {
    const { lo, hi, counts } = histogram ?? { counts: [] };
    const ground = counts.indexOf(Math.max(...counts));
    const rest = counts.map((n, i) => (i === ground ? 0 : n)),
        all = rest.reduce((sum, n) => sum + n, 0);
    if (!(all > 0)) return [...range];
    let sum = 0;
    const top = rest.findIndex((n) => (sum += n) >= 0.995 * all);
    const high = lo + ((top + 1) * (hi - lo)) / counts.length;
    return high > range[0] ? [range[0], Math.min(high, range[1])] : [...range];
}

/** One of the three pictures. */
class Slice {
    #drag = null;
    #lines = [0, 1].map(() => svg('line', { class: 'cross' }));
    #letters = ['left', 'right', 'top', 'bottom'].map((side) => h('span', { class: `side ${side}` }));
    #label = h('span', { class: 'slice-label' });

    constructor(slices, axis) {
        this.slices = slices;
        this.axis = axis;
        this.picture = document.createElement('pel-picture');
        Object.assign(this.picture, { className: 'slice', tabIndex: 0 });
        this.picture.setAttribute('aria-label', `Slice across ${'ijk'[axis]}. Page up and down step, arrows move the cross-hair`);
        this.svg = svg('svg', { class: 'overlay', 'aria-hidden': 'true' }, this.#lines);
        const others = [0, 1, 2].filter((i) => i !== axis);
        this.#lines.forEach((line, i) => attributes(line, { stroke: COLORS[others[i]] }));
        this.picture.append(this.svg, ...this.#letters, this.#label);
        this.picture.style.setProperty('--frame', COLORS[axis]);
        this.picture.addEventListener('drawn', () => this.update());
        this.picture.addEventListener('resized', () => this.update());
        this.picture.addEventListener('pointerdown', (event) => this.#press(event));
        this.picture.addEventListener('pointermove', (event) => this.#move(event));
        for (const end of ['pointerup', 'pointercancel']) this.picture.addEventListener(end, () => this.#lift());
        this.picture.addEventListener('contextmenu', (event) => event.preventDefault());
        this.picture.addEventListener(
            'wheel',
            (event) => {
                event.preventDefault();
                slices.step(axis, event.deltaY > 0 ? -1 : 1);
            },
            { passive: false },
        );
        this.picture.addEventListener('keydown', (event) => this.#key(event));
    }

    get view() {
        const header = this.picture.header;
        return header?.camera ? new View(header.camera, header.of[0] / header.of[1]) : null;
    }

    #press(event) {
        this.picture.setPointerCapture(event.pointerId);
        this.picture.focus({ preventScroll: true });
        this.#drag = { from: [event.clientX, event.clientY], window: this.slices.window, level: event.button === 2 };
        if (!this.#drag.level) this.#goTo(event);
        event.preventDefault();
    }

    #move(event) {
        if (!this.#drag) return;
        if (!this.#drag.level) return this.#goTo(event);
        /* Right drag: to the right widens the window, upwards brightens, as in radiology. */
        const [lo, hi] = this.#drag.window,
            [a, b] = get('volume').range;
        const width = Math.max(hi - lo + ((event.clientX - this.#drag.from[0]) / 300) * (b - a), (b - a) * 1e-3);
        const level = (lo + hi) / 2 + ((event.clientY - this.#drag.from[1]) / 300) * (b - a);
        this.slices.setWindow([level - width / 2, level + width / 2]);
    }

    #lift() {
        this.#drag = null;
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
        const others = [0, 1, 2].filter((i) => i !== this.axis),
            far = event.shiftKey ? 10 : 1;
        const steps = {
            PageUp: [this.axis, 1],
            PageDown: [this.axis, -1],
            ArrowLeft: [others[0], -1],
            ArrowRight: [others[0], 1],
            ArrowDown: [others[1], -1],
            ArrowUp: [others[1], 1],
        };
        if (!(event.key in steps)) return;
        this.slices.step(steps[event.key][0], steps[event.key][1] * far);
        event.preventDefault();
        event.stopPropagation();
    }

    /** Cross-hair, letters at the sides, the number of the slice. */
    update() {
        const view = this.view,
            { at, matrix, inverse } = this.slices,
            volume = get('volume');
        if (!view || !at || !matrix) return;
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
        const sides = [scale(view.right, -1), view.right, view.up, scale(view.up, -1)];
        this.#letters.forEach((letter, i) => (letter.textContent = directionName(volume.space, sides[i])));
        const index = Math.round(transform(inverse, at)[this.axis]);
        this.#label.textContent = `${'ijk'[this.axis]} ${index} / ${volume.dims[this.axis] - 1}`;
    }
}

export class Slices {
    #scheduled = false;

    constructor(app, stage) {
        this.app = app;
        this.slices = [0, 1, 2].map((axis) => new Slice(this, axis));
        this.pictures = Object.fromEntries(this.slices.map((slice, i) => [VIEWS[i], slice.picture]));
        stage.append(...this.slices.map(({ picture }) => picture));
        this.at = null;
        this.window = null;
        this.grey = true;
        watch(['volume'], () => this.#volume());
        watch(['layout'], () => this.#layout(stage));
        watch(['link'], () => get('link').state === 'open' && this.on && setTimeout(() => this.#send(), 0));
        for (const { picture } of this.slices) picture.addEventListener('resized', () => this.on && this.#schedule());
    }

    get on() {
        return get('layout') === 'four';
    }

    #volume() {
        const volume = get('volume');
        this.matrix = flat(volume.index_to_world);
        this.inverse = invert(this.matrix);
        this.window = usualWindow(volume);
        this.at = transform(
            this.matrix,
            volume.dims.map((n) => Math.floor(n / 2)),
        );
        this.#told();
        if (this.on) this.#schedule();
    }

    #layout(stage) {
        stage.dataset.layout = get('layout');
        if (this.on) this.#schedule();
        else if (get('volume')) this.app.connection.send({ do: 'slices', at: null });
    }

    #schedule() {
        if (!this.#scheduled) {
            this.#scheduled = true;
            requestAnimationFrame(() => this.#send());
        }
    }

    #send() {
        this.#scheduled = false;
        if (!this.on || !this.at) return;
        const size = this.slices[0].picture.wanted();
        this.app.connection.send({ do: 'slices', at: this.at, size, ...(this.grey ? { window: this.window } : {}) });
    }

    #told() {
        for (const slice of this.slices) slice.update();
        this.onchange?.();
    }

    /** The cross-hair at an index (fractions allowed), kept inside the volume. */
    goTo(index) {
        const { dims } = get('volume');
        this.at = transform(
            this.matrix,
            index.map((x, i) => clamp(x, 0, dims[i] - 1)),
        );
        this.#told();
        this.#schedule();
    }

    step(axis, by) {
        const index = transform(this.inverse, this.at);
        index[axis] = Math.round(index[axis] + by);
        this.goTo(index);
    }

    setWindow(range) {
        this.window = range;
        this.#told();
        this.#schedule();
    }

    setGrey(grey) {
        this.grey = grey;
        this.#told();
        this.#schedule();
    }
}

export function slicesPanel(app) {
    const { slices } = app;
    const on = checkbox((wish) => set({ layout: wish ? 'four' : 'one' }), 'Show three slices');
    const grey = checkbox((wish) => slices.setGrey(wish), 'Grey values');
    const window = numberInput({ label: 'Window', minimum: 0 }, (w) => slices.setWindow([level() - w / 2, level() + w / 2]));
    const levels = numberInput({ label: 'Level' }, (l) => slices.setWindow([l - width() / 2, l + width() / 2]));
    const level = () => (slices.window[0] + slices.window[1]) / 2,
        width = () => slices.window[1] - slices.window[0];
    const rows = h('div', { class: 'stack' });
    watch(['volume'], () =>
        rows.replaceChildren(
            ...get('volume').dims.map((n, axis) => {
                const control = slider({ minimum: 0, maximum: Math.max(n - 1, 1), label: `Slice ${'ijk'[axis]}`, whole: true }, (x) => {
                    const index = transform(slices.inverse, slices.at);
                    index[axis] = x;
                    slices.goTo(index);
                });
                const row = field('ijk'[axis], control);
                row.update = control.update;
                return row;
            }),
        ),
    );
    const place = h('p', { class: 'hint' });
    slices.onchange = () => {
        on.update(slices.on);
        grey.update(slices.grey);
        window.update(width());
        levels.update(level());
        const index = transform(slices.inverse, slices.at);
        [...rows.children].forEach((row, axis) => row.update(Math.round(index[axis])));
        place.textContent = `Cross-hair at ${slices.at.map((x) => short(x)).join(', ')} in the world.`;
    };
    watch(['layout', 'volume'], () => get('volume') && slices.onchange());
    return h(
        'div',
        { class: 'stack' },
        field('Three slices', on),
        rows,
        place,
        field('Grey values', grey, { help: 'Grey between the ends of the window; off: the transfer function’s colours' }),
        h('div', { class: 'row' }, field('Window', window), field('Level', levels)),
        button('Whole range', () => slices.setWindow([...get('volume').range]), { kind: 'small' }),
        h('p', { class: 'hint' }, 'Drag moves the cross-hair, the wheel steps, a right drag sets window (sideways) and level (upwards).'),
    );
}
