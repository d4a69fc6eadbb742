/* SPDX-License-Identifier: MIT */
/* The scene: its starting values, the option rows of the optics, and the one check that all drawing passes. */
#include <pellucid/scene.h>

#include <math.h>
#include <string.h>

#include "fail.h"
#include "vec.h"

static const char *const modes[] = { "composite", "mip", "minip", "average", "xray", "isosurface", "slice", NULL };
static const char *const classifications[] = { "post", "pre", "preintegrated", NULL };
static const char *const roots[] = { "cubic", "steps", NULL };
static const char *const reconstructions[] = { "auto", "linear", "nearest", NULL };

#define AT(field) offsetof(struct pel_render_settings, field)
const struct pel_option pel_render_options[] = {
    { "mode", "Mode",
      "How samples along a ray become a pixel: light emitted and absorbed, the greatest, least or mean sample, "
      "absorption alone, surfaces of equal value, or planes",
      PEL_OPTION_CHOICE, AT(mode), 0, 0, "composite", modes, NULL },
    { "step", "Step", "Distance between samples along a ray", PEL_OPTION_DOUBLE, AT(step), 0.01, 100, "0.5", NULL, "voxels" },
    { "jitter", "Jitter", "Move each ray's samples by a fixed pseudo-random part of the step: fine noise in place of rings",
      PEL_OPTION_BOOL, AT(jitter), 0, 1, "false", NULL, NULL },
    { "refine", "Refine", "Average this many frames at half a voxel (or at a finer --step), each with its samples elsewhere in their steps; 0: one frame as it is",
      PEL_OPTION_INT, AT(refine), 0, 256, "0", NULL, "frames" },
    { "termination", "Termination", "A ray ends once its opacity reaches this; 1 follows every ray to its end", PEL_OPTION_DOUBLE,
      AT(termination), 0.01, 1, "0.998", NULL, "opacity" },
    { "skip", "Skip what cannot be seen", "Pass over transparent regions; the picture is the same, only sooner", PEL_OPTION_BOOL,
      AT(skip), 0, 1, "true", NULL, NULL },
    { "classification", "Classification",
      "Look colours up after interpolating values (post), at the voxels (pre), or integrate the transfer function between samples "
      "(preintegrated)",
      PEL_OPTION_CHOICE, AT(classification), 0, 0, "post", classifications, NULL },
    { "reconstruction", "Reconstruction", "How values between voxels are found; auto is nearest for labels and linear for everything else",
      PEL_OPTION_CHOICE, AT(reconstruction), 0, 0, "auto", reconstructions, NULL },
    { "roots", "Roots",
      "How rays find isosurfaces: exactly, cell by cell, as the roots of a cubic; or by steps, which miss what lies between two of them. "
      "Slices and triangles have their own ways",
      PEL_OPTION_CHOICE, AT(roots), 0, 0, "cubic", roots, NULL },
    { "shade", "Shading", "Light the composite by the gradient of the values; isosurfaces are always lit", PEL_OPTION_BOOL, AT(shade), 0, 1,
      "true", NULL, NULL },
    { "ambient", "Ambient", "Light that reaches everything", PEL_OPTION_DOUBLE, AT(ambient), 0, 10, "0.3", NULL, NULL },
    { "diffuse", "Diffuse", "Light reflected evenly by what faces the light", PEL_OPTION_DOUBLE, AT(diffuse), 0, 10, "0.7", NULL, NULL },
    { "specular", "Specular", "Strength of highlights", PEL_OPTION_DOUBLE, AT(specular), 0, 10, "0.2", NULL, NULL },
    { "specular-power", "Specular power", "Sharpness of highlights; larger is sharper", PEL_OPTION_DOUBLE, AT(specular_power), 0, 1000,
      "20", NULL, NULL },
    { "invert", "Invert", "X-ray: bright where it absorbs, as a radiograph shows it", PEL_OPTION_BOOL, AT(invert), 0, 1, "false", NULL,
      NULL },
    { NULL },
};
#undef AT

void pel_source_apply(const struct pel_source *source, struct pel_volume *volume)
{
    if (source->has_spacing)
        memcpy(volume->spacing, source->spacing, sizeof volume->spacing);
    if (source->has_void) {
        volume->has_void = true;
        volume->void_value = source->void_value;
        pel_volume_update_range(volume);
    }
}

bool pel_scene_init(struct pel_scene *scene, struct pel_error *error)
{
    memset(scene, 0, sizeof *scene);
    if (!pel_transfer_init(&scene->transfer, error))
        return false;
    scene->camera = (struct pel_camera)PEL_CAMERA_INIT;
    pel_option_defaults(pel_render_options, &scene->render);
    scene->slice.normal[2] = 1;
    scene->lights[0] = (struct pel_light){ .headlight = true, .color = { 1, 1, 1 } };
    scene->light_count = 1;
    scene->background[3] = 1;
    return true;
}

void pel_scene_finish(struct pel_scene *scene)
{
    pel_transfer_finish(&scene->transfer);
    memset(scene, 0, sizeof *scene);
}

static bool within(const double *values, int count, double lo, double hi)
{
    for (int i = 0; i < count; i++)
        if (!(values[i] >= lo && values[i] <= hi))
            return false;
    return true;
}

static bool check_direction(const double v[3], const char *what, int index, struct pel_error *error)
{
    double length = pel_length(v);
    if (!(length > 0) || !isfinite(length))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s %d: (%g, %g, %g) is no direction", what, index, v[0], v[1], v[2]);
    return true;
}

static bool check_plane(const struct pel_plane *plane, const char *what, int index, struct pel_error *error)
{
    if (!within(plane->origin, 3, -1e100, 1e100))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s %d: its origin is not finite", what, index);
    return check_direction(plane->normal, what, index, error);
}

/* What the option rows allow is what a setting may be: each is written as text and read back into a scratch copy. */
static bool check_settings(const struct pel_render_settings *settings, struct pel_error *error)
{
    struct pel_render_settings scratch = *settings;
    char text[256];
    for (const struct pel_option *row = pel_render_options; row->name; row++) {
        pel_option_get(row, settings, text, sizeof text);
        if (!pel_option_set(row, &scratch, text, error))
            return false;
    }
    return true;
}

static bool check_isosurfaces(const struct pel_scene *scene, struct pel_error *error)
{
    if (scene->isosurface_count < 0 || scene->isosurface_count > PEL_MAX_ISOSURFACES)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%d isosurfaces; at most %d are possible", scene->isosurface_count, PEL_MAX_ISOSURFACES);
    if (scene->render.mode == PEL_MODE_ISOSURFACE && scene->isosurface_count == 0)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "no isosurface to draw; give an isovalue");
    for (int i = 0; i < scene->isosurface_count; i++) {
        const struct pel_isosurface *surface = &scene->isosurfaces[i];
        if (!isfinite(surface->value))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "isosurface %d: the isovalue is not finite", i);
        if (!within(surface->color, 3, 0, 1) || !within(&surface->opacity, 1, 0, 1))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "isosurface %d: colour and opacity must be from 0 to 1", i);
    }
    return true;
}

static bool check_lights(const struct pel_scene *scene, struct pel_error *error)
{
    if (scene->light_count < 0 || scene->light_count > PEL_MAX_LIGHTS)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%d lights; at most %d are possible", scene->light_count, PEL_MAX_LIGHTS);
    for (int i = 0; i < scene->light_count; i++) {
        const struct pel_light *light = &scene->lights[i];
        if (!light->headlight && !check_direction(light->direction, "light", i, error))
            return false;
        if (!within(light->color, 3, 0, 1e6))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "light %d: its colour must be finite and not negative", i);
    }
    return true;
}

static bool check_clipping(const struct pel_scene *scene, struct pel_error *error)
{
    if (scene->clip_plane_count < 0 || scene->clip_plane_count > PEL_MAX_CLIP_PLANES)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%d clip planes; at most %d are possible", scene->clip_plane_count, PEL_MAX_CLIP_PLANES);
    for (int i = 0; i < scene->clip_plane_count; i++)
        if (!check_plane(&scene->clip_planes[i], "clip plane", i, error))
            return false;
    for (int a = 0; scene->clip_box_enabled && a < 3; a++)
        if (!(scene->clip_box[2 * a] <= scene->clip_box[2 * a + 1]))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "clip box: %g to %g along axis %d; the least comes first", scene->clip_box[2 * a],
                            scene->clip_box[2 * a + 1], a);
    return true;
}

static bool check_slices(const struct pel_scene *scene, struct pel_error *error)
{
    if (scene->more_slice_count < 0 || scene->more_slice_count > PEL_MAX_SLICES - 1)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%d slices; 1 to %d are possible", scene->more_slice_count + 1, PEL_MAX_SLICES);
    if (scene->render.mode != PEL_MODE_SLICE)
        return true;
    if (!check_plane(&scene->slice, "slice", 0, error))
        return false;
    for (int i = 0; i < scene->more_slice_count; i++)
        if (!check_plane(&scene->more_slices[i], "slice", i + 1, error))
            return false;
    return true;
}

bool pel_scene_check(const struct pel_scene *scene, struct pel_error *error)
{
    if (!scene->volume)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the scene has no volume");
    if (!pel_volume_check(scene->volume, error))
        return pel_fail_in(error, "volume: ");
    if (scene->volume->components != 1)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a volume of %d components cannot be drawn; take its magnitude first",
                        scene->volume->components);
    if (scene->transfer.color_count < 1 || scene->transfer.opacity_count < 1)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the transfer function has no points");
    if (!(scene->transfer.unit_distance > 0) || !isfinite(scene->transfer.unit_distance))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a unit distance of %g; it must be positive", scene->transfer.unit_distance);
    if (!within(scene->background, 4, 0, 1))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the background's colour must be from 0 to 1");
    return pel_camera_check(&scene->camera, error) && check_settings(&scene->render, error) && check_isosurfaces(scene, error) &&
           check_lights(scene, error) && check_clipping(scene, error) && check_slices(scene, error);
}
