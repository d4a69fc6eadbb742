/* SPDX-License-Identifier: MIT */
/* Moves of the camera: VTK's trackball (vtkInteractorStyleTrackballCamera), in fractions of the picture, so that pages of any size move
 * alike. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "session_inside.h"

#define RADIANS (3.14159265358979323846 / 180)

static bool take(struct call *call, const struct pel_camera *camera)
{
    if (!pel_camera_check(camera, call->error))
        return false;
    call->session->scene.camera = *camera;
    return true;
}

static double distance(const struct pel_camera *camera)
{
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += pow(camera->position[i] - camera->focal_point[i], 2);
    return sqrt(sum);
}

/* World width and height of the picture in the plane of the focal point. */
static void focal_plane(const struct session *s, const struct pel_camera *camera, double size[2])
{
    size[1] = 2 * (camera->parallel ? camera->parallel_scale : distance(camera) * tan(camera->view_angle / 2 * RADIANS));
    size[0] = size[1] * s->size[0] / s->size[1];
}

static void shift(struct pel_camera *camera, double right_by, double up_by)
{
    double right[3], up[3], forward[3];
    pel_camera_basis(camera, right, up, forward);
    for (int i = 0; i < 3; i++) {
        double by = right_by * right[i] + up_by * up[i];
        camera->position[i] += by;
        camera->focal_point[i] += by;
    }
}

bool run_rotate(struct call *call)
{
    struct pel_camera camera = call->session->scene.camera;
    double by[2], right[3], up[3], forward[3];
    if (!call_numbers(call, "by", 2, by))
        return false;
    if (fabs(by[0]) > 1e3 || fabs(by[1]) > 1e3)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "by: no more than 1000 pictures at once");
    pel_camera_azimuth(&camera, -200 * by[0]);
    pel_camera_elevation(&camera, 200 * by[1]);
    pel_camera_basis(&camera, right, up, forward); /* the view-up follows, so that one may go over the pole */
    memcpy(camera.view_up, up, sizeof up);
    return take(call, &camera);
}

bool run_pan(struct call *call)
{
    struct pel_camera camera = call->session->scene.camera;
    double by[2], size[2];
    if (!call_numbers(call, "by", 2, by))
        return false;
    focal_plane(call->session, &camera, size);
    shift(&camera, -by[0] * size[0], by[1] * size[1]);
    return take(call, &camera);
}

bool run_zoom(struct call *call)
{
    struct pel_camera camera = call->session->scene.camera;
    double by, at[2] = { 0.5, 0.5 }, size[2];
    if (!call_number(call, "by", 1e-6, 1e6, &by) || (call_has(call, "at") && !call_numbers(call, "at", 2, at)))
        return false;
    focal_plane(call->session, &camera, size);
    if (camera.parallel)
        camera.parallel_scale /= by;
    else
        for (int i = 0; i < 3; i++)
            camera.position[i] = camera.focal_point[i] + (camera.position[i] - camera.focal_point[i]) / by;
    shift(&camera, (at[0] - 0.5) * size[0] * (1 - 1 / by), (0.5 - at[1]) * size[1] * (1 - 1 / by));
    return take(call, &camera);
}

bool run_roll(struct call *call)
{
    struct pel_camera camera = call->session->scene.camera;
    double by;
    if (!call_number(call, "by", -1e6, 1e6, &by))
        return false;
    pel_camera_roll(&camera, by);
    return take(call, &camera);
}

bool run_focus(struct call *call)
{
    struct pel_camera camera = call->session->scene.camera;
    struct pel_pick pick;
    if (!session_pick(call, 0.1, &pick))
        return false;
    if (!pick.hit)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "there is nothing to be seen at that point; choose one on the object");
    for (int i = 0; i < 3; i++) {
        camera.position[i] += pick.world[i] - camera.focal_point[i];
        camera.focal_point[i] = pick.world[i];
    }
    return take(call, &camera);
}

/* Moves the camera along its view until the volume's whole box is seen: each corner (x, y, z) in the view's basis is seen at x / (d + z)
 * from the distance d. */
static void see_all(const struct session *s, struct pel_camera *camera)
{
    const double fill = 0.9;
    const struct pel_volume *volume = s->scene.volume;
    double right[3], up[3], forward[3], bounds[6], aspect = (double)s->size[0] / s->size[1], far = 0, scale = 0;
    double ty = tan(camera->view_angle / 2 * RADIANS) * fill, tx = ty * aspect;
    pel_camera_basis(camera, right, up, forward);
    pel_volume_bounds(volume, bounds);
    for (int corner = 0; corner < 8; corner++) {
        double index[3], world[3], x = 0, y = 0, z = 0;
        for (int a = 0; a < 3; a++) {
            double last = volume->dims[a] > 1 ? (double)(volume->dims[a] - 1) : 0.5;
            index[a] = corner >> a & 1 ? last : volume->dims[a] > 1 ? 0 : -0.5;
        }
        pel_volume_index_to_world(volume, index, world);
        for (int a = 0; a < 3; a++) {
            double from = world[a] - camera->focal_point[a];
            x += from * right[a];
            y += from * up[a];
            z += from * forward[a];
        }
        far = fmax(far, fmax(fabs(x) / tx, fabs(y) / ty) - z);
        scale = fmax(scale, fmax(fabs(x) / aspect, fabs(y)) / fill);
    }
    for (int a = 0; a < 3; a++)
        camera->position[a] = camera->focal_point[a] - forward[a] * far;
    camera->parallel_scale = scale;
}

bool run_view(struct call *call)
{
    static const char *const names[] = { "+x", "-x", "+y", "-y", "+z", "-z" };
    struct session *s = call->session;
    struct pel_camera camera = s->scene.camera;
    const char *name = call_text(call, "axis", 3);
    double bounds[6];
    int axis = 0;
    while (name && axis < 6 && strcmp(name, names[axis]) != 0)
        axis++;
    if (!name || axis == 6)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "axis: it must be +x, -x, +y, -y, +z or -z");
    pel_volume_bounds(s->scene.volume, bounds);
    for (int a = 0; a < 3; a++)
        camera.position[a] = camera.focal_point[a] = 0.5 * bounds[2 * a] + 0.5 * bounds[2 * a + 1];
    camera.position[axis / 2] += axis % 2 ? -1 : 1;
    memcpy(camera.view_up, (double[3]) { 0, 0, 1 }, sizeof camera.view_up);
    if (axis / 2 == 2) /* a patient's front is up: +y in RAS, -y in LPS */
        memcpy(camera.view_up, (double[3]) { 0, s->scene.volume->space == PEL_SPACE_LPS ? -1 : 1, 0 }, sizeof camera.view_up);
    see_all(s, &camera);
    return take(call, &camera);
}

/* The whole box, not what pel_scene_fit_camera finds to be shown: who turns a volume, or cuts it, wants no part of it to leave the picture.
 */
void session_fit_camera(const struct session *s, struct pel_camera *camera)
{
    struct pel_scene scene = s->scene; /* of which only the camera is changed */
    if (scene.render.mode == PEL_MODE_SLICE) {
        scene.camera = *camera;
        if (pel_scene_choose(&scene, &(struct pel_scene_parts) { .camera = true }, s->size[0], s->size[1], NULL))
            *camera = scene.camera;
    } else {
        pel_camera_fit(camera, scene.volume, s->size[0], s->size[1]);
    }
}

static bool same_camera(const struct pel_camera *a, const struct pel_camera *b)
{
    return memcmp(a, b, offsetof(struct pel_camera, parallel)) == 0 && a->parallel == b->parallel && a->parallel_scale == b->parallel_scale;
}

void session_fit_again(struct session *s)
{
    if (!s->volume || !s->start_fitted || !same_camera(&s->scene.camera, &s->start))
        return;
    session_fit_camera(s, &s->start);
    s->scene.camera = s->start;
}

bool run_reset(struct call *call)
{
    struct session *s = call->session;
    struct pel_camera camera = s->start;
    if (s->start_fitted)
        session_fit_camera(s, &camera);
    return take(call, &camera);
}
