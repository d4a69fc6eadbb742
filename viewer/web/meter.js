/* SPDX-License-Identifier: MIT */
/* What frames cost, as the page sees it: frames a second while something moves, and the time from an input to the frame that shows it. */

const WINDOW_MS = 1000;

export class Meter {
    #shown = [];
    #latencies = [];

    /** Call when a frame was drawn, with the ages in ms of the inputs that it is the first to show. */
    frame(now, latencies) {
        this.#shown.push(now);
        this.#shown = this.#shown.filter((time) => now - time <= WINDOW_MS);
        this.#latencies = [...this.#latencies, ...latencies].slice(-30);
    }

    /** Frames a second over the last second; null where there were too few to say. */
    get fps() {
        const [first, last] = [this.#shown[0], this.#shown.at(-1)];
        return this.#shown.length >= 3 ? ((this.#shown.length - 1) * 1000) / (last - first) : null;
    }

    /** Median of the last latencies. */
    get latency() {
        const sorted = [...this.#latencies].sort((a, b) => a - b);
        return sorted.length ? sorted[sorted.length >> 1] : null;
    }
}
