/* SPDX-License-Identifier: MIT */
#include "mesh_facts.h"

unsigned seed;

double random_number(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / 16777216.0;
}

enum { FEW = 6 }; /* values of noise: many are the isovalue itself */

void make_noise(struct pel_volume *v, size_t nx, size_t ny, size_t nz, bool smooth)
{
    const size_t dims[3] = { nx, ny, nz };
    pel_volume_init(v);
    assert_true(pel_volume_allocate(v, dims, smooth ? PEL_F32 : PEL_U8, 1, NULL));
    for (size_t i = 0; i < nx * ny * nz; i++)
        if (smooth)
            ((float *)v->data)[i] = (float)random_number();
        else
            ((unsigned char *)v->data)[i] = (unsigned char)(random_number() * FEW);
    pel_volume_update_range(v);
}

int compare_edges(const void *p, const void *q)
{
    const struct edge *a = p, *b = q;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return (a->b > b->b) - (a->b < b->b);
}

struct edge *sorted_edges(const struct pel_mesh *mesh)
{
    struct edge *edges = malloc((3 * mesh->triangle_count + 1) * sizeof *edges);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 0; i < 3; i++)
            edges[3 * t + (size_t)i] = (struct edge) { mesh->triangles[t][i], mesh->triangles[t][(i + 1) % 3] };
    qsort(edges, 3 * mesh->triangle_count, sizeof *edges, compare_edges);
    return edges;
}

void index_of(const struct pel_volume *v, const struct pel_mesh *mesh, size_t vertex, double index[3])
{
    double world[3];
    for (int i = 0; i < 3; i++)
        world[i] = mesh->origin[i] + (double)mesh->positions[vertex][i];
    pel_volume_world_to_index(v, world, index);
}

/* Whether both ends of an edge lie on one face of the volume's box, where a surface may be open. */
static bool on_border(const struct pel_volume *v, const struct pel_mesh *mesh, struct edge edge)
{
    double p[3], q[3];
    index_of(v, mesh, edge.a, p);
    index_of(v, mesh, edge.b, q);
    for (int a = 0; a < 3; a++) {
        double last = (double)v->dims[a] - 1;
        if ((fabs(p[a]) < 1e-3 && fabs(q[a]) < 1e-3) || (fabs(p[a] - last) < 1e-3 && fabs(q[a] - last) < 1e-3))
            return true;
    }
    return false;
}

long expect_watertight(const struct pel_volume *v, const struct pel_mesh *mesh)
{
    struct edge *edges = sorted_edges(mesh);
    size_t count = 3 * mesh->triangle_count, open = 0;
    bool *used = calloc(mesh->vertex_count + 1, sizeof *used);
    for (size_t i = 0; i < count; i++) {
        const struct edge back = { edges[i].b, edges[i].a };
        used[edges[i].a] = true;
        assert_true(edges[i].a != edges[i].b);
        assert_true(i == 0 || compare_edges(&edges[i - 1], &edges[i]) != 0);
        if (!bsearch(&back, edges, count, sizeof *edges, compare_edges)) {
            assert_true(on_border(v, mesh, edges[i]));
            open++;
        }
    }
    for (size_t i = 0; i < mesh->vertex_count; i++)
        assert_true(used[i]);
    assert_int_equal(open, pel_mesh_open_edges(mesh));
    free(used);
    free(edges);
    return (long)mesh->vertex_count - (long)((count + open) / 2) + (long)mesh->triangle_count;
}

double enclosed(const struct pel_mesh *mesh)
{
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const float *a = mesh->positions[mesh->triangles[t][0]], *b = mesh->positions[mesh->triangles[t][1]],
                    *c = mesh->positions[mesh->triangles[t][2]];
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            sum += (double)a[i] * ((double)b[j] * (double)c[k] - (double)b[k] * (double)c[j]);
        }
    }
    return sum;
}

struct pel_mesh *extract_within(const struct pel_volume *v, double isovalue, double tolerance, int threads)
{
    struct pel_mesh_params params = { .isovalues = { isovalue }, .isovalue_count = 1, .tolerance = tolerance, .threads = threads };
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_mesh *mesh = pel_mesh_extract(v, &params, &error);
    if (!mesh)
        fail_msg("%s", error.message);
    return mesh;
}

struct pel_mesh *extract(const struct pel_volume *v, double isovalue, int threads)
{
    return extract_within(v, isovalue, 0, threads);
}

void expect_same(const struct pel_mesh *a, const struct pel_mesh *b)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->positions, b->positions, a->vertex_count * sizeof *a->positions);
    assert_memory_equal(a->normals, b->normals, a->vertex_count * sizeof *a->normals);
    assert_memory_equal(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles);
}
