/* SPDX-License-Identifier: MIT */
/* The chooser of colour maps: a grid of previews. */

import { h, svg } from './dom.js';
import { get, watch } from './store.js';

let strips = 0;

/** A strip that shows colours ("#rrggbb", evenly spaced). */
function strip(colors) {
    const id = `strip-${++strips}`;
    return svg(
        'svg',
        { class: 'strip', viewBox: '0 0 100 10', preserveAspectRatio: 'none', 'aria-hidden': 'true' },
        svg(
            'defs',
            {},
            svg(
                'linearGradient',
                { id },
                colors.map((color, i) => svg('stop', { offset: i / Math.max(colors.length - 1, 1), 'stop-color': color })),
            ),
        ),
        svg('rect', { width: 100, height: 10, fill: `url(#${id})` }),
    );
}

/** A grid of buttons, one a map; calls back with the name. */
export function colormapGrid(onchoose) {
    const grid = h('div', { class: 'colormaps', role: 'group', 'aria-label': 'Colour maps' });
    watch(['hello'], () =>
        grid.replaceChildren(
            ...(get('hello')?.colormaps ?? []).map((map) =>
                h(
                    'button',
                    { type: 'button', class: 'colormap', 'data-map': map.name, title: map.name, onclick: () => onchoose(map.name) },
                    strip(map.colors),
                    h('span', {}, map.name),
                ),
            ),
        ),
    );
    watch(['hello', 'scene'], () => {
        const name = get('scene')?.transfer?.colormap;
        for (const button of grid.children) button.setAttribute('aria-pressed', String(button.dataset.map === name));
    });
    return grid;
}
