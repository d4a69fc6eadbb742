/* SPDX-License-Identifier: MIT */
/* NIfTI: the facts of real files, headers made by hand in both versions and byte orders, damage. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"

static void facts_of_real_files(void **state)
{
    (void)state;
    expect_description(data_path("bonsai.nii.gz"), "nifti 256x256x256 u8 x1\nspacing 1 1 1\norigin -127 -127 -128\n" PLAIN_AXES
                                                   "space RAS units 'mm'\nmin 0 max 255 mean 13.464758 nonzero 3386236 voids 0\n");
    expect_description(data_path("inia19-t1-brain.nii.gz"),
                       "nifti 168x206x128 f32 x1\nspacing 0.5 0.5 0.5\norigin -42 -57.5 -30\n" PLAIN_AXES
                       "space RAS units ''\nmin 0 max 383.176 mean 17.011214 nonzero 874576 voids 0\n");
}

/* A NIfTI-1 header by the offsets of its specification, little-endian or big-endian. */
struct header {
    unsigned char bytes[352];
    bool big;
};

static void put(struct header *h, size_t offset, const void *value, size_t size)
{
    for (size_t i = 0; i < size; i++)
        h->bytes[offset + i] = ((const unsigned char *)value)[h->big ? size - 1 - i : i];
}

static void put_short(struct header *h, size_t offset, int16_t value)
{
    put(h, offset, &value, 2);
}

static void put_float(struct header *h, size_t offset, float value)
{
    put(h, offset, &value, 4);
}

static struct header header_of(bool big, int16_t type, int16_t bits, int16_t x, int16_t y, int16_t z)
{
    struct header h = { .big = big };
    int32_t size = 348;
    put(&h, 0, &size, 4);
    put_short(&h, 40, 3);
    put_short(&h, 42, x);
    put_short(&h, 44, y);
    put_short(&h, 46, z);
    put_short(&h, 70, type);
    put_short(&h, 72, bits);
    for (size_t i = 0; i < 4; i++)
        put_float(&h, 76 + 4 * i, (float)(i + 1));
    put_float(&h, 108, 352);
    h.bytes[123] = 2;
    memcpy(h.bytes + 344, "n+1", 4);
    return h;
}

static const char *write_nifti(const struct header *h, const void *data, size_t size)
{
    unsigned char file[1024] = { 0 };
    assert_true(size <= sizeof file - 352);
    memcpy(file, h->bytes, 352);
    memcpy(file + 352, data, size);
    const char *path = scratch("n.nii");
    write_file(path, file, 352 + size);
    return path;
}

static const unsigned char counting[32] = { 0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
                                            16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31 };

static void both_byte_orders(void **state)
{
    (void)state;
    for (int big = 0; big < 2; big++) {
        struct pel_volume v;
        struct header h = header_of(big, 4, 16, 2, 2, 2);
        read_ok(write_nifti(&h, counting, 16), &v, NULL);
        assert_int_equal(v.type, PEL_I16);
        assert_int_equal(((int16_t *)v.data)[1], big ? 0x0203 : 0x0302);
        assert_true(v.spacing[0] == 2 && v.spacing[1] == 3 && v.spacing[2] == 4);
        pel_volume_finish(&v);
    }
}

static void types_and_shapes(void **state)
{
    (void)state;
    struct pel_volume v;
    struct pel_file_info info;
    struct header h = header_of(false, 128, 24, 2, 2, 2);
    read_ok(write_nifti(&h, counting, 24), &v, &info);
    assert_int_equal(v.components, 3);
    assert_memory_equal(v.data, counting, 24);
    pel_volume_finish(&v);
    /* Time: the first point, and a note. */
    h = header_of(false, 2, 8, 2, 2, 2);
    put_short(&h, 40, 4);
    put_short(&h, 48, 3);
    read_ok(write_nifti(&h, counting, 24), &v, &info);
    assert_memory_equal(v.data, counting, 8);
    assert_int_equal(info.note_count, 1);
    pel_volume_finish(&v);
    /* The fifth axis holds components, one plane after the other. */
    h = header_of(false, 2, 8, 2, 2, 1);
    put_short(&h, 40, 5);
    put_short(&h, 48, 1);
    put_short(&h, 50, 3);
    read_ok(write_nifti(&h, counting, 12), &v, &info);
    assert_int_equal(v.components, 3);
    assert_memory_equal(v.data, ((unsigned char[]){ 0, 4, 8, 1, 5, 9, 2, 6, 10, 3, 7, 11 }), 12);
    pel_volume_finish(&v);
    /* Two dimensions are one slice. */
    h = header_of(false, 2, 8, 4, 2, 0);
    put_short(&h, 40, 2);
    read_ok(write_nifti(&h, counting, 8), &v, &info);
    assert_memory_equal(v.dims, ((size_t[]){ 4, 2, 1 }), sizeof v.dims);
    pel_volume_finish(&v);
    h = header_of(false, 1536, 128, 1, 1, 1);
    expect_bad(write_nifti(&h, counting, 16), "FLOAT128");
}

static void scaling_and_voids(void **state)
{
    (void)state;
    struct pel_volume v;
    struct header h = header_of(false, 2, 8, 2, 2, 2);
    put_float(&h, 112, 0.5f);
    put_float(&h, 116, -3);
    read_ok(write_nifti(&h, counting, 8), &v, NULL);
    assert_int_equal(v.type, PEL_F32);
    for (int i = 0; i < 8; i++)
        assert_true(((float *)v.data)[i] == (float)i / 2 - 3);
    assert_true(v.range[0] == -3 && v.range[1] == 0.5);
    pel_volume_finish(&v);
    /* NaN is a void and stays one. */
    float values[4] = { 1, NAN, 3, INFINITY };
    h = header_of(false, 16, 32, 2, 2, 1);
    read_ok(write_nifti(&h, values, sizeof values), &v, NULL);
    assert_memory_equal(v.data, values, sizeof values);
    assert_true(v.range[0] == 1 && v.range[1] == 3);
    pel_volume_finish(&v);
}

static void transforms(void **state)
{
    (void)state;
    struct header h = header_of(false, 2, 8, 2, 2, 2);
    const char *facts = "min 0 max 7 mean 3.500000 nonzero 7 voids 0\n";
    char golden[600];
    /* qform: half a turn about x, and a mirrored third axis. */
    put_short(&h, 252, 1);
    put_float(&h, 256, 1);
    put_float(&h, 268, 10);
    put_float(&h, 272, 20);
    put_float(&h, 276, 30);
    put_float(&h, 76, -1);
    snprintf(golden, sizeof golden, "nifti 2x2x2 u8 x1\nspacing 2 3 4\norigin 10 20 30\naxis 0: 1 0 0\naxis 1: 0 -1 0\naxis 2: 0 0 1\n"
                                    "space RAS units 'mm'\n%s", facts);
    expect_description(write_nifti(&h, counting, 8), golden);
    /* sform goes before it, and may be sheared. */
    float rows[12] = { 2, 1, 0, -1, 0, 1, 0, -2, 0, 0, 0.5f, -3 };
    put_short(&h, 254, 2);
    for (size_t i = 0; i < 12; i++)
        put_float(&h, 280 + 4 * i, rows[i]);
    snprintf(golden, sizeof golden, "nifti 2x2x2 u8 x1\nspacing 2 1.41421356 0.5\norigin -1 -2 -3\naxis 0: 1 0 0\n"
                                    "axis 1: 0.707107 0.707107 0\naxis 2: 0 0 1\nspace RAS units 'mm'\n%s", facts);
    expect_description(write_nifti(&h, counting, 8), golden);
    /* A transform that cannot be inverted, and no other: spacing alone. */
    put_short(&h, 252, 0);
    put_float(&h, 280 + 40, 0);
    snprintf(golden, sizeof golden, "nifti 2x2x2 u8 x1\nspacing 2 3 4\norigin 0 0 0\n" PLAIN_AXES "space unknown units 'mm'\n%s"
                                    "note: its transform to the world cannot be inverted; only its spacing is used\n", facts);
    expect_description(write_nifti(&h, counting, 8), golden);
}

static void two_files_and_second_version(void **state)
{
    (void)state;
    struct pel_volume v;
    struct header h = header_of(false, 2, 8, 2, 2, 2);
    memcpy(h.bytes + 344, "ni1", 4);
    put_float(&h, 108, 0);
    write_file(scratch("pair.hdr"), h.bytes, 348);
    expect_bad(scratch("pair.hdr"), "missing");
    write_gzip(scratch("pair.img.gz"), counting, 8);
    read_ok(scratch("pair.hdr"), &v, NULL);
    assert_memory_equal(v.data, counting, 8);
    pel_volume_finish(&v);
    read_ok(scratch("pair.img.gz"), &v, NULL);
    assert_memory_equal(v.data, counting, 8);
    pel_volume_finish(&v);
    for (int big = 0; big < 2; big++) {
        unsigned char file[560] = { 0 };
        struct header part = { .big = big };
        int32_t size = 540;
        int64_t dims[4] = { 3, 2, 2, 2 }, offset = 544;
        double spacing = 0.25;
        put(&part, 0, &size, 4);
        memcpy(part.bytes + 4, "n+2\0\r\n\032\n", 8);
        put_short(&part, 12, 512);
        put_short(&part, 14, 16);
        for (size_t i = 0; i < 4; i++)
            put(&part, 16 + 8 * i, &dims[i], 8);
        for (size_t i = 1; i < 4; i++)
            put(&part, 104 + 8 * i, &spacing, 8);
        put(&part, 168, &offset, 8);
        memcpy(file, part.bytes, 352);
        memcpy(file + 544, counting, 16);
        write_file(scratch("two.nii"), file, sizeof file);
        read_ok(scratch("two.nii"), &v, NULL);
        assert_int_equal(v.type, PEL_U16);
        assert_int_equal(((uint16_t *)v.data)[1], big ? 0x0203 : 0x0302);
        assert_true(v.spacing[1] == 0.25);
        pel_volume_finish(&v);
        dims[1] = dims[2] = dims[3] = INT64_MAX / 2;
        for (size_t i = 1; i < 4; i++)
            put(&part, 16 + 8 * i, &dims[i], 8);
        memcpy(file, part.bytes, 352);
        write_file(scratch("two.nii"), file, sizeof file);
        read_bad(scratch("two.nii"), NULL);
    }
}

static void lies(void **state)
{
    (void)state;
    struct header h;
    /* 18 GB asked for by 377 bytes, also where the file is gzip'd. */
    h = header_of(false, 2, 8, 2621, 2621, 2621);
    expect_bad(write_nifti(&h, counting, 25), "asks for 18005329061 bytes");
    write_gzip(scratch("l.nii.gz"), h.bytes, 352);
    expect_bad(scratch("l.nii.gz"), "asks for 18005329061 bytes");
    h = header_of(false, 64, 64, 32767, 32767, 32767);
    put_short(&h, 40, 7);
    for (size_t i = 4; i < 8; i++)
        put_short(&h, 40 + 2 * i, 32767);
    expect_bad(write_nifti(&h, counting, 16), "beyond what can be addressed");
    h = header_of(false, 2, 8, 2, 0, 2);
    expect_bad(write_nifti(&h, counting, 16), "0 samples along axis 1");
    h = header_of(false, 2, 8, 2, -3, 2);
    expect_bad(write_nifti(&h, counting, 16), "-3 samples");
    h = header_of(false, 77, 8, 2, 2, 2);
    expect_bad(write_nifti(&h, counting, 16), "type code 77");
    h = header_of(false, 2, 8, 2, 2, 2);
    put_short(&h, 40, 9);
    expect_bad(write_nifti(&h, counting, 16), "9 dimensions");
    h = header_of(false, 2, 8, 2, 2, 2);
    put_float(&h, 108, NAN);
    expect_bad(write_nifti(&h, counting, 16), "begin at byte nan");
    h = header_of(false, 2, 8, 2, 2, 2);
    put_float(&h, 108, 1e9f);
    expect_bad(write_nifti(&h, counting, 16), "asks for");
    h = header_of(false, 2, 8, 2, 2, 2);
    h.bytes[1] = 2;
    expect_bad(write_nifti(&h, counting, 16), "348 or 540");
}

static void truncations(void **state)
{
    (void)state;
    struct header h = header_of(true, 4, 16, 2, 2, 2);
    const char *path = write_nifti(&h, counting, 16);
    expect_truncations_fail(path, scratch("cut.nii"), 368);
    size_t size;
    unsigned char *bytes = read_file(path, &size);
    write_gzip(scratch("z.nii.gz"), bytes, size);
    free(bytes);
    free(read_file(scratch("z.nii.gz"), &size));
    expect_truncations_fail(scratch("z.nii.gz"), scratch("cut.nii.gz"), size - 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_real_files), cmocka_unit_test(both_byte_orders), cmocka_unit_test(types_and_shapes),
        cmocka_unit_test(scaling_and_voids),   cmocka_unit_test(transforms),       cmocka_unit_test(two_files_and_second_version),
        cmocka_unit_test(lies),                cmocka_unit_test(truncations),
    };
    return cmocka_run_group_tests_name("nifti", tests, make_scratch, remove_scratch);
}
