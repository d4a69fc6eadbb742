/* SPDX-License-Identifier: MIT */
/* The second half of shear-warp: the intermediate image drawn into the picture, in two dimensions. */
#ifndef PEL_CPU_WARP_H
#define PEL_CPU_WARP_H

#include "shear.h"

/* Pixel (x, y) of the picture shows the place (u, v) / w of the intermediate image, u = u[0] + u[1] x + u[2] y and so on; in parallel
 * projection w is 1. */
struct pel_warp {
    double u[3], v[3], w[3];
    bool split;  /* draws only pixels whose rays are nearest to this principal axis, and leaves the others */
    int axis, sign;
};

/* Draws rows of the job's picture; with depth where job->depth and shear->depth are there. */
void pel_warp_row(const struct pel_job *job, const struct pel_shear *shear, const struct pel_warp *warp, int y);

#endif
