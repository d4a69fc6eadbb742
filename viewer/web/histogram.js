/* SPDX-License-Identifier: MIT */
/* The drawing under the transfer function's points: the histogram, and below it the colours with the curve's opacity. And the axes:
 * values along x, zoomed; opacity along y, with a power that spreads what is near zero. */

import { clamp } from './dom.js';
import { ticks } from './geometry.js';
import { evaluate } from './transfer-model.js';

/** From values and opacities to pixels and back, in a box of width x height. */
export class Axes {
    constructor(lo, hi, width, height, power) {
        Object.assign(this, { lo, hi: hi > lo ? hi : lo + 1, width, height, power });
    }

    x(value) {
        return ((value - this.lo) / (this.hi - this.lo)) * this.width;
    }

    value(x) {
        return this.lo + (x / this.width) * (this.hi - this.lo);
    }

    y(opacity) {
        return this.height * (1 - clamp(opacity, 0, 1) ** (1 / this.power));
    }

    opacity(y) {
        return clamp(1 - y / this.height, 0, 1) ** this.power;
    }

    valueTicks() {
        return ticks(this.lo, this.hi, Math.max(Math.floor(this.width / 60), 2));
    }

    opacityTicks() {
        return this.power > 2 ? [0, 0.001, 0.01, 0.1, 0.3, 1] : this.power > 1 ? [0, 0.01, 0.1, 0.25, 0.5, 1] : [0, 0.25, 0.5, 0.75, 1];
    }
}

const css = (color) => `rgb(${color.map((c) => Math.round(clamp(c, 0, 1) * 255)).join(' ')})`;

/** How many samples each pixel column has: the counts of the bins that it covers, the highest of them. */
function columns(histogram, axes) {
    const { lo, hi, counts } = histogram;
    const out = new Float64Array(Math.ceil(axes.width));
    const perValue = counts.length / (hi - lo || 1);
    for (let x = 0; x < out.length; x++) {
        const from = (axes.value(x) - lo) * perValue,
            to = (axes.value(x + 1) - lo) * perValue;
        if (to < 0 || from >= counts.length) continue;
        const last = clamp(Math.ceil(to) - 1, 0, counts.length - 1);
        for (let i = clamp(Math.floor(from), 0, counts.length - 1); i <= last; i++) out[x] = Math.max(out[x], counts[i]);
    }
    return out;
}

/**
 * Heights 0 to 1 of the columns. Linear: the bins that hold almost everything (the air about the object) would flatten the rest; what is
 * above four times the 97th percentile is cut off.
 */
function heights(histogram, axes, logarithmic) {
    const found = columns(histogram, axes);
    const sorted = [...histogram.counts].filter((n) => n > 0).sort((a, b) => a - b);
    const most = sorted.at(-1) ?? 1;
    if (logarithmic) return found.map((n) => Math.log1p(n) / Math.log1p(most));
    const cut = Math.min(most, 4 * (sorted[Math.floor(sorted.length * 0.97)] ?? most)) || 1;
    return found.map((n) => Math.min(n / cut, 1));
}

/** Draws into a canvas of the axes' size (CSS pixels; `ratio` device pixels each). */
export function drawHistogram(canvas, axes, { histogram, colors, opacities, logarithmic, ratio, bar, style }) {
    const width = Math.round(axes.width * ratio),
        height = Math.round((axes.height + bar) * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, axes.width, axes.height + bar);
    context.strokeStyle = style.grid;
    context.lineWidth = 1;
    context.beginPath();
    for (const opacity of axes.opacityTicks()) {
        const y = Math.round(axes.y(opacity)) + 0.5;
        context.moveTo(0, y);
        context.lineTo(axes.width, y);
    }
    context.stroke();
    if (histogram) {
        const tall = heights(histogram, axes, logarithmic);
        context.fillStyle = style.bars;
        context.beginPath();
        context.moveTo(0, axes.height);
        tall.forEach((t, x) => {
            context.lineTo(x, axes.height * (1 - 0.97 * t));
            context.lineTo(x + 1, axes.height * (1 - 0.97 * t));
        });
        context.lineTo(axes.width, axes.height);
        context.fill();
    }
    if (colors?.length) {
        for (let x = 0; x < axes.width; x++) {
            const value = axes.value(x + 0.5),
                color = css(evaluate(colors, value));
            context.fillStyle = color;
            context.fillRect(x, axes.height + 4, 1.5, bar - 4);
            if (opacities?.length) {
                const top = axes.y(evaluate(opacities, value)[0]);
                context.globalAlpha = 0.42;
                context.fillRect(x, top, 1, axes.height - top);
                context.globalAlpha = 1;
            }
        }
    }
}
