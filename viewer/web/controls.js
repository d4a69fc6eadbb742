/* SPDX-License-Identifier: MIT */
/* Controls made from the rows of the option tables: a label, the row's help, its unit, and by its type a switch, a list, a
 * slider with a number beside it, a colour or text. A new row of a table needs nothing here. */

import { clamp, field, fromHex, h, hex, short } from './dom.js';

/**
 * What puts a text into a field, unless somebody is typing there: what was given (or refused) may be replaced though the field still has
 * the focus.
 */
function shower(input) {
    let typing = false;
    input.addEventListener('input', () => (typing = true));
    for (const end of ['change', 'blur']) input.addEventListener(end, () => (typing = false));
    return (text) => {
        if (!typing && input.value !== text) input.value = text;
    };
}

/** What somebody gave in a field of a number, within what it may be, and shown so; undefined, and what was there again, for no number. */
function given(input, { minimum, maximum, whole }, before, digits) {
    if (!Number.isFinite(input.valueAsNumber)) {
        input.value = before;
        return undefined;
    }
    const number = whole ? Math.round(input.valueAsNumber) : input.valueAsNumber;
    const inside = clamp(number, minimum ?? -Infinity, maximum ?? Infinity);
    if (inside !== input.valueAsNumber) input.value = short(inside, digits);
    return inside;
}

/** How values lie along a slider: logarithmic over some decades, spread towards 0 where what is usual is a small part of what may be. */
function spacing(minimum, maximum, usual) {
    const same = (x) => x;
    if (minimum > 0 && maximum / minimum >= 100 && maximum / minimum <= 1e5) return [Math.log, Math.exp];
    if (minimum === 0 && usual > 0 && maximum / usual >= 8) return [Math.cbrt, (x) => x ** 3];
    return [same, same];
}

/** Round numbers that lie close enough along a slider: by digits where it is bent, else of steps of its span, wherever the span lies. */
function rounding(minimum, maximum, whole, even) {
    const span = maximum - minimum || 1,
        unit = 10 ** Math.floor(Math.log10(span / 1000));
    const digits = Math.ceil(Math.log10(Math.max(Math.abs(minimum), Math.abs(maximum)) / span)) + 4;
    const round = whole
        ? Math.round
        : even
          ? (x) => Number((Math.round(x / unit) * unit).toPrecision(15))
          : (x) => Number(x.toPrecision(4));
    return [round, clamp(digits, 6, 15)];
}

/**
 * A slider and a number that say the same. What is told has a phase, as in Edits: a drag is one move however it ends, for a slider that is
 * let go where it was taken tells no `change`.
 */
export function slider({ minimum, maximum, label, whole, usual }, onchange) {
    const [forward, back] = spacing(minimum, maximum, usual);
    const steps = whole && back(2) === 2 ? Math.min(maximum - minimum, 1000) : 1000;
    const range = h('input', {
        type: 'range',
        min: forward(minimum),
        max: forward(maximum),
        'aria-label': label,
        step: (forward(maximum) - forward(minimum)) / steps,
    });
    const number = h('input', { type: 'number', min: minimum, max: maximum, step: 'any', 'aria-label': label });
    const [round, digits] = rounding(minimum, maximum, whole, back(2) === 2),
        show = shower(number);
    let active = false,
        keys = false,
        value = minimum,
        before = '';
    const end = () => {
        if (!active) return;
        active = false;
        for (const kind of ['pointerup', 'pointercancel']) removeEventListener(kind, end);
        onchange(value, 'end');
    };
    range.addEventListener('keydown', () => (keys = true));
    range.addEventListener('pointerdown', () => (keys = false));
    range.addEventListener('input', () => {
        value = clamp(round(back(Number(range.value))), minimum, maximum);
        number.value = short(value, digits);
        const phase = keys ? 'key' : active ? 'move' : 'start';
        if (phase === 'start') for (const kind of ['pointerup', 'pointercancel']) addEventListener(kind, end);
        active = !keys;
        onchange(value, phase);
    });
    for (const kind of ['change', 'blur']) range.addEventListener(kind, end);
    number.addEventListener('change', () => {
        const now = given(number, { minimum, maximum, whole }, before, digits);
        if (now === undefined) return;
        range.value = forward(now);
        onchange(now, 'end');
    });
    const element = h('div', { class: 'slider' }, range, number);
    element.update = (now) => {
        if (active || now === undefined || now === null) return;
        range.value = forward(now);
        before = short(now, digits);
        show(before);
    };
    return element;
}

/** A number alone. */
export function numberInput({ minimum, maximum, label, whole }, onchange) {
    const number = h('input', {
        type: 'number',
        min: minimum ?? undefined,
        max: maximum ?? undefined,
        step: whole ? 1 : 'any',
        'aria-label': label,
    });
    const show = shower(number);
    let before = '';
    number.addEventListener('change', () => {
        const now = given(number, { minimum, maximum, whole }, before, 7);
        if (now !== undefined) onchange(now, 'end');
    });
    number.update = (value) => {
        before = value === undefined || value === null ? '' : short(value, 7);
        show(before);
    };
    return number;
}

export function select(choices, onchange, label) {
    const element = h(
        'select',
        { 'aria-label': label },
        choices.map((choice) => {
            const [value, text] = Array.isArray(choice) ? choice : [choice, choice];
            return h('option', { value }, text);
        }),
    );
    element.addEventListener('change', () => onchange(element.value, 'end'));
    element.update = (value) => (element.value = value ?? '');
    return element;
}

export function checkbox(onchange, label) {
    const element = h('input', { type: 'checkbox', role: 'switch', 'aria-label': label });
    element.addEventListener('change', () => onchange(element.checked, 'end'));
    element.update = (value) => (element.checked = Boolean(value));
    return element;
}

/** A colour [r, g, b] of numbers 0 to 1; what else the value has (alpha) stays. */
export function colorInput(onchange, label) {
    const element = h('input', { type: 'color', 'aria-label': label });
    let value = [0, 0, 0],
        active = false;
    const change = (phase) => onchange([...fromHex(element.value), ...value.slice(3)], phase);
    /* A chooser that is left with the colour of its start tells no `change`: then whatever comes next in the page ends it. */
    const end = () => {
        if (!active) return;
        active = false;
        removeEventListener('pointerdown', end, true);
        change('end');
    };
    element.addEventListener('input', () => {
        if (!active) addEventListener('pointerdown', end, true);
        change(active ? 'move' : 'start');
        active = true;
    });
    for (const kind of ['change', 'blur', 'focus', 'keydown']) element.addEventListener(kind, end);
    element.update = (next) => {
        value = next ?? value;
        if (!active) element.value = hex(value);
    };
    return element;
}

/** Several numbers side by side, told together; those that were not touched with all their digits, of which `digits` are shown. */
export function numbersInput(count, label, onchange, digits = 5) {
    let shown = [];
    const inputs = Array.from({ length: count }, (_, i) =>
        h('input', { type: 'number', step: 'any', 'aria-label': `${label} ${'xyzuvw'[i]}` }),
    );
    const shows = inputs.map(shower),
        element = h('div', { class: 'numbers' }, inputs);
    element.addEventListener('change', (event) => {
        const values = inputs.map((input, i) => (input === event.target || shown[i] === undefined ? input.valueAsNumber : shown[i]));
        if (values.every(Number.isFinite)) onchange(values, 'end');
    });
    element.update = (values) => {
        shown = values ?? [];
        shows.forEach((show, i) => show(shown[i] === undefined ? '' : short(shown[i], digits)));
    };
    return element;
}

function textInput(label, onchange) {
    const element = h('input', { type: 'text', 'aria-label': label });
    const show = shower(element);
    element.addEventListener('change', () => onchange(element.value, 'end'));
    element.update = (value) => show(value ?? '');
    return element;
}

const COLORS = { black: '#000000', white: '#ffffff', gray: '#808080', grey: '#808080', transparent: '#00000000' };

/** A value of a row as its control takes it: a technique's options and colours come as text. */
function typed({ type }, value) {
    if (typeof value !== 'string') return value;
    if (type === 'bool') return /^(true|on|yes|1)$/.test(value);
    if (type === 'int' || type === 'double') return Number(value);
    const text = type === 'color' ? (COLORS[value.toLowerCase()] ?? value) : value;
    if (type === 'color' && text.startsWith('#')) return fromHex(text);
    return type === 'color' || type.startsWith('vec') ? text.split(',').map(Number) : text;
}

function control(row, onchange) {
    const { type, minimum, maximum, label } = row;
    const whole = type === 'int';
    const bounded = [minimum, maximum].every((x) => Number.isFinite(x) && Math.abs(x) < 1e6);
    const vector = /^vec([236])$/.exec(type);
    if (type === 'bool') return checkbox(onchange, label);
    if (type === 'choice') return select(row.choices, onchange, label);
    if (type === 'int' || type === 'double')
        return bounded
            ? slider({ minimum, maximum, label, whole, usual: Number(row.default) }, onchange)
            : numberInput({ minimum, maximum, label, whole }, onchange);
    if (type === 'color') return colorInput((color, phase) => onchange(hex(color), phase), label);
    if (vector) return numbersInput(Number(vector[1]), label, onchange);
    return textInput(label, onchange);
}

/** A control for a row of an option table; `update(value)` shows a value, the default where it is undefined. */
export function optionControl(row, onchange) {
    const inner = control(row, onchange);
    const name = row.label || row.name;
    const fallback = row.default === null || row.default === undefined ? '' : ` (default ${row.default}${row.unit ? ` ${row.unit}` : ''})`;
    const element = field(name, inner, { help: `${row.help}${fallback}`, unit: row.type === 'bool' ? null : row.unit });
    element.dataset.option = row.name;
    element.update = (value) => inner.update(typed(row, value ?? row.default));
    return element;
}
