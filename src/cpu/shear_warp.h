/* SPDX-License-Identifier: MIT */
/* Shear-warp on the CPU engine: emission and absorption by object-aligned slices (paper 003, section 4, after Lacroute and Levoy 1994).
 *
 * The layers are those of the ray caster (raycast.h): volume, classification, view. It draws mode composite with post-classification. */
#ifndef PEL_CPU_SHEAR_WARP_H
#define PEL_CPU_SHEAR_WARP_H

#include <pellucid/image.h>
#include <pellucid/scene.h>

#include "shear_factor.h"

struct pel_shear_warp;

/* As for the ray caster. */
struct pel_shear_warp *pel_shear_warp_create(int threads, const char *isa, struct pel_error *error);
void pel_shear_warp_destroy(struct pel_shear_warp *warper); /* accepts NULL */
const char *pel_shear_warp_isa(const struct pel_shear_warp *warper);
bool pel_shear_warp_set_volume(struct pel_shear_warp *warper, const struct pel_volume *volume, struct pel_error *error);
bool pel_shear_warp_classify(struct pel_shear_warp *warper, const struct pel_scene *scene, struct pel_error *error);

/* After a change of the step alone: the tables' unit of length, which nothing else here depends on. */
bool pel_shear_warp_set_step(struct pel_shear_warp *warper, const struct pel_scene *scene, struct pel_error *error);

/* Factors the view. `linear`: opacity is corrected for the slices' distance by the paper's linear approximation (section 4), not exactly.
 */
bool pel_shear_warp_aim(struct pel_shear_warp *warper, const struct pel_scene *scene, const struct pel_shear_settings *settings,
                        bool linear, int width, int height, struct pel_error *error);

struct pel_shear_counters {
    uint64_t in_box, taken; /* samples of the rays' stretches inside the box; samples taken */
    uint64_t rays, slices;  /* pixels of the intermediate images; slices composited */
    uint64_t cells, visible_cells;
    uint64_t bytes; /* memory held beside the volume */
};

/* Draws, in two stages whose ends are told in `stage_ms`: the slices composited, and the warp. */
bool pel_shear_warp_draw(struct pel_shear_warp *warper, const struct pel_scene *scene, const struct pel_progress *progress,
                         struct pel_image *image, struct pel_shear_counters *counters, double stage_ms[2], struct pel_error *error);

#endif
