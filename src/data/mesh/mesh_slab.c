/* SPDX-License-Identifier: MIT */
/* Bricks are taken in the order of x, then y. Each numbers the edges of its 5^3 voxels that have a vertex; what lies on faces that an
 * earlier brick had is copied from there, so that vertices are shared. Two rows of bricks are all that must be remembered. */
#include "mesh_slab.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "samples.h"
#include "vec.h"

enum { SIDE = PEL_CELL_SIZE + 1, HALO = SIDE + 2, NONE = -1 };

/* Vertices on the edges of a brick: that of the edge from voxel (x, y, z) along each axis. */
struct numbers {
    uint32_t edge[3][SIDE][SIDE][SIDE]; /* axis, z, y, x */
    bool any;                           /* false: nothing of it is set */
};

struct brick {
    const struct pel_mesh_work *work;
    struct pel_mesh_slab *slab;
    struct pel_error *error;
    size_t first[3]; /* voxel */
    int voxels[3];   /* 2 to SIDE along each axis */
    double values[HALO][HALO][HALO]; /* less the isovalue; with a voxel more on each side, clamped to the volume; NaN where void */
    unsigned inside[SIDE][SIDE], voids[SIDE][SIDE]; /* a bit a voxel along x */
    struct numbers *numbers;
};

/* ---- growing arrays ---- */

static bool grow(void **array, size_t *room, size_t count, size_t size, struct pel_error *error)
{
    size_t bytes, more = *room ? *room : 256;
    if (count < *room)
        return true;
    if (!pel_mul(more, 2, &more) || !pel_mul(more, size, &bytes))
        return pel_fail(error, PEL_ERROR_MEMORY, "a part of the surface is larger than memory can be");
    void *grown = realloc(*array, bytes);
    if (!grown)
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu MB of a part of the surface", bytes >> 20);
    *array = grown;
    *room = more;
    return true;
}

static bool add_vertex(struct pel_mesh_slab *s, const float position[3], const float normal[3], uint32_t *number, struct pel_error *error)
{
    size_t room = s->vertex_room;
    if (s->vertex_count == UINT32_MAX - 1)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the surface has more vertices than 32 bits count; take another isovalue");
    if (!grow((void **)&s->positions, &room, s->vertex_count, sizeof *s->positions, error) ||
        !grow((void **)&s->normals, &s->vertex_room, s->vertex_count, sizeof *s->normals, error))
        return false;
    memcpy(s->positions[s->vertex_count], position, sizeof *s->positions);
    memcpy(s->normals[s->vertex_count], normal, sizeof *s->normals);
    *number = (uint32_t)s->vertex_count++;
    return true;
}

static bool add_triangle(struct pel_mesh_slab *s, bool mirrored, const uint32_t corners[3], struct pel_error *error)
{
    if (!grow((void **)&s->triangles, &s->triangle_room, s->triangle_count, sizeof *s->triangles, error))
        return false;
    uint32_t *t = s->triangles[s->triangle_count++];
    t[0] = corners[0], t[1] = corners[mirrored ? 2 : 1], t[2] = corners[mirrored ? 1 : 2];
    return true;
}

static bool add_seam(struct pel_mesh_slab *s, int side, uint64_t key, uint32_t vertex, struct pel_error *error)
{
    if (!grow((void **)&s->seams[side], &s->seam_room[side], s->seam_count[side], sizeof **s->seams, error))
        return false;
    s->seams[side][s->seam_count[side]++] = (struct pel_mesh_seam) { key, vertex };
    return true;
}

void pel_mesh_slab_finish(struct pel_mesh_slab *s)
{
    free(s->positions);
    free(s->normals);
    free(s->triangles);
    free(s->seams[0]);
    free(s->seams[1]);
    memset(s, 0, sizeof *s);
}

/* ---- a brick's voxels ---- */

static size_t clamped(size_t first, int offset, size_t dim)
{
    if (offset < 0 && first < (size_t)-offset)
        return 0;
    size_t at = first + (size_t)offset;
    return at < dim ? at : dim - 1;
}

static void load_row(const struct brick *b, size_t y, size_t z, double row[HALO])
{
    const struct pel_volume *v = b->work->volume;
    size_t x0 = clamped(b->first[0], -1, v->dims[0]), x1 = clamped(b->first[0], HALO - 2, v->dims[0]);
    double samples[HALO];
    pel_samples_load(v, (z * v->dims[1] + y) * v->dims[0] + x0, x1 - x0 + 1, samples);
    for (int x = 0; x < HALO; x++) {
        double value = samples[clamped(b->first[0], x - 1, v->dims[0]) - x0];
        row[x] = isfinite(value) ? value - b->work->isovalue : NAN;
    }
}

/* Inside is where the isovalue is reached, as for the ray caster. */
static void load(struct brick *b)
{
    const struct pel_volume *v = b->work->volume;
    for (int a = 0; a < 3; a++)
        b->voxels[a] = v->dims[a] - b->first[a] < SIDE ? (int)(v->dims[a] - b->first[a]) : SIDE;
    for (int z = 0; z < HALO; z++)
        for (int y = 0; y < HALO; y++)
            load_row(b, clamped(b->first[1], y - 1, v->dims[1]), clamped(b->first[2], z - 1, v->dims[2]), b->values[z][y]);
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++) {
            b->inside[z][y] = b->voids[z][y] = 0;
            for (int x = 0; x < SIDE; x++) {
                b->inside[z][y] |= (unsigned)(b->values[z + 1][y + 1][x + 1] >= 0) << x;
                b->voids[z][y] |= (unsigned)isnan(b->values[z + 1][y + 1][x + 1]) << x;
            }
        }
}

/* ---- vertices ---- */

/* Central difference at a voxel along an axis. Voxels beyond the volume are the last one, as for the ray caster; voids count as the voxel
 * itself, where the ray caster has no gradient: a surface in a file has no other light to fall back on. */
static double slope(const double *value, int stride)
{
    double low = value[-stride], high = value[stride];
    return ((isnan(high) ? *value : high) - (isnan(low) ? *value : low)) / 2;
}

/* The ray caster's gradient at a place on an edge: the mean of the differences at both ends, weighted, since reconstruction is linear there. */
static void set_normal(const struct pel_mesh_work *w, const double *ends[2], double part, int axis, float normal[3])
{
    static const int strides[3] = { 1, HALO, HALO * HALO };
    double g[3], n[3];
    for (int a = 0; a < 3; a++) {
        double low = slope(ends[0], strides[a]), high = slope(ends[1], strides[a]);
        g[a] = low + part * (high - low);
    }
    double most = fmax(fmax(fabs(g[0]), fabs(g[1])), fabs(g[2]));
    if (!(most > 0 && most <= 1e300)) { /* the differences cancel: along the edge the values differ */
        g[0] = g[1] = g[2] = 0;
        g[axis] = most = *ends[1] > *ends[0] ? 1 : -1;
    }
    for (int i = 0; i < 3; i++)
        n[i] = -pel_dot(w->normal[i], g) / fabs(most);
    pel_normalize(n);
    for (int i = 0; i < 3; i++)
        normal[i] = (float)n[i];
}

/* The vertex on the edge along `axis` from the brick's voxel `at`. */
static bool make_vertex(struct brick *b, int axis, const int at[3], uint32_t *number)
{
    const struct pel_mesh_work *w = b->work;
    static const int steps[3] = { 1, HALO, HALO * HALO };
    const double *ends[2] = { &b->values[at[2] + 1][at[1] + 1][at[0] + 1], NULL };
    ends[1] = ends[0] + steps[axis];
    double part = *ends[0] / (*ends[0] - *ends[1]), index[3];
    part = part >= 0 && part <= 1 ? part : 0.5; /* values so large that their difference is not finite */
    float position[3], normal[3];
    for (int a = 0; a < 3; a++)
        index[a] = (double)(b->first[a] + (size_t)at[a]) + (a == axis ? part : 0);
    for (int i = 0; i < 3; i++)
        position[i] = (float)pel_dot(w->to_world[i], index);
    set_normal(w, ends, part, axis, normal);
    return add_vertex(b->slab, position, normal, number, b->error);
}

/* The vertex of a cell's edge, made where it is not there yet. */
static bool find_vertex(struct brick *b, const int cell[3], int edge, uint32_t *number)
{
    int corners[2];
    pel_cell_edge(edge, corners);
    const int axis = edge / 4, at[3] = { cell[0] + (corners[0] & 1), cell[1] + (corners[0] >> 1 & 1), cell[2] + (corners[0] >> 2) };
    uint32_t *slot = &b->numbers->edge[axis][at[2]][at[1]][at[0]];
    if (*slot == (uint32_t)NONE && !make_vertex(b, axis, at, slot))
        return false;
    *number = *slot;
    return true;
}

/* The mean of the vertices of a loop: amidst a loop that no triangles without it can fill (cell_table.c). */
static bool add_centre(struct brick *b, const uint32_t vertices[12], unsigned of, uint32_t *number)
{
    const struct pel_mesh_slab *s = b->slab;
    double sum[3] = { 0, 0, 0 }, normals[3] = { 0, 0, 0 };
    float position[3], normal[3];
    for (int edge = 0; edge < 12; edge++)
        for (int i = 0; of >> edge & 1 && i < 3; i++) {
            sum[i] += (double)s->positions[vertices[edge]][i];
            normals[i] += (double)s->normals[vertices[edge]][i];
        }
    if (pel_normalize(normals) < 1e-6) {
        int first = __builtin_ctz(of);
        for (int i = 0; i < 3; i++)
            normals[i] = (double)s->normals[vertices[first]][i];
    }
    for (int i = 0; i < 3; i++) {
        position[i] = (float)(sum[i] / __builtin_popcount(of));
        normal[i] = (float)normals[i];
    }
    return add_vertex(b->slab, position, normal, number, b->error);
}

/* ---- cells ---- */

/* Where insides join on an ambiguous face: the saddle of the bilinear signal is inside where the product of the values inside is at least
 * that of the values outside (Nielson and Hamann 1991, equation 4, without the division). Both cells beside the face multiply the same. */
static unsigned entry_of(const struct brick *b, const int cell[3], unsigned inside)
{
    const struct pel_cell_table *t = b->work->table;
    unsigned way = 0, ways = 0;
    for (int face = 0; face < 6; face++) {
        int corners[4];
        double value[4];
        if (!(t->ambiguous[inside] >> face & 1))
            continue;
        pel_cell_face(face, corners);
        for (int i = 0; i < 4; i++)
            value[i] = b->values[cell[2] + 1 + (corners[i] >> 2)][cell[1] + 1 + (corners[i] >> 1 & 1)][cell[0] + 1 + (corners[i] & 1)];
        double even = value[0] * value[2], odd = value[1] * value[3];
        bool even_inside = inside >> corners[0] & 1;
        way |= (unsigned)(even_inside ? even >= odd : odd >= even) << ways++;
    }
    return t->first[inside] + way;
}

static bool cut_cell(struct brick *b, const int cell[3], unsigned inside)
{
    const struct pel_cell_entry *entry = &b->work->table->entries[entry_of(b, cell, inside)];
    uint32_t vertices[PEL_CELL_CENTRE + 1];
    unsigned done = 0;
    for (int i = 0; i < entry->count; i++)
        for (int j = 0; j < 3; j++) {
            int edge = entry->triangles[i][j];
            if (edge == PEL_CELL_CENTRE || done >> edge & 1)
                continue;
            if (!find_vertex(b, cell, edge, &vertices[edge]))
                return false;
            done |= 1u << edge;
        }
    if (entry->centre && !add_centre(b, vertices, entry->centre, &vertices[PEL_CELL_CENTRE]))
        return false;
    for (int i = 0; i < entry->count; i++) {
        const uint8_t *edges = entry->triangles[i];
        const uint32_t corners[3] = { vertices[edges[0]], vertices[edges[1]], vertices[edges[2]] };
        if (!add_triangle(b->slab, b->work->mirrored, corners, b->error))
            return false;
    }
    return true;
}

static bool cut_row(struct brick *b, int y, int z)
{
    const unsigned rows[4] = { b->inside[z][y], b->inside[z][y + 1], b->inside[z + 1][y], b->inside[z + 1][y + 1] };
    const unsigned voids = b->voids[z][y] | b->voids[z][y + 1] | b->voids[z + 1][y] | b->voids[z + 1][y + 1];
    const unsigned all = (1u << b->voxels[0]) - 1;
    if (!((rows[0] | rows[1] | rows[2] | rows[3]) & all) || (rows[0] & rows[1] & rows[2] & rows[3] & all) == all)
        return true;
    for (int x = 0; x < b->voxels[0] - 1; x++) {
        unsigned inside = 0;
        for (int i = 0; i < 4; i++)
            inside |= (rows[i] >> x & 3) << (2 * i);
        const int cell[3] = { x, y, z };
        if (inside != 0 && inside != 255 && !(voids >> x & 3) && !cut_cell(b, cell, inside))
            return false;
    }
    return true;
}

/* ---- bricks ---- */

/* Takes over the numbers on the faces that the brick shares with those before it along x and along y, and on the line that it shares with the
 * one beyond both: where voids keep the others from it, that one alone may have made a vertex there. */
static void copy_shared(struct numbers *to, const struct numbers *left, const struct numbers *behind, const struct numbers *beyond)
{
    memset(to->edge, 0xff, sizeof to->edge);
    to->any = true;
    for (int axis = 0; axis < 3; axis++)
        for (int z = 0; z < SIDE; z++)
            for (int i = 0; i < SIDE; i++) {
                if (left && left->any)
                    to->edge[axis][z][i][0] = left->edge[axis][z][i][SIDE - 1];
                if (behind && behind->any && to->edge[axis][z][0][i] == (uint32_t)NONE)
                    to->edge[axis][z][0][i] = behind->edge[axis][z][SIDE - 1][i];
            }
    for (int axis = 0; beyond && beyond->any && axis < 3; axis++)
        for (int z = 0; z < SIDE; z++)
            if (to->edge[axis][z][0][SIDE - 1] == (uint32_t)NONE)
                to->edge[axis][z][0][SIDE - 1] = beyond->edge[axis][z][SIDE - 1][0];
}

/* The vertices on the lowest and the highest plane of the bricks. An edge between bricks belongs to the last that has it: then all
 * that could make a vertex of it have been there. */
static bool note_seams(struct brick *b, size_t brick, const bool last[2])
{
    const int planes[2] = { 0, b->voxels[2] - 1 };
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < 2 * SIDE * SIDE; i++) {
            int axis = i / (SIDE * SIDE), y = i / SIDE % SIDE, x = i % SIDE;
            bool ours = (x < SIDE - 1 || last[0]) && (y < SIDE - 1 || last[1]);
            uint32_t vertex = b->numbers->edge[axis][planes[side]][y][x];
            if (ours && vertex != (uint32_t)NONE && !add_seam(b->slab, side, (uint64_t)brick * 2 * SIDE * SIDE + (uint64_t)i, vertex, b->error))
                return false;
        }
    return true;
}

static bool cut_brick(struct brick *b, size_t brick, const bool last[2])
{
    load(b);
    for (int z = 0; z < b->voxels[2] - 1; z++)
        for (int y = 0; y < b->voxels[1] - 1; y++)
            if (!cut_row(b, y, z))
                return false;
    return note_seams(b, brick, last);
}

size_t pel_mesh_scratch_bytes(const struct pel_minmax *minmax)
{
    return 2 * minmax->cells.dims[0] * sizeof(struct numbers);
}

bool pel_mesh_slab_make(struct pel_mesh_slab *slab, const struct pel_mesh_work *work, size_t bz, void *scratch, struct pel_error *error)
{
    const struct pel_minmax_level *bricks = &work->minmax->cells;
    const size_t *n = bricks->dims;
    struct numbers *rows[2] = { scratch, (struct numbers *)scratch + n[0] };
    struct brick b = { .work = work, .slab = slab, .error = error };
    for (size_t x = 0; x < n[0]; x++)
        rows[0][x].any = rows[1][x].any = false;
    for (size_t y = 0; y < n[1]; y++) {
        struct numbers *row = rows[y & 1], *before = rows[~y & 1];
        for (size_t x = 0; x < n[0]; x++) {
            size_t at = (bz * n[1] + y) * n[0] + x;
            const bool last[2] = { x == n[0] - 1, y == n[1] - 1 };
            row[x].any = false;
            if (!((double)bricks->least[at] < work->isovalue && (double)bricks->most[at] >= work->isovalue))
                continue;
            copy_shared(&row[x], x ? &row[x - 1] : NULL, y ? &before[x] : NULL, y && x + 1 < n[0] ? &before[x + 1] : NULL);
            b.first[0] = x * PEL_CELL_SIZE, b.first[1] = y * PEL_CELL_SIZE, b.first[2] = bz * PEL_CELL_SIZE;
            b.numbers = &row[x];
            if (!cut_brick(&b, y * n[0] + x, last))
                return false;
        }
    }
    return true;
}
