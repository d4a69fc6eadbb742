/* SPDX-License-Identifier: MIT */
/* What the panels do, on a small volume: slices with zoom and pan, planes, isovalues, dropped files, the server's folder, what is saved. */

import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Face, assert, equal, launch, mainWithoutComplaints, pellucid, test, view } from './harness.mjs';

const browser = await launch();
const folder = mkdtempSync(path.join(os.tmpdir(), 'pellucid-web-'));
const file = path.join(folder, 'orbital.nrrd');
const made = spawnSync(pellucid, ['make', 'hydrogen', '-o', file, '--size', '40'], { encoding: 'utf8' });
assert(made.status === 0, made.stderr);
copyFileSync(file, path.join(folder, 'second.nrrd'));
const server = await view(file, folder);
const face = await Face.open(browser, server.address, { viewport: { width: 1000, height: 640 } });
const { page } = face;

async function open(name) {
    if (await page.locator(`#panel-${name}`).isHidden()) await page.click(`#open-${name}`);
}

/** Drops a file with a text on the page. */
function drop(name, text) {
    return page.evaluate(
        ([title, content]) => {
            const dataTransfer = new DataTransfer();
            dataTransfer.items.add(new File([content], title));
            for (const kind of ['dragenter', 'dragover', 'drop'])
                document.body.dispatchEvent(new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true }));
        },
        [name, text],
    );
}

/** What a click on something saves. */
async function saved(selector) {
    const [download] = await Promise.all([page.waitForEvent('download', { timeout: 120000 }), page.click(selector)]);
    return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

/** What a ZIP archive of stored files holds, by its directory at the end. */
function readZip(bytes) {
    const files = {};
    let at = bytes.readUInt32LE(bytes.length - 6);
    for (let left = bytes.readUInt16LE(bytes.length - 12); left > 0; left--) {
        equal(bytes.readUInt32LE(at), 0x02014b50, 'the mark of an entry');
        const [length, extra, comment] = [28, 30, 32].map((i) => bytes.readUInt16LE(at + i));
        const start = bytes.readUInt32LE(at + 42);
        const data = start + 30 + bytes.readUInt16LE(start + 26) + bytes.readUInt16LE(start + 28);
        files[bytes.subarray(at + 46, at + 46 + length).toString()] = bytes.subarray(data, data + bytes.readUInt32LE(at + 24));
        at += 46 + length + extra + comment;
    }
    return files;
}

/** Waits for a message in words. */
const told = (text) => page.waitForSelector(`.message:has-text("${text}")`, { timeout: 60000 });

/** The newest frame of a slice. */
const slice = (axis) => face.frames.filter(({ header }) => header.view === `slice-${axis}`).at(-1)?.header.camera;

test('the status line says when the picture is at rest', async () => {
    await face.rest();
    await page.waitForSelector('.status-quality:text-is("at rest")', { timeout: 60000 });
});

test('a picture of nothing is told in words, once', async () => {
    const opacities = face.scene.transfer.opacities.map(([value]) => [value, 0]);
    await face.send({ do: 'set', scene: { transfer: { opacities } } });
    await page.waitForSelector('.message:has-text("There is nothing to be seen in the picture")', { timeout: 60000 });
    assert((await face.rest()).header.empty, 'the frame does not say so');
    await face.send({ do: 'undo' });
    await face.until(() => face.scene.transfer.opacities.some(([, opacity]) => opacity > 0), 'the opacities');
    assert(!(await face.rest()).header.empty, 'the frame says so still');
});

test('a slice is zoomed, panned, made large and whole again', async () => {
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
    await face.until(() => slice('k'), 'the slices');
    const whole = slice('k')['parallel-scale'],
        other = slice('i')['parallel-scale'],
        [x, y] = await face.middle('.slice >> nth=2');
    await page.mouse.move(x + 20, y + 10);
    await page.keyboard.down('Control');
    await page.mouse.wheel(0, -300);
    await page.keyboard.up('Control');
    await face.until(() => slice('k')['parallel-scale'] < whole * 0.7, 'the slice to come nearer');
    equal(slice('i')['parallel-scale'], other, 'the other slices keep their zoom');
    const centre = slice('k')['camera-focal-point'].join();
    await face.drag([x, y], [x + 30, y + 20], { button: 'middle', steps: 4 });
    await face.until(() => slice('k')['camera-focal-point'].join() !== centre, 'the slice to be panned');
    await page.mouse.dblclick(x, y);
    await face.until(() => face.lastSent('slices').size[0] > 500, 'the slice to be large');
    await page.keyboard.press('Enter');
    await face.until(() => face.lastSent('slices').size[0] < 500, 'the four pictures');
    await page.keyboard.press('0');
    await face.until(() => Math.abs(slice('k')['parallel-scale'] / whole - 1) < 1e-6, 'the whole slice');
});

test('the probe tells what is under the pointer in a slice, clicks measure there', async () => {
    const [x, y] = await face.middle('.slice >> nth=2');
    await page.mouse.move(x + 8, y + 8);
    await page.waitForFunction(() => /value \S+ +voxel \d+/.test(document.querySelector('.status-cursor').textContent), null, {
        timeout: 60000,
    });
    await page.keyboard.press('m');
    const box = await page.locator('.slice >> nth=2').boundingBox();
    for (const part of [0.35, 0.65]) await page.mouse.click(box.x + box.width * part, y);
    await page.keyboard.press('Escape');
    await page.waitForSelector('.slice .measures text', { state: 'attached', timeout: 60000 });
    const { 'parallel-scale': half } = slice('k'),
        expected = 0.3 * box.width * ((2 * half) / box.height);
    const words = await page.locator('.slice .measures text').first().textContent();
    assert(Math.abs(parseFloat(words) / expected - 1) < 0.03, `the distance is ${words}, not ${expected}`);
});

test('two fingers zoom a slice and leave the cross-hair', async () => {
    const phone = await Face.open(browser, server.address, { viewport: { width: 390, height: 700 }, hasTouch: true, isMobile: true });
    await phone.page.keyboard.press('s');
    await phone.until(() => phone.frames.some(({ header }) => header.view === 'slice-k'), 'the slices');
    const { at } = phone.lastSent('slices'),
        [x, y] = await phone.middle('.slice >> nth=2'),
        client = await phone.page.context().newCDPSession(phone.page);
    const touch = (type, ...points) =>
        client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
    await touch('touchStart', [x - 20, y - 20]);
    await touch('touchStart', [x - 20, y - 20], [x + 20, y + 20]);
    for (let i = 1; i <= 5; i++) await touch('touchMove', [x - 20 - 6 * i, y - 20 - 6 * i], [x + 20 + 6 * i, y + 20 + 6 * i]);
    await touch('touchEnd');
    await phone.until(() => phone.lastSent('slices').views?.[2]?.scale > 0, 'the slice to come nearer');
    const text = (place) => place.map((v) => v.toFixed(6)).join();
    equal(text(phone.lastSent('slices').at), text(at), 'the cross-hair');
    await phone.page.keyboard.press('s');
    await phone.close();
});

test('planes of the mode slice: at the cross-hair, moved by a handle, undone', async () => {
    await page.click('#panel-slices button:has-text("Draw planes")');
    await page.click('#panel-slices button:has-text("At the cross-hair")');
    await face.until(() => face.scene.render.mode === 'slice' && face.scene.slice.length === 3, 'three planes');
    const before = JSON.stringify(face.scene.slice);
    const [x, y] = await face.middle('[data-handle="plane"] >> nth=2');
    await face.drag([x, y], [x, y + 25], { steps: 4, pause: 16 });
    await face.until(() => JSON.stringify(face.scene.slice) !== before, 'the plane to move');
    equal(JSON.stringify(face.scene.slice[0]), JSON.stringify(JSON.parse(before)[0]), 'the other planes');
    await page.click('#undo');
    await face.until(() => JSON.stringify(face.scene.slice) === before, 'the undo');
    await page.click('#panel-slices [aria-label="Show three slices"]');
});

test('an isovalue is a line on the histogram that can be dragged', async () => {
    await open('surfaces');
    await page.click('#panel-surfaces button:has-text("Add")');
    await face.until(() => face.scene.render.mode === 'isosurface' && face.scene.isosurfaces.length === 1, 'a surface');
    const before = await face.rest(),
        value = face.scene.isosurfaces[0].value;
    await open('transfer');
    const [x, y] = await face.middle('g.isosurfaces path');
    await face.drag([x, y], [x + 40, y], { steps: 4, pause: 16 });
    await face.until(() => face.scene.isosurfaces[0].value > value, 'the isovalue to grow');
    assert((await face.rest()).hash !== before.hash, 'the surface is the same');
});

test('a clip plane faces the eye and goes again', async () => {
    await open('clip');
    await page.click('#panel-clip button:has-text("Facing me")');
    await face.until(() => face.scene['clip-planes'].length === 1, 'the plane');
    await page.click('#panel-clip .card [title="Remove this plane"]');
    await face.until(() => face.scene['clip-planes'].length === 0, 'the plane to go');
});

test('what is dropped is taken, or refused in words', async () => {
    const presets = ['red', 'blue'].map((Name, i) => ({ Name, RGBPoints: [0, 0, 0, 0, 1, 1 - i, 0, i] }));
    await drop('two.json', JSON.stringify(presets));
    await page.selectOption('.presets select', 'blue');
    await face.until(() => face.scene.transfer.colors.at(-1).slice(1).join() === '0,0,1', 'the preset');
    await drop('broken.json', '{"RGBPoints": [0, ');
    await told('broken.json: ');
    await drop('noise.nrrd', 'NRRD0004\ntype: what\n');
    await told('noise.nrrd');
    await drop('pair.mhd', 'ObjectType = Image\nElementDataFile = pair.raw\n');
    await told('pair.mhd needs its data file pair.raw; drop both together.');
    const words = await page.locator('.message').allTextContents();
    equal(words.filter((text) => text.includes(os.tmpdir())).join('\n'), '', 'messages that name the server’s folders');
});

test('a scene is saved, dropped, and is the same', async () => {
    await open('save');
    const { name, bytes } = await saved('#panel-save button:has-text("Save scene")');
    const before = JSON.stringify(face.scene.transfer);
    await page.keyboard.press('Control+z');
    await face.until(() => JSON.stringify(face.scene.transfer) !== before, 'something else');
    await drop(name, bytes.toString('utf8'));
    await face.until(() => JSON.stringify(face.scene.transfer) === before, 'the scene');
});

test('a turntable is drawn, with progress', async () => {
    await open('save');
    await page.selectOption('#panel-save select', 'own');
    for (const [label, value] of Object.entries({ Width: '96', Height: '64', Frames: '6' })) {
        await page.fill(`#panel-save [aria-label="${label}"]`, value);
        await page.keyboard.press('Tab');
    }
    const { bytes } = await saved('#panel-save button:has-text("Save movie")');
    equal(bytes.subarray(0, 4).toString() + bytes.subarray(8, 12).toString(), 'RIFFWEBP', 'the kind of file');
    let pictures = 0;
    for (let at = 12; at < bytes.length; at += 8 + bytes.readUInt32LE(at + 4) + (bytes.readUInt32LE(at + 4) & 1))
        pictures += bytes.subarray(at, at + 4).toString() === 'ANMF';
    equal(pictures, 6, 'pictures in the movie');
    assert(
        face.events.some(({ event, what, done }) => event === 'progress' && what === 'movie' && done > 0 && done < 1),
        'no progress was told',
    );
    await page.waitForSelector('#progress', { state: 'hidden', timeout: 60000 });
    await page.selectOption('#panel-save [aria-label="Kind of movie"]', 'png');
    const { name, bytes: archive } = await saved('#panel-save button:has-text("Save movie")');
    equal(name, 'turn.zip', 'the name');
    const places = readZip(archive);
    equal(Object.keys(places).join(), [0, 1, 2, 3, 4, 5].map((i) => `turn_000${i}.png`).join(), 'pictures in the archive');
    for (const data of Object.values(places)) {
        equal(data.subarray(0, 4).toString('latin1'), '\x89PNG', 'the kind of picture');
        equal(`${data.readUInt32BE(16)}x${data.readUInt32BE(20)}`, '96x64', 'its size');
    }
    assert(!places['turn_0000.png'].equals(places['turn_0001.png']), 'nothing turned');
});

test('a movie and an upload each have a bar, and are cancelled by themselves', async () => {
    const hand = await page.context().newCDPSession(page),
        jobs = () => page.locator('#progress .job').allTextContents();
    const network = (uploadThroughput) =>
        hand.send('Network.emulateNetworkConditions', { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput });
    await open('save');
    await page.fill('#panel-save [aria-label="Frames"]', '3000');
    await page.keyboard.press('Tab');
    await page.click('#panel-save button:has-text("Save movie")');
    await network(100000);
    await drop('slow.nrrd', 'x'.repeat(3000000));
    await page.waitForSelector('#progress .job:has-text("Sending slow.nrrd")');
    await page.waitForSelector('#progress .job:has-text("Drawing the movie")');
    await saved('#panel-save button:has-text("Save scene")');
    equal((await jobs()).length, 2, 'bars after something else was saved');
    await page.click('#progress .job:has-text("Sending") button');
    await told('slow.nrrd was not sent.');
    await page.waitForFunction(() => document.querySelectorAll('#progress .job').length === 1);
    assert((await jobs())[0].startsWith('Drawing the movie'), 'the movie’s bar is gone');
    await page.click('#progress .job button');
    await told('Cancelled.');
    await page.waitForSelector('#progress', { state: 'hidden' });
    await network(-1);
});

test('of two folders asked for the newer is listed, whichever answer comes last', async () => {
    await open('file');
    await page.waitForSelector(`.file:has-text("${path.basename(folder)}")`);
    await page.evaluate(async () => {
        const { connection } = await import('./begin.js'),
            ask = connection.ask;
        connection.ask = async (...given) => {
            connection.ask = ask;
            const answer = await ask.apply(connection, given);
            await new Promise((done) => (window.late = done));
            return answer;
        };
    });
    await page.click(`.file:has-text("${path.basename(folder)}")`); /* its answer comes late */
    await page.waitForFunction(() => window.late);
    await page.evaluate(async () => {
        const { set } = await import('./store.js');
        for (const panel of ['save', 'file']) set({ panel }); /* asks for what is shown */
    });
    await face.until(() => face.count('list') === face.events.filter(({ event }) => event === 'files').length, 'all answers');
    await page.evaluate(() => window.late());
    await face.settle();
    equal(await page.locator('.path').textContent(), 'Folders of the server', 'what is listed');
});

test('a transfer function goes out and comes in', async () => {
    await open('transfer');
    const { bytes } = await saved('#panel-transfer button:has-text("Export")');
    const [preset] = [JSON.parse(bytes.toString('utf8'))].flat();
    assert(preset.RGBPoints.length >= 8, 'the preset has colours');
});

test('another file is opened from the server’s folder', async () => {
    await open('file');
    await page.click(`.file:has-text("${path.basename(folder)}")`);
    await page.click('.file:has-text("second.nrrd")');
    await page.waitForFunction(() => document.querySelector('#name').textContent === 'second.nrrd', null, { timeout: 60000 });
    await face.rest();
});

test('the device is told, and chosen where there are several', async () => {
    await open('render');
    const choice = page.locator('select[aria-label="Device"]'),
        known = () => face.events.filter((event) => event.devices).at(-1);
    const { devices } = known();
    await page.waitForSelector(devices.length > 1 ? 'select[aria-label="Device"]' : '.value:has-text("CPU")', { timeout: 60000 });
    if (devices.length < 2) return;
    for (const { id, name } of [devices[1], devices[0]]) {
        await choice.selectOption(id);
        await face.until(() => known().device.id === id, `${id} to draw`, 60000);
        const { header } = await face.rest();
        assert(header.device.includes(name), `${header.device} drew, not ${name}`);
    }
});

await mainWithoutComplaints(face, browser, server, folder);
