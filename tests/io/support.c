/* SPDX-License-Identifier: MIT */
#include "support.h"

#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

static char folder[256];

const char *data_path(const char *name)
{
    static char path[4096];
    const char *data = getenv("PELLUCID_TEST_DATA");
    snprintf(path, sizeof path, "%s/%s", data ? data : "", name);
    if (!data || access(path, R_OK) != 0) {
        print_message("SKIPPED: %s is not there; set PELLUCID_TEST_DATA to the folder of real data\n", data ? path : "PELLUCID_TEST_DATA");
        skip();
    }
    return path;
}

int make_scratch(void **state)
{
    (void)state;
    const char *tmp = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%.200s/pellucid-test-XXXXXX", tmp ? tmp : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_one(const char *path, const struct stat *st, int kind, struct FTW *where)
{
    (void)st, (void)kind, (void)where;
    return remove(path);
}

int remove_scratch(void **state)
{
    (void)state;
    return nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

const char *scratch(const char *name)
{
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

void write_file(const char *path, const void *bytes, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

void write_text(const char *path, const char *text)
{
    write_file(path, text, strlen(text));
}

void write_gzip(const char *path, const void *bytes, size_t size)
{
    gzFile f = gzopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(gzwrite(f, bytes, (unsigned)size), size);
    assert_int_equal(gzclose(f), Z_OK);
}

unsigned char *read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *size = (size_t)ftell(f);
    rewind(f);
    unsigned char *bytes = malloc(*size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, f), *size);
    bytes[*size] = 0;
    fclose(f);
    return bytes;
}

void describe(const struct pel_volume *v, const struct pel_file_info *info, char *text, size_t size)
{
    struct pel_statistics s;
    pel_statistics_compute(v, &s);
    int n = snprintf(text, size, "%s %zux%zux%zu %s x%d%s\nspacing %.9g %.9g %.9g\norigin %.9g %.9g %.9g\n", info->format, v->dims[0],
                     v->dims[1], v->dims[2], pel_type_name(v->type), v->components, v->labels ? " labels" : "", v->spacing[0],
                     v->spacing[1], v->spacing[2], v->origin[0], v->origin[1], v->origin[2]);
    for (int a = 0; a < 3; a++)
        n += snprintf(text + n, size - (size_t)n, "axis %d: %.6g %.6g %.6g\n", a, v->direction[a][0], v->direction[a][1],
                      v->direction[a][2]);
    n += snprintf(text + n, size - (size_t)n, "space %s units '%s'\nmin %.6g max %.6g mean %.6f nonzero %llu voids %llu\n",
                  pel_space_name(v->space), v->units, s.min, s.max, s.mean, (unsigned long long)s.nonzero, (unsigned long long)s.voids);
    for (int i = 0; i < info->note_count; i++)
        n += snprintf(text + n, size - (size_t)n, "note: %s\n", info->notes[i]);
}

void read_ok(const char *path, struct pel_volume *volume, struct pel_file_info *info)
{
    struct pel_error error = PEL_ERROR_INIT;
    pel_volume_init(volume);
    if (!pel_read_volume(path, NULL, volume, info, &error))
        fail_msg("%s", error.message);
    assert_true(pel_volume_check(volume, NULL));
    assert_true(volume->range[0] <= volume->range[1]);
}

void expect_description(const char *path, const char *golden)
{
    static struct pel_file_info info;
    struct pel_volume volume;
    char text[4096];
    read_ok(path, &volume, &info);
    describe(&volume, &info, text, sizeof text);
    pel_volume_finish(&volume);
    assert_string_equal(text, golden);
}

static long peak_kilobytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

const char *read_bad(const char *path, const char *raw)
{
    static struct pel_error error;
    struct pel_volume volume;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    long before = peak_kilobytes();
    params.raw = raw;
    error = (struct pel_error)PEL_ERROR_INIT;
    pel_volume_init(&volume);
    if (pel_read_volume(path, &params, &volume, NULL, &error)) {
        pel_volume_finish(&volume);
        fail_msg("%s was read, though it is damaged", path);
    }
    assert_int_not_equal(error.code, PEL_ERROR_NONE);
    assert_null(volume.data);
    assert_null(strchr(error.message, '\n'));
    assert_int_equal(strncmp(error.message, path, strlen(path)), 0);
    assert_true(strlen(error.message) > strlen(path) + 4);
    assert_true(peak_kilobytes() - before < 32 * 1024);
    return error.message;
}

void expect_bad(const char *path, const char *part)
{
    const char *message = read_bad(path, NULL);
    if (!strstr(message, part))
        fail_msg("\"%s\" does not say \"%s\"", message, part);
}

void expect_truncations_fail(const char *path, const char *cut_path, size_t whole)
{
    size_t size;
    unsigned char *bytes = read_file(path, &size);
    assert_true(size >= whole);
    size_t step = whole > 400 ? whole / 400 : 1;
    for (size_t cut = 0; cut < whole; cut += cut < 400 || cut + 40 > whole ? 1 : step) {
        write_file(cut_path, bytes, cut);
        read_bad(cut_path, NULL);
    }
    free(bytes);
}

void fill_volume(struct pel_volume *v, enum pel_type type, int components)
{
    struct pel_error error = PEL_ERROR_INIT;
    pel_volume_init(v);
    if (!pel_volume_allocate(v, (const size_t[3]){ 5, 4, 3 }, type, components, &error))
        fail_msg("%s", error.message);
    size_t count = pel_volume_samples(v) * (size_t)components;
    uint64_t state = 0x9e3779b97f4a7c15u;
    for (size_t i = 0; i < count; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        double value = (double)(int64_t)(state >> 20) / 65536.0 - 100000;
        if (type == PEL_F32)
            ((float *)v->data)[i] = i == 7 ? NAN : (float)value;
        else if (type == PEL_F64)
            ((double *)v->data)[i] = i == 7 ? NAN : value;
        else
            memcpy((char *)v->data + i * pel_type_size(type), &state, pel_type_size(type));
    }
    double axes[3][3] = { { 0.9, 0.1, 0.2 }, { -0.3, 1.1, 0.05 }, { 0.25, 0.35, -0.8 } };
    for (int a = 0; a < 3; a++) {
        double length = sqrt(axes[a][0] * axes[a][0] + axes[a][1] * axes[a][1] + axes[a][2] * axes[a][2]);
        for (int i = 0; i < 3; i++)
            v->direction[a][i] = axes[a][i] / length;
        v->spacing[a] = 0.1 + 0.7 * a;
        v->origin[a] = 1.0 / 3 - 17.1 * a;
    }
    snprintf(v->name, sizeof v->name, "a name, with: signs");
    snprintf(v->units, sizeof v->units, "mm");
    pel_volume_update_range(v);
}

void expect_same(const struct pel_volume *a, const struct pel_volume *b)
{
    assert_memory_equal(a->dims, b->dims, sizeof a->dims);
    assert_int_equal(a->type, b->type);
    assert_int_equal(a->components, b->components);
    assert_memory_equal(a->data, b->data, pel_volume_bytes(a));
    assert_memory_equal(a->origin, b->origin, sizeof a->origin);
    assert_memory_equal(a->spacing, b->spacing, sizeof a->spacing);
    assert_memory_equal(a->direction, b->direction, sizeof a->direction);
    assert_int_equal(a->space, b->space);
    assert_string_equal(a->units, b->units);
    assert_string_equal(a->name, b->name);
    assert_memory_equal(a->range, b->range, sizeof a->range);
    assert_int_equal(a->has_void, b->has_void);
    if (a->has_void)
        assert_true(a->void_value == b->void_value);
}

void expect_round_trips(const char *name, enum pel_space space)
{
    /* Compressed ones last: a header that names compressed data does not own the plain file beside it. */
    for (int compress = 0; compress < 2; compress++)
        for (int type = 0; type < PEL_TYPE_COUNT; type++)
            for (int components = 1; components <= 4; components++) {
                struct pel_volume written, read;
                struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
                struct pel_error error = PEL_ERROR_INIT;
                params.compress = compress;
                fill_volume(&written, (enum pel_type)type, components);
                written.space = space;
                written.has_void = type == PEL_U8;
                written.void_value = 7;
                pel_volume_update_range(&written);
                if (!pel_write_volume(scratch(name), &written, &params, &error))
                    fail_msg("%s", error.message);
                read_ok(scratch(name), &read, NULL);
                expect_same(&written, &read);
                pel_volume_finish(&written);
                pel_volume_finish(&read);
            }
}
