/* SPDX-License-Identifier: MIT */
/* The rail of buttons at the edge, and the panel that each opens over the picture: beside the rail in a wide window, as a sheet from below
 * in a narrow one. One panel at a time; Escape closes it. Until a file is open, those that are of no use without one are out of reach. */

import { get, ready, set, watch } from './store.js';
import { button, h, icon } from './dom.js';

export class Panels {
    #panels = new Map();

    constructor(rail, host) {
        this.rail = rail;
        this.host = host;
        watch(['panel'], () => this.#show());
        watch(['volume', 'scene', 'empty'], () => this.#lock());
        /* As a sheet from below the panel leaves the picture what it does not take. */
        new ResizeObserver(() => document.documentElement.style.setProperty('--sheet', `${host.offsetHeight}px`)).observe(host);
        host.addEventListener('keydown', (event) => {
            if (event.key === 'Escape') {
                event.stopPropagation();
                this.close();
            }
        });
    }

    /** @param {{name, title, icon, key, content: Element, wide?: boolean, free?: boolean}} panel  `free`: of use with no file open */
    add(panel) {
        const toggle = h(
            'button',
            {
                type: 'button',
                class: 'rail-button',
                id: `open-${panel.name}`,
                'aria-expanded': 'false',
                'aria-controls': `panel-${panel.name}`,
                title: `${panel.title} (${panel.key})`,
                onclick: () => this.toggle(panel.name),
            },
            icon(panel.icon),
            h('span', {}, panel.short ?? panel.title),
        );
        const head = h(
            'header',
            {},
            h('h2', { id: `title-${panel.name}` }, panel.title),
            h('span', { class: 'spring' }),
            panel.wide
                ? button('', () => this.host.classList.toggle('wide'), { icon: 'wide', kind: 'plain', title: 'Wider or narrower' })
                : null,
            button('', () => this.close(), { icon: 'close', kind: 'plain', title: 'Close (Escape)' }),
        );
        const body = h('div', { class: 'panel-body' }, panel.content);
        const choose = button('Choose a file', () => this.#choose(), { kind: 'small' });
        const first = panel.free ? null : h('p', { class: 'open-first', hidden: true }, 'Open a file first.', choose);
        const section = h(
            'section',
            { class: 'panel', id: `panel-${panel.name}`, 'aria-labelledby': `title-${panel.name}`, tabindex: '-1', hidden: true },
            head,
            first,
            body,
        );
        this.rail.append(toggle);
        this.host.append(section);
        this.#panels.set(panel.name, { ...panel, toggle, section, body, first });
        this.#show();
        this.#lock();
    }

    get list() {
        return [...this.#panels.values()];
    }

    toggle(name) {
        set({ panel: get('panel') === name ? null : name });
    }

    close() {
        const { toggle } = this.#panels.get(get('panel')) ?? {};
        set({ panel: null });
        toggle?.focus();
    }

    #choose() {
        set({ panel: 'file' });
        this.#panels.get('file').section.focus();
    }

    #lock() {
        const locked = !ready();
        for (const { free, body, first } of this.#panels.values()) {
            if (free) continue;
            body.inert = locked;
            first.hidden = !locked || !get('empty');
        }
    }

    #show() {
        const open = get('panel');
        for (const [name, { toggle, section }] of this.#panels) {
            section.hidden = name !== open;
            toggle.setAttribute('aria-expanded', String(name === open));
        }
        document.body.classList.toggle('panel-open', this.#panels.has(open));
    }
}
