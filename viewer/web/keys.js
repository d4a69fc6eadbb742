/* SPDX-License-Identifier: MIT */
/* Keys, and the list of them that `?` shows. Where a field or the editor has the focus, keys are theirs. */

import { button, h } from './dom.js';
import { placeName } from './geometry.js';
import { get, prefer, ready, set } from './store.js';

const TURN = 0.025; /* of the picture: 5 degrees */
const VIEWS = ['x', 'y', 'z'].flatMap((axis) => [1, -1].map((sign) => [axis, sign]));
const placeOf = ([axis, sign]) => placeName(get('volume')?.space, 'xyz'.indexOf(axis), sign);

const MOUSE = [
    ['Left drag', 'turns'],
    ['Middle or Shift left drag', 'pans'],
    ['Right drag, wheel', 'zooms'],
    ['Ctrl left drag', 'rolls'],
    ['Double click', 'the focal point goes there'],
    ['One finger, two fingers', 'turns; pans, zooms and rolls'],
    ['Tap', 'tells what is there (panel Probe and measure)'],
];
const SLICE = [
    ['Left drag, arrows', 'move the cross-hair'],
    ['Wheel, Page Up, Page Down', 'step through; Shift ten at once'],
    ['Space', 'marks the cross-hair for a distance'],
    ['Right drag', 'window and level'],
    ['Middle or Shift drag, Ctrl arrows', 'pan'],
    ['Ctrl wheel, +  −', 'zoom'],
    ['0', 'the whole slices'],
    ['Double click, Enter', 'one large, or all again'],
];
const EDITOR = [
    ['Drag a point', 'Shift keeps the value, Alt the opacity, Ctrl is fine'],
    ['Drag under the curve', 'moves the band'],
    ['Double click', 'adds a point, on the bar a colour'],
    ['Right click, Delete', 'removes it'],
    ['Wheel, drag beside', 'zooms values, pans'],
    ['Page Up, Page Down', 'choose a point, a colour, an isovalue'],
    ['Arrows', 'move it; Shift far, Ctrl fine'],
    ['B', 'takes the whole band of a point: arrows move it, up and down make it stronger and weaker'],
    ['Insert', 'adds one after it'],
];

/** Alt as a way to a character: AltGr, or the Alt of a Mac for [ and ]. */
const writes = (event) => event.getModifierState('AltGraph') || (event.altKey && '[]'.includes(event.key));

/** With Alt keys are the browser's own (back, menus). */
export const browsers = (event) => event.altKey && !writes(event);

export class Keys {
    constructor(app, dialog) {
        this.app = app;
        this.dialog = dialog;
        const { connection, trackball } = app;
        const camera = (command) => connection.send({ ...command, gesture: connection.newGesture() });
        /* [keys as shown, what it does (or what tells it), test, action, whether it is of use with no file open] */
        this.table = [
            ['Arrows', 'turn', (e) => e.key.startsWith('Arrow') && !e.shiftKey, (e) => trackball.nudge('rotate', this.#arrow(e))],
            ['Shift arrows', 'pan', (e) => e.key.startsWith('Arrow') && e.shiftKey, (e) => trackball.nudge('pan', this.#arrow(e))],
            ['+  −', 'zoom', (e) => '+=-'.includes(e.key), (e) => trackball.nudge('zoom', e.key === '-' ? 1 / 1.1 : 1.1)],
            ['[  ]', 'roll', (e) => '[]'.includes(e.key), (e) => trackball.nudge('roll', e.key === '[' ? 5 : -5)],
            ['R', 'the camera of the start', 'r', () => camera({ do: 'reset' })],
            ['1 … 6', () => `look from ${VIEWS.map(placeOf).join(', ')}`, (e) => /^[1-6]$/.test(e.key), (e) => app.look(...VIEWS[e.key - 1])],
            ['O', 'parallel or perspective', 'o', () => app.edits.apply({ camera: { parallel: !get('scene')?.camera?.parallel } })],
            ['F', 'focal point in the middle of what is seen', 'f', () => camera({ do: 'focus', at: [0.5, 0.5] })],
            ['Ctrl Z', 'undo', (e) => this.#ctrl(e, 'z') && !e.shiftKey, () => app.undo()],
            ['Ctrl Shift Z, Ctrl Y', 'redo', (e) => (this.#ctrl(e, 'z') && e.shiftKey) || this.#ctrl(e, 'y'), () => app.redo()],
            ['Ctrl S', 'save the picture', (e) => this.#ctrl(e, 's'), () => app.savePicture()],
            ['Space', 'marks what is in the middle, for a distance', (e) => this.#space(e), () => app.measureClick({ at: [0.5, 0.5] }, true)],
            ['M', 'measure a distance', 'm', () => set({ tool: get('tool') === 'measure' ? 'turn' : 'measure' })],
            ['S', 'three slices on or off', 's', () => set({ layout: get('layout') === 'four' ? 'one' : 'four' })],
            ['H', 'hide or show axes, scale bar, legend', 'h', () => prefer({ overlays: !get('preferences').overlays }), true],
            ['?', 'this list', (e) => e.key === '?', () => this.help(), true],
        ];
        this.panels = app.panels.list.map(({ name, key, title }) => [key, title, key.toLowerCase(), () => app.panels.toggle(name), true]);
        addEventListener('keydown', (event) => this.#press(event));
    }

    #ctrl(event, key) {
        return (event.ctrlKey || event.metaKey) && !event.altKey && event.key.toLowerCase() === key;
    }

    /** On controls it presses them. */
    #space({ key, target }) {
        return key === ' ' && Boolean(target.closest?.('pel-picture'));
    }

    #arrow({ key }) {
        const x = { ArrowLeft: -1, ArrowRight: 1 }[key] ?? 0,
            y = { ArrowUp: -1, ArrowDown: 1 }[key] ?? 0;
        return [x * TURN, y * TURN];
    }

    #press(event) {
        const typing = event.target.closest?.('input:not([type=checkbox], [type=range], [type=color]), textarea, select');
        const control = event.target.closest?.('input, select, button, dialog');
        /* AltGr, which writes [ and ] on many keyboards, comes as Ctrl and Alt on Windows. */
        const modified = (event.ctrlKey || event.metaKey) && !writes(event);
        if (typing && !(modified && !['z', 'y'].includes(event.key.toLowerCase()))) return;
        if ((control && /^(Arrow|Home|End|Page)/.test(event.key)) || this.dialog.open || browsers(event)) return;
        if (event.key === 'Escape') {
            if (get('tool') === 'measure') set({ tool: 'turn' });
            else this.app.panels.close();
            return;
        }
        for (const [, , test, action, free] of [...this.table, ...this.panels]) {
            const hit =
                typeof test === 'string'
                    ? !modified && !event.altKey && event.key.toLowerCase() === test
                    : (!modified || /^(z|y|s)$/i.test(event.key)) && test(event);
            if (hit) {
                event.preventDefault();
                if (free || ready()) action(event);
                else if (get('empty')) this.app.messages.tell('Open a file first.');
                return;
            }
        }
    }

    help() {
        const table = (title, rows) =>
            h(
                'div',
                {},
                h('h3', {}, title),
                h(
                    'dl',
                    { class: 'keys' },
                    rows.flatMap(([keys, what]) => [h('dt', {}, keys), h('dd', {}, typeof what === 'function' ? what() : what)]),
                ),
            );
        this.dialog.replaceChildren(
            h(
                'header',
                {},
                h('h2', { id: 'help-title' }, 'Keys and mouse'),
                h('span', { class: 'spring' }),
                button('', () => this.dialog.close(), { icon: 'close', kind: 'plain', title: 'Close (Escape)' }),
            ),
            h(
                'div',
                { class: 'help-columns' },
                table('Picture', MOUSE),
                table('Keys', this.table),
                table('Panels', this.panels),
                table('Slices', SLICE),
                table('Transfer function', EDITOR),
            ),
        );
        this.dialog.showModal();
    }
}
