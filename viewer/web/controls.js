/* SPDX-License-Identifier: MIT */
/* Controls made from the rows of the option tables: a label, the row's help as tooltip, its unit, and by its type a switch, a list, a
 * slider with a number beside it, a colour or text. A new row of a table needs nothing here. */

import { field, fromHex, h, hex, short } from './dom.js';

/** How values lie along a slider: logarithmic over some decades, spread towards 0 where what is usual is a small part of what may be. */
function spacing(minimum, maximum, usual) {
    const same = (x) => x;
    if (minimum > 0 && maximum / minimum >= 100 && maximum / minimum <= 1e5) return [Math.log, Math.exp];
    if (minimum === 0 && usual > 0 && maximum / usual >= 8) return [Math.cbrt, (x) => x ** 3];
    return [same, same];
}

/** A slider and a number that say the same. */
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
    const round = (x) => (whole ? Math.round(x) : Number(x.toPrecision(4)));
    let active = false;
    range.addEventListener('input', () => {
        const value = Math.min(Math.max(round(back(Number(range.value))), minimum), maximum);
        number.value = short(value);
        onchange(value, active ? 'move' : 'start');
        active = true;
    });
    range.addEventListener('change', () => {
        active = false;
        onchange(Number(number.value), 'end');
    });
    number.addEventListener('change', () => {
        if (number.value !== '' && number.checkValidity()) {
            range.value = forward(Number(number.value));
            onchange(whole ? Math.round(Number(number.value)) : Number(number.value), 'end');
        }
    });
    const element = h('div', { class: 'slider' }, range, number);
    element.update = (value) => {
        if (active || value === undefined || value === null) return;
        range.value = forward(value);
        if (document.activeElement !== number) number.value = short(value, 6);
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
    number.addEventListener('change', () => number.value !== '' && number.checkValidity() && onchange(Number(number.value), 'end'));
    number.update = (value) => {
        if (document.activeElement !== number) number.value = value === undefined || value === null ? '' : short(value, 7);
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
    element.addEventListener('input', () => {
        change(active ? 'move' : 'start');
        active = true;
    });
    element.addEventListener('change', () => {
        active = false;
        change('end');
    });
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
    const element = h('div', { class: 'numbers' }, inputs);
    element.addEventListener('change', (event) => {
        const values = inputs.map((input, i) => (input === event.target || shown[i] === undefined ? input.valueAsNumber : shown[i]));
        if (values.every(Number.isFinite)) onchange(values, 'end');
    });
    element.update = (values) => {
        shown = values ?? [];
        inputs.forEach((input, i) => {
            if (document.activeElement !== input) input.value = shown[i] === undefined ? '' : short(shown[i], digits);
        });
    };
    return element;
}

function textInput(label, onchange) {
    const element = h('input', { type: 'text', 'aria-label': label });
    element.addEventListener('change', () => onchange(element.value, 'end'));
    element.update = (value) => document.activeElement !== element && (element.value = value ?? '');
    return element;
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
    if (type === 'color') return colorInput(onchange, label);
    if (vector || type === 'size') return numbersInput(vector ? Number(vector[1]) : 2, label, onchange);
    return textInput(label, onchange);
}

/** A control for a row of an option table; `update(value)` shows a value, the default where it is undefined. */
export function optionControl(row, onchange) {
    const inner = control(row, onchange);
    const name = row.label || row.name;
    const fallback = row.default === null || row.default === undefined ? '' : ` (default ${row.default}${row.unit ? ` ${row.unit}` : ''})`;
    const element = field(name, inner, { help: `${row.help}${fallback}`, unit: row.type === 'bool' ? null : row.unit });
    element.dataset.option = row.name;
    element.update = (value) => inner.update(value ?? row.default);
    return element;
}
