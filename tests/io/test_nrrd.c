/* SPDX-License-Identifier: MIT */
/* NRRD: the facts of real files, the axes' meanings, all encodings, round trips, damage. */
#include "support.h"

#include <bzlib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"

static void facts_of_real_files(void **state)
{
    (void)state;
    expect_description(data_path("aneurism.nrrd"), "nrrd 256x256x256 u8 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                   "space unknown units ''\nmin 0 max 255 mean 1.069210 nonzero 168948 voids 0\n");
    expect_description(data_path("engine.nhdr"), "nrrd 256x256x128 u8 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                 "space unknown units ''\nmin 0 max 255 mean 22.348768 nonzero 5198360 voids 0\n");
    expect_description(data_path("neghip.nrrd"), "nrrd 64x64x64 u8 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                 "space unknown units ''\nmin 0 max 255 mean 18.402775 nonzero 121586 voids 0\n");
    expect_description(data_path("tooth.nhdr"), "nrrd 103x94x161 u16 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                "space unknown units ''\nmin 0 max 1300 mean 526.871014 nonzero 1558793 voids 0\n");
    expect_description(data_path("vishuman_head.nrrd"), "nrrd 512x512x234 u8 x1\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                                                        "space unknown units ''\nmin 0 max 255 mean 10.467327 nonzero 13211212 voids 0\n");
    expect_description(data_path("template_T2.nrrd"),
                       "nrrd 117x159x126 f32 x1\nspacing 0.859375 0.859375 0.859375\norigin -49.84375 67.890625 -53.7109375\n" PLAIN_AXES
                       "space LPS units ''\nmin 0 max 710.678 mean 64.398702 nonzero 2193126 voids 0\n");
    expect_description(data_path("carotid_velocity.nrrd"),
                       "nrrd 76x49x45 f32 x3\nspacing 1 1 1\norigin 0 0 0\n" PLAIN_AXES
                       "space unknown units ''\nmin 0 max 22.6949 mean 0.167487 nonzero 167561 voids 0\n");
    expect_description(data_path("wind.nrrd"), "nrrd 41x35x15 f32 x3\nspacing 1.6028 1.25 1.143\norigin 0 0 0\n" PLAIN_AXES
                                               "space unknown units ''\nmin 0.268123 max 78.907 mean 20.598614 nonzero 21525 voids 0\n");
}

static void round_trips(void **state)
{
    (void)state;
    expect_round_trips("a.nrrd", PEL_SPACE_RAS);
    expect_round_trips("a.nrrd", PEL_SPACE_LPS);
    expect_round_trips("a.nrrd", PEL_SPACE_UNKNOWN);
    expect_round_trips("b.nhdr", PEL_SPACE_RAS);
}

/* A header and what follows it. */
static void write_nrrd(const char *path, const char *header, const void *data, size_t size)
{
    char bytes[4096];
    int n = snprintf(bytes, sizeof bytes, "NRRD0004\n%s\n", header);
    assert_true((size_t)n + size < sizeof bytes);
    memcpy(bytes + n, data, size);
    write_file(path, bytes, (size_t)n + size);
}

static const unsigned char counting[64] = { 0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
                                            22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 37, 38, 39, 40, 41, 42, 43,
                                            44, 45, 46, 47, 48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62, 63 };

static void encodings(void **state)
{
    (void)state;
    const char *path = scratch("e.nrrd");
    struct pel_volume v;
    char packed[512];
    unsigned packed_size = sizeof packed;
    BZ2_bzBuffToBuffCompress(packed, &packed_size, (char *)counting, 24, 9, 0, 0);
    write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: bzip2\n", packed, packed_size);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, counting, 24);
    pel_volume_finish(&v);
    /* Behind the last block there is only a checksum of checksums. */
    for (unsigned cut = 0; cut + 11 < packed_size; cut++) {
        write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: bzip2\n", packed, cut);
        read_bad(path, NULL);
    }
    write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 1 2\nencoding: hex\n", "00 0a\nfF1\n0", 11);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, ((unsigned char[]){ 0, 10, 255, 16 }), 4);
    pel_volume_finish(&v);
    write_nrrd(path, "type: float\ndimension: 3\nsizes: 2 1 2\nencoding: ascii\n", "1.5 -2\nnan 1e3", 14);
    read_ok(path, &v, NULL);
    assert_true(((float *)v.data)[0] == 1.5f && ((float *)v.data)[1] == -2 && isnan(((float *)v.data)[2]) && ((float *)v.data)[3] == 1000);
    assert_true(v.range[0] == -2 && v.range[1] == 1000);
    pel_volume_finish(&v);
    write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 1 2\nencoding: ascii\n", "1 2 3 256", 9);
    read_bad(path, NULL);
    /* The last 8 bytes before one that is left over; lines and bytes to skip. */
    write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nbyte skip: -2\n", counting, 20);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, counting + 11, 8);
    pel_volume_finish(&v);
    write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nline skip: 2\nbyte skip: 1\n", "a\nbc\n-ABCDEFGH", 14);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, "ABCDEFGH", 8);
    pel_volume_finish(&v);
}

/* Several streams in a row, as pbzip2 writes them, cut in the middle of a stream and between two. */
static void bzip2_streams(void **state)
{
    (void)state;
    const char *path = scratch("m.nrrd"), *header = "type: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: bzip2\n";
    struct pel_volume v;
    char packed[1024];
    unsigned size = 0, ends[4];
    for (int i = 0; i < 4; i++) { /* 10, 0, 10 and 4 bytes */
        static const int starts[] = { 0, 10, 10, 20, 24 };
        ends[i] = sizeof packed - size;
        BZ2_bzBuffToBuffCompress(packed + size, &ends[i], (char *)counting + starts[i], (unsigned)(starts[i + 1] - starts[i]), 9, 0, 0);
        size += ends[i];
        ends[i] = size;
    }
    write_nrrd(path, header, packed, size);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, counting, 24);
    pel_volume_finish(&v);
    write_nrrd(path, header, packed, ends[2]);
    expect_bad(path, "4 bytes of samples are missing");
    write_nrrd(path, header, packed, ends[2] - 20);
    expect_bad(path, "missing");
    memcpy(packed + ends[2], "no bzip2", 8);
    write_nrrd(path, header, packed, ends[2] + 8);
    expect_bad(path, "damaged");
}

static bool stop_in_the_middle(void *user, double fraction)
{
    (void)user;
    return fraction < 0.5;
}

/* What stopped the reading of numbers in text is what is told, not that there are too few of them. */
static void text_that_stops(void **state)
{
    (void)state;
    enum { COUNT = 40000 };
    struct pel_volume v;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    char *text = malloc(COUNT * 8 + 100);
    assert_non_null(text);
    size_t size = (size_t)sprintf(text, "NRRD0004\ntype: int64\ndimension: 3\nsizes: %d 1 1\nencoding: ascii\n\n", COUNT);
    for (int i = 0; i < COUNT; i++)
        size += (size_t)sprintf(text + size, "%d\n", i * 7919 % 1000003);
    write_file(scratch("stop.nrrd"), text, size);
    read_ok(scratch("stop.nrrd"), &v, NULL);
    assert_true(((double *)v.data)[COUNT - 1] == (COUNT - 1) * 7919 % 1000003);
    pel_volume_finish(&v);
    params.progress = (struct pel_progress){ stop_in_the_middle, NULL };
    pel_volume_init(&v);
    assert_false(pel_read_volume(scratch("stop.nrrd"), &params, &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_CANCELLED);
    write_gzip(scratch("stop.nrrd"), text, size);
    free(text);
    unsigned char *packed = read_file(scratch("stop.nrrd"), &size);
    write_file(scratch("stop.nrrd"), packed, size / 2);
    free(packed);
    expect_bad(scratch("stop.nrrd"), "the compressed data end too early");
}

static void big_integers(void **state)
{
    (void)state;
    const char *path = scratch("i.nrrd");
    struct pel_volume v;
    int64_t fits[2] = { -((int64_t)1 << 53), 5 }, beyond[2] = { ((int64_t)1 << 53) + 1, 5 };
    write_nrrd(path, "type: int64\ndimension: 3\nsizes: 2 1 1\nencoding: raw\nendian: little\n", fits, 16);
    read_ok(path, &v, NULL);
    assert_int_equal(v.type, PEL_F64);
    assert_true(((double *)v.data)[0] == -9007199254740992.0 && ((double *)v.data)[1] == 5);
    pel_volume_finish(&v);
    write_nrrd(path, "type: int64\ndimension: 3\nsizes: 2 1 1\nencoding: raw\nendian: little\n", beyond, 16);
    expect_bad(path, "2^53");
}

static void axes(void **state)
{
    (void)state;
    const char *path = scratch("x.nrrd");
    struct pel_volume v;
    struct pel_file_info info;
    /* Components last: they come first in memory. */
    write_nrrd(path, "type: uchar\ndimension: 4\nsizes: 2 2 2 3\nkinds: domain domain domain vector\nencoding: raw\n", counting, 24);
    read_ok(path, &v, &info);
    assert_int_equal(v.components, 3);
    assert_memory_equal(v.data, ((unsigned char[]){ 0, 8, 16, 1, 9, 17, 2, 10, 18 }), 9);
    pel_volume_finish(&v);
    /* Components in the middle, and a list of volumes in front of which the first is taken. */
    write_nrrd(path, "type: uchar\ndimension: 5\nsizes: 5 2 3 2 1\nkinds: list space vector space space\nencoding: raw\n", counting, 60);
    read_ok(path, &v, &info);
    assert_int_equal(v.components, 3);
    assert_memory_equal(v.dims, ((size_t[]){ 2, 2, 1 }), sizeof v.dims);
    assert_memory_equal(v.data, ((unsigned char[]){ 0, 10, 20, 5, 15, 25, 30, 40, 50, 35, 45, 55 }), 12);
    assert_int_equal(info.note_count, 1);
    pel_volume_finish(&v);
    /* Time is no component, however short. */
    write_nrrd(path, "type: uchar\ndimension: 4\nsizes: 2 2 2 2\nkinds: domain domain domain time\nencoding: raw\n", counting, 16);
    read_ok(path, &v, &info);
    assert_int_equal(v.components, 1);
    assert_memory_equal(v.data, counting, 8);
    pel_volume_finish(&v);
    /* An image is a volume of one slice. */
    write_nrrd(path, "type: uchar\ndimension: 2\nsizes: 4 2\nspacings: 0.5 2\nencoding: raw\n", counting, 8);
    expect_description(path, "nrrd 4x2x1 u8 x1\nspacing 0.5 2 1\norigin 0 0 0\n" PLAIN_AXES
                             "space unknown units ''\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n");
    write_nrrd(path, "type: uchar\ndimension: 1\nsizes: 4\nencoding: raw\n", counting, 4);
    expect_bad(path, "axes");
    write_nrrd(path, "type: uchar\ndimension: 4\nsizes: 6 2 2 2\nkinds: 3D-symmetric-matrix space space space\nencoding: raw\n", counting,
               48);
    expect_bad(path, "1 to 4");
}

static void spaces(void **state)
{
    (void)state;
    const char *path = scratch("s.nrrd");
    const char *header = "type: uchar\ndimension: 3\nspace: %s\nsizes: 2 2 2\nspace directions: (0,3,0) (1,0,0.5) (0,0,-2)\n"
                         "space origin: (10,20,30)\nspace units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n";
    char text[512];
    snprintf(text, sizeof text, header, "left-anterior-superior");
    write_nrrd(path, text, counting, 8);
    expect_description(path, "nrrd 2x2x2 u8 x1\nspacing 3 1.11803399 2\norigin -10 20 30\naxis 0: 0 1 0\naxis 1: -0.894427 0 0.447214\n"
                             "axis 2: 0 0 -1\nspace RAS units 'mm'\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n"
                             "note: its world was left-anterior-superior; x is negated, and it is RAS now\n");
    snprintf(text, sizeof text, header, "LPS");
    write_nrrd(path, text, counting, 8);
    expect_description(path, "nrrd 2x2x2 u8 x1\nspacing 3 1.11803399 2\norigin 10 20 30\naxis 0: 0 1 0\naxis 1: 0.894427 0 0.447214\n"
                             "axis 2: 0 0 -1\nspace LPS units 'mm'\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n");
    /* Vectors turn with their world; colours do not. */
    struct pel_volume v;
    float vector[3] = { 1, 2, 3 };
    const char *field =
        "type: float\ndimension: 4\nspace: LAS\nsizes: 3 1 1 1\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: %s domain "
        "domain domain\nendian: little\nencoding: raw\n";
    snprintf(text, sizeof text, field, "vector");
    write_nrrd(path, text, vector, sizeof vector);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, ((float[]){ -1, 2, 3 }), sizeof vector);
    pel_volume_finish(&v);
    snprintf(text, sizeof text, field, "RGB-color");
    write_nrrd(path, text, vector, sizeof vector);
    read_ok(path, &v, NULL);
    assert_memory_equal(v.data, vector, sizeof vector);
    pel_volume_finish(&v);
    /* Directions in a plane cannot be drawn with; spacing is what is left of them. */
    write_nrrd(path,
               "type: uchar\ndimension: 3\nspace dimension: 3\nsizes: 2 2 2\nspace directions: (2,0,0) (4,0,0) (0,0,1)\nencoding: raw\n",
               counting, 8);
    expect_description(path, "nrrd 2x2x2 u8 x1\nspacing 2 4 1\norigin 0 0 0\n" PLAIN_AXES
                             "space unknown units ''\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n"
                             "note: the axis directions lie in a plane; taken as the axes x, y and z\n");
    /* Cells have their first sample half a spacing within. */
    write_nrrd(path, "type: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 2 2 2\naxis mins: 5 5 5\ncenters: cell node cell\nencoding: raw\n",
               counting, 8);
    expect_description(path, "nrrd 2x2x2 u8 x1\nspacing 2 2 2\norigin 6 5 6\n" PLAIN_AXES
                             "space unknown units ''\nmin 0 max 7 mean 3.500000 nonzero 7 voids 0\n");
}

static void detached(void **state)
{
    (void)state;
    struct pel_volume v;
    write_file(scratch("p1.raw"), counting, 4);
    write_file(scratch("p2.raw"), counting + 4, 4);
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: p%d.raw 1 2 1\n");
    read_ok(scratch("d.nhdr"), &v, NULL);
    assert_memory_equal(v.data, counting, 8);
    pel_volume_finish(&v);
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: LIST\np2.raw\r\np1.raw\n");
    read_ok(scratch("d.nhdr"), &v, NULL);
    assert_memory_equal(v.data, ((unsigned char[]){ 4, 5, 6, 7, 0, 1, 2, 3 }), 8);
    pel_volume_finish(&v);
    /* Data that are gzip'd though the header says raw are found by content. */
    write_gzip(scratch("g.raw"), counting, 8);
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: g.raw\n");
    read_ok(scratch("d.nhdr"), &v, NULL);
    assert_memory_equal(v.data, counting, 8);
    pel_volume_finish(&v);
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: none.raw\n");
    expect_bad(scratch("d.nhdr"), "none.raw");
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: d.nhdr\n");
    expect_bad(scratch("d.nhdr"), "header itself");
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: p%s%n.raw 1 2 1\n");
    expect_bad(scratch("d.nhdr"), "%d");
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: p%d.raw 1 3 1\n");
    expect_bad(scratch("d.nhdr"), "evenly");
    write_text(scratch("d.nhdr"), "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 3\nencoding: raw\ndata file: p%d.raw 1 3 1\n");
    expect_bad(scratch("d.nhdr"), "p3.raw");
}

static void whole_file_gzipped(void **state)
{
    (void)state;
    struct pel_volume v;
    static const char header[] = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\nABCDEFGH";
    write_gzip(scratch("wrong-name.dat"), header, sizeof header - 1);
    read_ok(scratch("wrong-name.dat"), &v, NULL);
    assert_memory_equal(v.data, "ABCDEFGH", 8);
    pel_volume_finish(&v);
}

static void lies(void **state)
{
    (void)state;
    static const struct {
        const char *header, *says;
    } cases[] = {
        { "type: uchar\ndimension: 3\nsizes: 2 2 3\nencoding: raw\n", "12 bytes of samples" },
        { "type: float\ndimension: 3\nsizes: 2048 2048 2048\nencoding: raw\nendian: little\n", "asks for 34359738368 bytes" },
        { "type: double\ndimension: 3\nsizes: 4294967296 4294967296 4294967296\nencoding: raw\nendian: little\n", "" },
        { "type: double\ndimension: 3\nsizes: 99999999999999999999 1 1\nencoding: raw\nendian: little\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 0 4 4\nencoding: raw\n", "" },
        { "type: uchar\ndimension: 3\nsizes: -2 -4 1\nencoding: raw\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 2 2\nencoding: raw\n", "" },
        { "type: quadruple\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n", "quadruple" },
        { "type: uchar\ndimension: 99\nsizes: 2 2 2\nencoding: raw\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: zip\n", "zip" },
        { "type: short\ndimension: 3\nsizes: 2 2 1\nencoding: raw\nendian: middle\n", "middle" },
        { "type: short\ndimension: 3\nsizes: 2 2 1\nencoding: raw\n", "endian" },
        { "dimension: 3\nsizes: 2 2 2\nencoding: raw\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 2 2 2\n", "encoding" },
        { "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 20000 20000 20000\nencoding: gzip\n", "asks for" },
        { "type: uchar\ndimension: 3\nsizes: 20000 20000 20000\nencoding: bzip2\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 20000 20000 20000\nencoding: ascii\n", "asks for" },
        { "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nbyte skip: 1000000000000\n", "skip" },
        { "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nline skip: 3\n", "" },
        { "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nfavourite: colour\n", "favourite" },
        { "no header line at all\n", "" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_nrrd(scratch("lie.nrrd"), cases[i].header, counting, 8);
        expect_bad(scratch("lie.nrrd"), cases[i].says);
    }
}

static void truncations(void **state)
{
    (void)state;
    size_t size;
    for (int compress = 0; compress < 2; compress++) {
        struct pel_volume v;
        struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
        params.compress = compress;
        fill_volume(&v, PEL_U16, 1);
        assert_true(pel_write_volume(scratch("t.nrrd"), &v, &params, NULL));
        pel_volume_finish(&v);
        free(read_file(scratch("t.nrrd"), &size));
        /* The trailer of gzip is not needed for the samples. */
        expect_truncations_fail(scratch("t.nrrd"), scratch("cut.nrrd"), compress ? size - 8 : size);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_real_files),
        cmocka_unit_test(round_trips),
        cmocka_unit_test(encodings),
        cmocka_unit_test(big_integers),
        cmocka_unit_test(axes),
        cmocka_unit_test(spaces),
        cmocka_unit_test(detached),
        cmocka_unit_test(whole_file_gzipped),
        cmocka_unit_test(lies),
        cmocka_unit_test(truncations),
        cmocka_unit_test(bzip2_streams),
        cmocka_unit_test(text_that_stops),
    };
    return cmocka_run_group_tests_name("nrrd", tests, make_scratch, remove_scratch);
}
