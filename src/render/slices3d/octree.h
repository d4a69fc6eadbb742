/* SPDX-License-Identifier: MIT */
/* The min-max octree of section 4 (3.5 of the dissertation): every node knows the least and the greatest voxel in it. A node of size s
 * holds the voxels s i .. s i + s along each axis, so neighbours share a face of voxels, and whatever is reconstructed in it lies between
 * the two. It is made once a volume; a transfer function reads it through the range table (cubes.h).
 *
 * The extremes are kept as bins, a byte each: a pair of bins then stands for one of 65536 intervals of values, so that a changed transfer
 * function asks the range table once for each pair and not once for each node. Bytes in a narrow range have a bin for each value and lose
 * nothing; wider types have 256 equal bins, and intervals are taken to the bins' outer ends. */
#ifndef PEL_SLICES3D_OCTREE_H
#define PEL_SLICES3D_OCTREE_H

#include <stdint.h>

#include <pellucid/volume.h>

enum { PEL_OCTREE_LEVELS = 6, PEL_OCTREE_BINS = 256 }; /* nodes of 1 to 32 voxels along an edge */

struct pel_octree_level {
    int dims[3];      /* nodes along each axis; 0 where the level was not made */
    uint8_t *lo, *hi; /* owned; bins of the least and the greatest value, x fastest */
};

struct pel_octree {
    struct pel_octree_level levels[PEL_OCTREE_LEVELS]; /* level l: nodes of 2^l voxels; from `leaf` up */
    int leaf;
    bool voids; /* bin 0 stands for voids, and values begin with bin 1 */
    bool exact; /* a bin is one value, else an interval of `width` */
    double least, width;
};

/* The level of an edge, a power of two from 1 to 32. */
int pel_octree_level_of(int size);

/* Leaves of level `leaf`. Values are of the volume's only component. */
bool pel_octree_init(struct pel_octree *octree, const struct pel_volume *volume, int leaf, int threads, struct pel_error *error);
void pel_octree_finish(struct pel_octree *octree); /* accepts a zeroed one */

/* The values that a node with these bins may hold, voids apart; false where it holds voids alone. */
bool pel_octree_interval(const struct pel_octree *octree, int lo, int hi, double *least, double *most);

size_t pel_octree_bytes(const struct pel_octree *octree);

#endif
