/* SPDX-License-Identifier: MIT */
/* Another file: from the server's folders, or dropped on the page and sent there. */

import { button, bytes, h, icon, short } from './dom.js';
import { select } from './controls.js';
import { get, watch } from './store.js';
import { importColors } from './exchange.js';
import { dropped, plan } from './drop.js';

/** Why an upload was refused, where the server did not say. */
function refusal(status) {
    return status === 413 ? 'it is larger than the server takes' : `the server refused it (${status})`;
}

/** Sends one file, beside those of the folder where one is given: the server's answer, or undefined where it was cancelled. */
function post({ name, file }, folder, progress) {
    return new Promise((resolve, reject) => {
        const request = new XMLHttpRequest();
        request.open('POST', `upload?name=${encodeURIComponent(name)}${folder ? `&folder=${folder}` : ''}`);
        request.responseType = 'json';
        request.upload.onprogress = (event) => progress(event.loaded, () => request.abort());
        request.onloadend = () => {
            if (request.status === 200 && request.response?.path) resolve(request.response);
            else if (request.status) reject(new Error(`${name}: ${request.response?.error ?? refusal(request.status)}`));
            else resolve(undefined);
        };
        request.send(file);
    });
}

/** Sends files into one folder of the server; what it said of the first, or undefined where it was cancelled. */
async function sendAll(app, files) {
    const total = files.reduce((sum, { file }) => sum + file.size, 0),
        caption = files.length > 1 ? `Sending ${files.length} files` : `Sending ${files[0].name}`;
    let done = 0,
        first = undefined,
        cancelled = false;
    for (const each of files) {
        const answer = await post(each, first?.folder, (loaded, abort) =>
            app.progress.show(files, caption, total ? Math.min((done + loaded) / total, 1) : 1, () => {
                cancelled = true;
                abort();
            }),
        );
        if (!answer || cancelled) {
            app.messages.tell(`${files.length > 1 ? 'The files were' : `${each.name} was`} not sent.`);
            return undefined;
        }
        first ??= answer;
        done += each.file.size;
    }
    return first;
}

/** "a, b and 7 more" */
function some(names) {
    return names.length > 3 ? `${names.slice(0, 2).join(', ')} and ${names.length - 2} more` : names.join(', ');
}

/** Volumes and scenes are sent and opened, a ParaView preset becomes the transfer function. */
async function take(app, given) {
    try {
        const { send, whole, preset, left } = await plan(await given);
        if (left.length) app.messages.tell(`Only ${send[0].name} and what it needs are taken; left out: ${some(left)}.`);
        if (preset !== undefined) {
            importColors(app, preset, send[0].name);
            return;
        }
        const first = await sendAll(app, send).finally(() => app.progress.hide(send));
        if (first) app.connection.send({ do: 'open', path: whole ? first.path.slice(0, first.path.lastIndexOf('/')) : first.path });
    } catch (error) {
        app.messages.error(error.message);
    }
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
        take(app, dropped(event.dataTransfer));
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
    const picker = (label, attributes) => {
        const input = h('input', { type: 'file', class: 'hidden', 'aria-label': label, tabindex: '-1', ...attributes });
        input.addEventListener('change', () => {
            if (input.files.length) take(app, [...input.files].map((file) => ({ name: file.name, file })));
            input.value = '';
        });
        return input;
    };
    const files = picker('Files to open', { multiple: true }),
        folder = picker('Folder to open', { webkitdirectory: true });
    let here = undefined;
    /* Of slices, each in a file, the folder is the volume. */
    const whole = button('Open this folder as a volume', () => app.connection.send({ do: 'open', path: here }), {
        kind: 'small',
        title: 'All the slices in it (DICOM, TIFF)',
    });
    whole.hidden = true;
    let newest = 0; /* answers may overtake each other */
    const browse = async (path) => {
        const question = ++newest;
        const found = await app.guard(app.connection.ask({ do: 'list', ...(path ? { path } : {}) }, 'files'));
        if (!found || question !== newest) return;
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
        arrays = h('div', {}),
        heading = h('h3', {}, 'Open a file');
    watch(['volume'], () => {
        const volume = get('volume');
        about.replaceChildren(...facts(volume));
        heading.textContent = 'Open another';
        notes.replaceChildren(...(volume.notes ?? []).map((note) => h('li', {}, note)));
        const names = (volume.arrays ?? []).map(({ name }) => name);
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
        heading,
        h(
            'div',
            { class: 'row' },
            button('From this computer…', () => files.click(), {
                kind: 'small',
                title: 'Or drop it on the picture; a header together with its data',
            }),
            button('A folder…', () => folder.click(), { kind: 'small', title: 'All the slices in it (DICOM, TIFF), from this computer' }),
            files,
            folder,
        ),
        where,
        h('div', { class: 'row' }, whole),
        list,
    );
}
