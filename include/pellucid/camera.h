/* SPDX-License-Identifier: MIT */
/* Camera: VTK's words and VTK's meaning, so that a VTK or ParaView view can be copied number by number. */
#ifndef PELLUCID_CAMERA_H
#define PELLUCID_CAMERA_H

#include <pellucid/option.h>
#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct pel_camera {
    double position[3];
    double focal_point[3];
    double view_up[3];     /* need not be unit or square to the view; must not be parallel to it */
    double view_angle;     /* full vertical angle of a perspective view, degrees, 0 < a < 180 */
    bool parallel;         /* parallel projection instead of perspective */
    double parallel_scale; /* half the height of a parallel view, world length, > 0 */
};

#define PEL_CAMERA_INIT { { 0, -5, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 30.0, false, 1.0 }

/* Option rows of struct pel_camera: camera-position, camera-focal-point, camera-view-up, camera-view-angle, parallel, parallel-scale. */
extern const struct pel_option pel_camera_options[];

/* Places the camera so that the whole volume is seen: from the front with the head up where the world axes have a
 * meaning (looking at the face), else from -y with +z up; then turned 30 degrees about the view-up and raised 20, so that depth shows.
 * width and height are the picture's, in pixels. Sets the parallel scale too; leaves view_angle and parallel as they are. */
void pel_camera_fit(struct pel_camera *camera, const struct pel_volume *volume, int width, int height);

/* VTK's moves: azimuth turns the position about the view-up through the focal point; elevation about the view's right;
 * roll turns the view-up about the view direction. Degrees. Zoom > 1 narrows the view angle (perspective) or the parallel scale. */
void pel_camera_azimuth(struct pel_camera *camera, double degrees);
void pel_camera_elevation(struct pel_camera *camera, double degrees);
void pel_camera_roll(struct pel_camera *camera, double degrees);
void pel_camera_zoom(struct pel_camera *camera, double factor);

/* Orthonormal basis: right, up and forward (towards the focal point). */
void pel_camera_basis(const struct pel_camera *camera, double right[3], double up[3], double forward[3]);

/* The ray through the centre of pixel (x, y), row 0 at the top. direction is unit length in the world; in a perspective view origin is the
 * camera's position, in a parallel one the point on the plane through the position. */
void pel_camera_ray(const struct pel_camera *camera, int width, int height, double x, double y, double origin[3], double direction[3]);

/* Refuses what cannot be a view: non-finite numbers, position on the focal point, view-up along the view, an angle out of range. */
bool pel_camera_check(const struct pel_camera *camera, struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
