/* SPDX-License-Identifier: MIT */
/* Surfaces in noise, which meets every way to cut a cell: that nothing is missing, nothing twice, and nothing where voids are. */
#include "mesh_facts.h"

static bool cell_is_whole(const struct pel_volume *v, const size_t cell[3])
{
    for (size_t c = 0; c < 8; c++)
        if (pel_volume_is_void(v, pel_volume_get(v, cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2), 0)))
            return false;
    return true;
}

/* Whether some cell without voids has the edge from a voxel along an axis. */
static bool edge_counts(const struct pel_volume *v, const size_t at[3], int axis)
{
    for (size_t side = 0; side < 4; side++) {
        size_t cell[3] = { at[0], at[1], at[2] };
        int b = (axis + 1) % 3, c = (axis + 2) % 3;
        if (cell[b] < (side & 1) || cell[c] < side >> 1)
            continue;
        cell[b] -= side & 1, cell[c] -= side >> 1;
        if (cell[b] + 1 < v->dims[b] && cell[c] + 1 < v->dims[c] && cell_is_whole(v, cell))
            return true;
    }
    return false;
}

/* How many edges of the grid the surface must cut. */
static size_t count_cuts(const struct pel_volume *v, double isovalue)
{
    size_t cuts = 0;
    for (size_t z = 0; z < v->dims[2]; z++)
        for (size_t y = 0; y < v->dims[1]; y++)
            for (size_t x = 0; x < v->dims[0]; x++)
                for (int axis = 0; axis < 3; axis++) {
                    const size_t at[3] = { x, y, z };
                    size_t to[3] = { x, y, z };
                    if (++to[axis] == v->dims[axis])
                        continue;
                    bool a = pel_volume_get(v, x, y, z, 0) >= isovalue, b = pel_volume_get(v, to[0], to[1], to[2], 0) >= isovalue;
                    cuts += a != b && edge_counts(v, at, axis);
                }
    return cuts;
}

/* Vertices that lie on an edge of the grid, and not amidst a cell. */
static size_t count_on_edges(const struct pel_volume *v, const struct pel_mesh *mesh)
{
    size_t count = 0;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double p[3];
        int whole = 0;
        index_of(v, mesh, i, p);
        for (int a = 0; a < 3; a++)
            whole += fabs(p[a] - round(p[a])) < 1e-5;
        count += whole >= 2;
    }
    return count;
}

/* All sizes about those of bricks, and noise that meets every way to cut a cell: each crossing has its vertex once, and nothing leaks. */
static void test_noise(void **state)
{
    (void)state;
    static const size_t sizes[][3] = { { 2, 2, 2 },  { 3, 5, 2 },   { 5, 5, 5 },  { 6, 4, 9 },
                                       { 8, 9, 10 }, { 13, 2, 17 }, { 2, 31, 3 }, { 24, 25, 26 } };
    seed = 1;
    for (size_t i = 0; i < 2 * sizeof sizes / sizeof *sizes; i++) {
        struct pel_volume v;
        bool smooth = i & 1;
        make_noise(&v, sizes[i / 2][0], sizes[i / 2][1], sizes[i / 2][2], smooth);
        for (int k = 1; k < 6; k++) {
            double isovalue = smooth ? k / 6.0 : k;
            size_t cuts = count_cuts(&v, isovalue);
            for (int finer = 0; finer < 3; finer++) {
                struct pel_mesh *mesh = extract_within(&v, isovalue, finer == 2 ? 0.001 : finer * 0.05, 2);
                expect_watertight(&v, mesh);
                size_t on_edges = count_on_edges(&v, mesh);
                assert_true(smooth ? on_edges == cuts : on_edges >= cuts); /* a mean of places that are voxels may be one */
                pel_mesh_destroy(mesh);
            }
        }
        pel_volume_finish(&v);
    }
}

/* Noise in a shell of outside values has no border: the surface is closed. */
static void test_closed_noise(void **state)
{
    (void)state;
    struct pel_volume v;
    seed = 7;
    make_noise(&v, 33, 30, 35, true);
    for (size_t z = 0; z < 35; z++)
        for (size_t y = 0; y < 30; y++)
            for (size_t x = 0; x < 33; x++)
                if (!x || !y || !z || x == 32 || y == 29 || z == 34)
                    ((float *)v.data)[(z * 30 + y) * 33 + x] = 0;
    for (int k = 1; k < 6; k++) {
        struct pel_mesh *mesh = extract_within(&v, k / 6.0, k % 2 * 0.05, 2);
        assert_int_equal(expect_watertight(&v, mesh) % 2, 0);
        assert_int_equal(pel_mesh_open_edges(mesh), 0);
        assert_true(enclosed(mesh) > 0);
        pel_mesh_destroy(mesh);
    }
    pel_volume_finish(&v);
}

/* No triangle lies in a cell that has a void; all other crossings are there, once. */
static void test_voids(void **state)
{
    (void)state;
    struct pel_volume v;
    seed = 3;
    for (int round = 0; round < 6; round++) {
        make_noise(&v, 14, 19, 15, true);
        for (size_t i = 0; i < 14 * 19 * 15; i++)
            if (random_number() < 0.02 * (round + 1))
                ((float *)v.data)[i] = round & 1 ? 2 : NAN;
        v.has_void = round & 1;
        v.void_value = 2;
        struct pel_mesh *mesh = extract_within(&v, 0.5, round / 2 * 0.03, 1);
        assert_int_equal(count_on_edges(&v, mesh), count_cuts(&v, 0.5));
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            double middle[3] = { 0, 0, 0 };
            for (int c = 0; c < 3; c++) {
                double p[3];
                index_of(&v, mesh, mesh->triangles[t][c], p);
                for (int a = 0; a < 3; a++)
                    middle[a] += p[a] / 3;
            }
            const size_t cell[3] = { (size_t)middle[0], (size_t)middle[1], (size_t)middle[2] };
            assert_true(cell_is_whole(&v, cell));
        }
        struct edge *edges = sorted_edges(mesh);
        for (size_t i = 1; i < 3 * mesh->triangle_count; i++)
            assert_true(compare_edges(&edges[i - 1], &edges[i]) != 0);
        free(edges);
        pel_mesh_destroy(mesh);
        pel_volume_finish(&v);
    }
}

/* How far the trilinear signal is from the isovalue, in the direction of its gradient: about how far away its surface is. */
static double off_by(const struct pel_volume *v, const double p[3], double isovalue)
{
    size_t c[3];
    double f[3], g[3] = { 0, 0, 0 }, value = -isovalue;
    for (int a = 0; a < 3; a++) {
        c[a] = (size_t)fmin(fmax(p[a], 0), (double)v->dims[a] - 2);
        f[a] = p[a] - (double)c[a];
    }
    for (size_t i = 0; i < 8; i++) {
        const double o[3] = { (double)(i & 1), (double)(i >> 1 & 1), (double)(i >> 2) };
        double at = pel_volume_get(v, c[0] + (i & 1), c[1] + (i >> 1 & 1), c[2] + (i >> 2), 0), w[3];
        for (int a = 0; a < 3; a++)
            w[a] = o[a] > 0 ? f[a] : 1 - f[a];
        value += at * w[0] * w[1] * w[2];
        for (int a = 0; a < 3; a++)
            g[a] += at * (o[a] > 0 ? 1 : -1) * w[(a + 1) % 3] * w[(a + 2) % 3];
    }
    return fabs(value) / fmax(sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), 1e-3);
}

/* Mean over the triangles' areas of how far their middles are off. */
static double mean_distance(const struct pel_volume *v, const struct pel_mesh *mesh, double isovalue)
{
    double sum = 0, areas = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double p[3][3], middle[3], n[3];
        for (int c = 0; c < 3; c++)
            index_of(v, mesh, mesh->triangles[t][c], p[c]);
        for (int a = 0; a < 3; a++) {
            int b = (a + 1) % 3, c = (a + 2) % 3;
            middle[a] = (p[0][a] + p[1][a] + p[2][a]) / 3;
            n[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
        }
        double area = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        sum += area * off_by(v, middle, isovalue);
        areas += area;
    }
    return sum / areas;
}

/* With a tolerance the surface goes where the trilinear signal's does. In noise, which is curved as nothing else is. */
static void test_tolerance(void **state)
{
    (void)state;
    struct pel_volume v;
    seed = 13;
    make_noise(&v, 20, 20, 20, true);
    struct pel_mesh *plain = extract(&v, 0.5, 2), *finer = extract_within(&v, 0.5, 0.05, 2), *finest = extract_within(&v, 0.5, 1e-4, 2);
    double off[3] = { mean_distance(&v, plain, 0.5), mean_distance(&v, finer, 0.5), mean_distance(&v, finest, 0.5) };
    print_message("%zu, %zu and %zu triangles: %.4f, %.4f and %.4f voxels off in the mean\n", plain->triangle_count, finer->triangle_count,
                  finest->triangle_count, off[0], off[1], off[2]);
    assert_true(off[1] < 0.4 * off[0] && off[2] < off[1]);
    assert_true(plain->triangle_count < finer->triangle_count && finer->triangle_count < finest->triangle_count);
    pel_mesh_destroy(plain);
    pel_mesh_destroy(finer);
    pel_mesh_destroy(finest);
    pel_volume_finish(&v);
}

/* A vertex with its normal, by place. */
static int compare_vertices(const void *p, const void *q)
{
    const float *a = p, *b = q;
    for (int i = 0; i < 3; i++)
        if (fabsf(a[i] - b[i]) > 1e-5f)
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static float (*sorted_vertices(const struct pel_mesh *mesh))[6]
{
    float(*all)[6] = malloc((mesh->vertex_count + 1) * sizeof *all);
    assert_non_null(all);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        memcpy(all[i], mesh->positions[i], sizeof mesh->positions[i]);
        memcpy(all[i] + 3, mesh->normals[i], sizeof mesh->normals[i]);
    }
    qsort(all, mesh->vertex_count, sizeof *all, compare_vertices);
    return all;
}

/* Volumes with voids go cell by cell, others row by row: where no surface is near the only void both make the same one. */
static void test_rows_and_cells(void **state)
{
    (void)state;
    struct pel_volume v;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        seed = 29;
        make_noise(&v, 23, 18, 21, true);
        memcpy(v.spacing, (double[3]){ 1, 0.7, 1.6 }, sizeof v.spacing);
        v.direction[0][0] = mirrored ? -1 : 1;
        for (size_t z = 0; z < 3; z++)
            for (size_t y = 0; y < 3; y++)
                for (size_t x = 0; x < 3; x++)
                    ((float *)v.data)[(z * 18 + y) * 23 + x] = 0.1f;
        struct pel_mesh *rows = extract(&v, 0.5, 2);
        ((float *)v.data)[0] = NAN;
        struct pel_mesh *cells = extract(&v, 0.5, 2);
        assert_true(rows->vertex_count > 5000);
        assert_int_equal(rows->vertex_count, cells->vertex_count);
        assert_int_equal(rows->triangle_count, cells->triangle_count);
        assert_true(fabs(enclosed(rows) - enclosed(cells)) < 1e-3);
        float(*a)[6] = sorted_vertices(rows), (*b)[6] = sorted_vertices(cells), worst = 0;
        for (size_t i = 0; i < rows->vertex_count; i++)
            for (int c = 0; c < 6; c++)
                worst = fmaxf(worst, fabsf(a[i][c] - b[i][c]));
        print_message("%zu vertices: %g apart at most, places and normals\n", rows->vertex_count, (double)worst);
        assert_true(worst < 2e-5f);
        free(a);
        free(b);
        pel_mesh_destroy(rows);
        pel_mesh_destroy(cells);
        pel_volume_finish(&v);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_closed_noise),
        cmocka_unit_test(test_voids),
        cmocka_unit_test(test_tolerance),
        cmocka_unit_test(test_rows_and_cells),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
