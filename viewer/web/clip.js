/* SPDX-License-Identifier: MIT */
/* Clipping: a box with a handle on each face, in the picture and as sliders, and planes that can be moved along their normals. */

import { attributes, button, clamp, field, h, svg } from './dom.js';
import { checkbox, numbersInput, slider } from './controls.js';
import { add, dot, length, scale, sub, unit } from './geometry.js';
import { get, watch } from './store.js';

const MOST = 6;
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

/** How far along a world direction a drag of pixels goes, seen at a point. */
function along(toPixels, point, direction, step, drag) {
    const [a, b] = [toPixels(point), toPixels(add(point, scale(direction, step)))];
    if (!a || !b) return 0;
    const way = sub(b, a),
        square = dot(way, way);
    return square < 0.25 ? 0 : (dot(drag, way) / square) * step;
}

/** A drag of a handle: calls move(pixels moved since the press, phase). */
function draggable(element, move) {
    let from = null,
        phase = 'start';
    element.addEventListener('pointerdown', (event) => {
        from = [event.clientX, event.clientY];
        phase = 'start';
        element.setPointerCapture(event.pointerId);
        event.stopPropagation();
        event.preventDefault();
    });
    element.addEventListener('pointermove', (event) => {
        if (from) {
            move([event.clientX - from[0], event.clientY - from[1]], phase);
            phase = 'move';
        }
    });
    for (const end of ['pointerup', 'pointercancel'])
        element.addEventListener(end, (event) => {
            if (from && phase === 'move') move([event.clientX - from[0], event.clientY - from[1]], 'end');
            from = null;
        });
}

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
    group = svg('g', { class: 'clip-layer' });
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

/** A handle stays in reach where its face is outside the picture or under the bar at the top: a drag is relative and works from there. */
function within(picture, [x, y]) {
    return { cx: clamp(x, 14, picture.clientWidth - 14), cy: clamp(y, 68, picture.clientHeight - 14) };
}

/** The layer of the planes: an arrow from where each stands to what it keeps. */
class PlanesLayer {
    group = svg('g', { class: 'clip-layer' });
    #start = null;

    constructor(app) {
        this.app = app;
    }

    #make(index) {
        const line = svg('line', { class: 'plane-arrow' }),
            handle = svg('circle', { class: 'clip-handle', r: 8, 'data-handle': 'plane' });
        draggable(handle, (drag, phase) => {
            const planes = get('scene')['clip-planes'];
            if (phase === 'start') this.#start = planes[index];
            const normal = unit(this.#start.normal);
            const by = along(this.toPixels, this.#start.origin, normal, diagonal() / 4, drag);
            this.app.edits.apply(
                { 'clip-planes': planes.map((p, i) => (i === index ? { ...p, origin: add(this.#start.origin, scale(normal, by)) } : p)) },
                phase,
            );
        });
        return svg('g', {}, line, handle);
    }

    update(view, toPixels) {
        this.toPixels = toPixels;
        const planes = get('panel') === 'clip' ? (get('scene')?.['clip-planes'] ?? []) : [];
        while (this.group.children.length > planes.length) this.group.lastChild.remove();
        while (this.group.children.length < planes.length) this.group.append(this.#make(this.group.children.length));
        planes.forEach(({ origin, normal }, i) => {
            const [line, handle] = this.group.children[i].children;
            const a = toPixels(origin),
                b = toPixels(add(origin, scale(unit(normal), diagonal() / 8)));
            if (a && b) {
                attributes(line, { x1: a[0], y1: a[1], x2: b[0], y2: b[1] });
                attributes(handle, within(this.app.picture, a));
            }
        });
    }
}

const middle = () => [0, 1, 2].map((i) => (get('volume').bounds[2 * i] + get('volume').bounds[2 * i + 1]) / 2);
const diagonal = () => length([0, 1, 2].map((i) => get('volume').bounds[2 * i + 1] - get('volume').bounds[2 * i]));

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

function planeRow(app, index) {
    const planes = () => get('scene')['clip-planes'];
    const change = (part, phase) =>
        app.edits.apply({ 'clip-planes': planes().map((p, i) => (i === index ? { ...p, ...part } : p)) }, phase);
    const half = diagonal() / 2;
    const offset = slider({ minimum: -half, maximum: half, label: `Offset of plane ${index + 1}` }, (x, phase) => {
        const { origin, normal } = planes()[index],
            n = unit(normal);
        change({ origin: add(origin, scale(n, x - dot(sub(origin, middle()), n))) }, phase);
    });
    const normal = numbersInput(3, `Normal of plane ${index + 1}`, (n) => length(n) > 0 && change({ normal: n }), 3);
    const row = h(
        'div',
        { class: 'card' },
        h(
            'div',
            { class: 'row' },
            h('span', { class: 'grow' }, `Plane ${index + 1}`),
            button('', () => change({ normal: scale(planes()[index].normal, -1) }), {
                icon: 'flip',
                kind: 'plain',
                title: 'Keep the other side',
            }),
            button('', () => app.edits.apply({ 'clip-planes': planes().filter((_, i) => i !== index) }), {
                icon: 'trash',
                kind: 'plain',
                title: 'Remove this plane',
            }),
        ),
        field('Offset', offset),
        field('Normal', normal),
    );
    row.update = ({ origin, normal: n }) => {
        offset.update(dot(sub(origin, middle()), unit(n)));
        normal.update(n);
    };
    return row;
}

function planeControls(app) {
    const rows = h('div', { class: 'stack' });
    watch(['scene', 'volume'], () => {
        const planes = get('scene')?.['clip-planes'] ?? [];
        if (!get('volume')) return;
        if (rows.children.length !== planes.length) rows.replaceChildren(...planes.map((_, i) => planeRow(app, i)));
        planes.forEach((plane, i) => rows.children[i].update(plane));
    });
    const more = (normal) => {
        const planes = get('scene')['clip-planes'] ?? [];
        if (planes.length >= MOST) app.messages.tell(`At most ${MOST} clip planes. Remove one first.`);
        else app.edits.apply({ 'clip-planes': [...planes, { origin: middle(), normal }] });
    };
    const axes = [0, 1, 2].map((axis) =>
        button('xyz'[axis], () => more([0, 1, 2].map((i) => (i === axis ? 1 : 0))), {
            kind: 'small',
            title: `A plane square to ${'xyz'[axis]}`,
        }),
    );
    return [
        rows,
        h(
            'div',
            { class: 'row' },
            h('span', { class: 'small-text' }, 'Add'),
            axes,
            button('Facing me', () => more(app.overlay.view?.forward ?? [0, 1, 0]), {
                kind: 'small',
                title: 'A plane square to the view: what is in front goes',
            }),
        ),
    ];
}

export function clipPanel(app) {
    app.overlay.addLayer(new BoxLayer(app));
    app.overlay.addLayer(new PlanesLayer(app));
    return h(
        'div',
        { class: 'stack' },
        boxControls(app),
        h('h3', {}, 'Planes'),
        planeControls(app),
        button('No clipping', () => app.edits.apply({ 'clip-box': null, 'clip-planes': [] }), { kind: 'small' }),
    );
}
