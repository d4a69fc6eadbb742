/* SPDX-License-Identifier: MIT */
/* Transfer functions from and to ParaView: the file is read here, what it says by the session. */

import { button, h } from './dom.js';
import { select } from './controls.js';
import { ready, watch } from './store.js';

/** The presets in a text, JSON or XML, that have names: each with the text of it alone. [] where there are none. */
export function presetsOf(text) {
    if (/^\s*</.test(text)) {
        const maps = new DOMParser().parseFromString(text, 'text/xml').querySelectorAll('ColorMap[name]');
        return [...maps].map((map) => ({ name: map.getAttribute('name'), text: `<ColorMaps>${map.outerHTML}</ColorMaps>` }));
    }
    try {
        const named = [JSON.parse(text)].flat().filter((preset) => typeof preset?.Name === 'string');
        return named.map((preset) => ({ name: preset.Name, text: JSON.stringify([preset]) }));
    } catch {
        return []; /* the session says in words what is wrong with it */
    }
}

/** Whether a dropped text is a ParaView preset, not a scene. */
export const isPreset = (text) => /^\s*</.test(text) || (/"(RGBPoints|IndexedColors)"/.test(text) && !/"pellucid-scene"/.test(text));

/** Imports the text of a file; of several presets one is asked for, and it alone is sent: there are files of many. */
export function importColors(app, text, file) {
    if (/"pellucid-scene"/.test(text)) {
        app.messages.error(`${file} is a scene, not a colour map: open it in the panel File, or drop it on the picture.`);
        return;
    }
    if (!ready()) {
        app.messages.error(`${file} is a colour map: open a volume first, to which it gives its colours.`);
        return;
    }
    const presets = presetsOf(text);
    if (presets.length < 2) {
        app.sendAbout({ do: 'import', text }, file);
        return;
    }
    const panel = document.getElementById('panel-transfer').querySelector('.presets');
    const choices = [['', `choose one of ${presets.length}`], ...presets.map(({ name }, i) => [i, name])];
    const choose = (i) => i !== '' && app.sendAbout({ do: 'import', text: presets[i].text }, file);
    const choice = select(choices, choose, 'Preset of the file');
    panel.replaceChildren(choice);
    app.showPanel('transfer');
    choice.focus();
    app.messages.tell(`${file} has ${presets.length} presets: choose one in the panel Transfer function.`);
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
