/* SPDX-License-Identifier: MIT */
/* Min-max grid: the least and the greatest value that reconstruction can give in each cell of 4^3 voxel steps, and in each block of 4^3
 * cells. It is made once a volume; classified by a transfer function's range table or by isovalues it says where nothing can be seen.
 *
 * Cell (i,j,k) covers the index-space positions [4i, 4i+4) x ..., so the voxels 4i .. 4i+4: neighbours share a face of voxels. */
#ifndef PEL_DATA_MINMAX_H
#define PEL_DATA_MINMAX_H

#include <pellucid/volume.h>

#define PEL_CELL_SHIFT 2                       /* voxels a cell, as a power of two */
#define PEL_CELL_SIZE (1 << PEL_CELL_SHIFT)
#define PEL_BLOCK_SHIFT 4                      /* voxels a block of cells */

struct pel_minmax_level {
    size_t dims[3];
    float *least,
        *most; /* owned; +inf and -inf where a cell holds nothing but voids. Rounded outwards where float is narrower than the data */
};

struct pel_minmax {
    struct pel_minmax_level cells;  /* 4^3 voxels */
    struct pel_minmax_level blocks; /* 4^3 cells */
    bool has_voids; /* some voxel is NaN, infinite or the void value */
};

/* Values are of the only component. */
bool pel_minmax_init(struct pel_minmax *minmax, const struct pel_volume *volume, int threads, struct pel_error *error);
void pel_minmax_finish(struct pel_minmax *minmax); /* accepts a zeroed one */

#endif
