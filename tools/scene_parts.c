/* SPDX-License-Identifier: MIT */
/* The parts of a scene that are chosen from the volume where nobody says them: transfer function, surfaces and slice, camera. */
#include "scene_arguments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Stretches the colours from the values that they cover now over [to[0], to[1]], and the opacities alike if they were chosen automatically.
 */
static bool stretch(struct pel_transfer *transfer, const double to[2], bool opacities_too, struct pel_error *error)
{
    double lo = transfer->colors[0].value, hi = transfer->colors[transfer->color_count - 1].value;
    if (!(lo < hi))
        return true;
    bool fine = false;
    double low = fmin(to[0], to[1]), high = fmax(to[0], to[1]);
    struct pel_color_point *colors = malloc(transfer->color_count * sizeof *colors);
    struct pel_opacity_point *opacities = malloc((transfer->opacity_count + 1) * sizeof *opacities);
    if (!colors || !opacities) {
        tool_fail(error, PEL_ERROR_MEMORY, "no memory for the transfer function");
        goto cleanup;
    }
    for (size_t i = 0; i < transfer->color_count; i++) {
        colors[i] = transfer->colors[i];
        colors[i].value = to[0] + (colors[i].value - lo) / (hi - lo) * (to[1] - to[0]);
    }
    for (size_t i = 0; i < transfer->opacity_count; i++) {
        opacities[i] = transfer->opacities[i];
        opacities[i].value = low + (opacities[i].value - lo) / (hi - lo) * (high - low);
    }
    fine =
        pel_transfer_set_colors(transfer, colors, transfer->color_count, error) &&
        (!opacities_too || transfer->opacity_count == 0 || pel_transfer_set_opacities(transfer, opacities, transfer->opacity_count, error));
cleanup:
    free(colors);
    free(opacities);
    return fine;
}

/* A colour map by name, or FILE.json, FILE.xml, FILE.json#PRESET. */
static bool set_colormap(struct pel_transfer *transfer, const char *text, const double range[2], struct pel_error *error)
{
    char path[PEL_OPTION_TEXT_SIZE];
    snprintf(path, sizeof path, "%s", text);
    char *preset = strrchr(path, '#');
    if (preset)
        *preset++ = 0;
    const char *ending = strrchr(path, '.');
    if (!ending || (strcmp(ending, ".json") != 0 && strcmp(ending, ".xml") != 0))
        return pel_transfer_set_colormap(transfer, text, range[0], range[1], error);
    return pel_read_transfer(path, preset && *preset ? preset : NULL, range[0], range[1], transfer, error) || tool_fail_in(error, path);
}

bool scene_set_transfer(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                        const struct pel_scene_parts *has, struct pel_error *error)
{
    struct pel_transfer *transfer = &loaded->scene.transfer;
    bool map = arguments_given(arguments, "colormap"), curve = arguments_given(arguments, "opacity"),
         range = arguments_given(arguments, "range");
    bool own_colors = !has->colors && !map, own_opacities = !has->opacities && !curve;
    const struct pel_scene_parts own = { .colors = own_colors || (own_opacities && range && !loaded->volume.labels),
                                         .opacities = own_opacities,
                                         .unit_distance = !has->unit_distance };
    if (!pel_scene_choose(&loaded->scene, &own, 0, 0, error))
        return false;
    /* Names are no scale: labels keep their colours. */
    if (range && !loaded->volume.labels && !stretch(transfer, values->range, own_opacities, error))
        return false;
    double whole[2] = { loaded->volume.range[0], loaded->volume.range[1] };
    if (!(whole[0] < whole[1])) /* one value, or none at all */
        whole[1] = (whole[0] = isfinite(whole[0]) ? whole[0] : 0) + 1;
    if (map && !set_colormap(transfer, values->colormap, range ? values->range : whole, error))
        return tool_fail_in(error, "--colormap");
    if (curve && !pel_transfer_parse_opacity(transfer, values->opacity, error))
        return tool_fail_in(error, "--opacity");
    if (arguments_given(arguments, "unit-distance"))
        transfer->unit_distance = values->unit_distance;
    return true;
}

static bool set_isosurfaces(struct loaded_scene *loaded, const struct scene_arguments *values, bool said, struct pel_error *error)
{
    struct pel_scene *scene = &loaded->scene;
    int count = values->isovalues.count;
    if ((count > 0 || !said) && !pel_scene_choose(scene, &(struct pel_scene_parts) { .isosurfaces = true }, 0, 0, error))
        return false;
    if (count > 0) {
        scene->isosurface_count = count;
        for (int i = 0; i < count; i++) {
            struct pel_isosurface *surface = &scene->isosurfaces[i];
            *surface = scene->isosurfaces[0];
            surface->value = values->isovalues.items[i];
            if (count > 1)
                pel_transfer_color(&scene->transfer, surface->value, surface->color);
        }
    }
    count = scene->isosurface_count;
    if (values->iso_color_count > 1 && values->iso_color_count != count)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--iso-color: %d colours for %d isosurfaces", values->iso_color_count, count);
    if (values->iso_opacities.count > 1 && values->iso_opacities.count != count)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--iso-opacity: %d values for %d isosurfaces", values->iso_opacities.count, count);
    for (int i = 0; i < count; i++) {
        if (values->iso_color_count > 0)
            memcpy(scene->isosurfaces[i].color, values->iso_colors[values->iso_color_count > 1 ? i : 0],
                   sizeof scene->isosurfaces[i].color);
        if (values->iso_opacities.count > 0)
            scene->isosurfaces[i].opacity = values->iso_opacities.items[values->iso_opacities.count > 1 ? i : 0];
    }
    return true;
}

bool scene_set_surfaces(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                        const struct pel_scene_parts *has, struct pel_error *error)
{
    struct pel_scene *scene = &loaded->scene;
    if (scene->render.mode == PEL_MODE_ISOSURFACE && !set_isosurfaces(loaded, values, has->isosurfaces, error))
        return false;
    if (values->slice_count > 0)
        scene->more_slice_count = values->slice_count - 1;
    for (int i = 0; i < values->slice_count; i++) {
        struct pel_plane *plane = i ? &scene->more_slices[i - 1] : &scene->slice;
        memcpy(plane->origin, values->slices[i], sizeof plane->origin);
        memcpy(plane->normal, values->slices[i] + 3, sizeof plane->normal);
    }
    if (values->slice_count == 0 && !has->slice && !pel_scene_choose(scene, &(struct pel_scene_parts) { .slice = true }, 0, 0, error))
        return false;
    if (values->clip_plane_count > 0)
        scene->clip_plane_count = values->clip_plane_count;
    for (int i = 0; i < values->clip_plane_count; i++) {
        memcpy(scene->clip_planes[i].origin, values->clip_planes[i], sizeof scene->clip_planes[i].origin);
        memcpy(scene->clip_planes[i].normal, values->clip_planes[i] + 3, sizeof scene->clip_planes[i].normal);
    }
    if (arguments_given(arguments, "clip-box")) {
        scene->clip_box_enabled = true;
        memcpy(scene->clip_box, values->clip_box, sizeof scene->clip_box);
    }
    return true;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* True where b has no part square to a that could be told from rounding. */
static bool nearly_parallel(const double a[3], const double b[3])
{
    double ab = dot(a, b), aa = dot(a, a), bb = dot(b, b);
    return ab * ab > (1 - 1e-6) * aa * bb;
}

bool scene_set_camera(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                      const struct pel_scene_parts *has, struct pel_error *error)
{
    struct pel_camera *camera = &loaded->base_camera;
    *camera = loaded->scene.camera;
    if (!arguments_overlay(arguments, GROUP_CAMERA, camera, error)) /* the fit depends on the view angle */
        return false;
    bool placed = arguments_given(arguments, "camera-position") || arguments_given(arguments, "camera-focal-point");
    if (!has->camera) {
        struct pel_camera kept = loaded->scene.camera;
        loaded->scene.camera = *camera;
        if (placed) /* a slice is not faced then */
            pel_scene_fit_camera(&loaded->scene, values->size[0], values->size[1]);
        else if (!pel_scene_choose(&loaded->scene, &(struct pel_scene_parts) { .camera = true }, values->size[0], values->size[1], error))
            return false;
        *camera = loaded->scene.camera;
        loaded->scene.camera = kept;
    }
    if (!arguments_overlay(arguments, GROUP_CAMERA, camera, error))
        return false;
    double view[3] = { camera->focal_point[0] - camera->position[0], camera->focal_point[1] - camera->position[1],
                       camera->focal_point[2] - camera->position[2] };
    /* A view straight down is asked for by its position alone: what is up then is ours to choose. */
    if (placed && !arguments_given(arguments, "camera-view-up") && nearly_parallel(view, camera->view_up))
        memcpy(camera->view_up, nearly_parallel(view, (double[3]) { 0, 1, 0 }) ? (double[3]) { 0, 0, 1 } : (double[3]) { 0, 1, 0 },
               sizeof camera->view_up);
    if (!pel_camera_check(camera, error))
        return false;
    scene_move_camera(loaded, values, 0);
    return true;
}

void scene_move_camera(struct loaded_scene *loaded, const struct scene_arguments *values, double azimuth)
{
    struct pel_camera *camera = &loaded->scene.camera;
    double right[3], up[3], forward[3];
    *camera = loaded->base_camera;
    if (values->azimuth + azimuth != 0)
        pel_camera_azimuth(camera, values->azimuth + azimuth);
    if (values->elevation != 0) {
        /* The view-up follows, so that one may go over the pole. */
        pel_camera_basis(camera, right, up, forward);
        pel_camera_elevation(camera, values->elevation);
        for (int a = 0; a < 3; a++)
            forward[a] = camera->focal_point[a] - camera->position[a];
        for (int a = 0; a < 3; a++)
            camera->view_up[a] = right[(a + 1) % 3] * forward[(a + 2) % 3] - right[(a + 2) % 3] * forward[(a + 1) % 3];
    }
    if (values->roll != 0)
        pel_camera_roll(camera, values->roll);
    if (values->zoom != 1)
        pel_camera_zoom(camera, values->zoom);
}
