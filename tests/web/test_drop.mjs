/* SPDX-License-Identifier: MIT */
/* Files that are dropped or chosen together, by the browser's own drop: a header with its data, slices, a folder of them, and what does not
 * belong together. */

import { existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Face, assert, equal, launch, mainWithoutComplaints, test, view } from './harness.mjs';

const browser = await launch();
const folder = mkdtempSync(path.join(os.tmpdir(), 'pellucid-web-'));
process.env.TMPDIR = path.join(folder, 'temporary');
mkdirSync(process.env.TMPDIR);

function write(name, ...parts) {
    const file = path.join(folder, name);
    mkdirSync(path.dirname(file), { recursive: true });
    writeFileSync(file, Buffer.concat(parts.map((part) => Buffer.from(part))));
    return file;
}

/** A ramp of 8-bit samples. */
const ramp = ([x, y, z]) => Buffer.from(Array.from({ length: x * y * z }, (_, i) => (i * 37) % 251));
const nrrd = ([x, y, z], ...fields) =>
    ['NRRD0004', 'type: uint8', 'dimension: 3', `sizes: ${x} ${y} ${z}`, 'encoding: raw', ...fields, ''].join('\n');
const meta = ([x, y, z], data) => `ObjectType = Image\nNDims = 3\nDimSize = ${x} ${y} ${z}\nElementType = MET_UCHAR\nElementDataFile = ${data}\n`;

function analyze([x, y, z]) {
    const header = Buffer.alloc(348);
    header.writeInt32LE(348, 0);
    [3, x, y, z, 1, 1, 1, 1].forEach((size, i) => header.writeInt16LE(size, 40 + 2 * i));
    header.writeInt16LE(2, 70); /* 8 bits without a sign */
    header.writeInt16LE(8, 72);
    for (let i = 0; i < 4; i++) header.writeFloatLE(1, 76 + 4 * i);
    return header;
}

/** A slice of 4 x 3 samples at a height, as a scanner would write it: explicit, little-endian. */
function dicom(height) {
    const tag = (group, element, kind, value) => {
        const even = value.length % 2 ? Buffer.concat([value, Buffer.from(kind === 'UI' ? '\0' : ' ')]) : value;
        const head = Buffer.alloc(kind === 'OB' ? 12 : 8);
        head.writeUInt16LE(group, 0);
        head.writeUInt16LE(element, 2);
        head.write(kind, 4, 'latin1');
        if (kind === 'OB') head.writeUInt32LE(even.length, 8);
        else head.writeUInt16LE(even.length, 6);
        return Buffer.concat([head, even]);
    };
    const text = (group, element, kind, value) => tag(group, element, kind, Buffer.from(value));
    const short = (element, value) => tag(0x28, element, 'US', Buffer.from([value & 255, value >> 8]));
    return Buffer.concat([
        Buffer.alloc(128),
        Buffer.from('DICM'),
        text(2, 0x10, 'UI', '1.2.840.10008.1.2.1'),
        text(0x20, 0x0e, 'UI', '1.2.3'),
        text(0x20, 0x32, 'DS', `0\\0\\${height}`),
        text(0x20, 0x37, 'DS', '1\\0\\0\\0\\1\\0'),
        short(2, 1),
        text(0x28, 4, 'CS', 'MONOCHROME2'),
        short(0x10, 3),
        short(0x11, 4),
        text(0x28, 0x30, 'DS', '1\\1'),
        ...[8, 8, 7, 0].map((value, i) => short(0x100 + i, value)),
        tag(0x7fe0, 0x10, 'OB', ramp([4, 3, height + 1]).subarray(-12)),
    ]);
}

const start = write('start.nrrd', nrrd([5, 5, 5]), '\n', ramp([5, 5, 5]));
const server = await view(start, '--max-upload', '2');
const face = await Face.open(browser, server.address, { viewport: { width: 1000, height: 640 } });
const { page } = face;
const hand = await page.context().newCDPSession(page);

/** Drops files and folders from the disk, as the system's own file manager would. */
async function drop(...files) {
    for (const type of ['dragEnter', 'dragOver', 'drop'])
        await hand.send('Input.dispatchDragEvent', { type, x: 300, y: 300, data: { items: [], files, dragOperationsMask: 1 } });
}

const told = (text) => page.waitForSelector(`.message:has-text("${text}")`, { timeout: 60000 });
/** Until a volume is shown, by the name and the numbers of samples at the top. */
const shown = (name, dims) =>
    page.waitForFunction(
        ([a, b]) => document.querySelector('#name').textContent === a && document.querySelector('#dims').textContent.startsWith(b),
        [name, dims.join(' × ')],
        { timeout: 60000 },
    );
/** The folders that the server has. */
function folders() {
    const [own] = readdirSync(process.env.TMPDIR).filter((name) => /^pellucid-view-\w{6}$/.test(name));
    return own ? readdirSync(path.join(process.env.TMPDIR, own)).map((name) => path.join(process.env.TMPDIR, own, name)) : [];
}
const opens = () => face.count('open');

test('a header and its data are opened, in whichever order', async () => {
    const data = write('pair.raw', ramp([6, 5, 4]));
    await drop(data, write('pair.nhdr', nrrd([6, 5, 4], 'data file: pair.raw')));
    await shown('pair.nhdr', [6, 5, 4]);
    await drop(write('pair.mhd', meta([4, 5, 6], 'pair.raw')), data);
    await shown('pair.mhd', [4, 5, 6]);
    await drop(data, write('here.nhdr', nrrd([5, 6, 4], 'data file: ./pair.raw')));
    await shown('here.nhdr', [5, 6, 4]);
    await drop(write('brain.img', ramp([7, 4, 3])), write('brain.hdr', analyze([7, 4, 3])));
    await shown('brain.hdr', [7, 4, 3]);
    await face.rest();
});

test('a header with many data files takes all of them', async () => {
    const pieces = [1, 2, 3].map((i) => write(`piece${i}.raw`, ramp([6, 5, i]).subarray(-30)));
    await drop(write('list.mhd', meta([6, 5, 3], 'LIST\npiece1.raw\npiece2.raw\npiece3.raw')), ...pieces);
    await shown('list.mhd', [6, 5, 3]);
    await drop(...pieces, write('numbered.nhdr', nrrd([5, 6, 3], 'data file: piece%d.raw 1 3 1')));
    await shown('numbered.nhdr', [5, 6, 3]);
});

test('what is missing is named', async () => {
    const before = opens();
    await drop(path.join(folder, 'pair.nhdr'));
    await told('pair.nhdr needs its data file pair.raw; drop both together.');
    await drop(path.join(folder, 'brain.hdr'));
    await told('brain.hdr needs its data file brain.img; drop both together.');
    await drop(path.join(folder, 'brain.img'));
    await told('brain.img needs its header brain.hdr; drop both together.');
    await drop(write('far.mhd', meta([6, 5, 4], 'data/pair.raw')));
    await told('far.mhd keeps its data in another folder (data/pair.raw)');
    await drop(path.join(folder, 'numbered.nhdr'), path.join(folder, 'piece1.raw'));
    await told('numbered.nhdr needs its data file piece2.raw');
    equal(opens(), before, 'files opened');
});

test('slices are opened as a volume, with progress', async () => {
    const slices = Array.from({ length: 120 }, (_, i) => write(`study/deep/IM${String(i).padStart(4, '0')}`, dicom(i)));
    write('study/notes.txt', 'what a folder holds beside');
    write('study/.hidden', 'and what nobody sees');
    await drop(...slices.slice(0, 9));
    await shown('slices', [4, 3, 9]);
    await page.evaluate(() => {
        window.progress = [];
        new MutationObserver(() => window.progress.push(document.querySelector('#progress').textContent)).observe(
            document.querySelector('#progress'),
            { childList: true, subtree: true, characterData: true },
        );
    });
    await drop(path.join(folder, 'study'));
    await shown('slices', [4, 3, 120]);
    const words = await page.evaluate(() => window.progress.join());
    assert(words.includes('Sending 120 files'), `the progress said ${words}`);
    await page.waitForSelector('#progress', { state: 'hidden', timeout: 60000 });
});

test('slices of one name in two folders are all taken', async () => {
    for (let i = 0; i < 6; i++) write(`two/${i % 2}/IM${i >> 1}`, dicom(i));
    await drop(path.join(folder, 'two'));
    await shown('slices', [4, 3, 6]);
});

test('of files that have nothing to do with each other the first is opened, and the page says so', async () => {
    const other = write('other.nrrd', nrrd([6, 6, 6]), '\n', ramp([6, 6, 6]));
    await drop(write('readme.txt', 'words'), other, start, write('red.json', '[{"Name": "red", "RGBPoints": [0, 0, 0, 0, 1, 1, 0, 0]}]'));
    await shown('other.nrrd', [6, 6, 6]);
    await told('Only other.nrrd and what it needs are taken; left out: readme.txt, start.nrrd, red.json.');
    const [newest] = folders().sort((a, b) => Number(path.basename(b)) - Number(path.basename(a)));
    equal(readdirSync(newest).join(), 'other.nrrd', 'what was sent');
});

test('a scene is dropped with its volume', async () => {
    const scene = JSON.stringify({ 'pellucid-scene': 1, volume: { path: 'other.nrrd' }, render: { mode: 'mip' } });
    await drop(path.join(folder, 'other.nrrd'), write('with.json', scene));
    await face.until(() => face.scene.render.mode === 'mip', 'the scene');
    await shown('other.nrrd', [6, 6, 6]);
});

test('too much is refused in words', async () => {
    const before = opens();
    const large = write('large.raw', Buffer.alloc(2000000));
    await drop(write('large.mhd', meta([200, 100, 100], 'large.raw')), large);
    await told('large.raw: the files sent together are larger than 2 MB');
    for (let i = 0; i < 4100; i++) write(`many/${i}.dcm`, 'x');
    await drop(path.join(folder, 'many'));
    await told('more than 4096 files');
    mkdirSync(path.join(folder, 'empty'));
    await drop(path.join(folder, 'empty'));
    await told('There is no file in what was dropped.');
    equal(opens(), before, 'files opened');
});

test('the panel’s buttons take several files, and a folder', async () => {
    if (await page.locator('#panel-file').isHidden()) await page.click('#open-file');
    const choose = async (button, files) => {
        const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.click(`#panel-file button:has-text("${button}")`)]);
        await chooser.setFiles(files);
    };
    await choose('From this computer', ['pair.raw', 'pair.nhdr'].map((name) => path.join(folder, name)));
    await shown('pair.nhdr', [6, 5, 4]);
    await choose('A folder', path.join(folder, 'two'));
    await shown('slices', [4, 3, 6]);
});

test('what was dropped is listed by the names that it had, and opened again', async () => {
    await page.click('#open-file');
    await page.click('#open-file');
    await page.click('.file:has-text("pair.nhdr") >> nth=0');
    await shown('pair.nhdr', [6, 5, 4]);
    equal(await page.locator('.file:has-text("pair.raw")').count(), 0, 'data files in the list');
    await page.click('#open-file');
    await page.click('#open-file');
    await page.click('.file:has-text("2-IM0 and 5 more") >> nth=-1');
    await page.click('button:has-text("Open this folder as a volume")');
    await shown('slices', [4, 3, 6]);
});

test('nothing of it is left behind', async () => {
    assert(folders().length > 0, 'files are kept while the viewer runs');
    equal(await server.stop(), 0, 'the end of the viewer');
    assert(existsSync(process.env.TMPDIR), 'the folder of the test');
    equal(readdirSync(process.env.TMPDIR).filter((name) => name.startsWith('pellucid-view')).join(), '', 'what is left');
    /* what was refused above; and its requests to a server that is going, or gone */
    face.complaints = face.complaints.filter((text) => !/WebSocket|net::ERR_(CONNECTION_|EMPTY_RESPONSE)|status of 413/.test(text));
    rmSync(path.join(folder, 'many'), { recursive: true });
});

await mainWithoutComplaints(face, browser, server, folder);
