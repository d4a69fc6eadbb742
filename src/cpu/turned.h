/* SPDX-License-Identifier: MIT */
/* A turned copy of the volume, y fastest, then x, then z: rows of voxels for scanlines that run along y, where the principal axis is x. Only
 * cells that may be seen, and those beside them, are ever turned, once each; of the memory for the rest the system gives none, where it
 * gives pages as they are written. */
#ifndef PEL_CPU_TURNED_H
#define PEL_CPU_TURNED_H

#include "kernel.h"

struct pel_turned {
    void *voxels;  /* owned, as is `done` */
    uint8_t *done; /* a byte a cell */
    size_t bytes;
    ptrdiff_t next_row, next_slice; /* from z to z and from x to x, in voxels */
};

/* Turns what the job's marks call for and is not turned yet; everything where nothing is skipped. Not for voxels of the kind WIDE. */
bool pel_turned_update(struct pel_turned *turned, const struct pel_job *job, pel_turn_kernel kernel, int threads, struct pel_error *error);
void pel_turned_finish(struct pel_turned *turned); /* accepts a zeroed one; for a new volume */

#endif
