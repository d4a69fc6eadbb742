/* SPDX-License-Identifier: MIT */
/* MetaImage: the facts of real files, every way of saying where the data are, round trips, damage. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"

static void facts_of_real_files(void **state)
{
    (void)state;
    expect_description(data_path("HeadMRVolume.mhd"), "metaimage 48x62x42 u8 x1\nspacing 4 4 4\norigin 0 0 0\n" PLAIN_AXES
                                                      "space unknown units ''\nmin 0 max 255 mean 24.468222 nonzero 123631 voids 0\n");
    expect_description(data_path("frogtissue.mhd"), "metaimage 500x470x136 u8 x1 labels\nspacing 1 1 1.5\norigin 0 0 0\n" PLAIN_AXES
                                                    "space unknown units ''\nmin 0 max 29 mean 0.384214 nonzero 1156957 voids 0\n");
}

static void round_trips(void **state)
{
    (void)state;
    expect_round_trips("a.mha", PEL_SPACE_LPS);
    expect_round_trips("a.mha", PEL_SPACE_UNKNOWN);
    expect_round_trips("b.mhd", PEL_SPACE_LPS);
}

/* The format's world is LPS: RAS comes back turned, and turned again it is what it was to the last bit. */
static void ras_is_turned(void **state)
{
    (void)state;
    struct pel_volume written, read;
    fill_volume(&written, PEL_I16, 1);
    written.space = PEL_SPACE_RAS;
    assert_true(pel_write_volume(scratch("r.mha"), &written, NULL, NULL));
    read_ok(scratch("r.mha"), &read, NULL);
    assert_int_equal(read.space, PEL_SPACE_LPS);
    assert_true(read.origin[0] == -written.origin[0] && read.origin[2] == written.origin[2]);
    pel_volume_to_space(&read, PEL_SPACE_RAS);
    expect_same(&written, &read);
    pel_volume_finish(&written);
    pel_volume_finish(&read);
}

static void anatomical_letters(void **state)
{
    (void)state;
    static const struct {
        double axes[3][3];
        const char *letters;
    } cases[] = { { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, "AnatomicalOrientation = RAI\n" },
                  { { { 0, 0, -1 }, { 0, 1, 0 }, { 1, 0, 0 } }, "AnatomicalOrientation = SAR\n" },
                  { { { -0.8, 0.6, 0 }, { 0.6, 0.8, 0 }, { 0, 0, 1 } }, "AnatomicalOrientation = LAI\n" } };
    for (size_t i = 0; i < 3; i++) {
        struct pel_volume v;
        size_t size;
        fill_volume(&v, PEL_U8, 1);
        v.space = PEL_SPACE_LPS;
        memcpy(v.direction, cases[i].axes, sizeof v.direction);
        assert_true(pel_write_volume(scratch("o.mha"), &v, NULL, NULL));
        pel_volume_finish(&v);
        unsigned char *bytes = read_file(scratch("o.mha"), &size);
        assert_non_null(strstr((char *)bytes, cases[i].letters));
        free(bytes);
    }
}

static const unsigned char counting[24] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23 };

static void write_mha(const char *path, const char *header, const void *data, size_t size)
{
    unsigned char file[2048];
    size_t n = strlen(header);
    assert_true(n + size <= sizeof file);
    memcpy(file, header, n);
    memcpy(file + n, data, size);
    write_file(path, file, n + size);
}

static void expect_values(const char *path, const unsigned char *values, size_t size)
{
    struct pel_volume v;
    read_ok(path, &v, NULL);
    assert_int_equal(pel_volume_bytes(&v), size);
    assert_memory_equal(v.data, values, size);
    pel_volume_finish(&v);
}

static void where_the_data_are(void **state)
{
    (void)state;
    write_file(scratch("s1.raw"), counting, 4);
    write_file(scratch("s2.raw"), counting + 4, 4);
    write_text(scratch("p.mhd"), "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = s%d.raw 1 2 1\n");
    expect_values(scratch("p.mhd"), counting, 8);
    write_text(scratch("p.mhd"),
               "NDims = 3\r\nDimSize = 2 2 2\r\nElementType = MET_UCHAR\r\nElementDataFile = LIST\r\ns1.raw\r\ns2.raw\r\n");
    expect_values(scratch("p.mhd"), counting, 8);
    write_text(scratch("p.mhd"), "NDims = 3\nDimSize = 2 2 1\nHeaderSize = -1\nElementType = MET_UCHAR\nElementDataFile = tail.raw\n");
    write_file(scratch("tail.raw"), counting, 24);
    expect_values(scratch("p.mhd"), counting + 20, 4);
    write_text(scratch("p.mhd"), "NDims = 3\nDimSize = 2 2 1\nHeaderSize = 3\nElementType = MET_UCHAR\nElementDataFile = tail.raw\n");
    expect_values(scratch("p.mhd"), counting + 3, 4);
    write_mha(scratch("t.mha"), "NDims = 3\nDimSize = 2 2 1\nBinaryData = False\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
              "1 2\n3 4", 7);
    expect_values(scratch("t.mha"), (unsigned char[]){ 1, 2, 3, 4 }, 4);
    write_mha(scratch("t.mha"), "NDims = 2\nDimSize = 2 2\nElementByteOrderMSB = True\nElementType = MET_SHORT\nElementDataFile = LOCAL\n",
              counting, 8);
    expect_values(scratch("t.mha"), (unsigned char[]){ 1, 0, 3, 2, 5, 4, 7, 6 }, 8);
    write_mha(scratch("t.mha"),
              "NDims = 3\nDimSize = 2 2 1\nElementNumberOfChannels = 3\nElementType = MET_UCHAR_ARRAY\nElementDataFile = LOCAL\n", counting,
              12);
    expect_values(scratch("t.mha"), counting, 12);
    /* Compressed, in a file whose name says nothing of it. */
    unsigned char packed[128];
    uLongf size = sizeof packed;
    compress(packed, &size, counting, 24);
    write_file(scratch("c.bin"), packed, size);
    write_text(scratch("c.mhd"), "NDims = 3\nDimSize = 2 3 4\nCompressedData = True\nElementType = MET_UCHAR\nElementDataFile = c.bin\n");
    expect_values(scratch("c.mhd"), counting, 24);
    write_gzip(scratch("c.bin"), counting, 24);
    write_text(scratch("c.mhd"), "NDims = 3\nDimSize = 2 3 4\nElementType = MET_UCHAR\nElementDataFile = c.bin\n");
    expect_values(scratch("c.mhd"), counting, 24);
}

static void placement(void **state)
{
    (void)state;
    write_mha(scratch("l.mha"),
              "ObjectType = Image\nNDims = 3\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\nElementSize = 9 9 9\nElementSpacing = "
              "0.5 2 3\n"
              "AnatomicalOrientation = ARI\nDistanceUnits = mm\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
              counting, 8);
    expect_description(scratch("l.mha"),
                       "metaimage 2x2x2 u8 x1\nspacing 0.5 2 3\norigin 1 2 3\naxis 0: 0 1 0\naxis 1: -1 0 0\naxis 2: 0 0 1\n"
                       "space LPS units 'mm'\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n");
    write_mha(scratch("l.mha"),
              "NDims = 3\nPosition = 1 2 3\nElementSize = 4 5 6\nElementSpacing = 0 5 6\nAnatomicalOrientation = ???\nDimSize = 2 2 2\n"
              "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
              counting, 8);
    expect_description(scratch("l.mha"), "metaimage 2x2x2 u8 x1\nspacing 1 5 6\norigin 1 2 3\n" PLAIN_AXES
                                         "space unknown units ''\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n"
                                         "note: the spacing of axis 0 is 0; taken as 1\n");
}

static void lies(void **state)
{
    (void)state;
    static const struct {
        const char *header, *says;
    } cases[] = {
        { "NDims = 3\nDimSize = 2 2 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "asks for 12 bytes" },
        { "NDims = 3\nDimSize = 4294967296 4294967296 4294967296\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "addressed" },
        { "NDims = 3\nDimSize = 3000 3000 3000\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n", "asks for 216000000000" },
        { "NDims = 3\nDimSize = 3000 3000 3000\nCompressedData = True\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n", "at most" },
        { "NDims = 3\nDimSize = 2 0 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "no samples along axis 1" },
        { "NDims = 3\nDimSize = 2 -2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "whole number" },
        { "NDims = 3\nDimSize = 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "whole number" },
        { "NDims = 30\nDimSize = 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "NDims" },
        { "DimSize = 2 2\nNDims = 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "NDims" },
        { "NDims = 3\nDimSize = 2 2 2\nElementType = MET_QUAD\nElementDataFile = LOCAL\n", "MET_QUAD" },
        { "NDims = 3\nDimSize = 2 2 2\nElementDataFile = LOCAL\n", "ElementType" },
        { "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n", "ElementDataFile" },
        { "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = lie.mha\n", "header itself" },
        { "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = nowhere.raw\n", "nowhere.raw" },
        { "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = %s%n 1 2 1\n", "%d" },
        { "NDims = 3\nDimSize = 2 2 2\nElementNumberOfChannels = 9\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "9 numbers" },
        { "NDims = 3\nDimSize = 2 2 2\nElementNumberOfChannels = 0\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "0 numbers" },
        { "NDims = 3\nDimSize = 2 2 2\nHeaderSize = 100000000000\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "skip" },
        { "NDims = 3\nDimSize = 2 2 2\nCompressedData = True\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "compressed" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_mha(scratch("lie.mha"), cases[i].header, counting, 8);
        expect_bad(scratch("lie.mha"), cases[i].says);
    }
}

static void truncations(void **state)
{
    (void)state;
    for (int compress = 0; compress < 2; compress++) {
        struct pel_volume v;
        struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
        size_t size;
        params.compress = compress;
        fill_volume(&v, PEL_F64, 1);
        assert_true(pel_write_volume(scratch("t.mha"), &v, &params, NULL));
        pel_volume_finish(&v);
        free(read_file(scratch("t.mha"), &size));
        expect_truncations_fail(scratch("t.mha"), scratch("cut.mha"), compress ? size - 16 : size);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_real_files), cmocka_unit_test(round_trips), cmocka_unit_test(ras_is_turned),
        cmocka_unit_test(anatomical_letters),  cmocka_unit_test(where_the_data_are), cmocka_unit_test(placement),
        cmocka_unit_test(lies),                cmocka_unit_test(truncations),
    };
    return cmocka_run_group_tests_name("metaimage", tests, make_scratch, remove_scratch);
}
