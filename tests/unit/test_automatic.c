/* SPDX-License-Identifier: MIT */
/* Automatic transfer functions and isovalues: on made-up objects the background must be clear and the object seen; on odd volumes they must
 * be valid; on real files the isovalue must lie where people put it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include <pellucid/io.h>
#include <pellucid/transfer.h>

enum { N = 48 };

static void put(struct pel_volume *v, size_t i, double value)
{
    switch (v->type) {
    case PEL_U8:
        ((uint8_t *)v->data)[i] = (uint8_t)value;
        break;
    case PEL_I16:
        ((int16_t *)v->data)[i] = (int16_t)value;
        break;
    case PEL_F32:
        ((float *)v->data)[i] = (float)value;
        break;
    default:
        ((double *)v->data)[i] = value;
        break;
    }
}

/* value(x, y, z) with coordinates in -1..1 and noise in -1..1. */
static struct pel_volume make(enum pel_type type, double (*value)(const double p[3], double noise))
{
    struct pel_volume v;
    uint32_t seed = 1;
    pel_volume_init(&v);
    v.spacing[0] = v.spacing[1] = v.spacing[2] = 2;
    assert_true(pel_volume_allocate(&v, (size_t[3]) { N, N, N }, type, 1, NULL));
    for (size_t i = 0; i < (size_t)N * N * N; i++) {
        size_t at[3] = { i % N, i / N % N, i / N / N };
        double p[3];
        for (int a = 0; a < 3; a++)
            p[a] = 2 * ((double)at[a] + 0.5) / N - 1;
        seed = seed * 1664525u + 1013904223u;
        put(&v, i, value(p, seed / 2147483648.0 - 1));
    }
    pel_volume_update_range(&v);
    return v;
}

static double radius(const double p[3])
{
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
}

/* Soft edge at r = at, one voxel wide or so. */
static double inside(const double p[3], double at)
{
    double x = (at - radius(p)) * N / 4 + 0.5;
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

static double ball_in_noise(const double p[3], double noise)
{
    return 20 + 100 * inside(p, 0.6) + 80 * inside(p, 0.3) + 6 * noise;
}

static double dense_ball_small(const double p[3], double noise)
{
    return -1000 + 1040 * inside(p, 0.7) + 900 * inside(p, 0.12) + 15 * noise;
}

static double bump(const double p[3], double noise)
{
    (void)noise;
    return exp(-8 * radius(p) * radius(p));
}

static double two_lobes(const double p[3], double noise)
{
    (void)noise;
    double a[3] = { p[0] - 0.45, p[1], p[2] }, b[3] = { p[0] + 0.45, p[1], p[2] };
    return bump(a, 0) - bump(b, 0);
}

static double mask(const double p[3], double noise)
{
    (void)noise;
    return radius(p) < 0.5;
}

static double everywhere(const double p[3], double noise)
{
    return 30 + 20 * p[0] + 5 * noise + 10 * sin(4 * p[1]);
}

static double constant(const double p[3], double noise)
{
    (void)p, (void)noise;
    return 7;
}

static double nothing(const double p[3], double noise)
{
    (void)p, (void)noise;
    return NAN;
}

static double huge(const double p[3], double noise)
{
    return 1e300 * ball_in_noise(p, noise);
}

static double tiny(const double p[3], double noise)
{
    return 1e6 + 1e-9 * ball_in_noise(p, noise);
}

static double with_outlier(const double p[3], double noise)
{
    return p[0] > 0.97 && p[1] > 0.97 && p[2] > 0.97 ? 1e30 : ball_in_noise(p, noise);
}

static double with_fill_value(const double p[3], double noise)
{
    return radius(p) > 0.95 ? -99999 : ball_in_noise(p, noise);
}

static void check_valid(const struct pel_transfer *t)
{
    assert_true(t->unit_distance > 0 && isfinite(t->unit_distance));
    assert_true(t->color_count >= 1 && t->opacity_count >= 1);
    for (size_t i = 0; i < t->color_count; i++)
        assert_true(isfinite(t->colors[i].value) && (i == 0 || t->colors[i].value >= t->colors[i - 1].value));
    for (size_t i = 0; i < t->opacity_count; i++)
        assert_true(isfinite(t->opacities[i].value) && t->opacities[i].opacity >= 0 && t->opacities[i].opacity <= 1 &&
                    (i == 0 || t->opacities[i].value >= t->opacities[i - 1].value));
}

struct seen {
    struct pel_transfer transfer;
    double isovalue, least; /* least: of the volume's values */
};

static struct seen automatic(enum pel_type type, double (*value)(const double p[3], double noise), enum pel_transfer_purpose purpose)
{
    struct seen seen;
    struct pel_volume v = make(type, value);
    assert_true(pel_transfer_init(&seen.transfer, NULL));
    assert_true(pel_transfer_automatic(&seen.transfer, &v, purpose, NULL));
    check_valid(&seen.transfer);
    assert_true(seen.transfer.unit_distance == 2);
    seen.isovalue = pel_isovalue_automatic(&v);
    seen.least = v.range[0];
    pel_volume_finish(&v);
    return seen;
}

static double opacity(const struct seen *seen, double value)
{
    return pel_transfer_opacity(&seen->transfer, value);
}

static void noise_is_clear_and_the_dense_core_is_dense(void **state)
{
    (void)state;
    struct seen s = automatic(PEL_U8, ball_in_noise, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 20) == 0 && opacity(&s, 26) < 0.01);
    assert_true(opacity(&s, 80) > 0.005);
    assert_true(opacity(&s, 200) > 3 * opacity(&s, 120) && opacity(&s, 200) > 0.05);
    assert_true(s.isovalue > 30 && s.isovalue < 115);
    double a[3], b[3];
    pel_transfer_color(&s.transfer, 120, a);
    pel_transfer_color(&s.transfer, 200, b);
    assert_true(fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2]) > 0.2);
    pel_transfer_finish(&s.transfer);
}

static void negative_values(void **state)
{
    (void)state;
    struct seen s = automatic(PEL_I16, dense_ball_small, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, -1000) == 0 && opacity(&s, -980) < 0.01);
    assert_true(opacity(&s, 940) > 0.05 && opacity(&s, 940) > opacity(&s, 40));
    assert_true(s.isovalue > -900 && s.isovalue < 0);
    pel_transfer_finish(&s.transfer);
}

static void smooth_fields_and_masks(void **state)
{
    (void)state;
    struct seen s = automatic(PEL_F32, bump, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 0) == 0 && opacity(&s, 1) > 0.1);
    assert_true(s.transfer.colors[0].value >= s.least && strcmp(s.transfer.colormap, "plasma") == 0);
    assert_true(s.isovalue > 0.03 && s.isovalue < 0.6);
    pel_transfer_finish(&s.transfer);

    s = automatic(PEL_F32, two_lobes, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 0) == 0 && opacity(&s, 0.9) > 0.1 && opacity(&s, -0.9) > 0.1);
    pel_transfer_finish(&s.transfer);

    s = automatic(PEL_U8, mask, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 0) == 0 && opacity(&s, 1) > 0.01);
    assert_true(fabs(s.isovalue - 0.5) < 1e-9);
    pel_transfer_finish(&s.transfer);

    s = automatic(PEL_F64, everywhere, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 0) == 0 && opacity(&s, 60) > 0.05);
    assert_true(s.isovalue > 30 && s.isovalue < 65);
    pel_transfer_finish(&s.transfer);
}

static void odd_volumes_give_valid_functions(void **state)
{
    (void)state;
    static double (*const odd[])(const double p[3], double noise) = { constant, nothing, huge, tiny, with_outlier, with_fill_value };
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
        for (int purpose = PEL_TRANSFER_COMPOSITE; purpose <= PEL_TRANSFER_AVERAGE; purpose++) {
            struct seen s = automatic(PEL_F64, odd[i], (enum pel_transfer_purpose)purpose);
            assert_true(isfinite(s.isovalue));
            pel_transfer_finish(&s.transfer);
        }
}

static void outliers_do_not_hide_the_object(void **state)
{
    (void)state;
    static double (*const odd[])(const double p[3], double noise) = { with_outlier, with_fill_value };
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        struct seen s = automatic(PEL_F64, odd[i], PEL_TRANSFER_COMPOSITE);
        assert_true(opacity(&s, 20) < 0.01 && opacity(&s, -99999) == 0);
        assert_true(opacity(&s, 200) > 0.05);
        assert_true(s.isovalue > 25 && s.isovalue < 150);
        pel_transfer_finish(&s.transfer);
    }
    struct seen s = automatic(PEL_F64, tiny, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 1e6 + 20e-9) < 0.01 && opacity(&s, 1e6 + 200e-9) > 0.05);
    pel_transfer_finish(&s.transfer);
    s = automatic(PEL_F64, huge, PEL_TRANSFER_COMPOSITE);
    assert_true(opacity(&s, 20e300) < 0.01 && opacity(&s, 200e300) > 0.05);
    pel_transfer_finish(&s.transfer);
}

static void other_purposes(void **state)
{
    (void)state;
    struct seen s = automatic(PEL_U8, ball_in_noise, PEL_TRANSFER_OPAQUE);
    assert_true(opacity(&s, 0) == 1 && opacity(&s, 255) == 1);
    pel_transfer_finish(&s.transfer);
    s = automatic(PEL_U8, ball_in_noise, PEL_TRANSFER_PROJECTION);
    assert_true(opacity(&s, 14) < 0.05 && opacity(&s, 200) == 1);
    pel_transfer_finish(&s.transfer);
    s = automatic(PEL_U8, ball_in_noise, PEL_TRANSFER_AVERAGE);
    double mean = 20 + 100 * 0.6 + 80 * 0.3, gray[3]; /* of a ray through the middle */
    pel_transfer_color(&s.transfer, mean, gray);
    assert_true(opacity(&s, mean) == 1 && gray[0] > 0.5);
    assert_true(opacity(&s, 14) < 0.05);
    pel_transfer_finish(&s.transfer);
    /* A ray through the ball's middle: neither black nor white. */
    s = automatic(PEL_U8, ball_in_noise, PEL_TRANSFER_XRAY);
    double outer = -log(1 - opacity(&s, 120)) * N * 0.3, core = -log(1 - opacity(&s, 200)) * N * 0.3, alpha = 1 - exp(-outer - core);
    assert_true(alpha > 0.5 && alpha < 0.97);
    /* Proportional to the value above the background. */
    double unit = log(1 - opacity(&s, 70)) / (70 - 20), twice = log(1 - opacity(&s, 120)) / (120 - 20);
    assert_true(fabs(unit / twice - 1) < 0.1);
    pel_transfer_finish(&s.transfer);
}

static void labels_get_a_color_each(void **state)
{
    (void)state;
    struct pel_volume v = make(PEL_U8, mask);
    for (size_t i = 0; i < (size_t)N * N * N; i++) /* three labels and the background */
        if (((uint8_t *)v.data)[i])
            ((uint8_t *)v.data)[i] = (uint8_t)(3 + i / 16 % 3 * 7);
    pel_volume_update_range(&v);
    v.labels = true;
    struct pel_transfer t;
    assert_true(pel_transfer_init(&t, NULL));
    assert_true(pel_transfer_automatic(&t, &v, PEL_TRANSFER_COMPOSITE, NULL));
    check_valid(&t);
    assert_true(pel_transfer_opacity(&t, 0) == 0);
    double rgb[3][3];
    for (int i = 0; i < 3; i++) {
        assert_true(pel_transfer_opacity(&t, 3 + 7 * i) >= 0.05);
        pel_transfer_color(&t, 3 + 7 * i, rgb[i]);
        for (int j = 0; j < i; j++)
            assert_true(fabs(rgb[i][0] - rgb[j][0]) + fabs(rgb[i][1] - rgb[j][1]) + fabs(rgb[i][2] - rgb[j][2]) > 0.3);
    }
    assert_true(pel_transfer_automatic(&t, &v, PEL_TRANSFER_OPAQUE, NULL));
    assert_true(pel_transfer_opacity(&t, 0) == 1);
    pel_transfer_finish(&t);
    pel_volume_finish(&v);
}

static void real_files(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double clear, seen, iso_lo, iso_hi; /* clear: a value of the background; seen: one of the object */
    } files[] = {
        { "aneurism.nrrd", 2, 200, 20, 120 },   { "bonsai.nii.gz", 0, 200, 8, 60 },       { "engine.nhdr", 5, 230, 25, 110 },
        { "neghip.nrrd", 0, 200, 20, 150 },     { "tooth.nhdr", 390, 1150, 450, 750 },    { "vishuman_head.nrrd", 4, 180, 12, 70 },
        { "cthead", 5, 180, 25, 75 },           { "template_T2.nrrd", 36, 560, 60, 300 }, { "inia19-t1-brain.nii.gz", 0, 105, 10, 60 },
        { "HeadMRVolume.mhd", 2, 100, 10, 45 }, { "ironProt.vtk", 0, 200, 20, 150 },      { "hydrogen.vti", 0, 0.5, 0.02, 0.3 },
        { "isabel_speed.vti", 1, 40, 15, 50 },  { "carotid.vtk", 10, 300, 140, 250 },
    };
    const char *folder = getenv("PELLUCID_TEST_DATA");
    struct stat info;
    if (!folder || stat(folder, &info) != 0) {
        print_message("SKIPPED: no real data at PELLUCID_TEST_DATA=%s\n", folder ? folder : "(not set)");
        skip();
    }
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[4096];
        struct pel_volume v;
        struct pel_transfer t;
        struct pel_error error = PEL_ERROR_INIT;
        snprintf(path, sizeof path, "%s/%s", folder, files[i].name);
        pel_volume_init(&v);
        if (!pel_read_volume(path, NULL, &v, NULL, &error))
            fail_msg("%s", error.message);
        if (v.components > 1) {
            struct pel_volume magnitude;
            pel_volume_init(&magnitude);
            assert_true(pel_volume_magnitude(&v, &magnitude, NULL));
            pel_volume_finish(&v);
            v = magnitude;
        }
        assert_true(pel_transfer_init(&t, NULL));
        assert_true(pel_transfer_automatic(&t, &v, PEL_TRANSFER_COMPOSITE, NULL));
        check_valid(&t);
        double clear = pel_transfer_opacity(&t, files[i].clear), seen = pel_transfer_opacity(&t, files[i].seen),
               iso = pel_isovalue_automatic(&v);
        if (!(clear < 0.002) || !(seen > 0.02))
            fail_msg("%s: opacity %g at %g, %g at %g", files[i].name, clear, files[i].clear, seen, files[i].seen);
        if (!(iso >= files[i].iso_lo && iso <= files[i].iso_hi))
            fail_msg("%s: isovalue %g", files[i].name, iso);
        pel_transfer_finish(&t);
        pel_volume_finish(&v);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_clear_and_the_dense_core_is_dense),
        cmocka_unit_test(negative_values),
        cmocka_unit_test(smooth_fields_and_masks),
        cmocka_unit_test(odd_volumes_give_valid_functions),
        cmocka_unit_test(outliers_do_not_hide_the_object),
        cmocka_unit_test(other_purposes),
        cmocka_unit_test(labels_get_a_color_each),
        cmocka_unit_test(real_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
