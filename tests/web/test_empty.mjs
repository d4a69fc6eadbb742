/* SPDX-License-Identifier: MIT */
/* The page with a folder and nothing open: all is clicked and keyed, a file fails, then one is opened and all works. */

import { mkdtempSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Face, assert, equal, launch, mainWithoutComplaints, test, view } from './harness.mjs';

const PANELS = ['transfer', 'surfaces', 'render', 'lights', 'clip', 'slices', 'measure', 'camera', 'file', 'save'];
const FREE = ['camera', 'file'];
const FIRST = 'Open a file first.';
const KEYS =
    'ArrowLeft ArrowUp Shift+ArrowRight + = - [ ] r 1 2 3 4 5 6 o f Control+z Control+Shift+z Control+y Control+s Space m s ' +
    'PageDown PageUp Home End Insert Delete Enter b 0 x';
const browser = await launch();
const folder = mkdtempSync(path.join(os.tmpdir(), 'pellucid-web-'));

function write(name, samples) {
    const header = ['NRRD0004', 'type: uint8', 'dimension: 3', 'sizes: 12 12 12', 'encoding: raw'].join('\n');
    writeFileSync(path.join(folder, name), Buffer.concat([Buffer.from(`${header}\n\n`), samples]));
}
const ball = Buffer.alloc(12 ** 3, 0).map((_, at) => {
    const off = [at % 12, Math.floor(at / 12) % 12, Math.floor(at / 144)].map((x) => x - 5.5);
    return Math.max(0, 200 - 30 * Math.hypot(...off));
});
write('ball.nrrd', ball);
write('short.nrrd', ball.subarray(0, 700));

const server = await view(folder);
const face = await Face.open(browser, server.address, { viewport: { width: 1000, height: 640 } }, '.file');
const { page } = face;
page.on('filechooser', () => {}); /* it stays unanswered */

const open = async (name) => {
    if (await page.locator(`#panel-${name}`).isHidden()) await page.click(`#open-${name}`);
};
const errors = () => face.events.filter(({ event }) => event === 'error');
const inert = (name) => page.evaluate((of) => document.querySelector(`#panel-${of} .panel-body`).inert, name);
/** Where the controls of what is seen are, but for the files themselves. */
const places = (selector) =>
    page.evaluate(
        (within) =>
            [...document.querySelectorAll(`${within} :is(button, input, select, svg[tabindex])`)]
                .filter((e) => !e.matches('.file, .hidden, [title^="Close"]') && e.getClientRects().length)
                .map((e) => e.getBoundingClientRect())
                .map(({ x, y, width, height }) => [x + width / 2, y + height / 2])
                .filter(([x, y]) => document.elementFromPoint(x, y)?.closest(within)),
        selector,
    );

test('with nothing open the page says so, and shows the files', async () => {
    assert(await page.locator('#panel-file').isVisible(), 'the panel of files');
    assert(/^Nothing is open yet/.test(await page.locator('#waiting').textContent()), 'what the picture’s place says');
});

test('with nothing open no control throws, and panels say what is to be done first', async () => {
    for (const name of PANELS.filter((one) => !FREE.includes(one))) {
        await open(name);
        assert(await inert(name), `the panel ${name} is in reach`);
        await page.waitForSelector(`#panel-${name} .open-first:has-text("${FIRST}")`);
        const found = await places(`#panel-${name} .panel-body`);
        for (const [x, y] of found) await page.mouse.click(x, y);
    }
    equal(face.sent.filter((command) => !['hello', 'size', 'list'].includes(command.do)).length, 0, 'commands that need a volume');
    for (const name of FREE) {
        await open(name);
        assert(!(await inert(name)), `the panel ${name} is out of reach`);
        for (const [x, y] of await places(`#panel-${name} .panel-body`)) await page.mouse.click(x, y);
        await page.keyboard.press('Escape');
    }
    await open('transfer');
    await page.click('#panel-transfer button:has-text("Choose a file")');
    await page.waitForSelector('#panel-file:not([hidden])');
    equal(await page.evaluate(() => document.activeElement.id), 'panel-file', 'what has the focus');
});

test('with nothing open no key and no hand on the picture throws', async () => {
    const before = face.sent.length,
        told = errors().length,
        [x, y] = await face.middle('#main');
    for (const name of [...PANELS, null]) {
        if (name) await open(name);
        else await page.keyboard.press('Escape');
        await page.mouse.click(x, y);
        for (const key of KEYS.split(' ')) await page.keyboard.press(key);
    }
    await page.waitForSelector(`.message.note:has-text("${FIRST}")`);
    await face.drag([x, y], [x + 60, y + 30]);
    await face.drag([x, y], [x + 60, y + 30], { button: 'right' });
    await page.mouse.wheel(0, 200);
    await page.mouse.dblclick(x, y);
    await page.keyboard.press('?');
    await page.waitForSelector('dialog[open]');
    await page.keyboard.press('Escape');
    await open('render');
    for (let i = 0; i < 40; i++) {
        await page.keyboard.press('Tab');
        if (await page.evaluate(() => document.activeElement.matches('.file, .rail-button, #theme, #help-button'))) continue;
        for (const key of ['Space', 'ArrowRight', 'ArrowUp', 'PageDown', 'Delete']) await page.keyboard.press(key);
    }
    const needless = face.sent.slice(before).filter((command) => !['list', 'size'].includes(command.do));
    equal(needless.map((command) => command.do).join(), '', 'commands that need a volume');
    equal(errors().length, told, 'errors');
});

test('the first file that fails leaves the page at the files, not waiting', async () => {
    await open('transfer');
    await face.send({ do: 'open', path: path.join(folder, 'short.nrrd') });
    await page.waitForSelector('.message.error:has-text("short.nrrd")');
    await page.waitForSelector('#panel-file:not([hidden])');
    assert(/^Nothing is open yet/.test(await page.locator('#waiting').textContent()), 'what the picture’s place says');
});

test('then a file is opened, and all works', async () => {
    await open('file');
    if (!(await page.locator('.file:has-text("ball.nrrd")').count())) await page.click('.file >> nth=-1');
    await page.click('.file:has-text("ball.nrrd")');
    await page.waitForSelector('body.has-picture', { timeout: 60000 });
    await face.rest();
    assert(await page.locator('#waiting').isHidden(), 'nothing is waited for');
    for (const name of PANELS) {
        await open(name);
        assert(!(await inert(name)), `the panel ${name} is out of reach`);
        equal(await page.locator(`#panel-${name} .open-first:visible`).count(), 0, `words in the panel ${name}`);
    }
    await open('transfer');
    await page.click('.colormap >> nth=3');
    await face.until(() => face.scene.transfer.colormap, 'a colour map');
    const opacities = face.scene.transfer.opacities.join();
    await page.locator('[aria-label="Strength of all opacities"] >> nth=0').focus();
    await page.keyboard.press('ArrowLeft');
    await face.until(() => face.scene.transfer.opacities.join() !== opacities, 'the strength');
    await open('surfaces');
    await page.click('#panel-surfaces button:has-text("Add")');
    await face.until(() => face.scene.isosurfaces?.length === 1, 'an isosurface');
    await open('clip');
    await page.click('[aria-label="Clip box"]');
    await page.click('#panel-clip button:has-text("Facing me")');
    await face.until(() => face.scene['clip-box'] && face.scene['clip-planes'].length === 1, 'a box and a plane');
    await open('slices');
    await page.click('#panel-slices button:has-text("Draw planes")');
    await page.click('#panel-slices button:has-text("At the cross-hair")');
    await face.until(() => face.scene.slice.length === 3, 'three planes');
    await page.click('[aria-label="Show three slices"]');
    await page.click('#panel-slices button:has-text("Whole range")');
    await face.until(() => face.frames.some(({ header }) => header.view === 'slice-k'), 'the slices');
    await page.locator('#main').focus();
    await page.keyboard.press('s');
    await page.keyboard.press('ArrowLeft');
    await face.until(() => face.count('rotate') > 0, 'the picture to turn');
    await face.rest();
});

await mainWithoutComplaints(face, browser, server, folder);
