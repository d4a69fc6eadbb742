/* SPDX-License-Identifier: MIT */
/* The line at the bottom: what the frame that is seen cost, and what drew it; and what is under the pointer. */

import { h, short } from './dom.js';
import { get, watch } from './store.js';
import { describe } from './measure.js';

/** In words what the picture is: in motion, refined further, or the last one, which stays. */
function quality({ quality: kind, final }) {
    return final ? 'at rest' : ({ moving: 'moving', full: 'full quality', refined: 'refining' }[kind] ?? kind);
}

/** 1234567 as 1.2 M. */
function many(count) {
    for (const [size, unit] of [
        [1e9, ' G'],
        [1e6, ' M'],
        [1e3, ' k'],
    ])
        if (count >= size) return short(count / size, 2) + unit;
    return String(count);
}

export function statusLine(host) {
    const names = ['quality', 'frame', 'fps', 'latency', 'size', 'technique', 'samples', 'device'];
    const titles = {
        quality: 'Quality of the picture that is seen',
        frame: 'Time to draw and to pack the frame on the server',
        fps: 'Frames shown in the last second',
        latency: 'From an input to the frame that shows it (median)',
        size: 'Pixels drawn, of the pixels of the picture',
        technique: 'Technique',
        samples: 'Samples taken along rays',
        device: 'What draws',
    };
    const parts = Object.fromEntries(names.map((name) => [name, h('span', { class: `status-${name}`, title: titles[name] })]));
    const cursor = h('span', { class: 'status-cursor' });
    host.append(cursor, h('span', { class: 'spring' }), ...names.map((name) => parts[name]));
    const put = (name, text) => parts[name].textContent !== text && (parts[name].textContent = text);
    let due = 0;
    const paint = () => {
        due = 0;
        const frame = get('frame');
        if (!frame) return;
        const { header, fps, latency } = frame,
            ms = header.ms ?? {};
        put('quality', quality(header));
        put('frame', `${short((ms.draw ?? 0) + (ms.encode ?? 0), 3)} ms`);
        put('fps', header.quality === 'moving' && fps ? `${Math.round(fps)} frames/s` : '');
        put('latency', header.quality === 'moving' && latency !== null ? `${Math.round(latency)} ms to the eye` : '');
        const [drawn, whole] = [header.size.join(' × '), header.of.join(' × ')];
        put('size', drawn === whole ? drawn : `${drawn} of ${whole}`);
        put('technique', header.technique + (header.averaged > 1 ? `, mean of ${header.averaged}` : ''));
        put('samples', header.samples ? `${many(header.samples)} samples` : '');
        put('device', header.device ?? '');
    };
    /* Ten times a second is all that can be read. */
    watch(['frame'], () => (due ||= setTimeout(paint, 100)));
    watch(['cursor'], () => (cursor.textContent = get('cursor') ? describe(get('cursor')) : ''));
}
