/* SPDX-License-Identifier: MIT */
/* Meshes as files: each format is read back by the least that can, and holds the mesh. */
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support.h"

#include <pellucid/mesh.h>

/* Two tetrahedra of isovalues 1 and 2; `far` from the world's zero. */
static struct pel_mesh *tetrahedra(double far)
{
    static const float corners[4][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    static const uint32_t faces[4][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 } };
    struct pel_mesh *mesh = calloc(1, sizeof *mesh);
    mesh->vertex_count = mesh->triangle_count = 8;
    mesh->positions = calloc(8, sizeof *mesh->positions);
    mesh->normals = calloc(8, sizeof *mesh->normals);
    mesh->triangles = calloc(8, sizeof *mesh->triangles);
    for (uint32_t i = 0; i < 8; i++)
        for (int a = 0; a < 3; a++) {
            mesh->positions[i][a] = corners[i % 4][a] * 0.3f + (float)(i / 4);
            mesh->normals[i][a] = (a == 1 ? -0.001f : 0.1f) * (float)(i + 1) + (a == 2 ? 0.0625f : 0); /* each of its own */
            mesh->triangles[i][a] = faces[i % 4][a] + i / 4 * 4;
        }
    mesh->origin[0] = far;
    mesh->origin[2] = 10;
    mesh->part_count = 2;
    mesh->parts[0] = (struct pel_mesh_part) { 1, 0, 4, 0, 4 };
    mesh->parts[1] = (struct pel_mesh_part) { 2, 4, 4, 4, 4 };
    return mesh;
}

static unsigned char *written(const char *name, const struct pel_mesh *mesh, size_t *size)
{
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_write_mesh(scratch(name), mesh, NULL, &error))
        fail_msg("%s", error.message);
    return read_file(scratch(name), size);
}

/* What stands behind a line of the header. */
static const unsigned char *behind(const unsigned char *bytes, size_t size, const char *line)
{
    const unsigned char *at = memmem(bytes, size, line, strlen(line));
    assert_non_null(at);
    return at + strlen(line);
}

static void expect_near(double a, double b)
{
    if (!(fabs(a - b) < 1e-6))
        fail_msg("%.9g is not %.9g", a, b);
}

static void test_ply(void **state)
{
    (void)state;
    for (int is_far = 0; is_far < 2; is_far++) {
        struct pel_mesh *mesh = tetrahedra(is_far ? 1e7 + 0.1 : 0.1);
        size_t size;
        unsigned char *bytes = written("t.ply", mesh, &size);
        assert_memory_equal(bytes, "ply\nformat binary_little_endian 1.0\n", 36);
        behind(bytes, size, "comment isovalue 2\n");
        behind(bytes, size, is_far ? "element vertex 8\nproperty double x\n" : "element vertex 8\nproperty float x\n");
        behind(bytes, size, "property double isovalue\nelement face 8\nproperty list uchar int vertex_indices\n");
        const unsigned char *at = behind(bytes, size, "end_header\n");
        const size_t record = (is_far ? 24 : 12) + 12 + 8;
        assert_int_equal(size, (size_t)(at - bytes) + 8 * record + 8 * 13);
        for (int v = 0; v < 8; v++, at += record) {
            double x, isovalue;
            float near, normal;
            memcpy(&x, at, sizeof x);
            memcpy(&near, at, sizeof near);
            memcpy(&normal, at + record - 20, sizeof normal);
            memcpy(&isovalue, at + record - 8, sizeof isovalue);
            expect_near(is_far ? x : (double)near, mesh->origin[0] + (double)mesh->positions[v][0]);
            expect_near((double)normal, (double)mesh->normals[v][0]);
            assert_true(isovalue == 1 + v / 4);
        }
        for (int t = 0; t < 8; t++, at += 13) {
            assert_int_equal(at[0], 3);
            assert_memory_equal(at + 1, mesh->triangles[t], 12);
        }
        free(bytes);
        pel_mesh_destroy(mesh);
    }
}

static void test_stl(void **state)
{
    (void)state;
    struct pel_mesh *mesh = tetrahedra(0.1);
    size_t size;
    uint32_t count;
    unsigned char *bytes = written("t.stl", mesh, &size);
    memcpy(&count, bytes + 80, sizeof count);
    assert_int_equal(count, 8);
    assert_int_equal(size, 84 + 8 * 50);
    assert_true(memcmp(bytes, "solid", 5) != 0);
    for (int t = 0; t < 8; t++) {
        float numbers[12];
        memcpy(numbers, bytes + 84 + 50 * t, sizeof numbers);
        for (int c = 0; c < 3; c++)
            expect_near((double)numbers[3 + 3 * c + 2], 10 + (double)mesh->positions[mesh->triangles[t][c]][2]);
        if (t % 4 == 0) /* in the plane of x and y, seen from below */
            assert_true(numbers[0] == 0 && numbers[1] == 0 && numbers[2] == -1);
    }
    free(bytes);
    pel_mesh_destroy(mesh);
}

static void test_obj(void **state)
{
    (void)state;
    struct pel_mesh *mesh = tetrahedra(0.1);
    size_t size, vertices = 0, normals = 0, faces = 0, groups = 0;
    char *text = (char *)written("t.obj", mesh, &size);
    text = realloc(text, size + 1);
    text[size] = 0;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        double p[3];
        size_t c[6];
        if (sscanf(line, "v %lf %lf %lf", &p[0], &p[1], &p[2]) == 3) {
            for (int a = 0; a < 3; a++)
                expect_near(p[a], mesh->origin[a] + (double)mesh->positions[vertices][a]);
            vertices++;
        } else if (sscanf(line, "vn %lf %lf %lf", &p[0], &p[1], &p[2]) == 3) {
            for (int a = 0; a < 3; a++)
                expect_near(p[a], (double)mesh->normals[normals][a]);
            normals++;
        } else if (sscanf(line, "f %zu//%zu %zu//%zu %zu//%zu", &c[0], &c[1], &c[2], &c[3], &c[4], &c[5]) == 6) {
            for (int i = 0; i < 6; i++)
                assert_int_equal(c[i], mesh->triangles[faces][i / 2] + 1);
            faces++;
        } else {
            assert_string_equal(line, groups++ ? "g isovalue_2" : "g isovalue_1");
            assert_int_equal(faces, groups == 1 ? 0 : 4);
        }
    }
    assert_int_equal(vertices + normals + faces + groups, 8 + 8 + 8 + 2);
    free(text);
    pel_mesh_destroy(mesh);
}

static void test_vtp(void **state)
{
    (void)state;
    struct pel_mesh *mesh = tetrahedra(0.1);
    size_t size;
    unsigned char *bytes = written("t.vtp", mesh, &size);
    behind(bytes, size, "NumberOfPoints=\"8\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"8\"");
    static const size_t lengths[5] = { 96, 64, 96, 192, 64 }; /* normals, isovalues, points, corners, ends */
    const unsigned char *at = behind(bytes, size, "encoding=\"raw\">\n   _");
    const unsigned char *arrays[5];
    size_t offset = 0;
    for (int i = 0; i < 5; i++) {
        uint64_t length;
        char word[48];
        snprintf(word, sizeof word, "format=\"appended\" offset=\"%zu\"", offset);
        behind(bytes, size, word);
        memcpy(&length, at + offset, sizeof length);
        assert_int_equal(length, lengths[i]);
        arrays[i] = at + offset + sizeof length;
        offset += sizeof length + lengths[i];
    }
    int64_t corner, end;
    float x;
    memcpy(&corner, arrays[3] + 8 * 23, sizeof corner);
    memcpy(&end, arrays[4] + 8 * 7, sizeof end);
    memcpy(&x, arrays[2] + 12 * 5, sizeof x);
    assert_int_equal(corner, 7);
    assert_int_equal(end, 24);
    expect_near((double)x, 0.1 + 1.3);
    assert_int_equal(size, (size_t)(at - bytes) + offset + strlen("\n  </AppendedData>\n</VTKFile>\n"));
    free(bytes);
    pel_mesh_destroy(mesh);
}

/* A program with a comma for its decimal point writes points all the same. Where no such locale is installed, one is made from its source.
 */
static bool take_comma_locale(void)
{
    static const char *const names[] = { "de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8" };
    char command[512];
    for (int i = 0; i < 4; i++)
        if (setlocale(LC_ALL, names[i]))
            return true;
    snprintf(command, sizeof command, "localedef -i de_DE -f UTF-8 '%s' >/dev/null 2>&1", scratch("de_DE.UTF-8"));
    setenv("LOCPATH", scratch("."), 1);
    return system(command) == 0 && setlocale(LC_ALL, "de_DE.UTF-8");
}

static void test_locale(void **state)
{
    (void)state;
    if (!take_comma_locale()) {
        print_message("no locale with a decimal comma here, and none can be made: skipped\n");
        skip();
    }
    char comma[8];
    snprintf(comma, sizeof comma, "%.1f", 0.5);
    assert_string_equal(comma, "0,5");
    struct pel_mesh *mesh = tetrahedra(0.1);
    mesh->parts[1].isovalue = 2.5;
    const char *const names[] = { "l.ply", "l.obj" }, *const words[] = { "comment isovalue 2.5\n", "v 0.1 0 10\n" };
    for (int i = 0; i < 2; i++) {
        size_t size;
        unsigned char *bytes = written(names[i], mesh, &size);
        behind(bytes, size, words[i]);
        free(bytes);
    }
    pel_mesh_destroy(mesh);
    const char *const headers[] = { "l.nrrd", "l.mha", "l.vti" };
    struct pel_volume volume, again;
    pel_volume_init(&volume);
    assert_true(pel_volume_allocate(&volume, (const size_t[3]) { 2, 3, 4 }, PEL_U8, 1, NULL));
    volume.spacing[1] = 2.5;
    for (int i = 0; i < 3; i++) {
        size_t size;
        assert_true(pel_write_volume(scratch(headers[i]), &volume, NULL, NULL));
        unsigned char *bytes = read_file(scratch(headers[i]), &size);
        behind(bytes, size, "2.5");
        free(bytes);
        read_ok(scratch(headers[i]), &again, NULL);
        if (again.spacing[1] != 2.5)
            fail_msg("%s: a spacing of %g came back", headers[i], again.spacing[1]);
        pel_volume_finish(&again);
    }
    pel_volume_finish(&volume);
    struct pel_scene scene;
    size_t size;
    assert_true(pel_scene_init(&scene, NULL));
    scene.volume = NULL;
    scene.render.step = 0.25;
    scene.camera.view_angle = 22.5;
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "40:0,80:0.25", NULL));
    assert_true(scene.transfer.opacities[1].opacity == 0.25);
    assert_true(pel_write_scene(scratch("l.json"), &scene, NULL));
    unsigned char *text = read_file(scratch("l.json"), &size);
    behind(text, size, "0.25");
    behind(text, size, "22.5");
    free(text);
    pel_scene_finish(&scene);
    setlocale(LC_ALL, "C");
}

static bool cancel(void *user, double fraction)
{
    (void)user;
    (void)fraction;
    return false;
}

/* A file appears whole or not at all; an empty mesh is a good file. */
static void test_refusals(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_mesh *mesh = tetrahedra(0), empty = { .part_count = 1 };
    assert_false(pel_write_mesh(scratch("t.foo"), mesh, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, ".ply, .stl, .obj or .vtp; give"));
    assert_false(pel_write_mesh(scratch("no/such/folder.ply"), mesh, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_IO);
    pel_mesh_destroy(mesh);
    static const char *const names[] = { "e.ply", "e.stl", "e.obj", "e.vtp" };
    for (int i = 0; i < 4; i++)
        assert_true(pel_write_mesh(scratch(names[i]), &empty, NULL, &error));

    struct pel_mesh large = { .vertex_count = 10000, .part_count = 1 };
    large.positions = calloc(10000, sizeof *large.positions);
    large.normals = calloc(10000, sizeof *large.normals);
    const struct pel_progress stop = { cancel, NULL };
    assert_false(pel_write_mesh(scratch("c.ply"), &large, &stop, &error));
    assert_int_equal(error.code, PEL_ERROR_CANCELLED);
    assert_int_equal(access(scratch("c.ply"), F_OK), -1);
    free(large.positions);
    free(large.normals);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ply), cmocka_unit_test(test_stl),    cmocka_unit_test(test_obj),
        cmocka_unit_test(test_vtp), cmocka_unit_test(test_locale), cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, make_scratch, remove_scratch);
}
