/* SPDX-License-Identifier: MIT */
/* What an edit makes of a transfer function's points. Points are the scene file's: opacities [[value, opacity], ...] and colors
 * [[value, r, g, b], ...], ascending in value. Nothing here knows the page; every function returns new points. */

const clamp = (x, lo, hi) => Math.min(Math.max(x, lo), hi);

/** The curve at a value: all numbers after the first of a point, interpolated; the ends go on level. */
export function evaluate(points, value) {
    if (!points.length) return [];
    if (value <= points[0][0]) return points[0].slice(1);
    if (value >= points.at(-1)[0]) return points.at(-1).slice(1);
    const i = points.findIndex((p) => p[0] > value);
    const [a, b] = [points[i - 1], points[i]];
    const t = b[0] > a[0] ? (value - a[0]) / (b[0] - a[0]) : 1;
    return a.slice(1).map((x, k) => x + t * (b[k + 1] - x));
}

/** Adds a point on the curve, or with the numbers given; {points, index of the new one}. */
export function insert(points, value, numbers = evaluate(points, value)) {
    const at = points.findIndex((p) => p[0] > value);
    const index = at < 0 ? points.length : at;
    return { points: [...points.slice(0, index), [value, ...numbers], ...points.slice(index)], index };
}

/** Removes a point; the last one stays. */
export function remove(points, index) {
    return points.length > 1 ? points.filter((_, i) => i !== index) : points;
}

/** Moves a point's value, between its neighbours; and sets what else is given. */
export function move(points, index, value, numbers) {
    const low = index > 0 ? points[index - 1][0] : -Infinity;
    const high = index < points.length - 1 ? points[index + 1][0] : Infinity;
    const moved = [clamp(value, low, high), ...(numbers ?? points[index].slice(1))];
    return points.map((p, i) => (i === index ? moved : p));
}

export const setOpacity = (points, index, value, opacity) => move(points, index, value, [clamp(opacity, 0, 1)]);

/**
 * The points from `first` to `last` moved together by a value; the points beside them are in the way. Opacities may be scaled at the
 * same time (by 1 where only the value moves).
 */
export function moveBand(points, first, last, by, factor = 1) {
    const low = first > 0 ? points[first - 1][0] - points[first][0] : -Infinity;
    const high = last < points.length - 1 ? points[last + 1][0] - points[last][0] : Infinity;
    const step = clamp(by, low, high);
    return points.map((p, i) => (i < first || i > last ? p : [p[0] + step, ...p.slice(1).map((x) => clamp(x * factor, 0, 1))]));
}

/**
 * The band about a point: from a place of no opacity to the next, the points that make the hump; all points where the curve nowhere
 * touches zero.
 */
export function bandOf(points, index) {
    const nothing = (i) => points[i][1] <= 1e-9;
    let first = index,
        last = index;
    while (first > 0 && !nothing(first)) first--;
    while (last < points.length - 1 && !nothing(last)) last++;
    return [first, last];
}

/** The band that a point belongs to; of one without opacity, between two bands, that of the neighbour that has the more. */
export function bandBy(points, index) {
    const near = [index, index - 1, index + 1].filter((i) => points[i]);
    return bandOf(points, near.reduce((best, i) => (points[i][1] > points[best][1] ? i : best)));
}

/** The band that a value lies in: that of the point beside it that has the more opacity. */
export function bandAt(points, value) {
    const found = points.findIndex((p) => p[0] > value),
        after = found < 0 ? points.length - 1 : found,
        before = Math.max(after - 1, 0);
    return bandOf(points, points[before][1] > points[after][1] ? before : after);
}

/**
 * Fewer points for almost the same curve (Douglas and Peucker 1973): none is further from the old curve than `tolerance`, an opacity.
 */
export function simplify(points, tolerance) {
    if (points.length < 3) return points;
    const [a, b] = [points[0], points.at(-1)];
    let worst = 0,
        at = 0;
    for (let i = 1; i < points.length - 1; i++) {
        const line = evaluate([a, b], points[i][0]);
        const off = Math.max(...line.map((x, k) => Math.abs(x - points[i][k + 1])));
        if (off > worst) [worst, at] = [off, i];
    }
    if (worst <= tolerance) return [a, b];
    return [...simplify(points.slice(0, at + 1), tolerance).slice(0, -1), ...simplify(points.slice(at), tolerance)];
}

/** All points stretched from their own range over another. */
export function stretch(points, lo, hi) {
    const [a, b] = [points[0][0], points.at(-1)[0]];
    return points.map((p) => [b > a ? lo + ((p[0] - a) * (hi - lo)) / (b - a) : lo, ...p.slice(1)]);
}

/** All opacities times a factor, kept within 0 to 1. */
export const scaleOpacity = (points, factor) => points.map((p) => [p[0], clamp(p[1] * factor, 0, 1)]);
