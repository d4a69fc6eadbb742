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
        file: 'aneurism.nrrd',
        viewport: WIDE,
        colorScheme: 'dark',
        async act(face) {
            await face.drag([420, 420], [330, 400], { pause: 16 });
        },
    },
    {
        name: 'bonsai',
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
for (const { name, file, viewport, colorScheme, mobile, act } of PICTURES) {
    const server = await view(path.join(data, file));
    const face = await Face.open(browser, server.address, { viewport, colorScheme, hasTouch: Boolean(mobile), isMobile: Boolean(mobile) });
    await face.rest();
    await act(face);
    await face.rest();
    await face.page.screenshot({ path: path.join(target, `viewer-${name}.png`) });
    console.log(`viewer-${name}.png`, face.complaints.join(' '));
    await face.close();
    await server.stop();
}
await browser.close();
