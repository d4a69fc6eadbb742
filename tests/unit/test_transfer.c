/* SPDX-License-Identifier: MIT */
/* Transfer functions: curves, jumps, edits that are refused, text. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/transfer.h>

static int make(void **state)
{
    static struct pel_transfer transfer;
    *state = &transfer;
    return pel_transfer_init(&transfer, NULL) ? 0 : -1;
}

static int drop(void **state)
{
    pel_transfer_finish(*state);
    return 0;
}

static void expect_close(double a, double b)
{
    if (!(fabs(a - b) <= 1e-12 * (1 + fabs(b))))
        fail_msg("%.17g is not %.17g", a, b);
}

static void starts_as_a_gray_ramp(void **state)
{
    struct pel_transfer *t = *state;
    double rgb[3];
    expect_close(pel_transfer_opacity(t, 0.25), 0.25);
    pel_transfer_color(t, 0.75, rgb);
    expect_close(rgb[1], 0.75);
    expect_close(t->unit_distance, 1);
    assert_string_equal(t->colormap, "gray");
}

static void curves_keep_their_ends_and_jump(void **state)
{
    struct pel_transfer *t = *state;
    const struct pel_opacity_point points[] = { { 10, 0.5 }, { 0, 0.1 }, { 10, 0.9 }, { 20, 0.2 } }; /* not sorted */
    assert_true(pel_transfer_set_opacities(t, points, 4, NULL));
    expect_close(pel_transfer_opacity(t, -1e9), 0.1);
    expect_close(pel_transfer_opacity(t, 5), 0.3);
    expect_close(pel_transfer_opacity(t, nextafter(10, 0)), 0.5);
    expect_close(pel_transfer_opacity(t, 10), 0.9);
    expect_close(pel_transfer_opacity(t, 15), 0.55);
    expect_close(pel_transfer_opacity(t, INFINITY), 0.2);
    expect_close(pel_transfer_opacity(t, NAN), 0);

    const struct pel_color_point colors[] = { { 1, { 1, 0, 0 } }, { 1, { 0, 1, 0 } }, { 1, { 0, 0, 1 } } };
    double rgb[3];
    assert_true(pel_transfer_set_colors(t, colors, 3, NULL));
    pel_transfer_color(t, 0.999, rgb);
    expect_close(rgb[0], 1);
    pel_transfer_color(t, 1, rgb);
    expect_close(rgb[2], 1);
    pel_transfer_color(t, NAN, rgb);
    expect_close(rgb[0] + rgb[1] + rgb[2], 0);
}

static void widest_values_do_not_overflow(void **state)
{
    struct pel_transfer *t = *state;
    const struct pel_opacity_point points[] = { { -DBL_MAX, 0 }, { DBL_MAX, 1 } };
    assert_true(pel_transfer_set_opacities(t, points, 2, NULL));
    expect_close(pel_transfer_opacity(t, 0), 0.5);
    expect_close(pel_transfer_opacity(t, DBL_MAX / 2), 0.75);
}

static void refused_edits_change_nothing(void **state)
{
    struct pel_transfer *t = *state, before;
    struct pel_error error = PEL_ERROR_INIT;
    assert_true(pel_transfer_init(&before, NULL));
    const struct pel_opacity_point bad_opacities[][2] = {
        { { 0, 0 }, { NAN, 1 } },  { { 0, 0 }, { INFINITY, 1 } }, { { 0, 0 }, { 1, 1.01 } },
        { { 0, -0.1 }, { 1, 1 } }, { { 0, NAN }, { 1, 1 } },
    };
    for (size_t i = 0; i < sizeof bad_opacities / sizeof *bad_opacities; i++) {
        error.code = PEL_ERROR_NONE;
        assert_false(pel_transfer_set_opacities(t, bad_opacities[i], 2, &error));
        assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    }
    const struct pel_color_point bad_colors[] = { { NAN, { 0, 0, 0 } }, { 0, { 0, 2, 0 } }, { 0, { 0, 0, NAN } } };
    for (size_t i = 0; i < sizeof bad_colors / sizeof *bad_colors; i++)
        assert_false(pel_transfer_set_colors(t, &bad_colors[i], 1, &error));
    assert_false(pel_transfer_set_colors(t, bad_colors, 0, &error));
    assert_false(pel_transfer_set_opacities(t, NULL, 0, &error));
    assert_false(pel_transfer_set_colormap(t, "viridis", 0, NAN, &error));
    assert_true(pel_transfer_equal(t, &before));
    pel_transfer_finish(&before);
}

static void unknown_color_map_names_the_nearest(void **state)
{
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_transfer_set_colormap(*state, "virids", 0, 1, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "virids"));
    assert_non_null(strstr(error.message, "viridis"));
}

static void opacity_from_text(void **state)
{
    struct pel_transfer *t = *state;
    assert_true(pel_transfer_parse_opacity(t, "40:0,80:0.2,255:0.9", NULL));
    assert_int_equal(t->opacity_count, 3);
    expect_close(pel_transfer_opacity(t, 60), 0.1);
    assert_true(pel_transfer_parse_opacity(t, " -1e3 : 0 , 1e3 : 1 ", NULL));
    expect_close(pel_transfer_opacity(t, 0), 0.5);
    assert_true(pel_transfer_parse_opacity(t, "0.3", NULL));
    expect_close(pel_transfer_opacity(t, -77), 0.3);
    expect_close(pel_transfer_opacity(t, 1e300), 0.3);
}

static void bad_opacity_text(void **state)
{
    static const char *const bad[] = {
        "",          "x",         ":",    "40",  "40:",   ":0.5",  "40:0,", ",40:0",  "40:0,,50:1",
        "40:0;50:1", "40:0 50:1", "40:2", "nan", "nan:0", "0:nan", "inf:1", "1:0.5x", "-0.1",
    };
    struct pel_transfer *t = *state;
    assert_true(pel_transfer_parse_opacity(t, "1:0.25", NULL));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct pel_error error = PEL_ERROR_INIT;
        if (pel_transfer_parse_opacity(t, bad[i], &error))
            fail_msg("'%s' was accepted", bad[i]);
        assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
        assert_true(error.message[0] && !strchr(error.message, '\n'));
        expect_close(pel_transfer_opacity(t, 0), 0.25);
    }
}

static void copies_are_equal_and_apart(void **state)
{
    struct pel_transfer *t = *state, copy;
    assert_true(pel_transfer_init(&copy, NULL));
    assert_true(pel_transfer_set_colormap(t, "turbo", -5, 5, NULL));
    t->unit_distance = 3;
    assert_false(pel_transfer_equal(t, &copy));
    assert_true(pel_transfer_copy(&copy, t, NULL));
    assert_true(pel_transfer_equal(t, &copy));
    assert_true(pel_transfer_copy(&copy, &copy, NULL));
    copy.colors[2].rgb[1] += 0.001;
    assert_false(pel_transfer_equal(t, &copy));
    assert_true(pel_transfer_copy(&copy, t, NULL));
    copy.opacities[0].value -= 1;
    assert_false(pel_transfer_equal(t, &copy));
    pel_transfer_finish(&copy);
}

static void rescaling(void **state)
{
    struct pel_transfer *t = *state;
    const struct pel_opacity_point points[] = { { 0, 0.1 }, { 1, 0.2 }, { 1, 0.8 }, { 2, 0.4 } };
    assert_true(pel_transfer_set_opacities(t, points, 4, NULL));
    pel_transfer_rescale(t, 0, 2, 100, 300);
    expect_close(pel_transfer_opacity(t, 150), 0.15);
    expect_close(pel_transfer_opacity(t, 200), 0.8);
    expect_close(pel_transfer_opacity(t, 250), 0.6);
    pel_transfer_rescale(t, 100, 300, 2, 0); /* reversed: the jump goes the other way */
    assert_true(t->opacities[0].value <= t->opacities[1].value && t->opacities[2].value <= t->opacities[3].value);
    expect_close(pel_transfer_opacity(t, 0.5), 0.6);
    expect_close(pel_transfer_opacity(t, 1), 0.2);
    expect_close(pel_transfer_opacity(t, 1.5), 0.15);
    pel_transfer_rescale(t, 1, 1, 5, 9); /* nothing to scale by: moved only */
    expect_close(pel_transfer_opacity(t, 5.5), 0.15);
    pel_transfer_rescale(t, 0, 1e-300, 0, 1e300);
    assert_true(isfinite(t->opacities[3].value) && isfinite(t->colors[t->color_count - 1].value));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make, drop)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(starts_as_a_gray_ramp),
        TEST(curves_keep_their_ends_and_jump),
        TEST(widest_values_do_not_overflow),
        TEST(refused_edits_change_nothing),
        TEST(unknown_color_map_names_the_nearest),
        TEST(opacity_from_text),
        TEST(bad_opacity_text),
        TEST(copies_are_equal_and_apart),
        TEST(rescaling),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
