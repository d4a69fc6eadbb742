/* SPDX-License-Identifier: MIT */
/* From a scene's camera, clipping and lights to a job's rays and optics, in the volume's index space. */
#ifndef PEL_CPU_RAYS_H
#define PEL_CPU_RAYS_H

#include "kernel.h"

/* Fills the parts of the job that describe rays, clipping, lights and the metric. The volume is scene->volume. */
void pel_rays_setup(struct pel_job *job, const struct pel_scene *scene, int width, int height);

#endif
