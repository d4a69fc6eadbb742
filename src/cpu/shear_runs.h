/* SPDX-License-Identifier: MIT */
/* Runs of what may be seen, for the scanlines of shear-warp, as bits in rows along the axis that scanlines follow: a bit a cell of 4^3 voxels,
 * which are the marks of a classification; and, within these cells, a bit a patch, the square between 2 x 2 voxels of one slice
 * (kernel_patches.h). Lacroute and Levoy encode runs of voxels once a transfer function and view axis, looking at all of them; here the min-max
 * grid and the range table leave few to look at. */
#ifndef PEL_CPU_SHEAR_RUNS_H
#define PEL_CPU_SHEAR_RUNS_H

#include "kernel.h"

struct pel_shear_runs {
    uint64_t *bits; /* owned; rows of `words` for each cell along axis[1], then axis[2] */
    size_t total;
    int words;
    uint8_t *seen; /* owned; rows of `row` bytes for each voxel along axis[1], then axis[2], and 8 bytes more */
    size_t seen_bytes, row;
};

/* Makes the rows for these axes from the job's marks; all ones where nothing is to be skipped. */
bool pel_shear_runs_build(struct pel_shear_runs *runs, const struct pel_job *job, const int axis[3], int threads, struct pel_error *error);
/* Makes the rows of patches. Not for voxels of the kind WIDE, and not where some are void. */
bool pel_shear_runs_patches(struct pel_shear_runs *runs, const struct pel_job *job, pel_patch_kernel kernel, const int axis[3], int threads,
                            struct pel_error *error);
void pel_shear_runs_finish(struct pel_shear_runs *runs); /* accepts a zeroed one */

#endif
