/* SPDX-License-Identifier: MIT */
/* Hands that do what is not foreseen: a drag that ends where it began, a second finger, edits that are refused, a connection that goes and
 * comes back, screens of many pixels. */

import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Face, assert, equal, launch, mainWithoutComplaints, pellucid, test, view } from './harness.mjs';

const browser = await launch();
const folder = mkdtempSync(path.join(os.tmpdir(), 'pellucid-web-'));
const file = path.join(folder, 'orbital.nrrd');
const made = spawnSync(pellucid, ['make', 'hydrogen', '-o', file, '--size', '32'], { encoding: 'utf8' });
assert(made.status === 0, made.stderr);
const server = await view(file);
const face = await Face.open(browser, server.address);
const { page } = face;
const BAND = [
    [0, 0],
    [20, 0],
    [30, 0.5],
    [60, 0.5],
    [70, 0],
    [120, 0],
];

async function open(name) {
    if (await page.locator(`#panel-${name}`).isHidden()) await page.click(`#open-${name}`);
}

const steps = () => face.events.filter(({ event }) => event === 'state').at(-1).undo;
const values = () => face.scene.transfer.opacities.map(([value]) => value);

/** Puts the trapezoid into the curve, over the volume's own values. */
async function putBand() {
    const [lo, hi] = await page.evaluate(async () => (await import('./store.js')).get('volume').range);
    const opacities = BAND.map(([value, opacity]) => [lo + (value / 120) * (hi - lo), opacity]);
    await face.send({ do: 'set', scene: { transfer: { opacities } } });
    await face.until(() => values().length === BAND.length && face.scene.transfer.opacities[2][1] === 0.5, 'the band');
    /* The page takes it once its own last edit rests. */
    await page.evaluate(async (wanted) => {
        const { get } = await import('./store.js');
        while (get('scene').transfer.opacities.join() !== wanted) await new Promise((done) => setTimeout(done, 10));
    }, opacities.join());
    await face.rest();
    return opacities;
}

test('every technique that can draw is chosen and draws', async () => {
    const { techniques } = face.events.find(({ event }) => event === 'hello');
    await open('render');
    await face.send({ do: 'set', scene: { render: { refine: 0 } } });
    for (const { name, engines } of techniques) {
        const option = page.locator(`#panel-render [aria-label="Technique"] option[value="${name}"]`);
        equal(await option.isDisabled(), !engines.includes('cpu'), `${name} is out of reach`);
        if (!engines.includes('cpu')) continue;
        await page.selectOption('#panel-render [aria-label="Technique"]', name);
        await face.until(() => face.scene.technique?.name === name, `${name} to be chosen`);
        await page.waitForFunction((now) => document.querySelector('#panel-render [aria-label="Technique"]').value === now, name);
        await face.rest();
    }
    equal(face.complaints.join('\n'), '', 'complaints');
    const color = page.locator('[data-option="ambient-color"] input');
    await page.selectOption('#panel-render [aria-label="Technique"]', 'slices2d');
    await page.waitForFunction(() => document.querySelector('[data-option="ambient-color"] input')?.value === '#202060');
    await color.fill('#ff8000');
    await face.until(() => face.scene.technique.options['ambient-color'] === '#ff8000', 'a colour as an option');
    await page.selectOption('#panel-render [aria-label="Technique"]', 'auto');
    await page.locator('#panel-render [aria-label="Technique"]').focus();
    await page.keyboard.press('ArrowDown');
    await face.until(() => face.scene.technique.name !== 'auto', 'a key to choose the next one');
    equal(await page.evaluate(() => document.activeElement.getAttribute('aria-label')), 'Technique', 'what has the focus');
    await page.selectOption('#panel-render [aria-label="Technique"]', 'auto');
    await face.rest();
});

test('a slider that is let go where it was taken ends its move', async () => {
    await open('transfer');
    const [x, y] = await face.middle('#panel-transfer .slider input[type=range]'),
        before = face.count('release');
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 40, y, { steps: 4 });
    await page.mouse.move(x, y, { steps: 4 });
    await page.mouse.up();
    await face.until(() => face.count('release') > before, 'the release');
    await face.rest();
});

test('a second finger in the editor changes nothing of the first one’s drag', async () => {
    await putBand();
    const client = await page.context().newCDPSession(page);
    await client.send('Emulation.setTouchEmulationEnabled', { enabled: true, maxTouchPoints: 2 });
    const touch = (type, ...points) =>
        client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
    const [x, y] = await face.middle('circle.opacities[data-index="2"]'),
        before = face.count('release'),
        undo = steps();
    await touch('touchStart', [x, y]);
    for (let i = 1; i <= 4; i++) await touch('touchMove', [x, y - 4 * i]);
    await touch('touchStart', [x, y - 16], [x + 60, y + 40]);
    await touch('touchMove', [x, y - 20], [x + 70, y + 40]);
    await touch('touchEnd', [x, y - 20]);
    await touch('touchMove', [x, y - 24]);
    await touch('touchEnd');
    await client.send('Emulation.setTouchEmulationEnabled', { enabled: false });
    await face.until(() => face.count('release') > before, 'the release');
    await face.rest();
    assert(face.scene.transfer.opacities[2][1] > 0.5, 'the point was dragged upwards');
    equal(face.scene.transfer.opacities[3][1], 0.5, 'the other point');
    equal(steps(), undo + 1, 'steps of undo');
});

test('a band is moved whole, however far', async () => {
    const before = await putBand(),
        span = before.at(-1)[0] - before[0][0];
    const box = await page.locator('.points').boundingBox(),
        [x] = await face.middle('circle.opacities[data-index="2"]'),
        [end] = await face.middle('circle.opacities[data-index="3"]');
    const from = [(x + end) / 2, box.y + box.height * 0.6];
    await face.drag(from, [from[0] + (end - x) * 0.8, from[1]], { steps: 6, pause: 16 });
    await face.rest();
    const after = face.scene.transfer.opacities,
        by = after[2][0] - before[2][0];
    assert(by > 0.15 * span && by < 0.25 * span, `the band went by ${by / span} of the values`);
    after.forEach(([value, opacity], i) => {
        const expected = before[i][0] + (i >= 1 && i <= 4 ? by : 0);
        assert(Math.abs(value - expected) < 1e-9 * span && opacity === before[i][1], `point ${i} is at ${value}, ${opacity}`);
    });
});

test('a band is moved and made stronger by keys, in one step of undo', async () => {
    const before = await putBand(),
        undo = steps();
    await page.click('circle.opacities[data-index="2"]');
    await page.keyboard.press('b');
    await page.waitForFunction(() => document.querySelector('.which').textContent === 'Band 2–5');
    await page.waitForFunction(() => document.querySelectorAll('circle.opacities.chosen').length === 4);
    for (let i = 0; i < 3; i++) await page.keyboard.press('ArrowRight');
    for (let i = 0; i < 5; i++) await page.keyboard.press('ArrowUp');
    await face.rest();
    const after = face.scene.transfer.opacities,
        by = after[2][0] - before[2][0],
        span = before.at(-1)[0] - before[0][0];
    assert(by > 0, 'the band did not move');
    assert(after[2][1] > 0.51 && after[2][1] < 0.6, `the opacity is ${after[2][1]}`);
    after.forEach(([value, opacity], i) => {
        const expected = before[i][0] + (i >= 1 && i <= 4 ? by : 0);
        assert(Math.abs(value - expected) < 1e-9 * span, `point ${i} is at ${value}`);
        equal(opacity, before[i][1] > 0 ? after[2][1] : 0, `the opacity of point ${i}`);
    });
    equal(steps(), undo + 1, 'steps of undo');
    await page.keyboard.press('b');
    await page.waitForFunction(() => /^Point 3\//.test(document.querySelector('.which').textContent));
});

test('what keys choose in the editor is brought into sight', async () => {
    await putBand();
    const editor = page.locator('.points');
    await page.click('circle.opacities[data-index="0"]');
    for (let i = 0; i < 8; i++) await page.keyboard.press('+');
    equal(await page.locator('circle.opacities[data-index="5"]').count(), 0, 'points out of sight');
    for (let i = 0; i < 5; i++) await page.keyboard.press('PageDown');
    await page.waitForSelector('circle.opacities.chosen[data-index="5"]');
    await page.click('#panel-transfer button:has-text("All values")');
    await editor.focus();
});

test('arrows held down in the editor are one step of undo; page down reaches colours', async () => {
    await putBand();
    await page.locator('.points').focus();
    const undo = steps(),
        before = JSON.stringify(face.scene.transfer.opacities);
    for (let i = 0; i < 10; i++) await page.keyboard.press('ArrowUp');
    await face.rest();
    assert(JSON.stringify(face.scene.transfer.opacities) !== before, 'nothing moved');
    equal(steps(), undo + 1, 'steps of undo');
    for (const key of ['PageUp', 'PageDown']) for (let i = 0; i < BAND.length; i++) await page.keyboard.press(key);
    await page.waitForFunction(() => /^Colour 1\//.test(document.querySelector('.which').textContent));
});

test('what is refused is shown as it is again', async () => {
    const distance = face.scene.transfer['unit-distance'],
        field = '[aria-label="Unit distance"]';
    await page.fill(field, '0');
    await page.keyboard.press('Enter');
    await page.waitForSelector('.message.error');
    await page.waitForFunction(([at, was]) => Math.abs(Number(document.querySelector(at).value) / was - 1) < 1e-5, [field, distance]);
    equal(face.scene.transfer['unit-distance'], distance, 'the distance');
    await page.click('.message.error button');
});

test('a click on isosurface is one step of undo', async () => {
    await open('render');
    const undo = steps();
    await page.click('[data-mode="isosurface"]');
    await face.until(() => face.scene.render.mode === 'isosurface' && face.scene.isosurfaces.length > 0, 'a surface');
    await face.rest();
    equal(steps(), undo + 1, 'steps of undo');
    await page.click('#undo');
    await face.until(() => face.scene.render.mode === 'composite', 'the undo');
});

test('of a large file of presets the chosen one is sent; one that is too large is refused in words', async () => {
    const color = (i, points) => [i, 0.123456789, 0.5, i / points];
    const preset = (Name, points) => ({ Name, RGBPoints: Array.from({ length: points }, (_, i) => color(i, points)).flat() });
    const drop = (name, content) =>
        page.evaluate(
            ([title, text]) => {
                const dataTransfer = new DataTransfer();
                dataTransfer.items.add(new File([text], title));
                for (const kind of ['dragenter', 'dragover', 'drop'])
                    document.body.dispatchEvent(new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true }));
            },
            [name, JSON.stringify(content)],
        );
    await drop('many.json', [preset('huge', 60000), preset('small', 3)]);
    await page.selectOption('.presets select', 'small');
    await face.until(() => face.scene.transfer.colors.length === 3, 'the small preset');
    await page.selectOption('.presets select', 'huge');
    await page.waitForSelector('.message.error:has-text("many.json: this is more than the server takes")');
    await page.click('.message.error button');
    equal(await page.evaluate(() => window.sockets.length), 1, 'connections so far');
});

test('a connection that comes back leaves distances and the cross-hair as they were', async () => {
    await open('slices');
    await page.click('#panel-slices [aria-label="Show three slices"]');
    await face.until(() => face.frames.some(({ header }) => header.view === 'slice-k'), 'the slices');
    await page.locator('.slice >> nth=2').focus();
    await page.keyboard.press(' ');
    for (let i = 0; i < 3; i++) await page.keyboard.press('PageUp');
    await page.keyboard.press(' ');
    await page.waitForSelector('.message:has-text("Distance")');
    await face.until(() => face.count('slices') > 1, 'the cross-hair to move');
    await page.fill('[aria-label="Window"]', '3');
    await page.keyboard.press('Tab');
    await face.settle();
    const before = face.lastSent('slices'),
        frames = face.frames.length;
    await page.evaluate(() => window.sockets.at(-1).close());
    await page.waitForSelector('#banner:not([hidden])');
    await face.until(() => face.count('hello') === 2, 'another hello');
    await page.waitForSelector('#banner', { state: 'hidden' });
    await face.until(() => face.frames.slice(frames).some(({ header }) => header.view === 'slice-k'), 'the slices again');
    await face.rest();
    const after = face.lastSent('slices');
    for (const key of ['at', 'window', 'size']) equal(JSON.stringify(after[key]), JSON.stringify(before[key]), `${key} of the slices`);
    equal(await page.locator('#panel-measure .card').count(), 1, 'distances');
    assert(parseFloat(await page.locator('#panel-measure .card').textContent().then((text) => text.slice(2))) > 0, 'a distance of nothing');
});

test('“Try now” leaves no attempt behind that was under way', async () => {
    const slow = await (await browser.newContext()).newPage(),
        sockets = [];
    let answer = () => {};
    const late = new Promise((done) => (answer = done));
    await slow.routeWebSocket(/socket/, async (route) => {
        const socket = { hellos: 0, closed: false };
        sockets.push(socket);
        route.onClose(() => (socket.closed = true));
        if (sockets.length === 2) await late; /* its opening takes its time */
        if (socket.closed) return;
        const there = route.connectToServer();
        route.onMessage((text) => {
            socket.hellos += JSON.parse(text).do === 'hello';
            there.send(text);
        });
        socket.end = () => route.close();
    });
    const until = async (condition, what) => {
        const end = performance.now() + 30000;
        while (!condition()) {
            assert(performance.now() < end, `waited in vain for ${what}`);
            await slow.waitForTimeout(20);
        }
    };
    await slow.goto(server.address);
    await slow.waitForSelector('body.has-picture', { timeout: 60000 });
    const told = await slow.evaluateHandle(async () => {
        const out = [];
        const { connection } = await import('./begin.js');
        connection.addEventListener('event', ({ detail }) => out.push(detail.event));
        return out;
    });
    await sockets[0].end();
    await until(() => sockets.length === 2, 'the second attempt');
    await slow.click('#banner button');
    await until(() => sockets.length === 3 && sockets[2].hellos > 0, 'the third attempt');
    answer();
    await slow.waitForSelector('#banner', { state: 'hidden' });
    await until(() => sockets[1].closed, 'the second attempt to be given up');
    await slow.waitForTimeout(500); /* in which it would be heard of */
    equal(sockets.map(({ hellos }) => hellos).join(), '1,0,1', 'hellos');
    equal((await told.jsonValue()).filter((event) => event === 'hello').length, 1, 'answers since');
    await slow.context().close();
});

test('with a slice enlarged a picture is saved as large as the window', async () => {
    const before = await page.evaluate(async () => (await import('./begin.js')).wanted());
    await page.locator('.slice >> nth=2').focus();
    await page.keyboard.press('Enter');
    await page.waitForSelector('#stage[data-large="k"]');
    const [saved] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Control+s')]);
    const png = readFileSync(await saved.path());
    equal(`${png.readUInt32BE(16)}x${png.readUInt32BE(20)}`, before.join('x'), 'its size');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#stage:not([data-large])');
});

test('under a hand slices are drawn as it moves, at full quality once it is up', async () => {
    const slices = (from) => face.frames.slice(from).filter(({ header }) => header.view === 'slice-i');
    await page.evaluate(() => document.querySelector('#messages').replaceChildren()); /* they would be under the hand */
    for (const button of ['left', 'right', 'middle']) {
        await face.settle();
        const [x, y] = await face.middle('.slice >> nth=2'),
            from = face.frames.length,
            sent = face.sent.length;
        await page.mouse.move(x, y);
        await page.mouse.down({ button });
        for (let i = 1; !slices(from).some(({ header }) => header.quality === 'moving'); i++) {
            assert(i < 1000, `no moving slice with the ${button} button`);
            await page.mouse.move(x + 20 * Math.sin(i), y + 20 * Math.cos(i));
            await page.waitForTimeout(16);
        }
        const commands = () => face.sent.slice(sent).map((command) => command.do).filter((name) => ['hold', 'slices'].includes(name));
        equal(commands()[0], 'hold', 'what comes first');
        await page.mouse.up({ button });
        await face.until(() => slices(from).at(-1)?.header.final, 'the finished slice');
        await face.settle();
        equal(commands().filter((name) => name === 'hold').length, 1, 'holds');
        assert(slices(from).at(-1).header.lossless, 'the slice at rest is not lossless');
    }
    await page.fill('[aria-label="Window"]', '3');
    await page.keyboard.press('Tab');
});

test('the wheel steps through slices, ten at once with Shift, which may turn it sideways', async () => {
    const number = async () => parseInt((await page.locator('.slice >> nth=2 >> .slice-label').textContent()).slice(2));
    const turn = async (deltaX, deltaY, shiftKey) => {
        const from = await number();
        await page.locator('.slice >> nth=2').evaluate(
            (slice, turned) => slice.dispatchEvent(new WheelEvent('wheel', { ...turned, cancelable: true })),
            { deltaX, deltaY, shiftKey },
        );
        await page.waitForFunction(
            (was) => parseInt(document.querySelectorAll('.slice-label')[2].textContent.slice(2)) !== was,
            from,
        );
        return (await number()) - from;
    };
    await page.locator('.slice >> nth=2').focus();
    equal(await turn(0, 100, false), -1, 'towards the hand');
    equal(await turn(0, -100, false), 1, 'away from it');
    equal(await turn(100, 0, true), -10, 'sideways with Shift');
    equal(await turn(-100, 0, true), 10, 'and back');
});

test('two pages with slices have one cross-hair; one that has enough of it takes nothing from the other', async () => {
    const other = await Face.open(browser, server.address);
    const until = (one, number) =>
        one.page.waitForFunction((n) => parseInt(document.querySelectorAll('.slice-label')[2].textContent.slice(2)) === n, number);
    await other.page.keyboard.press('s');
    for (const one of [other, face]) await until(one, 16); /* the middle of the volume, where a page begins */
    await other.page.locator('.slice >> nth=2').focus();
    for (let i = 0; i < 3; i++) await other.page.keyboard.press('PageDown');
    for (const one of [other, face]) await until(one, 13);
    await other.page.keyboard.press('s');
    await other.until(() => other.lastSent('slices').at === null, 'the other page’s slices to go');
    await page.locator('.slice >> nth=2').focus();
    await page.keyboard.press('PageUp');
    await until(face, 14);
    await other.close();
});

test('on a screen of many pixels an enlarged slice is drawn, on another screen anew', async () => {
    const fine = await Face.open(browser, server.address, { viewport: { width: 1600, height: 1100 }, deviceScaleFactor: 2 });
    await fine.page.keyboard.press('s');
    await fine.until(() => fine.frames.some(({ header }) => header.view === 'slice-k'), 'the slices');
    const [x, y] = await fine.middle('.slice >> nth=2');
    await fine.page.mouse.dblclick(x, y);
    const large = () => fine.frames.some(({ header }) => header.view === 'slice-k' && header.of[0] * header.of[1] > 2 ** 21.9);
    await fine.until(large, 'the large slice');
    equal(fine.events.filter(({ event }) => event === 'error').length, 0, 'errors');
    await fine.page.keyboard.press('Enter');
    await fine.page.keyboard.press('s');
    await fine.settle();
    /* Chromium's emulation tells of another ratio only with another size of the window; the picture's stays. */
    await fine.page.evaluate(() => Object.assign(document.querySelector('#stage').style, { width: '600px', height: '400px' }));
    await fine.until(() => fine.lastSent('size')?.size.join() === '1200,800', 'a picture of that size');
    const client = await fine.page.context().newCDPSession(fine.page);
    await client.send('Emulation.setDeviceMetricsOverride', { width: 1601, height: 1100, deviceScaleFactor: 1, mobile: false });
    await fine.until(() => fine.lastSent('size')?.size.join() === '600,400', 'a picture for the other screen');
    await fine.close();
    await page.keyboard.press('s');
    await face.rest();
});

test('a click on the axes looks along them while frames come; a double click there is no more than that', async () => {
    await page.evaluate(async () => (await import('./store.js')).set({ layout: 'one' }));
    await face.rest();
    const sent = face.sent.length;
    const [x, y] = await face.middle('.axis-end:last-child circle');
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.evaluate(async () => {
        const { picture } = await import('./begin.js');
        picture.dispatchEvent(new CustomEvent('drawn', { detail: picture.header }));
    });
    await page.mouse.up();
    await face.until(() => face.sent.slice(sent).some((command) => command.do === 'view'), 'the view');
    await page.keyboard.press('r');
    await face.rest();
    await page.mouse.dblclick(...(await face.middle('.axis-end:last-child circle')));
    await face.rest();
    equal(face.count('focus'), 0, 'double clicks on the picture');
});

test('the probe is asked again where the picture moves under the pointer, and says nothing once it left', async () => {
    const [x, y] = await face.middle('#main'),
        said = () => page.locator('.status-cursor').textContent();
    await face.send({ do: 'set', scene: { transfer: { opacities: [[0, 1]] } } }); /* so that something is met everywhere */
    await page.locator('#main').focus();
    await page.keyboard.press('r');
    await face.rest();
    await page.mouse.move(x, y + 2);
    await page.waitForSelector('.status-cursor:has-text("value")');
    const before = face.count('probe');
    await page.keyboard.press('ArrowLeft');
    await face.until(() => face.count('probe') > before, 'another probe');
    await page.waitForSelector('.status-cursor:has-text("value")');
    await page.mouse.move(x, y + 8);
    await page.mouse.move(...(await face.middle('#open-save')));
    await face.rest();
    equal(await said(), '', 'what is said of the place that the pointer left');
});

test('what is cancelled is no error', async () => {
    await open('save');
    await page.fill('#panel-save [aria-label="Frames"]', '3000');
    await page.keyboard.press('Tab');
    await page.click('#panel-save button:has-text("Save movie")');
    await page.click('#progress button:has-text("Cancel")');
    await page.waitForSelector('.message.note:has-text("Cancelled.")');
    await page.waitForSelector('#progress', { state: 'hidden' });
    equal(await page.locator('.message.error').count(), 0, 'errors');
});

test('the focus stays near what goes', async () => {
    await open('clip');
    for (let i = 0; i < 2; i++) await page.click('#panel-clip button:has-text("Facing me")');
    await face.until(() => face.scene['clip-planes'].length === 2, 'two planes');
    for (const left of [1, 0]) {
        await page.locator('#panel-clip .card [title="Remove this plane"] >> nth=-1').focus();
        await page.keyboard.press('Enter');
        await face.until(() => face.scene['clip-planes'].length === left, 'a plane to go');
        await page.waitForFunction(() => document.activeElement.closest('#panel-clip'));
    }
});

await mainWithoutComplaints(face, browser, server, folder);
