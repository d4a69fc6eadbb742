/* SPDX-License-Identifier: MIT */
/* Lights: the headlight that goes with the eye, and lights that stand in the world, each with a ball on
 * which the place that it shines on is dragged. What surfaces make of light comes from the option table. */

import { attributes, button, clamp, field, h, svg } from './dom.js';
import { colorInput, numbersInput, select } from './controls.js';
import { add, cross, dot, length, scale, unit } from './geometry.js';
import { browsers } from './keys.js';
import { get, watch } from './store.js';
import { SURFACE_ROWS, sceneOptions } from './render-panel.js';

const MOST = 4;
const WHITE = [1, 1, 1];
const RADIUS = 42;
const STEP = Math.PI / 36;
const TURNS = { ArrowLeft: ['up', -1], ArrowRight: ['up', 1], ArrowUp: ['right', -1], ArrowDown: ['right', 1] };

/** Of a place on the ball (x to the right, y up, 1 at the rim) the direction seen there; beyond the rim it goes on at the back. */
export function fromBall(view, x, y) {
    const far = Math.hypot(x, y),
        back = far > 1;
    const reach = back ? Math.max(2 - far, 0) : far;
    const [u, v] = far > 0 ? [(x / far) * reach, (y / far) * reach] : [0, 0];
    const depth = Math.sqrt(Math.max(1 - reach * reach, 0)) * (back ? -1 : 1);
    return unit(add(add(scale(view.right, u), scale(view.up, v)), scale(view.forward, -depth)));
}

/** Turns a direction about an axis (Rodrigues). */
function turned(direction, axis, angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return add(add(scale(direction, c), scale(cross(axis, direction), s)), scale(axis, dot(axis, direction) * (1 - c)));
}

/** A ball as lit by a light of that direction; dragged, or turned with arrows. */
function ball(app, label, onchange) {
    const dot_ = svg('circle', { class: 'light-spot', r: 6 });
    const id = `ball-${label.replace(/\W/g, '')}`;
    const shine = svg(
        'radialGradient',
        { id, gradientUnits: 'userSpaceOnUse', r: RADIUS * 1.5 },
        svg('stop', { offset: 0, 'stop-color': '#f4f6f8' }),
        svg('stop', { offset: 1, 'stop-color': '#1c2127' }),
    );
    const element = svg(
        'svg',
        { class: 'light-ball', viewBox: '-52 -52 104 104', tabindex: '0', role: 'application', 'aria-label': `${label}: arrows turn it` },
        svg('defs', {}, shine),
        svg('circle', { class: 'light-body', r: RADIUS, fill: `url(#${id})` }),
        dot_,
    );
    let direction = [0, 0, 1],
        down = null,
        moved = false;
    const place = (event, phase) => {
        const box = element.getBoundingClientRect(),
            unitPixels = (box.width / 104) * RADIUS;
        if (!app.overlay.view) return;
        onchange(
            fromBall(
                app.overlay.view,
                (event.clientX - box.left - box.width / 2) / unitPixels,
                -(event.clientY - box.top - box.height / 2) / unitPixels,
            ),
            phase,
        );
    };
    element.addEventListener('pointerdown', (event) => {
        event.preventDefault();
        if (down !== null) return; /* a second finger */
        element.setPointerCapture(event.pointerId);
        element.focus({ preventScroll: true });
        [down, moved] = [event.pointerId, false];
    });
    element.addEventListener('pointermove', (event) => {
        if (down !== event.pointerId) return;
        place(event, moved ? 'move' : 'start');
        moved = true;
    });
    for (const end of ['pointerup', 'pointercancel'])
        element.addEventListener(end, (event) => {
            if (down !== event.pointerId) return;
            place(event, 'end');
            down = null;
        });
    element.addEventListener('keydown', (event) => {
        const { view } = app.overlay;
        const [axis, sign] = TURNS[event.key] ?? [];
        if (!axis || !view || browsers(event)) return;
        onchange(unit(turned(direction, view[axis], sign * STEP * (event.shiftKey ? 3 : 1))), 'key');
        event.preventDefault();
        event.stopPropagation();
    });
    element.update = (next) => {
        direction = unit(next);
        const { view } = app.overlay;
        if (!view) return;
        const [x, y] = [dot(direction, view.right), -dot(direction, view.up)],
            behind = dot(direction, view.forward) > 0;
        attributes(dot_, { cx: x * RADIUS, cy: y * RADIUS });
        element.classList.toggle('behind', behind);
        /* From behind only the rim is lit. */
        const out = behind ? (1.9 / Math.max(Math.hypot(x, y), 0.05)) * Math.min(1, Math.hypot(x, y) + 0.3) : 1;
        attributes(shine, { cx: clamp(x * out, -4, 4) * RADIUS, cy: clamp(y * out, -4, 4) * RADIUS });
    };
    return element;
}

function row(app, index) {
    const name = `Light ${index + 1}`;
    const lights = () => get('scene').lights ?? [];
    const change = (part, phase) => app.edits.apply({ lights: lights().map((l, i) => (i === index ? { ...l, ...part } : l)) }, phase);
    const kind = select(
        [
            ['head', 'from the eye'],
            ['world', 'stands in the world'],
        ],
        (value) =>
            app.edits.apply({
                lights: lights().map(({ color }, i) =>
                    i !== index ? lights()[i] : value === 'head' ? { headlight: true, color } : { direction: usual(app), color },
                ),
            }),
        `${name}: where it is`,
    );
    const color = colorInput((c, phase) => change({ color: c }, phase), `${name}: colour`);
    const sphere = ball(app, `${name}: direction`, (direction, phase) => change({ direction }, phase));
    const numbers = numbersInput(3, `${name}: direction`, (direction) => length(direction) > 0 && change({ direction }), 3);
    const towards = h(
        'div',
        { class: 'light-direction' },
        sphere,
        field('Towards it', numbers, { help: 'Direction in the world, from the volume to the light' }),
    );
    const element = h(
        'div',
        { class: 'card light' },
        h(
            'div',
            { class: 'row' },
            color,
            kind,
            button('', () => app.edits.apply({ lights: lights().filter((_, i) => i !== index) }), {
                icon: 'trash',
                kind: 'plain',
                title: 'Remove this light',
            }),
        ),
        towards,
    );
    element.update = (light) => {
        kind.update(light.headlight ? 'head' : 'world');
        color.update(light.color ?? WHITE);
        towards.hidden = Boolean(light.headlight);
        if (light.direction) {
            numbers.update(light.direction);
            sphere.update(light.direction);
        }
    };
    return element;
}

/** A new light: from above at the left, as seen now. */
function usual(app) {
    return app.overlay.view ? fromBall(app.overlay.view, -0.5, 0.5) : [0, 0, 1];
}

export function lightsPanel(app) {
    const rows = h('div', { class: 'stack' }),
        hint = h('p', { class: 'hint', role: 'status' });
    const update = () => {
        const lights = get('scene')?.lights;
        if (!lights) return;
        while (rows.children.length > lights.length) rows.lastChild.remove();
        while (rows.children.length < lights.length) rows.append(row(app, rows.children.length));
        lights.forEach((light, i) => rows.children[i].update(light));
        const { mode, shade } = get('scene').render ?? {};
        const lit = mode === 'isosurface' || (mode === 'composite' && shade);
        hint.textContent = !lit
            ? mode === 'composite'
                ? 'Shading is off: lights have no effect.'
                : `The mode ${mode} has no light: it shows values alone.`
            : lights.length
              ? ''
              : 'No light: only the ambient part is seen.';
    };
    watch(['scene', 'panel'], update);
    watch(['frame'], () => get('panel') === 'lights' && update());
    const more = (light) => {
        const lights = get('scene')?.lights ?? [];
        if (lights.length >= MOST) app.messages.tell(`At most ${MOST} lights. Remove one first.`);
        else app.edits.apply({ lights: [...lights, light] });
    };
    return h(
        'div',
        { class: 'stack' },
        hint,
        rows,
        h(
            'div',
            { class: 'row' },
            button('Light', () => more({ direction: usual(app), color: WHITE }), {
                icon: 'plus',
                kind: 'small',
                title: 'A light that stands in the world',
            }),
            button('Headlight', () => more({ headlight: true, color: WHITE }), {
                icon: 'plus',
                kind: 'small',
                title: 'A light that goes with the eye',
            }),
        ),
        h('h3', {}, 'Surfaces'),
        sceneOptions(app, 'render', (name) => SURFACE_ROWS.includes(name)),
    );
}
