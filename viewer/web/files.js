/* SPDX-License-Identifier: MIT */
/* Another file: from the server's folders, or dropped on the page and sent there. */

import { button, bytes, h, icon, short } from './dom.js';
import { select } from './controls.js';
import { get, watch } from './store.js';
import { importColors, isPreset } from './exchange.js';

/* Of a file that may hold presets: ParaView's own list of them is 1.5 MB. */
const MOST_TEXT = 2 ** 25;

/** Why an upload was refused, where the server did not say. */
function refusal(status) {
    return status === 413 ? 'it is larger than the server takes' : `the server refused it (${status})`;
}

/** Sends a file to the server and opens it; told as it goes. */
function upload(app, file) {
    const request = new XMLHttpRequest();
    request.open('POST', `upload?name=${encodeURIComponent(file.name)}`);
    request.responseType = 'json';
    request.upload.onprogress = (event) =>
        event.lengthComputable && app.progress.show(`Sending ${file.name}`, event.loaded / event.total, () => request.abort());
    request.onloadend = () => {
        app.progress.hide();
        if (request.status === 200 && request.response?.path) app.connection.send({ do: 'open', path: request.response.path });
        else if (request.status)
            app.messages.error(`${file.name}: ${request.response?.error ?? refusal(request.status)}`);
        else app.messages.tell(`${file.name} was not sent.`);
    };
    request.send(file);
}

/** The file that a header (MetaImage, NRRD) names for its samples, or undefined where they follow in it. */
function dataFile(text) {
    const name = /^(?:ElementDataFile\s*=|data ?file:)\s*(.+?)\s*$/im.exec(text)?.[1];
    return name === 'LOCAL' ? undefined : name;
}

/** A volume or scene is sent and opened, a ParaView preset becomes the transfer function. */
async function take(app, file) {
    const small = /\.(json|xml)$/i.test(file.name) && file.size < MOST_TEXT;
    const text = small ? await file.text() : '';
    const apart = /\.(mhd|nhdr)$/i.test(file.name) && dataFile(await file.slice(0, 65536).text());
    if (apart)
        app.messages.error(
            `${file.name} keeps its samples in another file, ${apart}, which a page cannot fetch. ` +
                'Open it from the server’s folders: “pellucid view” takes a folder, too.',
        );
    else if (small && isPreset(text)) importColors(app, text, file.name);
    else upload(app, file);
}

/** Files dropped anywhere on the page. */
export function acceptDrops(app, sign) {
    const files = (event) => [...(event.dataTransfer?.types ?? [])].includes('Files');
    let depth = 0;
    addEventListener('dragenter', (event) => files(event) && (depth++, (sign.hidden = false)));
    addEventListener('dragleave', (event) => files(event) && --depth <= 0 && (sign.hidden = true));
    addEventListener('dragover', (event) => files(event) && event.preventDefault());
    addEventListener('drop', (event) => {
        depth = 0;
        sign.hidden = true;
        if (!files(event)) return;
        event.preventDefault();
        if (event.dataTransfer.files.length > 1)
            app.messages.tell(
                'One file at a time: the first is opened. Of a pair (header and data) open the header from the server’s folders.',
            );
        take(app, event.dataTransfer.files[0]);
    });
}

function facts(volume) {
    const rows = [
        ['Name', volume.name || '–'],
        ['Samples', `${volume.dims.join(' × ')}, ${volume.type}`],
        ['Spacing', `${volume.spacing.map((x) => short(x)).join(' × ')} ${volume.units ?? ''}`],
        ['Values', volume.range.map((x) => short(x)).join(' to ')],
        ['Axes', volume.space === 'unknown' || !volume.space ? 'meaning not known' : volume.space],
    ];
    return rows.flatMap(([name, text]) => [h('dt', {}, name), h('dd', {}, text)]);
}

export function filesPanel(app) {
    const list = h('ul', { class: 'files' }),
        where = h('div', { class: 'path' });
    const picker = h('input', { type: 'file', class: 'hidden', 'aria-label': 'File to open', tabindex: '-1' });
    picker.addEventListener('change', () => {
        if (picker.files[0]) take(app, picker.files[0]);
        picker.value = '';
    });
    let here = undefined;
    /* Of slices, each in a file, the folder is the volume. */
    const whole = button('Open this folder as a volume', () => app.connection.send({ do: 'open', path: here }), {
        kind: 'small',
        title: 'All the slices in it (DICOM, TIFF)',
    });
    whole.hidden = true;
    const browse = async (path) => {
        const found = await app.guard(app.connection.ask({ do: 'list', ...(path ? { path } : {}) }, 'files'));
        if (!found) return;
        here = path;
        where.textContent = found.path ?? 'Folders of the server';
        whole.hidden = !found.series;
        const up = found.path ? [{ name: '..', path: found.parent, folder: true }] : [];
        list.replaceChildren(
            ...[...up, ...found.entries].map((entry) =>
                h(
                    'li',
                    {},
                    h(
                        'button',
                        {
                            type: 'button',
                            class: 'file',
                            title: entry.path ?? '',
                            onclick: () =>
                                entry.folder ? browse(entry.path) : app.connection.send({ do: 'open', path: entry.path }),
                        },
                        icon(entry.folder ? 'folder' : 'surface'),
                        h('span', { class: 'grow' }, entry.name),
                        entry.folder || !entry.bytes ? null : h('span', { class: 'small-text' }, bytes(entry.bytes)),
                    ),
                ),
            ),
        );
        if (!found.entries.length) list.append(h('li', { class: 'hint' }, 'Nothing here that can be opened.'));
    };
    /* Listed again each time that the panel is opened, and when the connection came back: files come and go. */
    watch(['panel', 'link'], () => get('panel') === 'file' && get('link')?.state === 'open' && browse(here));
    const about = h('dl', { class: 'facts' }),
        notes = h('ul', { class: 'notes' }),
        arrays = h('div', {});
    watch(['volume'], () => {
        const volume = get('volume');
        about.replaceChildren(...facts(volume));
        notes.replaceChildren(...(volume.notes ?? []).map((note) => h('li', {}, note)));
        const names = (volume.arrays ?? []).map((a) => a.name ?? a);
        const choice = select(names, (array) => app.connection.send({ do: 'open', path: volume.path, array }), 'Array');
        choice.update(volume.array || volume.name);
        arrays.replaceChildren(...(names.length > 1 ? [choice] : []));
    });
    return h(
        'div',
        { class: 'stack' },
        about,
        arrays,
        notes,
        h('h3', {}, 'Open another'),
        h(
            'div',
            { class: 'row' },
            button('From this computer…', () => picker.click(), { kind: 'small', title: 'Or drop a file on the picture' }),
            picker,
        ),
        where,
        h('div', { class: 'row' }, whole),
        list,
    );
}
