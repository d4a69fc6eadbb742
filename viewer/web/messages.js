/* SPDX-License-Identifier: MIT */
/* What is wrong, or was done, in words: notes, and errors that stay longer; both go by themselves or when they are dismissed. And the line
 * about the connection, which stays as long as there is none. */

import { button, h } from './dom.js';
import { get, watch } from './store.js';

const NOTE_MS = 5000,
    ERROR_MS = 15000;
const LOST =
    'The connection to the server was lost. Trying again. ' +
    'If it stays so, start “pellucid view” again and open the address that it prints.';
const REFUSED = 'The server refuses this address: its token is another one. Open the address that “pellucid view” printed last.';

export class Messages {
    constructor(host, banner, reconnect) {
        this.host = host;
        this.banner = banner;
        this.text = '';
        watch(['link'], () => this.#link(reconnect));
    }

    #show(text, kind, stay) {
        for (const before of [...this.host.children]) if (before.firstChild.textContent === text) before.remove();
        const note = h(
            'div',
            { class: `message ${kind}`, role: kind === 'error' ? 'alert' : 'status' },
            h('span', {}, text),
            button('', () => note.remove(), { icon: 'close', kind: 'plain', title: 'Dismiss' }),
        );
        this.host.append(note);
        this.#keep('.note', 2);
        this.#keep('.message', 4);
        setTimeout(() => note.remove(), stay);
    }

    /** Only the newest of a kind: they cover the picture. */
    #keep(kind, most) {
        for (const old of [...this.host.querySelectorAll(kind)].slice(0, -most)) old.remove();
    }

    tell(text) {
        this.#show(text, 'note', NOTE_MS);
    }

    error(text) {
        this.#show(text, 'error', ERROR_MS);
    }

    #link(reconnect) {
        const text = { open: '', lost: LOST, refused: REFUSED }[get('link').state];
        /* While it is tried again the words stay as they are: a reader of the screen would read them out at each try. */
        if (text === undefined || text === this.text) return;
        if (text === LOST && this.text === REFUSED) return;
        this.text = text;
        this.banner.hidden = !text;
        this.banner.replaceChildren(text, ...(text ? [button('Try now', reconnect, { kind: 'small' })] : []));
    }
}
