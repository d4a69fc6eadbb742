/* SPDX-License-Identifier: MIT */
/* Elements without innerHTML: text from the server is only ever text. */

const SVG = 'http://www.w3.org/2000/svg';

function fill(element, attributes, children) {
    for (const [name, value] of Object.entries(attributes)) {
        if (value === undefined || value === null || value === false) continue;
        if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
        else if (name in element && (typeof value === 'boolean' || name === 'value')) element[name] = value;
        else element.setAttribute(name, value === true ? '' : value);
    }
    element.append(...children.flat(2).filter((child) => child !== null && child !== undefined && child !== false));
    return element;
}

/** An HTML element: h('button', {class: 'small', onclick: f}, 'text', child, [children]). */
export function h(name, attributes = {}, ...children) {
    return fill(document.createElement(name), attributes, children);
}

/** The same for SVG. */
export function svg(name, attributes = {}, ...children) {
    return fill(document.createElementNS(SVG, name), attributes, children);
}

/** Sets attributes of an element that is there; leaves what is the same alone, so that nothing is laid out again for nothing. */
export function attributes(element, values) {
    for (const [name, value] of Object.entries(values)) {
        const text = typeof value === 'number' ? String(Math.round(value * 100) / 100) : value;
        if (element.getAttribute(name) !== text) element.setAttribute(name, text);
    }
}

/** A labelled row of a form; the label belongs to the control by its id. */
let ids = 0;
export function field(label, control, { help, unit } = {}) {
    const takes = 'input, select, textarea, button';
    const targets = control.matches(takes) ? [control] : [...control.querySelectorAll(takes)];
    const [target] = targets;
    if (target && !target.id) target.id = `field-${++ids}`;
    const words = help ? h('span', { class: 'hidden', id: `help-${++ids}` }, help) : null;
    if (words) for (const each of targets) each.setAttribute('aria-describedby', words.id);
    return h(
        'div',
        { class: 'field', title: help },
        h('label', { for: target?.id }, label, unit ? h('span', { class: 'unit' }, unit) : null),
        control,
        words,
    );
}

/** A button with a caption and, maybe, an icon before it. */
export function button(caption, onclick, { title, kind = '', icon: sign, pressed } = {}) {
    return h(
        'button',
        { type: 'button', class: kind, title, onclick, 'aria-pressed': pressed === undefined ? undefined : String(pressed) },
        sign ? icon(sign) : null,
        caption ? h('span', {}, caption) : null,
    );
}

const ICONS = {
    transfer: 'M2 17 L6 13 L9 15 L13 5 L18 3 M2 3 V18 H18',
    surface: 'M10 2 L17 6 V14 L10 18 L3 14 V6 Z M3 6 L10 10 L17 6 M10 10 V18',
    render:
        'M10 2 V4 M10 16 V18 M2 10 H4 M16 10 H18 M4.5 4.5 L6 6 M14 14 L15.5 15.5 M4.5 15.5 L6 14 M14 6 L15.5 4.5 ' +
        'M13.5 10 A3.5 3.5 0 1 1 6.5 10 A3.5 3.5 0 1 1 13.5 10',
    light: 'M7.5 15 H12.5 M8.5 18 H11.5 M7.5 15 C7.5 12.5 5 11.5 5 8 A5 5 0 0 1 15 8 C15 11.5 12.5 12.5 12.5 15',
    clip: 'M6 2 V14 H18 M2 6 H14 V18',
    slices: 'M3 3 H17 V17 H3 Z M10 3 V17 M3 10 H17',
    measure: 'M2.5 13 L13 2.5 L17.5 7 L7 17.5 Z M5.5 10 L7.5 12 M8 7.5 L9.5 9 M10.5 5 L12.5 7',
    camera: 'M2 6 H6 L7.5 4 H12.5 L14 6 H18 V16 H2 Z M13 10.8 A3 3 0 1 1 7 10.8 A3 3 0 1 1 13 10.8',
    save: 'M10 2 V12 M6 8.5 L10 12.5 L14 8.5 M3 13 V17 H17 V13',
    close: 'M5 5 L15 15 M15 5 L5 15',
    wide: 'M8 5 L3 10 L8 15 M12 5 L17 10 L12 15',
    reset: 'M4 10 A6 6 0 1 0 6 5.5 M6 2 V6 H10',
    folder: 'M2 5 H8 L10 7 H18 V16 H2 Z',
    trash: 'M4 6 H16 M8 6 V3.5 H12 V6 M5.5 6 L6.5 17 H13.5 L14.5 6',
    plus: 'M10 4 V16 M4 10 H16',
    flip: 'M3 7 H15 L12 4 M17 13 H5 L8 16',
};

/** One of the icons, drawn with the colour of the text. */
export function icon(name) {
    return svg('svg', { class: 'icon', viewBox: '0 0 20 20', 'aria-hidden': 'true' }, svg('path', { d: ICONS[name] }));
}

/** "#rrggbb" from three numbers 0 to 1, and back (with "#rrggbbaa", too). */
export function hex(color) {
    return (
        '#' +
        color
            .slice(0, 3)
            .map((c) =>
                Math.round(Math.min(Math.max(c, 0), 1) * 255)
                    .toString(16)
                    .padStart(2, '0'),
            )
            .join('')
    );
}

export function fromHex(text) {
    return [1, 3, 5, 7].filter((at) => at < text.length).map((at) => parseInt(text.slice(at, at + 2), 16) / 255);
}

/** A number for people: about four digits, no tail of zeros. */
export function short(value, digits = 4) {
    if (!Number.isFinite(value)) return String(value);
    const size = Math.abs(value);
    if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(digits - 1).replace(/\.?0+e/, 'e');
    return String(Number(value.toPrecision(digits)));
}

export function bytes(count) {
    const units = ['B', 'kB', 'MB', 'GB', 'TB'];
    const at = Math.min(Math.floor(Math.log10(Math.max(count, 1)) / 3), 4);
    return `${short(count / 1000 ** at, 3)} ${units[at]}`;
}

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
