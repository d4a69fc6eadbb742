/* SPDX-License-Identifier: MIT */
/* A job's rays as a projection: what vertex shaders need to put an index position where the rays of its pixel go. */
#ifndef PEL_RENDER_GPU_VIEW_H
#define PEL_RENDER_GPU_VIEW_H

#include "kernel.h"

struct pel_gpu_view {
    float clip_x[4], clip_y[4], clip_w[4]; /* clip coordinates of an index position p: dot(xyz, p) + w */
    double depth[4];                       /* its view depth, likewise: times the length of a pixel's Dw it is the distance along the ray */
    double eye[3];                         /* index position of the eye; in parallel, of the first pixel's ray where s is 0 */
};

/* False where the picture plane is no plane. */
bool pel_gpu_view_setup(struct pel_gpu_view *view, const struct pel_job *job, bool parallel);

#endif
