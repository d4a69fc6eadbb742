/* SPDX-License-Identifier: MIT */
/* Pick: what a point of a picture shows, and where in the volume that is. In double precision, on the reconstructed signal (docs/optics.md),
 * whatever technique drew the picture. */
#ifndef PELLUCID_PICK_H
#define PELLUCID_PICK_H

#include <pellucid/scene.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct pel_pick {
    bool inside;     /* the ray goes through what clipping leaves of the volume */
    bool hit;        /* something is met; else what follows is 0 */
    double world[3]; /* where */
    double index[3]; /* the same in voxels, fractions allowed */
    double value;    /* the reconstructed value there; NaN where it is void */
    double distance; /* world length from where the ray starts (pel_camera_ray) */
};

/* Looks along the ray through the point (x, y) of a picture of width x height pixels, in pixels: (0, 0) is its upper left corner, (0.5, 0.5) the
 * centre of its first pixel. Composite: the first sample with which the opacity along the ray reaches `opacity`, above 0 to 1. Isosurface and
 * slice: the first surface or plane that is met and not wholly transparent. MIP and MinIP: the sample that is shown; of average and X-ray, which show no place, the
 * greatest sample. Fails as pel_scene_check does, and for a point, size or opacity that is none. */
bool pel_scene_pick(const struct pel_scene *scene, int width, int height, double x, double y, double opacity, struct pel_pick *pick,
                    struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
