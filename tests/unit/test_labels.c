/* SPDX-License-Identifier: MIT */
/* Labels told from signals: made-up segmentations and signals with few values, which are the hard cases, then the real files. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include <pellucid/io.h>
#include <pellucid/volume.h>

enum { N = 64 };

static uint32_t next(uint32_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return *seed;
}

/* Calls value(x, y, z) in -1..1 for each sample and stores its result. */
static struct pel_volume make(enum pel_type type, int (*value)(double, double, double, uint32_t *))
{
    struct pel_volume v;
    uint32_t seed = 99;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ N, N + 3, N - 5 }, type, 1, NULL));
    size_t i = 0;
    for (size_t z = 0; z < v.dims[2]; z++)
        for (size_t y = 0; y < v.dims[1]; y++)
            for (size_t x = 0; x < v.dims[0]; x++, i++) {
                int n = value(2.0 * (double)x / N - 1, 2.0 * (double)y / N - 1, 2.0 * (double)z / N - 1, &seed);
                if (type == PEL_U8)
                    ((uint8_t *)v.data)[i] = (uint8_t)n;
                else if (type == PEL_U16)
                    ((uint16_t *)v.data)[i] = (uint16_t)n;
                else if (type == PEL_I32)
                    ((int32_t *)v.data)[i] = n;
                else
                    ((float *)v.data)[i] = (float)n;
            }
    return v;
}

static bool detect(enum pel_type type, int (*value)(double, double, double, uint32_t *))
{
    struct pel_volume v = make(type, value);
    bool labels = pel_volume_detect_labels(&v);
    assert_true(labels == v.labels);
    pel_volume_finish(&v);
    return labels;
}

/* ---- segmentations ---- */

/* Organs: twelve balls of different labels in an empty background, as an atlas has them. */
static int organs(double x, double y, double z, uint32_t *seed)
{
    (void)seed;
    for (int i = 0; i < 12; i++) {
        double dx = x - 0.6 * cos(i * 2.1), dy = y - 0.6 * sin(i * 1.3), dz = z - 0.6 * cos(i * 3.7 + 1);
        if (dx * dx + dy * dy + dz * dz < 0.07)
            return i * 2 + 3;
    }
    return 0;
}

/* A parcellation without background: nearest of 20 seeds, labels far apart. */
static int parcels(double x, double y, double z, uint32_t *seed)
{
    (void)seed;
    int best = 0;
    double least = 1e9;
    for (int i = 0; i < 20; i++) {
        double dx = x - cos(i * 2.1), dy = y - sin(i * 1.3), dz = z - cos(i * 3.7 + 1), d = dx * dx + dy * dy + dz * dz;
        if (d < least)
            least = d, best = i;
    }
    return best * 97 % 20 * 1000 + 5;
}

/* ---- signals ---- */

static int mask(double x, double y, double z, uint32_t *seed)
{
    (void)seed;
    return x * x + y * y + z * z < 0.5 ? 255 : 0;
}

static int smooth_few(double x, double y, double z, uint32_t *seed)
{
    (void)seed;
    return (int)(8 + 7.9 * sin(4 * x) * cos(3 * y) * sin(5 * z + 1));
}

static int noise(double x, double y, double z, uint32_t *seed)
{
    (void)x, (void)y, (void)z;
    return (int)(next(seed) % 16);
}

/* How much of a voxel at the distance r lies in a ball. */
static double ball(double r, double radius)
{
    return fmin(1, fmax(0, (radius - r) * N / 4 + 0.5));
}

/* CT of few gray levels: two tissues with noise and an edge of one partial voxel. */
static int noisy_ct(double x, double y, double z, uint32_t *seed)
{
    double r = sqrt(x * x + y * y + z * z), inside = ball(r, 0.8), bone = ball(r, 0.4);
    return (int)(4 + 16 * inside + 30 * bone + next(seed) % 4);
}

/* The same without noise: flat inside, as a denoised or masked scan. */
static int clean_ct(double x, double y, double z, uint32_t *seed)
{
    (void)seed;
    double r = sqrt(x * x + y * y + z * z), inside = ball(r, 0.8), bone = ball(r, 0.4);
    return (int)(20 * inside + 30 * bone);
}

static int many(double x, double y, double z, uint32_t *seed)
{
    return (int)(128 + 100 * sin(4 * x) * cos(3 * y) * sin(5 * z)) + (int)(next(seed) % 8);
}

static int constant(double x, double y, double z, uint32_t *seed)
{
    (void)x, (void)y, (void)z, (void)seed;
    return 7;
}

static void test_segmentations(void **state)
{
    (void)state;
    assert_true(detect(PEL_U8, organs));
    assert_true(detect(PEL_U16, organs));
    assert_true(detect(PEL_U16, parcels));
    assert_true(detect(PEL_I32, parcels));
}

static void test_signals(void **state)
{
    (void)state;
    assert_false(detect(PEL_U8, mask));
    assert_false(detect(PEL_U8, smooth_few));
    assert_false(detect(PEL_U8, noise));
    assert_false(detect(PEL_U8, noisy_ct));
    assert_false(detect(PEL_U8, clean_ct));
    assert_false(detect(PEL_U8, many));
    assert_false(detect(PEL_U8, constant));
    assert_false(detect(PEL_F32, organs)); /* floating point is a signal always */
}

/* ---- real files ---- */

static void check_file(const char *folder, const char *name, bool expected)
{
    char path[1024];
    struct pel_volume v;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    pel_volume_init(&v);
    if (!pel_read_volume(path, &params, &v, NULL, &error))
        fail_msg("%s", error.message);
    if (pel_volume_detect_labels(&v) != expected)
        fail_msg("%s is taken for %s", name, expected ? "a signal" : "labels");
    /* Coarser gray levels of a signal are a signal still. */
    for (int shift = 2; !expected && v.type == PEL_U8 && shift <= 5; shift++) {
        for (size_t i = 0; i < pel_volume_samples(&v); i++)
            ((uint8_t *)v.data)[i] = (uint8_t)(((uint8_t *)v.data)[i] >> (shift == 2 ? 2 : 1));
        if (pel_volume_detect_labels(&v))
            fail_msg("%s with %d bits less is taken for labels", name, shift);
    }
    pel_volume_finish(&v);
}

static void test_real_files(void **state)
{
    (void)state;
    const char *folder = getenv("PELLUCID_TEST_DATA");
    struct stat info;
    if (!folder || stat(folder, &info) != 0) {
        print_message("PELLUCID_TEST_DATA names no folder: SKIPPED\n");
        skip();
    }
    check_file(folder, "frogtissue.mhd", true);
    static const char *const signals[] = { "aneurism.nrrd", "bonsai.nii.gz", "engine.nhdr", "cthead", "tooth.nhdr",
                                           "neghip.nrrd", "HeadMRVolume.mhd", "ironProt.vtk" };
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        check_file(folder, signals[i], false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_segmentations),
        cmocka_unit_test(test_signals),
        cmocka_unit_test(test_real_files),
    };
    return cmocka_run_group_tests_name("labels", tests, NULL, NULL);
}
