/* SPDX-License-Identifier: MIT */
/* Files are read by a thread of their own, so that what is open can be turned meanwhile. The scene and volume that it made take the place
 * of the old ones in one step; the histogram is counted after that, for the picture does not wait for it. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "record.h"
#include "session_inside.h"

struct session_opening {
    struct session *session;
    char *path, *array; /* owned; path NULL: params.open */
    struct history_step step;
    int direction, client; /* client: who asked; 0: nobody */
    bool has_id;
    int64_t id;
    uint64_t recorded; /* the recording's entry of the command */
    atomic_bool cancel;
    double told_ms;
};

static void opening_free(struct session_opening *o)
{
    free(o->path);
    free(o->array);
    free(o->step.text);
    free(o);
}

void session_volume_release(struct session_volume *volume)
{
    if (--volume->users > 0)
        return;
    pel_volume_finish(&volume->volume);
    json_decref(volume->histogram);
    free(volume);
}

static bool report(void *user, double fraction)
{
    struct session_opening *o = user;
    double now = session_now();
    if (now - o->told_ms > 100) {
        o->told_ms = now;
        pthread_mutex_lock(&o->session->lock);
        session_tell_progress(o->session, 0, "open", fraction);
        pthread_mutex_unlock(&o->session->lock);
    }
    return !atomic_load(&o->cancel);
}

/* ---- reading ---- */

static bool has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && strcmp(path + length - tail, ending) == 0;
}

struct reading {
    struct session *session;
    const char *header;
};

/* A pipe or a device might keep the thread for ever. */
static bool is_plain(const char *path, struct pel_error *error)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return session_fail(error, PEL_ERROR_IO, "%.300s: %s", path, strerror(errno));
    return S_ISREG(st.st_mode) || S_ISDIR(st.st_mode) ||
           session_fail(error, PEL_ERROR_ARGUMENT, "%.300s: it is neither a file nor a folder", path);
}

static bool may_read(void *user, const char *path)
{
    const struct reading *reading = user;
    return session_may_read(reading->session, reading->header, path) && is_plain(path, NULL);
}

static bool may_open(const struct session_opening *o, const char *path, struct pel_error *error)
{
    if (!session_may_open(o->session, path))
        return session_fail(error, PEL_ERROR_ARGUMENT, "%.300s: it is not below the folders that may be opened", path);
    return is_plain(path, error);
}

/* What a snapshot names was open before; and a file named on the command line is read as the first one is, with whatever it names. */
static bool is_trusted(const struct session_opening *o, const char *path)
{
    return o->step.text || session_is_named(o->session, path);
}

static bool read_samples(const struct session_opening *o, struct session_opened *out, const struct pel_progress *progress,
                         struct pel_error *error)
{
    const struct pel_source *source = &out->scene.source;
    bool trusted = is_trusted(o, source->path) || is_trusted(o, o->path);
    struct reading reading = { o->session, source->path };
    struct pel_read_params params = { source->array[0] ? source->array : NULL, source->raw[0] ? source->raw : NULL, *progress,
                                      trusted ? NULL : may_read, &reading };
    struct pel_volume magnitude;
    if (!pel_read_volume(source->path, &params, &out->volume, &out->info, error))
        return false;
    if (out->volume.components > 1) {
        pel_volume_init(&magnitude);
        bool fine = pel_volume_magnitude(&out->volume, &magnitude, error);
        pel_volume_finish(&out->volume);
        if (!fine)
            return false;
        out->volume = magnitude;
    }
    pel_source_apply(source, &out->volume);
    return true;
}

static bool find_source(const struct session_opening *o, struct session_opened *out, struct pel_scene_parts *has, struct pel_error *error)
{
    struct pel_scene *scene = &out->scene;
    bool scene_file = o->path && has_ending(o->path, ".json");
    if (o->step.text || !o->path) {
        *has = (struct pel_scene_parts) { true, true, true, true, true, true, true };
        return true;
    }
    bool trusted = is_trusted(o, o->path);
    scene->render.refine = SESSION_REFINE;
    if (!trusted && !may_open(o, o->path, error)) /* before anything of it is read */
        return false;
    if (scene_file && !pel_read_scene(o->path, scene, has, error))
        return false;
    if (!scene_file)
        snprintf(scene->source.path, sizeof scene->source.path, "%s", o->path);
    if (o->array)
        snprintf(scene->source.array, sizeof scene->source.array, "%s", o->array);
    return trusted || !scene_file || may_open(o, scene->source.path, error);
}

/* A volume file with all that makes a scene chosen, or a scene file and its volume, or the scene of a snapshot. */
static bool open_path(const struct session_opening *o, struct session_opened *out, const struct pel_progress *progress,
                      struct pel_error *error)
{
    struct pel_scene_parts has = { 0 };
    pel_volume_init(&out->volume);
    if (o->step.text ? !session_scene_from_snapshot(o->step.text, NULL, &out->scene, error) : !pel_scene_init(&out->scene, error))
        return false;
    struct pel_scene *scene = &out->scene;
    if (!find_source(o, out, &has, error) || !read_samples(o, out, progress, error))
        goto failed;
    scene->volume = &out->volume;
    const struct pel_scene_parts missing = {
        .colors = !has.colors,
        .opacities = !has.opacities,
        .unit_distance = !has.unit_distance,
        .camera = !has.camera,
        .isosurfaces = !has.isosurfaces && scene->render.mode == PEL_MODE_ISOSURFACE,
        .slice = !has.slice,
    };
    out->fit_camera = missing.camera;
    if (pel_scene_choose(scene, &missing, 1, 1, error) && pel_scene_check(scene, error))
        return true;
failed:
    pel_scene_finish(scene);
    pel_volume_finish(&out->volume);
    return false;
}

bool session_open_snapshot(const char *text, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    struct session_opening o = { .step.text = (char *)text };
    return open_path(&o, opened, progress, error);
}

/* ---- taking over ---- */

void session_take_start(struct session *s, const struct history_step *step)
{
    s->start = step->start;
    s->start_fitted = step->fitted;
    session_fit_again(s);
}

static void adopt(struct session_opening *o, struct session_opened *opened, struct session_volume *volume, struct history_step before)
{
    struct session *s = o->session;
    struct pel_scene *scene = &opened->scene;
    if (opened->device)
        s->device = opened->device;
    volume->users = 1;
    volume->number = ++s->volumes;
    volume->volume = opened->volume;
    volume->info = opened->info;
    scene->volume = &volume->volume;
    session_drop_impossible_technique(s, scene);
    if (before.text)
        history_push(&s->history, 0, 0, before);
    if (s->volume)
        session_volume_release(s->volume);
    pel_scene_finish(&s->scene);
    s->volume = volume;
    s->scene = *scene;
    s->start_fitted = opened->fit_camera;
    if (s->start_fitted)
        session_fit_camera(s, &s->scene.camera);
    s->start = s->scene.camera;
    if (o->direction)
        session_take_start(s, &o->step);
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++)
        s->clients[i].slices = false;
    session_slices_leave(s);
    session_changed(s, false);
    session_tell_volume(s, 0);
    s->state_dirty = true;
}

static json_t *count(const struct pel_volume *volume)
{
    enum { BINS = 512 };
    struct pel_histogram h;
    double lo = volume->range[0], hi = volume->range[1];
    size_t bins = BINS;
    if (!(lo <= hi))
        return NULL;
    if (volume->type != PEL_F32 && volume->type != PEL_F64 && hi - lo < BINS) {
        bins = (size_t)(hi - lo) + 1; /* a bin a value */
        lo -= 0.5;
        hi += 0.5;
    } else if (lo == hi) {
        hi = lo + 1;
    }
    if (!pel_histogram_init(&h, volume, lo, hi, bins, false, NULL))
        return NULL;
    json_t *counts = json_array();
    for (size_t i = 0; i < h.count; i++)
        json_array_append_new(counts, json_integer((json_int_t)h.bins[i]));
    pel_histogram_finish(&h);
    return json_pack("{s:f, s:f, s:o}", "lo", lo, "hi", hi, "counts", counts);
}

static void count_histogram(struct session *s, struct session_volume *volume)
{
    json_t *histogram = count(&volume->volume);
    pthread_mutex_lock(&s->lock);
    volume->histogram = histogram;
    if (s->volume == volume && histogram)
        session_tell_volume(s, 0);
    session_volume_release(volume);
    pthread_mutex_unlock(&s->lock);
}

static void failed(struct session_opening *o, struct pel_error *error)
{
    struct session *s = o->session;
    const char *name = o->direction < 0 ? "undo" : o->direction > 0 ? "redo" : "open";
    const struct call call = { .name = name, .has_id = o->has_id, .id = o->id };
    session_tell_progress(s, 0, "open", 1);
    if (o->direction) {
        session_history_back(s, o->direction, o->step, error);
        o->step.text = NULL;
    }
    session_tell_error(s, o->client, error, &call);
    s->failed |= !o->path;
}

/* The scene may be saved and opened elsewhere. */
static void resolve(struct pel_source *source)
{
    char *real = realpath(source->path, NULL);
    if (real && strlen(real) < sizeof source->path && session_is_text(real))
        strcpy(source->path, real);
    free(real);
}

static void *run(void *user)
{
    struct session_opening *o = user;
    struct session *s = o->session;
    struct session_opened opened = { .fit_camera = false };
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_progress progress = { report, o };
    struct session_volume *volume = calloc(1, sizeof *volume);
    bool fine = volume ? o->path || o->step.text ? open_path(o, &opened, &progress, &error)
                                                 : s->params.open(s->params.open_user, &opened, &progress, &error)
                       : session_fail(&error, PEL_ERROR_MEMORY, "no memory for a volume");
    if (fine && !session_is_text(opened.scene.source.path)) { /* no scene, no step of undo could tell of it */
        session_fail(&error, PEL_ERROR_ARGUMENT, "%.300s: " SESSION_NO_TEXT, opened.scene.source.path);
        pel_scene_finish(&opened.scene);
        pel_volume_finish(&opened.volume);
        pel_device_destroy(opened.device);
        fine = false;
    }
    if (fine)
        resolve(&opened.scene.source); /* without the lock: a disk may be slow */
    pthread_mutex_lock(&s->lock);
    if (fine) {
        const struct history_step none = { .text = NULL };
        adopt(o, &opened, volume, s->volume && !o->direction ? session_step(s, NULL) : none);
        if (s->params.record && !o->path)
            record_scene(s->params.record, &s->scene, s->start_fitted);
        session_tell_progress(s, 0, "open", 1);
        volume->users++; /* until its histogram is counted */
    } else {
        free(volume);
        failed(o, &error);
    }
    if (s->params.record && o->client && (fine || error.code == PEL_ERROR_CANCELLED))
        record_opened(s->params.record, session_now() - s->started_ms, o->recorded, fine);
    s->opening = NULL;
    pthread_cond_broadcast(&s->settled);
    pthread_cond_signal(&s->wake);
    pthread_mutex_unlock(&s->lock);
    opening_free(o);
    if (fine) {
        count_histogram(s, volume);
        session_devices_list(s); /* not where there is nothing to draw: the viewer may be ending */
    }
    pthread_mutex_lock(&s->lock);
    session_thread_ends(s);
    pthread_mutex_unlock(&s->lock);
    return NULL;
}

bool session_open(struct session *s, const struct call *asker, const char *path, const char *array, const struct history_step *step,
                  int direction, struct pel_error *error)
{
    struct session_opening *o = calloc(1, sizeof *o);
    bool fine = o && (!path || (o->path = strdup(path))) && (!array || !array[0] || (o->array = strdup(array)));
    if (!fine) {
        if (o)
            opening_free(o);
        session_fail(error, PEL_ERROR_MEMORY, "no memory to open a file");
        if (direction)
            session_history_keep(s, direction, *step);
        return false;
    }
    o->session = s;
    if (asker) {
        o->client = asker->client->number;
        o->has_id = asker->has_id;
        o->id = asker->id;
        o->recorded = s->recorded - 1;
    }
    if (step)
        o->step = *step;
    o->direction = direction;
    if (session_thread(s, run, o, error)) {
        s->opening = o; /* the thread waits for the lock before it takes this back */
        return true;
    }
    if (direction) {
        session_history_keep(s, direction, o->step);
        o->step.text = NULL;
    }
    opening_free(o);
    return false;
}

void session_open_cancel(struct session *s)
{
    if (s->opening)
        atomic_store(&s->opening->cancel, true);
}

bool session_open_steps(const struct session *s)
{
    return s->opening && s->opening->direction != 0;
}
