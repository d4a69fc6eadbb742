/* SPDX-License-Identifier: MIT */
/* The technique's descriptor, and what it refuses. */
#include <stddef.h>

#include "fail.h"
#include "mesh_render.h"

static const char *const extracts[] = { "cpu", "gpu", NULL };

#define AT(field) offsetof(struct pel_mesh_options, field)
static const struct pel_option options[] = {
    { "extract", "Extraction",
      "Who makes the triangles: the CPU, or the GPU by HistoPyramids, whose triangles are marching cubes' own, as with a tolerance of 0",
      PEL_OPTION_CHOICE, AT(extract), 0, 0, "cpu", extracts, NULL },
    { "tolerance", "Tolerance",
      "How far triangles may lie from the surface, which is curved within a voxel, before vertices are added; 0 adds none, as marching "
      "cubes",
      PEL_OPTION_DOUBLE, AT(tolerance), 0, 1, "0.02", NULL, "voxels" },
    { NULL },
};
#undef AT

/* Nobody asked for it. */
static bool is_default_tolerance(const struct pel_mesh_options *o)
{
    struct pel_mesh_options defaults;
    pel_option_defaults(options, &defaults);
    return o->tolerance == defaults.tolerance;
}

static bool check(const struct pel_scene *scene, const void *chosen, bool gpu, struct pel_error *error)
{
    (void)gpu;
    const struct pel_volume *v = scene->volume;
    const struct pel_mesh_options *o = chosen;
    if (scene->render.mode != PEL_MODE_ISOSURFACE)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "mesh draws mode isosurface alone; use the technique raycast for the others");
    if (o->extract == PEL_MESH_EXTRACT_GPU && o->tolerance != 0 && !is_default_tolerance(o))
        return pel_fail(error, PEL_ERROR_ARGUMENT,
                        "mesh: the GPU's triangles keep no tolerance (%g voxels were asked for); take extract cpu, or tolerance 0",
                        o->tolerance);
    for (int a = 0; a < 3; a++)
        if (v->dims[a] < 2)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "mesh: the volume is flat, one sample along %c; use the technique raycast",
                            'x' + a);
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    if (!*state && !(*state = pel_mesh_renderer_create(frame->device, error)))
        return false;
    return pel_mesh_renderer_prepare(*state, frame, error);
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    return pel_mesh_renderer_draw(state, frame, error);
}

static void finish(void *state)
{
    pel_mesh_renderer_destroy(state);
}

extern const struct pel_technique pel_technique_mesh;
const struct pel_technique pel_technique_mesh = {
    .info = {
        .name = "mesh",
        .summary = "Isosurfaces as triangles of marching cubes, through the rasteriser; on a GPU; mode isosurface",
        .citation = "Lorensen and Cline, Marching cubes: A high resolution 3D surface construction algorithm, 1987; Nielson and Hamann, The asymptotic decider, 1991",
        .engines = PEL_ENGINE_GPU,
        .options = options,
        .options_size = sizeof(struct pel_mesh_options),
    },
    .check = check,
    .prepare = prepare,
    .draw = draw,
    .finish = finish,
};
