/* SPDX-License-Identifier: MIT */
/* What the hand on the viewer's page feels, measured in the page, in headless Chromium: the age of each input when the frame that
 * first shows it was drawn (and when the browser's next animation frame began, which is when the screen can show it), frames a second
 * while dragging, the first picture, the first answer to a drag, and the time from letting go to full quality.
 *
 *     node bench/viewer.mjs BUILD-FOLDER [FILE] [--size 768] [--seconds 5] [--rounds 3]
 *
 * The picture is SIZE x SIZE, of the shipped program with its own choices. Prints one JSON object. Browser, server and engine share
 * the machine's processors, as they do for a user. */

import os from 'node:os';
import path from 'node:path';
import { begin } from './viewer_harness.mjs';

const { launch, sleep, view, file, size, seconds, rounds } = await begin({ size: 768, seconds: 5, rounds: 3 });

const quantile = (values, q) => {
    const sorted = [...values].sort((a, b) => a - b);
    return sorted.length ? Number(sorted[Math.min(Math.floor(q * sorted.length), sorted.length - 1)].toFixed(1)) : null;
};
const summary = (values) => ({
    median: quantile(values, 0.5),
    p95: quantile(values, 0.95),
    least: quantile(values, 0),
    most: quantile(values, 1),
    count: values.length,
});

/** In the page: gathers what each frame showed. */
async function watchFrames(page) {
    await page.evaluate(async () => {
        const { watch, get } = await import('./store.js');
        window.seen = [];
        watch(['frame'], () => {
            const { header, latencies } = get('frame'),
                drawn = performance.now();
            const entry = {
                quality: header.quality,
                size: header.size,
                type: header.type,
                ms: header.ms,
                technique: header.technique,
                latencies,
                drawn,
                id: header.id,
            };
            window.seen.push(entry);
            requestAnimationFrame(() => (entry.screen = performance.now() - drawn));
        });
        addEventListener('pointerdown', (event) => (window.down = event.timeStamp), true);
        addEventListener('pointerup', (event) => (window.up = event.timeStamp), true);
    });
}

async function drag(page, ms) {
    const { mouse } = page,
        middle = size / 2,
        radius = size / 4,
        start = performance.now();
    await mouse.move(middle + radius, middle);
    await mouse.down();
    for (let now = 0; now < ms; now = performance.now() - start) {
        const angle = now / 700;
        await mouse.move(middle + radius * Math.cos(angle), middle + radius * Math.sin(angle));
        await sleep(8);
    }
    await mouse.up();
}

async function round(browser) {
    const begun = performance.now(),
        server = await view(file),
        ready = performance.now();
    const context = await browser.newContext({ viewport: { width: size, height: size + 26 } });
    await context.addInitScript(() => {
        addEventListener('DOMContentLoaded', () =>
            new MutationObserver((_, observer) => {
                if (document.body.classList.contains('has-picture')) {
                    window.firstPicture = performance.now();
                    observer.disconnect();
                }
            }).observe(document.body, { attributes: true }),
        );
    });
    const page = await context.newPage();
    await page.goto(server.address);
    await page.waitForFunction(() => window.firstPicture, null, { timeout: 60000 });
    const firstPicture = await page.evaluate(() => window.firstPicture);
    const shape = await page.evaluate(() => [document.querySelector('#main').clientWidth, document.querySelector('#main').clientHeight]);
    await watchFrames(page);
    await sleep(1500);
    /* The very first drag: its first answer; then a long one. */
    await drag(page, 300);
    const first = await page.evaluate(() => window.seen.find((f) => f.latencies.length)?.latencies[0]);
    await sleep(2500);
    await page.evaluate(() => (window.seen.length = 0));
    await drag(page, seconds * 1000);
    await page.waitForFunction(() => window.seen.some((f) => f.drawn > window.up && f.quality !== 'moving'), null, { timeout: 60000 });
    await sleep(200);
    const { seen, up } = await page.evaluate(() => ({ seen: window.seen, up: window.up }));
    await context.close();
    await server.stop();
    const moving = seen.filter((f) => f.drawn <= up && f.latencies.length);
    const full = seen.find((f) => f.drawn > up && f.quality !== 'moving');
    return {
        server_ready_ms: ready - begun,
        first_picture_ms: firstPicture,
        first_picture_from_start_ms: ready - begun + (firstPicture ?? 0),
        first_answer_ms: first,
        shape,
        latencies: moving.flatMap((f) => f.latencies),
        screen: moving.map((f) => f.screen ?? 0),
        draw: moving.map((f) => f.ms.draw),
        encode: moving.map((f) => f.ms.encode),
        fps: moving.length > 1 ? ((moving.length - 1) * 1000) / (moving.at(-1).drawn - moving[0].drawn) : 0,
        full_quality_ms: full.drawn - up,
        drawn_size: moving.at(-1)?.size,
        type: moving.at(-1)?.type,
        technique: moving.at(-1)?.technique,
    };
}

const browser = await launch();
const all = [];
for (let i = 0; i < rounds; i++) all.push(await round(browser));
const version = browser.version();
await browser.close();
const of = (key) => all.flatMap((r) => r[key]);
console.log(
    JSON.stringify(
        {
            file: path.basename(file),
            picture: all[0].shape,
            drawn: all.at(-1).drawn_size,
            type: all.at(-1).type,
            technique: all.at(-1).technique,
            rounds,
            processors: os.cpus().length,
            processor: os.cpus()[0].model,
            load: os.loadavg()[0],
            chromium: version,
            first_picture_ms: summary(of('first_picture_ms')),
            from_start_ms: summary(of('first_picture_from_start_ms')),
            first_answer_ms: summary(of('first_answer_ms')),
            input_to_drawn_ms: summary(of('latencies')),
            drawn_to_screen_ms: summary(of('screen')),
            frames_per_second: summary(of('fps')),
            server_draw_ms: summary(of('draw')),
            server_encode_ms: summary(of('encode')),
            full_quality_ms: summary(of('full_quality_ms')),
        },
        null,
        2,
    ),
);
