/* SPDX-License-Identifier: MIT */
/* Clipping: a box with a handle on each face, in the picture and as sliders, and planes that can be moved along their normals. */

import { attributes, button, clamp, field, h, svg } from './dom.js';
import { checkbox, slider } from './controls.js';
import { along, draggable, within } from './handles.js';
import { get, watch } from './store.js';
import { planesSection } from './planes.js';

const PLANES = { key: 'clip-planes', panel: 'clip', name: 'Plane', least: 0, most: 6, flips: true, shown: () => true };
const EDGES = [
    [0, 1],
    [2, 3],
    [4, 5],
    [6, 7],
    [0, 2],
    [1, 3],
    [4, 6],
    [5, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

const corner = (box, i) => [box[i & 1], box[2 + ((i >> 1) & 1)], box[4 + ((i >> 2) & 1)]];

/** Keeps the two ends of an axis in order and inside the volume. */
function withFace(box, face, value, bounds) {
    const axis = face >> 1,
        gap = (bounds[2 * axis + 1] - bounds[2 * axis]) * 0.002;
    const low = face % 2 ? box[face - 1] + gap : bounds[2 * axis],
        high = face % 2 ? bounds[face] : box[face + 1] - gap;
    return box.map((x, i) => (i === face ? clamp(value, low, high) : x));
}

/** The layer of the box: twelve edges, six handles. */
class BoxLayer {
    group = svg('g', { class: 'clip-layer off' });
    #edges = EDGES.map(() => svg('line', { class: 'clip-edge' }));
    #handles = [0, 1, 2, 3, 4, 5].map((face) =>
        svg('circle', { class: `clip-handle axis-${face >> 1}`, r: 8, 'data-handle': 'clip', 'data-face': face }),
    );
    #pressed = null;

    constructor(app) {
        this.app = app;
        this.group.append(...this.#edges, ...this.#handles);
        this.#handles.forEach((handle, face) => draggable(handle, (drag, phase) => this.#drag(face, drag, phase)));
    }

    #drag(face, drag, phase) {
        const bounds = get('volume').bounds;
        if (phase === 'start') this.#pressed = { box: get('scene')['clip-box'] ?? bounds, toPixels: this.toPixels };
        const { box } = this.#pressed,
            axis = face >> 1;
        const direction = [0, 1, 2].map((i) => (i === axis ? 1 : 0));
        const by = along(this.toPixels, this.#middle(box, face), direction, bounds[2 * axis + 1] - bounds[2 * axis], drag);
        this.app.edits.apply({ 'clip-box': withFace(box, face, box[face] + by, bounds) }, phase);
    }

    #middle(box, face) {
        return [0, 1, 2].map((i) => (i === face >> 1 ? box[face] : (box[2 * i] + box[2 * i + 1]) / 2));
    }

    update(view, toPixels) {
        this.toPixels = toPixels;
        const box = get('scene')?.['clip-box'];
        const shown = Boolean(box) && get('panel') === 'clip';
        this.group.classList.toggle('off', !shown);
        if (!shown) return;
        const corners = [...Array(8).keys()].map((i) => toPixels(corner(box, i)));
        EDGES.forEach(
            ([a, b], i) =>
                corners[a] &&
                corners[b] &&
                attributes(this.#edges[i], { x1: corners[a][0], y1: corners[a][1], x2: corners[b][0], y2: corners[b][1] }),
        );
        this.#handles.forEach((handle, face) => {
            const at = toPixels(this.#middle(box, face));
            if (at) attributes(handle, within(this.app.picture, at));
        });
    }
}

function boxControls(app) {
    const on = checkbox((wish) => app.edits.apply({ 'clip-box': wish ? get('volume').bounds : null }), 'Clip box');
    const faces = h('div', { class: 'stack' });
    watch(['volume'], () => {
        const { bounds } = get('volume');
        faces.replaceChildren(
            ...[0, 1, 2, 3, 4, 5].map((face) => {
                const axis = face >> 1,
                    label = `${'xyz'[axis]} ${face % 2 ? 'to' : 'from'}`;
                const control = slider({ minimum: bounds[2 * axis], maximum: bounds[2 * axis + 1], label }, (value, phase) =>
                    app.edits.apply({ 'clip-box': withFace(get('scene')['clip-box'] ?? bounds, face, value, bounds) }, phase),
                );
                const row = field(label, control);
                row.update = control.update;
                return row;
            }),
        );
    });
    watch(['scene', 'volume', 'panel'], () => {
        const box = get('scene')?.['clip-box'];
        on.update(box);
        faces.hidden = !box;
        [...faces.children].forEach((row, face) => row.update(box?.[face]));
        app.overlay?.update();
    });
    return [field('Clip box', on, { help: 'Keep what lies inside a box; its faces can be dragged in the picture' }), faces];
}

export function clipPanel(app) {
    app.overlay.addLayer(new BoxLayer(app));
    return h(
        'div',
        { class: 'stack' },
        boxControls(app),
        h('h3', {}, 'Planes'),
        planesSection(app, PLANES),
        button('No clipping', () => app.edits.apply({ 'clip-box': null, 'clip-planes': [] }), { kind: 'small' }),
    );
}
