/* SPDX-License-Identifier: MIT */
/* The one store: what the page knows. Whoever shows something subscribes to the keys that it shows; nobody else keeps a copy that lasts.
 *
 * hello, volume, scene, undo, redo   as the server's events told them (viewer/protocol.md); volume stays the same object as long as it is
 *            the same volume
 * empty      nothing is open, nor being opened
 * histogram  of the volume, or null until it is counted
 * devices    {device, devices}: what draws, and what could
 * frame      header of the main picture's last frame shown, with `latencies` of the inputs that it is the
 *            first to show, and over the last ones `latency` and `fps`
 * link       {state: "connecting" | "open" | "lost" | "refused"}
 * measures   {list, first}: distances, and the first place of one to come
 * panel      name of the open panel or null
 * layout     "one" | "four" (with slices)
 * tool       "turn" | "measure"
 * cursor     what `probe` found under the pointer, or null
 * preferences, kept in the browser: theme, resolution, overlays,
 *            counts, power (of the transfer function's editor) */

const values = new Map();
const listeners = new Map();

export const get = (key) => values.get(key);

/** Is there something to work on? Until then most controls and keys have no meaning. */
export const ready = () => Boolean(get('volume') && get('scene'));

/** Sets keys and tells their listeners once each, after all are set. */
export function set(changes) {
    const changed = Object.keys(changes).filter((key) => values.get(key) !== changes[key]);
    for (const key of changed) values.set(key, changes[key]);
    const told = new Set();
    for (const key of changed) {
        for (const listener of listeners.get(key) ?? []) {
            if (!told.has(listener)) {
                told.add(listener);
                listener(changes);
            }
        }
    }
}

/** Calls back whenever one of the keys changes, and once now where one is set already. */
export function watch(keys, listener) {
    for (const key of keys) {
        if (!listeners.has(key)) listeners.set(key, new Set());
        listeners.get(key).add(listener);
    }
    if (keys.some((key) => values.has(key))) listener({});
}

const STORED = 'pellucid';

/** Preferences live in the browser, not in the scene: another page may see the same scene in another theme. */
export function loadPreferences(fallback) {
    let stored = {};
    try {
        stored = JSON.parse(localStorage.getItem(STORED)) ?? {};
    } catch {
        /* no storage (private window) or nonsense in it: as if nothing were stored */
    }
    set({ preferences: { ...fallback, ...stored } });
}

export function prefer(changes) {
    const preferences = { ...get('preferences'), ...changes };
    set({ preferences });
    try {
        localStorage.setItem(STORED, JSON.stringify(preferences));
    } catch {
        /* kept for this page alone */
    }
}
