/* SPDX-License-Identifier: MIT */
/* The page itself: keys, narrow windows, contrast, names of controls, and the parts that need no server (points of a transfer
 * function, geometry). */

import { spawnSync } from 'node:child_process';
import { mkdtempSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { Face, assert, equal, launch, mainWithoutComplaints, pellucid, test, view } from './harness.mjs';

const browser = await launch();
const folder = mkdtempSync(path.join(os.tmpdir(), 'pellucid-web-'));
const file = path.join(folder, 'orbital.nrrd');
const made = spawnSync(pellucid, ['make', 'hydrogen', '-o', file, '--size', '48'], { encoding: 'utf8' });
assert(made.status === 0, made.stderr);
const server = await view(file);
const face = await Face.open(browser, server.address);
const PANELS = ['transfer', 'surfaces', 'render', 'lights', 'clip', 'slices', 'measure', 'camera', 'file', 'save'];

/** Opens a panel whatever was open. */
async function open(page, name) {
    if (await page.locator(`#panel-${name}`).isHidden()) await page.click(`#open-${name}`);
}

test('keys open panels, the list of keys and the editor', async () => {
    const { page } = face;
    await page.locator('#main').focus();
    await page.keyboard.press('e');
    await page.waitForSelector('#panel-render:not([hidden])');
    await page.keyboard.press('t');
    await page.waitForSelector('#panel-transfer:not([hidden])');
    await page.keyboard.press('?');
    await page.waitForSelector('dialog[open]');
    await page.keyboard.press('Escape');
    assert(!(await page.locator('dialog').isVisible()), 'Escape closes the list');
    const opacity = face.scene.transfer.opacities.map((p) => p[1]).join();
    await page.locator('.points').focus();
    await page.keyboard.press('PageDown');
    await page.keyboard.press('Shift+ArrowUp');
    await face.until(() => face.scene.transfer.opacities.map((p) => p[1]).join() !== opacity, 'an arrow to move the point');
    await page.keyboard.press('Control+z');
    await face.until(() => face.scene.transfer.opacities.map((p) => p[1]).join() === opacity, 'the undo');
});

test('keys with Alt are the browser’s; AltGr writes brackets', async () => {
    const { page } = face;
    await face.rest();
    /** Presses a key as a keyboard of another kind would; whether the page took it. */
    const press = (selector, key, modifiers) =>
        page.locator(selector).first().evaluate(
            (element, init) => !element.dispatchEvent(new KeyboardEvent('keydown', { ...init, bubbles: true, cancelable: true })),
            { key, ...modifiers },
        );
    const commands = () => face.sent.filter((command) => command.do !== 'shown').length,
        before = commands();
    for (const key of ['ArrowLeft', '1', '+', 'z'])
        equal(await press('#main', key, { altKey: true, ctrlKey: key === 'z' }), false, `Alt and ${key} is taken`);
    for (const selector of ['.points', '.slice'])
        equal(await press(selector, 'ArrowLeft', { altKey: true }), false, `Alt and an arrow on ${selector} is taken`);
    await face.settle();
    equal(commands(), before, 'commands');
    const ways = [{}, { ctrlKey: true, altKey: true, modifierAltGraph: true }, { modifierAltGraph: true }, { altKey: true }];
    for (const [i, modifiers] of ways.entries()) {
        equal(await press('#main', '[', modifiers), true, `[ with ${JSON.stringify(modifiers)} is taken`);
        await face.until(() => face.count('roll') === i + 1, 'the picture to roll');
    }
    await page.keyboard.press('r');
    await face.rest();
});

test('Tab reaches the picture, the rail and the controls of the panel', async () => {
    const { page } = face,
        seen = new Set();
    await page.evaluate(() => document.activeElement?.blur());
    for (let i = 0; i < 60; i++) {
        await page.keyboard.press('Tab');
        seen.add(
            await page.evaluate(
                () => document.activeElement.id || document.activeElement.className?.baseVal || document.activeElement.className,
            ),
        );
    }
    for (const wanted of ['main', 'open-transfer', 'open-save', 'points', 'colormap'])
        assert(seen.has(wanted), `Tab does not reach ${wanted}`);
});

test('every control has a name, every option row a control', async () => {
    const { page } = face,
        hello = face.events.find(({ event }) => event === 'hello');
    for (const name of PANELS) {
        await open(page, name);
        const nameless = await page.evaluate(() =>
            [...document.querySelectorAll('button, input, select')]
                .filter((e) => e.offsetParent && !(e.getAttribute('aria-label') || e.textContent.trim() || e.title || e.labels?.length))
                .map((e) => e.outerHTML),
        );
        equal(nameless.join('\n'), '', `controls without a name in ${name}`);
    }
    const rows = [...hello.options.render.filter((row) => row.name !== 'mode'), ...hello.options.camera].map((row) => row.name);
    const shown = await page.evaluate(() => [...document.querySelectorAll('[data-option]')].map((e) => e.dataset.option));
    equal(rows.filter((row) => !shown.includes(row)).join(), '', 'rows without a control');
    const helpless = await page.evaluate(() =>
        [...document.querySelectorAll('[data-option] :is(input, select)')]
            .filter((e) => !document.getElementById(e.getAttribute('aria-describedby'))?.textContent)
            .map((e) => e.outerHTML),
    );
    equal(helpless.join('\n'), '', 'options whose help is told to nobody');
    const mode = hello.options.render.find((row) => row.name === 'mode').choices.length;
    equal(await page.locator('.modes button').count(), mode, 'modes');
});

test('an option is set through its control and follows the session', async () => {
    const { page } = face;
    await open(page, 'render');
    const before = face.scene.render.skip;
    await page.click('[data-option="skip"] input');
    await face.until(() => face.scene.render.skip === !before, 'the session to follow');
    await page.click('#undo');
    await face.until(() => face.scene.render.skip === before, 'undo');
    await page.waitForFunction((was) => document.querySelector('[data-option="skip"] input').checked === was, before);
    await page.click('.modes [data-mode="mip"]');
    await face.until(() => face.scene.render.mode === 'mip', 'the mode');
    await page.click('#undo');
});

test('a light is put into the world, turned on its ball, coloured, undone', async () => {
    const { page } = face,
        light = () => face.scene.lights[0],
        start = JSON.stringify(face.scene.lights);
    await open(page, 'lights');
    await page.selectOption('#panel-lights .light select', 'world');
    await face.until(() => light().headlight === false, 'a light in the world');
    const [x, y] = await face.middle('.light-ball'),
        from = light().direction;
    await face.drag([x, y], [x + 30, y], { steps: 4, pause: 16 });
    await face.until(() => light().direction.join() !== from.join(), 'the light to turn');
    const camera = face.scene.camera,
        to = camera['camera-focal-point'].map((f, i) => f - camera['camera-position'][i]);
    const before = light().direction,
        facing = (d) => d.reduce((sum, v, i) => sum - v * to[i], 0);
    assert(facing(before) > 0, 'what is dragged on the ball lies on the side of the eye');
    await page.locator('.light-ball').focus();
    await page.keyboard.press('ArrowUp');
    await face.until(() => light().direction.join() !== before.join(), 'an arrow to turn it');
    await page.fill('#panel-lights .light input[type=color]', '#ff0000');
    await face.until(() => light().color.join() === '1,0,0', 'the colour');
    for (let i = 0; i < 4; i++) await page.keyboard.press('Control+z');
    await face.until(() => JSON.stringify(face.scene.lights) === start, 'four steps of undo');
});

test('no panel overflows a phone in portrait', async () => {
    const phone = await Face.open(browser, server.address, { viewport: { width: 360, height: 640 }, hasTouch: true, isMobile: true });
    for (const name of PANELS) {
        await open(phone.page, name);
        const wide = await phone.page.evaluate((panel) => {
            const out = [...document.querySelectorAll(`#panel-${panel} *`)].filter(
                (e) =>
                    e.getClientRects().length &&
                    !e.closest('svg svg, .hidden, clipPath') &&
                    !(e instanceof SVGElement) &&
                    (e.getBoundingClientRect().right > innerWidth + 0.5 || e.getBoundingClientRect().left < -0.5),
            );
            const page = document.scrollingElement.scrollWidth > innerWidth;
            const body = document.querySelector(`#panel-${panel} .panel-body`);
            return [
                page && 'the page',
                body.scrollWidth > body.clientWidth && 'the panel',
                ...out.map((e) => e.outerHTML.slice(0, 120)),
            ].filter(Boolean);
        }, name);
        equal(wide.join('\n'), '', `what is too wide in ${name}`);
    }
    /* The picture stays in sight above the sheet, once it was told how high that is. */
    await phone.page.waitForFunction(() => {
        const [picture, sheet] = ['#main', '#panels'].map((selector) => document.querySelector(selector).getBoundingClientRect());
        return picture.bottom < sheet.top + 20 && picture.height > 150;
    });
    equal(phone.complaints.join('\n'), '', 'complaints of the browser');
    await phone.close();
});

test('a finger turns the picture', async () => {
    const phone = await Face.open(browser, server.address, { viewport: { width: 390, height: 700 }, hasTouch: true, isMobile: true });
    await phone.rest();
    const client = await phone.page.context().newCDPSession(phone.page),
        [x, y] = await phone.middle('#main');
    const touch = (type, points) =>
        client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
    await touch('touchStart', [[x, y]]);
    for (let i = 1; i <= 6; i++) await touch('touchMove', [[x + 12 * i, y]]);
    await touch('touchEnd', []);
    await phone.until(() => phone.lastSent('rotate'), 'a rotation');
    await touch('touchStart', [
        [x - 40, y],
        [x + 40, y],
    ]);
    for (let i = 1; i <= 6; i++)
        await touch('touchMove', [
            [x - 40 - 6 * i, y],
            [x + 40 + 6 * i, y],
        ]);
    await touch('touchEnd', []);
    await phone.until(() => phone.sent.filter((c) => c.do === 'zoom').reduce((f, c) => f * c.by, 1) > 1.3, 'a pinch to zoom');
    await phone.settle();
    equal(phone.count('hold'), 2, 'holds, one a gesture');
    equal(phone.count('probe'), 0, 'probes so far');
    await touch('touchStart', [[x, y]]);
    await touch('touchEnd', []);
    await phone.until(() => phone.count('probe') > 0, 'a tap to probe');
    await phone.close();
});

/** In the page: texts on panels whose contrast with what is behind them is below 4.5 (WCAG 2 AA); what is disabled is exempt. */
function poorContrasts() {
    const channels = (color) => {
        const values = color.match(/[\d.]+/g).map(Number);
        return [...values.slice(0, 3), values[3] ?? 1];
    };
    const luminance = (color) => {
        const [r, g, b] = color.slice(0, 3).map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const behind = (element) => {
        for (let e = element; e; e = e.parentElement) {
            /* Over a picture: what the scene has behind the volume; writing there has an edge against the rest. */
            if (e.matches('pel-picture')) return e.dataset.ground === 'light' ? [255, 255, 255, 1] : [0, 0, 0, 1];
            const knob = e.matches('.axis-end text') && e.parentNode.querySelector('circle');
            if (knob) return channels(getComputedStyle(knob).fill);
            const color = channels(getComputedStyle(e).backgroundColor);
            if (color[3] === 1) return color;
        }
        return [255, 255, 255, 1];
    };
    const poor = [];
    const PLACES = '#top, #top *, #rail *, #panels *, #status *, #stage *, #messages *, #banner, #banner *, #progress *, dialog[open] *';
    for (const element of document.querySelectorAll(PLACES)) {
        const field = element.matches('input:not([type=range], [type=color], [type=checkbox]), select');
        const writes =
            field ||
            [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim());
        if (!writes || !element.getClientRects().length || element.closest(':disabled, .hidden')) continue;
        const style = getComputedStyle(element),
            ink = element instanceof SVGElement ? style.fill : style.color;
        const [u, v] = [luminance(channels(ink)), luminance(behind(element))];
        const ratio = (Math.max(u, v) + 0.05) / (Math.min(u, v) + 0.05);
        if (ratio < 4.5) poor.push(`${ratio.toFixed(2)}: ${element.outerHTML.slice(0, 90)}`);
    }
    return poor;
}

test('writing has the contrast of WCAG AA in both themes', async () => {
    for (const colorScheme of ['dark', 'light']) {
        const themed = await Face.open(browser, server.address, { colorScheme });
        for (const name of PANELS) {
            await open(themed.page, name);
            equal((await themed.page.evaluate(poorContrasts)).join('\n'), '', `poor contrasts, ${colorScheme}, ${name}`);
        }
        /* Notes, errors and the banner; and what is written over pictures, on a ground like the theme's. */
        await themed.send({ do: 'set', scene: { background: colorScheme === 'dark' ? [0, 0, 0, 1] : [1, 1, 1, 1] } });
        await themed.page.evaluate(async () => (await import('./store.js')).set({ link: { state: 'lost' }, layout: 'four' }));
        await themed.send({ do: 'set', scene: { nonsense: 1 } });
        await themed.page.waitForSelector('.message.error');
        await themed.page.waitForFunction((ground) => document.querySelector('#main').dataset.ground === ground, colorScheme);
        await themed.until(() => themed.frames.some(({ header }) => header.view === 'slice-k'), 'the slices');
        await themed.page.waitForSelector('.slice-label:not(:empty)');
        equal((await themed.page.evaluate(poorContrasts)).join('\n'), '', `poor contrasts, ${colorScheme}, over the pictures`);
        await themed.page.evaluate(async () => (await import('./store.js')).set({ link: { state: 'open' }, layout: 'one' }));
        await themed.page.click('#help-button');
        equal((await themed.page.evaluate(poorContrasts)).join('\n'), '', `poor contrasts, ${colorScheme}, list of keys`);
        const ground = await themed.page.evaluate(
            () => getComputedStyle(document.querySelector('#top')).backgroundColor.match(/\d+/g).map(Number)[0],
        );
        assert(colorScheme === 'dark' ? ground < 80 : ground > 200, `the ${colorScheme} theme has panels of brightness ${ground}`);
        await themed.close();
    }
});

test('points of a transfer function', async () => {
    const wrong = await face.page.evaluate(async () => {
        const m = await import('./transfer-model.js'),
            out = [];
        const is = (what, actual, expected) =>
            JSON.stringify(actual) === JSON.stringify(expected) || out.push(`${what}: ${JSON.stringify(actual)}`);
        const curve = [
            [0, 0],
            [10, 0.5],
            [20, 0],
            [30, 1],
        ];
        is('between', m.evaluate(curve, 5), [0.25]);
        is('before', m.evaluate(curve, -5), [0]);
        is('after', m.evaluate(curve, 99), [1]);
        is('insert', m.insert(curve, 15), {
            points: [
                [0, 0],
                [10, 0.5],
                [15, 0.25],
                [20, 0],
                [30, 1],
            ],
            index: 2,
        });
        is('insert last', m.insert(curve, 40, [1]).index, 4);
        is('remove', m.remove(curve, 1).length, 3);
        is('remove the last', m.remove([[1, 1]], 0), [[1, 1]]);
        is('move stops at the neighbour', m.setOpacity(curve, 1, 25, 2)[1], [20, 1]);
        is('band', m.bandOf(curve, 1), [0, 2]);
        is('band moves', m.moveBand(curve, 0, 2, 5), [
            [5, 0],
            [15, 0.5],
            [25, 0],
            [30, 1],
        ]);
        is(
            'band stops',
            m.moveBand(curve, 0, 2, 50).map((p) => p[0]),
            [10, 20, 30, 30],
        );
        is(
            'simplify',
            m.simplify(
                [
                    [0, 0],
                    [1, 0.1],
                    [2, 0.2],
                    [3, 0.9],
                ],
                0.01,
            ),
            [
                [0, 0],
                [2, 0.2],
                [3, 0.9],
            ],
        );
        is(
            'stretch',
            m.stretch(curve, 0, 60).map((p) => p[0]),
            [0, 20, 40, 60],
        );
        is('band at a value', m.bandAt(curve, 12), [0, 2]);
        is('band at the last rise', m.bandAt(curve, 28), [2, 3]);
        return out;
    });
    equal(wrong.join('\n'), '', 'points');
});

test('the camera of a frame projects and unprojects', async () => {
    const wrong = await face.page.evaluate(async () => {
        const g = await import('./geometry.js'),
            out = [];
        const near = (what, a, b) => a.every((x, i) => Math.abs(x - b[i]) < 1e-9) || out.push(`${what}: ${a}`);
        for (const parallel of [false, true]) {
            const view = new g.View(
                {
                    'camera-position': [3, -8, 5],
                    'camera-focal-point': [1, 1, 1],
                    'camera-view-up': [0, 0, 1],
                    'camera-view-angle': 40,
                    parallel,
                    'parallel-scale': 3,
                },
                1.5,
            );
            near('the focal point is in the middle', view.project([1, 1, 1]).slice(0, 2), [0.5, 0.5]);
            near('there and back', view.project(view.unproject(0.2, 0.9)).slice(0, 2), [0.2, 0.9]);
        }
        const m = [2, 0.5, 0, 7, 0, 3, 0.1, -4, 0, 0, 1.5, 9, 0, 0, 0, 1];
        near('inverse', g.transform(g.invert(m), g.transform(m, [3, 5, 8])), [3, 5, 8]);
        near('ticks', g.ticks(0, 255, 5), [0, 50, 100, 150, 200, 250]);
        (g.directionName('LPS', [0, 0.2, -0.9]) === 'I' &&
            g.directionName('RAS', [-1, 0, 0]) === 'L' &&
            g.directionName('unknown', [1, 0, 0]) === '+x') ||
            out.push('letters');
        const planes = [['LPS', [0, 0, -3]], ['RAS', [0.2, 0.9, 0.1]], ['LPS', [2, 1.9, 0]], ['LPS', [1, -1, 0]], ['RAS', [1, 1, 1]], ['unknown', [0, 0, 1]]];
        const names = planes.map(([space, direction]) => g.planeName(space, direction)).join();
        if (names !== 'Axial,Coronal,Sagittal,,,') out.push(`planes: ${names}`);
        return out;
    });
    equal(wrong.join('\n'), '', 'geometry');
});

await mainWithoutComplaints(face, browser, server, folder);
