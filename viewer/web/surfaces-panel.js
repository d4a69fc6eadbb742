/* SPDX-License-Identifier: MIT */
/* Isosurfaces: a list of values with colour and opacity; the same that are lines in the transfer function's editor. */

import { button, h, short } from './dom.js';
import { colorInput, slider } from './controls.js';
import { get, watch } from './store.js';

const COLORS = [
    [0.93, 0.87, 0.75],
    [0.85, 0.35, 0.3],
    [0.35, 0.6, 0.85],
    [0.45, 0.75, 0.45],
    [0.85, 0.65, 0.3],
    [0.7, 0.5, 0.8],
];
const MOST = 16;

function row(app, surface, index, range) {
    const list = () => get('scene').isosurfaces;
    const change = (key, value, phase) =>
        app.edits.apply({ isosurfaces: list().map((s, i) => (i === index ? { ...s, [key]: value } : s)) }, phase);
    const value = slider({ minimum: range[0], maximum: range[1], label: `Isovalue ${index + 1}` }, (x, phase) => change('value', x, phase));
    const opacity = slider({ minimum: 0, maximum: 1, label: `Opacity of isosurface ${index + 1}` }, (x, phase) =>
        change('opacity', x, phase),
    );
    const color = colorInput((c, phase) => change('color', c, phase), `Colour of isosurface ${index + 1}`);
    const remove = button('', () => app.edits.apply({ isosurfaces: list().filter((_, i) => i !== index) }), {
        icon: 'trash',
        kind: 'plain',
        title: 'Remove this isosurface',
    });
    const element = h(
        'div',
        { class: 'surface card' },
        h('div', { class: 'row' }, color, h('span', { class: 'grow' }, 'Isovalue'), remove),
        value,
        h('div', { class: 'row' }, h('span', { class: 'small-text' }, 'Opacity')),
        opacity,
    );
    element.update = (s) => {
        value.update(s.value);
        opacity.update(s.opacity ?? 1);
        color.update(s.color ?? COLORS[0]);
    };
    element.update(surface);
    return element;
}

export function surfacesPanel(app) {
    const rows = h('div', { class: 'stack' });
    const hint = h('p', { class: 'hint' });
    let shape = '';
    watch(['scene', 'volume'], () => {
        const surfaces = get('scene')?.isosurfaces ?? [],
            range = get('volume')?.range ?? [0, 1];
        const now = `${surfaces.length} ${range}`;
        if (now !== shape) rows.replaceChildren(...surfaces.map((surface, i) => row(app, surface, i, range)));
        else surfaces.forEach((surface, i) => rows.children[i].update(surface));
        shape = now;
        const drawn = get('scene')?.render?.mode === 'isosurface';
        hint.textContent = !surfaces.length ? 'No isosurface yet.' : drawn ? '' : 'They are drawn in the mode isosurface.';
        show.hidden = drawn || !surfaces.length;
    });
    function add() {
        const surfaces = get('scene').isosurfaces ?? [],
            [lo, hi] = get('volume').range;
        if (surfaces.length >= MOST) {
            app.messages.tell(`At most ${MOST} isosurfaces can be drawn. Remove one first.`);
            return;
        }
        const value = surfaces.length ? (surfaces.at(-1).value + hi) / 2 : Number(short(lo + 0.3 * (hi - lo)));
        app.edits.apply({
            isosurfaces: [...surfaces, { value, color: COLORS[surfaces.length % COLORS.length], opacity: surfaces.length ? 0.5 : 1 }],
            render: { mode: 'isosurface' },
        });
    }
    /** One step of undo: the value, and the mode that shows it. */
    function automatic() {
        const gesture = app.connection.newGesture();
        app.connection.send({ do: 'automatic', what: 'isosurfaces', gesture });
        app.connection.send({ do: 'set', scene: { render: { mode: 'isosurface' } }, gesture });
    }
    const show = button('Draw isosurfaces', () => app.edits.apply({ render: { mode: 'isosurface' } }), { kind: 'small' });
    return h(
        'div',
        { class: 'stack' },
        rows,
        hint,
        h(
            'div',
            { class: 'row' },
            button('Add', add, { icon: 'plus', kind: 'small', title: 'One more isosurface' }),
            show,
            button('Automatic', automatic, {
                kind: 'small',
                title: 'The value that shows the outer boundary',
            }),
        ),
    );
}
