/* SPDX-License-Identifier: MIT */
/* Ray casting, the default technique. On the CPU the method is in src/cpu (kernel.c is the loop itself), on a GPU in raycast_gpu.c and the
 * shaders; here both meet the renderer. */
#include <stdlib.h>

#include "alloc.h"
#include "fail.h"
#include "raycast.h"
#include "raycast_gpu.h"
#include "technique.h"
#include "timer.h"

static const struct pel_option no_options[] = { { NULL } };

/* One of the two: a renderer keeps to its device. */
struct caster {
    struct pel_raycaster *cpu;
    struct pel_gpu_raycaster *gpu;
};

static bool prepare_cpu(struct pel_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    unsigned changes = frame->changes;
    double start = pel_now_ms();
    if (changes & PEL_CHANGE_VOLUME) {
        if (!pel_raycaster_set_volume(rc, frame->scene->volume, error))
            return false;
        pel_frame_stage(frame, "min-max grid", start);
        start = pel_now_ms();
    }
    if (changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_SETTINGS)) {
        if (!pel_raycaster_classify(rc, frame->scene, error))
            return false;
        pel_frame_stage(frame, "classify", start);
        start = pel_now_ms();
    } else if (changes & PEL_CHANGE_STEP) {
        if (!pel_raycaster_set_step(rc, frame->scene, error))
            return false;
        pel_frame_stage(frame, "tables", start);
        start = pel_now_ms();
    }
    if (!pel_raycaster_aim(rc, frame->scene, frame->jitter, frame->image->width, frame->image->height, error))
        return false;
    pel_frame_stage(frame, "aim", start);
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    struct caster *caster = *state;
    if (!caster && !(caster = *state = pel_alloc(1, sizeof *caster, "ray caster", error)))
        return false;
    if (frame->device) {
        if (!caster->gpu)
            caster->gpu = pel_gpu_raycaster_create(frame->device, error);
        return caster->gpu && pel_gpu_raycaster_prepare(caster->gpu, frame, error);
    }
    if (!caster->cpu)
        caster->cpu = pel_raycaster_create(frame->threads, getenv("PELLUCID_ISA"), error);
    return caster->cpu && prepare_cpu(caster->cpu, frame, error);
}

static bool draw_cpu(struct pel_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_raycast_counters c;
    double start = pel_now_ms();
    bool ok = pel_raycaster_draw(rc, frame->scene, frame->progress, frame->image, &c, error);
    frame->stats->isa = pel_raycaster_isa(rc);
    pel_frame_stage(frame, "cast rays", start);
    pel_frame_count(frame, "samples taken", c.taken);
    pel_frame_count(frame, "samples skipped", c.in_box > c.taken ? c.in_box - c.taken : 0);
    pel_frame_count(frame, "rays culled", c.culled);
    pel_frame_count(frame, "cells", c.cells);
    pel_frame_count(frame, "cells that may be seen", c.visible_cells);
    pel_frame_count(frame, "bytes beside the volume", c.bytes);
    return ok;
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    struct caster *caster = state;
    return frame->device ? pel_gpu_raycaster_draw(caster->gpu, frame, error) : draw_cpu(caster->cpu, frame, error);
}

static bool sample_limit(void *state, double *samples_per_second, struct pel_error *error)
{
    struct caster *caster = state;
    return caster->gpu ? pel_gpu_raycaster_sample_limit(caster->gpu, samples_per_second, error)
                       : pel_fail(error, PEL_ERROR_UNSUPPORTED, "the CPU engine has no texture units");
}

static void finish(void *state)
{
    struct caster *caster = state;
    if (!caster)
        return;
    pel_raycaster_destroy(caster->cpu);
    pel_gpu_raycaster_destroy(caster->gpu);
    free(caster);
}

extern const struct pel_technique pel_technique_raycast;
const struct pel_technique pel_technique_raycast = {
    .info = {
        .name = "raycast",
        .summary = "Ray casting that passes over what cannot be seen; all modes",
        .citation = "Levoy, Efficient ray tracing of volume data, 1990; optics: Xue, Volume visualization using advanced graphics hardware shaders, 2008, section 1.4",
        .engines = PEL_ENGINE_CPU | PEL_ENGINE_GPU,
        .options = no_options,
    },
    .prepare = prepare,
    .draw = draw,
    .sample_limit = sample_limit,
    .finish = finish,
};
