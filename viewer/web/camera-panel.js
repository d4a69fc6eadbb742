/* SPDX-License-Identifier: MIT */
/* The camera in buttons and numbers; and how this page looks. */

import { button, field, h } from './dom.js';
import { checkbox, select } from './controls.js';
import { placeName } from './geometry.js';
import { get, prefer, watch } from './store.js';
import { sceneOptions } from './render-panel.js';

export function cameraPanel(app) {
    const views = h('div', { class: 'views', role: 'group', 'aria-label': 'Look from' });
    watch(['volume'], () => {
        const { space } = get('volume');
        views.replaceChildren(
            ...['x', 'y', 'z'].flatMap((axis, i) =>
                [1, -1].map((sign, j) => {
                    const place = placeName(space, i, sign);
                    return button(place[0].toUpperCase() + place.slice(1), () => app.look(axis, sign), {
                        kind: 'small',
                        title: `Look from ${place}, key ${2 * i + j + 1}`,
                    });
                }),
            ),
        );
    });
    const theme = select(
        [
            ['auto', 'as the system'],
            ['dark', 'dark'],
            ['light', 'light'],
        ],
        (value) => prefer({ theme: value }),
        'Theme',
    );
    const overlays = checkbox((on) => prefer({ overlays: on }), 'Axes, scale bar and legend');
    watch(['preferences'], () => {
        theme.update(get('preferences').theme);
        overlays.update(get('preferences').overlays);
    });
    return h(
        'div',
        { class: 'stack' },
        views,
        h(
            'div',
            { class: 'row' },
            button('Reset', () => app.connection.send({ do: 'reset', gesture: app.connection.newGesture() }), {
                icon: 'reset',
                kind: 'small',
                title: 'The camera of the start (R)',
            }),
            button('Fit', () => app.connection.send({ do: 'automatic', what: 'camera' }), {
                kind: 'small',
                title: 'The whole volume in view',
            }),
        ),
        h('h3', {}, 'Camera'),
        sceneOptions(app, 'camera'),
        h('h3', {}, 'This page'),
        field('Theme', theme),
        field('Overlays', overlays, { help: 'Axes, scale bar and legend over the picture' }),
    );
}
