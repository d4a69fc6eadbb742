/* SPDX-License-Identifier: MIT */
/* From a scene's camera, clipping and lights to a job's rays and optics, in the volume's index space. */
#ifndef PEL_CPU_RAYS_H
#define PEL_CPU_RAYS_H

#include "kernel.h"

/* Fills the parts of the job that describe rays, clipping, lights, the metric and the settings. The volume is scene->volume. `jitter` as in
 * struct pel_job. */
void pel_rays_setup(struct pel_job *job, const struct pel_scene *scene, int jitter, int width, int height);

/* Octants of directions (distance_map.h) into which the job's rays go, a bit for each. */
unsigned pel_rays_octants(const struct pel_job *job);

/* The pixels whose rays can meet the box of index positions: [x0, x1) x [y0, y1) within the picture. False where there are none. */
bool pel_rays_rectangle(const struct pel_job *job, bool parallel, const double lo[3], const double hi[3], int rectangle[4]);

#endif
