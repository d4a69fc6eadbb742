/* SPDX-License-Identifier: MIT */
/* The double-precision reference: docs/optics.md word for word, plain, slow, obviously right. */
#ifndef PEL_CPU_REFERENCE_H
#define PEL_CPU_REFERENCE_H

#include <stdint.h>

#include <pellucid/image.h>
#include <pellucid/scene.h>

/* Draws into `image` (allocated; depth filled where it has one). Rows are shared among threads; the bytes do not depend on how many. The
 * scene has passed pel_scene_check. `jitter`: 0 for none, else 1 + the frame's number (jitter.h).
 * `samples` (nullable) gets the number of samples taken. Settings that only make things faster (skip) are
 * ignored; termination is ignored too: the whole integral is computed. */
bool pel_reference_draw(const struct pel_scene *scene, int jitter, int threads, const struct pel_progress *progress,
                        struct pel_image *image, uint64_t *samples, struct pel_error *error);

/* What the pixel (x, y), fractions allowed, of such a picture shows first: of a composite the sample with which the ray's opacity reaches
 * `opacity`, else the place of its depth. */
struct pel_reference_pick {
    bool inside, valued;       /* the ray meets what is drawn of the volume; something is seen there, and has a value */
    double distance;           /* along the ray, INFINITY where nothing is seen; then the rest means nothing */
    double world[3], index[3], value;
};
bool pel_reference_pick(const struct pel_scene *scene, int width, int height, double x, double y, double opacity, struct pel_reference_pick *pick,
                        struct pel_error *error);

#endif
