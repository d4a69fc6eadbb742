/* SPDX-License-Identifier: MIT */
/* Runs of cells that may be seen, for the scanlines of shear-warp: the marks of a classification as bits, in rows along the axis that
 * scanlines follow. Lacroute and Levoy encode runs of voxels once a transfer function; a bit a cell of 4^3 voxels is made in parts of a
 * millisecond, from marks that the min-max grid and the range table give. */
#ifndef PEL_CPU_SHEAR_RUNS_H
#define PEL_CPU_SHEAR_RUNS_H

#include "kernel.h"

struct pel_shear_runs {
    uint64_t *bits; /* owned; rows of `words` for each cell along axis[1], then axis[2] */
    size_t total;
    int words;
};

/* Makes the rows for these axes from the job's marks; all ones where nothing is to be skipped. */
bool pel_shear_runs_build(struct pel_shear_runs *runs, const struct pel_job *job, const int axis[3], int threads, struct pel_error *error);
void pel_shear_runs_finish(struct pel_shear_runs *runs); /* accepts a zeroed one */

#endif
