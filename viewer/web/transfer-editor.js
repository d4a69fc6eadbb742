/* SPDX-License-Identifier: MIT */
/* <pel-transfer-editor>: the points of a transfer function over the histogram. Opacity points are circles on the curve, colour points are
 * drops under the bar, isovalues are lines. It shows what it is given and tells edits by events; what comes of them is not its business:
 *
 * edit      {part: "opacities" | "colors" | "isosurfaces", points, phase: "start" | "move" | "end" | "key"}, as in Edits
 * choose    {part, index, band}: which point the number fields are about; `band`: null, or [first, last] of its band, which arrows move
 *
 * Mouse: drag a point; drag below the curve moves its band; shift keeps the value, alt the opacity, ctrl is fine; double click adds;
 * right click removes; the wheel zooms values, a drag on the ground pans. Keys: page up/down choose, of all parts one after the other,
 * B takes the band of a point and gives it up again, arrows move, insert, delete; values are panned to what is chosen. */

import { attributes, clamp, h, short, svg } from './dom.js';
import { bandAt, bandBy, evaluate, insert, move, moveBand, remove, setOpacity } from './transfer-model.js';
import { Axes, drawHistogram } from './histogram.js';
import { browsers } from './keys.js';

const MARGIN = { left: 36, right: 10, top: 10, bottom: 22 };
const BAR = 18;
const FINE = 0.12;
const STRONGER = 1.02; /* a band, with each step of a key */

/** What a point of each part is called. */
export const NAMES = { opacities: 'Point', colors: 'Colour', isosurfaces: 'Isovalue' };

export class TransferEditor extends HTMLElement {
    #canvas = h('canvas', { 'aria-hidden': 'true' });
    #svg = svg('svg', {
        class: 'points',
        role: 'application',
        tabindex: '0',
        'aria-label':
            'Transfer function. Page up and down choose a point, colour or isovalue, arrows move it, B takes its band as a whole, ' +
            'Insert adds, Delete removes',
    });
    #live = h('div', { class: 'hidden', 'aria-live': 'polite' });
    #drag = null;
    #observer = new ResizeObserver(() => this.draw());
    #frame = 0;

    data = { opacities: [], colors: [], isosurfaces: [], histogram: null, range: [0, 1] };
    look = { logarithmic: true, power: 2, zoom: null };
    chosen = { part: 'opacities', index: 0, band: null };

    connectedCallback() {
        this.append(this.#canvas, this.#svg, this.#live);
        this.#observer.observe(this);
        this.#svg.addEventListener('pointerdown', (event) => this.#press(event));
        this.#svg.addEventListener('pointermove', (event) => this.#move(event));
        for (const end of ['pointerup', 'pointercancel']) this.#svg.addEventListener(end, (event) => this.#lift(event));
        this.#svg.addEventListener('dblclick', (event) => this.#add(event));
        this.#svg.addEventListener('contextmenu', (event) => this.#menu(event));
        this.#svg.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
        this.#svg.addEventListener('keydown', (event) => this.#key(event));
        matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
    }

    disconnectedCallback() {
        this.#observer.disconnect();
    }

    get dragging() {
        return this.#drag !== null && this.#drag.part !== 'ground';
    }

    /** New data (an object with some of the keys of `data`), or a new look; drawn with the next animation frame. */
    update(data, look) {
        Object.assign(this.data, data);
        Object.assign(this.look, look);
        const { part, index, band } = this.chosen,
            count = this.data[part].length;
        this.chosen = count ? this.#choice(part, clamp(index, 0, count - 1), band) : this.#choice('opacities', 0);
        this.draw();
    }

    draw() {
        this.#frame ||= requestAnimationFrame(() => {
            this.#frame = 0;
            if (this.isConnected && this.clientWidth > 0) this.#paint();
        });
    }

    get axes() {
        const [lo, hi] = this.look.zoom ?? this.data.range;
        return new Axes(
            lo,
            hi,
            Math.max(this.clientWidth - MARGIN.left - MARGIN.right, 20),
            Math.max(this.clientHeight - MARGIN.top - MARGIN.bottom - BAR, 20),
            this.look.power,
        );
    }

    /** A choice of a point, or, with `whole`, of its band: what the curve has of it now. */
    #choice(part, index, whole) {
        const band = whole && part === 'opacities' && this.data[part][index] ? bandBy(this.data[part], index) : null;
        return { part, index, band };
    }

    choose(part, index, whole = false) {
        this.chosen = this.#choice(part, index, whole);
        const points = this.data[part],
            point = points[index];
        if (point) {
            const value = part === 'isosurfaces' ? point.value : point[0],
                text = part === 'opacities' ? `, opacity ${short(point[1])}` : '';
            const [first, last] = this.chosen.band ?? [];
            this.#live.textContent = this.chosen.band
                ? `Band of ${last - first + 1} points: values ${short(points[first][0])} to ${short(points[last][0])}`
                : `${NAMES[part]} ${index + 1} of ${points.length}: value ${short(value)}${text}`;
        }
        this.#tell('choose', this.chosen);
        this.draw();
    }

    #tell(type, detail) {
        this.dispatchEvent(new CustomEvent(type, { detail }));
    }

    /** An edit: shown here at once, told to whoever listens. */
    commit(part, points, phase = 'end') {
        this.data[part] = points;
        this.draw();
        this.#tell('edit', { part, points, phase });
    }

    /* ---- drawing ---- */

    #paint() {
        const axes = this.axes,
            style = getComputedStyle(this);
        drawHistogram(this.#canvas, axes, {
            ...this.data,
            logarithmic: this.look.logarithmic,
            ratio: window.devicePixelRatio || 1,
            bar: BAR,
            style: { grid: style.getPropertyValue('--grid'), bars: style.getPropertyValue('--bars') },
        });
        Object.assign(this.#canvas.style, {
            left: `${MARGIN.left}px`,
            top: `${MARGIN.top}px`,
            width: `${axes.width}px`,
            height: `${axes.height + BAR}px`,
        });
        attributes(this.#svg, { width: this.clientWidth, height: this.clientHeight });
        const inside = svg('g', { transform: `translate(${MARGIN.left} ${MARGIN.top})` });
        inside.append(...this.#ticks(axes), ...this.#curve(axes), ...this.#lines(axes), ...this.#drops(axes), ...this.#dots(axes));
        this.#svg.replaceChildren(inside);
    }

    #ticks(axes) {
        const below = axes.height + BAR + 14;
        const values = axes
            .valueTicks()
            .map((value) => svg('text', { x: axes.x(value), y: below, class: 'tick', 'text-anchor': 'middle' }, short(value)));
        const opacities = axes
            .opacityTicks()
            .map((opacity) => svg('text', { x: -6, y: axes.y(opacity) + 4, class: 'tick', 'text-anchor': 'end' }, short(opacity)));
        return [...values, ...opacities];
    }

    #curve(axes) {
        const points = this.data.opacities;
        if (!points.length) return [];
        const at = ([value, opacity]) => `${axes.x(value).toFixed(1)},${axes.y(opacity).toFixed(1)}`;
        /* Between points a straight line of opacity is bent on the power scale: follow it. */
        const path = [];
        points.forEach((point, i) => {
            path.push(at(point));
            const next = points[i + 1];
            if (next && axes.power > 1 && Math.abs(axes.x(next[0]) - axes.x(point[0])) > 6)
                for (let k = 1; k < 8; k++) path.push(at([0, 1].map((j) => point[j] + (k / 8) * (next[j] - point[j]))));
        });
        const line = [`-2000,${axes.y(points[0][1]).toFixed(1)}`, ...path, `9000,${axes.y(points.at(-1)[1]).toFixed(1)}`].join(' ');
        const clip = svg('clipPath', { id: 'editor-box' }, svg('rect', { x: -1, y: -8, width: axes.width + 2, height: axes.height + 16 }));
        return [
            svg('defs', {}, clip),
            svg('polyline', { points: line, class: 'curve under', 'clip-path': 'url(#editor-box)' }),
            svg('polyline', { points: line, class: 'curve', 'clip-path': 'url(#editor-box)' }),
        ];
    }

    #visible(axes, value) {
        const x = axes.x(value);
        return x >= -1 && x <= axes.width + 1;
    }

    #marks(part, make) {
        return this.data[part]
            .map((point, index) => {
                const [first, last] = this.chosen.band ?? [this.chosen.index, this.chosen.index];
                const chosen = this.chosen.part === part && first <= index && index <= last;
                return make(point, { 'data-part': part, 'data-index': index, class: `${part} ${chosen ? 'chosen' : ''}` });
            })
            .filter(Boolean);
    }

    #dots(axes) {
        return this.#marks(
            'opacities',
            ([value, opacity], mark) =>
                this.#visible(axes, value) &&
                svg('circle', { cx: axes.x(value), cy: axes.y(opacity), r: mark.class.includes('chosen') ? 6.5 : 4.5, ...mark }),
        );
    }

    #drops(axes) {
        const y = axes.height + BAR;
        return this.#marks(
            'colors',
            ([value, ...color], mark) =>
                this.#visible(axes, value) &&
                svg('path', {
                    d: `M${axes.x(value)} ${y - 9} l5 5 v6 h-10 v-6 z`,
                    fill: `rgb(${color.map((c) => Math.round(c * 255)).join(' ')})`,
                    ...mark,
                }),
        );
    }

    #lines(axes) {
        return this.#marks('isosurfaces', (surface, mark) => {
            if (!this.#visible(axes, surface.value)) return null;
            const x = axes.x(surface.value),
                fill = `rgb(${surface.color
                    .slice(0, 3)
                    .map((c) => Math.round(c * 255))
                    .join(' ')})`;
            return svg(
                'g',
                mark,
                svg('line', { x1: x, x2: x, y1: 0, y2: axes.height }),
                svg('path', { d: `M${x} -9 l7 4 v8 h-14 v-8 z`, fill, ...mark }),
            );
        });
    }

    /* ---- mouse and touch ---- */

    #at(event) {
        const box = this.#svg.getBoundingClientRect();
        return [event.clientX - box.left - MARGIN.left, event.clientY - box.top - MARGIN.top];
    }

    /**
     * The mark that is nearest to the pointer, of the part that lies under it, or of the points close by: fingers are wide. Marks may
     * cover each other: the one on top is often not the one that is meant.
     */
    #hit(event) {
        const under = event.target.closest?.('[data-part]'),
            part = under?.dataset.part ?? 'opacities';
        const [x, y] = this.#at(event),
            axes = this.axes;
        let best = under ? { part, index: Number(under.dataset.index) } : null,
            least = under ? Infinity : event.pointerType === 'touch' ? 22 : 9;
        this.data[part].forEach((point, index) => {
            const across = axes.x(part === 'isosurfaces' ? point.value : point[0]) - x;
            const off = part === 'opacities' ? Math.hypot(across, axes.y(point[1]) - y) : Math.abs(across);
            /* Of those at the same place the last one, which is on top. */
            if (off <= least) [best, least] = [{ part, index }, off];
        });
        return best;
    }

    #press(event) {
        if (event.button !== 0 || this.#drag) return;
        this.#svg.setPointerCapture(event.pointerId);
        const hit = this.#hit(event),
            at = this.#at(event),
            axes = this.axes;
        const value = axes.value(at[0]);
        const under = this.data.opacities.length && at[1] < axes.height && at[1] > axes.y(evaluate(this.data.opacities, value)[0]) + 4;
        const inside = value > (this.data.opacities[0]?.[0] ?? Infinity) && value < (this.data.opacities.at(-1)?.[0] ?? -Infinity);
        this.#drag = { pointer: event.pointerId, at, axes, moved: false, zoom: this.look.zoom ?? this.data.range };
        if (hit) Object.assign(this.#drag, hit, { points: this.data[hit.part] });
        else if (under && inside && !event.shiftKey)
            Object.assign(this.#drag, { part: 'band', points: this.data.opacities, band: bandAt(this.data.opacities, value) });
        else this.#drag.part = 'ground';
        if (hit) this.choose(hit.part, hit.index);
        this.#svg.focus({ preventScroll: true });
        event.preventDefault();
    }

    #move(event) {
        const drag = this.#drag;
        if (!drag) {
            const hit = this.#hit(event);
            this.#svg.classList.toggle('over', Boolean(hit));
            return;
        }
        if (event.pointerId !== drag.pointer) return;
        const [x, y] = this.#at(event),
            fine = event.ctrlKey ? FINE : 1;
        const dx = (x - drag.at[0]) * fine,
            dy = (y - drag.at[1]) * fine;
        if (!drag.moved && Math.hypot(dx, dy) < 2 * fine) return;
        const first = !drag.moved;
        drag.moved = true;
        if (drag.part === 'ground') {
            const by = drag.axes.value(0) - drag.axes.value(dx);
            this.zoomTo(drag.zoom[0] + by, drag.zoom[1] + by);
            return;
        }
        const part = drag.part === 'band' ? 'opacities' : drag.part;
        this.data[part] = this.#dragged(drag, event.shiftKey ? 0 : dx, event.altKey ? 0 : dy);
        this.draw();
        this.#tell('edit', { part, points: this.data[part], phase: first ? 'start' : 'move' });
        if (drag.part !== 'band') this.#tell('choose', this.chosen);
    }

    #dragged({ part, points, index, band, axes, factor }, dx, dy) {
        const perPixel = axes.value(1) - axes.value(0);
        if (part === 'band') return moveBand(points, band[0], band[1], dx * perPixel, factor);
        if (part === 'isosurfaces') {
            const [lo, hi] = this.data.range;
            return points.map((p, i) => (i === index ? { ...p, value: clamp(p.value + dx * perPixel, lo, hi) } : p));
        }
        const value = points[index][0] + dx * perPixel;
        return part === 'colors'
            ? move(points, index, value)
            : setOpacity(points, index, value, axes.opacity(axes.y(points[index][1]) + dy));
    }

    #lift(event) {
        if (event.pointerId === this.#drag?.pointer) this.#finish();
    }

    #finish() {
        const drag = this.#drag;
        this.#drag = null;
        if (drag?.moved && drag.part !== 'ground') {
            const part = drag.part === 'band' ? 'opacities' : drag.part;
            this.#tell('edit', { part, points: this.data[part], phase: 'end' });
        }
    }

    #add(event) {
        if (this.#hit(event)) return;
        const [x, y] = this.#at(event),
            axes = this.axes,
            onBar = y > axes.height;
        const part = onBar ? 'colors' : 'opacities';
        const { points, index } = insert(this.data[part], axes.value(x), onBar ? undefined : [axes.opacity(y)]);
        this.commit(part, points);
        this.choose(part, index);
    }

    #menu(event) {
        event.preventDefault();
        this.#finish(); /* a long press, and on a Mac a click with Ctrl, is also a press */
        const hit = this.#hit(event);
        if (hit) this.removePoint(hit.part, hit.index);
    }

    removePoint(part, index) {
        const left = part === 'isosurfaces' ? this.data[part].filter((_, i) => i !== index) : remove(this.data[part], index);
        this.commit(part, left);
        if (left.length) this.choose(part, clamp(index, 0, left.length - 1));
        else this.choose('opacities', 0);
    }

    #wheel(event) {
        event.preventDefault();
        const axes = this.axes,
            [x] = this.#at(event);
        const factor = 1.2 ** clamp(event.deltaY / 100, -3, 3),
            about = axes.value(clamp(x, 0, axes.width));
        this.zoomTo(about - (about - axes.lo) * factor, about + (axes.hi - about) * factor);
    }

    /** Shows values from lo to hi; the whole range where they are wider than it. */
    zoomTo(lo, hi) {
        const [a, b] = this.data.range,
            span = hi - lo;
        if (span >= b - a) {
            this.update({}, { zoom: null });
        } else if (span > (b - a) * 1e-5) {
            const from = clamp(lo, a, b - span);
            this.update({}, { zoom: [from, from + span] });
        }
    }

    /* ---- keys ---- */

    /** The point before or after the chosen one; after the last of a part comes the first of the next. */
    #chooseNext(by) {
        const all = Object.keys(NAMES).flatMap((part) => this.data[part].map((_, index) => ({ part, index })));
        const now = all.findIndex(({ part, index }) => part === this.chosen.part && index === this.chosen.index);
        const next = all[clamp(now + by, 0, all.length - 1)];
        if (!next) return;
        this.choose(next.part, next.index);
        this.#reveal();
    }

    /** Pans the values so far that the chosen point is seen. */
    #reveal() {
        const { part, index } = this.chosen,
            point = this.data[part][index],
            { lo, hi } = this.axes;
        const value = part === 'isosurfaces' ? point.value : point[0],
            by = Math.min(value - lo, 0) + Math.max(value - hi, 0);
        if (this.look.zoom && by) this.zoomTo(lo + by, hi + by);
    }

    #key(event) {
        if (browsers(event)) return;
        const { part, index, band } = this.chosen,
            list = this.data[part];
        const axes = this.axes,
            step = event.ctrlKey ? 0.25 : event.shiftKey ? 10 : 1,
            perPixel = axes.value(1) - axes.value(0);
        const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
        if (event.key in moves && list[index]) {
            const [dx, dy] = moves[event.key];
            const what = band ? { part: 'band', band, factor: STRONGER ** -dy } : { part, index };
            this.commit(part, this.#dragged({ ...what, points: list, axes }, dx, dy), 'key');
            this.choose(part, index, band);
            this.#reveal();
        } else if (event.key.toLowerCase() === 'b' && !event.ctrlKey && !event.metaKey && part === 'opacities' && list[index]) {
            this.choose(part, index, !band);
        } else if (event.key === 'PageDown' || event.key === 'PageUp') {
            this.#chooseNext(event.key === 'PageDown' ? 1 : -1);
        } else if (event.key === 'Insert' && part !== 'isosurfaces' && list[index]) {
            const next = list[index + 1],
                value = next ? (list[index][0] + next[0]) / 2 : list[index][0] + 20 * perPixel;
            const added = insert(list, value);
            this.commit(part, added.points);
            this.choose(part, added.index);
        } else if (event.key === 'Delete' && list.length) {
            this.removePoint(part, index);
        } else if ((event.key === '+' || event.key === '-') && !event.ctrlKey) {
            const middle = (axes.lo + axes.hi) / 2,
                half = ((axes.hi - axes.lo) / 2) * (event.key === '+' ? 0.8 : 1.25);
            this.zoomTo(middle - half, middle + half);
        } else {
            return;
        }
        event.preventDefault();
        event.stopPropagation();
    }
}

customElements.define('pel-transfer-editor', TransferEditor);
