/* SPDX-License-Identifier: MIT */
/* Edits of the scene. Each is made on a copy, which takes the scene's place only when it can be drawn. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "session_inside.h"

bool session_copy_scene(const struct session *s, struct pel_scene *copy, struct pel_error *error)
{
    *copy = s->scene;
    copy->transfer = (struct pel_transfer) { 0 };
    return pel_transfer_copy(&copy->transfer, &s->scene.transfer, error);
}

void session_drop_impossible_technique(const struct session *s, struct pel_scene *scene)
{
    if (!pel_technique_check(scene, s->device, NULL))
        scene->technique = (struct pel_technique_choice) { .name = "" };
}

bool session_take_scene(struct session *s, struct pel_scene *changed, struct pel_error *error)
{
    const double *n = changed->slice.normal;
    const struct pel_scene_parts missing = {
        .isosurfaces = changed->render.mode == PEL_MODE_ISOSURFACE && changed->isosurface_count == 0,
        .slice = n[0] == 0 && n[1] == 0 && n[2] == 0,
    };
    bool fine = pel_technique_check(changed, s->device, error) && pel_scene_choose(changed, &missing, s->size[0], s->size[1], error) &&
                pel_scene_check(changed, error);
    if (!fine) {
        pel_transfer_finish(&changed->transfer);
        return false;
    }
    pel_transfer_finish(&s->scene.transfer);
    s->scene = *changed;
    return true;
}

bool run_set(struct call *call)
{
    struct session *s = call->session;
    const json_t *part = json_object_get(call->json, "scene");
    struct pel_scene changed;
    if (!json_is_object(part))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "scene: it must be an object, part of a scene file");
    if (json_object_get(part, "volume"))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "scene: volume: another volume is opened with `open`");
    char *text = json_dumps(part, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!text)
        return session_fail(call->error, PEL_ERROR_MEMORY, "scene: no memory for it");
    bool fine = session_copy_scene(s, &changed, call->error);
    if (fine && !pel_scene_from_text(text, strlen(text), NULL, &changed, NULL, call->error)) {
        pel_transfer_finish(&changed.transfer);
        fine = false;
    }
    free(text);
    return fine && session_take_scene(s, &changed, call->error);
}

bool run_automatic(struct call *call)
{
    struct session *s = call->session;
    const char *what = call_text(call, "what", 32);
    struct pel_scene changed;
    if (!what)
        return false;
    const struct pel_scene_parts parts = {
        .transfer = strcmp(what, "transfer") == 0,
        .isosurfaces = strcmp(what, "isosurfaces") == 0,
        .camera = strcmp(what, "camera") == 0,
        .slice = strcmp(what, "slice") == 0,
    };
    if (!parts.transfer && !parts.isosurfaces && !parts.camera && !parts.slice)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "what: it must be transfer, isosurfaces, camera or slice");
    if (!session_copy_scene(s, &changed, call->error))
        return false;
    if (parts.camera)
        session_fit_camera(s, &changed.camera);
    if (parts.camera || pel_scene_choose(&changed, &parts, s->size[0], s->size[1], call->error))
        return session_take_scene(s, &changed, call->error);
    pel_transfer_finish(&changed.transfer);
    return false;
}

bool run_colormap(struct call *call)
{
    const char *name = call_text(call, "name", 64);
    struct pel_scene changed;
    double range[2];
    if (!name || !call_numbers(call, "range", 2, range) || !session_copy_scene(call->session, &changed, call->error))
        return false;
    if (pel_transfer_set_colormap(&changed.transfer, name, range[0], range[1], call->error))
        return session_take_scene(call->session, &changed, call->error);
    pel_transfer_finish(&changed.transfer);
    return false;
}

bool run_import(struct call *call)
{
    struct session *s = call->session;
    const char *text = call_text(call, "text", SESSION_MOST_BYTES), *name = NULL;
    double lo = s->scene.volume->range[0], hi = s->scene.volume->range[1];
    struct pel_scene changed;
    if (!text || (call_has(call, "name") && !(name = call_text(call, "name", 256))))
        return false;
    if (!(lo < hi)) /* one value, or none at all */
        hi = (lo = lo == hi ? lo : 0) + 1;
    if (!session_copy_scene(s, &changed, call->error))
        return false;
    if (pel_transfer_from_text(text, strlen(text), name, lo, hi, &changed.transfer, call->error))
        return session_take_scene(s, &changed, call->error);
    pel_transfer_finish(&changed.transfer);
    return false;
}

/* Offers a text (freed) for download. */
static bool offer(struct call *call, char *text, const char *name)
{
    if (!text)
        return false;
    int fd = download_file(call->error);
    bool fine = fd >= 0 && download_write(fd, text, strlen(text), call->error);
    free(text);
    if (fine)
        session_offer(call->session, call->client->number, fd, name, "application/json", call);
    else if (fd >= 0)
        close(fd);
    return fine;
}

bool run_export(struct call *call)
{
    return offer(call, pel_transfer_to_text(&call->session->scene.transfer, call->error), "transfer.json");
}

bool run_scene(struct call *call)
{
    struct pel_scene scene = call->session->scene; /* borrows its transfer function */
    const char *slash = strrchr(scene.source.path, '/');
    if (slash && session_is_upload(call->session, scene.source.path)) /* the user's file is not where the server keeps its copy */
        memmove(scene.source.path, slash + 1, strlen(slash));
    return offer(call, pel_scene_to_text(&scene, NULL, call->error), "scene.json");
}

/* ---- back and forth ---- */

bool session_scene_from_snapshot(const char *text, const struct pel_volume *volume, struct pel_scene *scene, struct pel_error *error)
{
    if (!pel_scene_init(scene, error))
        return false;
    scene->volume = volume;
    scene->light_count = 0; /* what the text leaves out is empty, not the default */
    if (pel_scene_from_text(text, strlen(text), NULL, scene, NULL, error))
        return true;
    pel_scene_finish(scene);
    return false;
}

static bool same_source(const struct pel_source *a, const struct pel_source *b)
{
    return strcmp(a->path, b->path) == 0 && strcmp(a->array, b->array) == 0 && strcmp(a->raw, b->raw) == 0;
}

struct history_step session_step(const struct session *s, struct pel_error *error)
{
    return (struct history_step) { pel_scene_to_text(&s->scene, NULL, error), s->start, s->start_fitted };
}

static bool go(struct call *call, int direction)
{
    struct session *s = call->session;
    struct pel_scene scene;
    const struct history_step now = session_step(s, call->error);
    if (!now.text)
        return false;
    const struct history_step step = direction < 0 ? history_undo(&s->history, now) : history_redo(&s->history, now);
    call->nothing = !step.text;
    if (!step.text)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, direction < 0 ? "there is nothing to undo" : "there is nothing to redo");
    bool fine = session_scene_from_snapshot(step.text, s->scene.volume, &scene, call->error);
    if (fine && !same_source(&scene.source, &s->scene.source)) {
        char path[PEL_OPTION_TEXT_SIZE], array[sizeof scene.source.array];
        memcpy(path, scene.source.path, sizeof path);
        memcpy(array, scene.source.array, sizeof array);
        pel_scene_finish(&scene);
        return session_open(s, call, path, array, &step, direction, call->error);
    }
    if (fine)
        session_drop_impossible_technique(s, &scene); /* another device may draw now */
    fine = fine && session_take_scene(s, &scene, call->error);
    if (fine) {
        session_take_start(s, &step);
        session_changed(s, false);
        s->state_dirty = true;
        free(step.text);
    } else {
        session_history_back(s, direction, step, call->error);
    }
    return fine;
}

/* The file of a snapshot, owned; NULL where none is named. */
static char *path_of(const char *text)
{
    json_t *json = json_loads(text, 0, NULL);
    const char *path = json_string_value(json_object_get(json_object_get(json, "volume"), "path"));
    char *copy = path ? strdup(path) : NULL;
    json_decref(json);
    return copy;
}

static bool is_of(const char *text, const void *path)
{
    char *own = path_of(text);
    bool same = own && strcmp(own, path) == 0;
    free(own);
    return same;
}

void session_history_keep(struct session *s, int direction, struct history_step step)
{
    free((direction < 0 ? history_redo(&s->history, step) : history_undo(&s->history, step)).text);
}

void session_history_back(struct session *s, int direction, struct history_step step, struct pel_error *error)
{
    if (error->code == PEL_ERROR_CANCELLED || error->code == PEL_ERROR_MEMORY) {
        session_history_keep(s, direction, step);
        return;
    }
    char *path = path_of(step.text);
    char why[sizeof error->message];
    bool gone = path && strcmp(path, s->scene.source.path) != 0;
    int count = 1 + history_drop(&s->history, direction, gone ? is_of : NULL, path);
    snprintf(why, sizeof why, "%.400s; %d step%s of %s %s left out", error->message, count, count == 1 ? "" : "s",
             direction < 0 ? "undo" : "redo", count == 1 ? "is" : "are");
    memcpy(error->message, why, sizeof why);
    s->state_dirty = true;
    free(path);
    free(step.text);
}

bool run_undo(struct call *call)
{
    return go(call, -1);
}

bool run_redo(struct call *call)
{
    return go(call, 1);
}
