/* SPDX-License-Identifier: MIT */
/* Makes the pictures of the page in docs/gallery: node tests/web/gallery.mjs PELLUCID SOURCE-ROOT PACKAGES-FOLDER [TARGET-FOLDER]
 * What is above 400 kB is kept with a palette of its own: convert IN.png -colors 256 PNG8:OUT.png */

import path from 'node:path';
import { Face, data, launch, root, sleep, view } from './harness.mjs';

const target = process.argv[5] ?? path.join(root, 'docs/gallery');
const WIDE = { width: 1280, height: 800 },
    PHONE = { width: 390, height: 844 };

const PICTURES = [
    {
        name: 'aneurism',
        nearer: 400,
        file: 'aneurism.nrrd',
        viewport: WIDE,
        colorScheme: 'dark',
        async act(face) {
            await face.drag([420, 420], [330, 400], { pause: 16 });
        },
    },
    {
        name: 'bonsai',
        nearer: 300,
        file: 'bonsai.nii.gz',
        viewport: WIDE,
        colorScheme: 'light',
        async act(face) {
            await face.page.click('#open-render');
            await face.page.click('.swatch[title$="White"]');
            await face.page.evaluate(() => document.querySelector('#panel-render .panel-body').scrollTo(0, 0));
        },
    },
    {
        name: 'head-clip',
        nearer: 450,
        file: 'vishuman_head.nrrd',
        viewport: WIDE,
        colorScheme: 'dark',
        async act(face) {
            await face.page.click('#open-clip');
            await face.page.click('#panel-clip input[role=switch]');
            await face.until(() => face.scene['clip-box'], 'the box');
            const input = face.page.locator('#panel-clip [aria-label="x to"][type=number]');
            const [lo, hi] = face.scene['clip-box'];
            await input.fill(String(Math.round(lo + (hi - lo) * 0.55)));
            await input.press('Enter');
            await input.blur();
        },
    },
    {
        name: 'engine-lights',
        nearer: 350,
        file: 'engine.nhdr',
        viewport: WIDE,
        colorScheme: 'light',
        async act(face) {
            await face.page.click('#open-render');
            await face.page.click('.swatch[title$="Light"]');
            await face.page.click('#open-lights');
            await face.page.selectOption('#panel-lights .light select', 'world');
            await face.until(() => !face.scene.lights[0].headlight, 'a light in the world');
            await face.page.click('#panel-lights button:has-text("Light")');
            await face.until(() => face.scene.lights.length === 2, 'two lights');
            const [x, y] = await face.middle('.light >> nth=1 >> .light-ball');
            await face.drag([x, y], [x + 36, y + 4], { steps: 5, pause: 16 });
            await face.page.fill('.light >> nth=1 >> input[type=color]', '#ffb35c');
        },
    },
    {
        name: 'brain-slices',
        file: 'inia19-t1-brain.nii.gz',
        viewport: WIDE,
        colorScheme: 'dark',
        async act(face) {
            await face.page.click('#open-slices');
            await face.page.click('#panel-slices input[role=switch] >> nth=0');
            await sleep(1500);
        },
    },
    {
        name: 'phone-dark',
        nearer: 500,
        file: 'vishuman_head.nrrd',
        viewport: PHONE,
        colorScheme: 'dark',
        mobile: true,
        async act(face) {
            await face.page.click('#open-transfer');
        },
    },
    {
        name: 'phone-light',
        nearer: 250,
        file: 'aneurism.nrrd',
        viewport: PHONE,
        colorScheme: 'light',
        mobile: true,
        async act(face) {
            await face.page.click('#open-surfaces');
            await face.page.click('#panel-surfaces button:has-text("Automatic")');
            await sleep(300);
            if (await face.page.locator('#panel-surfaces button:has-text("Draw isosurfaces")').isVisible())
                await face.page.click('#panel-surfaces button:has-text("Draw isosurfaces")');
        },
    },
];

const browser = await launch();
for (const { name, file, viewport, colorScheme, mobile, nearer, act } of PICTURES) {
    const server = await view(path.join(data, file));
    const face = await Face.open(browser, server.address, { viewport, colorScheme, hasTouch: Boolean(mobile), isMobile: Boolean(mobile) });
    await face.rest();
    await act(face);
    await sleep(500); /* a sheet from below has made its place */
    if (nearer) {
        await face.page.mouse.move(...(await face.middle('#main')));
        await face.page.mouse.wheel(0, -nearer);
        await face.page.mouse.move(1, 1);
    }
    await face.rest();
    await sleep(500); /* decoded, drawn and told in the line at the bottom */
    await face.page.screenshot({ path: path.join(target, `viewer-${name}.png`) });
    console.log(`viewer-${name}.png`, face.complaints.join(' '));
    await face.close();
    await server.stop();
}
await browser.close();
