/* SPDX-License-Identifier: MIT */
/* Object-aligned slices. The paper (Rezk-Salama et al. 2000, section 4) keeps three stacks of 2D textures and lets the graphics card shear
 * and warp them without saying so; on the CPU the shear and the warp are explicit (Lacroute and Levoy 1994), in src/cpu/shear_warp.c. */
#include <stddef.h>
#include <stdlib.h>

#include "fail.h"
#include "shear_warp.h"
#include "technique.h"
#include "timer.h"

enum correction { CORRECTION_EXACT, CORRECTION_LINEAR };
static const char *const corrections[] = { "exact", "linear", NULL };
static const char *const intermediates[] = { "voxel", "picture", NULL };

struct slices2d_options {
    int supersampling;
    enum correction correction;
    enum pel_intermediate intermediate;
    double rays;
};

#define AT(field) offsetof(struct slices2d_options, field)
static const struct pel_option options[] = {
    { "supersampling", "Supersampling", "Slices composited for each slice of voxels; those between are interpolated", PEL_OPTION_INT,
      AT(supersampling), 1, 10, "1", NULL, NULL },
    { "opacity-correction", "Opacity correction",
      "How opacity follows the distance between slices along a ray: exactly, or scaled linearly as the paper does", PEL_OPTION_CHOICE,
      AT(correction), 0, 0, "exact", corrections, NULL },
    { "intermediate", "Intermediate image", "What the rays of the intermediate image are as far apart as: voxels, or pixels of the picture",
      PEL_OPTION_CHOICE, AT(intermediate), 0, 0, "voxel", intermediates, NULL },
    { "rays", "Rays", "Rays of the intermediate image along each axis, a voxel or a pixel", PEL_OPTION_DOUBLE, AT(rays), 0.25, 8, "1", NULL,
      NULL },
    { NULL },
};
#undef AT

/* What slices cannot draw is refused, so that nobody takes another picture for the one asked for. */
static bool check(const struct pel_scene *scene, struct pel_error *error)
{
    if (scene->render.mode != PEL_MODE_COMPOSITE)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices2d draws mode composite alone; use the technique raycast for the others");
    if (scene->render.classification != PEL_CLASSIFICATION_POST)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices2d classifies after interpolation (post) alone; use the technique raycast");
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    const struct slices2d_options *o = frame->options;
    const unsigned changes = frame->changes;
    struct pel_shear_warp *sw = *state;
    if (!check(frame->scene, error))
        return false;
    if (!sw && !(sw = *state = pel_shear_warp_create(frame->threads, getenv("PELLUCID_ISA"), error)))
        return false;
    double start = pel_now_ms();
    if (changes & PEL_CHANGE_VOLUME) {
        if (!pel_shear_warp_set_volume(sw, frame->scene->volume, error))
            return false;
        pel_frame_stage(frame, "min-max grid", start);
        start = pel_now_ms();
    }
    if (changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_SETTINGS)) {
        if (!pel_shear_warp_classify(sw, frame->scene, error))
            return false;
        pel_frame_stage(frame, "classify", start);
        start = pel_now_ms();
    } else if (changes & PEL_CHANGE_STEP && !pel_shear_warp_set_step(sw, frame->scene, error)) {
        return false;
    }
    const struct pel_shear_settings settings = { o->supersampling, o->intermediate, o->rays };
    if (!pel_shear_warp_aim(sw, frame->scene, &settings, o->correction == CORRECTION_LINEAR, frame->image->width, frame->image->height,
                            error))
        return false;
    pel_frame_stage(frame, "factor", start);
    return true;
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_shear_counters c;
    double stages[2];
    frame->stats->isa = pel_shear_warp_isa(state);
    if (!pel_shear_warp_draw(state, frame->scene, frame->progress, frame->image, &c, stages, error))
        return false;
    double now = pel_now_ms();
    pel_frame_stage(frame, "shear", now - stages[0]);
    pel_frame_stage(frame, "warp", now - stages[1]);
    pel_frame_count(frame, "samples taken", c.taken);
    pel_frame_count(frame, "samples skipped", c.in_box > c.taken ? c.in_box - c.taken : 0);
    pel_frame_count(frame, "rays", c.rays);
    pel_frame_count(frame, "slices", c.slices);
    pel_frame_count(frame, "cells", c.cells);
    pel_frame_count(frame, "cells that may be seen", c.visible_cells);
    pel_frame_count(frame, "bytes beside the volume", c.bytes);
    return true;
}

static void finish(void *state)
{
    pel_shear_warp_destroy(state);
}

extern const struct pel_technique pel_technique_slices2d;
const struct pel_technique pel_technique_slices2d = {
    .info = {
        .name = "slices2d",
        .summary = "Object-aligned slices (shear-warp): the picture under the moving hand; mode composite",
        .citation = "Rezk-Salama, Engel, Bauer, Greiner, Ertl, Interactive volume rendering on standard PC graphics hardware using multi-textures and multi-stage rasterization, 2000, sections 4 and 5; Lacroute and Levoy, Fast volume rendering using a shear-warp factorization of the viewing transformation, 1994",
        .engines = PEL_ENGINE_CPU,
        .options = options,
        .options_size = sizeof(struct slices2d_options),
    },
    .prepare = prepare,
    .draw = draw,
    .finish = finish,
};
