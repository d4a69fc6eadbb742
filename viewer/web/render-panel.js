/* SPDX-License-Identifier: MIT */
/* Mode, technique, optics, background: all controls but the background's come from the option tables. */

import { button, field, fromHex, h, hex } from './dom.js';
import { colorInput, checkbox, optionControl, select } from './controls.js';
import { get, prefer, watch } from './store.js';

const MODES = {
    composite: 'Composite',
    mip: 'Maximum',
    minip: 'Minimum',
    average: 'Average',
    xray: 'X-ray',
    isosurface: 'Isosurface',
    slice: 'Slice',
};
/** Rows of the option table that say what surfaces make of light: they stand with the lights. */
export const SURFACE_ROWS = ['shade', 'ambient', 'diffuse', 'specular', 'specular-power'];
const GROUNDS = [
    ['Black', '#000000'],
    ['Dark', '#1b2027'],
    ['Grey', '#8a8f96'],
    ['Light', '#eef1f4'],
    ['White', '#ffffff'],
];

/** A button for each mode of the row `mode`. */
function modeChooser(app) {
    const group = h('div', { class: 'modes', role: 'group', 'aria-label': 'Mode' });
    watch(['hello'], () => {
        const row = get('hello')?.options?.render?.find(({ name }) => name === 'mode');
        group.replaceChildren(
            ...(row?.choices ?? []).map((mode) =>
                button(MODES[mode] ?? mode, () => app.setMode(mode), { kind: 'choice', title: `Mode ${mode}` }),
            ),
        );
        [...group.children].forEach((b, i) => (b.dataset.mode = row.choices[i]));
    });
    watch(['scene', 'hello'], () =>
        [...group.children].forEach((b) => b.setAttribute('aria-pressed', String(b.dataset.mode === get('scene')?.render?.mode))),
    );
    return group;
}

/** Rows of an option table as controls that follow scene[key] (or what `read` finds in the scene). */
function optionList(rows, read, write) {
    const list = h(
        'div',
        { class: 'stack' },
        rows.map((row) => optionControl(row, (value, phase) => write(row.name, value, phase))),
    );
    const update = () => {
        const values = read(get('scene')) ?? {};
        rows.forEach((row, i) => list.children[i].update(values[row.name]));
    };
    list.update = update;
    update();
    return list;
}

/** The list of techniques; those that what draws now cannot draw are shown, and cannot be chosen. */
function techniqueChooser(app) {
    const choice = select([], (name) => app.edits.apply({ technique: { name, options: {} } }), 'Technique');
    watch(['hello', 'devices'], () => {
        const engine = get('devices')?.device?.kind === 'cpu' ? 'cpu' : null;
        const able = ({ engines }) => !engine || engines.includes(engine);
        choice.replaceChildren(
            ...(get('hello')?.techniques ?? []).map((technique) =>
                h(
                    'option',
                    { value: technique.name, disabled: !able(technique) },
                    able(technique) ? technique.name : `${technique.name} (on a GPU)`,
                ),
            ),
        );
        choice.update(get('scene')?.technique?.name);
    });
    return choice;
}

function techniqueSection(app) {
    const choice = techniqueChooser(app),
        summary = h('p', { class: 'hint' }),
        place = h('div', {});
    let shown = null,
        list = null;
    watch(['hello', 'scene'], () => {
        const { techniques } = get('hello') ?? {},
            technique = get('scene')?.technique;
        if (!techniques || !technique) return;
        choice.update(technique.name);
        if (technique.name !== shown) {
            shown = technique.name;
            const found = techniques.find(({ name }) => name === shown);
            summary.textContent = found?.summary ?? '';
            list = optionList(
                found?.options ?? [],
                (scene) => scene?.technique?.options,
                (name, value, phase) =>
                    app.edits.apply(
                        { technique: { name: technique.name, options: { ...get('scene').technique.options, [name]: value } } },
                        phase,
                    ),
            );
            place.replaceChildren(list);
        }
        list.update();
    });
    return [field('Technique', choice, { help: 'How the picture is computed' }), summary, place];
}

/** A group of the scene's options: those whose names `which` takes. */
export function sceneOptions(app, group, which = () => true) {
    const box = h('div', {});
    let list = null;
    watch(['hello'], () => {
        const rows = (get('hello')?.options?.[group] ?? []).filter(({ name }) => which(name));
        list = optionList(
            rows,
            (scene) => scene?.[group],
            (name, value, phase) => app.edits.apply({ [group]: { [name]: value } }, phase),
        );
        box.replaceChildren(list);
    });
    watch(['scene'], () => list?.update());
    return box;
}

function background(app) {
    const color = colorInput((c, phase) => app.edits.apply({ background: c }, phase), 'Background');
    const presets = h(
        'div',
        { class: 'swatches' },
        GROUNDS.map(([name, value]) => {
            const swatch = h('button', {
                type: 'button',
                class: 'swatch',
                title: `Background: ${name}`,
                'aria-label': `Background ${name}`,
            });
            swatch.style.background = value;
            swatch.addEventListener('click', () => app.edits.apply({ background: [...fromHex(value), 1] }));
            swatch.dataset.color = value;
            return swatch;
        }),
    );
    watch(['scene'], () => {
        const ground = get('scene')?.background;
        if (!ground) return;
        color.update(ground);
        for (const swatch of presets.children) swatch.setAttribute('aria-pressed', String(swatch.dataset.color === hex(ground)));
    });
    return field('Background', h('div', { class: 'row' }, color, presets));
}

function linearLight(app) {
    const control = checkbox((on) => app.edits.apply({ 'linear-light': on }), 'Linear light');
    watch(['scene'], () => control.update(get('scene')?.['linear-light']));
    return field('Linear light', control, { help: 'Composite in linear light instead of display values' });
}

const deviceName = ({ name, kind, threads }) => `${name ?? kind}${threads ? `, ${threads} threads` : ''}`;

/** What draws, and how fine; where the server has one device alone there is nothing to choose. */
function device(app) {
    const alone = h('span', { class: 'value' });
    const choice = select(
        [],
        (id) => {
            app.connection.send({ do: 'device', device: id });
            choice.update(get('devices').device.id); /* until the server says that it draws */
        },
        'Device',
    );
    const choosing = field('Device', choice, { help: 'What draws' }),
        only = h('div', { class: 'field' }, h('span', { class: 'label' }, 'Device'), alone);
    const resolution = select(
        [
            ['1', 'every pixel of the screen'],
            ['css', 'one per CSS pixel'],
            ['0.5', 'half'],
        ],
        (part) => prefer({ resolution: part }),
        'Resolution',
    );
    watch(['preferences'], () => resolution.update(get('preferences').resolution));
    watch(['devices'], () => {
        const { devices = [], device: now } = get('devices');
        if (!now) return;
        choice.replaceChildren(...devices.map((d) => h('option', { value: d.id }, deviceName(d))));
        choice.update(now.id);
        alone.textContent = deviceName(now);
        choosing.hidden = devices.length < 2;
        only.hidden = !choosing.hidden;
    });
    return [
        field('Resolution', resolution, { help: 'Of the picture at rest; under the moving hand it follows the time budget' }),
        choosing,
        only,
    ];
}

export function renderPanel(app) {
    return h(
        'div',
        { class: 'stack' },
        modeChooser(app),
        techniqueSection(app),
        h('h3', {}, 'Optics'),
        sceneOptions(app, 'render', (name) => name !== 'mode' && !SURFACE_ROWS.includes(name)),
        h('h3', {}, 'Picture'),
        background(app),
        linearLight(app),
        device(app),
    );
}
