/* SPDX-License-Identifier: MIT */
/* The factored view: from a job's rays to a shear along a principal axis and a warp of the plane (Lacroute and Levoy 1994). */
#ifndef PEL_CPU_SHEAR_FACTOR_H
#define PEL_CPU_SHEAR_FACTOR_H

#include "shear.h"
#include "warp.h"

enum pel_intermediate {
    PEL_INTERMEDIATE_VOXEL,   /* rays are as far apart as voxels */
    PEL_INTERMEDIATE_PICTURE, /* rays are as far apart as pixels of the picture */
};

struct pel_shear_settings {
    int supersampling, every; /* slices a slice of voxels, 1 to 10, and one of these for so many */
    enum pel_intermediate intermediate;
    double rays;  /* of the intermediate image, a voxel or pixel along each axis */
    double blend; /* degrees about the switch from one axis to another in which both are drawn and mixed; 0: none */
};

#define PEL_SHEAR_PARTS 6

/* The principal axes that the picture needs, each as 2 * axis, + 1 where rays go against it. One in most views. Perspective so wide that
 * rays of one picture are nearest to different axes takes several: each ray belongs to the axis that is nearest to it. */
int pel_shear_parts(const struct pel_job *job, bool perspective, int parts[PEL_SHEAR_PARTS]);

/* The same, and within `blend` degrees about the switch from one axis to another both, with weights that add up to 1, unless the picture is
 * `split` anyway. */
int pel_shear_parts_blended(const struct pel_job *job, bool perspective, double blend, int parts[PEL_SHEAR_PARTS],
                            double weights[PEL_SHEAR_PARTS], bool *split);

/* Factors the view along one of them: fills everything in `shear` but the runs, the slices' array and the image, and in `warp` the way from
 * the picture to the intermediate image. `split`: the picture has several parts. False where the intermediate image would be too large. */
bool pel_shear_factor(const struct pel_job *job, bool perspective, const struct pel_shear_settings *settings, int part, bool split,
                      struct pel_shear *shear, struct pel_warp *warp, struct pel_error *error);

/* Fills shear->slice_count slices. */
void pel_shear_slices(const struct pel_job *job, const struct pel_shear_settings *settings, const struct pel_shear *shear,
                      struct pel_slice *slices);

#endif
