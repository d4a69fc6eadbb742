/* SPDX-License-Identifier: MIT */
/* Three slices square to the volume's own axes, with a linked cross-hair, and their panel. The hand on one of them is slice.js. */

import { button, clamp, field, h, short } from './dom.js';
import { checkbox, numberInput, slider } from './controls.js';
import { wanted } from './begin.js';
import { axisStep, invert, planeName, transform, unit } from './geometry.js';
import { get, set, watch } from './store.js';
import { planesSection } from './planes.js';
import { Slice } from './slice.js';
import { Burst } from './trackball.js';

const drawsPlanes = () => get('scene')?.render?.mode === 'slice';
const PLANES = { key: 'slice', panel: 'slices', name: 'Plane', least: 1, most: 8, flips: false, shown: drawsPlanes };
const VIEWS = ['slice-i', 'slice-j', 'slice-k'];
/* What the server draws of a slice. */
const MOST = { side: 4096, pixels: 2 ** 22 };

/** A window that shows tissue: from the least value to where 99.5 % of what is not the background (the fullest bin) lie below. */
function usualWindow(range, histogram) {
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

export class Slices {
    #scheduled = false;
    #asked = 0; /* id of the last command */
    #sliding = false;

    constructor(app, stage) {
        this.app = app;
        this.stage = stage;
        this.slices = [0, 1, 2].map((axis) => new Slice(this, axis));
        this.pictures = Object.fromEntries(this.slices.map((slice, i) => [VIEWS[i], slice.picture]));
        stage.append(...this.slices.map(({ picture }) => picture));
        this.burst = new Burst(app.connection); /* of the wheel and of keys */
        this.at = null;
        this.window = null;
        this.grey = true;
        watch(['volume'], () => this.#volume());
        watch(['histogram'], () => get('volume') && this.window === this.usual && this.setWindow(this.#usualWindow()));
        watch(['layout'], () => this.#layout());
        watch(['measures'], () => this.on && this.slices.forEach((slice) => slice.update()));
        watch(['link'], () => get('link').state === 'open' && this.on && this.#send());
        watch(['preferences'], () => this.on && this.changed());
        for (const { picture } of this.slices) picture.addEventListener('resized', () => this.on && this.changed());
    }

    get on() {
        return get('layout') === 'four';
    }

    #volume() {
        const volume = get('volume');
        this.matrix = volume.index_to_world;
        this.inverse = invert(this.matrix);
        this.window = this.#usualWindow();
        this.at = transform(
            this.matrix,
            volume.dims.map((n) => Math.floor(n / 2)),
        );
        this.#told();
        for (const slice of this.slices) slice.seen = null;
        if (this.on) this.changed();
    }

    /** Kept as long as no hand has set another. */
    #usualWindow() {
        return (this.usual = usualWindow(get('volume').range, get('histogram')));
    }

    #layout() {
        for (const slice of this.slices) slice.letGo(); /* what is hidden hears of no pointer */
        this.stage.dataset.layout = get('layout');
        delete this.stage.dataset.large;
        if (this.on) this.changed();
        else if (get('volume')) this.app.connection.send({ do: 'slices', at: null });
    }

    /** Something of what is asked for changed: asked for with the next animation frame. */
    changed() {
        if (!this.#scheduled) {
            this.#scheduled = true;
            requestAnimationFrame(() => this.#send());
        }
    }

    #send() {
        this.#scheduled = false;
        if (!this.on || !this.at) return;
        const { picture } = this.slices.find((slice) => slice.picture.clientWidth > 0) ?? this.slices[0];
        const views = this.slices.some(({ seen }) => seen) ? { views: this.slices.map(({ seen }) => seen) } : {};
        this.#asked = this.app.connection.send({
            do: 'slices',
            at: this.at,
            size: wanted(picture, MOST),
            ...(this.grey ? { window: this.window } : {}),
            ...views,
        });
    }

    /** A picture of a slice is seen. There is one cross-hair for all pages: where another page moved it, it is there here, too. */
    shown(axis, id, focus) {
        if (this.#scheduled || id < this.#asked) return;
        const index = transform(this.inverse, this.at),
            there = transform(this.inverse, focus)[axis];
        if (Math.abs(there - index[axis]) < 1e-3) return;
        index[axis] = there;
        this.at = transform(this.matrix, index);
        this.#told();
    }

    /** One slice over the whole stage, or the four pictures again. */
    enlarge(axis) {
        const { dataset } = this.stage;
        if (dataset.large) delete dataset.large;
        else dataset.large = 'ijk'[axis];
        for (const [i, { picture }] of this.slices.entries()) picture.classList.toggle('large', Boolean(dataset.large) && i === axis);
    }

    /** The whole of each slice in view. */
    whole() {
        for (const slice of this.slices) slice.seen = null;
        this.changed();
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
        this.changed();
        this.app.probe.hover({ world: this.at });
    }

    /** The hand on a slider, in the phases of one. */
    hand(phase) {
        const { connection } = this.app;
        if (phase === 'key') this.burst.touch();
        else if (phase === 'start') connection.hold();
        else if (phase === 'end' && this.#sliding) connection.release();
        this.#sliding = phase === 'start' || phase === 'move';
    }

    step(axis, by) {
        const index = transform(this.inverse, this.at);
        index[axis] = Math.round(index[axis] + by);
        this.goTo(index);
    }

    setWindow(range) {
        this.window = range;
        this.#told();
        this.changed();
    }

    setGrey(grey) {
        this.grey = grey;
        this.#told();
        this.changed();
    }
}

/** The planes that the mode slice shows in the main picture. */
function planes(app, slices) {
    const crossing = button(
        'At the cross-hair',
        () =>
            app.edits.apply({
                slice: [0, 1, 2].map((axis) => ({ origin: slices.at, normal: unit(axisStep(slices.matrix, axis)) })),
                render: { mode: 'slice' },
            }),
        { kind: 'small', title: 'Three planes, those of the slices, in the picture' },
    );
    const show = button('Draw planes', () => app.setMode('slice'), { kind: 'small', title: 'The mode slice' });
    const hint = h('p', { class: 'hint' }, 'They are drawn in the mode slice.');
    const section = h('div', { class: 'stack' }, planesSection(app, PLANES, crossing));
    watch(['scene'], () => {
        section.hidden = !drawsPlanes();
        hint.hidden = show.hidden = drawsPlanes();
    });
    return [hint, h('div', { class: 'row' }, show), section];
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
                const plane = planeName(get('volume').space, axisStep(slices.matrix, axis)),
                    name = plane ? `${plane} (${'ijk'[axis]})` : 'ijk'[axis];
                const control = slider({ minimum: 0, maximum: Math.max(n - 1, 1), label: `Slice ${name}`, whole: true }, (x, phase) => {
                    slices.hand(phase);
                    const index = transform(slices.inverse, slices.at);
                    index[axis] = x;
                    slices.goTo(index);
                });
                const row = field(name, control);
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
        h(
            'div',
            { class: 'row' },
            button('Whole range', () => slices.setWindow([...get('volume').range]), {
                kind: 'small',
                title: 'The window takes all values',
            }),
            button('Whole slices', () => slices.whole(), { kind: 'small', title: 'No zoom: each slice as a whole (0)' }),
        ),
        h(
            'p',
            { class: 'hint' },
            'Drag moves the cross-hair, the wheel steps, Ctrl and wheel zoom, a middle or Shift drag pans, a right drag sets window ' +
                '(sideways) and level (upwards). A double click makes one large.',
        ),
        h('h3', {}, 'Planes in the picture'),
        planes(app, slices),
    );
}
