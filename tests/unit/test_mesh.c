/* SPDX-License-Identifier: MIT */
/* Surfaces as triangles: where they lie, which way they look, and that nothing is missing or twice in them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/pellucid.h>

static unsigned seed;

static double random_number(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / 16777216.0;
}

/* ---- facts of a mesh ---- */

struct edge {
    uint32_t a, b; /* as a triangle goes along it */
};

static int compare_edges(const void *p, const void *q)
{
    const struct edge *a = p, *b = q;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return (a->b > b->b) - (a->b < b->b);
}

static struct edge *sorted_edges(const struct pel_mesh *mesh)
{
    struct edge *edges = malloc((3 * mesh->triangle_count + 1) * sizeof *edges);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 0; i < 3; i++)
            edges[3 * t + (size_t)i] = (struct edge){ mesh->triangles[t][i], mesh->triangles[t][(i + 1) % 3] };
    qsort(edges, 3 * mesh->triangle_count, sizeof *edges, compare_edges);
    return edges;
}

/* The index position of a vertex. */
static void index_of(const struct pel_volume *v, const struct pel_mesh *mesh, size_t vertex, double index[3])
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

/* No crack and nothing twice: each edge is gone along once in each direction, but for those on the volume's border, which are gone
 * along once in all. Every vertex is used. Returns V - E + F. */
static long expect_watertight(const struct pel_volume *v, const struct pel_mesh *mesh)
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

/* Six times the volume that a closed mesh encloses: positive where its triangles look outwards. */
static double enclosed(const struct pel_mesh *mesh)
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

static struct pel_mesh *extract_within(const struct pel_volume *v, double isovalue, double tolerance, int threads)
{
    struct pel_mesh_params params = { .isovalues = { isovalue }, .isovalue_count = 1, .tolerance = tolerance, .threads = threads };
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_mesh *mesh = pel_mesh_extract(v, &params, &error);
    if (!mesh)
        fail_msg("%s", error.message);
    return mesh;
}

static struct pel_mesh *extract(const struct pel_volume *v, double isovalue, int threads)
{
    return extract_within(v, isovalue, 0, threads);
}

static void expect_same(const struct pel_mesh *a, const struct pel_mesh *b)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->positions, b->positions, a->vertex_count * sizeof *a->positions);
    assert_memory_equal(a->normals, b->normals, a->vertex_count * sizeof *a->normals);
    assert_memory_equal(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles);
}

/* ---- analytic surfaces ---- */

static void make(struct pel_volume *v, const char *name, const char *size)
{
    const struct pel_dataset *dataset = pel_dataset_find(name);
    void *params = pel_dataset_create_params(dataset);
    const struct pel_option *row = dataset->options;
    while (strcmp(row->name, "size") != 0)
        row++;
    pel_volume_init(v);
    assert_true(pel_option_set(row, params, size, NULL));
    assert_true(pel_dataset_make(dataset, params, v, NULL));
    free(params);
}

/* Value and gradient of the sets in the world's coordinates; radii are the sets' defaults. */
static double sphere(const double p[3], double g[3])
{
    double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (int i = 0; i < 3; i++)
        g[i] = -p[i] / r;
    return -r;
}

static double torus(const double p[3], double g[3])
{
    const double ring = 0.6;
    double r = sqrt(p[0] * p[0] + p[1] * p[1]), d = sqrt((r - ring) * (r - ring) + p[2] * p[2]);
    g[0] = -p[0] / r * (r - ring) / d, g[1] = -p[1] / r * (r - ring) / d, g[2] = -p[2] / d;
    return -d;
}

/* Distance and angle to what the formula says, at each vertex. `level`: the formula's value on the surface. On the volume's border the
 * gradient is the ray caster's, whose differences end there: no angle is asked for. */
static void expect_on_surface(const struct pel_volume *v, const struct pel_mesh *mesh, double (*formula)(const double p[3], double g[3]),
                              double level)
{
    double farthest = 0, least = 1;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double p[3], g[3], dot = 0, length = 0;
        bool border = false;
        index_of(v, mesh, i, p);
        for (int a = 0; a < 3; a++) {
            border |= p[a] < 1 || p[a] > (double)v->dims[a] - 2;
            p[a] = mesh->origin[a] + (double)mesh->positions[i][a];
        }
        double away = formula(p, g) - level;
        for (int a = 0; a < 3; a++) {
            dot -= g[a] * (double)mesh->normals[i][a];
            length += g[a] * g[a];
        }
        farthest = fmax(farthest, fabs(away) / sqrt(length) / v->spacing[0]);
        least = border ? least : fmin(least, dot / sqrt(length));
    }
    print_message("%zu vertices, at most %.5f voxels off, %.3f degrees off\n", mesh->vertex_count, farthest, acos(least) * 180 / 3.14159265);
    assert_true(farthest < 0.01);
    assert_true(acos(least) * 180 / 3.14159265 < 1);
}

static double gyroid(const double p[3], double g[3])
{
    for (int i = 0; i < 3; i++)
        g[i] = cos(p[i]) * cos(p[(i + 1) % 3]) - sin(p[(i + 2) % 3]) * sin(p[i]);
    return sin(p[0]) * cos(p[1]) + sin(p[1]) * cos(p[2]) + sin(p[2]) * cos(p[0]);
}

static void test_sphere(void **state)
{
    (void)state;
    struct pel_volume v;
    make(&v, "sphere", "64");
    struct pel_mesh *mesh = extract(&v, 0, 2);
    double p[3] = { 0, 0, 1 }, g[3], level = sphere(p, g) + 1 - 0.7;
    expect_on_surface(&v, mesh, sphere, level);
    assert_int_equal(expect_watertight(&v, mesh), 2);
    assert_true(fabs(enclosed(mesh) / 6 / (4 * 3.14159265 / 3 * 0.343) - 1) < 0.005);
    pel_mesh_destroy(mesh);
    pel_volume_finish(&v);
}

static void test_torus(void **state)
{
    (void)state;
    struct pel_volume v;
    make(&v, "torus", "128");
    struct pel_mesh *mesh = extract(&v, 0, 2);
    expect_on_surface(&v, mesh, torus, -0.25);
    assert_int_equal(expect_watertight(&v, mesh), 0);
    assert_true(enclosed(mesh) > 0);
    pel_mesh_destroy(mesh);
    pel_volume_finish(&v);
}

static void test_gyroid(void **state)
{
    (void)state;
    struct pel_volume v;
    make(&v, "gyroid", "128");
    struct pel_mesh *mesh = extract(&v, 0, 2);
    expect_on_surface(&v, mesh, gyroid, 0);
    expect_watertight(&v, mesh);
    assert_true(pel_mesh_open_edges(mesh) > 0); /* it goes on beyond the box */
    pel_mesh_destroy(mesh);
    pel_volume_finish(&v);
}

/* ---- stress ---- */

enum { FEW = 6 }; /* values of noise: many are the isovalue itself */

static void make_noise(struct pel_volume *v, size_t nx, size_t ny, size_t nz, bool smooth)
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
    static const size_t sizes[][3] = { { 2, 2, 2 }, { 3, 5, 2 }, { 5, 5, 5 }, { 6, 4, 9 }, { 8, 9, 10 }, { 13, 2, 17 }, { 2, 31, 3 }, { 24, 25, 26 } };
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

/* A sheared, mirrored placement far from the world's zero: the surface is where it was, looks outwards, and normals stay normal. */
static void test_placement(void **state)
{
    (void)state;
    struct pel_volume v;
    make(&v, "sphere", "40");
    struct pel_mesh *plain = extract(&v, 0, 1);
    static const double directions[3][3] = { { 0, 1, 0 }, { 1, 0, 0 }, { 0.6, 0, 0.8 } }, spacing[3] = { 0.5, 2, 3 }, origin[3] = { 5e6, -4e6, 9 };
    memcpy(v.direction, directions, sizeof directions);
    memcpy(v.spacing, spacing, sizeof spacing);
    memcpy(v.origin, origin, sizeof origin);
    struct pel_mesh *placed = extract(&v, 0, 1);
    double bounds[6], box[6];
    assert_true(enclosed(plain) > 0 && enclosed(placed) > 0);
    assert_int_equal(expect_watertight(&v, placed), 2);
    assert_int_equal(plain->triangle_count, placed->triangle_count);
    assert_true(pel_mesh_bounds(placed, bounds));
    pel_volume_bounds(&v, box);
    for (int i = 0; i < 3; i++) {
        assert_true(bounds[2 * i] > box[2 * i] && bounds[2 * i + 1] < box[2 * i + 1]);
        assert_true(placed->origin[i] == origin[i]);
    }
    for (size_t t = 0; t < placed->triangle_count; t++) { /* the normals go with the triangles */
        const uint32_t *corner = placed->triangles[t];
        const float *a = placed->positions[corner[0]], *b = placed->positions[corner[1]], *c = placed->positions[corner[2]];
        double p[3], q[3], dot = 0;
        for (int i = 0; i < 3; i++)
            p[i] = (double)b[i] - (double)a[i], q[i] = (double)c[i] - (double)a[i];
        for (int i = 0; i < 3; i++)
            dot += (p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3]) * (double)placed->normals[corner[0]][i];
        assert_true(dot > -1e-6);
    }
    pel_mesh_destroy(plain);
    pel_mesh_destroy(placed);
    pel_volume_finish(&v);
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

static void test_threads(void **state)
{
    (void)state;
    struct pel_volume v;
    seed = 5;
    make_noise(&v, 40, 37, 43, true);
    for (int i = 0; i < 2; i++) {
        struct pel_mesh *one = extract_within(&v, 0.4, i * 0.02, 1), *four = extract_within(&v, 0.4, i * 0.02, 4);
        expect_same(one, four);
        pel_mesh_destroy(one);
        pel_mesh_destroy(four);
    }
    pel_volume_finish(&v);
}

/* Each type of number gives the same surface of the same values. */
static void test_types(void **state)
{
    (void)state;
    struct pel_volume v, u;
    seed = 11;
    make_noise(&v, 12, 13, 14, false);
    struct pel_mesh *expected = extract(&v, 2.5, 1);
    for (enum pel_type type = 0; type < PEL_TYPE_COUNT; type++) {
        pel_volume_init(&u);
        assert_true(pel_volume_allocate(&u, v.dims, type, 1, NULL));
        for (size_t i = 0; i < 12 * 13 * 14; i++) {
            unsigned char value = ((unsigned char *)v.data)[i];
            switch (type) {
            case PEL_U8: case PEL_I8: ((unsigned char *)u.data)[i] = value; break;
            case PEL_U16: case PEL_I16: ((unsigned short *)u.data)[i] = value; break;
            case PEL_U32: case PEL_I32: ((unsigned *)u.data)[i] = value; break;
            case PEL_F32: ((float *)u.data)[i] = value; break;
            default: ((double *)u.data)[i] = value;
            }
        }
        struct pel_mesh *mesh = extract(&u, 2.5, 1);
        expect_same(expected, mesh);
        pel_mesh_destroy(mesh);
        pel_volume_finish(&u);
    }
    pel_mesh_destroy(expected);
    pel_volume_finish(&v);
}

/* Several isovalues: each part is what it is alone; one that nothing reaches is empty. */
static void test_parts(void **state)
{
    (void)state;
    struct pel_volume v;
    make(&v, "sphere", "32");
    struct pel_mesh_params params = { .isovalues = { 0.2, 99, -0.1 }, .isovalue_count = 3, .threads = 2 };
    struct pel_mesh *mesh = pel_mesh_extract(&v, &params, NULL), *alone = extract(&v, -0.1, 1);
    assert_non_null(mesh);
    assert_int_equal(mesh->part_count, 3);
    assert_int_equal(mesh->parts[1].vertex_count, 0);
    assert_int_equal(mesh->parts[1].triangle_count, 0);
    const struct pel_mesh_part *last = &mesh->parts[2];
    assert_true(last->isovalue == -0.1);
    assert_int_equal(last->first_vertex, mesh->parts[0].vertex_count);
    assert_int_equal(last->vertex_count, alone->vertex_count);
    assert_int_equal(last->triangle_count, alone->triangle_count);
    assert_int_equal(mesh->vertex_count, last->first_vertex + last->vertex_count);
    assert_memory_equal(mesh->positions + last->first_vertex, alone->positions, alone->vertex_count * sizeof *alone->positions);
    for (size_t t = 0; t < alone->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            assert_int_equal(mesh->triangles[last->first_triangle + t][c], alone->triangles[t][c] + last->first_vertex);
    pel_mesh_destroy(mesh);
    pel_mesh_destroy(alone);
    pel_volume_finish(&v);
}

static bool cancel(void *user, double fraction)
{
    (void)user;
    (void)fraction;
    return false;
}

static void expect_refused(const struct pel_volume *v, const struct pel_mesh_params *params, enum pel_error_code code, const char *words)
{
    struct pel_error error = PEL_ERROR_INIT;
    assert_null(pel_mesh_extract(v, params, &error));
    assert_int_equal(error.code, code);
    assert_non_null(strstr(error.message, words));
}

static void test_refusals(void **state)
{
    (void)state;
    struct pel_volume v, flat;
    const size_t dims[3] = { 4, 4, 1 };
    make(&v, "sphere", "16");
    struct pel_mesh_params none = PEL_MESH_PARAMS_INIT, bad = { .isovalues = { 0, NAN }, .isovalue_count = 2 },
                           below = { .isovalue_count = 1, .tolerance = -1 }, one = { .isovalues = { 0 }, .isovalue_count = 1 }, stopped = one;
    stopped.progress = (struct pel_progress){ cancel, NULL };
    expect_refused(&v, &none, PEL_ERROR_ARGUMENT, "isovalues");
    expect_refused(&v, &bad, PEL_ERROR_ARGUMENT, "not finite");
    expect_refused(&v, &below, PEL_ERROR_ARGUMENT, "tolerance");
    expect_refused(&v, &stopped, PEL_ERROR_CANCELLED, "");
    pel_volume_init(&flat);
    assert_true(pel_volume_allocate(&flat, dims, PEL_U8, 1, NULL));
    expect_refused(&flat, &one, PEL_ERROR_UNSUPPORTED, "along z");
    pel_volume_finish(&flat);
    assert_true(pel_volume_allocate(&flat, dims, PEL_U8, 3, NULL));
    expect_refused(&flat, &one, PEL_ERROR_ARGUMENT, "magnitude");
    pel_volume_finish(&flat);
    pel_volume_finish(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),    cmocka_unit_test(test_torus), cmocka_unit_test(test_gyroid),
        cmocka_unit_test(test_noise),     cmocka_unit_test(test_closed_noise), cmocka_unit_test(test_voids),
        cmocka_unit_test(test_placement), cmocka_unit_test(test_threads), cmocka_unit_test(test_types),
        cmocka_unit_test(test_parts),     cmocka_unit_test(test_tolerance), cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
