/* SPDX-License-Identifier: MIT */
/* The way of a frame: check the scene, find out what changed since the technique last drew, let it prepare that, let it draw. The renderer
 * knows no technique by name. */
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "device_gl.h"
#include "fail.h"
#include "parallel.h"
#include "refine.h"
#include "technique.h"
#include "timer.h"

#define MAX_TECHNIQUES 32
#define SETTINGS ((unsigned)PEL_CHANGE_SETTINGS | PEL_CHANGE_STEP)

/* What a technique has seen: a copy of the scene (whose volume pointer is only compared) and the picture's size. */
struct seen {
    bool any;
    struct pel_scene scene; /* its transfer function is a copy of our own; `source` is left out */
    struct pel_render_settings drawn; /* with which the technique drew it: refined frames have a step of their own */
    struct pel_volume volume;
    int width, height;
    void *options; /* owned copy */
};

struct pel_renderer {
    struct pel_renderer_params params;
    int threads;
    void *states[MAX_TECHNIQUES];
    void *options[MAX_TECHNIQUES]; /* owned; NULL where a technique has none */
    struct seen *seen[MAX_TECHNIQUES];
    struct pel_refinement refinement; /* of the view that was drawn last */
    bool finished;
    size_t last; /* technique that drew */
    struct pel_frame_stats stats;
};

static void free_options(struct pel_renderer *r)
{
    for (size_t i = 0; pel_techniques[i]; i++)
        free(r->options[i]);
}

struct pel_renderer *pel_renderer_create(const struct pel_renderer_params *params, struct pel_error *error)
{
    struct pel_renderer *r = pel_alloc(1, sizeof *r, "renderer", error);
    if (!r)
        return NULL;
    r->params = params ? *params : (struct pel_renderer_params)PEL_RENDERER_PARAMS_INIT;
    r->threads = pel_threads(r->params.threads);
    for (size_t i = 0; pel_techniques[i]; i++) {
        const struct pel_technique_info *info = &pel_techniques[i]->info;
        if (!info->options_size)
            continue;
        r->options[i] = pel_alloc(1, info->options_size, "options", error);
        if (!r->options[i]) {
            free_options(r);
            free(r);
            return NULL;
        }
        pel_option_defaults(info->options, r->options[i]);
    }
    return r;
}

void *pel_renderer_options(struct pel_renderer *r, const char *technique)
{
    for (size_t i = 0; pel_techniques[i]; i++)
        if (!strcmp(pel_techniques[i]->info.name, technique))
            return r->options[i];
    return NULL;
}

static void forget(struct pel_renderer *r, size_t i)
{
    if (r->seen[i])
        pel_transfer_finish(&r->seen[i]->scene.transfer);
    if (r->seen[i])
        free(r->seen[i]->options);
    free(r->seen[i]);
    r->seen[i] = NULL;
}

static struct pel_device *device_for(const struct pel_renderer *r, const struct pel_technique *technique)
{
    return technique->info.engines & PEL_ENGINE_GPU ? r->params.device : NULL;
}

/* Makes the device current for techniques, if there is one; a host's context is given back as it was. */
static bool enter_device(struct pel_device *device, struct pel_gl_saved *saved, struct pel_error *error)
{
    if (!device)
        return true;
    if (!pel_device_begin(device, error))
        return false;
    if (!device->own)
        pel_gl_save(saved);
    return true;
}

static void leave_device(struct pel_device *device, const struct pel_gl_saved *saved)
{
    if (!device)
        return;
    if (!device->own)
        pel_gl_restore(saved);
    pel_device_end(device);
}

void pel_renderer_destroy(struct pel_renderer *r)
{
    if (!r)
        return;
    struct pel_gl_saved saved;
    bool entered = enter_device(r->params.device, &saved, NULL);
    for (size_t i = 0; pel_techniques[i]; i++) {
        pel_techniques[i]->finish(r->states[i]); /* where the context is gone, what it held is, too; the rest is memory */
        forget(r, i);
    }
    if (entered)
        leave_device(r->params.device, &saved);
    pel_refine_finish(&r->refinement);
    free_options(r);
    free(r);
}

void pel_renderer_invalidate(struct pel_renderer *r)
{
    for (size_t i = 0; pel_techniques[i]; i++)
        forget(r, i);
}

bool pel_renderer_finished(const struct pel_renderer *r)
{
    return r->finished;
}

bool pel_renderer_sample_limit(struct pel_renderer *r, double *samples_per_second, struct pel_error *error)
{
    const struct pel_technique *t = pel_techniques[r->last];
    struct pel_device *device = device_for(r, t);
    struct pel_gl_saved saved;
    if (!device || !r->seen[r->last] || !t->sample_limit)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "nothing was drawn on a GPU");
    if (!enter_device(device, &saved, error))
        return false;
    bool ok = t->sample_limit(r->states[r->last], samples_per_second, error);
    leave_device(device, &saved);
    return ok;
}

const struct pel_frame_stats *pel_renderer_stats(const struct pel_renderer *r)
{
    return &r->stats;
}

static bool same_volume(const struct pel_volume *a, const struct pel_volume *b)
{
    return a->data == b->data && a->type == b->type && a->components == b->components && a->has_void == b->has_void &&
           a->labels == b->labels && !memcmp(a->dims, b->dims, sizeof a->dims) && !memcmp(a->origin, b->origin, sizeof a->origin) &&
           !memcmp(a->direction, b->direction, sizeof a->direction) && !memcmp(a->spacing, b->spacing, sizeof a->spacing) &&
           !memcmp(&a->void_value, &b->void_value, sizeof a->void_value) && !memcmp(a->range, b->range, sizeof a->range);
}

/* Jitter is told with each frame, and refining is the renderer's own. */
static unsigned settings_changed(const struct pel_render_settings *then, const struct pel_render_settings *now)
{
    struct pel_render_settings rest;
    memcpy(&rest, then, sizeof rest); /* with its padding */
    rest.step = now->step;
    rest.jitter = now->jitter;
    rest.refine = now->refine;
    return (then->step != now->step ? PEL_CHANGE_STEP : 0) | (memcmp(&rest, now, sizeof rest) ? PEL_CHANGE_SETTINGS : 0);
}

/* Plain structs are compared as bytes: padding that differs only means that something is prepared once more. */
static unsigned changes_since(const struct seen *seen, const struct pel_scene *now, const struct pel_image *image, const void *options,
                              size_t options_size)
{
    if (!seen)
        return PEL_CHANGE_ALL;
    const struct pel_scene *then = &seen->scene;
    unsigned changes = 0;
    if (then->volume != now->volume || !same_volume(&seen->volume, now->volume))
        changes |= PEL_CHANGE_VOLUME;
    if (!pel_transfer_equal(&then->transfer, &now->transfer) || then->linear_light != now->linear_light)
        changes |= PEL_CHANGE_TRANSFER;
    if (then->isosurface_count != now->isosurface_count || memcmp(then->isosurfaces, now->isosurfaces, sizeof now->isosurfaces))
        changes |= PEL_CHANGE_ISOSURFACES;
    changes |= settings_changed(&then->render, &now->render);
    if (memcmp(&then->camera, &now->camera, sizeof now->camera))
        changes |= PEL_CHANGE_CAMERA;
    if (seen->width != image->width || seen->height != image->height)
        changes |= PEL_CHANGE_SIZE;
    if (then->clip_plane_count != now->clip_plane_count || memcmp(then->clip_planes, now->clip_planes, sizeof now->clip_planes) ||
        then->clip_box_enabled != now->clip_box_enabled || memcmp(then->clip_box, now->clip_box, sizeof now->clip_box) ||
        memcmp(&then->slice, &now->slice, sizeof now->slice) || then->more_slice_count != now->more_slice_count ||
        memcmp(then->more_slices, now->more_slices, sizeof now->more_slices))
        changes |= PEL_CHANGE_CLIPPING;
    if (then->light_count != now->light_count || memcmp(then->lights, now->lights, sizeof now->lights))
        changes |= PEL_CHANGE_LIGHTS;
    if (options_size && memcmp(seen->options, options, options_size))
        changes |= PEL_CHANGE_OPTIONS;
    return changes;
}

/* What the rows allow is what an option may be: each is written as text and read back into a copy. */
static bool check_options(const struct pel_technique_info *info, const void *options, struct pel_error *error)
{
    if (!options)
        return true;
    void *scratch = pel_alloc(1, info->options_size, "options", error);
    bool ok = scratch != NULL;
    char text[PEL_OPTION_TEXT_SIZE];
    for (const struct pel_option *row = info->options; ok && row->name; row++) {
        pel_option_get(row, options, text, sizeof text);
        ok = pel_option_set(row, scratch, text, error);
    }
    free(scratch);
    return ok;
}

static bool remember_options(struct seen *seen, const void *options, size_t size, struct pel_error *error)
{
    if (size && !seen->options && !(seen->options = pel_alloc(1, size, "options", error)))
        return false;
    if (size)
        memcpy(seen->options, options, size);
    return true;
}

static bool remember(struct pel_renderer *r, size_t i, const struct pel_scene *scene, const struct pel_render_settings *drawn,
                     const struct pel_image *image, struct pel_error *error)
{
    struct seen *seen = r->seen[i];
    if (!seen) {
        seen = r->seen[i] = pel_alloc(1, sizeof *seen, "scene", error);
        if (!seen)
            return false;
        if (!pel_transfer_init(&seen->scene.transfer, error)) {
            free(seen);
            r->seen[i] = NULL;
            return false;
        }
    }
    struct pel_transfer own = seen->scene.transfer;
    if (!pel_transfer_equal(&own, &scene->transfer) && !pel_transfer_copy(&own, &scene->transfer, error))
        return false;
    memcpy(&seen->scene, scene, sizeof *scene); /* with its padding, for the comparison */
    seen->scene.transfer = own;
    memcpy(&seen->drawn, drawn, sizeof *drawn);
    seen->volume = *scene->volume;
    seen->width = image->width;
    seen->height = image->height;
    return remember_options(seen, r->options[i], pel_techniques[i]->info.options_size, error);
}

static void add_counter(struct pel_frame_stats *s, const char *name, uint64_t value)
{
    if (s->counter_count == PEL_MAX_COUNTERS)
        return;
    s->counters[s->counter_count].name = name;
    s->counters[s->counter_count++].value = value;
}

/* One frame of the view with these settings in place of the scene's, and `jitter` as in struct pel_frame. */
static bool draw_frame(struct pel_renderer *r, size_t i, const struct pel_scene *view, const struct pel_render_settings *settings,
                       int jitter, struct pel_image *image, struct pel_error *error)
{
    const struct pel_technique *t = pel_techniques[i];
    struct pel_device *device = device_for(r, t);
    if (!device && !(t->info.engines & PEL_ENGINE_CPU))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s draws on a GPU alone; give the renderer a device", t->info.name);
    unsigned changes = changes_since(r->seen[i], view, image, r->options[i], t->info.options_size);
    if (r->seen[i]) /* the technique drew other settings than the view's where that was refined, or is to be */
        changes = (changes & ~SETTINGS) | settings_changed(&r->seen[i]->drawn, settings);
    struct pel_scene scene = *view;
    scene.render = *settings;
    struct pel_frame frame = {
        .scene = &scene,
        .image = image,
        .device = device,
        .options = r->options[i],
        .threads = r->threads,
        .jitter = jitter,
        .changes = changes,
        .progress = &r->params.progress,
        .stats = &r->stats,
    };
    struct pel_gl_saved saved;
    if (!check_options(&t->info, r->options[i], error) || (t->check && !t->check(&scene, r->options[i], device, error)) ||
        !enter_device(device, &saved, error))
        return false;
    bool ok = t->prepare(&r->states[i], &frame, error) && remember(r, i, view, settings, image, error);
    if (!ok)
        forget(r, i);
    ok = ok && t->draw(r->states[i], &frame, error);
    leave_device(device, &saved);
    return ok;
}

/* The next frame of a view at rest into the mean, if it is not finished; and the mean into the image. */
static bool draw_refined(struct pel_renderer *r, size_t i, const struct pel_scene *scene, struct pel_image *image, struct pel_error *error)
{
    struct pel_refinement *f = &r->refinement;
    if (!pel_refine_done(f)) {
        struct pel_render_settings settings;
        struct pel_image colors = *image;
        colors.depth = NULL;
        memcpy(&settings, &scene->render, sizeof settings); /* with its padding, for the comparison */
        pel_refine_settings(&settings);
        if (!pel_refine_reserve(f, error) || !draw_frame(r, i, scene, &settings, 1 + f->frames, &colors, error))
            return false;
        pel_refine_add(f, r->threads, &colors);
    }
    pel_refine_show(f, r->threads, image);
    return true;
}

static bool draw_with(struct pel_renderer *r, size_t i, const struct pel_scene *scene, struct pel_image *image, struct pel_error *error)
{
    struct pel_refinement *f = &r->refinement;
    const struct pel_device *device = device_for(r, pel_techniques[i]);
    const struct seen *seen = r->seen[i];
    bool ok, refine = scene->render.refine > 0;
    bool rests = refine && seen && !changes_since(seen, scene, image, r->options[i], pel_techniques[i]->info.options_size) &&
                 !memcmp(&seen->scene.render, &scene->render, sizeof scene->render) && pel_refine_continues(f, i, image);
    r->stats = (struct pel_frame_stats){
        .technique = rests ? r->stats.technique : pel_techniques[i]->info.name, /* "auto" names another */
        .reason = rests ? r->stats.reason : NULL,
        .device = device ? pel_device_describe(device)->name : "cpu",
        .isa = rests ? r->stats.isa : NULL,
        .threads = r->threads,
    };
    if (rests) {
        ok = draw_refined(r, i, scene, image, error);
    } else {
        if (refine)
            pel_refine_restart(f);
        else
            pel_refine_finish(f);
        ok = draw_frame(r, i, scene, &scene->render, scene->render.jitter, image, error) &&
             (!refine || pel_refine_begin(f, i, scene->render.refine, image, error));
    }
    if (refine)
        add_counter(&r->stats, "frames averaged", (uint64_t)pel_refine_count(f));
    r->last = i;
    r->finished = ok && (!refine || pel_refine_done(f));
    return ok;
}

bool pel_renderer_draw(struct pel_renderer *r, const struct pel_scene *scene, const char *technique, struct pel_image *image,
                       struct pel_error *error)
{
    r->finished = false;
    if (!pel_scene_check(scene, error))
        return false;
    if (!image->rgba || image->width < 1 || image->height < 1)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the image has no pixels; give it a size with pel_image_allocate");
    if (!technique)
        technique = "raycast";
    for (size_t i = 0; pel_techniques[i]; i++)
        if (!strcmp(pel_techniques[i]->info.name, technique))
            return draw_with(r, i, scene, image, error);
    char known[256] = "";
    for (size_t i = 0; pel_techniques[i]; i++)
        if (strlen(known) + strlen(pel_techniques[i]->info.name) + 2 < sizeof known)
            strcat(strcat(known, " "), pel_techniques[i]->info.name);
    return pel_fail(error, PEL_ERROR_ARGUMENT, "no technique '%s'; there are:%s", technique, known);
}

void pel_frame_stage(const struct pel_frame *frame, const char *name, double start_ms)
{
    pel_frame_stage_gpu(frame, name, start_ms, -1);
}

void pel_frame_stage_gpu(const struct pel_frame *frame, const char *name, double start_ms, double gpu_ms)
{
    struct pel_frame_stats *s = frame->stats;
    if (s->stage_count == PEL_MAX_STAGES)
        return;
    s->stages[s->stage_count].name = name;
    s->stages[s->stage_count].cpu_ms = pel_now_ms() - start_ms;
    s->stages[s->stage_count++].gpu_ms = gpu_ms;
}

void pel_frame_count(const struct pel_frame *frame, const char *name, uint64_t value)
{
    add_counter(frame->stats, name, value);
}
