/* SPDX-License-Identifier: MIT */
/* Several files at once, dropped or chosen: which of them are to be sent, and which one of these is opened. A header goes with its data, a
 * series of slices goes as a whole, and of volumes that have nothing to do with each other the first goes. */

import { isPreset } from './exchange.js';

/* What the server takes together. */
export const MOST_FILES = 4096;
/* Of a file that may hold presets: ParaView's own list of them is 1.5 MB. */
const MOST_TEXT = 2 ** 25;
const HEAD_BYTES = 65536;
/* What is opened, where there is a choice: the least. A scene or header that names others of the files comes before what stands alone. */
const RANK = { scene: 0, header: 1, volume: 2, other: 3, preset: 4 };
const VOLUME = /\.(json|nrrd|nhdr|mha|mhd|nii|hdr|vti|vtk|tiff?|dcm)(\.gz)?$/i;

/** A name of the same folder, without what says so. */
const plain = (name) => name.replace(/^(\.\/+)+/, '');

/** The names between two numbers of a pattern "slice%03d.raw 1 20 2". */
function numbered(pattern) {
    const [, name, from, to, by] = /^(\S.*?)\s+(-?\d+)\s+(-?\d+)(?:\s+(-?\d+))?/.exec(pattern) ?? [];
    if (!name) return [];
    const step = Math.max(Math.abs(Number(by ?? 1)), 1),
        names = [];
    for (let i = Number(from); i <= Number(to) && names.length < MOST_FILES; i += step)
        names.push(name.replace(/%(0?)(\d*)[du]/, (_, zero, width) => String(i).padStart(Number(width), zero || ' ')));
    return names;
}

/** The files that a header (MetaImage, NRRD) names for its samples; [] where they follow in it. */
function namedIn(text) {
    const [head] = text.startsWith('NRRD') ? text.split(/\r?\n\r?\n/) : [text];
    const found = /^(?:ElementDataFile[ \t]*=|data ?file:)[ \t]*(.+?)[ \t]*$/im.exec(head);
    if (!found || found[1] === 'LOCAL') return [];
    const names = /^LIST\b/.test(found[1])
        ? head.slice(found.index + found[0].length).split(/\r?\n/).map((line) => line.trim()).filter(Boolean)
        : found[1].includes('%')
          ? numbered(found[1])
          : [found[1]];
    return names.map(plain);
}

/** What a scene says of its volume, where it names one that may be beside it. */
function volumeOf(text) {
    try {
        const path = JSON.parse(text)?.volume?.path,
            name = typeof path === 'string' ? plain(path) : '/';
        return name.includes('/') ? [] : [name];
    } catch {
        return []; /* the session says in words what is wrong with it */
    }
}

/** Of a file with a name that is plain: what it needs (of each need, the names that would do) and what it is. */
async function look(entry) {
    const { name, file } = entry,
        base = name.replace(/\.gz$/i, '');
    const all = (names) => names.map((one) => [one]);
    if (/\.(json|xml)$/i.test(name) && file.size < MOST_TEXT) {
        const text = await file.text();
        if (isPreset(text)) return { ...entry, needs: [], rank: RANK.preset, text };
        const needs = all(volumeOf(text));
        return { ...entry, needs, rank: needs.length ? RANK.scene : RANK.volume };
    }
    if (/\.(nhdr|nrrd|mhd|mha)$/i.test(name)) {
        const needs = all(namedIn(await file.slice(0, HEAD_BYTES).text()));
        return { ...entry, needs, rank: needs.length ? RANK.header : RANK.volume };
    }
    const pair = (ending) => [['', '.gz'].map((gz) => base.slice(0, -4) + ending + gz)];
    if (/\.hdr$/i.test(base)) return { ...entry, needs: pair('.img'), rank: RANK.header };
    if (/\.img$/i.test(base)) return { ...entry, needs: [], header: pair('.hdr')[0], rank: RANK.other };
    return { ...entry, needs: [], rank: VOLUME.test(name) ? RANK.volume : RANK.other };
}

/** Is it one of a series? By its name, or by DICOM's sign: scanners write files without an ending. */
async function isSlice({ name, file }) {
    if (/\.(dcm|ima|tiff?)$/i.test(name)) return true;
    if (VOLUME.test(name) || (name.includes('.') && !/^[\d.]+$/.test(name))) return false;
    return (await file.slice(128, 132).text()) === 'DICM';
}

/** Those of a series under names of their own: in the folders of a study they begin anew. */
function renamed(slices) {
    const taken = new Set();
    return slices.map(({ name, file }) => {
        let own = name;
        for (let i = 2; taken.has(own); i++) own = `${i}-${name}`;
        taken.add(own);
        return { name: own, file };
    });
}

/** `first` and what it needs, and what that needs. */
function withNeeds(first, byName) {
    const chosen = new Set([first]);
    for (const entry of chosen)
        for (const names of entry.needs) {
            const found = names.map((name) => byName.get(name)).find(Boolean);
            if (found) chosen.add(found);
            else if (names[0].includes('/'))
                throw new Error(`${entry.name} keeps its data in another folder (${names[0]}): open it from the server’s folders.`);
            else throw new Error(`${entry.name} needs its data file ${names[0]}; drop both together.`);
        }
    return [...chosen];
}

/**
 * What to do with files that came together.
 * @param {{name, file}[]} given
 * @returns {{send: {name, file}[], whole: boolean, preset: string|undefined, left: string[]}}  the first of `send` is to be opened, or, where
 * `whole`, the folder that they are in; `preset`: the text of the first, which is a colour map, and nothing is to be sent
 */
export async function plan(given) {
    const files = given.filter(({ name }) => !name.startsWith('.'));
    if (files.length > MOST_FILES) throw new Error(`These are more than ${MOST_FILES} files: open them from the server’s folders.`);
    if (!files.length) throw new Error('There is no file in what was dropped.');
    const entries = [];
    for (const entry of files) entries.push(await look(entry));
    const byName = new Map(entries.map((entry) => [entry.name, entry]));
    const needed = new Set(entries.flatMap(({ needs }) => needs.flat()));
    const free = entries.filter(({ name }) => !needed.has(name));
    const rank = Math.min(...free.map((entry) => entry.rank));
    const first = free.find((entry) => entry.rank === rank) ?? entries[0];
    const rest = (send) => entries.filter(({ file }) => !send.some((sent) => sent.file === file)).map(({ name }) => name);
    if (rank >= RANK.volume) {
        const slices = [];
        for (const entry of entries) if (await isSlice(entry)) slices.push(entry);
        if (slices.length > 1) return { send: renamed(slices), whole: true, left: [] };
    }
    if (first.header) throw new Error(`${first.name} needs its header ${first.header[0]}; drop both together.`);
    const send = first.text === undefined ? withNeeds(first, byName) : [first];
    return { send, whole: false, preset: first.text, left: rest(send) };
}

/* ---- what was dropped ---- */

const read = (directory) => new Promise((done, failed) => directory.readEntries(done, failed));
const fileOf = (entry) => new Promise((done, failed) => entry.file(done, failed));

/** The files of a drop, those in its folders, too; to be called while the event is handled, or the browser forgets them. */
export async function dropped(transfer) {
    const items = [...transfer.items].filter(({ kind }) => kind === 'file');
    const waiting = items.map((item) => ({ entry: item.webkitGetAsEntry?.(), file: item.getAsFile() }));
    const files = [];
    for (const { entry, file } of waiting) {
        if (files.length > MOST_FILES) break;
        if (!entry?.isDirectory) {
            const found = file ?? (await fileOf(entry));
            files.push({ name: found.name, file: found });
            continue;
        }
        const reader = entry.createReader(); /* it gives them a hundred at a time */
        for (let some = await read(reader); some.length && waiting.length < 4 * MOST_FILES; some = await read(reader))
            waiting.push(...some.map((one) => ({ entry: one })));
    }
    return files;
}
