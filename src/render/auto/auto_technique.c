/* SPDX-License-Identifier: MIT */
/* Which technique draws a scene fastest on this device is measured: each candidate draws some of a scene's first frames, and the fastest
 * all further ones. No frame is drawn twice, so that measuring costs no more than what the slower technique is slower. A still, which has
 * no further frames, is drawn by the first candidate, the ray caster; so is everything that the others cannot draw or refuse.
 *
 * Candidates keep to the ray caster's picture: peeling differs from it only where it finds surfaces that steps step over. The mesh, whose
 * surface is within a tolerance, is none. Those that lost give back what they hold. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "alloc.h"
#include "fail.h"
#include "technique.h"
#include "timer.h"

enum { RAYCAST, PEEL, CANDIDATES };
enum { FRAMES = 3 }; /* of a candidate: the first prepares more than later ones and does not count, of the others the fastest does */

extern const struct pel_technique pel_technique_raycast, pel_technique_peel;
static const struct pel_technique *const candidates[CANDIDATES] = { [RAYCAST] = &pel_technique_raycast, [PEEL] = &pel_technique_peel };
static const struct pel_option no_options[] = { { NULL } };

/* A technique that may be taken. */
struct candidate {
    void *state;
    void *options;    /* its own, as its rows set them; NULL where it has none */
    unsigned changes; /* since it drew */
    int frames;       /* drawn in the trial */
    double best_ms;   /* of those that count */
};

struct choice {
    struct candidate candidates[CANDIDATES];
    int taken;        /* for the frame */
    unsigned changes; /* that it was told of */
    double start_ms;
    /* The trial belongs to a volume and these. */
    int surfaces, size_class;
    bool skip;
    enum pel_roots roots;
    bool decided;
    int winner;
    char refusal[160]; /* why peeling is out of it; empty: it is not */
    char reason[256];
};

static void drop(struct choice *c, int i)
{
    candidates[i]->finish(c->candidates[i].state);
    c->candidates[i].state = NULL;
    c->candidates[i].changes = PEL_CHANGE_ALL;
}

static void finish(void *state)
{
    struct choice *c = state;
    if (!c)
        return;
    for (int i = 0; i < CANDIDATES; i++) {
        drop(c, i);
        free(c->candidates[i].options);
    }
    free(c);
}

static struct choice *create(struct pel_error *error)
{
    struct choice *c = pel_alloc(1, sizeof *c, "choice of a technique", error);
    for (int i = 0; c && i < CANDIDATES; i++) {
        const struct pel_technique_info *info = &candidates[i]->info;
        c->candidates[i].changes = PEL_CHANGE_ALL;
        if (!info->options_size)
            continue;
        if (!(c->candidates[i].options = pel_alloc(1, info->options_size, "options", error))) {
            finish(c);
            return NULL;
        }
        pel_option_defaults(info->options, c->candidates[i].options);
    }
    return c;
}

/* Pictures between a power of four pixels and the next cost alike enough. */
static int size_class(const struct pel_image *image)
{
    return (int)floor(log2((double)image->width * image->height) / 2);
}

/* Does what was measured still count? Else all candidates are measured anew. */
static void keep_or_restart(struct choice *c, const struct pel_frame *frame)
{
    const struct pel_scene *scene = frame->scene;
    int size = size_class(frame->image);
    if (!(frame->changes & PEL_CHANGE_VOLUME) && c->surfaces == scene->isosurface_count && c->size_class == size &&
        c->skip == scene->render.skip && c->roots == scene->render.roots)
        return;
    c->surfaces = scene->isosurface_count;
    c->size_class = size;
    c->skip = scene->render.skip;
    c->roots = scene->render.roots;
    c->decided = false;
    c->refusal[0] = 0;
    if (frame->changes & PEL_CHANGE_VOLUME)
        drop(c, PEEL); /* its turn comes later */
    for (int i = 0; i < CANDIDATES; i++) {
        c->candidates[i].frames = 0;
        c->candidates[i].best_ms = INFINITY;
    }
}

static void decide(struct choice *c, int winner)
{
    c->decided = true;
    c->winner = winner;
    for (int i = 0; i < CANDIDATES; i++)
        if (i != winner)
            drop(c, i);
}

/* Peeling cannot draw this: the ray caster does, which draws everything. */
static void refuse(struct choice *c, const char *why)
{
    snprintf(c->refusal, sizeof c->refusal, "%.*s", (int)sizeof c->refusal - 1, why);
    decide(c, RAYCAST);
}

/* Is it a further frame of a view at rest? Those that are averaged come from one technique, and have a step of their own. */
static bool refining(const struct pel_frame *frame)
{
    return frame->scene->render.refine > 0 && frame->jitter > 0 && !(frame->changes & ~(unsigned)PEL_CHANGE_STEP);
}

static bool measurable(const struct pel_frame *frame)
{
    return frame->device && frame->scene->render.mode == PEL_MODE_ISOSURFACE;
}

/* The technique for the frame. */
static int choose(struct choice *c, const struct pel_frame *frame)
{
    const struct candidate *ray = &c->candidates[RAYCAST], *peel = &c->candidates[PEEL];
    keep_or_restart(c, frame);
    if (!measurable(frame))
        return RAYCAST;
    if (refining(frame))
        return c->taken;
    if (!c->decided && peel->frames == FRAMES)
        decide(c, peel->best_ms < ray->best_ms ? PEEL : RAYCAST);
    if (c->decided)
        return c->winner;
    return ray->frames < FRAMES ? RAYCAST : PEEL;
}

static void explain(struct choice *c, const struct pel_frame *frame)
{
    const struct candidate *ray = &c->candidates[RAYCAST], *peel = &c->candidates[PEEL];
    const size_t size = sizeof c->reason;
    if (!frame->device)
        snprintf(c->reason, size, "on the CPU it is always raycast");
    else if (!measurable(frame))
        snprintf(c->reason, size, "in modes other than isosurface it is always raycast");
    else if (c->refusal[0])
        snprintf(c->reason, size, "the other refused: %s", c->refusal);
    else if (c->decided)
        snprintf(c->reason, size, "a frame took %.3g ms by raycast, %.3g ms by peel", ray->best_ms, peel->best_ms);
    else
        snprintf(c->reason, size, "measuring both, %d of %d frames before this one", ray->frames + peel->frames, CANDIDATES * FRAMES);
}

/* The frame as the technique that is taken knows it. */
static struct pel_frame frame_of(const struct choice *c, const struct pel_frame *frame)
{
    struct pel_frame own = *frame;
    own.options = c->candidates[c->taken].options;
    own.changes = c->changes;
    return own;
}

static bool prepare_taken(struct choice *c, const struct pel_frame *frame, struct pel_error *error)
{
    struct candidate *own = &c->candidates[c->taken];
    c->changes = own->changes;
    struct pel_frame asked = frame_of(c, frame);
    bool ok = candidates[c->taken]->prepare(&own->state, &asked, error);
    own->changes = ok ? 0 : PEL_CHANGE_ALL;
    explain(c, frame);
    frame->stats->technique = candidates[c->taken]->info.name;
    frame->stats->reason = c->reason;
    return ok;
}

/* After a failure: whether the ray caster may do what peeling could not. */
static bool give_way(struct choice *c, const struct pel_frame *frame, const struct pel_error *why)
{
    if (c->taken != PEEL || why->code == PEL_ERROR_CANCELLED)
        return false;
    refuse(c, why->message);
    c->taken = RAYCAST;
    frame->stats->stage_count = frame->stats->counter_count = 0;
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_error why = PEL_ERROR_INIT;
    struct choice *c = *state;
    if (!c && !(c = *state = create(error)))
        return false;
    for (int i = 0; i < CANDIDATES; i++)
        c->candidates[i].changes |= frame->changes;
    c->taken = choose(c, frame);
    c->start_ms = pel_now_ms();
    if (prepare_taken(c, frame, &why) || (give_way(c, frame, &why) && prepare_taken(c, frame, &why)))
        return true;
    return pel_fail(error, why.code, "%s", why.message);
}

/* Notes what a frame of the trial took: all of it, up to the picture in memory. */
static void note(struct choice *c, const struct pel_frame *frame)
{
    struct candidate *own = &c->candidates[c->taken];
    if (c->decided || !measurable(frame) || refining(frame) || own->frames == FRAMES)
        return;
    if (own->frames++ > 0)
        own->best_ms = fmin(own->best_ms, pel_now_ms() - c->start_ms);
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    struct choice *c = state;
    struct pel_error why = PEL_ERROR_INIT;
    struct pel_frame own = frame_of(c, frame);
    bool ok = candidates[c->taken]->draw(c->candidates[c->taken].state, &own, &why);
    if (!ok && give_way(c, frame, &why)) {
        why = (struct pel_error)PEL_ERROR_INIT;
        ok = prepare_taken(c, frame, &why);
        own = frame_of(c, frame);
        ok = ok && candidates[c->taken]->draw(c->candidates[c->taken].state, &own, &why);
    }
    if (!ok)
        return pel_fail(error, why.code, "%s", why.message);
    note(c, frame);
    return true;
}

static bool sample_limit(void *state, double *samples_per_second, struct pel_error *error)
{
    struct choice *c = state;
    const struct pel_technique *taken = candidates[c->taken];
    return taken->sample_limit ? taken->sample_limit(c->candidates[c->taken].state, samples_per_second, error)
                               : pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s does not measure it", taken->info.name);
}

extern const struct pel_technique pel_technique_auto;
const struct pel_technique pel_technique_auto = {
    .info = {
        .name = "auto",
        .summary = "Whichever of raycast and peel draws isosurfaces faster on the GPU, as measured at the first frames; else raycast",
        .engines = PEL_ENGINE_CPU | PEL_ENGINE_GPU,
        .options = no_options,
    },
    .prepare = prepare,
    .draw = draw,
    .sample_limit = sample_limit,
    .finish = finish,
};
