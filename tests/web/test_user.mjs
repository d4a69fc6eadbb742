/* SPDX-License-Identifier: MIT */
/* What a user meets: crowded points, numbers that are too large, a volume of a patient, a folder of slices, undo once too often. */

import { mkdirSync, mkdtempSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Face, assert, equal, launch, mainWithoutComplaints, test, view } from './harness.mjs';

const SIDE = 16;
const SLOPE = [
    [0, 0.25],
    [200, 0.5],
];
const browser = await launch();
const folder = mkdtempSync(path.join(os.tmpdir(), 'pellucid-web-'));

/** A ball, 0 outside and 200 in its middle, in a NRRD file whose axes and unit are those of `fields`. */
function ball(name, fields) {
    const samples = Buffer.alloc(SIDE ** 3);
    for (let at = 0; at < samples.length; at++) {
        const off = [at % SIDE, Math.floor(at / SIDE) % SIDE, Math.floor(at / SIDE ** 2)].map((x) => x - SIDE / 2);
        samples[at] = Math.max(0, 200 - 28 * Math.hypot(...off));
    }
    const lines = ['NRRD0004', 'type: uint8', 'dimension: 3', `sizes: ${SIDE} ${SIDE} ${SIDE}`, 'encoding: raw', ...fields];
    const file = path.join(folder, name);
    writeFileSync(file, Buffer.concat([Buffer.from(`${lines.join('\n')}\n\n`), samples]));
    return file;
}

const patient = ball('patient.nrrd', ['space: left-posterior-superior', 'space directions: (1,0,0) (0,1,0) (0,0,1)', 'space origin: (0,0,0)']);
const server = await view(patient, folder);
const face = await Face.open(browser, server.address, { viewport: { width: 1000, height: 640 } });
const { page } = face;

async function open(name) {
    if (await page.locator(`#panel-${name}`).isHidden()) await page.click(`#open-${name}`);
}

test('of points that cover each other the nearest is taken', async () => {
    await open('transfer');
    const opacities = Array.from({ length: 61 }, (_, i) => [100 + i / 2, 0.5]);
    await face.send({ do: 'set', scene: { transfer: { opacities } } });
    await page.waitForFunction(() => document.querySelectorAll('circle.opacities').length === 61);
    for (const index of [20, 33]) {
        const [x, y] = await face.middle(`circle.opacities[data-index="${index}"]`);
        await page.mouse.click(x, y);
        await page.waitForSelector(`circle.opacities.chosen[data-index="${index}"]`, { timeout: 10000 });
    }
});

test('a number that is too large is the largest one, and shown so; no number is what was there', async () => {
    await open('transfer');
    await face.send({ do: 'set', scene: { transfer: { opacities: SLOPE } } });
    await page.waitForFunction(() => document.querySelectorAll('circle.opacities').length === 2);
    await page.click('circle.opacities[data-index="0"]');
    const shown = (text) =>
        page.waitForFunction((now) => document.querySelector('[aria-label="Opacity of the chosen point"]').value === now, text);
    const fill = async (text) => {
        await page.fill('[aria-label="Opacity of the chosen point"]', text);
        await page.keyboard.press('Enter');
    };
    await shown('0.25');
    await fill('5');
    await shown('1');
    await face.until(() => face.scene.transfer.opacities[0][1] === 1, 'the curve to follow');
    await fill('-3');
    await shown('0');
    await face.until(() => face.scene.transfer.opacities[0][1] === 0, 'the curve to follow');
    await fill('');
    await shown('0');
    await open('render');
    const step = '#panel-render [data-option="refine"] input[type=number]';
    await page.fill(step, '99999');
    await page.keyboard.press('Enter');
    const most = await page.locator(step).getAttribute('max');
    await face.until(() => face.scene.render.refine === Number(most), 'the option to be the largest');
    equal(await page.inputValue(step), most, 'what is shown');
    await face.send({ do: 'set', scene: { render: { refine: 0 } } });
});

test('automatic isosurfaces are drawn, in one step of undo', async () => {
    const steps = () => face.events.filter(({ event }) => event === 'state').at(-1).undo;
    await face.rest();
    const before = steps();
    equal(face.scene.render.mode, 'composite', 'the mode');
    await open('surfaces');
    await page.click('#panel-surfaces button:has-text("Automatic")');
    await face.until(() => face.scene.render.mode === 'isosurface' && face.scene.isosurfaces.length > 0, 'the surface');
    await face.rest();
    equal(steps(), before + 1, 'steps of undo');
    await page.click('#undo');
    await face.until(() => face.scene.render.mode === 'composite', 'the undo');
});

test('undo once too often is no error; messages leave the scale bar free', async () => {
    while (face.events.filter(({ event }) => event === 'state').at(-1).undo > 0) {
        const before = face.events.length;
        await face.send({ do: 'undo' });
        await face.until(() => face.events.slice(before).some(({ event }) => event === 'state'), 'the undo');
    }
    await page.click('#open-surfaces');
    await page.locator('#panel-surfaces').waitFor({ state: 'hidden' });
    await page.keyboard.press('Control+z');
    await page.waitForSelector('.message:has-text("Nothing to undo.")', { timeout: 60000 });
    equal(await page.locator('.message.error').count(), 0, 'errors');
    for (const [width, height] of [
        [1000, 640],
        [390, 700],
    ]) {
        await page.setViewportSize({ width, height });
        const [over, bar] = [await page.locator('.message').last().boundingBox(), await page.locator('#main .scale-bar').boundingBox()];
        assert(over.y + over.height <= bar.y, `at ${width} pixels a message ends at ${over.y + over.height}, the bar begins at ${bar.y}`);
    }
    await page.setViewportSize({ width: 1000, height: 640 });
});

/** A grey TIFF of 8 x 8 bytes, all of one value. */
function tiff(value) {
    const tags = [
        [256, 8],
        [257, 8],
        [258, 8],
        [259, 1],
        [262, 1],
        [273, 128],
        [277, 1],
        [278, 8],
        [279, 64],
    ];
    const bytes = Buffer.alloc(192, value);
    bytes.fill(0, 0, 128);
    bytes.write('II*\0');
    bytes.writeUInt32LE(8, 4);
    bytes.writeUInt16LE(tags.length, 8);
    tags.forEach(([tag, what], i) => {
        bytes.writeUInt16LE(tag, 10 + 12 * i);
        bytes.writeUInt16LE(4, 12 + 12 * i);
        bytes.writeUInt32LE(1, 14 + 12 * i);
        bytes.writeUInt32LE(what, 18 + 12 * i);
    });
    return bytes;
}

test('a folder of slices is opened as a volume', async () => {
    const slices = path.join(folder, 'slices');
    mkdirSync(slices);
    for (let i = 0; i < 5; i++) writeFileSync(path.join(slices, `slice${i}.tif`), tiff(40 * i));
    const whole = page.locator('button:has-text("Open this folder as a volume")');
    await open('file');
    await page.click(`.file:has-text("${path.basename(folder)}")`);
    await page.waitForSelector('.file:has-text("patient.nrrd")', { timeout: 60000 });
    assert(await whole.isHidden(), 'a folder without slices is offered as a volume');
    await page.click('.file:has-text("slices")');
    await page.waitForSelector('.file:has-text("slice4.tif")', { timeout: 60000 });
    await whole.click();
    await page.waitForFunction(() => document.querySelector('#dims').textContent.startsWith('8 × 8 × 5'), null, { timeout: 60000 });
    await face.rest();
    await page.click('.file:has-text("..")');
    await page.click('.file:has-text("patient.nrrd")');
    await page.waitForFunction(() => document.querySelector('#dims').textContent.startsWith('16 × 16 × 16'), null, { timeout: 60000 });
    await face.rest();
});

test('a patient’s sides are named on buttons, in the list of keys and on the sliders of slices', async () => {
    await open('camera');
    const views = await page.locator('#panel-camera .views button').allTextContents();
    equal(views.join(), 'Left (L),Right (R),Back (P),Front (A),Top (S),Bottom (I)', 'the buttons');
    await open('slices');
    const rows = await page.locator('#panel-slices .field label').allTextContents();
    for (const name of ['Sagittal (i)', 'Coronal (j)', 'Axial (k)']) assert(rows.includes(name), `${name} is not in ${rows.join()}`);
    await page.keyboard.press('?');
    await page.waitForSelector('#help:has-text("look from left (L), right (R), back (P), front (A), top (S), bottom (I)")', { timeout: 10000 });
    await page.keyboard.press('Escape');
});

test('the status line tells the voxel as finely as the value', async () => {
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
    await face.until(() => face.frames.some(({ header }) => header.view === 'slice-k'), 'the slices');
    const [x, y] = await face.middle('.slice >> nth=2');
    await page.mouse.move(x + 21, y + 17);
    await page.waitForSelector('.status-cursor:has-text("voxel")', { timeout: 60000 });
    const words = await page.locator('.status-cursor').textContent(),
        { index } = face.events.filter(({ event, hit }) => event === 'probe' && hit).at(-1);
    const told = /voxel ([^ ]+), ([^ ]+), ([^ ]+)/.exec(words).slice(1).map(Number);
    assert(index.some((i) => Math.abs(i - Math.round(i)) > 0.05), `the pointer is between voxels: ${index}`);
    index.forEach((i, axis) => assert(Math.abs(i - told[axis]) <= 0.0051, `${words} for the place ${index}`));
    await page.click('#panel-slices [aria-label="Show three slices"]');
});

test('no unit is told where the volume tells none', async () => {
    await face.rest();
    const words = await page.locator('#main .scale-bar').textContent();
    assert(/^[\d.]+ units/.test(words), `the scale bar says ${words}`);
    const [x, y] = await face.middle('#main');
    await page.mouse.move(x, y);
    await page.waitForSelector('.status-cursor:has-text("voxel")', { timeout: 60000 });
    assert(!/mm/.test(await page.locator('.status-cursor').textContent()), 'the status line says mm');
});

test('a scene that is imported as a colour map is called a scene', async () => {
    await open('transfer');
    const scene = JSON.stringify({ 'pellucid-scene': 1, render: { mode: 'mip' } });
    await page.setInputFiles('[aria-label="ParaView colour map to import"]', {
        name: 'view.json',
        mimeType: 'application/json',
        buffer: Buffer.from(scene),
    });
    await page.waitForSelector('.message.error:has-text("view.json is a scene, not a colour map")', { timeout: 10000 });
});

test('slices are called as in anatomy where the axes are known, and in short where there is little room', async () => {
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
    const labels = (texts) =>
        page.waitForFunction((wanted) => [...document.querySelectorAll('.slice-label')].map((e) => e.textContent).join() === wanted, texts, {
            timeout: 60000,
        });
    await page.setViewportSize({ width: 1300, height: 640 });
    await labels('Sagittal 8 / 15,Coronal 8 / 15,Axial 8 / 15');
    await page.waitForSelector('.slice[aria-label^="Axial slice (k)"]');
    await page.setViewportSize({ width: 900, height: 640 });
    await labels('Sagittal 8,Coronal 8,Axial 8');
    await page.setViewportSize({ width: 1000, height: 640 });
    await page.click('#panel-slices [aria-label="Show three slices"]');
});

test('no bar, rail or panel lies over a slice, in wide windows and narrow ones', async () => {
    const panel = () => page.locator('#panel-slices');
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
    const covered = () =>
        page.evaluate(() => {
            const box = (element) => element.getBoundingClientRect();
            const over = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
            const above = ['#top', '#rail', '#panel-slices:not([hidden])', '#status'].flatMap((name) => [...document.querySelectorAll(name)]);
            const below = [...document.querySelectorAll('.slice')].filter((slice) => slice.clientWidth > 0);
            return below.flatMap((slice, i) => above.filter((e) => over(box(e), box(slice))).map((e) => `#${e.id} over picture ${i}`)).join();
        });
    for (const [width, height] of [[1600, 900], [1280, 720], [1000, 640], [900, 700], [420, 800]])
        for (const shown of [true, false]) {
            await page.setViewportSize({ width, height });
            if ((await panel().isVisible()) !== shown) await page.click('#open-slices');
            const end = performance.now() + 10000;
            while ((await covered()) && performance.now() < end);
            equal(await covered(), '', `${width} x ${height}, ${shown ? 'with' : 'without'} the panel`);
        }
    await page.setViewportSize({ width: 1000, height: 640 });
    await page.locator('.slice >> nth=0').dblclick();
    await page.waitForSelector('#stage[data-large]');
    equal(await covered(), '', 'a large slice');
    await page.locator('.slice.large').dblclick();
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
});

test('on a phone four pictures lie beside the bar and the sheet, not under them', async () => {
    await page.setViewportSize({ width: 390, height: 844 });
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
    await page.waitForSelector('#stage[data-layout="four"]');
    const edges = () =>
        page.evaluate(() => {
            const box = (selector) => document.querySelector(selector).getBoundingClientRect();
            return [box('#top').bottom, box('#stage').top, box('#stage').bottom, box('#panel-slices').top];
        });
    await page.waitForFunction(() => document.querySelector('#panel-slices').getAnimations().length === 0);
    const [bar, top, bottom, sheet] = await edges();
    assert(bar <= top, `the bar ends at ${bar}, the pictures begin at ${top}`);
    assert(bottom <= sheet + 1, `the pictures end at ${bottom}, the sheet begins at ${sheet}`);
    await page.click('#panel-slices [aria-label="Show three slices"]');
    await page.setViewportSize({ width: 1000, height: 640 });
});

await mainWithoutComplaints(face, browser, server, folder);
