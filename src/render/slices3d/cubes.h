/* SPDX-License-Identifier: MIT */
/* The two sets of cubes that stand for the isosurfaces phi_t and phi_p (sections 4.1 and 4.2; 3.5 of the dissertation), extracted again
 * from the octree whenever the transfer function changes, and their outer faces, which are what is drawn into the z-buffer.
 *
 * The papers have one threshold each and want the interior to lie above it. Here the range table answers for an interval of values, so any
 * transfer function will do: with several bands, with opaque shells in translucent ones, with interiors below the isovalue.
 *   A cube is EMPTY where no value that can be reconstructed in it is visible, FULL where all are, else MIXED: it "contains isosurface".
 *   A cube is opaque where the least opacity of all these values reaches the threshold, and it holds no void.
 * Neighbours share a face of voxels, so a FULL cube never touches an EMPTY one, nor an opaque cube one that has no opaque value. */
#ifndef PEL_SLICES3D_CUBES_H
#define PEL_SLICES3D_CUBES_H

#include "octree.h"
#include "transfer_table.h"

enum pel_cube_class { PEL_CUBE_EMPTY, PEL_CUBE_MIXED, PEL_CUBE_FULL };

/* What a transfer function makes of each interval of bins; index lo + 256 hi. */
struct pel_cube_table {
    uint8_t classes[PEL_OCTREE_BINS * PEL_OCTREE_BINS];
    uint8_t opacity[PEL_OCTREE_BINS * PEL_OCTREE_BINS]; /* 255ths of the least opacity, rounded down; 0 with voids */
};
void pel_cube_table_build(struct pel_cube_table *table, const struct pel_octree *octree, const struct pel_transfer_table *transfer);

/* A face of a run of cubes along x: x in bits 0..15, y in 16..31 of `a`; of `b` z in bits 0..15, direction in 16..18, cubes in 19..31.
 * Directions: 0 -x, 1 +x, 2 -y, 3 +y, 4 -z, 5 +z. */
struct pel_cube_face {
    uint32_t a, b;
};

/* A set of cubes of one level: a bit a cube, rows of whole words. */
struct pel_cube_bits {
    int dims[3];
    size_t words;   /* a row */
    uint64_t *rows; /* owned */
};

struct pel_cube_set {
    int level;                   /* of the octree */
    struct pel_cube_bits solid;  /* all cubes that are not EMPTY (phi_t), or opaque (phi_p) */
    size_t cubes;                /* in S (figure 5), in T (figure 8) */
    struct pel_cube_face *faces; /* owned; the outer ones of the set, ordered by direction */
    size_t room;
    size_t first[7];  /* of each direction in `faces`; the last is the count */
    uint8_t *opacity; /* owned; phi_p: a cube's least opacity, 0 below the threshold */
    int lo[3], hi[3]; /* the solid cubes lie in [lo, hi) */
    size_t *scratch;  /* owned */
};

/* phi_t, inflated: the cubes that contain the surface, and those inside it at the volume's boundary, so that it is closed (figure 5). */
bool pel_cubes_extract_t(struct pel_cube_set *set, const struct pel_octree *octree, const struct pel_cube_table *table, int level,
                         int threads, struct pel_error *error);
/* phi_p, shrunk: the outermost of the cubes that lie completely inside (figure 8); opacity of at least `threshold`. Not reduced: also
 * the cubes that contain the surface and whose middle value is opaque, which hide what may be seen (figures 3 and 4, left). */
bool pel_cubes_extract_p(struct pel_cube_set *set, const struct pel_octree *octree, const struct pel_cube_table *table, int level,
                         double threshold, bool reduced, int threads, struct pel_error *error);
void pel_cubes_finish(struct pel_cube_set *set); /* accepts a zeroed one */

static inline bool pel_cube_is_solid(const struct pel_cube_bits *bits, int x, int y, int z)
{
    if (x < 0 || y < 0 || z < 0 || x >= bits->dims[0] || y >= bits->dims[1] || z >= bits->dims[2])
        return false;
    return bits->rows[((size_t)z * (size_t)bits->dims[1] + (size_t)y) * bits->words + (size_t)x / 64] >> (x % 64) & 1;
}

#endif
