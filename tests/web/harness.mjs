/* SPDX-License-Identifier: MIT */
/* What the tests of the page share: TAP, the shipped viewer as a child, headless Chromium, and what goes over the WebSocket, seen from
 * outside. */

import { spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

/* node harness-user.mjs PELLUCID SOURCE-ROOT PACKAGES-FOLDER */
export const [pellucid, root, packages] = process.argv.slice(2);
export const data = process.env.PELLUCID_TEST_DATA || path.join(root, '..', 'shared', 'data');
export const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

const BROWSERS = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];
/* Commands after which no other picture comes; of a hand that moved nothing, either. */
const ASKS = ['shown', 'hold', 'release', 'probe', 'slices', 'list', 'picture', 'movie', 'scene', 'export', 'cancel'];
const tests = [];

export function test(name, run) {
    tests.push([name, run]);
}

export function assert(condition, message) {
    if (!condition) throw new Error(message);
}

export function equal(actual, expected, message) {
    assert(Object.is(actual, expected), `${message}: ${actual} in place of ${expected}`);
}

function skip(reason) {
    console.log(`1..0 # SKIP ${reason}`);
    process.exit(0);
}

/** Playwright's driver, or the whole program is skipped with a reason. */
function driver() {
    const installed = spawnSync('sh', [path.join(root, 'tests/web/install.sh'), path.join(root, 'tests/web'), packages], {
        encoding: 'utf8',
    });
    if (installed.status !== 0) skip(installed.stdout.trim() || String(installed.error));
    return createRequire(path.join(packages, 'package.json'))('playwright-core');
}

export async function launch() {
    const executablePath = process.env.PELLUCID_CHROMIUM || BROWSERS.find((file) => existsSync(file));
    if (!executablePath) skip('no Chromium here: scripts/deps check installs it, or set PELLUCID_CHROMIUM');
    return driver().chromium.launch({ executablePath, args: ['--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage'] });
}

/** The shipped viewer; {address, pid, stop()}. */
export async function view(file, ...options) {
    const child = spawn(pellucid, ['view', file, '--no-open', '--port', '0', ...options], { stdio: ['ignore', 'pipe', 'pipe'] });
    let text = '';
    const ended = new Promise((done) => child.on('exit', done));
    const address = await new Promise((resolve, reject) => {
        const read = (chunk) => {
            text += chunk;
            const found = /http:\/\/\S+/.exec(text);
            if (found && text.includes('\n')) resolve(found[0]);
        };
        child.stdout.on('data', read);
        child.stderr.on('data', read);
        child.on('error', reject);
        ended.then((status) => reject(new Error(`pellucid view ended with ${status}: ${text}`)));
    });
    return {
        address,
        pid: child.pid,
        async stop() {
            child.kill('SIGTERM');
            const status = await Promise.race([ended, sleep(10000).then(() => 'hung')]);
            if (status === 'hung') child.kill('SIGKILL');
            return status;
        },
    };
}

/** A page on the viewer, and what it and the server told each other. */
export class Face {
    frames = [];
    events = [];
    sent = [];
    complaints = [];

    /** `seen`: what is waited for. */
    static async open(browser, address, options = {}, seen = 'body.has-picture') {
        const face = new Face();
        const context = await browser.newContext({ viewport: { width: 1000, height: 600 }, ...options });
        await context.addInitScript(() => {
            const Socket = WebSocket;
            window.sockets = []; /* so that a test can end a connection */
            window.WebSocket = class extends Socket {
                constructor(...given) {
                    super(...given);
                    window.sockets.push(this);
                }
            };
        });
        face.page = await context.newPage();
        face.page.on('console', (message) => ['error', 'warning'].includes(message.type()) && face.complaints.push(message.text()));
        face.page.on('pageerror', (error) => face.complaints.push(error.stack));
        face.page.on('websocket', (socket) => {
            socket.on('framereceived', ({ payload }) => face.#receive(payload));
            socket.on('framesent', ({ payload }) => face.sent.push(JSON.parse(payload)));
        });
        face.started = performance.now();
        await face.page.goto(address);
        await face.page.waitForSelector(seen, { timeout: 60000 });
        face.firstPicture = performance.now() - face.started;
        return face;
    }

    #receive(payload) {
        if (typeof payload === 'string') {
            this.events.push(JSON.parse(payload));
            return;
        }
        const length = payload.readUInt32LE(0);
        const header = JSON.parse(payload.subarray(4, 4 + length).toString('utf8'));
        this.frames.push({
            header,
            hash: createHash('sha256')
                .update(payload.subarray(4 + length))
                .digest('hex'),
            time: performance.now(),
        });
    }

    main() {
        return this.frames.filter(({ header }) => header.view === 'main');
    }

    /** The last command of a kind that the page sent. */
    lastSent(kind) {
        return this.sent.filter((command) => command.do === kind).at(-1);
    }

    get scene() {
        return this.events.filter(({ event }) => event === 'state').at(-1).scene;
    }

    /** Waits until something is so. */
    async until(condition, what, ms = 30000) {
        const end = performance.now() + ms;
        while (!condition()) {
            assert(performance.now() < end, `waited ${ms / 1000} s in vain for ${what}`);
            await sleep(10);
        }
    }

    count(kind) {
        return this.sent.filter((command) => command.do === kind).length;
    }

    /** A command as if the page sent it. */
    async send(command) {
        await this.page.evaluate(async (wish) => (await import('./begin.js')).connection.send(wish), command);
    }

    /** Until all that the page merges or puts off was sent: no hand is down, the picture's size is that of the window. */
    async settle() {
        const wanted = await this.page.evaluate(async () => {
            for (let i = 0; i < 2; i++) await new Promise((done) => requestAnimationFrame(done));
            return (await import('./begin.js')).wanted().join();
        });
        const size = () => this.sent.filter((command) => ['hello', 'size'].includes(command.do)).at(-1).size.join();
        await this.until(() => this.count('hold') === this.count('release'), 'as many releases as holds');
        await this.until(() => size() === wanted, `the size ${wanted} to be asked for`);
    }

    /** The last picture of what was sent so far: the server says of it that none comes after it. */
    async rest() {
        await this.settle();
        const id = Math.max(0, ...this.sent.filter((command) => !ASKS.includes(command.do)).map((command) => command.id ?? 0));
        const final = () => {
            const last = this.main().at(-1);
            return last?.header.final && last.header.id >= id ? last : null;
        };
        await this.until(final, 'the picture at rest', 120000);
        assert(final().header.lossless, 'the picture at rest is not lossless');
        return final();
    }

    async drag(from, to, { steps = 10, pause = 0, button = 'left' } = {}) {
        const { mouse } = this.page;
        await mouse.move(...from);
        await mouse.down({ button });
        for (let i = 1; i <= steps; i++) {
            await mouse.move(from[0] + ((to[0] - from[0]) * i) / steps, from[1] + ((to[1] - from[1]) * i) / steps);
            if (pause) await sleep(pause);
        }
        await mouse.up({ button });
    }

    /** The middle of an element. */
    async middle(selector) {
        const element = this.page.locator(selector).first();
        let box = null;
        for (let i = 0; !box && i < 20; i++) {
            await element.waitFor();
            box = await element.boundingBox(); /* null where it was drawn anew meanwhile */
        }
        assert(box, `${selector} is not seen`);
        return [box.x + box.width / 2, box.y + box.height / 2];
    }

    async close() {
        await this.page.context().close();
    }
}

export function note(text) {
    for (const line of String(text).split('\n')) console.log(`# ${line}`);
}

/** Runs what `test` gathered. */
export async function main(finish) {
    console.log(`1..${tests.length}`);
    let failed = 0;
    for (const [i, [name, run]] of tests.entries()) {
        const start = performance.now();
        try {
            await run();
            console.log(`ok ${i + 1} - ${name}`);
            note(`${((performance.now() - start) / 1000).toFixed(1)} s`);
        } catch (error) {
            failed++;
            console.log(`not ok ${i + 1} - ${name}`);
            note(error.stack ?? error);
        }
    }
    await finish();
    process.exit(failed ? 1 : 0);
}

/** The same, of tests with one face and a folder of files: at last the face's browser may have complained about nothing. */
export async function mainWithoutComplaints(face, browser, server, folder) {
    test('the browser had nothing to complain about', () => equal(face.complaints.join('\n'), '', 'complaints'));
    await main(async () => {
        await browser.close();
        await server.stop();
        rmSync(folder, { recursive: true });
    });
}
