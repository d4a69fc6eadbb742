/* SPDX-License-Identifier: MIT */
/* Object-aligned slices. The paper (Rezk-Salama et al. 2000, section 4) keeps three stacks of 2D textures and lets the graphics card shear
 * and warp them without saying so: on a GPU that is slices2d_gpu.c and the .glsl files beside it. On the CPU the shear and the warp are
 * explicit (Lacroute and Levoy 1994), in src/cpu/shear_warp.c. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "alloc.h"
#include "fail.h"
#include "shear_warp.h"
#include "slices2d.h"
#include "slices2d_gpu.h"
#include "slices2d_schedule.h"
#include "technique.h"
#include "timer.h"

static const char *const corrections[] = { "exact", "linear", NULL };
static const char *const intermediates[] = { "voxel", "picture", NULL };
static const char *const each[] = { "1", "2", "4", "8", NULL };
static const char *const coordinates[] = { "corrected", "shared", NULL };
static const char *const surfaces[] = { "crossing", "alpha-test", NULL };
static const char *const lightings[] = { "scene", "global", "voxel", NULL };

#define AT(field) offsetof(struct pel_slices2d_options, field)
static const struct pel_option options[] = {
    { "supersampling", "Supersampling", "Slices composited for each slice of voxels; those between are interpolated", PEL_OPTION_INT,
      AT(supersampling), 1, 10, "1", NULL, NULL },
    { "opacity-correction", "Opacity correction",
      "How opacity follows the distance between slices along a ray: exactly, or scaled linearly as the paper does", PEL_OPTION_CHOICE,
      AT(correction), 0, 0, "exact", corrections, NULL },
    { "intermediate", "Intermediate image",
      "What the rays of the CPU engine's intermediate image are as far apart as: voxels, or pixels of the picture", PEL_OPTION_CHOICE,
      AT(intermediate), 0, 0, "voxel", intermediates, NULL },
    { "rays", "Rays", "Rays of the CPU engine's intermediate image along each axis, a voxel or a pixel", PEL_OPTION_DOUBLE, AT(rays), 0.25,
      8, "1", NULL, NULL },
    { "slice-step", "Slice step", "One slice for so many slices of voxels: what moves need not be as fine as what rests", PEL_OPTION_INT,
      AT(every), 1, 8, "1", NULL, NULL },
    { "budget", "Budget",
      "Leave slices out to draw in so much time, as what earlier pictures took tells; what is left out, and so the picture, then depends "
      "on the machine's pace; 0: leave out none",
      PEL_OPTION_DOUBLE, AT(budget_ms), 0, 10000, "0", NULL, "milliseconds" },
    { "slices-per-polygon", "Slices a polygon", "Slices that the GPU engine maps on one polygon: the same picture, drawn sooner",
      PEL_OPTION_CHOICE, AT(slices_per_polygon), 0, 0, "4", each, NULL },
    { "texture-coordinates", "Texture coordinates",
      "Of several slices on a polygon (GPU): corrected for where each lies, or shared, which shows them displaced", PEL_OPTION_CHOICE,
      AT(coordinates), 0, 0, "corrected", coordinates, NULL },
    { "blend", "Blend", "Within how many degrees about the switch from one stack to another both are drawn and blended", PEL_OPTION_DOUBLE,
      AT(blend), 0, 45, "0", NULL, "degrees" },
    { "surface", "Surface",
      "What of a slice an isosurface is (GPU): where the value crosses the isovalue to the next, or what passes the paper's alpha test",
      PEL_OPTION_CHOICE, AT(surface), 0, 0, "crossing", surfaces, NULL },
    { "lighting", "Lighting",
      "The scene's, or the paper's ambient and diffuse light (GPU): with a global ambient colour, or with the voxels' own",
      PEL_OPTION_CHOICE, AT(lighting), 0, 0, "scene", lightings, NULL },
    { "ambient-color", "Ambient colour", "Of lighting global", PEL_OPTION_COLOR, AT(ambient_color), 0, 0, "#202060", NULL, NULL },
    { NULL },
};
#undef AT

/* One of the two: a renderer keeps to its device. */
struct slicer {
    struct pel_shear_warp *cpu;
    struct pel_gpu_slices2d *gpu;
    struct pel_slices2d_scheduler scheduler;
    struct pel_slices2d_options options; /* of this frame: as they are set, or as the scheduler would have them */
    int voxels;                          /* along the view: slices of voxels */
};

/* Slices of voxels along the index axis nearest to the view's direction. */
static int voxels_along_view(const struct pel_scene *scene)
{
    const struct pel_volume *volume = scene->volume;
    double eye[3], focus[3];
    int nearest = 0;
    pel_volume_world_to_index(volume, scene->camera.position, eye);
    pel_volume_world_to_index(volume, scene->camera.focal_point, focus);
    for (int a = 1; a < 3; a++)
        if (fabs(focus[a] - eye[a]) > fabs(focus[nearest] - eye[nearest]))
            nearest = a;
    return (int)volume->dims[nearest];
}

/* The frame with options that fit its budget (section 10). */
static struct pel_frame scheduled(struct slicer *slicer, const struct pel_frame *frame)
{
    struct pel_slices2d_options *o = &slicer->options;
    struct pel_frame own = *frame;
    own.options = o;
    *o = *(const struct pel_slices2d_options *)frame->options;
    if (o->budget_ms > 0) {
        const struct pel_slices2d_quality best = { o->supersampling, o->every, 1 << o->slices_per_polygon };
        slicer->scheduler.no_polygons = !frame->device;
        slicer->voxels = voxels_along_view(frame->scene);
        struct pel_slices2d_quality q = pel_slices2d_schedule(&slicer->scheduler, true, o->budget_ms, slicer->voxels, &best);
        o->supersampling = q.supersampling;
        o->every = q.every;
        o->slices_per_polygon = __builtin_ctz((unsigned)q.slices_per_polygon);
    }
    return own;
}

static bool check_gpu(const struct pel_render_settings *r, struct pel_error *error)
{
    if (r->mode != PEL_MODE_COMPOSITE && r->mode != PEL_MODE_ISOSURFACE && r->mode != PEL_MODE_SLICE)
        return pel_fail(error, PEL_ERROR_ARGUMENT,
                        "slices2d draws the modes composite, isosurface and slice on a GPU; use the technique raycast for the others");
    if (r->mode == PEL_MODE_COMPOSITE && r->classification == PEL_CLASSIFICATION_PREINTEGRATED)
        return pel_fail(error, PEL_ERROR_ARGUMENT,
                        "slices2d cannot pre-integrate; use the classification post or pre, or the technique raycast");
    return true;
}

static bool check_cpu(const struct pel_scene *scene, const struct pel_slices2d_options *o, struct pel_error *error)
{
    if (scene->render.mode != PEL_MODE_COMPOSITE)
        return pel_fail(error, PEL_ERROR_ARGUMENT,
                        "slices2d draws mode composite alone on the CPU; use the technique raycast for the others");
    if (scene->render.classification != PEL_CLASSIFICATION_POST)
        return pel_fail(error, PEL_ERROR_ARGUMENT,
                        "slices2d classifies after interpolation (post) alone on the CPU; use the technique raycast");
    if (o->lighting != PEL_LIGHTING_SCENE || o->coordinates != PEL_COORDINATES_CORRECTED)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices2d: lighting and texture-coordinates are the GPU engine's; use --device gpu");
    return true;
}

static bool check(const struct pel_scene *scene, const void *chosen, bool gpu, struct pel_error *error)
{
    return gpu ? check_gpu(&scene->render, error) : check_cpu(scene, chosen, error);
}

static bool prepare_cpu(struct pel_shear_warp *sw, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_slices2d_options *o = frame->options;
    const unsigned changes = frame->changes;
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
    const struct pel_shear_settings settings = { o->supersampling, o->every, o->intermediate, o->rays, o->blend };
    if (!pel_shear_warp_aim(sw, frame->scene, &settings, o->correction == PEL_CORRECTION_LINEAR, frame->image->width, frame->image->height,
                            error))
        return false;
    pel_frame_stage(frame, "factor", start);
    return true;
}

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    struct slicer *slicer = *state;
    if (!slicer && !(slicer = *state = pel_alloc(1, sizeof *slicer, "slices", error)))
        return false;
    const struct pel_frame own = scheduled(slicer, frame);
    if (frame->device) {
        if (!slicer->gpu)
            slicer->gpu = pel_gpu_slices2d_create(frame->device, error);
        return slicer->gpu && pel_gpu_slices2d_prepare(slicer->gpu, &own, error);
    }
    if (!slicer->cpu)
        slicer->cpu = pel_shear_warp_create(frame->threads, getenv("PELLUCID_ISA"), error);
    return slicer->cpu && prepare_cpu(slicer->cpu, &own, error);
}

static bool draw_cpu(struct pel_shear_warp *sw, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_shear_counters c;
    double stages[2];
    frame->stats->isa = pel_shear_warp_isa(sw);
    if (!pel_shear_warp_draw(sw, frame->scene, frame->progress, frame->image, &c, stages, error))
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

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    struct slicer *slicer = state;
    const struct pel_slices2d_options *o = &slicer->options;
    struct pel_frame own = *frame;
    double start = pel_now_ms();
    own.options = o;
    if (!(frame->device ? pel_gpu_slices2d_draw(slicer->gpu, &own, error) : draw_cpu(slicer->cpu, &own, error)))
        return false;
    const struct pel_slices2d_quality drawn = { o->supersampling, o->every, 1 << o->slices_per_polygon };
    if (o->budget_ms > 0)
        pel_slices2d_measured(&slicer->scheduler, &drawn, slicer->voxels, pel_now_ms() - start);
    return true;
}

static void finish(void *state)
{
    struct slicer *slicer = state;
    if (!slicer)
        return;
    pel_shear_warp_destroy(slicer->cpu);
    pel_gpu_slices2d_destroy(slicer->gpu);
    free(slicer);
}

extern const struct pel_technique pel_technique_slices2d;
const struct pel_technique pel_technique_slices2d = {
    .info = {
        .name = "slices2d",
        .summary = "Object-aligned slices: the picture under the moving hand; mode composite, on a GPU isosurface and slice, too",
        .citation = "Rezk-Salama, Engel, Bauer, Greiner, Ertl, Interactive volume rendering on standard PC graphics hardware using multi-textures and multi-stage rasterization, 2000; on the CPU Lacroute and Levoy, Fast volume rendering using a shear-warp factorization of the viewing transformation, 1994",
        .engines = PEL_ENGINE_CPU | PEL_ENGINE_GPU,
        .options = options,
        .options_size = sizeof(struct pel_slices2d_options),
    },
    .check = check,
    .prepare = prepare,
    .draw = draw,
    .finish = finish,
};
