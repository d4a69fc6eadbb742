/* SPDX-License-Identifier: MIT */
/* Turning voxels into rows along y (turned.h): W rows at a time, so that a line of memory that was fetched is used up along x. */
#ifndef PEL_CPU_KERNEL_TURN_H
#define PEL_CPU_KERNEL_TURN_H

#include "kernel_shear_fetch.h"
#include "turned.h"

#if PEL_KIND != PEL_KIND_WIDE

#define TURN_STEP (PEL_KIND == PEL_KIND_U8 ? 4 : PEL_KIND == PEL_KIND_U16 ? 2 : 1) /* voxels that a gather brings */

/* W voxels from (x, y, z) on along y, of TURN_STEP x, into rows at `to`, `next` apart. */
PEL_INLINE void turn_voxels(const struct pel_job *job, int x, int y, int z, narrow_type *to, ptrdiff_t next)
{
    vi at = vi_min(vi_lane() + y, vi_set(job->dims[1] - 1)) * job->row + (x + z * job->slice);
#if PEL_KIND == PEL_KIND_U8
    vi word = vi_gather(job->data, at);
    for (int i = 0; i < 4; i++) {
        narrow n = __builtin_convertvector((word >> (8 * i)) & 0xff, narrow);
        memcpy(to + i * next, &n, sizeof n);
    }
#elif PEL_KIND == PEL_KIND_U16
    vi word = vi_gather2(job->data, at);
    for (int i = 0; i < 2; i++) {
        narrow n = __builtin_convertvector((word >> (16 * i)) & 0xffff, narrow);
        memcpy(to + i * next, &n, sizeof n);
    }
#else
    vf voxel = vf_gather(job->data, at);
    memcpy(to, &voxel, sizeof voxel);
    (void)next;
#endif
}

static void turn_cells(const struct pel_job *job, int slab, const uint8_t *wanted, const struct pel_turned *turned)
{
    const int cells = job->cell_dims[0], rows = job->cell_dims[1], together = W / PEL_CELL_SIZE, depth = job->dims[2] < 2 ? 2 : job->dims[2],
              z0 = slab * PEL_CELL_SIZE, z1 = z0 + PEL_CELL_SIZE < depth ? z0 + PEL_CELL_SIZE : depth;
    for (int cy = 0; cy < rows; cy += together)
        for (int z = z0; z < z1; z++)
            for (int cx = 0; cx < cells; cx++) {
                bool any = false;
                for (int i = cy; i < cy + together && i < rows; i++)
                    any |= wanted[i * cells + cx];
                for (int i = 0; any && i < PEL_CELL_SIZE; i += TURN_STEP) {
                    int x = cx * PEL_CELL_SIZE + i, last = job->row - TURN_STEP;
                    x = x < last ? x : last; /* a row's last word begins before its end */
                    narrow_type *to = (narrow_type *)turned->voxels + z * turned->next_row + x * turned->next_slice + cy * PEL_CELL_SIZE;
                    turn_voxels(job, x, cy * PEL_CELL_SIZE, z, to, turned->next_slice);
                }
            }
}

#else

static void turn_cells(const struct pel_job *job, int slab, const uint8_t *wanted, const struct pel_turned *turned)
{
    (void)job, (void)slab, (void)wanted, (void)turned; /* never asked for */
}

#endif

#endif
