/* SPDX-License-Identifier: MIT */
/* What is drawn over the main picture with the camera of the frame that is seen: orientation axes, scale bar, colour legend. The clip box,
 * the planes and the measured distances (clip.js, measure.js) add layers of their own. */

import { attributes, clamp, h, hex, short, svg } from './dom.js';
import { axisNames, dot, roundStep, ticks, View } from './geometry.js';
import { get, watch } from './store.js';
import { evaluate } from './transfer-model.js';

const AXIS_RADIUS = 38;

/** The six ends of the axes. */
const ENDS = ['x', 'y', 'z'].flatMap((name, axis) =>
    [1, -1].map((sign) => ({ name, axis, sign, direction: [0, 1, 2].map((i) => (i === axis ? sign : 0)) })),
);

/**
 * A bar of a round length. Parallel: exact everywhere. Perspective: as long as it says in the focal plane, which is told; in short where
 * there is no room.
 */
export function updateScaleBar(host, view, picture) {
    const perPixel = (2 * view.halfHeight) / picture.area.height;
    const world = roundStep(Math.min(160, picture.clientWidth / 4) * perPixel);
    const unit = get('volume').units || 'units';
    const place = view.parallel ? '' : picture.clientWidth < 320 ? ' at focus' : ' in the focal plane';
    const text = `${short(world)} ${unit}${place}`;
    if (!host.children.length) host.append(h('div', { class: 'bar' }), h('div', {}));
    const [bar, label] = host.children;
    bar.style.width = `${(world / perPixel).toFixed(1)}px`;
    if (label.textContent !== text) label.textContent = text;
}

export class Overlay {
    #layers = [];
    #view = null;
    #ends = [];

    constructor(app, picture) {
        this.app = app;
        this.picture = picture;
        this.svg = svg('svg', { class: 'overlay', 'aria-hidden': 'true' });
        this.axes = svg('svg', { class: 'axes', viewBox: '-56 -56 112 112' });
        this.scaleBar = h('div', { class: 'scale-bar', 'aria-hidden': 'true' });
        this.legend = h('div', { class: 'legend', 'aria-hidden': 'true' });
        picture.append(this.svg, this.axes, this.scaleBar, this.legend);
        /* The ends stay the same elements from frame to frame, or a click on one would be lost when a frame comes in its middle. */
        this.axes.addEventListener('click', (event) => {
            const { name, sign } = this.#ends.find(({ group }) => group.contains(event.target)) ?? {};
            if (name) app.look(name, sign);
        });
        watch(['volume'], () => this.#nameAxes());
        picture.addEventListener('drawn', () => this.update());
        picture.addEventListener('resized', () => this.update());
        watch(['scene', 'volume'], () => this.#legend());
        watch(['volume', 'preferences', 'scene'], () => this.update());
    }

    /** A layer: an SVG group, drawn again with each frame by update(view, toPixels). */
    addLayer(layer) {
        this.svg.append(layer.group);
        this.#layers.push(layer);
        this.update();
    }

    /** The camera that the picture was seen with; null before the first frame. */
    get view() {
        return this.#view;
    }

    /** World to CSS pixels of the picture: [x, y] or null. */
    toPixels = (point) => {
        const at = this.#view?.project(point),
            area = this.picture.area;
        return at && [area.x + at[0] * area.width, area.y + at[1] * area.height];
    };

    update() {
        const header = this.picture.header;
        if (!header?.camera || !get('volume')) return;
        const shown = get('preferences').overlays;
        this.#view = new View(header.camera, header.of[0] / header.of[1]);
        attributes(this.svg, { width: this.picture.clientWidth, height: this.picture.clientHeight });
        this.#ground();
        for (const layer of this.#layers) layer.update(this.#view, this.toPixels);
        this.axes.classList.toggle('off', !shown);
        this.scaleBar.hidden = !shown;
        this.legend.hidden = !shown || get('scene')?.render?.mode === 'xray';
        if (shown) {
            this.#axes();
            updateScaleBar(this.scaleBar, this.#view, this.picture);
        }
    }

    /** Writing is light on a dark picture and dark on a light one. */
    #ground() {
        const [r, g, b] = get('scene')?.background ?? [0, 0, 0];
        this.picture.dataset.ground = 0.3 * r + 0.59 * g + 0.11 * b > 0.5 ? 'light' : 'dark';
    }

    #nameAxes() {
        const names = axisNames(get('volume').space);
        this.#ends = ENDS.map((end) => {
            const letter = names[end.axis][end.sign > 0 ? 0 : 1],
                strong = end.sign > 0 || letter;
            const line = strong ? svg('line', { x1: 0, y1: 0, 'stroke-width': end.sign > 0 ? 3 : 1.5 }) : null,
                knob = svg('circle', { r: strong ? 10 : 6, 'stroke-width': 1.5 }),
                text = letter ? svg('text', { 'text-anchor': 'middle' }, letter) : null;
            const title = svg('title', {}, `Look from ${letter || `−${end.name}`}`);
            const side = end.sign > 0 ? 'front' : 'back';
            const group = svg('g', { class: `axis-end axis-${end.axis} ${side}`, 'data-handle': 'axis' }, title, line, knob, text);
            return { ...end, group, line, knob, text };
        });
        this.axes.replaceChildren(...this.#ends.map(({ group }) => group));
    }

    #axes() {
        const { right, up, forward } = this.#view;
        for (const { direction, group, line, knob, text } of this.#ends) {
            const x = dot(direction, right) * AXIS_RADIUS,
                y = -dot(direction, up) * AXIS_RADIUS;
            if (line) attributes(line, { x2: x, y2: y });
            attributes(knob, { cx: x, cy: y });
            if (text) attributes(text, { x, y: y + 4 });
            attributes(group, { opacity: 0.75 - 0.25 * dot(direction, forward) });
        }
        /* The nearer ones over the others; moved only where that changes. */
        const sorted = this.#ends.toSorted((a, b) => dot(b.direction, forward) - dot(a.direction, forward)).map(({ group }) => group);
        if (sorted.some((group, i) => this.axes.children[i] !== group)) this.axes.replaceChildren(...sorted);
    }

    /** The colours of the values that have a colour; in isosurface mode, the surfaces. */
    #legend() {
        const scene = get('scene'),
            volume = get('volume');
        if (!scene?.transfer?.colors?.length || !volume) return;
        if (scene.render?.mode === 'isosurface' && scene.isosurfaces?.length) {
            this.legend.replaceChildren(
                ...scene.isosurfaces.map((surface) => {
                    const patch = h('i', {});
                    patch.style.background = hex(surface.color ?? [1, 1, 1]);
                    return h('div', { class: 'legend-surface' }, patch, short(surface.value));
                }),
            );
            return;
        }
        const colors = scene.transfer.colors;
        const lo = Math.max(colors[0][0], volume.range[0]),
            hi = Math.min(colors.at(-1)[0], volume.range[1]);
        const [from, to] = hi > lo ? [lo, hi] : volume.range;
        const stops = Array.from({ length: 24 }, (_, i) => hex(evaluate(colors, to + (i / 23) * (from - to))));
        const bar = h('div', { class: 'legend-bar' });
        bar.style.background = `linear-gradient(${stops.join(',')})`;
        const marks = ticks(from, to, 4).map((value) => {
            const mark = h('span', {}, short(value));
            mark.style.top = `${clamp(((to - value) / (to - from)) * 100, 0, 100)}%`;
            return mark;
        });
        this.legend.replaceChildren(bar, h('div', { class: 'legend-marks' }, marks));
    }
}
