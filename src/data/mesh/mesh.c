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

static int compare_edges(const void *a, const void *b)
{
    const uint64_t *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

int64_t pel_mesh_open_edges(const struct pel_mesh *mesh)
{
    size_t count, open = 0;
    uint64_t *edges = pel_mul(mesh->triangle_count, 3, &count) ? pel_alloc(count, sizeof *edges, "edges", NULL) : NULL;
    if (!edges)
        return -1;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (size_t i = 0; i < 3; i++) {
            uint64_t a = mesh->triangles[t][i], b = mesh->triangles[t][(i + 1) % 3];
            edges[3 * t + i] = a < b ? a << 32 | b : b << 32 | a;
        }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && edges[end] == edges[i];)
            end++;
        open += end - i == 1;
    }
    free(edges);
    return (int64_t)open;
}
