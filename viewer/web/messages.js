/* SPDX-License-Identifier: MIT */
/* What is wrong, or was done, in words: notes that go by themselves, errors that stay until they are read, and the line about the
 * connection. */

import { button, h } from './dom.js';
import { get, watch } from './store.js';

const NOTE_MS = 5000,
    ERROR_MS = 15000;

export class Messages {
    #texts = new Map();

    constructor(host, banner, reconnect) {
        this.host = host;
        this.banner = banner;
        watch(['link'], () => this.#link(reconnect));
    }

    #show(text, kind, stay) {
        const before = this.#texts.get(text);
        if (before?.isConnected) before.remove();
        const note = h(
            'div',
            { class: `message ${kind}`, role: kind === 'error' ? 'alert' : 'status' },
            h('span', {}, text),
            button('', () => note.remove(), { icon: 'close', kind: 'plain', title: 'Dismiss' }),
        );
        this.#texts.set(text, note);
        this.host.append(note);
        while (this.host.children.length > 4) this.host.firstChild.remove();
        setTimeout(() => note.remove(), stay);
    }

    tell(text) {
        this.#show(text, 'note', NOTE_MS);
    }

    error(text) {
        this.#show(text, 'error', ERROR_MS);
    }

    #link(reconnect) {
        const { state, wait } = get('link');
        const text = {
            connecting: get('hello') ? 'Connecting again…' : '',
            open: '',
            lost:
                `The connection to the server was lost. Trying again${wait > 1000 ? ` every ${Math.round(wait / 1000)} s` : ''}. ` +
                'If it stays so, start “pellucid view” again and open the address that it prints.',
            refused: 'The server refuses this address: its token is another one. Open the address that “pellucid view” printed last.',
        }[state];
        this.banner.hidden = !text;
        this.banner.replaceChildren(text, ...(text && state !== 'connecting' ? [button('Try now', reconnect, { kind: 'small' })] : []));
    }
}
