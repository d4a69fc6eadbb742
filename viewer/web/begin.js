/* SPDX-License-Identifier: MIT */
/* What cannot wait: asks the server for the first picture while the rest of the page is still on its way. main.js takes over from here. */

import './picture.js';
import { Connection } from './connection.js';
import { get, loadPreferences, set } from './store.js';

loadPreferences({ theme: 'auto', resolution: '1', overlays: true, counts: 'log', power: 2 });
/* The open panel and the theme decide what is left for the picture, so they come before its size is asked for. */
const panel = matchMedia('(min-width: 900px)').matches ? 'transfer' : null;
set({ layout: 'one', tool: 'turn', panel });
document.documentElement.dataset.theme = get('preferences').theme;
document.body.classList.toggle('panel-open', panel !== null);

export const picture = document.getElementById('main');

/** The size in pixels that a picture should have, by what the user prefers; `most` as in Picture.wanted. */
export function wanted(of = picture, most = undefined) {
    const part = { 1: 1, css: 1 / (window.devicePixelRatio || 1), 0.5: 0.5 }[get('preferences').resolution] ?? 1;
    return of.wanted(part, most);
}

export const connection = new Connection(() => ({ do: 'hello', size: wanted() }));
connection.connect();
