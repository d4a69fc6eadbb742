/* SPDX-License-Identifier: MIT */
/* The SIMD ray caster: docs/optics.md in float lanes, passing over what cannot be seen.
 *
 * What it keeps between frames comes in three layers, each rebuilt only when its source changed: the min-max grid (volume), the
 * classification (transfer function, isovalues, step: look-up tables and the cells that may be seen), the rays (camera, size, clipping:
 * span masks and distance maps). */
#ifndef PEL_CPU_RAYCAST_H
#define PEL_CPU_RAYCAST_H

#include <stdint.h>

#include <pellucid/image.h>
#include <pellucid/scene.h>

struct pel_raycaster;

/* `threads` as in pel_threads; `isa` (nullable) forces an instruction set by name. */
struct pel_raycaster *pel_raycaster_create(int threads, const char *isa, struct pel_error *error);
void pel_raycaster_destroy(struct pel_raycaster *raycaster); /* accepts NULL */

/* "x86-64-v3" */
const char *pel_raycaster_isa(const struct pel_raycaster *raycaster);

/* Layer 1: the volume's min-max grid, and a padded copy of a volume too thin for the kernels' fetches. The volume is borrowed until the
 * next call. Refuses volumes of more than 2^31 - 1 voxels: the lanes' offsets have 32 bits. */
bool pel_raycaster_set_volume(struct pel_raycaster *raycaster, const struct pel_volume *volume, struct pel_error *error);

/* Layer 2: tables and marks of visible cells for the scene's transfer function, isosurfaces and settings. */
bool pel_raycaster_classify(struct pel_raycaster *raycaster, const struct pel_scene *scene, struct pel_error *error);

/* The part of layer 2 that the step alone decides: the tables. Which cells may be seen does not hang on it. */
bool pel_raycaster_set_step(struct pel_raycaster *raycaster, const struct pel_scene *scene, struct pel_error *error);

struct pel_raycast_counters {
    uint64_t in_box, taken; /* samples in the stretches of the rays that were cast; samples taken */
    uint64_t culled;        /* rays that were not cast: nothing in their pixels */
    uint64_t cells, visible_cells;
    uint64_t bytes; /* memory held beside the volume */
};

/* Layer 3: rays for a picture of this size, the cells that may be seen projected onto it, and distance maps for the directions in which its
 * rays go. `jitter`: 0 for none, else 1 + the frame's number (jitter.h). */
bool pel_raycaster_aim(struct pel_raycaster *raycaster, const struct pel_scene *scene, int jitter, int width, int height,
                       struct pel_error *error);

/* Draws. The scene has passed pel_scene_check and is the one that was classified and aimed at. */
bool pel_raycaster_draw(struct pel_raycaster *raycaster, const struct pel_scene *scene, const struct pel_progress *progress,
                        struct pel_image *image, struct pel_raycast_counters *counters, struct pel_error *error);

#endif
