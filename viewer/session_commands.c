/* SPDX-License-Identifier: MIT */
/* The commands by name: which keys each takes, and what it needs and does. To add one: its function in a file of its kind, and a line in
 * the table. */
#include "session_commands.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "record.h"

enum {
    FREE = 1 << 0,   /* needs no volume */
    EDIT = 1 << 1,   /* changes the scene: a step of the history, and a new picture */
    CAMERA = 1 << 2, /* an edit of the camera alone */
    FIRST = 1 << 3,  /* may come before hello */
    STEP = 1 << 4,   /* goes along the history */
    READS = 1 << 5,  /* reads a file, if need be */
};

struct session_command {
    const char *name;
    const char *keys; /* beside do, id and gesture; separated and ended by spaces */
    int flags;
    bool (*run)(struct call *call);
};

/* ---- reading of keys ---- */

bool call_has(const struct call *call, const char *key)
{
    const json_t *value = json_object_get(call->json, key);
    return value && !json_is_null(value);
}

bool call_numbers(const struct call *call, const char *key, size_t count, double *out)
{
    const json_t *list = json_object_get(call->json, key);
    if (!json_is_array(list) || json_array_size(list) != count)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: it must be a list of %zu numbers", key, count);
    for (size_t i = 0; i < count; i++) {
        const json_t *value = json_array_get(list, i);
        out[i] = json_number_value(value);
        if (!json_is_number(value) || !(fabs(out[i]) <= 1e100))
            return session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: entry %zu is no number up to 1e100", key, i + 1);
    }
    return true;
}

bool call_number(const struct call *call, const char *key, double least, double most, double *out)
{
    const json_t *value = json_object_get(call->json, key);
    *out = json_number_value(value);
    if (json_is_number(value) && *out >= least && *out <= most)
        return true;
    return session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: it must be a number from %g to %g", key, least, most);
}

bool call_size(const struct call *call, const char *key, double most_side, double most_pixels, int size[2])
{
    double sides[2];
    if (!call_numbers(call, key, 2, sides))
        return false;
    for (int i = 0; i < 2; i++)
        if (sides[i] != floor(sides[i]) || sides[i] < SESSION_LEAST_SIDE || sides[i] > most_side)
            return session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: %g is no whole number of pixels from %d to %g", key, sides[i],
                                SESSION_LEAST_SIDE, most_side);
    if (sides[0] * sides[1] > most_pixels)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: %g x %g are more than %g pixels; ask for a smaller picture", key,
                            sides[0], sides[1], most_pixels);
    size[0] = (int)sides[0];
    size[1] = (int)sides[1];
    return true;
}

const char *call_text(const struct call *call, const char *key, size_t most)
{
    const json_t *value = json_object_get(call->json, key);
    const char *text = json_string_value(value);
    size_t length = json_string_length(value);
    if (text && length > 0 && length < most && !memchr(text, 0, length))
        return text;
    session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: it must be a text of 1 to %zu bytes", key, most - 1);
    return NULL;
}

/* ---- what concerns the client alone ---- */

/* The widest shape, for the camera's angle is of the height: what any client would see is then in the picture. As wide as the client with
 * the most columns asks, which has no fewer rows than that gives: so the limits of one client's size hold. */
void session_size_again(struct session *s)
{
    const int *widest = NULL;
    int width = 0;
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++) {
        const int *size = s->clients[i].size;
        if (!s->clients[i].number || !size[0])
            continue;
        if (!widest || (int64_t)size[0] * widest[1] > (int64_t)widest[0] * size[1])
            widest = size;
        width = size[0] > width ? size[0] : width;
    }
    if (!widest)
        return;
    int height = (int)((int64_t)width * widest[1] / widest[0]);
    if (s->size[0] == width && s->size[1] == height)
        return;
    s->size[0] = width;
    s->size[1] = height;
    session_fit_again(s);
    session_changed(s, true);
    s->state_dirty = true;
}

static bool take_size(struct call *call)
{
    int size[2];
    if (!call_size(call, "size", SESSION_MOST_SIDE, SESSION_MOST_PIXELS, size) || !session_check_memory(size, call->error))
        return false;
    memcpy(call->client->size, size, sizeof size);
    session_size_again(call->session);
    return true;
}

static bool run_hello(struct call *call)
{
    struct session *s = call->session;
    if (!take_size(call))
        return false;
    call->client->greeted = true;
    s->greeted = true;
    session_tell_hello(s, call->client->number, call);
    if (s->volume) {
        session_tell_volume(s, call->client->number);
        session_tell_state(s, call->client->number);
        session_changed(s, true); /* so that this client, too, gets a frame */
    }
    return true;
}

static bool run_size(struct call *call)
{
    return take_size(call);
}

static bool run_hold(struct call *call)
{
    call->client->held = true;
    session_interrupt(call->session);
    call->session->state_dirty = true;
    return true;
}

static bool run_release(struct call *call)
{
    call->client->held = false;
    call->session->release = !session_held(call->session);
    call->session->state_dirty = true;
    return true;
}

static const struct session_command commands[] = {
    { "hello", "size ", FREE | FIRST, run_hello },
    { "size", "size ", FREE, run_size },
    { "hold", "", FREE, run_hold },
    { "release", "", FREE, run_release },
    { "rotate", "by ", EDIT | CAMERA, run_rotate },
    { "pan", "by ", EDIT | CAMERA, run_pan },
    { "zoom", "by at ", EDIT | CAMERA, run_zoom },
    { "roll", "by ", EDIT | CAMERA, run_roll },
    { "focus", "at ", EDIT | CAMERA, run_focus },
    { "view", "axis ", EDIT | CAMERA, run_view },
    { "reset", "", EDIT | CAMERA, run_reset },
    { "set", "scene ", EDIT, run_set },
    { "automatic", "what ", EDIT, run_automatic },
    { "colormap", "name range ", EDIT, run_colormap },
    { "import", "text name ", EDIT, run_import },
    { "export", "", 0, run_export },
    { "undo", "", STEP | READS, run_undo },
    { "redo", "", STEP | READS, run_redo },
    { "probe", "at world opacity ", 0, run_probe },
    { "slices", "at size window views ", 0, run_slices },
    { "picture", "size background ", 0, run_picture },
    { "movie", "size frames degrees format background ", 0, run_movie },
    { "cancel", "what ", FREE, run_cancel },
    { "scene", "", 0, run_scene },
    { "device", "device ", 0, run_device },
    { "list", "path ", FREE, run_list },
    { "open", "path array ", FREE | READS, run_open },
};

static bool has_word(const char *words, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = words; *at; at += strcspn(at, " ") + 1)
        if (strncmp(at, word, length) == 0 && at[length] == ' ')
            return true;
    return false;
}

static bool check(const struct call *call, const struct session_command *command)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)call->json, key, value)
        if (!has_word("do id gesture ", key) && !has_word(command->keys, key))
            return session_fail(call->error, PEL_ERROR_ARGUMENT, "%.60s: %s has no such key", key, command->name);
    if (!call->client->greeted && !(command->flags & FIRST))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "the first command of a client is hello");
    if (!call->session->volume && !(command->flags & FREE))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "there is no volume yet; open a file first");
    if (command->flags & READS && call->session->opening)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "a file is being read already; wait for it, or cancel it");
    if (command->flags & EDIT && !(command->flags & CAMERA) && session_open_steps(call->session))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "undo or redo is reading a file; wait for it, or cancel it");
    return true;
}

/* An edit is a step of the history, unless it continues a gesture or changed nothing. Nor are the camera's moves while undo or redo reads a
 * file: where they would lead ends when it is read. */
static bool run_edit(struct call *call, const struct session_command *command)
{
    struct session *s = call->session;
    struct history_step before = { .text = NULL };
    bool step = !session_open_steps(s) && history_begins(&s->history, call->client->number, call->gesture);
    if (step && !(before = session_step(s, call->error)).text)
        return false;
    bool fine = command->run(call);
    if (fine) {
        bool camera = command->flags & CAMERA;
        session_changed(s, camera);
        s->state_dirty |= !camera || !session_held(s);
    }
    if (fine && before.text) {
        char *after = pel_scene_to_text(&s->scene, NULL, NULL);
        if (!after || strcmp(before.text, after) != 0) {
            history_push(&s->history, call->client->number, call->gesture, before);
            s->state_dirty = true;
            before.text = NULL;
        }
        free(after);
    }
    free(before.text);
    return fine;
}

bool session_command_run(struct call *call)
{
    struct session *s = call->session;
    const struct session_command *command = NULL;
    for (size_t i = 0; i < sizeof commands / sizeof *commands && !command; i++)
        if (strcmp(commands[i].name, call->name) == 0)
            command = &commands[i];
    if (!command)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "do: there is no command %.60s", call->name);
    if (!check(call, command))
        return false;
    if (s->params.record) {
        bool aside = command->flags & CAMERA && session_open_steps(s);
        record_command(s->params.record, session_now() - s->started_ms, call->client->number, call->json, aside);
        s->recorded++;
    }
    return command->flags & EDIT ? run_edit(call, command) : command->run(call);
}
