/* SPDX-License-Identifier: MIT */
/* Planes of the scene, those that clip and those that are seen in the mode slice: an arrow with a handle in the picture, and a card in the
 * panel, for each. */

import { attributes, button, field, h, svg } from './dom.js';
import { numbersInput, slider } from './controls.js';
import { add, dot, length, scale, sub, unit } from './geometry.js';
import { along, diagonal, draggable, middle, within } from './handles.js';
import { get, watch } from './store.js';

/**
 * A list of planes in the scene.
 * @typedef {{key: string, panel: string, name: string, least: number, most: number, flips: boolean, shown: function(): boolean}} Kind
 *     its key in the scene, the panel whose opening shows the handles, what one is called, how many there are at least and at most, whether
 *     the side that it faces matters, and when it is seen at all
 */
const planesOf = ({ key }) => [get('scene')?.[key] ?? []].flat();

/** Arrows with handles. */
class PlanesLayer {
    group = svg('g', { class: 'clip-layer' });
    #start = null;

    constructor(app, kind) {
        this.app = app;
        this.kind = kind;
    }

    #make(index) {
        const line = svg('line', { class: 'plane-arrow' }),
            handle = svg('circle', { class: 'clip-handle', r: 8, 'data-handle': 'plane' });
        draggable(handle, (drag, phase) => {
            const planes = planesOf(this.kind);
            if (phase === 'start') this.#start = planes[index];
            const normal = unit(this.#start.normal);
            const by = along(this.toPixels, this.#start.origin, normal, diagonal() / 4, drag);
            const moved = { ...this.#start, origin: add(this.#start.origin, scale(normal, by)) };
            this.app.edits.apply({ [this.kind.key]: planes.map((p, i) => (i === index ? moved : p)) }, phase);
        });
        return svg('g', {}, line, handle);
    }

    update(view, toPixels) {
        this.toPixels = toPixels;
        const planes = get('panel') === this.kind.panel && this.kind.shown() ? planesOf(this.kind) : [];
        while (this.group.children.length > planes.length) this.group.lastChild.remove();
        while (this.group.children.length < planes.length) this.group.append(this.#make(this.group.children.length));
        planes.forEach(({ origin, normal }, i) => {
            const [line, handle] = this.group.children[i].children;
            const a = toPixels(origin),
                b = toPixels(add(origin, scale(unit(normal), diagonal() / 8)));
            if (a && b) {
                attributes(line, { x1: a[0], y1: a[1], x2: b[0], y2: b[1] });
                /* At the arrow's end: several planes may stand in one place. */
                attributes(handle, within(this.app.picture, b));
            }
        });
    }
}

function planeCard(app, kind, index) {
    const name = `${kind.name} ${index + 1}`;
    const planes = () => planesOf(kind);
    const change = (part, phase) => app.edits.apply({ [kind.key]: planes().map((p, i) => (i === index ? { ...p, ...part } : p)) }, phase);
    const half = diagonal() / 2;
    const offset = slider({ minimum: -half, maximum: half, label: `Offset of ${name}` }, (x, phase) => {
        const { origin, normal } = planes()[index],
            n = unit(normal);
        change({ origin: add(origin, scale(n, x - dot(sub(origin, middle()), n))) }, phase);
    });
    const normal = numbersInput(3, `Normal of ${name}`, (n) => length(n) > 0 && change({ normal: n }), 3);
    const flip = button('', () => change({ normal: scale(planes()[index].normal, -1) }), {
        icon: 'flip',
        kind: 'plain',
        title: 'Keep the other side',
    });
    const remove = button('', () => app.edits.apply({ [kind.key]: planes().filter((_, i) => i !== index) }), {
        icon: 'trash',
        kind: 'plain',
        title: 'Remove this plane',
    });
    const card = h(
        'div',
        { class: 'card' },
        h('div', { class: 'row' }, h('span', { class: 'grow' }, name), kind.flips ? flip : null, remove),
        field('Offset', offset),
        field('Normal', normal),
    );
    card.update = ({ origin, normal: n }, count) => {
        offset.update(dot(sub(origin, middle()), unit(n)));
        normal.update(n);
        remove.disabled = count <= kind.least;
    };
    return card;
}

/** The cards, and buttons that add one; the handles come over the picture. `more`: further buttons beside them. */
export function planesSection(app, kind, ...more) {
    const layer = new PlanesLayer(app, kind),
        cards = h('div', { class: 'stack' });
    app.overlay.addLayer(layer);
    watch(['volume'], () => cards.replaceChildren());
    watch(['scene', 'volume', 'panel'], () => {
        const planes = planesOf(kind);
        if (!get('volume') || !get('scene')) return;
        while (cards.children.length > planes.length) cards.lastChild.remove();
        while (cards.children.length < planes.length) cards.append(planeCard(app, kind, cards.children.length));
        planes.forEach((plane, i) => cards.children[i].update(plane, planes.length));
        app.overlay.update();
    });
    const put = (normal) => {
        const planes = planesOf(kind);
        if (planes.length >= kind.most) app.messages.tell(`At most ${kind.most} of these planes. Remove one first.`);
        else app.edits.apply({ [kind.key]: [...planes, { origin: middle(), normal }] });
    };
    const axes = [0, 1, 2].map((axis) =>
        button('xyz'[axis], () => put([0, 1, 2].map((i) => (i === axis ? 1 : 0))), {
            kind: 'small',
            title: `A plane square to ${'xyz'[axis]}`,
        }),
    );
    const facing = button('Facing me', () => put(app.overlay.view?.forward ?? [0, 1, 0]), {
        kind: 'small',
        title: 'A plane square to the view',
    });
    return [cards, h('div', { class: 'row' }, h('span', { class: 'small-text' }, 'Add'), axes, facing, more)];
}
