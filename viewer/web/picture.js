/* SPDX-License-Identifier: MIT */
/* <pel-picture>: a canvas that shows the frames of one view. Decoding is done by the browser, off this thread; a frame of another size than
 * the canvas is scaled into it smoothly, with its proportions kept (another page of the session may have asked for another shape). */

export class Picture extends HTMLElement {
    #canvas = document.createElement('canvas');
    #context = this.#canvas.getContext('2d', { alpha: false });
    #bitmap = null;
    #seen = [0, 0]; /* width and height when it was seen last */
    #observer = new ResizeObserver(() => this.#resized());

    /** Header of the frame that is seen, or null. */
    header = null;

    connectedCallback() {
        this.#canvas.setAttribute('aria-hidden', 'true');
        this.prepend(this.#canvas);
        this.#observer.observe(this);
        this.#watchRatio();
        /* A browser takes the focus that a hand's press gives for a keyboard's, and would frame the picture. */
        this.addEventListener('pointerdown', () => this.classList.add('by-hand'), true);
        for (const kind of ['keydown', 'blur']) this.addEventListener(kind, () => this.classList.remove('by-hand'));
    }

    disconnectedCallback() {
        this.#observer.disconnect();
    }

    /** A window that goes to another screen may keep its size in CSS pixels, of which the observer tells. */
    #watchRatio() {
        const media = matchMedia(`(resolution: ${window.devicePixelRatio || 1}dppx)`);
        const change = () => {
            if (!this.isConnected) return;
            this.#watchRatio();
            this.#resized();
        };
        media.addEventListener('change', change, { once: true });
    }

    /**
     * The size to ask the server for: device pixels times `part`, less where that is more than it draws. Of a picture that is not seen
     * now, as it was last.
     */
    wanted(part = 1, { side = 8192, pixels = 2 ** 25 } = {}) {
        const lengths = this.clientWidth > 0 ? [this.clientWidth, this.clientHeight] : this.#seen;
        const [width, height] = lengths.map((length) => Math.max(length * (window.devicePixelRatio || 1) * part, 16));
        const less = Math.min(1, side / Math.max(width, height), Math.sqrt(pixels / (width * height)));
        return [width, height].map((length) => (less < 1 ? Math.max(Math.floor(length * less), 16) : Math.round(length)));
    }

    /** Where the picture lies in this element, in CSS pixels: {x, y, width, height}. */
    get area() {
        const width = this.clientWidth || 1,
            height = this.clientHeight || 1;
        const [w, h] = this.header?.of ?? [width, height];
        const factor = Math.min(width / w, height / h);
        /* A rounding of half a pixel is no reason for a black line at the edge. */
        if (Math.abs(w * factor - width) < 1.5 && Math.abs(h * factor - height) < 1.5) return { x: 0, y: 0, width, height };
        return { x: (width - w * factor) / 2, y: (height - h * factor) / 2, width: w * factor, height: h * factor };
    }

    /** Where a pointer event is in the picture: fractions. */
    at(event) {
        const box = this.getBoundingClientRect(),
            area = this.area;
        return [(event.clientX - box.left - area.x) / area.width, (event.clientY - box.top - area.y) / area.height];
    }

    /** Shows a frame; done once it is drawn. */
    async show(header, picture) {
        const bitmap = await createImageBitmap(new Blob([picture], { type: header.type }));
        this.#bitmap?.close();
        this.#bitmap = bitmap;
        this.header = header;
        this.#draw();
        this.dispatchEvent(new CustomEvent('drawn', { detail: header }));
    }

    #resized() {
        if (this.clientWidth > 0) this.#seen = [this.clientWidth, this.clientHeight];
        const ratio = window.devicePixelRatio || 1;
        const width = Math.max(Math.round(this.clientWidth * ratio), 1),
            height = Math.max(Math.round(this.clientHeight * ratio), 1);
        if (width !== this.#canvas.width || height !== this.#canvas.height) {
            this.#canvas.width = width;
            this.#canvas.height = height;
            this.#draw();
        }
        this.dispatchEvent(new CustomEvent('resized'));
    }

    #draw() {
        if (!this.#bitmap) return;
        const { width, height } = this.#canvas;
        const area = this.area,
            ratio = width / (this.clientWidth || 1);
        const whole = area.x === 0 && area.y === 0;
        const exact = whole && this.#bitmap.width === width && this.#bitmap.height === height;
        this.#context.imageSmoothingEnabled = !exact;
        this.#context.imageSmoothingQuality = this.header.quality === 'moving' ? 'low' : 'high';
        if (!whole) {
            this.#context.fillRect(0, 0, width, height);
            this.#context.drawImage(this.#bitmap, area.x * ratio, area.y * ratio, area.width * ratio, area.height * ratio);
        } else {
            this.#context.drawImage(this.#bitmap, 0, 0, width, height);
        }
    }
}

customElements.define('pel-picture', Picture);
