/* SPDX-License-Identifier: MIT */
/* The technique's options, and what it refuses. */
#include <stddef.h>
#include <stdlib.h>

#include "fail.h"
#include "slices3d.h"

static const char *const culls[] = { "none", "front", "err", "ess", "ert", "ess+ert", "band", NULL };
static const char *const shows[] = { "picture", "depth", "near", "phi_t", "phi_p", NULL };
static const char *const phi_ps[] = { "followed", "reduced", "original", NULL };
static const char *const targets[] = { "float32", "float16", "byte", NULL };

#define AT(field) offsetof(struct pel_slices3d_options, field)
static const struct pel_option options[] = {
    { "cull", "Culling",
      "What hides fragments before they are shaded: nothing; empty space in front (front); rays that meet nothing (err); these and empty "
      "space "
      "behind (ess); what lies behind opaque cubes (ert); both; or all of them with a second z-buffer (band)",
      PEL_OPTION_CHOICE, AT(cull), 0, 0, "band", culls, NULL },
    { "cube-t", "Cubes of phi_t", "Edge of the cubes that enclose what may be seen; a power of two", PEL_OPTION_INT, AT(cube_t), 1, 32, "4",
      NULL, "voxels" },
    { "cube-p", "Cubes of phi_p", "Edge of the cubes that are opaque everywhere; a power of two", PEL_OPTION_INT, AT(cube_p), 1, 32, "2",
      NULL, "voxels" },
    { "opaque", "Opaque from", "Opacity of a unit distance from which a cube may hide others", PEL_OPTION_DOUBLE, AT(opaque), 0.05, 1,
      "0.8", NULL, NULL },
    { "phi-p", "Surface phi_p",
      "How opaque cubes hide: rays are followed in them until no more is seen (followed), they stop at the face as in the paper (reduced), "
      "or also at cubes that are opaque in part, which tears holes (original)",
      PEL_OPTION_CHOICE, AT(phi_p), 0, 0, "followed", phi_ps, NULL },
    { "slab", "Slab", "Slices after which pixels that are full are stopped, 1: after each as in the paper's two passes; 0: never",
      PEL_OPTION_INT, AT(slab), 0, 4096, "0", NULL, "slices" },
    { "back-to-front", "Back to front", "Draw the farthest slice first", PEL_OPTION_BOOL, AT(back_to_front), 0, 0, "false", NULL, NULL },
    { "early-out", "Early out", "Leave fragments that are transparent before they are shaded, which the paper's shaders could not",
      PEL_OPTION_BOOL, AT(early_out), 0, 0, "true", NULL, NULL },
    { "shrink", "Shrink", "With cull band, cut slices from the box of what may be seen and not from the whole volume's", PEL_OPTION_BOOL,
      AT(shrink), 0, 0, "true", NULL, NULL },
    { "target", "Target", "What slices are blended in", PEL_OPTION_CHOICE, AT(target), 0, 0, "float32", targets, NULL },
    { "show", "Show", "The picture, the z-buffer (depth), the second one (near), or the cubes' faces as they are drawn into it",
      PEL_OPTION_CHOICE, AT(show), 0, 0, "picture", shows, NULL },
    { "cost", "Cost model", "Count fragments and measure the simple and the complex shader, for --stats; draws the frame several times",
      PEL_OPTION_BOOL, AT(cost), 0, 0, "false", NULL, NULL },
    { NULL },
};
#undef AT

static bool power_of_two(int n)
{
    return (n & (n - 1)) == 0;
}

static bool check(const struct pel_scene *scene, const void *chosen, bool gpu, struct pel_error *error)
{
    (void)gpu;
    const struct pel_slices3d_options *o = chosen;
    if (scene->render.mode != PEL_MODE_COMPOSITE)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices3d draws mode composite alone; use the technique raycast for the others");
    if (!power_of_two(o->cube_t) || !power_of_two(o->cube_p))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices3d: cubes have edges of 1, 2, 4, 8, 16 or 32 voxels");
    if (o->slab && o->back_to_front)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices3d: pixels fill from front to back alone; leave out slab or back-to-front");
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    if (!*state && !(*state = pel_slices3d_create(frame->device, error)))
        return false;
    return pel_slices3d_prepare(*state, frame, error);
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    return pel_slices3d_draw(state, frame, error);
}

static void finish(void *state)
{
    pel_slices3d_destroy(state);
}

extern const struct pel_technique pel_technique_slices3d;
const struct pel_technique pel_technique_slices3d = {
    .info = {
        .name = "slices3d",
        .summary = "View-aligned slices of a 3D texture, culled by isosurfaces in the z-buffer; on a GPU; mode composite",
        .citation = "Xue, Zhang, Crawfis, iSBVR: Isosurface-aided hardware acceleration techniques for slice-based volume rendering, 2005; Xue, Volume visualization using advanced graphics hardware shaders, 2008, chapter 3",
        .engines = PEL_ENGINE_GPU,
        .options = options,
        .options_size = sizeof(struct pel_slices3d_options),
    },
    .check = check,
    .prepare = prepare,
    .draw = draw,
    .finish = finish,
};
