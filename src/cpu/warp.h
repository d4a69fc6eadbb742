/* SPDX-License-Identifier: MIT */
/* The second half of shear-warp: the intermediate image drawn into the picture, in two dimensions. */
#ifndef PEL_CPU_WARP_H
#define PEL_CPU_WARP_H

#include "shear.h"

/* Pixel (x, y) of the picture shows the place (u, v) / w of the bordered intermediate image, u = u[0] + u[1] x + u[2] y and so on; in
 * parallel projection w is 1, in perspective it is above 0 wherever there is something to show. */
struct pel_warp {
    double u[3], v[3], w[3];
    double lo[2], hi[2]; /* only between these, in u and v, do four neighbouring rays hold anything */
    bool split;          /* draws only pixels whose rays are nearest to this principal axis, and leaves the others */
    int axis, sign;
};

/* Finds lo and hi from the rows that were composited. */
void pel_warp_bound(struct pel_warp *warp, const struct pel_shear *shear);

/* Split: does this part draw the pixel? */
bool pel_warp_belongs(const struct pel_job *job, const struct pel_warp *warp, int x, int y);

/* World distance at which opacity passes one half at the pixel, whose upper left ray is at `offset` in the image; +inf where it does not.
 */
float pel_warp_depth(const struct pel_job *job, const struct pel_shear *shear, int32_t offset, float fu, float fv, int x, int y);

#endif
