/* SPDX-License-Identifier: MIT */
/* Bricks are taken in the order of x, then y. What lies on faces that an earlier brick had gets its number from there, so that vertices are
 * shared. Two rows of bricks are all that must be remembered. */
#include "mesh_slab.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "mesh_brick.h"

enum { SIDE = PEL_BRICK_SIDE };

/* ---- growing arrays ---- */

/* Room for `more` items after `count`. */
static bool grow(void **array, size_t *room, size_t count, size_t more, size_t size, struct pel_error *error)
{
    size_t bytes, larger = *room ? *room : 256;
    if (more <= *room - count)
        return true;
    while (larger - count < more)
        if (!pel_mul(larger, 2, &larger))
            return pel_fail(error, PEL_ERROR_MEMORY, "a part of the surface is larger than memory can be");
    if (!pel_mul(larger, size, &bytes))
        return pel_fail(error, PEL_ERROR_MEMORY, "a part of the surface is larger than memory can be");
    void *grown = realloc(*array, bytes);
    if (!grown)
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu MB of a part of the surface", bytes >> 20);
    *array = grown;
    *room = larger;
    return true;
}

bool pel_mesh_add_vertices(struct pel_mesh_slab *s, const float (*positions)[3], const float (*normals)[3], size_t count, uint32_t *first,
                           struct pel_error *error)
{
    size_t room = s->vertex_room;
    if (s->vertex_count >= UINT32_MAX - count)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the surface has more vertices than 32 bits count; take another isovalue");
    if (!grow((void **)&s->positions, &room, s->vertex_count, count, sizeof *s->positions, error) ||
        !grow((void **)&s->normals, &s->vertex_room, s->vertex_count, count, sizeof *s->normals, error))
        return false;
    memcpy(s->positions[s->vertex_count], positions, count * sizeof *positions);
    memcpy(s->normals[s->vertex_count], normals, count * sizeof *normals);
    *first = (uint32_t)s->vertex_count;
    s->vertex_count += count;
    return true;
}

bool pel_mesh_reserve_triangles(struct pel_mesh_slab *s, size_t count, struct pel_error *error)
{
    return grow((void **)&s->triangles, &s->triangle_room, s->triangle_count, count, sizeof *s->triangles, error);
}

bool pel_mesh_add_triangle(struct pel_mesh_slab *s, uint32_t a, uint32_t b, uint32_t c, struct pel_error *error)
{
    if (!pel_mesh_reserve_triangles(s, 1, error))
        return false;
    uint32_t *corners = s->triangles[s->triangle_count++];
    corners[0] = a, corners[1] = b, corners[2] = c;
    return true;
}

static bool add_seam(struct pel_mesh_slab *s, int side, uint64_t key, uint32_t vertex, struct pel_error *error)
{
    if (!grow((void **)&s->seams[side], &s->seam_room[side], s->seam_count[side], 1, sizeof **s->seams, error))
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

/* ---- sharing ---- */

/* Takes over the numbers on the faces that the brick shares with those before it along x and along y, and on the line that it shares with
 * the one beyond both: where voids keep the others from it, that one alone may have made a vertex there. */
static void copy_shared(struct pel_brick_numbers *to, int kinds, const struct pel_brick_numbers *left,
                        const struct pel_brick_numbers *behind, const struct pel_brick_numbers *beyond)
{
    memset(to->at, 0xff, (size_t)kinds * sizeof to->at[0]);
    to->any = true;
    for (int kind = 0; kind < kinds; kind++)
        for (int z = 0; z < SIDE; z++) {
            uint32_t(*here)[SIDE] = to->at[kind][z];
            for (int i = 0; left && i < SIDE; i++)
                here[i][0] = left->at[kind][z][i][SIDE - 1];
            for (int i = 0; behind && i < SIDE; i++) /* PEL_NO_VERTEX is the greatest number there is */
                here[0][i] = here[0][i] < behind->at[kind][z][SIDE - 1][i] ? here[0][i] : behind->at[kind][z][SIDE - 1][i];
            if (beyond && here[0][SIDE - 1] == PEL_NO_VERTEX)
                here[0][SIDE - 1] = beyond->at[kind][z][SIDE - 1][0];
        }
}

/* Brick `x` of a row, where there is one and something is in it. */
static const struct pel_brick_numbers *filled(const struct pel_brick_numbers *row, size_t x, size_t count, bool there)
{
    return there && x < count && row[x].any ? &row[x] : NULL;
}

/* The vertices on the lowest and the highest plane of the bricks: on edges along x and y, and on the faces in the plane. What lies between
 * bricks belongs to the last that has it: then all that could make a vertex there have been there. */
static bool note_seams(struct pel_brick *b, size_t brick, const bool last[2])
{
    enum { KINDS = 2 + 2 * PEL_BRICK_BENDS, FACES = PEL_BRICK_KINDS - 2 * PEL_BRICK_BENDS }; /* those on the faces across z are the last */
    const int planes[2] = { 0, b->voxels[2] - 1 }, places = (b->work->tolerance > 0 ? KINDS : 2) * SIDE * SIDE;
    const int ours[2] = { last[0] ? SIDE : SIDE - 1, last[1] ? SIDE : SIDE - 1 };
    for (int side = 0; side < 2; side++)
        for (int number = 0; number < places / (SIDE * SIDE); number++) {
            const uint32_t(*plane)[SIDE] = (const uint32_t(*)[SIDE])b->numbers->at[number < 2 ? number : FACES + number - 2][planes[side]];
            const uint64_t first = (uint64_t)brick * (uint64_t)places + (uint64_t)(number * SIDE * SIDE);
            for (int y = 0; y < ours[1]; y++)
                for (int x = 0; x < ours[0]; x++)
                    if (plane[y][x] != PEL_NO_VERTEX && !add_seam(b->slab, side, first + (uint64_t)(y * SIDE + x), plane[y][x], b->error))
                        return false;
        }
    return true;
}

/* ---- the slab ---- */

size_t pel_mesh_scratch_bytes(const struct pel_minmax *minmax)
{
    return 2 * minmax->cells.dims[0] * sizeof(struct pel_brick_numbers);
}

bool pel_mesh_slab_make(struct pel_mesh_slab *slab, const struct pel_mesh_work *work, size_t bz, void *scratch, struct pel_error *error)
{
    const struct pel_minmax_level *bricks = &work->minmax->cells;
    const size_t *n = bricks->dims;
    struct pel_brick_numbers *rows[2] = { scratch, (struct pel_brick_numbers *)scratch + n[0] };
    struct pel_brick b = { .work = work, .slab = slab, .error = error };
    const int kinds = work->tolerance > 0 ? PEL_BRICK_KINDS : 3;
    const bool fast = !(work->tolerance > 0) && !work->minmax->has_voids;
    for (size_t x = 0; x < n[0]; x++)
        rows[0][x].any = rows[1][x].any = false;
    for (size_t y = 0; y < n[1]; y++) {
        struct pel_brick_numbers *row = rows[y & 1], *before = rows[~y & 1];
        for (size_t x = 0; x < n[0]; x++) {
            size_t at = (bz * n[1] + y) * n[0] + x;
            const bool last[2] = { x == n[0] - 1, y == n[1] - 1 };
            row[x].any = false;
            if (!((double)bricks->least[at] < work->isovalue && (double)bricks->most[at] >= work->isovalue))
                continue;
            copy_shared(&row[x], kinds, filled(row, x - 1, n[0], x > 0), filled(before, x, n[0], y > 0),
                        filled(before, x + 1, n[0], y > 0));
            b.first[0] = x * PEL_CELL_SIZE, b.first[1] = y * PEL_CELL_SIZE, b.first[2] = bz * PEL_CELL_SIZE;
            b.numbers = &row[x];
            pel_brick_load(&b);
            if (!(fast ? pel_brick_cut_edges(&b) : pel_brick_cut(&b)) || !note_seams(&b, y * n[0] + x, last))
                return false;
        }
    }
    return true;
}
