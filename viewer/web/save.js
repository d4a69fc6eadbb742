/* SPDX-License-Identifier: MIT */
/* Pictures, turntables and scene files to keep; and the bar that tells how far the server is with one. */

import { button, field, h } from './dom.js';
import { checkbox, numberInput, select } from './controls.js';

const SIZES = [
    ['window', 'as in the window'],
    ['1920x1080', '1920 × 1080'],
    ['3840x2160', '3840 × 2160'],
    ['2048x2048', '2048 × 2048'],
    ['4096x4096', '4096 × 4096'],
    ['own', 'own size'],
];
const FORMATS = [
    ['webp', 'animation (WebP)'],
    ['png', 'pictures (PNG in a ZIP)'],
];
const MOST_PIXELS = 2 ** 26;

/** What takes a while: of each a caption, a bar that tells how far it is, a button to stop it. */
export class Progress {
    #jobs = new Map();

    constructor(host) {
        this.host = host;
    }

    /** @param {*} what  the job; any value of its own */
    show(what, text, done, cancel) {
        if (!this.#jobs.has(what)) this.#add(what);
        const job = this.#jobs.get(what);
        job.caption.textContent = `${text}: ${Math.round(done * 100)} %`;
        job.bar.value = done;
        job.bar.setAttribute('aria-label', text);
        job.stop.title = `Cancel: ${text}`;
        job.cancel = cancel;
    }

    #add(what) {
        const job = {
            caption: h('span', { class: 'grow' }),
            bar: h('progress', { max: 1 }),
            stop: button('Cancel', () => job.cancel(), { kind: 'small' }),
        };
        job.element = h('div', { class: 'job' }, h('div', { class: 'row' }, job.caption, job.stop), job.bar);
        this.#jobs.set(what, job);
        this.host.append(job.element);
        this.host.hidden = false;
    }

    hide(what) {
        this.#jobs.get(what)?.element.remove();
        this.#jobs.delete(what);
        this.host.hidden = this.#jobs.size === 0;
    }
}

export function savePanel(app) {
    const own = { width: 1600, height: 1200 };
    const sizes = select(SIZES, () => update(), 'Size of the picture');
    sizes.update('window');
    const width = numberInput({ minimum: 16, maximum: 16384, label: 'Width', whole: true }, (x) => (own.width = x));
    const height = numberInput({ minimum: 16, maximum: 16384, label: 'Height', whole: true }, (x) => (own.height = x));
    const ownSize = h('div', { class: 'row' }, field('Width', width, { unit: 'pixels' }), field('Height', height, { unit: 'pixels' }));
    const update = () => {
        width.update(own.width);
        height.update(own.height);
        ownSize.hidden = sizes.value !== 'own';
    };
    update();
    const size = () =>
        sizes.value === 'window'
            ? app.picture.wanted()
            : sizes.value === 'own'
              ? [own.width, own.height]
              : sizes.value.split('x').map(Number);
    const background = checkbox(() => {}, 'With background');
    background.update(true);
    const savePicture = () => {
        const [w, hgt] = size();
        if (w * hgt > MOST_PIXELS)
            app.messages.error(`${w} × ${hgt} are more pixels than a picture may have (${MOST_PIXELS}). Choose a smaller size.`);
        else app.download({ do: 'picture', size: [w, hgt], background: background.checked });
    };
    const frames = numberInput({ minimum: 2, maximum: 3600, label: 'Frames', whole: true }, () => {});
    const degrees = numberInput({ label: 'Degrees' }, () => {});
    frames.update(72);
    degrees.update(360);
    const format = select(FORMATS, () => {}, 'Kind of movie');
    const saveMovie = () =>
        app.download({
            do: 'movie',
            size: size().map((x) => x - (x % 2)), // film encoders want even sides
            frames: Number(frames.value),
            degrees: Number(degrees.value),
            format: format.value,
            background: background.checked || format.value === 'webp',
        });
    const element = h(
        'div',
        { class: 'stack' },
        field('Size', sizes),
        ownSize,
        field('Background', background, { help: 'Off: what is empty is transparent' }),
        button('Save picture', savePicture, { icon: 'save', kind: 'primary', title: 'At full quality, as PNG (Ctrl S)' }),
        h('h3', {}, 'Turntable'),
        h('div', { class: 'row' }, field('Frames', frames), field('Turn', degrees, { unit: 'degrees' })),
        field('As', format, {
            help: 'An animation plays in every browser; pictures are without loss, for programs that make films: ffmpeg -i turn_%04d.png turn.mp4',
        }),
        button('Save movie', saveMovie, { icon: 'save', kind: 'small', title: 'A turn about the view-up' }),
        h('h3', {}, 'Scene'),
        h('p', { class: 'hint' }, 'All that decides what is seen, for “pellucid render --scene” or to open here again.'),
        button('Save scene', () => app.download({ do: 'scene' }), { icon: 'save', kind: 'small' }),
    );
    app.savePicture = savePicture;
    return element;
}
