/* SPDX-License-Identifier: MIT */
/* Transfer functions from and to ParaView: the file is read here, what it says by the session. */

import { button, h } from './dom.js';
import { select } from './controls.js';
import { watch } from './store.js';

/** Names of the presets in a text, JSON or XML; [] where they have none. */
export function presetNames(text) {
    if (/^\s*</.test(text)) {
        const maps = new DOMParser().parseFromString(text, 'text/xml').querySelectorAll('ColorMap');
        return [...maps].map((map) => map.getAttribute('name')).filter(Boolean);
    }
    try {
        const found = [JSON.parse(text)].flat();
        return found.map((preset) => preset?.Name).filter((name) => typeof name === 'string');
    } catch {
        return []; /* the session says in words what is wrong with it */
    }
}

/** Whether a dropped text is a ParaView preset, not a scene. */
export const isPreset = (text) => /^\s*</.test(text) || /"(RGBPoints|IndexedColors)"/.test(text);

/** Imports the text of a file; of several presets one is asked for. */
export function importColors(app, text, file) {
    const names = presetNames(text);
    if (names.length < 2) {
        app.sendAbout({ do: 'import', text }, file);
        return;
    }
    const panel = document.getElementById('panel-transfer').querySelector('.presets');
    const choices = [['', `choose one of ${names.length}`], ...names.map((name) => [name, name])];
    const choice = select(choices, (name) => name && app.sendAbout({ do: 'import', text, name }, file), 'Preset of the file');
    panel.replaceChildren(choice);
    app.showPanel('transfer');
    choice.focus();
    app.messages.tell(`${file} has ${names.length} presets: choose one in the panel Transfer function.`);
}

/** The buttons in the panel. */
export function exchange(app) {
    const picker = h('input', {
        type: 'file',
        accept: '.json,.xml',
        class: 'hidden',
        'aria-label': 'ParaView colour map to import',
        tabindex: '-1',
    });
    picker.addEventListener('change', async () => {
        const [file] = picker.files;
        if (file) importColors(app, await file.text(), file.name);
        picker.value = '';
    });
    const presets = h('div', { class: 'presets' });
    watch(['volume'], () => presets.replaceChildren());
    return h(
        'div',
        { class: 'stack' },
        h(
            'div',
            { class: 'row' },
            button('Import…', () => picker.click(), { kind: 'small', title: 'A ParaView colour map: JSON or XML' }),
            button('Export', () => app.download({ do: 'export' }), {
                kind: 'small',
                title: 'The transfer function as a ParaView preset (JSON)',
            }),
            picker,
        ),
        presets,
    );
}
