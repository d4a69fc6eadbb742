/* SPDX-License-Identifier: MIT */
/* Handles over the picture that are dragged along a direction of the world: of the clip box and of planes. */

import { clamp } from './dom.js';
import { add, dot, length, scale, sub } from './geometry.js';
import { get } from './store.js';

/** How far along a world direction a drag of pixels goes, seen at a point. */
export function along(toPixels, point, direction, step, drag) {
    const [a, b] = [toPixels(point), toPixels(add(point, scale(direction, step)))];
    if (!a || !b) return 0;
    const way = sub(b, a),
        square = dot(way, way);
    return square < 0.25 ? 0 : (dot(drag, way) / square) * step;
}

/** A drag of a handle: calls move(pixels moved since the press, phase). */
export function draggable(element, move) {
    let from = null,
        pointer = 0,
        phase = 'start';
    const go = (event) => {
        if (event.pointerId !== pointer) return;
        move([event.clientX - from[0], event.clientY - from[1]], phase);
        phase = 'move';
    };
    const lift = (event) => {
        if (event.pointerId !== pointer) return;
        listen(removeEventListener);
        if (phase === 'move') move([event.clientX - from[0], event.clientY - from[1]], 'end');
        from = null;
    };
    /* Of the window: the handle may go under the hand, when another page removes what it belongs to. */
    const listen = (how) => {
        how('pointermove', go);
        for (const end of ['pointerup', 'pointercancel']) how(end, lift);
    };
    element.addEventListener('pointerdown', (event) => {
        event.stopPropagation();
        event.preventDefault();
        if (from) return; /* a second finger */
        from = [event.clientX, event.clientY];
        pointer = event.pointerId;
        phase = 'start';
        element.setPointerCapture(pointer);
        listen(addEventListener);
    });
}

/** A handle stays in reach where its face is outside the picture or under the bar at the top: a drag is relative and works from there. */
export function within(picture, [x, y]) {
    return { cx: clamp(x, 14, picture.clientWidth - 14), cy: clamp(y, 68, picture.clientHeight - 14) };
}

/** Of the volume, in the world. */
export const middle = () => [0, 1, 2].map((i) => (get('volume').bounds[2 * i] + get('volume').bounds[2 * i + 1]) / 2);
export const diagonal = () => length([0, 1, 2].map((i) => get('volume').bounds[2 * i + 1] - get('volume').bounds[2 * i]));
