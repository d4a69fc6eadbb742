/* SPDX-License-Identifier: MIT */
/* Surfaces as triangles: where they lie, which way they look, and that threads, types and placements change nothing in them. */
#include "mesh_facts.h"

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
    print_message("%zu vertices, at most %.5f voxels off, %.3f degrees off\n", mesh->vertex_count, farthest,
                  acos(least) * 180 / 3.14159265);
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

/* A sheared, mirrored placement far from the world's zero: the surface is where it was, looks outwards, and normals stay normal. */
static void test_placement(void **state)
{
    (void)state;
    struct pel_volume v;
    make(&v, "sphere", "40");
    struct pel_mesh *plain = extract(&v, 0, 1);
    static const double directions[3][3] = { { 0, 1, 0 }, { 1, 0, 0 }, { 0.6, 0, 0.8 } }, spacing[3] = { 0.5, 2, 3 },
                        origin[3] = { 5e6, -4e6, 9 };
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
            case PEL_U8:
            case PEL_I8:
                ((unsigned char *)u.data)[i] = value;
                break;
            case PEL_U16:
            case PEL_I16:
                ((unsigned short *)u.data)[i] = value;
                break;
            case PEL_U32:
            case PEL_I32:
                ((unsigned *)u.data)[i] = value;
                break;
            case PEL_F32:
                ((float *)u.data)[i] = value;
                break;
            default:
                ((double *)u.data)[i] = value;
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
                           below = { .isovalue_count = 1, .tolerance = -1 }, one = { .isovalues = { 0 }, .isovalue_count = 1 },
                           stopped = one;
    stopped.progress = (struct pel_progress) { cancel, NULL };
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
        cmocka_unit_test(test_sphere),  cmocka_unit_test(test_torus), cmocka_unit_test(test_gyroid), cmocka_unit_test(test_placement),
        cmocka_unit_test(test_threads), cmocka_unit_test(test_types), cmocka_unit_test(test_parts),  cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
