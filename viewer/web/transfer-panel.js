/* SPDX-License-Identifier: MIT */
/* The panel of the transfer function and the isovalues: the editor, the chosen point in numbers, colour maps, import and export. */

import { NAMES } from './transfer-editor.js';
import { button, field, h } from './dom.js';
import { colorInput, numberInput, select, slider } from './controls.js';
import { colormapGrid } from './colormaps.js';
import { exchange } from './exchange.js';
import { get, prefer, watch } from './store.js';
import { bandBy, move, scaleOpacity, simplify } from './transfer-model.js';

/** The chosen point as numbers and, of a colour point, its colour. */
function pointFields(editor) {
    const value = numberInput({ label: 'Value of the chosen point' }, (x) =>
        change((p, i) => (editor.chosen.part === 'isosurfaces' ? p.map((s, k) => (k === i ? { ...s, value: x } : s)) : move(p, i, x))),
    );
    const opacity = numberInput({ minimum: 0, maximum: 1, label: 'Opacity of the chosen point' }, (x) =>
        change((p, i) => move(p, i, p[i][0], [x])),
    );
    const color = colorInput((c, phase) => change((p, i) => move(p, i, p[i][0], c.slice(0, 3)), phase), 'Colour of the chosen point');
    const [valueField, opacityField, colorField] = [field('Value', value), field('Opacity', opacity), field('Colour', color)];
    const which = h('span', { class: 'which' });
    const remove = button('', () => editor.removePoint(editor.chosen.part, editor.chosen.index), {
        icon: 'trash',
        kind: 'plain',
        title: 'Remove the point (Delete, or right click)',
    });
    const element = h('div', { class: 'point-fields' }, which, valueField, opacityField, colorField, remove);
    function change(make, phase = 'end') {
        const { part, index } = editor.chosen;
        editor.commit(part, make(editor.data[part], index), phase);
    }
    const update = () => {
        const { part, index, band } = editor.chosen,
            point = editor.data[part][index];
        element.hidden = !point;
        if (!point) return;
        which.textContent = band ? `Band ${band[0] + 1}–${band[1] + 1}` : `${NAMES[part]} ${index + 1}/${editor.data[part].length}`;
        opacityField.hidden = part !== 'opacities';
        colorField.hidden = part !== 'colors';
        value.update(part === 'isosurfaces' ? point.value : point[0]);
        if (part === 'opacities') opacity.update(point[1]);
        if (part === 'colors') color.update(point.slice(1));
    };
    editor.addEventListener('choose', update);
    watch(['scene'], () => queueMicrotask(update));
    return element;
}

/** Logarithmic or linear counts, how opacity spreads near zero, the zoom of values. */
function lookRow(editor) {
    const counts = select(
        [
            ['log', 'log counts'],
            ['linear', 'linear counts'],
        ],
        (kind) => prefer({ counts: kind }),
        'Counts of the histogram',
    );
    const power = select(
        [
            ['1', 'opacity even'],
            ['2', 'opacity fine'],
            ['4', 'opacity finest'],
        ],
        (p) => prefer({ power: Number(p) }),
        'Scale of opacity: how much room there is near zero',
    );
    const whole = button('All values', () => editor.zoomTo(-Infinity, Infinity), {
        kind: 'small',
        title: 'Show all values again (wheel zooms, a drag on the ground pans)',
    });
    watch(['preferences'], () => {
        const { counts: kind, power: p } = get('preferences');
        counts.update(kind);
        power.update(String(p));
        editor.update({}, { logarithmic: kind === 'log', power: p });
    });
    return h('div', { class: 'row' }, counts, power, whole);
}

/** What changes all points. */
function wholeCurve(app, editor) {
    let from = null;
    const strength = slider({ minimum: 0.05, maximum: 20, label: 'Strength of all opacities' }, (factor, phase) => {
        from ??= get('scene').transfer.opacities;
        editor.commit('opacities', scaleOpacity(from, factor), phase);
        if (phase === 'end' || phase === 'key') {
            from = null;
            queueMicrotask(() => strength.update(1));
        }
    });
    strength.update(1);
    const reduce = () => {
        const points = editor.data.opacities,
            high = Math.max(...points.map((p) => p[1]));
        editor.commit('opacities', simplify(points, high * 0.03));
    };
    const fit = () => {
        const { part, index } = editor.chosen;
        const points = editor.data.opacities;
        if (part === 'opacities' && points[index]) {
            const [first, last] = bandBy(points, index);
            const pad = (points[last][0] - points[first][0]) * 0.3 || 1;
            editor.zoomTo(points[first][0] - pad, points[last][0] + pad);
        }
    };
    return [
        field('Opacity ×', strength, { help: 'Scales the whole curve' }),
        h(
            'div',
            { class: 'row' },
            button('Automatic', () => app.connection.send({ do: 'automatic', what: 'transfer' }), {
                kind: 'small',
                title: 'Choose colours and opacities from the volume again',
            }),
            button('Simplify', reduce, { kind: 'small', title: 'Fewer points for almost the same curve' }),
            button('Zoom to band', fit, { kind: 'small', title: 'Show the values of the band of the chosen point' }),
        ),
    ];
}

export function transferPanel(app) {
    const editor = document.createElement('pel-transfer-editor');
    editor.addEventListener('edit', ({ detail: { part, points, phase } }) =>
        app.edits.apply(part === 'isosurfaces' ? { isosurfaces: points } : { transfer: { [part]: points } }, phase),
    );
    watch(['scene', 'volume', 'histogram'], () => {
        const scene = get('scene'),
            volume = get('volume');
        if (!scene || editor.dragging) return;
        const { opacities = [], colors = [] } = scene.transfer ?? {};
        const values = [...opacities, ...colors].map((p) => p[0]);
        const [lo, hi] = volume?.range ?? [Math.min(...values), Math.max(...values)];
        editor.update({ opacities, colors, isosurfaces: scene.isosurfaces ?? [], histogram: get('histogram'), range: [lo, hi] });
    });
    watch(['volume'], () => editor.update({}, { zoom: null }));
    const choose = (name) => {
        const { colors } = get('scene').transfer,
            range = get('volume').range;
        const span = colors.length > 1 ? [colors[0][0], colors.at(-1)[0]] : range;
        app.connection.send({ do: 'colormap', name, range: span });
    };
    const ends = () => [0, -1].map((at) => get('scene').transfer.colors.at(at)[0]);
    const lo = numberInput({ label: 'Colours from' }, (x) => spread(x, ends()[1])),
        hi = numberInput({ label: 'Colours to' }, (x) => spread(ends()[0], x));
    const spread = (from, to) => {
        if (from < to) app.stretchColors(from, to, get('scene').transfer.colormap);
        else app.messages.error('Colours go from a lower value to a higher one.');
        showEnds();
    };
    const showEnds = () => get('scene')?.transfer?.colors?.length && [lo, hi].forEach((input, i) => input.update(ends()[i]));
    watch(['scene'], showEnds);
    const unitDistance = numberInput({ minimum: 0, label: 'Unit distance' }, (x) => app.edits.apply({ transfer: { 'unit-distance': x } }));
    watch(['scene'], () => unitDistance.update(get('scene')?.transfer?.['unit-distance']));
    app.editor = editor;
    return h(
        'div',
        { class: 'stack' },
        editor,
        pointFields(editor),
        lookRow(editor),
        wholeCurve(app, editor),
        h('h3', {}, 'Colours'),
        h('div', { class: 'row range-row' }, field('From', lo), field('To', hi)),
        colormapGrid(choose),
        h('h3', {}, 'More'),
        field('Unit distance', unitDistance, { help: 'Length of material that has the opacity of the curve', unit: 'world' }),
        exchange(app),
    );
}
