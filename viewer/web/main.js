/* SPDX-License-Identifier: MIT */
/* The page: puts the parts together, takes what the server says to the store, and holds the few actions that several parts share. */

import { Edits } from './edits.js';
import { Keys } from './keys.js';
import { Messages } from './messages.js';
import { Meter } from './meter.js';
import { Overlay } from './overlay.js';
import { Panels } from './panels.js';
import { Probe, measureClick, measurePanel } from './measure.js';
import { Progress, savePanel } from './save.js';
import { Slices, slicesPanel } from './slices.js';
import { Trackball } from './trackball.js';
import { acceptDrops, filesPanel } from './files.js';
import { connection, picture, wanted } from './begin.js';
import { cameraPanel } from './camera-panel.js';
import { clipPanel } from './clip.js';
import { get, prefer, ready, set, watch } from './store.js';
import { keepFocus } from './focus.js';
import { lightsPanel } from './lights.js';
import { renderPanel } from './render-panel.js';
import { stretch } from './transfer-model.js';
import { statusLine } from './status.js';
import { surfacesPanel } from './surfaces-panel.js';
import { transferPanel } from './transfer-panel.js';

const RESIZE_MS = 120;
/* The server's own folder of uploaded files, in a message: the user knows the files by their names. */
const UPLOADED = /\S*\/pellucid-view-\w+\/\d+\//g,
    UPLOADED_WHOLE = /\S*\/pellucid-view-\w+\/\d+(?=:|$)/g;
/* What the server does that takes a while. */
const JOBS = { movie: 'Drawing the movie', picture: 'Drawing the picture', open: 'Reading the file' };
const $ = (id) => document.getElementById(id);

const edits = new Edits(connection);
let subject = { id: 0, name: '' };
const meter = new Meter();

/** What the parts share. */
const app = {
    connection,
    edits,
    picture,

    /** A promise whose failure is told in words; undefined then. Anything else passes. */
    async guard(promise) {
        try {
            return await promise;
        } catch (error) {
            app.complain(error);
            return undefined;
        }
    },

    /** What the server says is wrong. That something ended as it was asked to is nothing wrong. */
    complain({ message, code }, name) {
        const text = message.replace(UPLOADED, '').replace(UPLOADED_WHOLE, 'The files sent');
        if (code === 'cancelled') app.messages.tell('Cancelled.');
        else app.messages.error(name ? `${name}: ${text}` : text);
    },

    /** A command that ends in a file: asks, then saves it. */
    async download(command) {
        const file = await app.guard(connection.ask(command, 'download'));
        if (!file) return;
        const link = document.createElement('a');
        Object.assign(link, { href: file.url, download: file.name });
        link.click();
        app.messages.tell(`Saved ${file.name}.`);
    },

    /** A command with the text of a file: what is wrong with it is told under the file's name. */
    sendAbout(command, name) {
        subject = { id: connection.send(command), name };
    },

    look(axis, sign) {
        connection.send({ do: 'view', axis: (sign > 0 ? '+' : '-') + axis, gesture: connection.newGesture() });
    },

    showPanel(name) {
        set({ panel: name });
    },

    measureClick(place, spoken) {
        measureClick(app, place, spoken);
    },

    undo() {
        connection.send({ do: 'undo' });
    },

    redo() {
        connection.send({ do: 'redo' });
    },

    /** A mode; what it needs and is not there yet is chosen by the session. */
    setMode(mode) {
        edits.apply({ render: { mode } });
    },

    /** The colours over another range of values. */
    stretchColors(lo, hi, name) {
        if (name) connection.send({ do: 'colormap', name, range: [lo, hi] });
        else edits.apply({ transfer: { colors: stretch(get('scene').transfer.colors, lo, hi) } });
    },
};

app.messages = new Messages($('messages'), $('banner'), () => connection.connect());
app.progress = new Progress($('progress'));
app.probe = new Probe(app);
app.trackball = new Trackball(picture, connection, {
    click: (at, event) => {
        if (get('tool') === 'measure') app.measureClick({ at });
        else if (event.pointerType === 'touch') app.probe.hover({ at });
    },
    twice: (at) => get('tool') !== 'measure' && connection.send({ do: 'focus', at, gesture: connection.newGesture() }),
    hover: (at) => app.probe.hover(at && { at }),
});
app.overlay = new Overlay(app, picture);
app.slices = new Slices(app, $('stage'));
app.panels = new Panels($('rail'), $('panels'));
for (const panel of [
    {
        name: 'transfer',
        title: 'Transfer function',
        short: 'Transfer',
        icon: 'transfer',
        key: 'T',
        content: transferPanel(app),
        wide: true,
    },
    { name: 'surfaces', title: 'Isosurfaces', short: 'Surfaces', icon: 'surface', key: 'I', content: surfacesPanel(app) },
    { name: 'render', title: 'Rendering', short: 'Render', icon: 'render', key: 'E', content: renderPanel(app) },
    { name: 'lights', title: 'Lights', icon: 'light', key: 'G', content: lightsPanel(app) },
    { name: 'clip', title: 'Clipping', short: 'Clip', icon: 'clip', key: 'C', content: clipPanel(app) },
    { name: 'slices', title: 'Slices', icon: 'slices', key: 'L', content: slicesPanel(app) },
    { name: 'measure', title: 'Probe and measure', short: 'Measure', icon: 'measure', key: 'P', content: measurePanel(app) },
    { name: 'camera', title: 'Camera and view', short: 'Camera', icon: 'camera', key: 'V', content: cameraPanel(app), free: true },
    { name: 'file', title: 'File', icon: 'folder', key: 'D', content: filesPanel(app), free: true },
    { name: 'save', title: 'Save', icon: 'save', key: 'W', content: savePanel(app) },
])
    app.panels.add(panel);
app.keys = new Keys(app, $('help'));
acceptDrops(app, $('drop'));
statusLine($('status'));

/* ---- what the server says ---- */

/** All of a `volume` event but the histogram, which is counted later. */
const facts = ({ histogram, id, ...rest }) => JSON.stringify(rest);

/** Another volume; or the one that is there, told again because its histogram is counted or the connection came back. */
function volume(event) {
    const again = get('volume') && facts(event) === facts(get('volume'));
    if (!again) set({ volume: event, histogram: event.histogram });
    else if (event.histogram) set({ histogram: event.histogram });
}

/** The files are what there is to see. */
function nothingOpen() {
    set({ empty: true, panel: 'file' });
}

const told = {
    hello: (event) => {
        set({ hello: event, devices: event });
        if (event.empty) nothingOpen(); /* a folder was named */
        else set({ empty: false });
    },
    devices: (event) => set({ devices: event }),
    volume,
    state: (event) => edits.state(event),
    error: (event) => {
        const { id, code, do: kind } = event;
        if (kind === 'set') edits.refused();
        if (code === 'nothing') app.messages.tell(kind === 'undo' ? 'Nothing to undo.' : 'Nothing to redo.');
        else app.complain(event, id && id === subject.id ? subject.name : '');
    },
    progress: ({ what, done }) => {
        if (what === 'open' && done >= 1 && !get('volume')) nothingOpen(); /* it failed */
        else if (what === 'open') set({ empty: false });
        if (done >= 1) app.progress.hide(what);
        else app.progress.show(what, JOBS[what] ?? what, done, () => connection.send({ do: 'cancel', what }));
    },
};
connection.addEventListener('event', ({ detail }) => told[detail.event]?.(detail));
connection.addEventListener('link', ({ detail }) => {
    set({ link: detail });
    if (detail.state === 'open') return;
    edits.drop();
    for (const what of Object.keys(JOBS)) app.progress.hide(what);
});
let empty = false; /* the last picture at rest: it is told once */
connection.addEventListener('frame', async ({ detail: { header, picture: data } }) => {
    const target = header.view === 'main' ? picture : app.slices.pictures[header.view];
    try {
        await target?.show(header, data);
    } catch {
        app.messages.error('A picture came that the browser cannot decode. Reload the page; if it stays so, use another browser.');
    }
    connection.shown(header.frame);
    if (header.view === 'main' && target) {
        const latencies = connection.latencies(header.id);
        meter.frame(performance.now(), latencies);
        if (header.empty && !empty)
            app.messages.tell('There is nothing to be seen in the picture: look at the opacities, isovalues, clipping, voids or the camera.');
        if (header.final) empty = header.empty;
        set({ frame: { header, latencies, fps: meter.fps, latency: meter.latency } });
        document.body.classList.add('has-picture');
    }
});

/* ---- the page itself ---- */

watch(['volume', 'scene', 'empty'], () => {
    picture.inert = !ready();
    $('waiting').textContent = get('empty')
        ? 'Nothing is open yet. Choose a file in the panel File, or drop one here.'
        : 'Waiting for the first picture…';
});

let resizing = 0;
function resize() {
    clearTimeout(resizing);
    resizing = setTimeout(() => connection.open && picture.clientWidth > 0 && connection.send({ do: 'size', size: wanted() }), RESIZE_MS);
    app.editor.draw();
}
picture.addEventListener('resized', resize);
let resolution = get('preferences').resolution;
watch(['preferences'], () => {
    const { theme, resolution: now } = get('preferences');
    document.documentElement.dataset.theme = theme;
    if (now !== resolution) resize();
    resolution = now;
    app.editor.draw();
});
watch(['volume'], () => {
    const { name, path } = get('volume');
    const whole = (path ?? '').replace(UPLOADED_WHOLE, name || 'slices');
    const file = whole.split('/').filter(Boolean).at(-1) ?? name;
    $('name').textContent = file;
    $('dims').textContent = `${get('volume').dims.join(' × ')} ${get('volume').type}`;
    document.title = `${file} – Pellucid`;
});
watch(['undo', 'redo'], () => {
    /* Not `disabled`: that would take the focus from under the keyboard. */
    for (const name of ['undo', 'redo']) $(name).setAttribute('aria-disabled', String(!get(name)));
});
for (const name of ['undo', 'redo']) $(name).addEventListener('click', () => get(name) && app[name]());
keepFocus($('panels'));
$('help-button').addEventListener('click', () => app.keys.help());
$('theme').addEventListener('click', () => {
    const dark = getComputedStyle(document.documentElement).colorScheme.includes('dark');
    prefer({ theme: dark ? 'light' : 'dark' });
});
connection.listen();
