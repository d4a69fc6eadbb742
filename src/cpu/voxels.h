/* SPDX-License-Identifier: MIT */
/* Layer 1 of the CPU engine, shared by its techniques: the volume's samples as the kernels fetch them, and its min-max grid. Both change
 * with the volume alone. */
#ifndef PEL_CPU_VOXELS_H
#define PEL_CPU_VOXELS_H

#include "classify.h"
#include "kernel.h"
#include "minmax.h"

struct pel_voxels {
    const struct pel_volume *volume; /* borrowed */
    void *padded;                    /* owned copy of a volume too thin to fetch from, or NULL */
    struct pel_minmax minmax;
    struct pel_raw_scale raw;
    enum pel_kernel_kind kind;
};

/* Makes the grid (and the copy), and fills the parts of the job that describe voxels. The volume is borrowed until the next call. Refuses
 * volumes of more than 2^31 - 1 voxels: the lanes' offsets have 32 bits. */
bool pel_voxels_set(struct pel_voxels *voxels, const struct pel_volume *volume, int threads, struct pel_job *job, struct pel_error *error);
void pel_voxels_finish(struct pel_voxels *voxels); /* accepts a zeroed one */

/* Memory held beside the volume. */
size_t pel_voxels_bytes(const struct pel_voxels *voxels, const struct pel_job *job);

#endif
