/* SPDX-License-Identifier: MIT */
/* Facts of a mesh, and its end. */
#include <pellucid/mesh.h>

#include <math.h>
#include <stdlib.h>

#include "alloc.h"

void pel_mesh_destroy(struct pel_mesh *mesh)
{
    if (!mesh)
        return;
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->triangles);
    free(mesh);
}

bool pel_mesh_bounds(const struct pel_mesh *mesh, double bounds[6])
{
    float lo[3] = { INFINITY, INFINITY, INFINITY }, hi[3] = { -INFINITY, -INFINITY, -INFINITY };
    for (size_t v = 0; v < mesh->vertex_count; v++)
        for (int i = 0; i < 3; i++) {
            lo[i] = fminf(lo[i], mesh->positions[v][i]);
            hi[i] = fmaxf(hi[i], mesh->positions[v][i]);
        }
    for (int i = 0; i < 3; i++) {
        bounds[2 * i] = mesh->origin[i] + (double)lo[i];
        bounds[2 * i + 1] = mesh->origin[i] + (double)hi[i];
    }
    return mesh->vertex_count > 0;
}

bool pel_mesh_is_far(const struct pel_mesh *mesh)
{
    double bounds[6], extent = 0, most = 0;
    if (!pel_mesh_bounds(mesh, bounds))
        return false;
    for (int a = 0; a < 3; a++) {
        extent = fmax(extent, bounds[2 * a + 1] - bounds[2 * a]);
        most = fmax(most, fmax(fabs(bounds[2 * a]), fabs(bounds[2 * a + 1])));
    }
    return most > 256 * extent;
}

static int compare_vertices(const void *a, const void *b)
{
    const uint32_t *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* How many of these stand there once. Few, in a mesh: around six edges meet in a vertex. */
static size_t count_single(uint32_t *items, size_t count)
{
    enum { FEW = 16 };
    size_t single = 0;
    for (size_t i = 0; i < count && count <= FEW; i++) {
        bool again = false;
        for (size_t k = 0; k < count; k++)
            again |= k != i && items[k] == items[i];
        single += !again;
    }
    if (count <= FEW)
        return single;
    qsort(items, count, sizeof *items, compare_vertices);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && items[end] == items[i];)
            end++;
        single += end - i == 1;
    }
    return single;
}

/* Edges are put to the lesser of their vertices, where few of them meet. */
int64_t pel_mesh_open_edges(const struct pel_mesh *mesh)
{
    size_t count = 0, open = 0, before = 0;
    size_t *ends = pel_alloc(mesh->vertex_count, sizeof *ends, "edges", NULL);
    uint32_t *others = pel_mul(mesh->triangle_count, 3, &count) ? pel_alloc_aligned(count, sizeof *others, "edges", NULL) : NULL;
    bool fine = ends && others;
    for (size_t i = 0; fine && i < count; i++) {
        uint32_t a = mesh->triangles[i / 3][i % 3], b = mesh->triangles[i / 3][(i + 1) % 3];
        ends[a < b ? a : b]++;
    }
    for (size_t v = 0; fine && v < mesh->vertex_count; v++) {
        size_t here = ends[v];
        ends[v] = before;
        before += here;
    }
    for (size_t i = 0; fine && i < count; i++) {
        uint32_t a = mesh->triangles[i / 3][i % 3], b = mesh->triangles[i / 3][(i + 1) % 3];
        others[ends[a < b ? a : b]++] = a < b ? b : a;
    }
    for (size_t v = 0; fine && v < mesh->vertex_count; v++)
        open += count_single(others + (v ? ends[v - 1] : 0), ends[v] - (v ? ends[v - 1] : 0));
    free(ends);
    free(others);
    return fine ? (int64_t)open : -1;
}
