/* SPDX-License-Identifier: MIT */
/* Vertices at one place made one: no triangle without area where the surface allows it, and the surface what it was. */
#include "mesh_facts.h"

static bool same_place(const struct pel_mesh *mesh, uint32_t a, uint32_t b)
{
    const float *p = mesh->positions[a], *q = mesh->positions[b];
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

static size_t count_flat(const struct pel_mesh *mesh)
{
    size_t count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *c = mesh->triangles[t];
        count += same_place(mesh, c[0], c[1]) || same_place(mesh, c[1], c[2]) || same_place(mesh, c[2], c[0]);
    }
    return count;
}

static uint32_t root_of(uint32_t *up, uint32_t v)
{
    while (up[v] != v)
        v = up[v] = up[up[v]];
    return v;
}

/* Closed and open parts of a mesh whose vertices are all at one place. */
static void count_points(const struct pel_mesh *mesh, int *closed, int *open)
{
    uint32_t *up = malloc((mesh->vertex_count + 1) * sizeof *up);
    int *triangles = calloc(mesh->vertex_count + 1, sizeof *triangles), *vertices = calloc(mesh->vertex_count + 1, sizeof *vertices);
    bool *wide = calloc(mesh->vertex_count + 1, sizeof *wide);
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        up[v] = v;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 1; i < 3; i++)
            up[root_of(up, mesh->triangles[t][i])] = root_of(up, mesh->triangles[t][0]);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        vertices[root_of(up, v)]++;
        wide[root_of(up, v)] |= !same_place(mesh, v, root_of(up, v));
    }
    for (size_t t = 0; t < mesh->triangle_count; t++)
        triangles[root_of(up, mesh->triangles[t][0])]++;
    *closed = *open = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        if (up[v] == v && !wide[v]) { /* closed: F = 2 V - 4 */
            *closed += triangles[v] == 2 * vertices[v] - 4;
            *open += triangles[v] != 2 * vertices[v] - 4;
        }
    free(up);
    free(triangles);
    free(vertices);
    free(wide);
}

/* Collapses, and holds what came of it to what was there. */
static size_t collapse(const struct pel_volume *v, struct pel_mesh *mesh)
{
    size_t left, flat = count_flat(mesh);
    int closed, open;
    count_points(mesh, &closed, &open);
    long euler = expect_watertight(v, mesh);
    double volume = enclosed(mesh);
    assert_true(pel_mesh_collapse(mesh, &left, NULL));
    assert_int_equal(expect_watertight(v, mesh), euler - 2 * closed - open);
    assert_int_equal(left, count_flat(mesh));
    assert_true(fabs(enclosed(mesh) - volume) <= 1e-3 + 1e-6 * fabs(volume));
    assert_int_equal(mesh->parts[0].vertex_count, mesh->vertex_count);
    assert_int_equal(mesh->parts[0].triangle_count, mesh->triangle_count);
    print_message("%zu of %zu triangles without area stay\n", left, flat);
    return left;
}

/* Bytes of noise, a sixth of them the isovalue itself, with the border open and closed. */
static void test_noise(void **state)
{
    (void)state;
    seed = 17;
    for (int round = 0; round < 4; round++) {
        struct pel_volume v;
        make_noise(&v, 21, 19, 23, false);
        unsigned char *bytes = v.data;
        for (size_t i = 0; i < 21 * 19 * 23; i++) {
            size_t x = i % 21, y = i / 21 % 19, z = i / 21 / 19;
            if (round & 1 && (!x || !y || !z || x == 20 || y == 18 || z == 22))
                bytes[i] = 0;
        }
        for (int k = 1; k < 6; k++) {
            struct pel_mesh *mesh = extract_within(&v, k, round / 2 * 0.03, 2);
            size_t flat = count_flat(mesh), before = mesh->triangle_count;
            assert_true(flat > 500);
            assert_true(collapse(&v, mesh) < flat / 2);
            assert_true(mesh->triangle_count < before);
            pel_mesh_destroy(mesh);
        }
        pel_volume_finish(&v);
    }
}

/* Distances in whole numbers: a ball whose surface goes through many voxels. None of its vertices shares a place. */
static void test_ball(void **state)
{
    (void)state;
    struct pel_volume v;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (const size_t[3]) { 40, 40, 40 }, PEL_U8, 1, NULL));
    for (size_t i = 0; i < 64000; i++) {
        double x = (double)(i % 40) - 19.5, y = (double)(i / 40 % 40) - 19.5, z = (double)(i / 1600) - 19.5;
        ((unsigned char *)v.data)[i] = (unsigned char)(100 - 2 * sqrt(x * x + y * y + z * z));
    }
    pel_volume_update_range(&v);
    struct pel_mesh *mesh = extract(&v, 70, 2);
    assert_true(count_flat(mesh) > 100);
    assert_int_equal(collapse(&v, mesh), 0);
    assert_int_equal(expect_watertight(&v, mesh), 2);
    pel_mesh_destroy(mesh);
    pel_volume_finish(&v);
}

/* A voxel alone is a point, and nothing stays of it; a row of them is a tube without width, which stays; the rest of both parts is moved
 * up. */
static void test_points(void **state)
{
    (void)state;
    struct pel_volume v;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (const size_t[3]) { 12, 12, 12 }, PEL_U8, 1, NULL));
    unsigned char(*bytes)[12][12] = v.data;
    memset(v.data, 0, 12 * 12 * 12);
    bytes[2][2][2] = bytes[5][0][5] = 9;
    pel_volume_update_range(&v);
    struct pel_mesh *mesh = extract(&v, 9, 1);
    assert_int_equal(mesh->triangle_count, 8 + 4);
    assert_int_equal(collapse(&v, mesh), 0);
    assert_int_equal(mesh->vertex_count, 0);
    pel_mesh_destroy(mesh);
    memset(bytes[8][8] + 2, 9, 6);
    bytes[5][5][5] = 20;
    mesh = extract(&v, 9, 1);
    assert_true(collapse(&v, mesh) > 0);
    pel_mesh_destroy(mesh);
    struct pel_mesh_params params = { .isovalues = { 9, 4 }, .isovalue_count = 2, .threads = 1 };
    mesh = pel_mesh_extract(&v, &params, NULL);
    struct pel_mesh *alone = extract(&v, 4, 1);
    assert_true(pel_mesh_collapse(mesh, NULL, NULL));
    assert_int_equal(mesh->parts[1].first_vertex, mesh->parts[0].vertex_count);
    assert_int_equal(mesh->parts[1].triangle_count, alone->triangle_count);
    assert_int_equal(mesh->parts[1].vertex_count, alone->vertex_count);
    for (size_t t = 0; t < alone->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            assert_int_equal(mesh->triangles[mesh->parts[1].first_triangle + t][c], alone->triangles[t][c] + mesh->parts[1].first_vertex);
    assert_memory_equal(mesh->positions + mesh->parts[1].first_vertex, alone->positions, alone->vertex_count * sizeof *alone->positions);
    pel_mesh_destroy(mesh);
    pel_mesh_destroy(alone);
    pel_volume_finish(&v);
}

/* Where no voxel is the isovalue not a byte changes. */
static void test_nothing(void **state)
{
    (void)state;
    struct pel_volume v;
    size_t left = 1;
    seed = 4;
    make_noise(&v, 15, 16, 17, false);
    struct pel_mesh *mesh = extract(&v, 2.5, 1), *same = extract(&v, 2.5, 1), empty = { .part_count = 1 };
    assert_true(pel_mesh_collapse(mesh, &left, NULL));
    assert_int_equal(left, 0);
    expect_same(mesh, same);
    assert_true(pel_mesh_collapse(&empty, NULL, NULL));
    pel_mesh_destroy(mesh);
    pel_mesh_destroy(same);
    pel_volume_finish(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_ball),
        cmocka_unit_test(test_points),
        cmocka_unit_test(test_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
