/* SPDX-License-Identifier: MIT */
/* From a volume to a mesh: slabs on all threads, then their seams, then one array of each kind. The slabs' own order gives the numbers, so
 * nothing depends on who made which. */
#include "mesh_extract.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "mesh_slab.h"
#include "parallel.h"
#include "vec.h"

/* A slab and where it goes in the mesh. */
struct item {
    struct pel_mesh_slab slab;
    uint32_t *numbers; /* owned: the mesh's number of each vertex of the slab */
    size_t number_room;
    size_t first_vertex, own_vertices, first_triangle;
    bool failed;
    struct pel_error error;
};

struct extraction {
    struct pel_mesh_work work;
    struct pel_mesh *mesh;
    struct item *items;
    size_t count, begun;               /* items; those of rounds before */
    size_t round;                      /* items that are made at once */
    size_t vertex_room, triangle_room; /* of the mesh */
    char *scratch;
    size_t scratch_size; /* a thread */
};

/* ---- slabs ---- */

static void make_item(void *context, size_t i, int thread)
{
    struct extraction *x = context;
    struct item *item = &x->items[x->begun + i];
    item->failed = !pel_mesh_slab_make(&item->slab, &x->work, x->begun + i, x->scratch + (size_t)thread * x->scratch_size, &item->error);
}

/* What a round ago was copied gives its memory, which is in the caches and need not be got from the system. Of that round the last slab is
 * still asked for its seam. */
static void reuse_memory(struct extraction *x, size_t count)
{
    for (size_t i = x->begun; x->begun && i < x->begun + count && i + 1 - x->round < x->begun; i++) {
        struct item *from = &x->items[i - x->round], *to = &x->items[i];
        to->slab = from->slab;
        to->slab.vertex_count = to->slab.triangle_count = to->slab.seam_count[0] = to->slab.seam_count[1] = 0;
        to->numbers = from->numbers;
        to->number_room = from->number_room;
        memset(&from->slab, 0, sizeof from->slab);
        from->numbers = NULL;
    }
}

static bool make_slabs(struct extraction *x, const struct pel_mesh_params *params, size_t count, struct pel_error *error)
{
    reuse_memory(x, count);
    pel_parallel_for(params->threads, count, make_item, x);
    for (size_t i = x->begun; i < x->begun + count; i++)
        if (x->items[i].failed)
            return pel_fail(error, x->items[i].error.code, "%s", x->items[i].error.message);
    return true;
}

/* ---- seams ---- */

/* Numbers a slab's vertices. Those on its lowest plane that the slab below has as well get the numbers that they have there. */
static bool number_item(struct item *item, const struct item *below, size_t first, struct pel_error *error)
{
    const struct pel_mesh_slab *s = &item->slab;
    item->first_vertex = first;
    if (s->vertex_count > item->number_room || !item->numbers) {
        free(item->numbers);
        item->numbers = pel_alloc(s->vertex_count, sizeof *item->numbers, "numbers of vertices", error);
        item->number_room = s->vertex_count;
    }
    if (!item->numbers)
        return false;
    memset(item->numbers, 0xff, s->vertex_count * sizeof *item->numbers);
    for (size_t i = 0, j = 0; below && i < s->seam_count[0] && j < below->slab.seam_count[1];) {
        const struct pel_mesh_seam *here = &s->seams[0][i], *there = &below->slab.seams[1][j];
        if (here->key == there->key)
            item->numbers[here->vertex] = below->numbers[there->vertex];
        i += here->key <= there->key;
        j += there->key <= here->key;
    }
    for (size_t i = 0; i < s->vertex_count; i++)
        if (item->numbers[i] == UINT32_MAX && first + item->own_vertices < UINT32_MAX)
            item->numbers[i] = (uint32_t)(first + item->own_vertices++);
        else if (item->numbers[i] == UINT32_MAX)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the surface has more vertices than 32 bits count; take another isovalue");
    return true;
}

static bool number_items(struct extraction *x, size_t count, size_t *vertices, size_t *triangles, struct pel_error *error)
{
    for (size_t i = x->begun; i < x->begun + count; i++) {
        struct item *item = &x->items[i];
        item->first_triangle = *triangles;
        if (!number_item(item, i ? &x->items[i - 1] : NULL, *vertices, error))
            return false;
        *vertices += item->own_vertices;
        *triangles += item->slab.triangle_count;
    }
    return true;
}

static void copy_item(void *context, size_t i, int thread)
{
    (void)thread;
    struct extraction *x = context;
    struct item *item = &x->items[x->begun + i];
    struct pel_mesh *mesh = x->mesh;
    for (size_t v = 0; v < item->slab.vertex_count; v++)
        if (item->numbers[v] >= item->first_vertex) {
            memcpy(mesh->positions[item->numbers[v]], item->slab.positions[v], sizeof *mesh->positions);
            memcpy(mesh->normals[item->numbers[v]], item->slab.normals[v], sizeof *mesh->normals);
        }
    for (size_t t = 0; t < item->slab.triangle_count; t++)
        for (int c = 0; c < 3; c++)
            mesh->triangles[item->first_triangle + t][c] = item->numbers[item->slab.triangles[t][c]];
}

/* ---- the mesh ---- */

static bool resize(void **array, size_t count, size_t size, const char *what, struct pel_error *error)
{
    size_t bytes;
    void *other = pel_mul(count ? count : 1, size, &bytes) ? realloc(*array, bytes) : NULL;
    if (!other)
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu %s of the surface", count, what);
    *array = other;
    return true;
}

static bool resize_mesh(struct extraction *x, size_t vertices, size_t triangles, struct pel_error *error)
{
    struct pel_mesh *mesh = x->mesh;
    x->vertex_room = vertices;
    x->triangle_room = triangles;
    return resize((void **)&mesh->positions, vertices, sizeof *mesh->positions, "vertices", error) &&
           resize((void **)&mesh->normals, vertices, sizeof *mesh->normals, "normals", error) &&
           resize((void **)&mesh->triangles, triangles, sizeof *mesh->triangles, "triangles", error);
}

static size_t with_reserve(size_t count, size_t room)
{
    return count <= room ? room : count > SIZE_MAX / 2 ? count : count + count / 2;
}

/* In rounds, between which progress is told. */
static bool make_part(struct extraction *x, const struct pel_mesh_params *params, int part, size_t *vertices, size_t *triangles,
                      struct pel_error *error)
{
    for (x->begun = 0; x->begun < x->count; x->begun += x->round) {
        size_t now = x->count - x->begun < x->round ? x->count - x->begun : x->round;
        if (!pel_progress_report(&params->progress, (part + (double)x->begun / (double)x->count) / params->isovalue_count, error) ||
            !make_slabs(x, params, now, error) || !number_items(x, now, vertices, triangles, error))
            return false;
        if ((*vertices > x->vertex_room || *triangles > x->triangle_room) &&
            !resize_mesh(x, with_reserve(*vertices, x->vertex_room), with_reserve(*triangles, x->triangle_room), error))
            return false;
        pel_parallel_for(params->threads, now, copy_item, x);
    }
    return true;
}

static bool add_part(struct extraction *x, const struct pel_mesh_params *params, int number, struct pel_error *error)
{
    struct pel_mesh *mesh = x->mesh;
    size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    x->work.isovalue = params->isovalues[number];
    x->work.tolerance = params->tolerance;
    x->items = pel_alloc(x->count, sizeof *x->items, "parts of the surface", error);
    bool ok = x->items && make_part(x, params, number, &vertices, &triangles, error);
    if (ok) {
        mesh->parts[mesh->part_count++] =
            (struct pel_mesh_part) { params->isovalues[number], mesh->vertex_count, vertices - mesh->vertex_count, mesh->triangle_count,
                                     triangles - mesh->triangle_count };
        mesh->vertex_count = vertices;
        mesh->triangle_count = triangles;
    }
    for (size_t i = 0; x->items && i < x->count; i++) {
        free(x->items[i].numbers);
        pel_mesh_slab_finish(&x->items[i].slab);
    }
    free(x->items);
    x->items = NULL;
    return ok;
}

static bool check(const struct pel_volume *volume, const struct pel_mesh_params *params, struct pel_error *error)
{
    if (!pel_volume_check(volume, error))
        return false;
    if (volume->components != 1)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a surface is of one number a sample, and these have %d; take the magnitude",
                        volume->components);
    if (params->isovalue_count < 1 || params->isovalue_count > PEL_MAX_ISOSURFACES)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%d isovalues cannot be; give 1 to %d", params->isovalue_count, PEL_MAX_ISOSURFACES);
    for (int i = 0; i < params->isovalue_count; i++)
        if (!isfinite(params->isovalues[i]))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "isovalue %d is not finite", i);
    if (!(params->tolerance >= 0))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a tolerance of %g voxels cannot be; it is 0 or more", params->tolerance);
    for (int a = 0; a < 3; a++)
        if (volume->dims[a] < 2)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the volume is flat: one sample along %c; a surface needs two", 'x' + a);
    return true;
}

static void place(struct pel_mesh_work *work, const struct pel_volume *v)
{
    double inverse[3][3];
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            work->to_world[i][a] = v->direction[a][i] * v->spacing[a];
    work->mirrored = pel_invert3((const double(*)[3])work->to_world, inverse) < 0;
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            work->normal[i][a] = inverse[a][i];
}

struct pel_mesh *pel_mesh_extract_by(const struct pel_volume *volume, const struct pel_minmax *minmax, const struct pel_mesh_params *params,
                                     struct pel_error *error)
{
    struct extraction x = { .work = { .volume = volume, .minmax = minmax }, .count = minmax->cells.dims[2] };
    struct pel_cell_table *table = pel_alloc(1, sizeof *table, "the table of cells", error);
    x.mesh = pel_alloc(1, sizeof *x.mesh, "mesh", error);
    x.scratch_size = pel_mesh_scratch_bytes(minmax);
    x.scratch = pel_alloc((size_t)pel_threads(params->threads), x.scratch_size, "rows of bricks", error);
    bool ok = table && x.mesh && x.scratch;
    if (ok) {
        pel_cell_table_init(table);
        place(&x.work, volume);
        x.work.table = table;
        memcpy(x.mesh->origin, volume->origin, sizeof volume->origin);
        memcpy(x.mesh->units, volume->units, sizeof volume->units);
        memcpy(x.mesh->name, volume->name, sizeof volume->name);
        x.mesh->space = volume->space;
    }
    x.round = (size_t)pel_threads(params->threads) * 8;
    for (int i = 0; ok && i < params->isovalue_count; i++)
        ok = add_part(&x, params, i, error);
    ok = ok && resize_mesh(&x, x.mesh->vertex_count, x.mesh->triangle_count, error);
    free(x.scratch);
    free(table);
    if (!ok) {
        pel_mesh_destroy(x.mesh);
        x.mesh = NULL;
    }
    return x.mesh;
}

struct pel_mesh *pel_mesh_extract(const struct pel_volume *volume, const struct pel_mesh_params *params, struct pel_error *error)
{
    struct pel_minmax minmax;
    struct pel_mesh *mesh = NULL;
    if (!check(volume, params, error))
        return NULL;
    if (pel_minmax_init(&minmax, volume, params->threads, error))
        mesh = pel_mesh_extract_by(volume, &minmax, params, error);
    pel_minmax_finish(&minmax);
    return mesh;
}
