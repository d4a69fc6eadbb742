/* SPDX-License-Identifier: MIT */
/* The camera, with vtkCamera's formulas: azimuth and elevation move the position and leave the view-up, roll turns the view-up. */
#include <pellucid/camera.h>

#include <float.h>
#include <math.h>
#include <string.h>

#include "fail.h"
#include "vec.h"

#define RADIANS (3.14159265358979323846 / 180)
#define LEAST_ANGLE 0.001
#define MOST_ANGLE 179.9

const struct pel_option pel_camera_options[] = {
    { "camera-position", "Camera position", "Where the camera stands in the world; chosen so that the whole volume is seen unless given",
      PEL_OPTION_VEC3, offsetof(struct pel_camera, position), -1e100, 1e100, NULL, NULL, "world length" },
    { "camera-focal-point", "Focal point",
      "The point of the world that the camera looks at and turns about; the volume's centre unless given", PEL_OPTION_VEC3,
      offsetof(struct pel_camera, focal_point), -1e100, 1e100, NULL, NULL, "world length" },
    { "camera-view-up", "View-up", "The world direction that points up in the picture; must not lie along the view", PEL_OPTION_VEC3,
      offsetof(struct pel_camera, view_up), -1e100, 1e100, NULL, NULL, NULL },
    { "camera-view-angle", "View angle", "Full vertical angle of a perspective view", PEL_OPTION_DOUBLE,
      offsetof(struct pel_camera, view_angle), LEAST_ANGLE, MOST_ANGLE, "30", NULL, "degrees" },
    { "parallel", "Parallel projection", "Parallel projection instead of perspective", PEL_OPTION_BOOL,
      offsetof(struct pel_camera, parallel), 0, 1, "false", NULL, NULL },
    { "parallel-scale", "Parallel scale", "Half the height of a parallel view; chosen so that the whole volume is seen unless given",
      PEL_OPTION_DOUBLE, offsetof(struct pel_camera, parallel_scale), 1e-100, 1e100, NULL, NULL, "world length" },
    { NULL },
};

void pel_camera_basis(const struct pel_camera *camera, double right[3], double up[3], double forward[3])
{
    pel_sub(camera->focal_point, camera->position, forward);
    pel_normalize(forward);
    double view_up[3] = { camera->view_up[0], camera->view_up[1], camera->view_up[2] };
    pel_normalize(view_up); /* first, so that a tiny or huge view-up does not spoil the cross product */
    pel_cross(forward, view_up, right);
    pel_normalize(right);
    pel_cross(right, forward, up);
}

/* Turns the position about a unit axis through the focal point. */
static void orbit(struct pel_camera *camera, const double axis[3], double degrees)
{
    double arm[3];
    pel_sub(camera->position, camera->focal_point, arm);
    pel_rotate(arm, axis, degrees, arm);
    for (int i = 0; i < 3; i++)
        camera->position[i] = camera->focal_point[i] + arm[i];
}

void pel_camera_azimuth(struct pel_camera *camera, double degrees)
{
    double axis[3] = { camera->view_up[0], camera->view_up[1], camera->view_up[2] };
    pel_normalize(axis);
    orbit(camera, axis, degrees);
}

void pel_camera_elevation(struct pel_camera *camera, double degrees)
{
    double right[3], up[3], forward[3];
    pel_camera_basis(camera, right, up, forward);
    double axis[3] = { -right[0], -right[1], -right[2] };
    orbit(camera, axis, degrees);
}

void pel_camera_roll(struct pel_camera *camera, double degrees)
{
    double forward[3];
    pel_sub(camera->focal_point, camera->position, forward);
    pel_normalize(forward);
    pel_rotate(camera->view_up, forward, degrees, camera->view_up);
}

void pel_camera_zoom(struct pel_camera *camera, double factor)
{
    if (!(factor > 0) || !isfinite(factor))
        return;
    if (camera->parallel)
        camera->parallel_scale /= factor;
    else
        camera->view_angle = pel_clamp(camera->view_angle / factor, LEAST_ANGLE, MOST_ANGLE);
}

/* The eight corners of the volume's own box (not of its world bounds, which a turned grid does not fill), relative to their mean. */
static void box_corners(const struct pel_volume *volume, double corners[8][3], double centre[3])
{
    for (int i = 0; i < 3; i++)
        centre[i] = 0;
    for (int corner = 0; corner < 8; corner++) {
        double index[3];
        for (int a = 0; a < 3; a++) {
            double last = volume->dims[a] > 1 ? (double)(volume->dims[a] - 1) : 0.5;
            index[a] = corner >> a & 1 ? last : volume->dims[a] > 1 ? 0 : -0.5;
        }
        pel_volume_index_to_world(volume, index, corners[corner]);
        for (int i = 0; i < 3; i++)
            centre[i] += corners[corner][i] / 8;
    }
    for (int corner = 0; corner < 8; corner++)
        pel_sub(corners[corner], centre, corners[corner]);
}

/* The camera looks at the centre from the distance at which the outermost corner lies at 90 % of the way from the middle of the picture
 * to its nearer edge. A corner (x, y, z) in the view's basis is seen from the distance d at x / (d + z), to be held against the tangent of
 * half the view angle. */
void pel_camera_fit(struct pel_camera *camera, const struct pel_volume *volume, int width, int height)
{
    const double fill = 0.9;
    double corners[8][3], centre[3], right[3], up[3], forward[3], radius = 0;
    double aspect = (double)(width > 0 ? width : 1) / (height > 0 ? height : 1);
    box_corners(volume, corners, centre);
    for (int i = 0; i < 8; i++)
        radius = fmax(radius, pel_length(corners[i]));
    memcpy(camera->focal_point, centre, sizeof centre);
    memcpy(camera->position, centre, sizeof centre);
    camera->position[1] += volume->space == PEL_SPACE_RAS ? radius : -radius; /* anterior is +y in RAS, -y in LPS */
    memcpy(camera->view_up, (double[3]){ 0, 0, 1 }, sizeof camera->view_up);
    pel_camera_azimuth(camera, 30);
    pel_camera_elevation(camera, 20);
    pel_camera_basis(camera, right, up, forward);

    double ty = tan(pel_clamp(camera->view_angle, LEAST_ANGLE, MOST_ANGLE) / 2 * RADIANS) * fill, tx = ty * aspect;
    double distance = radius * 1.05, scale = 0; /* never inside the box */
    for (int i = 0; i < 8; i++) {
        double x = fabs(pel_dot(corners[i], right)), y = fabs(pel_dot(corners[i], up)), z = pel_dot(corners[i], forward);
        distance = fmax(distance, fmax(x / tx, y / ty) - z);
        scale = fmax(scale, fmax(x / aspect, y) / fill);
    }
    for (int i = 0; i < 3; i++)
        camera->position[i] = centre[i] - forward[i] * distance;
    camera->parallel_scale = scale;
}

void pel_camera_ray(const struct pel_camera *camera, int width, int height, double x, double y, double origin[3], double direction[3])
{
    double right[3], up[3], forward[3];
    pel_camera_basis(camera, right, up, forward);
    double half = camera->parallel ? camera->parallel_scale : tan(camera->view_angle / 2 * RADIANS);
    double v = (1 - 2 * (y + 0.5) / height) * half, u = (2 * (x + 0.5) / width - 1) * half * width / height;
    for (int i = 0; i < 3; i++) {
        double aside = u * right[i] + v * up[i];
        origin[i] = camera->position[i] + (camera->parallel ? aside : 0);
        direction[i] = forward[i] + (camera->parallel ? 0 : aside);
    }
    pel_normalize(direction);
}

bool pel_camera_check(const struct pel_camera *camera, struct pel_error *error)
{
    for (int i = 0; i < 3; i++)
        if (!(fabs(camera->position[i]) <= 1e100 && fabs(camera->focal_point[i]) <= 1e100 && fabs(camera->view_up[i]) <= 1e100))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "camera: position, focal point and view-up must be finite numbers");
    double forward[3], up[3] = { camera->view_up[0], camera->view_up[1], camera->view_up[2] }, across[3];
    pel_sub(camera->focal_point, camera->position, forward);
    if (!(pel_normalize(forward) > 0))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "camera: the position lies on the focal point; move one of them");
    if (!(pel_normalize(up) > 0))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "camera: the view-up has no length");
    pel_cross(forward, up, across);
    if (!(pel_length(across) > 1e-6))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "camera: the view-up lies along the view; choose another");
    if (!(camera->view_angle >= LEAST_ANGLE && camera->view_angle <= MOST_ANGLE))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "camera: a view angle of %g degrees; it must be from %g to %g", camera->view_angle,
                        LEAST_ANGLE, MOST_ANGLE);
    if (!(camera->parallel_scale > 0 && camera->parallel_scale <= 1e100))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "camera: a parallel scale of %g; it must be positive", camera->parallel_scale);
    return true;
}
