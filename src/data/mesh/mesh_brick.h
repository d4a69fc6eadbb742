/* SPDX-License-Identifier: MIT */
/* A brick of 4^3 cells: its voxels, and the numbers of the vertices in it. */
#ifndef PEL_DATA_MESH_BRICK_H
#define PEL_DATA_MESH_BRICK_H

#include "mesh_slab.h"

enum {
    PEL_BRICK_SIDE = PEL_CELL_SIZE + 1,
    PEL_BRICK_HALO = PEL_BRICK_SIDE + 2, /* voxels along an axis with those that gradients need */
    PEL_BRICK_BENDS = 3,                 /* vertices that a segment over a face may have */
    PEL_BRICK_KINDS =
        3 + 6 * PEL_BRICK_BENDS, /* of places for vertices at a voxel: the edge along each axis, two segments on the face across each */
};
#define PEL_NO_VERTEX UINT32_MAX

/* Vertices of the slab by where they lie: on the edge from voxel (x, y, z) along `axis` (kind = axis), or on the face that begins there
 * across `axis` (from kind = 3 + 2 axis PEL_BRICK_BENDS on, its two segments). Without a tolerance there are but the first three kinds. */
struct pel_brick_numbers {
    uint32_t at[PEL_BRICK_KINDS][PEL_BRICK_SIDE][PEL_BRICK_SIDE][PEL_BRICK_SIDE]; /* kind, z, y, x */
    bool any;                                                                     /* false: nothing of it is set */
};

struct pel_brick {
    const struct pel_mesh_work *work;
    struct pel_mesh_slab *slab;
    struct pel_error *error;
    size_t first[3];                                               /* voxel */
    int voxels[3];                                                 /* 1 to PEL_BRICK_SIDE along each axis */
    double values[PEL_BRICK_HALO][PEL_BRICK_HALO][PEL_BRICK_HALO]; /* less the isovalue; with a voxel more on each side, clamped to the
                                                                      volume; NaN where void */
    unsigned inside[PEL_BRICK_SIDE][PEL_BRICK_SIDE], voids[PEL_BRICK_SIDE][PEL_BRICK_SIDE]; /* a bit a voxel along x */
    struct pel_brick_numbers *numbers;
};

/* The voxels from brick->first on. */
void pel_brick_load(struct pel_brick *brick);
/* The triangles in all its cells. */
bool pel_brick_cut(struct pel_brick *brick);

/* ---- mesh_edges.c ---- */

/* As pel_brick_cut does, and sooner; for a brick without voids, where no tolerance is asked for. */
bool pel_brick_cut_edges(struct pel_brick *brick);

/* ---- mesh_cell.c: the surface in one cell ---- */

/* `inside` has a bit a corner (cell_table.h). */
bool pel_cell_cut(struct pel_brick *brick, const int cell[3], unsigned inside);

/* The table's entry for a cell with ambiguous faces (or without). */
const struct pel_cell_entry *pel_cell_entry_of(const struct pel_brick *brick, const int cell[3], unsigned inside);

/* The value at a corner of a cell, less the isovalue. */
static inline const double *pel_brick_corner(const struct pel_brick *b, const int cell[3], int corner)
{
    return &b->values[cell[2] + 1 + (corner >> 2)][cell[1] + 1 + (corner >> 1 & 1)][cell[0] + 1 + (corner & 1)];
}

/* ---- mesh_curve.c: where the surface of the trilinear signal runs in a cell. Places are in the cell, 0 to 1 ---- */

struct pel_cell_values {
    double corner[8]; /* less the isovalue */
};

/* Where an edge is cut. */
void pel_curve_on_edge(const struct pel_cell_values *values, int edge, double place[3]);
/* A segment over a face between two of its edges, from the one that both cells beside the face call the first. */
struct pel_curve {
    double ends[2][3];
    bool turned; /* the first end is on the second edge that was given */
    bool corner; /* around a corner of the face, else from side to side */
    int axes[2]; /* of the face; from side to side: along the edges, across */
    int low;     /* the corner around which, or the face's lowest */
    double q, sides[2];
};
void pel_curve_start(struct pel_curve *curve, const struct pel_cell_values *values, int face, const int edges[2], const double ends[2][3]);
/* The place at a part of the segment, 0 to 1. */
void pel_curve_at(const struct pel_curve *curve, const struct pel_cell_values *values, double part, double place[3]);
/* How far a place is from a straight line. */
double pel_curve_off(const double place[3], const double from[3], const double to[3]);
/* From a place to the surface near it, and how far it was, in voxels; the place stays where the way is not clear. */
double pel_curve_to_surface(const struct pel_cell_values *values, double place[3]);

#endif
