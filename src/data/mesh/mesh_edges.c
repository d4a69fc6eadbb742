/* SPDX-License-Identifier: MIT */
/* The plain triangles of marching cubes in a brick without voids, row by row, as flying edges goes (Schroeder, Maynard and Geveci 2015):
 * first all edges that are cut get their vertices, which bits of whole rows tell; then cells are looked up and their triangles written. It
 * makes what mesh_cell.c makes, and leaves to it the few cells that have a vertex in their middle. */
#include <math.h>
#include <string.h>

#include "mesh_brick.h"

enum { SIDE = PEL_BRICK_SIDE, HALO = PEL_BRICK_HALO, MOST_EDGES = SIDE * SIDE * (SIDE - 1) };

/* Edges along one axis that are cut, side by side. */
struct cuts {
    int count;
    uint32_t *slots[MOST_EDGES];
    double low[MOST_EDGES], high[MOST_EDGES], index[3][MOST_EDGES]; /* values less the isovalue at the ends; the lower end's voxel */
    double slopes[2][3][MOST_EDGES];                                /* twice the central differences at the ends */
    float positions[MOST_EDGES][3], normals[MOST_EDGES][3];
};

static void gather_cut(const struct pel_brick *b, int axis, int x, int y, int z, struct cuts *c)
{
    static const int strides[3] = { 1, HALO, HALO * HALO };
    uint32_t *slot = &b->numbers->at[axis][z][y][x];
    if (*slot != PEL_NO_VERTEX)
        return;
    const double *low = &b->values[z + 1][y + 1][x + 1], *high = low + strides[axis];
    int i = c->count++;
    c->slots[i] = slot;
    c->low[i] = *low;
    c->high[i] = *high;
    for (int a = 0; a < 3; a++) {
        c->slopes[0][a][i] = low[strides[a]] - low[-strides[a]];
        c->slopes[1][a][i] = high[strides[a]] - high[-strides[a]];
    }
    c->index[0][i] = (double)(b->first[0] + (size_t)x);
    c->index[1][i] = (double)(b->first[1] + (size_t)y);
    c->index[2][i] = (double)(b->first[2] + (size_t)z);
}

/* The brick's edges along an axis whose ends lie on either side. */
static void gather_cuts(const struct pel_brick *b, int axis, struct cuts *c)
{
    const unsigned all = (1u << b->voxels[0]) - 1;
    c->count = 0;
    for (int z = 0; z < b->voxels[2] - (axis == 2); z++)
        for (int y = 0; y < b->voxels[1] - (axis == 1); y++) {
            unsigned here = b->inside[z][y], there = axis == 0 ? here >> 1 : axis == 1 ? b->inside[z][y + 1] : b->inside[z + 1][y];
            for (unsigned cut = (here ^ there) & (axis == 0 ? all >> 1 : all); cut; cut &= cut - 1)
                gather_cut(b, axis, __builtin_ctz(cut), y, z, c);
        }
}

static inline double greatest(double x, double y, double z)
{
    x = fabs(x), y = fabs(y), z = fabs(z);
    double most = x > y ? x : y;
    return most > z ? most : z;
}

/* Places and normals, as mesh_cell.c has them. Loops without branches, for the compiler's vectors. */
static void place_cuts(const struct pel_mesh_work *w, int axis, struct cuts *c)
{
    for (int i = 0; i < c->count; i++) {
        double part = c->low[i] / (c->low[i] - c->high[i]);
        part = part >= 0 && part <= 1 ? part : 0.5; /* values so large that their difference is not finite */
        c->index[axis][i] += part;
        for (int a = 0; a < 3; a++)
            c->slopes[0][a][i] = part * c->slopes[1][a][i] + (1 - part) * c->slopes[0][a][i];
    }
    for (int i = 0; i < c->count; i++) {
        double n[3], x = c->slopes[0][0][i], y = c->slopes[0][1][i], z = c->slopes[0][2][i];
        double scale = -1 / greatest(x, y, z);
        for (int a = 0; a < 3; a++)
            n[a] = (w->normal[a][0] * x + w->normal[a][1] * y + w->normal[a][2] * z) * scale;
        scale = 1 / sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int a = 0; a < 3; a++) {
            c->normals[i][a] = (float)(n[a] * scale);
            c->positions[i][a] =
                (float)(w->to_world[a][0] * c->index[0][i] + w->to_world[a][1] * c->index[1][i] + w->to_world[a][2] * c->index[2][i]);
        }
    }
}

/* Where the differences cancel there is no gradient (NaN; or none that is finite): towards where the values rise along the edge. */
static void mend_normals(const struct pel_mesh_work *w, int axis, struct cuts *c)
{
    for (int i = 0; i < c->count; i++) {
        double most = greatest(c->slopes[0][0][i], c->slopes[0][1][i], c->slopes[0][2][i]) / 2;
        if (most > 0 && most <= 1e300)
            continue;
        double n[3], length = 0;
        for (int a = 0; a < 3; a++) {
            n[a] = w->normal[a][axis] * (c->high[i] >= 0 ? -1 : 1);
            length += n[a] * n[a];
        }
        for (int a = 0; a < 3; a++)
            c->normals[i][a] = (float)(n[a] / sqrt(length));
    }
}

static bool make_vertices(struct pel_brick *b)
{
    struct cuts cuts;
    for (int axis = 0; axis < 3; axis++) {
        gather_cuts(b, axis, &cuts);
        if (!cuts.count)
            continue;
        place_cuts(b->work, axis, &cuts);
        mend_normals(b->work, axis, &cuts);
        uint32_t first;
        if (!pel_mesh_add_vertices(b->slab, (const float(*)[3])cuts.positions, (const float(*)[3])cuts.normals, (size_t)cuts.count, &first,
                                   b->error))
            return false;
        for (int i = 0; i < cuts.count; i++)
            *cuts.slots[i] = first + (uint32_t)i;
    }
    return true;
}

/* Where the number of an edge's vertex is, from that of the cell's first corner. */
static void find_edges(ptrdiff_t edges[12])
{
    for (int edge = 0; edge < 12; edge++) {
        int corners[2];
        pel_cell_edge(edge, corners);
        edges[edge] = edge / 4 * SIDE * SIDE * SIDE + (corners[0] >> 2) * SIDE * SIDE + (corners[0] >> 1 & 1) * SIDE + (corners[0] & 1);
    }
}

/* False where the cell needs a vertex in its middle. */
static bool has_triangles(const struct pel_cell_entry *entry)
{
    for (int l = 0; l < entry->loops; l++)
        if (!entry->loop[l].triangles)
            return false;
    return true;
}

static bool make_triangles(struct pel_brick *b, const ptrdiff_t edges[12], const int cell[3], unsigned inside)
{
    const struct pel_cell_table *table = b->work->table;
    const struct pel_cell_entry *entry = &table->entries[table->first[inside]];
    if (table->ambiguous[inside])
        entry = pel_cell_entry_of(b, cell, inside);
    if (!has_triangles(entry))
        return pel_cell_cut(b, cell, inside);
    if (!pel_mesh_reserve_triangles(b->slab, PEL_CELL_TRIANGLES, b->error))
        return false;
    const uint32_t *numbers = &b->numbers->at[0][cell[2]][cell[1]][cell[0]];
    uint32_t(*to)[3] = b->slab->triangles + b->slab->triangle_count;
    const int second = b->work->mirrored ? 2 : 1, third = 3 - second;
    const struct pel_cell_loop *last = &entry->loop[entry->loops - 1];
    const int count = last->first_triangle + last->triangles;
    for (int i = 0; i < count; i++) {
        to[i][0] = numbers[edges[entry->triangles[i][0]]];
        to[i][second] = numbers[edges[entry->triangles[i][1]]];
        to[i][third] = numbers[edges[entry->triangles[i][2]]];
    }
    b->slab->triangle_count += (size_t)count;
    return true;
}

bool pel_brick_cut_edges(struct pel_brick *b)
{
    ptrdiff_t edges[12];
    find_edges(edges);
    if (!make_vertices(b))
        return false;
    for (int z = 0; z < b->voxels[2] - 1; z++)
        for (int y = 0; y < b->voxels[1] - 1; y++) {
            const unsigned rows[4] = { b->inside[z][y], b->inside[z][y + 1], b->inside[z + 1][y], b->inside[z + 1][y + 1] };
            const unsigned any = rows[0] | rows[1] | rows[2] | rows[3], every = rows[0] & rows[1] & rows[2] & rows[3];
            /* Cells along x that have corners on both sides. */
            unsigned cut = (any | any >> 1) & ~(every & every >> 1) & ((1u << (b->voxels[0] - 1)) - 1);
            for (; cut; cut &= cut - 1) {
                const int x = __builtin_ctz(cut), cell[3] = { x, y, z };
                unsigned inside = 0;
                for (int i = 0; i < 4; i++)
                    inside |= (rows[i] >> x & 3) << (2 * i);
                if (!make_triangles(b, edges, cell, inside))
                    return false;
            }
        }
    return true;
}
