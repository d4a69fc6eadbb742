/* SPDX-License-Identifier: MIT */
/* VTK legacy files: the facts of real ones, every kind of attribute and encoding, damage. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"
#define HEAD(ENCODING) "# vtk DataFile Version 3.0\na title\n" ENCODING "\nDATASET STRUCTURED_POINTS\n"

static void read_array(const char *path, const char *array, struct pel_volume *volume)
{
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    params.array = array;
    pel_volume_init(volume);
    if (!pel_read_volume(path, &params, volume, NULL, &error))
        fail_msg("%s", error.message);
    assert_string_equal(volume->name, array);
}

static void facts_of_real_files(void **state)
{
    (void)state;
    expect_description(data_path("ironProt.vtk"), "vtk 68x68x68 u8 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                  "space unknown units ''\nmin 0 max 255 mean 13.138259 nonzero 106699 voids 0\n");
    expect_description(data_path("carotid.vtk"), "vtk 76x49x45 f32 x1\nspacing 1 1 1\norigin 100 80 1\n" PLAIN_AXES
                                                 "space unknown units ''\nmin 0 max 580 mean 99.049093 nonzero 167548 voids 0\n");
    struct pel_volume field, same;
    read_array(data_path("carotid.vtk"), "vectors", &field);
    assert_int_equal(field.components, 3);
    assert_float_equal(field.range[1], 22.6949, 1e-4);
    read_ok(data_path("carotid_velocity.nrrd"), &same, NULL);
    assert_memory_equal(field.data, same.data, pel_volume_bytes(&same));
    pel_volume_finish(&field);
    pel_volume_finish(&same);
}

static void ascii(void **state)
{
    (void)state;
    struct pel_volume v;
    write_text(scratch("a.vtk"), HEAD("ASCII") "DIMENSIONS 3 2 1\nORIGIN -1 2.5 3e2\nASPECT_RATIO 0.5 1 2\nPOINT_DATA 6\n"
                                               "SCALARS some%20thing short\nLOOKUP_TABLE default\n-1 2 3\n 4 5 32767\n");
    expect_description(scratch("a.vtk"), "vtk 3x2x1 i16 x1\nspacing 0.5 1 2\norigin -1 2.5 300\n" PLAIN_AXES
                                         "space unknown units ''\nmin -1 max 32767 mean 5463.333333 nonzero 6 voids 0\n");
    read_array(scratch("a.vtk"), "some thing", &v);
    assert_memory_equal(v.data, ((int16_t[]) { -1, 2, 3, 4, 5, 32767 }), 12);
    pel_volume_finish(&v);
    /* no LOOKUP_TABLE, DOS line ends, NaN */
    write_text(scratch("b.vtk"),
               "# vtk DataFile Version 2.0\r\n\r\nascii\r\nDATASET structured_points\r\ndimensions 2 1 1\r\npoint_data 2\r\n"
               "scalars s float 1\r\nnan 1e-3\r\n");
    read_array(scratch("b.vtk"), "s", &v);
    assert_true(isnan(((float *)v.data)[0]));
    assert_true(((float *)v.data)[1] == 1e-3f);
    assert_true(v.range[0] == v.range[1]);
    pel_volume_finish(&v);
}

/* All that may stand in such a file, in text. Each array's numbers are its own, so that reading another one would show. */
static const char everything[] =
    HEAD("ASCII") "FIELD FieldData 2\nTimeValue 1 1 double\n1.5\nwords 1 2 string\none\ntwo words\n"
                  "DIMENSIONS 2 2 2\nSPACING 1 2 3\nORIGIN 0 0 0\n"
                  "CELL_DATA 1\nSCALARS cell int\nLOOKUP_TABLE default\n99\n"
                  "POINT_DATA 8\n"
                  "NORMALS n float\n0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1\n"
                  "TENSORS t float\n1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 "
                  "0 0 1 1 0 0 0 1 0 0 0 1 "
                  "1 0 0 0 1 0 0 0 1\n"
                  "TEXTURE_COORDINATES uv 2 float\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16\n"
                  "COLOR_SCALARS rgba 4\n0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 0.5\n"
                  "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\n"
                  "VECTORS v double\n1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 4\n"
                  "LOOKUP_TABLE colours 2\n0 0 0 1 1 1 1 1\n"
                  "FIELD more 3\nf1 1 8 unsigned_int\n1 2 3 4 5 6 7 4000000000\nMETADATA\nCOMPONENT_NAMES\nx\n\nshort 1 3 int\n1 2 3\nf2 2 "
                  "8 char\n"
                  "1 -2 3 -4 5 -6 7 -8 9 -10 11 -12 13 -14 15 -16\n"
                  "SCALARS last unsigned_char 3\nLOOKUP_TABLE colours\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24\n"
                  "SCALARS one char\nLOOKUP_TABLE colours\n1 2 3 4 5 6 7 8\n";

static void all_attributes(void **state)
{
    (void)state;
    static struct pel_file_info info;
    struct pel_volume v;
    write_text(scratch("all.vtk"), everything);
    read_ok(scratch("all.vtk"), &v, &info);
    assert_string_equal(v.name, "one"); /* scalars of one component come first, even if they stand last */
    assert_int_equal(((int8_t *)v.data)[7], 8);
    pel_volume_finish(&v);
    static const char *const names[] = { "n", "t", "uv", "rgba", "v", "f1", "f2", "last", "one" };
    static const int components[] = { 3, 9, 2, 4, 3, 1, 2, 3, 1 };
    assert_int_equal(info.array_count, 9);
    for (int i = 0; i < 9; i++) {
        assert_string_equal(info.arrays[i].name, names[i]);
        assert_int_equal(info.arrays[i].components, components[i]);
    }
    read_array(scratch("all.vtk"), "f2", &v);
    assert_int_equal(((int8_t *)v.data)[15], -16);
    pel_volume_finish(&v);
    read_array(scratch("all.vtk"), "f1", &v);
    assert_int_equal(((uint32_t *)v.data)[7], 4000000000u);
    pel_volume_finish(&v);
    read_array(scratch("all.vtk"), "v", &v);
    assert_true(((double *)v.data)[23] == 4);
    pel_volume_finish(&v);
    read_array(scratch("all.vtk"), "rgba", &v);
    assert_memory_equal((uint8_t *)v.data + 24, "\0\0\0\377\0\0\0\200", 8);
    pel_volume_finish(&v);
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    params.array = "none";
    assert_false(pel_read_volume(scratch("all.vtk"), &params, &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "uv, rgba, v"));
    params.array = "t";
    assert_false(pel_read_volume(scratch("all.vtk"), &params, &v, NULL, &error));
    assert_non_null(strstr(error.message, "9 components"));
}

static void cells(void **state)
{
    (void)state;
    write_text(scratch("c.vtk"),
               HEAD("ASCII") "DIMENSIONS 3 2 1\nSPACING 2 2 2\nORIGIN 0 0 0\nCELL_DATA 2\nSCALARS c float\nLOOKUP_TABLE default\n"
                             "7 9\n");
    expect_description(scratch("c.vtk"), "vtk 2x1x1 f32 x1\nspacing 2 2 2\norigin 1 1 0\n" PLAIN_AXES
                                         "space unknown units ''\nmin 7 max 9 mean 8.000000 nonzero 2 voids 0\n"
                                         "note: the file has values of cells, not of points: a sample stands at each cell's centre\n");
}

/* A binary file: text, then `size` bytes, then a word after them that must be found. Returns where those bytes end. */
static size_t write_binary(const char *path, const char *type, const void *bytes, size_t size)
{
    char file[4096];
    int n = snprintf(file, sizeof file, HEAD("BINARY") "DIMENSIONS 3 3 2\nPOINT_DATA 18\nSCALARS s %s\nLOOKUP_TABLE default\n", type);
    memcpy(file + n, bytes, size);
    n += (int)size;
    size_t end = (size_t)n;
    n += snprintf(file + n, sizeof file - (size_t)n, "\nVECTORS v char\n");
    for (int i = 0; i < 54; i++)
        file[n++] = (char)(i - 26);
    write_file(path, file, (size_t)n);
    return end;
}

static void binary_types(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum pel_type type;
        int size;
    } types[] = {
        { "unsigned_char", PEL_U8, 1 }, { "char", PEL_I8, 1 },           { "unsigned_short", PEL_U16, 2 }, { "short", PEL_I16, 2 },
        { "unsigned_int", PEL_U32, 4 }, { "int", PEL_I32, 4 },           { "float", PEL_F32, 4 },          { "double", PEL_F64, 8 },
        { "long", PEL_F64, 8 },         { "vtktypeuint64", PEL_F64, 8 },
    };
    for (size_t t = 0; t < sizeof types / sizeof *types; t++) {
        struct pel_volume v;
        unsigned char bytes[144] = { 0 };
        bool is_float = types[t].type == PEL_F32 || !strcmp(types[t].name, "double");
        for (int i = 0; i < 18; i++) {
            float f = (float)i + 0.5f;
            double d = i + 0.5;
            uint64_t bits = (uint64_t)i << 1;
            if (is_float && types[t].size == 4)
                memcpy(&bits, &f, 4);
            else if (is_float)
                memcpy(&bits, &d, 8);
            for (int b = 0; b < types[t].size; b++)
                bytes[i * types[t].size + b] = (unsigned char)(bits >> 8 * (types[t].size - 1 - b));
        }
        size_t end = write_binary(scratch("b.vtk"), types[t].name, bytes, (size_t)(18 * types[t].size));
        read_array(scratch("b.vtk"), "s", &v);
        assert_int_equal(v.type, types[t].type);
        for (size_t i = 0; i < 18; i++)
            assert_true(pel_volume_get(&v, i % 3, i / 3 % 3, i / 9, 0) == (is_float ? (double)i + 0.5 : (double)(i << 1)));
        pel_volume_finish(&v);
        read_array(scratch("b.vtk"), "v", &v);
        assert_true(pel_volume_get(&v, 0, 0, 0, 0) == -26 && pel_volume_get(&v, 2, 2, 1, 2) == 27);
        pel_volume_finish(&v);
        expect_truncations_fail(scratch("b.vtk"), scratch("cut.vtk"), end);
    }
    struct pel_volume v;
    write_binary(scratch("b.vtk"), "bit", "\xa5\x80\x40", 3);
    read_array(scratch("b.vtk"), "s", &v);
    assert_memory_equal(v.data, "\1\0\1\0\0\1\0\1\1\0\0\0\0\0\0\0\0\1", 18);
    pel_volume_finish(&v);
}

static void gzipped(void **state)
{
    (void)state;
    struct pel_volume v;
    size_t size;
    write_text(scratch("all.vtk"), everything);
    unsigned char *bytes = read_file(scratch("all.vtk"), &size);
    write_gzip(scratch("all.vtk.gz"), bytes, size);
    free(bytes);
    read_array(scratch("all.vtk.gz"), "v", &v);
    assert_true(((double *)v.data)[23] == 4);
    pel_volume_finish(&v);
}

static void expect_refused(const char *body, const char *part)
{
    char text[2048];
    snprintf(text, sizeof text, HEAD("BINARY") "%s", body);
    write_text(scratch("bad.vtk"), text);
    expect_bad(scratch("bad.vtk"), part);
}

static void bad_files(void **state)
{
    (void)state;
    write_text(scratch("t.vtk"), everything);
    expect_truncations_fail(scratch("t.vtk"), scratch("cut.vtk"), (size_t)(strstr(everything, "99") - everything));
    expect_refused("DIMENSIONS 0 1 1\n", "no samples along axis 0");
    expect_refused("DIMENSIONS -4 4 4\n", "no count");
    expect_refused("DIMENSIONS 4 4\nPOINT_DATA 16\n", "no number");
    expect_refused("DIMENSIONS 4000000 4000000 4000000\nPOINT_DATA 1\n", "beyond what can be addressed");
    expect_refused("DIMENSIONS 2000 2000 2000\nPOINT_DATA 8000000000\nSCALARS s double\nLOOKUP_TABLE default\nabc", "too soon");
    expect_refused("DIMENSIONS 2 2 2\nPOINT_DATA 9\nSCALARS s char\nLOOKUP_TABLE default\n012345678", "DIMENSIONS make 8");
    expect_refused("DIMENSIONS 2 2 2\nPOINT_DATA 8\nSCALARS s quux\nLOOKUP_TABLE default\n01234567", "quux");
    expect_refused("DIMENSIONS 2 2 2\nPOINT_DATA 8\nSCALARS s char 0\nLOOKUP_TABLE default\n01234567", "no number of components");
    expect_refused("DIMENSIONS 2 2 2\nPOINT_DATA 8\nSCALARS s char 5\nLOOKUP_TABLE default\n0123456701234567012345670123456701234567",
                   "5 components");
    expect_refused("DIMENSIONS 2 2 2\nPOINT_DATA 8\nWIDGETS s char\n01234567", "WIDGETS");
    expect_refused("DIMENSIONS 2 2 2\nPOINT_DATA 8\nFIELD f 99999999\nx 4 8999999999999999 double\n0", "too soon");
    expect_refused("DIMENSIONS 2 2 2\n", "no array");
    expect_refused("POINT_DATA 8\n", "before DIMENSIONS");
    write_text(scratch("bad.vtk"), "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n");
    expect_bad(scratch("bad.vtk"), "UNSTRUCTURED_GRID");
    write_text(scratch("bad.vtk"), HEAD("ASCII") "DIMENSIONS 2 1 1\nPOINT_DATA 2\nSCALARS s unsigned_char\nLOOKUP_TABLE default\n1 300\n");
    expect_bad(scratch("bad.vtk"), "does not fit");
    write_text(scratch("bad.vtk"), HEAD("ASCII") "DIMENSIONS 2 1 1\nPOINT_DATA 2\nSCALARS s float\nLOOKUP_TABLE default\n1 two\n");
    expect_bad(scratch("bad.vtk"), "no number: 'two'");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_real_files), cmocka_unit_test(ascii),   cmocka_unit_test(all_attributes), cmocka_unit_test(cells),
        cmocka_unit_test(binary_types),        cmocka_unit_test(gzipped), cmocka_unit_test(bad_files),
    };
    return cmocka_run_group_tests_name("vtk", tests, make_scratch, remove_scratch);
}
