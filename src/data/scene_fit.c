/* SPDX-License-Identifier: MIT */
/* Fitting the camera to what a scene shows, instead of to the volume's box: scans leave wide margins of air. A few hundred thousand samples
 * of the volume stand for all; one in two hundred may be left outside at each side of each axis, so that specks of noise do not push the
 * object into the distance. */
#include <pellucid/scene.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "vec.h"

#define MOST_SAMPLES 400000
#define LEAST_POINTS 50 /* fewer say nothing about where the object is */

struct points {
    float (*at)[3]; /* index space */
    size_t count;
};

static bool is_shown(const struct pel_scene *scene, double value, double least_opacity)
{
    if (pel_volume_is_void(scene->volume, value) || !isfinite(value))
        return false;
    if (scene->render.mode != PEL_MODE_ISOSURFACE)
        return pel_transfer_opacity(&scene->transfer, value) > least_opacity;
    for (int i = 0; i < scene->isosurface_count; i++)
        if (value >= scene->isosurfaces[i].value)
            return true;
    return false;
}

static bool collect(const struct pel_scene *scene, struct points *points)
{
    const struct pel_volume *v = scene->volume;
    size_t stride = (size_t)ceil(cbrt((double)pel_volume_samples(v) / MOST_SAMPLES));
    stride = stride < 1 ? 1 : stride;
    double least = 0;
    for (size_t i = 0; i < scene->transfer.opacity_count; i++)
        least = fmax(least, 0.05 * scene->transfer.opacities[i].opacity);
    size_t most = 1;
    for (int a = 0; a < 3; a++)
        most *= v->dims[a] / stride + 1;
    points->at = pel_alloc(most, sizeof *points->at, "points", NULL);
    points->count = 0;
    for (size_t z = stride / 2; points->at && z < v->dims[2]; z += stride)
        for (size_t y = stride / 2; y < v->dims[1]; y += stride)
            for (size_t x = stride / 2; x < v->dims[0]; x += stride)
                if (is_shown(scene, pel_volume_get(v, x, y, z, 0), least))
                    memcpy(points->at[points->count++], (float[3]){ (float)x, (float)y, (float)z }, sizeof *points->at);
    return points->at && points->count >= LEAST_POINTS;
}

/* Drops the outermost two-hundredths along each axis. */
static bool trim(const struct pel_volume *volume, struct points *points)
{
    for (int a = 0; a < 3; a++) {
        size_t *bins = pel_alloc(volume->dims[a], sizeof *bins, "bins", NULL), drop = points->count / 200, kept = 0;
        if (!bins)
            return false;
        for (size_t i = 0; i < points->count; i++)
            bins[(size_t)points->at[i][a]]++;
        size_t first = 0, last = volume->dims[a] - 1;
        for (size_t sum = bins[first]; sum <= drop && first < last; sum += bins[first])
            first++;
        for (size_t sum = bins[last]; sum <= drop && last > first; sum += bins[last])
            last--;
        free(bins);
        for (size_t i = 0; i < points->count; i++)
            if (points->at[i][a] >= (float)first && points->at[i][a] <= (float)last)
                memmove(points->at[kept++], points->at[i], sizeof *points->at);
        points->count = kept;
    }
    return points->count > 0;
}

void pel_scene_fit_camera(struct pel_scene *scene, int width, int height)
{
    struct pel_camera *camera = &scene->camera;
    struct points points = { NULL, 0 };
    pel_camera_fit(camera, scene->volume, width, height);
    enum pel_mode mode = scene->render.mode;
    bool whole = mode == PEL_MODE_MINIP || mode == PEL_MODE_AVERAGE || mode == PEL_MODE_SLICE;
    if (whole || !collect(scene, &points) || !trim(scene->volume, &points)) {
        free(points.at);
        return;
    }
    double basis[3][3], lo[3] = { INFINITY, INFINITY, INFINITY }, hi[3] = { -INFINITY, -INFINITY, -INFINITY };
    pel_camera_basis(camera, basis[0], basis[1], basis[2]);
    for (size_t i = 0; i < points.count; i++) {
        double world[3], index[3] = { points.at[i][0], points.at[i][1], points.at[i][2] };
        pel_volume_index_to_world(scene->volume, index, world);
        for (int a = 0; a < 3; a++) {
            double along = pel_dot(world, basis[a]);
            points.at[i][a] = (float)along;
            lo[a] = fmin(lo[a], along);
            hi[a] = fmax(hi[a], along);
        }
    }
    double aspect = (double)width / height, ty = tan(camera->view_angle / 360 * 3.14159265358979323846) * 0.88, tx = ty * aspect,
           distance = 0, scale = 0;
    double middle[3] = { (lo[0] + hi[0]) / 2, (lo[1] + hi[1]) / 2, (lo[2] + hi[2]) / 2 };
    for (size_t i = 0; i < points.count; i++) {
        double x = fabs(points.at[i][0] - middle[0]), y = fabs(points.at[i][1] - middle[1]), z = points.at[i][2] - middle[2];
        distance = fmax(distance, fmax(x / tx, y / ty) - z);
        scale = fmax(scale, fmax(x / aspect, y) / 0.88);
    }
    free(points.at);
    distance = fmax(distance, (hi[2] - lo[2]) / 2 * 1.05 + pel_volume_mean_spacing(scene->volume));
    for (int i = 0; i < 3; i++) {
        camera->focal_point[i] = middle[0] * basis[0][i] + middle[1] * basis[1][i] + middle[2] * basis[2][i];
        camera->position[i] = camera->focal_point[i] - distance * basis[2][i];
    }
    camera->parallel_scale = fmax(scale, pel_volume_mean_spacing(scene->volume));
}
