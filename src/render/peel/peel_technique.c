/* SPDX-License-Identifier: MIT */
/* The technique's options, and what it refuses. */
#include <stddef.h>

#include "fail.h"
#include "peel.h"

static const char *const covers[] = { "disc", "box", NULL };
static const char *const skippings[] = { "masks", "tree", NULL };
static const char *const paths[] = { "auto", "raster", "compute", NULL };

#define AT(field) offsetof(struct pel_peel_options, field)
static const struct pel_option options[] = {
    { "granularity", "Granularity", "Edge of the macro-cells that are active or not", PEL_OPTION_INT, AT(granularity), 1, 8, "2", NULL,
      "voxels" },
    { "interior", "Interior skipping", "Skip what is empty between the first layer of active cells and the last, too", PEL_OPTION_BOOL,
      AT(interior), 0, 0, "true", NULL, NULL },
    { "segments", "Segments",
      "What finds a ray's segments: the peeled masks, or a traversal of a min-max tree along each ray, to compare them with",
      PEL_OPTION_CHOICE, AT(skipping), 0, 0, "masks", skippings, NULL },
    { "cover", "Cover", "What of the screen an active cell covers: the paper's disc around it, or the bound of its box", PEL_OPTION_CHOICE,
      AT(cover), 0, 0, "box", covers, NULL },
    { "mask-path", "Mask path",
      "What makes the masks: the rasteriser and the logic operation OR, a compute shader with atomic OR, or the faster of them, as "
      "measured at the first frame",
      PEL_OPTION_CHOICE, AT(path), 0, 0, "auto", paths, NULL },
    { "bisect", "Bisect", "With roots by steps: settle where a step meets a surface by halving it ten times, as printed, in place of regula falsi",
      PEL_OPTION_BOOL, AT(bisect), 0, 0, "false", NULL, NULL },
    { NULL },
};
#undef AT

static bool check(const struct pel_scene *scene, const void *chosen, bool gpu, struct pel_error *error)
{
    (void)gpu;
    const struct pel_peel_options *o = chosen;
    if (scene->render.mode != PEL_MODE_ISOSURFACE)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "peel draws mode isosurface alone; use the technique raycast for the others");
    if (o->skipping == PEL_BY_TREE && !o->interior)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "peel: a tree has no first and last layer; leave out segments tree or no-interior");
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    if (!*state && !(*state = pel_peel_create(frame->device, error)))
        return false;
    return pel_peel_prepare(*state, frame, error);
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    return pel_peel_draw(state, frame, error);
}

static void finish(void *state)
{
    pel_peel_destroy(state);
}

extern const struct pel_technique pel_technique_peel;
const struct pel_technique pel_technique_peel = {
    .info = {
        .name = "peel",
        .summary = "Isosurfaces, opaque or translucent, by rays inside the layers of active cells alone; on a GPU; mode isosurface",
        .citation = "Liu, Clapworthy, Dong, Multi-layer depth peeling by single-pass rasterisation for faster isosurface raytracing on GPUs, 2010",
        .engines = PEL_ENGINE_GPU,
        .options = options,
        .options_size = sizeof(struct pel_peel_options),
    },
    .check = check,
    .prepare = prepare,
    .draw = draw,
    .finish = finish,
};
