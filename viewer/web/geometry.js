/* SPDX-License-Identifier: MIT */
/* Vectors, and the camera of a frame's header: from the world to the picture and back. Pictures go from 0 to 1, left to right and top to
 * bottom, as in the protocol. */

export const add = (a, b) => a.map((x, i) => x + b[i]);
export const sub = (a, b) => a.map((x, i) => x - b[i]);
export const scale = (a, s) => a.map((x) => x * s);
export const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const unit = (a) => scale(a, 1 / (length(a) || 1));

/** The camera of a scene or a frame (the scene file's keys), ready to project: a picture of `aspect` = width / height. */
export class View {
    constructor(camera, aspect) {
        this.position = camera['camera-position'];
        this.focus = camera['camera-focal-point'];
        this.forward = unit(sub(this.focus, this.position));
        this.right = unit(cross(this.forward, camera['camera-view-up']));
        this.up = cross(this.right, this.forward);
        this.distance = length(sub(this.focus, this.position));
        this.parallel = Boolean(camera.parallel);
        this.tangent = Math.tan(((camera['camera-view-angle'] ?? 30) * Math.PI) / 360);
        this.scale = camera['parallel-scale'] ?? 1;
        this.aspect = aspect;
    }

    /** Half the height of what the picture shows, in the focal plane. */
    get halfHeight() {
        return this.parallel ? this.scale : this.distance * this.tangent;
    }

    /** World to picture: [x, y, depth], or null behind the eye. */
    project(point) {
        const to = sub(point, this.position);
        const depth = dot(to, this.forward);
        if (!this.parallel && depth <= this.distance * 1e-6) return null;
        const half = this.parallel ? this.scale : depth * this.tangent;
        return [0.5 + dot(to, this.right) / (2 * half * this.aspect), 0.5 - dot(to, this.up) / (2 * half), depth];
    }

    /** Picture to world, in the plane through the focal point square to the view. */
    unproject(x, y) {
        const half = this.halfHeight;
        return add(this.focus, add(scale(this.right, (2 * x - 1) * half * this.aspect), scale(this.up, (1 - 2 * y) * half)));
    }
}

/** Of a 4x4 matrix, row-major: where it puts a point. */
export function transform(matrix, p) {
    return [0, 1, 2].map((r) => matrix[4 * r] * p[0] + matrix[4 * r + 1] * p[1] + matrix[4 * r + 2] * p[2] + matrix[4 * r + 3]);
}

/** The column of an axis: the step in the world of one voxel along it. */
export const axisStep = (matrix, axis) => [matrix[axis], matrix[4 + axis], matrix[8 + axis]];

/** The inverse of an affine 4x4. */
export function invert(m) {
    const a = axisStep(m, 0),
        b = axisStep(m, 1),
        c = axisStep(m, 2),
        t = [m[3], m[7], m[11]];
    const det = dot(a, cross(b, c));
    const rows = [cross(b, c), cross(c, a), cross(a, b)].map((row) => scale(row, 1 / det));
    return [...rows.flatMap((row) => [...row, -dot(row, t)]), 0, 0, 0, 1];
}

/** The largest of 1, 2, 5 times a power of ten that is not above `limit`. */
export function roundStep(limit) {
    const power = 10 ** Math.floor(Math.log10(limit));
    return (limit / power >= 5 ? 5 : limit / power >= 2 ? 2 : 1) * power;
}

/** Round numbers from lo to hi, about `count` of them. */
export function ticks(lo, hi, count) {
    if (!(hi > lo)) return [lo];
    const step = roundStep(((hi - lo) / count) * 1.5);
    const out = [];
    for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + step * 1e-9; k++) out.push(k === 0 ? 0 : k * step);
    return out;
}

/** What the ends of a world axis are called: letters where they mean something in a patient, else x, y, z. */
export function axisNames(space) {
    if (space === 'LPS')
        return [
            ['L', 'R'],
            ['P', 'A'],
            ['S', 'I'],
        ];
    if (space === 'RAS')
        return [
            ['R', 'L'],
            ['A', 'P'],
            ['S', 'I'],
        ];
    return [
        ['x', ''],
        ['y', ''],
        ['z', ''],
    ];
}

const PLACES = { L: 'left', R: 'right', P: 'back', A: 'front', S: 'top', I: 'bottom' };

/** Where one looks from, along an axis (0, 1, 2) of the world: "front (A)" in a patient, else "+y". */
export function placeName(space, axis, sign) {
    const names = axisNames(space)[axis],
        letter = names[1] && names[sign > 0 ? 0 : 1];
    return letter ? `${PLACES[letter]} (${letter})` : (sign > 0 ? '+' : '−') + names[0];
}

/** What slices square to a world direction are called in a patient, "" elsewhere, and where they are as near to another one (45 degrees). */
export function planeName(space, direction) {
    if (!axisNames(space)[0][1]) return '';
    const sizes = unit(direction).map(Math.abs),
        most = Math.max(...sizes);
    return most > Math.SQRT1_2 + 1e-6 ? ['Sagittal', 'Coronal', 'Axial'][sizes.indexOf(most)] : '';
}

/** The anatomical letter, or the axis, towards which a world direction points most. */
export function directionName(space, direction) {
    const axis = [0, 1, 2].reduce((best, i) => (Math.abs(direction[i]) > Math.abs(direction[best]) ? i : best), 0);
    const names = axisNames(space)[axis];
    const positive = direction[axis] > 0;
    return names[1] ? names[positive ? 0 : 1] : (positive ? '+' : '−') + names[0];
}
