/* SPDX-License-Identifier: MIT */
/* How a surface cuts a cell of eight voxels: marching cubes (Lorensen and Cline 1987), with the triangles made by a rule and not typed in.
 *
 * The surface meets each face of the cell in line segments. Where a face has two opposite corners inside and two outside there are two
 * ways to draw them, and the asymptotic decider (Nielson and Hamann 1991) takes that of the bilinear signal on the face. It asks the
 * face's four values alone, so both cells beside it draw the same segments: that is all it takes for a surface without cracks. The
 * segments of the six faces join into closed loops, and each loop is filled with triangles.
 *
 * Corner c lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge 4 a + i runs along axis a from the corner whose other two coordinates are the bits
 * of i, in the order of the axes. Face 2 a + s is that at s along axis a. */
#ifndef PEL_DATA_CELL_TABLE_H
#define PEL_DATA_CELL_TABLE_H

#include <stdint.h>

#include <pellucid/error.h>

enum {
    PEL_CELL_LOOPS = 4,      /* the most there are */
    PEL_CELL_TRIANGLES = 10, /* likewise, of all loops that are filled with them */
    PEL_CELL_ENTRIES = 656,  /* all ways to cut a cell */
};

/* One way to cut a cell. */
struct pel_cell_entry {
    uint8_t loops;
    struct pel_cell_loop {
        uint8_t first, count;              /* of `edges` and `faces` */
        uint8_t first_triangle, triangles; /* none: the loop can be filled around a vertex in its middle alone */
    } loop[PEL_CELL_LOOPS];
    uint8_t edges[12], faces[12];             /* the edges that loops go through, and the face over which each leads to the next; */
    uint8_t triangles[PEL_CELL_TRIANGLES][3]; /* corners of triangles, as edges. All counter-clockwise as seen from outside */
};

struct pel_cell_table {
    uint16_t first[256]; /* by the cell's case: bit c is set where corner c is inside */
    uint8_t
        ambiguous[256]; /* faces that have two ways; a bit each. Entry first + i, where bit j of i: the insides of the j-th of them join */
    int count;
    struct pel_cell_entry entries[PEL_CELL_ENTRIES];
};

void pel_cell_table_init(struct pel_cell_table *table);

/* The two corners of an edge. */
static inline void pel_cell_edge(int edge, int corners[2])
{
    int axis = edge / 4, b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    corners[0] = (edge & 1) << b | (edge >> 1 & 1) << c;
    corners[1] = corners[0] | 1 << axis;
}

/* The four of a face: counter-clockwise as seen from outside. */
static inline void pel_cell_face(int face, int corners[4])
{
    int axis = face / 2, side = face % 2, b = (axis + 1) % 3, c = (axis + 2) % 3;
    const int around[4] = { 0, 1 << b, 1 << b | 1 << c, 1 << c }; /* counter-clockwise as seen from high on the axis */
    for (int i = 0; i < 4; i++)
        corners[i] = around[side ? i : 3 - i] | side << axis;
}

#endif
