/* SPDX-License-Identifier: MIT */
/* The viewer as its user has it: the shipped program, the page in Chromium, a hand on the mouse. Times are printed, never asserted. */

import http from 'node:http';
import path from 'node:path';
import { existsSync, readFileSync } from 'node:fs';
import { Face, assert, data, equal, launch, main, note, test, view } from './harness.mjs';

const file = path.join(data, 'aneurism.nrrd');
if (!existsSync(file)) {
    console.log(`1..0 # SKIP no test data at ${data}: set PELLUCID_TEST_DATA`);
    process.exit(0);
}
const browser = await launch();
const server = await view(file);
const face = await Face.open(browser, server.address);
note(`first picture ${face.firstPicture.toFixed(0)} ms after the page was asked for`);
const picture = '#main';

/** Status of a plain request. */
function status(address, headers = {}) {
    return new Promise((resolve, reject) =>
        http
            .get(address, { headers }, (answer) => {
                answer.resume();
                resolve(answer.statusCode);
            })
            .on('error', reject),
    );
}

test('the first picture is seen and comes to rest losslessly', async () => {
    const rest = await face.rest();
    const [width, height] = rest.header.size;
    const drawn = await face.page.evaluate(() => {
        const canvas = document.querySelector('#main canvas'),
            copy = new OffscreenCanvas(canvas.width, canvas.height);
        const context = copy.getContext('2d', { willReadFrequently: true });
        context.drawImage(canvas, 0, 0);
        const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
        let bright = 0;
        for (let i = 0; i < data.length; i += 4) bright += data[i] + data[i + 1] + data[i + 2] > 60;
        return [canvas.width, canvas.height, bright / (data.length / 4)];
    });
    equal(`${drawn[0]}x${drawn[1]}`, `${width}x${height}`, 'the picture is drawn pixel by pixel');
    assert(drawn[2] > 0.02 && drawn[2] < 0.9, `a part of the picture is bright, not ${drawn[2]}`);
});

test('a drag turns the picture; undo gives it back byte for byte', async () => {
    const before = await face.rest(),
        [x, y] = await face.middle(picture);
    const count = face.main().length,
        start = performance.now();
    await face.drag([x, y], [x + 150, y + 40], { steps: 20, pause: 16 });
    const frames = face.main().slice(count),
        end = performance.now();
    assert(frames.length > 0, 'no frame came while the hand was down');
    note(
        `first frame of the drag ${(frames[0].time - start).toFixed(0)} ms, ${frames.length} frames in ${(end - start).toFixed(0)} ms`,
    );
    const after = await face.rest();
    assert(after.hash !== before.hash, 'the picture is the same after the drag');
    assert(
        JSON.stringify(after.header.camera['camera-position']) !== JSON.stringify(before.header.camera['camera-position']),
        'the camera did not move',
    );
    equal(
        JSON.stringify(after.header.camera['camera-focal-point']),
        JSON.stringify(before.header.camera['camera-focal-point']),
        'turning keeps the focal point',
    );
    await face.page.keyboard.press('Control+z');
    equal((await face.rest()).hash, before.hash, 'one undo takes the whole drag back');
    await face.page.keyboard.press('Control+Shift+z');
    equal((await face.rest()).hash, after.hash, 'redo turns it again');
    await face.page.keyboard.press('Control+z');
});

test('buttons, wheel and keys move the camera as VTK does', async () => {
    const [x, y] = await face.middle(picture);
    const moved = async (act) => {
        const from = (await face.rest()).header.camera;
        await act();
        return [from, (await face.rest()).header.camera];
    };
    const far = (c) => Math.hypot(...c['camera-position'].map((v, i) => v - c['camera-focal-point'][i]));
    let [a, b] = await moved(() => face.drag([x, y], [x + 60, y], { button: 'middle' }));
    assert(JSON.stringify(a['camera-focal-point']) !== JSON.stringify(b['camera-focal-point']), 'the middle button pans');
    [a, b] = await moved(() => face.drag([x, y], [x, y - 60], { button: 'right' }));
    assert(far(b) < far(a) * 0.98, 'a right drag upwards goes nearer');
    [a, b] = await moved(() => face.page.mouse.wheel(0, 300));
    assert(far(b) > far(a) * 1.05, 'the wheel towards the hand goes farther');
    [a, b] = await moved(() => face.page.keyboard.press('ArrowLeft'));
    assert(JSON.stringify(a['camera-position']) !== JSON.stringify(b['camera-position']), 'an arrow turns');
    [a, b] = await moved(() => face.page.keyboard.press('1'));
    const along = b['camera-position'].map((v, i) => Math.abs(v - b['camera-focal-point'][i]));
    assert(along[1] < 1e-6 * along[0] && along[2] < 1e-6 * along[0], '1 looks along x');
    [, b] = await moved(() => face.page.keyboard.press('r'));
    const start = face.main()[0].header.camera;
    assert(far(b) > 0 && Math.abs(far(b) / far(start) - 1) < 1e-6, 'r gives the camera of the start');
});

test('a dragged opacity point changes the picture and is undone at once', async () => {
    const before = await face.rest(),
        undo = face.events.filter((e) => e.event === 'state').at(-1).undo;
    const points = face.scene.transfer.opacities;
    const index = Math.floor(points.length / 2);
    const at = await face.middle(`#panel-transfer circle[data-index="${index}"]`);
    await face.drag(at, [at[0], at[1] - 70], { steps: 12, pause: 16 });
    const after = await face.rest();
    assert(after.hash !== before.hash, 'the picture is the same');
    assert(face.scene.transfer.opacities[index][1] > points[index][1] + 0.01, 'the session has not the new opacity');
    equal(face.events.filter((e) => e.event === 'state').at(-1).undo, undo + 1, 'one drag is one step of undo');
    await face.page.keyboard.press('Control+z');
    equal((await face.rest()).hash, before.hash, 'undo gives the picture back byte for byte');
});

test('points are added by a double click and removed by Delete', async () => {
    await face.rest();
    const count = face.scene.transfer.opacities.length;
    const box = await face.page.locator('#panel-transfer .points').boundingBox();
    await face.page.mouse.dblclick(box.x + box.width * 0.6, box.y + 25);
    await face.until(() => face.scene.transfer.opacities.length === count + 1, 'one more point');
    await face.page.keyboard.press('Delete');
    await face.until(() => face.scene.transfer.opacities.length === count, 'the point to go');
});

test('a colour map is chosen and keeps the opacities', async () => {
    await face.rest();
    const opacities = JSON.stringify(face.scene.transfer.opacities);
    await face.page.click('.colormap[data-map="viridis"]');
    await face.until(() => face.scene.transfer.colormap === 'viridis', 'the map');
    equal(JSON.stringify(face.scene.transfer.opacities), opacities, 'opacities');
    await face.page.keyboard.press('Control+z');
    await face.until(() => face.scene.transfer.colormap !== 'viridis', 'the undo');
});

test('two pages agree', async () => {
    const other = await Face.open(browser, server.address);
    const [x, y] = await face.middle(picture);
    await other.drag([x, y], [x - 120, y], { steps: 8, pause: 16 });
    /* What one hand does the other page is told when it is told: wait for the picture, not for a time. */
    const same = async (mover, follower, what) => {
        const { hash } = await mover.rest();
        await follower.until(() => follower.main().at(-1).hash === hash, what, 60000);
        return hash;
    };
    const turned = await same(other, face, 'the first page to show what the second turned');
    await face.until(() => JSON.stringify(face.scene) === JSON.stringify(other.scene), 'the scenes to agree');
    await face.page.keyboard.press('r');
    assert((await same(face, other, 'the second page to follow')) !== turned, 'the camera of the start is another');
    equal(other.complaints.join('\n'), '', 'complaints of the browser');
    await other.close();
});

test('the clip box has handles that clip', async () => {
    await face.page.click('#open-clip');
    await face.page.click('#panel-clip input[role=switch]');
    await face.until(() => face.scene['clip-box'], 'the box');
    const before = await face.rest(),
        box = [...face.scene['clip-box']];
    const handle = await face.middle('.clip-handle[data-face="5"]');
    await face.drag(handle, [handle[0], handle[1] + 120], { steps: 10, pause: 16 });
    const after = await face.rest(),
        now = face.scene['clip-box'];
    assert(now[5] < box[5] - 1, `the face went from ${box[5]} to ${now[5]}`);
    equal(JSON.stringify(now.slice(0, 5)), JSON.stringify(box.slice(0, 5)), 'the other faces');
    assert(after.hash !== before.hash, 'nothing was clipped');
    await face.page.click('#panel-clip button:has-text("No clipping")');
    await face.until(() => !face.scene['clip-box'], 'the box to go');
});

test('three slices with a linked cross-hair', async () => {
    await face.page.click('#open-slices');
    await face.page.click('#panel-slices input[role=switch] >> nth=0');
    const views = ['slice-i', 'slice-j', 'slice-k'];
    await face.until(() => views.every((v) => face.frames.some(({ header }) => header.view === v)), 'three slices');
    await face.rest();
    const count = face.frames.length,
        at = face.lastSent('slices').at;
    const box = await face.page.locator('.slice >> nth=2').boundingBox();
    await face.page.mouse.click(box.x + box.width * 0.4, box.y + box.height * 0.55);
    await face.until(() => JSON.stringify(face.lastSent('slices').at) !== JSON.stringify(at), 'the cross-hair to move');
    equal(face.lastSent('slices').at[2], at[2], 'within its slice the cross-hair keeps the third coordinate');
    await face.until(() => face.frames.slice(count).some(({ header }) => header.view === 'slice-i'), 'the other slice to follow');
    await face.page.click('#panel-slices input[role=switch] >> nth=0');
    await face.until(() => face.lastSent('slices').at === null, 'the slices to go');
});

test('the probe tells what is under the pointer, two clicks a distance', async () => {
    await face.rest();
    await face.page.click('#open-measure');
    await face.page.click('#panel-measure button:has-text("Measure a distance")');
    const places = await face.page.evaluate(async () => {
        /* the brightest place of two parts of the picture is on the object */
        const canvas = document.querySelector('#main canvas'),
            box = canvas.getBoundingClientRect(),
            copy = new OffscreenCanvas(canvas.width, canvas.height);
        const context = copy.getContext('2d', { willReadFrequently: true });
        context.drawImage(canvas, 0, 0);
        const pixels = context.getImageData(0, 0, canvas.width, canvas.height).data;
        const best = (from, to) => {
            let most = -1,
                place = null;
            for (let y = Math.floor(canvas.height * 0.2); y < canvas.height * 0.8; y++)
                for (let x = Math.floor(canvas.width * from); x < canvas.width * to; x++) {
                    const i = 4 * (y * canvas.width + x),
                        sum = pixels[i] + pixels[i + 1] + pixels[i + 2];
                    if (sum > most)
                        [most, place] = [
                            sum,
                            [box.x + (x + 0.5) * (box.width / canvas.width), box.y + (y + 0.5) * (box.height / canvas.height)],
                        ];
                }
            return place;
        };
        return [best(0.3, 0.5), best(0.5, 0.7)];
    });
    await face.page.mouse.move(...places[0]);
    await face.page.waitForFunction(() => /value [\d.]+ .*voxel/.test(document.querySelector('.status-cursor').textContent), null, {
        timeout: 60000,
    });
    for (const [i, place] of places.entries()) {
        await face.page.mouse.click(...place);
        await face.page.waitForFunction((text) => document.querySelector('#panel-measure [role=status]').textContent.includes(text), [
            'second place',
            'first place',
        ][i]);
    }
    await face.page.waitForSelector('#panel-measure .card:has-text("1: ")', { timeout: 60000 });
    const words = await face.page.textContent('#panel-measure .card'),
        { 'parallel-scale': half, parallel, 'camera-position': eye, 'camera-focal-point': focus, 'camera-view-angle': angle } =
            face.main().at(-1).header.camera;
    const far = Math.hypot(...eye.map((x, i) => x - focus[i])),
        height = 2 * (parallel ? half : far * Math.tan((angle * Math.PI) / 360));
    const picture = await face.page.locator('#main').boundingBox(),
        apart = (Math.hypot(places[1][0] - places[0][0], places[1][1] - places[0][1]) / picture.height) * height;
    /* Both lie near the focal plane, at depths of their own. */
    const found = parseFloat(words.slice(3));
    assert(found > 0.5 * apart && found < 4 * apart, `the distance is ${words}, ${apart} in the focal plane`);
    await face.page.keyboard.press('Escape');
});

test('a picture of another size is saved', async () => {
    await face.page.click('#open-save');
    await face.page.selectOption('#panel-save select', '1920x1080');
    const [saved] = await Promise.all([face.page.waitForEvent('download', { timeout: 60000 }), face.page.click('#panel-save .primary')]);
    const png = readFileSync(await saved.path());
    equal(png.subarray(1, 4).toString(), 'PNG', 'the kind of file');
    equal(`${png.readUInt32BE(16)}x${png.readUInt32BE(20)}`, '1920x1080', 'its size');
});

test('without the token, with another host or origin: refused', async () => {
    const address = new URL(server.address);
    equal(await status(server.address), 200, 'with the token');
    equal(await status(new URL('/', address)), 403, 'no token');
    equal(await status(new URL('/main.js', address)), 403, 'a file without token');
    equal(await status(new URL('/nonsense/main.js', address)), 403, 'a wrong token');
    equal(await status(server.address, { Host: 'evil.example' }), 403, 'a foreign host');
    const stranger = await (await browser.newContext()).newPage();
    const refused = await stranger.evaluate(
        (to) =>
            new Promise((done) => {
                const socket = new WebSocket(to, 'pellucid-1');
                socket.onopen = () => done('open');
                socket.onerror = () => done('refused');
            }),
        new URL('socket', server.address).href.replace('http', 'ws'),
    );
    equal(refused, 'refused', 'a WebSocket from another origin');
    await stranger.context().close();
});

test('a lost connection is told in words', async () => {
    equal(face.complaints.join('\n'), '', 'complaints of the browser before');
    const ended = await server.stop();
    assert(ended === 0 || ended === 130, `the viewer ended with ${ended}`);
    await face.page.waitForSelector('#banner:not([hidden])', { timeout: 60000 });
    assert(/connection/.test(await face.page.textContent('#banner')), 'the banner speaks of the connection');
});

await main(async () => {
    await browser.close();
    await server.stop();
});
