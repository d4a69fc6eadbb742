/* SPDX-License-Identifier: MIT */
/* Pages of the viewer in headless Chromium, all at once on one session, the same drag replayed in each for a while: what frames they
 * get, how old these are, whether something is lost, and the server's memory.
 *
 *     node bench/viewer_pages.mjs BUILD-FOLDER [FILE] [--pages 8] [--seconds 600] [--size 768]
 *
 * A frame's age is how many newer ones there were when it was sent. Lost is a command that no frame shows in the end, and a page that
 * does not end with the others' picture. bench/viewer_soak.py does the same without browsers, which would have the processors otherwise. */

import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { begin } from './viewer_harness.mjs';

const { launch, sleep, view, file, pages, seconds, size } = await begin({ pages: 8, seconds: 600, size: 768 });

/** In the page: what its socket sends and gets. */
function watchSocket() {
    window.told = { frames: 0, oldest: 0, sent: 0, shown: 0, final: false, errors: [] };
    const Socket = WebSocket;
    window.WebSocket = class extends Socket {
        constructor(...words) {
            super(...words);
            this.addEventListener('message', ({ data: message }) => {
                const { told } = window;
                if (typeof message === 'string') {
                    const event = JSON.parse(message);
                    if (event.event === 'error') told.errors.push(event.message);
                    return;
                }
                const header = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, new DataView(message).getUint32(0, true))));
                told.frames++;
                told.oldest = Math.max(told.oldest, header.age);
                told.shown = Math.max(told.shown, header.id);
                told.final = header.final;
            });
        }

        send(text) {
            window.told.sent = Math.max(window.told.sent, JSON.parse(text).id ?? 0);
            super.send(text);
        }
    };
}

const memory = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

async function drag(page, until) {
    const { mouse } = page,
        middle = size / 2,
        radius = size / 4;
    while (performance.now() < until) {
        await mouse.move(middle + radius, middle);
        await mouse.down();
        for (let i = 0; i < 200 && performance.now() < until; i++) {
            await mouse.move(middle + radius * Math.cos(i / 30), middle + radius * Math.sin(i / 30));
            await sleep(16);
        }
        await mouse.up();
        await sleep(200);
    }
}

const browser = await launch(),
    server = await view(file),
    open = [];
for (let i = 0; i < pages; i++) {
    const context = await browser.newContext({ viewport: { width: size, height: size + 26 } });
    await context.addInitScript(watchSocket);
    const page = await context.newPage();
    await page.goto(server.address);
    await page.waitForSelector('body.has-picture', { timeout: 60000 });
    open.push(page);
}
const begun = performance.now(),
    samples = [];
const sampling = setInterval(() => samples.push([Math.round((performance.now() - begun) / 1000), memory(server.pid)]), 15000);
await Promise.all(open.map((page) => drag(page, begun + seconds * 1000)));
clearInterval(sampling);
const rests = () => window.told.final && window.told.shown === window.told.sent;
for (const page of open) await page.waitForFunction(rests, null, { timeout: 60000 }).catch(() => {}); /* told below */
await sleep(1000);
const ends = [];
for (const page of open) {
    const told = await page.evaluate(() => window.told);
    const picture = createHash('sha256')
        .update(await page.evaluate(() => document.querySelector('#main canvas, canvas#main')?.toDataURL() ?? ''))
        .digest('hex');
    ends.push({ ...told, picture });
}
const after = memory(server.pid),
    version = browser.version();
await browser.close();
const status = await server.stop();
const settled = samples.filter(([at]) => at >= 30).map(([, mb]) => mb);
console.log(
    JSON.stringify(
        {
            file: path.basename(file),
            pages,
            seconds,
            size,
            processors: os.cpus().length,
            processor: os.cpus()[0].model,
            chromium: version,
            frames: ends.map((end) => end.frames),
            oldest: Math.max(...ends.map((end) => end.oldest)),
            not_final: ends.filter((end) => !end.final).length,
            commands_lost: ends.filter((end) => end.shown !== end.sent).length,
            pictures: new Set(ends.map((end) => end.picture)).size,
            errors: ends.flatMap((end) => end.errors),
            memory_mb: {
                from_30_s: settled.length ? [Math.min(...settled), Math.max(...settled)].map((mb) => Number(mb.toFixed(1))) : null,
                samples: samples.map(([at, mb]) => [at, Number(mb.toFixed(1))]),
                after: Number(after.toFixed(1)),
            },
            status,
        },
        null,
        1,
    ),
);
