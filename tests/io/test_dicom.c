/* SPDX-License-Identifier: MIT */
/* DICOM: the facts of a real series; series that are mixed, unordered, tilted, doubled or have gaps; every encoding of the header and of
 * pixels; damage. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define PLAIN_AXES "axis 0: 1 0 0\naxis 1: 0 1 0\naxis 2: 0 0 1\n"
#define IMPLICIT "1.2.840.10008.1.2"
#define EXPLICIT "1.2.840.10008.1.2.1"
#define BIG "1.2.840.10008.1.2.2"
#define RLE "1.2.840.10008.1.2.5"

static void facts_of_a_real_series(void **state)
{
    (void)state;
    expect_description(data_path("pet_dicom"),
                       "dicom 128x128x299 f32 x1\nspacing 3.5378182 3.5378182 3.375\norigin -226.13246 -425.88375 -1259.459\n" PLAIN_AXES
                       "space LPS units 'mm'\nmin 0 max 66260.8 mean 887.953390 nonzero 3994475 voids 0\n"
                       "note: stored numbers 0 to 32766 are scaled by the file's slope 2.02224 and intercept 0\n");
}

/* A file that is being written. */
struct file {
    unsigned char bytes[1 << 14];
    size_t size;
    bool implicit, big_endian;
};

static void put(struct file *f, const void *bytes, size_t size)
{
    assert_true(f->size + size <= sizeof f->bytes);
    memcpy(f->bytes + f->size, bytes, size);
    f->size += size;
}

static void put_number(struct file *f, uint32_t value, int size)
{
    for (int i = 0; i < size; i++)
        put(f, &(unsigned char) { (unsigned char)(value >> 8 * (f->big_endian ? size - 1 - i : i)) }, 1);
}

/* The beginning of an element. */
static void put_tag(struct file *f, uint32_t tag, const char *vr, uint32_t length)
{
    put_number(f, tag >> 16, 2);
    put_number(f, tag & 0xffff, 2);
    if (!vr || f->implicit) {
        put_number(f, length, 4);
        return;
    }
    put(f, vr, 2);
    if (strstr("OB OW OF OD SQ UN UT", vr)) {
        put_number(f, 0, 2);
        put_number(f, length, 4);
    } else {
        put_number(f, length, 2);
    }
}

static void put_text(struct file *f, uint32_t tag, const char *vr, const char *text)
{
    size_t length = strlen(text), padded = length + length % 2;
    put_tag(f, tag, vr, (uint32_t)padded);
    put(f, text, length);
    put(f, !strcmp(vr, "UI") ? "" : " ", padded - length);
}

static void put_short(struct file *f, uint32_t tag, unsigned value)
{
    put_tag(f, tag, "US", 2);
    put_number(f, value, 2);
}

/* What is told of a slice; NULL or 0: not at all, or what is usual. */
struct slice {
    const char *syntax, *series, *position, *orientation, *spacing, *slope, *intercept, *photometric, *frames;
    int number, instance;
    int bits, stored, is_signed, samples, planes;
    int rows, columns;
    bool no_preamble;
};

static void begin(struct file *f, const struct slice *s)
{
    char text[32];
    const char *syntax = s->syntax ? s->syntax : EXPLICIT;
    memset(f, 0, sizeof *f);
    if (!s->no_preamble) {
        f->size = 128;
        put(f, "DICM", 4);
        put_text(f, 0x00020010, "UI", syntax);
    }
    f->implicit = !strcmp(syntax, IMPLICIT);
    f->big_endian = !strcmp(syntax, BIG);
    put_text(f, 0x00080060, "CS", "CT");
    put_text(f, 0x0008103e, "LO", "A series");
    /* a private sequence of undefined length, to be stepped over */
    put_tag(f, 0x00091001, "SQ", 0xffffffff);
    put_tag(f, 0xfffee000, NULL, 0xffffffff);
    put_text(f, 0x00280010, "US", "zz");
    put_tag(f, 0xfffee00d, NULL, 0);
    put_tag(f, 0xfffee0dd, NULL, 0);
    put_text(f, 0x00180050, "DS", "2.5");
    put_text(f, 0x0020000e, "UI", s->series ? s->series : "1.2.3");
    snprintf(text, sizeof text, "%d", s->number);
    put_text(f, 0x00200011, "IS", text);
    snprintf(text, sizeof text, "%d", s->instance);
    put_text(f, 0x00200013, "IS", text);
    if (s->position)
        put_text(f, 0x00200032, "DS", s->position);
    if (s->orientation)
        put_text(f, 0x00200037, "DS", s->orientation);
    put_short(f, 0x00280002, s->samples ? (unsigned)s->samples : 1);
    put_text(f, 0x00280004, "CS", s->photometric ? s->photometric : "MONOCHROME2");
    if (s->samples > 1)
        put_short(f, 0x00280006, (unsigned)s->planes);
    if (s->frames)
        put_text(f, 0x00280008, "IS", s->frames);
    put_short(f, 0x00280010, s->rows ? (unsigned)s->rows : 2);
    put_short(f, 0x00280011, s->columns ? (unsigned)s->columns : 3);
    if (s->spacing)
        put_text(f, 0x00280030, "DS", s->spacing);
    put_short(f, 0x00280100, s->bits ? (unsigned)s->bits : 16);
    put_short(f, 0x00280101, s->stored ? (unsigned)s->stored : s->bits ? (unsigned)s->bits : 16);
    put_short(f, 0x00280102, (s->stored ? (unsigned)s->stored : s->bits ? (unsigned)s->bits : 16) - 1);
    put_short(f, 0x00280103, (unsigned)s->is_signed);
    if (s->intercept)
        put_text(f, 0x00281052, "DS", s->intercept);
    if (s->slope)
        put_text(f, 0x00281053, "DS", s->slope);
}

/* Six numbers, or `count`: base, base + 1, ... */
static void put_pixels(struct file *f, const struct slice *s, int base, int count)
{
    int size = (s->bits ? s->bits : 16) / 8;
    put_tag(f, 0x7fe00010, size == 1 ? "OB" : "OW", (uint32_t)(size * count));
    for (int i = 0; i < count; i++)
        put_number(f, (uint32_t)(base + i), size);
}

static void write_slice(const char *path, const struct slice *s, int base)
{
    static struct file f;
    begin(&f, s);
    put_pixels(&f, s, base, (s->rows ? s->rows : 2) * (s->columns ? s->columns : 3) * (s->samples ? s->samples : 1));
    write_file(path, f.bytes, f.size);
}

#define STANDARD .orientation = "1\\0\\0\\0\\1\\0", .spacing = "0.5\\0.25"

static void header_encodings(void **state)
{
    (void)state;
    static const char *const syntaxes[] = { IMPLICIT, EXPLICIT, BIG };
    for (int i = 0; i < 6; i++) {
        struct slice s = { .syntax = syntaxes[i % 3], .position = "1\\2\\3", STANDARD, .no_preamble = i / 3 };
        if (s.no_preamble && i % 3 == 2)
            continue;
        write_slice(scratch("a.dcm"), &s, 100);
        expect_description(scratch("a.dcm"), "dicom 3x2x1 u16 x1\nspacing 0.25 0.5 2.5\norigin 1 2 3\n" PLAIN_AXES
                                             "space LPS units 'mm'\nmin 100 max 105 mean 102.500000 nonzero 6 voids 0\n"
                                             "note: one slice; give the folder to read the series that it may be of\n");
    }
}

static void expect_numbers(const struct slice *s, int base, enum pel_type type, const double *values)
{
    struct pel_volume v;
    write_slice(scratch("n.dcm"), s, base);
    read_ok(scratch("n.dcm"), &v, NULL);
    assert_int_equal(v.type, type);
    for (size_t i = 0; i < 6; i++)
        assert_true(pel_volume_get(&v, i % 3, i / 3, 0, 0) == values[i]);
    pel_volume_finish(&v);
}

static void numbers(void **state)
{
    (void)state;
    expect_numbers(&(struct slice) { .bits = 8 }, 250, PEL_U8, (double[]) { 250, 251, 252, 253, 254, 255 });
    expect_numbers(&(struct slice) { .bits = 8, .is_signed = 1 }, 250, PEL_I8, (double[]) { -6, -5, -4, -3, -2, -1 });
    expect_numbers(&(struct slice) { .bits = 16, .is_signed = 1 }, -3, PEL_I16, (double[]) { -3, -2, -1, 0, 1, 2 });
    expect_numbers(&(struct slice) { .bits = 32 }, 70000, PEL_U32, (double[]) { 70000, 70001, 70002, 70003, 70004, 70005 });
    /* 12 bits of 16: what stands above them is no part of the number */
    expect_numbers(&(struct slice) { .stored = 12, .is_signed = 1 }, 0xf7fe, PEL_I16,
                   (double[]) { 2046, 2047, -2048, -2047, -2046, -2045 });
    /* CT: whole numbers stay whole, and get another type only where they must */
    expect_numbers(&(struct slice) { .slope = "1", .intercept = "-1024" }, 1022, PEL_I16, (double[]) { -2, -1, 0, 1, 2, 3 });
    expect_numbers(&(struct slice) { .intercept = "-1024" }, 2000, PEL_U16, (double[]) { 976, 977, 978, 979, 980, 981 });
    expect_numbers(&(struct slice) { .intercept = "10", .is_signed = 1 }, 32760, PEL_U16,
                   (double[]) { 32770, 32771, 32772, 32773, 32774, 32775 });
    expect_numbers(&(struct slice) { .intercept = "10" }, 65530, PEL_I32, (double[]) { 65540, 65541, 65542, 65543, 65544, 65545 });
    expect_numbers(&(struct slice) { .slope = "0.5", .intercept = "1" }, 10, PEL_F32, (double[]) { 6, 6.5, 7, 7.5, 8, 8.5 });
    expect_numbers(&(struct slice) { .intercept = "0.25" }, 10, PEL_F32, (double[]) { 10.25, 11.25, 12.25, 13.25, 14.25, 15.25 });
}

static void colours(void **state)
{
    (void)state;
    struct pel_volume v;
    for (int planes = 0; planes < 2; planes++) {
        struct slice s = { .bits = 8, .samples = 3, .photometric = "RGB", .planes = planes };
        write_slice(scratch("c.dcm"), &s, 0);
        read_ok(scratch("c.dcm"), &v, NULL);
        assert_int_equal(v.components, 3);
        for (size_t i = 0; i < 6; i++)
            for (int c = 0; c < 3; c++)
                assert_true(pel_volume_get(&v, i % 3, i / 3, 0, c) == (double)(planes ? (size_t)c * 6 + i : i * 3 + (size_t)c));
        pel_volume_finish(&v);
    }
    write_slice(scratch("c.dcm"), &(struct slice) { .bits = 8, .samples = 3, .photometric = "YBR_FULL" }, 0);
    expect_bad(scratch("c.dcm"), "YBR_FULL");
}

/* An empty folder of this name. */
static const char *folder(const char *name)
{
    char command[600];
    snprintf(command, sizeof command, "rm -rf '%s'", scratch(name));
    assert_int_equal(system(command), 0);
    mkdir(scratch(name), 0777);
    return scratch(name);
}

/* Slices z = 0, 1, ... at `step` mm, with numbers from 10 * z on, under names and in an order that say nothing. `missing` and `twice` are
 * slices, or -1. */
static void write_series(const char *name, int count, double step, int missing, int twice, const struct slice *like)
{
    char path[600], position[64];
    for (int z = 0; z < count; z++)
        for (int copy = 0; copy <= (z == twice) && z != missing; copy++) {
            struct slice s = *like;
            snprintf(position, sizeof position, "-1\\%g\\%.10g", s.rows == 4 ? 0.5 * z : -2.0, 7 + step * z);
            s.position = position;
            s.instance = 100 - z;
            snprintf(path, sizeof path, "%s/%s%02d%s", scratch(name), like->series ? like->series : "x", (z * 7) % count,
                     copy ? "copy" : "");
            write_slice(path, &s, 10 * z);
        }
}

static void expect_series(const char *name, const char *array, int count, double base, const char *notes)
{
    struct pel_volume v;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    static struct pel_file_info info;
    char text[2048] = "";
    params.array = array;
    pel_volume_init(&v);
    if (!pel_read_volume(scratch(name), &params, &v, &info, &error))
        fail_msg("%s", error.message);
    for (int i = 0; i < info.note_count; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s\n", info.notes[i]);
    assert_string_equal(text, notes);
    assert_int_equal(v.dims[2], count);
    for (int z = 0; z < count; z++)
        assert_true(pel_volume_get(&v, 0, 0, (size_t)z, 0) == base + 10 * z);
    pel_volume_finish(&v);
}

static void series_in_order(void **state)
{
    (void)state;
    struct pel_volume v;
    folder("s");
    write_series("s", 8, 3, -1, -1, &(struct slice) { STANDARD });
    expect_series("s", NULL, 8, 0, "");
    read_ok(scratch("s"), &v, NULL);
    assert_true(v.spacing[0] == 0.25 && v.spacing[1] == 0.5 && v.spacing[2] == 3 && v.origin[2] == 7 && v.direction[2][2] == 1);
    assert_string_equal(v.name, "A series");
    pel_volume_finish(&v);
    /* the other way round the patient: the normal points down, and the first slice is the highest */
    folder("s");
    write_series("s", 8, -3, -1, -1, &(struct slice) { .orientation = "1\\0\\0\\0\\-1\\0", .spacing = "1\\1" });
    expect_series("s", NULL, 8, 0, "");
    read_ok(scratch("s"), &v, NULL);
    assert_true(v.origin[2] == 7 && v.direction[2][2] == -1 && v.direction[1][1] == -1);
    pel_volume_finish(&v);
    /* a tilted gantry: slices move along y too */
    folder("s");
    write_series("s", 8, 2, -1, -1, &(struct slice) { STANDARD, .rows = 4 });
    read_ok(scratch("s"), &v, NULL);
    double corner[3];
    pel_volume_index_to_world(&v, (const double[3]) { 0, 0, 7 }, corner);
    assert_float_equal(corner[0], -1, 1e-9);
    assert_float_equal(corner[1], 3.5, 1e-9);
    assert_float_equal(corner[2], 21, 1e-9);
    pel_volume_finish(&v);
}

static void series_with_faults(void **state)
{
    (void)state;
    struct slice standard = { STANDARD };
    folder("s");
    write_series("s", 8, 3, 3, -1, &standard);
    expect_bad(scratch("s"), "slices are missing: 6 mm lie between");
    expect_bad(scratch("s"), "find the 1 missing");
    folder("s");
    write_series("s", 8, 3, -1, 5, &standard);
    expect_series("s", NULL, 8, 0, "1 slices at a place that another one has are left out\n");
    /* the same stack at three times: the first by instance number */
    folder("s");
    for (int time = 0; time < 3; time++)
        for (int z = 0; z < 4; z++) {
            char path[600], position[64];
            snprintf(position, sizeof position, "0\\0\\%d", z);
            snprintf(path, sizeof path, "%s/%d%d", scratch("s"), time, z);
            write_slice(path, &(struct slice) { STANDARD, .position = position, .instance = time * 4 + z }, time * 1000 + z * 10);
        }
    expect_series("s", NULL, 4, 0, "3 stacks at the same place (times, echoes): the first is read\n");
    /* a little uneven, and too much so */
    folder("s");
    write_series("s", 8, 3, 3, -1, &standard);
    write_slice(scratch("s/between"), &(struct slice) { STANDARD, .position = "-1\\-2\\16.2", .instance = 50 }, 30);
    expect_series("s", NULL, 8, 0, "the slices are unevenly spaced, by up to 0.067 of a step: even steps of 3 mm are taken\n");
    write_slice(scratch("s/between"), &(struct slice) { STANDARD, .position = "-1\\-2\\17", .instance = 50 }, 30);
    expect_bad(scratch("s"), "unevenly spaced");
    /* slices that do not say where they are */
    folder("s");
    for (int z = 0; z < 3; z++) {
        char path[600];
        snprintf(path, sizeof path, "%s/%c", scratch("s"), "bca"[z]);
        write_slice(path, &(struct slice) { .instance = z + 9 }, 10 * z);
    }
    expect_series("s", NULL, 3, 0,
                  "the files do not tell the distance of pixels: taken as 1 mm\n"
                  "the files do not tell where slices lie: sorted by instance number, 2.5 mm apart\n");
}

static void mixed_folders(void **state)
{
    (void)state;
    folder("m");
    write_series("m", 5, 3, -1, -1, &(struct slice) { STANDARD, .series = "1.5", .number = 7 });
    write_series("m", 3, 3, -1, -1, &(struct slice) { STANDARD, .series = "1.6", .number = 8, .intercept = "500" });
    write_slice(
        scratch("m/localizer"),
        &(struct slice) { .series = "1.5", .number = 7, .orientation = "0\\1\\0\\0\\0\\-1", .spacing = "1\\1", .position = "0\\0\\0" }, 9);
    write_text(scratch("m/readme.txt"), "no image");
    expect_series("m", NULL, 5, 0,
                  "2 series in the folder, with slices: \"7: A series\" (6), \"8: A series\" (3); the largest is read\n"
                  "1 slices of another size or orientation are left out (localizers?)\n1 files of the folder are no DICOM images\n");
    const char *left_out = "1 files of the folder are no DICOM images\n";
    expect_series("m", "8", 3, 500, left_out);
    expect_series("m", "1.6", 3, 500, left_out);
    expect_series("m", "8: A series", 3, 500, left_out);
    struct pel_volume v;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_error error = PEL_ERROR_INIT;
    params.array = "9";
    pel_volume_init(&v);
    assert_false(pel_read_volume(scratch("m"), &params, &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "\"8: A series\" (3)"));
    /* a damaged slice is told, not passed over */
    size_t size;
    unsigned char *bytes = read_file(scratch("m/localizer"), &size);
    write_file(scratch("m/localizer"), bytes, size - 3);
    free(bytes);
    expect_bad(scratch("m"), "localizer: the file ends");
}

/* An item of a sequence around one element. */
static void put_item(struct file *f, uint32_t sequence, uint32_t tag, const char *text)
{
    put_tag(f, sequence, "SQ", 0xffffffff);
    put_tag(f, 0xfffee000, NULL, 0xffffffff);
    put_text(f, tag, "DS", text);
    put_tag(f, 0xfffee00d, NULL, 0);
    put_tag(f, 0xfffee0dd, NULL, 0);
}

/* An enhanced image: all slices in a file, each frame with its own position, from the highest to the lowest. */
static void enhanced(void **state)
{
    (void)state;
    static struct file f;
    struct slice s = { .frames = "4" };
    begin(&f, &s);
    put_tag(&f, 0x52009229, "SQ", 0xffffffff);
    put_tag(&f, 0xfffee000, NULL, 0xffffffff);
    put_item(&f, 0x00209116, 0x00200037, "1\\0\\0\\0\\1\\0");
    put_item(&f, 0x00289110, 0x00280030, "2\\3");
    put_item(&f, 0x00289145, 0x00281053, "2");
    put_tag(&f, 0xfffee00d, NULL, 0);
    put_tag(&f, 0xfffee0dd, NULL, 0);
    put_tag(&f, 0x52009230, "SQ", 0xffffffff);
    for (int z = 0; z < 4; z++) {
        char position[32];
        snprintf(position, sizeof position, "5\\6\\%d", 40 - 10 * z);
        put_tag(&f, 0xfffee000, NULL, 0xffffffff);
        put_item(&f, 0x00209113, 0x00200032, position);
        put_tag(&f, 0xfffee00d, NULL, 0);
    }
    put_tag(&f, 0xfffee0dd, NULL, 0);
    put_pixels(&f, &s, 0, 24);
    write_file(scratch("e.dcm"), f.bytes, f.size);
    expect_description(scratch("e.dcm"), "dicom 3x2x4 f32 x1\nspacing 3 2 10\norigin 5 6 10\n" PLAIN_AXES
                                         "space LPS units 'mm'\nmin 0 max 46 mean 23.000000 nonzero 23 voids 0\n"
                                         "note: stored numbers 0 to 23 are scaled by the file's slope 2 and intercept 0\n");
    struct pel_volume v;
    read_ok(scratch("e.dcm"), &v, NULL);
    assert_true(pel_volume_get(&v, 0, 0, 0, 0) == 36 && pel_volume_get(&v, 0, 0, 3, 0) == 0);
    pel_volume_finish(&v);
    expect_truncations_fail(scratch("e.dcm"), scratch("cut.dcm"), f.size);
}

#include "dicom_streams.h"

/* A file with `count` fragments of compressed pixels, which are also its frames. */
static void write_compressed(const char *path, const char *syntax, int bits, int stored, const unsigned char *stream, size_t size,
                             int count, const char *photometric)
{
    static struct file f;
    char frames[16];
    snprintf(frames, sizeof frames, "%d", count);
    struct slice s = { .syntax = syntax,
                       .bits = bits,
                       .stored = stored,
                       .rows = 6,
                       .columns = 8,
                       .frames = frames,
                       STANDARD,
                       .photometric = photometric,
                       .samples = photometric ? 3 : 1 };
    begin(&f, &s);
    put_tag(&f, 0x7fe00010, "OB", 0xffffffff);
    put_tag(&f, 0xfffee000, NULL, 0);
    for (int i = 0; i < count; i++) {
        put_tag(&f, 0xfffee000, NULL, (uint32_t)(size + size % 2));
        put(&f, stream, size);
        put(&f, "", size % 2);
    }
    put_tag(&f, 0xfffee0dd, NULL, 0);
    write_file(path, f.bytes, f.size);
}

static void compressed(void **state)
{
    (void)state;
    static const struct {
        const char *syntax;
        const unsigned char *bytes;
        size_t size;
        int bits, stored, modulo, tolerance;
    } streams[] = {
        { "1.2.840.10008.1.2.4.50", baseline, sizeof baseline, 8, 8, 256, 2 },
        { "1.2.840.10008.1.2.4.51", extended12, sizeof extended12, 16, 12, 4096, 2 },
        { "1.2.840.10008.1.2.4.57", lossless8, sizeof lossless8, 8, 8, 256, 0 },
        { "1.2.840.10008.1.2.4.70", lossless12, sizeof lossless12, 16, 12, 4096, 0 },
        { "1.2.840.10008.1.2.4.70", lossless16, sizeof lossless16, 16, 16, 4096, 0 },
        { "1.2.840.10008.1.2.4.80", jpegls, sizeof jpegls, 16, 12, 4096, 0 },
        { "1.2.840.10008.1.2.4.90", jpeg2000, sizeof jpeg2000, 16, 12, 65536, 0 }, /* signed there: see below */
    };
    for (size_t i = 0; i < sizeof streams / sizeof *streams; i++) {
        struct pel_volume v;
        write_compressed(scratch("j.dcm"), streams[i].syntax, streams[i].bits, streams[i].stored, streams[i].bytes, streams[i].size, 2,
                         NULL);
        read_ok(scratch("j.dcm"), &v, NULL);
        for (int z = 0; z < 2; z++)
            for (int y = 0; y < 6; y++)
                for (int x = 0; x < 8; x++) {
                    int value = (x * x * 37 + y * 101 + x * y % 5 * 11) % 4096 % streams[i].modulo;
                    if (streams[i].bytes == jpeg2000)
                        value = (value - 2048) & 4095;
                    assert_true(abs((int)pel_volume_get(&v, (size_t)x, (size_t)y, (size_t)z, 0) - value) <= streams[i].tolerance);
                }
        pel_volume_finish(&v);
        /* cut short, as an unfinished download is */
        write_compressed(scratch("bad.dcm"), streams[i].syntax, streams[i].bits, streams[i].stored, streams[i].bytes, streams[i].size / 2,
                         1, NULL);
        read_bad(scratch("bad.dcm"), NULL);
        write_compressed(scratch("bad.dcm"), streams[i].syntax, streams[i].bits, streams[i].stored, streams[i].bytes, 3, 1, NULL);
        read_bad(scratch("bad.dcm"), NULL);
        write_compressed(scratch("bad.dcm"), streams[i].syntax, 32, streams[i].stored, streams[i].bytes, streams[i].size, 1, NULL);
        read_bad(scratch("bad.dcm"), NULL);
    }
    struct pel_volume v;
    write_compressed(scratch("c.dcm"), "1.2.840.10008.1.2.4.50", 8, 8, colour, sizeof colour, 1, "YBR_FULL_422");
    read_ok(scratch("c.dcm"), &v, NULL);
    for (size_t i = 0; i < 48; i++)
        for (int c = 0; c < 3; c++)
            assert_float_equal(pel_volume_get(&v, i % 8, i / 8, 0, c), c == 0 ? 200 - 4 * (double)(i / 8) : c == 1 ? 90 : 30, 3);
    pel_volume_finish(&v);
    write_compressed(scratch("bad.dcm"), "1.2.840.10008.1.2.4.80", 8, 8, colour, sizeof colour, 1, "YBR_FULL");
    expect_bad(scratch("bad.dcm"), "YBR_FULL");
    write_compressed(scratch("bad.dcm"), "1.2.840.10008.1.2.4.102", 8, 8, baseline, sizeof baseline, 1, NULL);
    expect_bad(scratch("bad.dcm"), "1.2.840.10008.1.2.4.102");
}

static void run_lengths(void **state)
{
    (void)state;
    /* two segments, the high bytes first: a run of 40 and 8 plain ones, then 47 equal and one more */
    static const unsigned char good[] = { 2, 0, 0, 0, 64, 0, 0, 0, 75, 0, 0, 0, [64] = 217, 1, 7, 2, 2, 2, 2, 2, 2, 2, 2, 210, 5, 0, 6 };
    struct pel_volume v;
    unsigned char bad[sizeof good];
    write_compressed(scratch("r.dcm"), RLE, 16, 16, good, sizeof good, 1, NULL);
    read_ok(scratch("r.dcm"), &v, NULL);
    for (size_t i = 0; i < 48; i++)
        assert_true(pel_volume_get(&v, i % 8, i / 8, 0, 0) == (i < 40 ? 256 : 512) + (i < 47 ? 5 : 6));
    pel_volume_finish(&v);
    for (size_t i = 0; i < 68; i++) { /* any byte of the segments' table or of a run's length that is wrong */
        if (i >= 12 && i != 64)
            continue;
        memcpy(bad, good, sizeof bad);
        bad[i] ^= 0x55;
        write_compressed(scratch("bad.dcm"), RLE, 16, 16, bad, sizeof bad, 1, NULL);
        read_bad(scratch("bad.dcm"), NULL);
    }
}

static void expect_slice_bad(const struct slice *s, const char *part)
{
    write_slice(scratch("bad.dcm"), s, 0);
    expect_bad(scratch("bad.dcm"), part);
}

static void bad_files(void **state)
{
    (void)state;
    static struct file f;
    struct slice s = { STANDARD, .position = "0\\0\\0" };
    size_t size;
    write_slice(scratch("t.dcm"), &s, 0);
    free(read_file(scratch("t.dcm"), &size));
    expect_truncations_fail(scratch("t.dcm"), scratch("cut.dcm"), size);
    expect_slice_bad(&(struct slice) { .frames = "4000000000" }, "too soon");
    expect_slice_bad(&(struct slice) { .bits = 12 }, "12 bits");
    expect_slice_bad(&(struct slice) { .stored = 17 }, "do not fit");
    expect_slice_bad(&(struct slice) { .samples = 4 }, "4 numbers");
    expect_slice_bad(&(struct slice) { .orientation = "1\\0\\0\\1\\0\\0", .spacing = "1\\1" }, "right angles");
    begin(&f, &(struct slice) { .rows = 65535, .columns = 65535, .frames = "60000" });
    put_tag(&f, 0x7fe00010, "OW", 0xfffffff0);
    put(&f, "123456", 6);
    write_file(scratch("bad.dcm"), f.bytes, f.size);
    expect_bad(scratch("bad.dcm"), "the file ends");
    begin(&f, &s);
    write_file(scratch("bad.dcm"), f.bytes, f.size);
    expect_bad(scratch("bad.dcm"), "has no pixels");
    begin(&f, &s);
    for (int i = 0; i < 200; i++) { /* sequences in sequences */
        put_tag(&f, 0x00400555, "SQ", 0xffffffff);
        put_tag(&f, 0xfffee000, NULL, 0xffffffff);
    }
    write_file(scratch("bad.dcm"), f.bytes, f.size);
    expect_bad(scratch("bad.dcm"), "nested");
    begin(&f, &(struct slice) { .syntax = "1.2.840.10008.1.2.1.99" });
    write_file(scratch("bad.dcm"), f.bytes, f.size);
    expect_bad(scratch("bad.dcm"), "deflated");
    folder("none");
    write_text(scratch("none/a.txt"), "text");
    expect_bad(scratch("none"), "folder with no DICOM");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_of_a_real_series),
        cmocka_unit_test(header_encodings),
        cmocka_unit_test(numbers),
        cmocka_unit_test(colours),
        cmocka_unit_test(series_in_order),
        cmocka_unit_test(series_with_faults),
        cmocka_unit_test(mixed_folders),
        cmocka_unit_test(enhanced),
        cmocka_unit_test(compressed),
        cmocka_unit_test(run_lengths),
        cmocka_unit_test(bad_files),
    };
    return cmocka_run_group_tests_name("dicom", tests, make_scratch, remove_scratch);
}
