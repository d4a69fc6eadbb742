/* SPDX-License-Identifier: MIT */
/* Mode, technique, optics, background: all controls but the background's come from the option tables. */

import { button, field, h, hex } from './dom.js';
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

function techniqueSection(app) {
    const box = h('div', { class: 'stack' });
    let shown = null,
        list = null,
        choice = null,
        summary = null;
    watch(['hello', 'scene'], () => {
        const { techniques } = get('hello') ?? {},
            technique = get('scene')?.technique;
        if (!techniques || !technique) return;
        if (technique.name !== shown || !choice) {
            shown = technique.name;
            const found = techniques.find(({ name }) => name === shown);
            choice = select(
                techniques.map(({ name }) => name),
                (name) => app.edits.apply({ technique: { name, options: {} } }),
                'Technique',
            );
            choice.update(shown);
            summary = h('p', { class: 'hint' }, found?.summary ?? '');
            list = optionList(
                found?.options ?? [],
                (scene) => scene?.technique?.options,
                (name, value, phase) =>
                    app.edits.apply({ technique: { name: shown, options: { ...get('scene').technique.options, [name]: value } } }, phase),
            );
            box.replaceChildren(field('Technique', choice, { help: 'How the picture is computed' }), summary, list);
        }
        list.update();
    });
    return box;
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
            swatch.addEventListener('click', () =>
                app.edits.apply({ background: [...[1, 3, 5].map((i) => parseInt(value.slice(i, i + 2), 16) / 255), 1] }),
            );
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
    const place = h('div', {});
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
        const choice = select(
            devices.map((d) => [d.id, deviceName(d)]),
            (id) => {
                app.connection.send({ do: 'device', device: id });
                choice.update(now.id); /* until the server says that it draws */
            },
            'Device',
        );
        choice.update(now.id);
        place.replaceChildren(
            devices.length > 1
                ? field('Device', choice, { help: 'What draws' })
                : h('div', { class: 'field' }, h('span', { class: 'label' }, 'Device'), h('span', { class: 'value' }, deviceName(now))),
        );
    });
    return [field('Resolution', resolution, { help: 'Of the picture at rest; under the moving hand it follows the time budget' }), place];
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
