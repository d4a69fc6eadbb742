/* SPDX-License-Identifier: MIT */
/* The focus of the keyboard stays near where a focused control went or was disabled: without this it would start at the page's top. */

const TAKES = 'button:not(:disabled), input:not(:disabled, [tabindex="-1"]), select:not(:disabled), [tabindex="0"]';

const firstIn = (element) => [element, ...element.querySelectorAll(TAKES)].find((e) => e.matches(TAKES) && e.getClientRects().length);

/** Watches the controls within an element; a neighbour takes the focus of one that goes, or else the closest around it that can. */
export function keepFocus(host) {
    let last = null,
        around = []; /* [element, which of its children] from the focused one outwards */
    const forget = ({ target }) => {
        if (!last?.contains(target)) last = null;
    };
    document.addEventListener('pointerdown', forget, true);
    document.addEventListener('focusin', forget, true);
    host.addEventListener('focusin', ({ target }) => {
        last = target;
        around = [];
        for (let e = target; e !== host; e = e.parentElement) around.push([e.parentElement, [...e.parentElement.children].indexOf(e)]);
    });
    const look = () => {
        if (!last || (last.isConnected && !last.disabled) || document.activeElement?.matches('body') === false) return;
        last = null;
        for (const [element, at] of around) {
            if (!element.isConnected) continue;
            const near = [element.children[at], element.children[at - 1], element].filter(Boolean).map(firstIn).find(Boolean);
            if (near) return near.focus();
        }
    };
    new MutationObserver(look).observe(host, { childList: true, subtree: true, attributes: true, attributeFilter: ['disabled'] });
}
