/* SPDX-License-Identifier: MIT */
/* The parts of a scene that are chosen from its volume where nobody says them. What makes a good choice is in automatic.c (transfer
 * function, isovalue) and scene_fit.c (camera); here is what they are asked for. */
#include <math.h>
#include <string.h>

#include <pellucid/scene.h>

#include "vec.h"

static enum pel_transfer_purpose purpose_of(enum pel_mode mode)
{
    switch (mode) {
    case PEL_MODE_MIP:
        return PEL_TRANSFER_PROJECTION;
    case PEL_MODE_AVERAGE:
        return PEL_TRANSFER_AVERAGE;
    case PEL_MODE_MINIP:
    case PEL_MODE_SLICE:
        return PEL_TRANSFER_OPAQUE;
    case PEL_MODE_XRAY:
        return PEL_TRANSFER_XRAY;
    case PEL_MODE_COMPOSITE:
    case PEL_MODE_ISOSURFACE:
        break;
    }
    return PEL_TRANSFER_COMPOSITE;
}

static bool choose_transfer(struct pel_scene *scene, bool colors, bool opacities, bool unit, struct pel_error *error)
{
    struct pel_transfer automatic, *transfer = &scene->transfer;
    if (!colors && !opacities) {
        if (unit)
            transfer->unit_distance = pel_volume_mean_spacing(scene->volume);
        return true;
    }
    if (!pel_transfer_init(&automatic, error))
        return false;
    bool fine = pel_transfer_automatic(&automatic, scene->volume, purpose_of(scene->render.mode), error);
    if (fine && colors) {
        fine = pel_transfer_set_colors(transfer, automatic.colors, automatic.color_count, error);
        memcpy(transfer->colormap, automatic.colormap, sizeof transfer->colormap);
    }
    if (fine && opacities)
        fine = pel_transfer_set_opacities(transfer, automatic.opacities, automatic.opacity_count, error);
    if (unit)
        transfer->unit_distance = automatic.unit_distance;
    pel_transfer_finish(&automatic);
    return fine;
}

static void choose_slice(struct pel_scene *scene)
{
    const struct pel_volume *volume = scene->volume;
    double bounds[6], middle[3];
    pel_volume_bounds(volume, bounds);
    for (int a = 0; a < 3; a++) {
        scene->slice.origin[a] = 0.5 * bounds[2 * a] + 0.5 * bounds[2 * a + 1];
        middle[a] = (double)((volume->dims[a] - 1) / 2);
    }
    if (volume->labels) /* through voxels, not between two */
        pel_volume_index_to_world(volume, middle, scene->slice.origin);
    memcpy(scene->slice.normal, volume->direction[2], sizeof scene->slice.normal);
    scene->more_slice_count = 0;
}

/* Sees a slice face on, from the side on which the camera was, upright as far as that can be. */
static void face_slice(struct pel_camera *camera, const struct pel_plane *slice, enum pel_space space)
{
    double length = pel_length(slice->normal), view[3];
    pel_sub(camera->position, camera->focal_point, view);
    double distance = pel_length(view) * (pel_dot(view, slice->normal) < 0 ? -1 : 1);
    for (int a = 0; a < 3; a++)
        camera->position[a] = camera->focal_point[a] + distance * slice->normal[a] / length;
    memcpy(camera->view_up, (double[3]) { 0, 0, 1 }, sizeof camera->view_up);
    if (fabs(slice->normal[2]) > 0.9 * length) /* a patient's front is up: +y in RAS, -y in LPS */
        memcpy(camera->view_up, (double[3]) { 0, space == PEL_SPACE_LPS ? -1 : 1, 0 }, sizeof camera->view_up);
}

bool pel_scene_choose(struct pel_scene *scene, const struct pel_scene_parts *parts, int width, int height, struct pel_error *error)
{
    static const double bone[3] = { 0.9, 0.85, 0.75 };
    bool all = parts->transfer && !parts->colors && !parts->opacities && !parts->unit_distance;
    if (!choose_transfer(scene, all || parts->colors, all || parts->opacities, all || parts->unit_distance, error))
        return false;
    if (parts->isosurfaces) {
        scene->isosurface_count = 1;
        scene->isosurfaces[0].value = pel_isovalue_automatic(scene->volume);
        scene->isosurfaces[0].opacity = 1;
        memcpy(scene->isosurfaces[0].color, bone, sizeof bone);
    }
    if (parts->slice)
        choose_slice(scene);
    if (parts->camera) {
        pel_scene_fit_camera(scene, width, height);
        if (scene->render.mode == PEL_MODE_SLICE && scene->more_slice_count == 0)
            face_slice(&scene->camera, &scene->slice, scene->volume->space);
    }
    return true;
}
