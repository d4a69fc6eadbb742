/* SPDX-License-Identifier: MIT */
/* The thread that draws. It looks at what changed, does the one thing that matters most, and looks again:
 *   a picture of motion, small or by slices, that fits the budget, while a hand is down or full quality would take longer than that;
 *   the slices that were asked for; the picture in full quality, once things rest; further frames of it, averaged; pictures and movies to
 * be saved. What is not motion stops at its next report when a command comes. Commands never wait for a picture: each picture has a copy of
 * the scene. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "session_inside.h"

/* A change that no hand holds may be one of many: a wheel turns in steps. Full quality waits so long for the next. */
#define QUIET_MS 120.0
/* Between two pictures of a refinement that are sent. */
#define REFINED_MS 700.0
static const char fast[] = "slices2d", usual[] = "raycast";
/* Of the time for a picture of motion, what the fast technique may take to draw it; what is left is for its way to the page. */
#define DRAWING_SHARE 0.6

enum work { WORK_NONE, WORK_MOVING, WORK_SLICES, WORK_FULL, WORK_REFINE, WORK_JOB };

struct drawer {
    struct session *session;
    struct pel_renderer *renderer;
    struct encoder *encoder;
    struct slices_drawer *slices;
    struct pel_image moving, full;
    struct pel_scene scene;        /* the copy that is drawn */
    uint64_t known;                /* number of the volume that the renderer may remember; 0: none */
    struct session_volume *volume; /* of the copy; held */
    struct pace pace;
    uint64_t paced;              /* number of the volume that the pace is of; 0: none */
    enum pel_mode mode;          /* likewise */
    char technique[32];          /* likewise: the scene's */
    bool fast_refused;           /* the fast technique cannot draw this */
    double full_ms, full_pixels; /* of the last picture in full quality; 0: there was none */
    double refined_sent_ms;
    struct frame_facts rest; /* of the picture that is being refined */
    bool stoppable;
};

bool session_held(const struct session *s)
{
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++)
        if (s->clients[i].number && s->clients[i].held)
            return true;
    return false;
}

void session_interrupt(struct session *s)
{
    if (!s->quit) /* the end is not to be taken for a change */
        atomic_store(&s->abort, SESSION_CHANGED);
    pthread_cond_signal(&s->wake);
}

void session_changed(struct session *s, bool camera_only)
{
    s->camera_only = (s->shown == s->revision || s->camera_only) && camera_only;
    s->revision++;
    s->slices_revision += !camera_only; /* they may show the transfer function's colours */
    s->release = false;
    s->changed_ms = session_now();
    session_interrupt(s);
}

static bool go_on(void *user, double fraction)
{
    const struct drawer *d = user;
    (void)fraction;
    int abort = atomic_load(&d->session->abort);
    return abort != SESSION_ENDS && !(d->stoppable && abort);
}

const char *session_technique(const struct pel_scene *scene)
{
    return scene->technique.name[0] ? scene->technique.name : usual;
}

bool session_take_options(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, struct pel_error *error)
{
    const struct pel_technique_info *info = pel_technique_find(technique);
    void *options = info ? pel_renderer_options(renderer, technique) : NULL;
    if (options)
        pel_option_defaults(info->options, options);
    return strcmp(scene->technique.name, technique) != 0 || pel_renderer_take_technique(renderer, &scene->technique, error);
}

/* ---- what to draw next ---- */

static bool full_is_slow(const struct drawer *d, const struct session *s)
{
    return d->full_ms == 0 || d->full_ms * s->size[0] * s->size[1] / d->full_pixels > 0.8 * d->pace.budget_ms;
}

/* `wait_ms` gets how long to wait where there is nothing yet; 0: until something happens. */
static enum work next_work(const struct drawer *d, const struct session *s, double *wait_ms)
{
    bool held = session_held(s), wanted = !s->params.wanted || !s->greeted || s->params.wanted(s->params.user);
    *wait_ms = 0;
    if (!s->volume)
        return WORK_NONE;
    if (s->shown != s->revision && (wanted || !held) && (held || (full_is_slow(d, s) && !s->release)))
        return WORK_MOVING;
    if (!s->greeted)
        return WORK_NONE;
    if (session_slices_due(s) && wanted)
        return WORK_SLICES;
    if (held)
        return WORK_NONE;
    if (s->full != s->revision) {
        double since = session_now() - s->changed_ms;
        if (s->shown != s->revision || s->release || since >= QUIET_MS)
            return WORK_FULL;
        *wait_ms = QUIET_MS - since;
        return WORK_NONE;
    }
    if (s->refined != s->revision)
        return WORK_REFINE;
    return session_job_due(s) ? WORK_JOB : WORK_NONE;
}

/* A copy of the scene as it is now, and of whose commands are in it. With the lock held. */
static bool take_copy(struct drawer *d, struct frame_facts *f, struct pel_error *error)
{
    struct session *s = d->session;
    struct pel_transfer transfer = d->scene.transfer;
    if (d->volume != s->volume) {
        if (d->volume)
            session_volume_release(d->volume);
        d->volume = s->volume;
        d->volume->users++;
        d->full_ms = 0;
    }
    if (!pel_transfer_equal(&transfer, &s->scene.transfer) && !pel_transfer_copy(&transfer, &s->scene.transfer, error)) {
        d->scene.transfer = transfer;
        return false;
    }
    memcpy(&d->scene, &s->scene, sizeof d->scene); /* with its padding: the renderer compares bytes */
    d->scene.transfer = transfer;
    *f = (struct frame_facts) {
        .view = "main", .of = { s->size[0], s->size[1] }, .revision = s->revision, .volume = s->volume->number, .scene = &d->scene
    };
    session_note_clients(s, f, false);
    return true;
}

/* Before each draw, of the scene or of a job: what the renderer remembers is of one volume. */
static void know(struct drawer *d, uint64_t volume)
{
    if (d->known != volume)
        pel_renderer_invalidate(d->renderer);
    d->known = volume;
}

/* Another mode, technique or volume costs something else; true then. */
static bool meet(struct drawer *d)
{
    bool new = false;
    know(d, d->volume->number);
    if (d->paced != d->volume->number || d->mode != d->scene.render.mode || strcmp(d->technique, session_technique(&d->scene)) != 0) {
        pace_init(&d->pace, d->session->params.budget_ms);
        d->fast_refused = false;
        d->full_ms = 0;
        d->mode = d->scene.render.mode;
        snprintf(d->technique, sizeof d->technique, "%s", session_technique(&d->scene));
        new = true;
    }
    d->paced = d->volume->number;
    return new;
}

/* Does shear-warp stand in for the technique under a moving hand? */
static bool takes_fast(const struct drawer *d)
{
    return !d->session->device && !d->fast_refused && d->scene.render.mode == PEL_MODE_COMPOSITE &&
           d->scene.render.classification == PEL_CLASSIFICATION_POST;
}

static void tell_failure(struct drawer *d, const struct pel_error *error)
{
    struct session *s = d->session;
    pthread_mutex_lock(&s->lock);
    session_tell_error(s, 0, error, NULL);
    pthread_mutex_unlock(&s->lock);
}

/* ---- drawing ---- */

/* `budget_ms`: leave out what does not fit into it, which is the fast technique's option; 0: nothing. */
static bool draw(struct drawer *d, const char *technique, double budget_ms, struct pel_image *image, struct frame_facts *f,
                 struct pel_error *error)
{
    double start = session_now();
    char budget[32];
    snprintf(budget, sizeof budget, "%d", (int)ceil(budget_ms));
    if (!session_take_options(d->renderer, &d->scene, technique, error) ||
        (budget_ms > 0 && !pel_option_set(pel_option_find(pel_technique_find(technique)->options, "budget"),
                                          pel_renderer_options(d->renderer, technique), budget, error)) ||
        !pel_renderer_draw(d->renderer, &d->scene, technique, image, error))
        return false;
    f->draw_ms = session_now() - start;
    f->stats = pel_renderer_stats(d->renderer);
    return true;
}

static bool send(struct drawer *d, const struct pel_image *image, struct frame_facts *f, struct pel_error *error)
{
    return session_send_frame(d->session, d->encoder, image, f, &(struct pel_progress) { go_on, d }, error);
}

/* By the fast technique, which leaves slices out to keep to the budget. */
static bool draw_fast(struct drawer *d, struct frame_facts *f, struct pel_error *error)
{
    return draw(d, fast, DRAWING_SHARE * d->pace.budget_ms, &d->moving, f, error);
}

/* The fast technique where it can, else the scene's own with twice the step. */
static bool draw_quickly(struct drawer *d, struct frame_facts *f, struct pel_error *error)
{
    bool fine = takes_fast(d) && draw_fast(d, f, error);
    if (fine || error->code != PEL_ERROR_NONE) {
        if (fine || error->code != PEL_ERROR_UNSUPPORTED)
            return fine;
        d->fast_refused = true;
        *error = (struct pel_error)PEL_ERROR_INIT;
    }
    d->scene.render.step *= 2;
    return draw(d, d->technique, 0, &d->moving, f, error);
}

static bool draw_moving(struct drawer *d, struct frame_facts *f, enum pace_kind kind, bool slow, struct pel_error *error)
{
    int size[2] = { f->of[0], f->of[1] };
    double start = session_now();
    bool first = d->pace.sums[PACE_CAMERA].n == 0;
    if (slow)
        pace_choose(&d->pace, kind, f->of, size);
    d->scene.render.refine = 0;
    if (!pel_image_allocate(&d->moving, size[0], size[1], false, error) ||
        !(slow ? draw_quickly(d, f, error) : draw(d, d->technique, 0, &d->moving, f, error)))
        return false;
    f->quality = "moving";
    if (!send(d, &d->moving, f, error))
        return false;
    double ms = session_now() - start;
    if (!slow)
        return true;
    pace_measured(&d->pace, kind, size, ms);
    if (first && kind == PACE_SCENE) {
        /* What a turn will cost is known before the first one: the same picture again, with all prepared. */
        double drawn = f->draw_ms;
        if (takes_fast(d) ? draw_fast(d, f, NULL) : draw(d, d->technique, 0, &d->moving, f, NULL))
            pace_measured(&d->pace, PACE_CAMERA, size, ms - drawn + f->draw_ms);
    }
    return true;
}

static bool draw_full(struct drawer *d, struct frame_facts *f, bool *finished, struct pel_error *error)
{
    double start = session_now();
    if (!pel_image_allocate(&d->full, f->of[0], f->of[1], false, error) || !draw(d, d->technique, 0, &d->full, f, error))
        return false;
    f->final = *finished = pel_renderer_finished(d->renderer); /* at once where nothing is refined, or where this was drawn before */
    if (!f->final || d->scene.render.refine <= 1) {            /* what is remembered costs nothing, and tells nothing */
        d->full_ms = session_now() - start;
        d->full_pixels = (double)f->of[0] * f->of[1];
    }
    f->quality = f->final && d->scene.render.refine > 0 ? "refined" : "full";
    d->rest = *f;
    d->refined_sent_ms = session_now();
    return send(d, &d->full, f, error);
}

/* One more frame into the mean of the picture at rest. That it is finished is never noted without the final picture sent. */
static bool refine(struct drawer *d, struct frame_facts *f, bool *finished, struct pel_error *error)
{
    if (!draw(d, d->technique, 0, &d->full, f, error))
        return false;
    *finished = pel_renderer_finished(d->renderer);
    if (*finished || session_now() - d->refined_sent_ms > REFINED_MS) {
        f->quality = "refined";
        f->final = *finished;
        if (!send(d, &d->full, f, error))
            return false;
        d->refined_sent_ms = session_now();
    }
    return true;
}

/* Where a GPU refuses what the ray caster draws, also one that was asked for by name, the CPU draws from then on, and the event `devices`
 * tells so. What another technique cannot draw is no reason to leave the GPU. */
static bool leave_device(struct drawer *d, const struct pel_error *error)
{
    struct session *s = d->session;
    struct pel_renderer_params params = { .threads = s->params.threads, .progress = { go_on, d } };
    struct pel_error told;
    if (!s->device || error->code != PEL_ERROR_UNSUPPORTED || (strcmp(d->technique, usual) != 0 && strcmp(d->technique, "auto") != 0))
        return false;
    session_fail(&told, error->code, "%.460s; the CPU draws from now on", error->message);
    pel_renderer_destroy(d->renderer);
    pthread_mutex_lock(&s->lock);
    session_tell_error(s, 0, &told, NULL);
    pel_device_destroy(s->device);
    s->device = NULL;
    session_tell_devices(s);
    pthread_mutex_unlock(&s->lock);
    d->renderer = pel_renderer_create(&params, NULL);
    d->known = d->paced = 0;
    return d->renderer != NULL;
}

static struct pel_renderer_params renderer_params(struct drawer *d)
{
    return (struct pel_renderer_params) { d->session->params.threads, { go_on, d }, d->session->device };
}

static bool make_renderer(struct drawer *d, struct pel_error *error)
{
    const struct pel_renderer_params params = renderer_params(d);
    if (!d->renderer)
        d->renderer = pel_renderer_create(&params, error);
    return d->renderer != NULL;
}

/* Does it, without the lock; what came of it is noted with it. */
static void work(struct drawer *d, enum work what, struct frame_facts *f, enum pace_kind kind, bool slow)
{
    struct session *s = d->session;
    struct pel_error error = PEL_ERROR_INIT;
    bool finished = false;
    slow |= meet(d);
    bool fine = what == WORK_MOVING ? draw_moving(d, f, kind, slow, &error)
                : what == WORK_FULL ? draw_full(d, f, &finished, &error)
                                    : refine(d, f, &finished, &error);
    bool stopped = !fine && error.code == PEL_ERROR_CANCELLED, again = false;
    if (!fine && !stopped && !(again = leave_device(d, &error)))
        tell_failure(d, &error);
    pthread_mutex_lock(&s->lock);
    if (stopped || again)
        return;
    s->shown = f->revision;
    if (what != WORK_MOVING)
        s->full = f->revision;
    if (finished || (!fine && what != WORK_MOVING))
        s->refined = f->revision;
}

static void wait_for_work(struct session *s, double wait_ms)
{
    struct timespec until;
    if (wait_ms <= 0) {
        pthread_cond_wait(&s->wake, &s->lock);
        return;
    }
    clock_gettime(CLOCK_MONOTONIC, &until);
    long ns = until.tv_nsec + (long)(wait_ms * 1e6);
    until.tv_sec += ns / 1000000000;
    until.tv_nsec = ns % 1000000000;
    pthread_cond_timedwait(&s->wake, &s->lock, &until);
}

/* What was to be done cannot even be begun: it is not tried again until something changes. */
static void give_up(struct drawer *d, enum work what, const struct pel_error *error)
{
    struct session *s = d->session;
    if (what == WORK_JOB) {
        session_job_fail(s, error);
        return;
    }
    session_tell_error(s, 0, error, NULL);
    if (what == WORK_SLICES) {
        s->slices_shown = s->slices_revision;
        s->slices_moving = false;
    } else {
        s->shown = s->full = s->refined = s->revision;
    }
}

/* The scene, or the state of a refinement or job, that is to be drawn, and what draws it. */
static bool get_ready(struct drawer *d, enum work what, struct frame_facts *f, struct pel_error *error)
{
    if (what == WORK_REFINE) {
        *f = d->rest;
        session_note_clients(d->session, f, false);
    } else if (what != WORK_JOB && !take_copy(d, f, error)) {
        return false;
    }
    return make_renderer(d, error);
}

static void draw_slices(struct drawer *d, struct frame_facts *f)
{
    struct session *s = d->session;
    const struct session_slices asked = s->slices;
    const uint64_t revision = s->slices_revision;
    s->slices_moving = session_held(s);
    f->quality = s->slices_moving ? "moving" : "full";
    f->final = !s->slices_moving;
    session_note_clients(s, f, true);
    pthread_mutex_unlock(&s->lock);
    session_slices_draw(s, &d->slices, d->encoder, &asked, f);
    pthread_mutex_lock(&s->lock);
    s->slices_shown = revision;
}

static void draw_job(struct drawer *d)
{
    struct session *s = d->session;
    uint64_t volume = session_job_volume(s);
    pthread_mutex_unlock(&s->lock);
    know(d, volume);
    session_job_step(s, d->renderer);
    pthread_mutex_lock(&s->lock);
}

/* One thing; with the lock held, which is given up meanwhile. */
static void do_next(struct drawer *d, enum work what)
{
    struct session *s = d->session;
    struct frame_facts f;
    struct pel_error error = PEL_ERROR_INIT;
    atomic_store(&s->abort, s->quit ? SESSION_ENDS : 0);
    if (!get_ready(d, what, &f, &error)) {
        give_up(d, what, &error);
        return;
    }
    bool slow = full_is_slow(d, s);
    enum pace_kind kind = s->camera_only ? PACE_CAMERA : PACE_SCENE;
    /* What is full and fast enough to be the answer to a change is not stopped by the next change, or none would ever be shown. */
    d->stoppable = what != WORK_MOVING && (what != WORK_FULL || slow || s->shown == s->revision);
    if (what == WORK_SLICES) {
        draw_slices(d, &f);
    } else if (what == WORK_JOB) {
        draw_job(d);
    } else {
        pthread_mutex_unlock(&s->lock);
        work(d, what, &f, kind, slow);
    }
}

void *session_draw(void *user)
{
    struct session *s = user;
    struct drawer d = { .session = s };
    struct pel_error error = PEL_ERROR_INIT;
    pel_image_init(&d.moving);
    pel_image_init(&d.full);
    pace_init(&d.pace, s->params.budget_ms);
    bool fine = (d.encoder = encoder_create(&error)) && pel_scene_init(&d.scene, &error);
    pthread_mutex_lock(&s->lock);
    while (fine && !s->quit) {
        double wait_ms;
        if (s->state_dirty && s->volume) {
            s->state_dirty = false;
            session_tell_state(s, 0);
            pthread_cond_broadcast(&s->settled);
        }
        if (s->wish.there && session_device_change(s, &d.renderer, renderer_params(&d)))
            d.known = d.paced = 0;
        enum work what = next_work(&d, s, &wait_ms);
        if (what == WORK_NONE)
            wait_for_work(s, wait_ms);
        else
            do_next(&d, what);
        pthread_cond_broadcast(&s->settled);
    }
    if (!fine)
        session_tell_error(s, 0, &error, NULL);
    if (d.volume)
        session_volume_release(d.volume);
    s->quit = true;
    pthread_cond_broadcast(&s->settled);
    pthread_mutex_unlock(&s->lock);
    session_slices_finish(d.slices);
    pel_renderer_destroy(d.renderer);
    pel_scene_finish(&d.scene);
    pel_image_finish(&d.moving);
    pel_image_finish(&d.full);
    encoder_destroy(d.encoder);
    return NULL;
}
