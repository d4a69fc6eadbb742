/* SPDX-License-Identifier: MIT */
/* Raw samples, whose layout the user says. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const unsigned char counting[24] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23 };

static void read_as(const char *path, const char *layout, struct pel_volume *v, struct pel_file_info *info)
{
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    params.raw = layout;
    pel_volume_init(v);
    if (!pel_read_volume(path, &params, v, info, &error))
        fail_msg("%s", error.message);
}

static void layouts(void **state)
{
    (void)state;
    const char *path = scratch("r.raw");
    struct pel_volume v;
    struct pel_file_info info;
    write_file(path, counting, 24);
    read_as(path, "2x3x4:u8", &v, &info);
    assert_memory_equal(v.data, counting, 24);
    assert_string_equal(info.format, "raw");
    assert_int_equal(info.note_count, 0);
    pel_volume_finish(&v);
    read_as(path, "2x3x2:u16", &v, NULL);
    assert_int_equal(((uint16_t *)v.data)[1], 0x0302);
    pel_volume_finish(&v);
    read_as(path, "2x3x2:u16:be", &v, NULL);
    assert_int_equal(((uint16_t *)v.data)[1], 0x0203);
    pel_volume_finish(&v);
    read_as(path, "2x2x1:u16:be+4", &v, &info);
    assert_int_equal(((uint16_t *)v.data)[0], 0x0405);
    assert_int_equal(info.note_count, 1);
    pel_volume_finish(&v);
    read_as(path, "2x2x1:u8+20", &v, NULL);
    assert_memory_equal(v.data, counting + 20, 4);
    pel_volume_finish(&v);
    read_as(path, "3x2x2x2:u8", &v, NULL);
    assert_int_equal(v.components, 3);
    assert_memory_equal(v.dims, ((size_t[]){ 2, 2, 2 }), sizeof v.dims);
    pel_volume_finish(&v);
    read_as(path, "6x4:u8", &v, NULL);
    assert_memory_equal(v.dims, ((size_t[]){ 6, 4, 1 }), sizeof v.dims);
    pel_volume_finish(&v);
    write_gzip(path, counting, 24);
    read_as(path, "2x3x4:u8", &v, NULL);
    assert_memory_equal(v.data, counting, 24);
    pel_volume_finish(&v);
    /* Samples that begin as gzip does are samples where the length says so. */
    unsigned char looks[8] = { 0x1f, 0x8b, 8, 0, 1, 2, 3, 4 };
    write_file(path, looks, 8);
    read_as(path, "2x2x2:u8", &v, NULL);
    assert_memory_equal(v.data, looks, 8);
    pel_volume_finish(&v);
}

static void bad_layouts(void **state)
{
    (void)state;
    static const char *const layouts[] = { "",
                                           "256",
                                           "2x2:",
                                           "2x2",
                                           "2x2x2:u7",
                                           "x2x2:u8",
                                           "2x2x2x:u8",
                                           "2x2x2x2x2:u8",
                                           "-2x-2x2:u8",
                                           "2x2x2:u8:me",
                                           "2x2x2:u8+",
                                           "2x2x2:u8+-4",
                                           "2x2x2:u8 ",
                                           "0x2x2:u8",
                                           "9x2x2x2:u8",
                                           "2 x2x2:u8",
                                           "99999999999999999999x1x1:u8",
                                           "4294967296x4294967296x4294967296:u8",
                                           "2x2x2:averyveryverylongtypename" };
    const char *path = scratch("b.raw");
    write_file(path, counting, 24);
    for (size_t i = 0; i < sizeof layouts / sizeof *layouts; i++)
        read_bad(path, layouts[i]);
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume v;
    pel_volume_init(&v);
    params.raw = "2x2x2:u7";
    assert_false(pel_read_volume(path, &params, &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    params.raw = "1024x1024x1024:f64";
    assert_false(pel_read_volume(path, &params, &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_FORMAT);
    read_bad(path, "2x2x2:u8+17");
    read_bad(path, "2x2x2:u8+100000000000");
    read_bad(scratch("none.raw"), "2x2x2:u8");
}

static void writes_what_it_holds(void **state)
{
    (void)state;
    struct pel_volume written, read;
    fill_volume(&written, PEL_F32, 3);
    assert_true(pel_write_volume(scratch("w.raw"), &written, NULL, NULL));
    read_as(scratch("w.raw"), "3x5x4x3:f32", &read, NULL);
    assert_memory_equal(read.data, written.data, pel_volume_bytes(&written));
    pel_volume_finish(&written);
    pel_volume_finish(&read);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(layouts), cmocka_unit_test(bad_layouts), cmocka_unit_test(writes_what_it_holds) };
    return cmocka_run_group_tests_name("raw", tests, make_scratch, remove_scratch);
}
