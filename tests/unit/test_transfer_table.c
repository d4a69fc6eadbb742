/* SPDX-License-Identifier: MIT */
/* The sampled transfer function: near the exact one everywhere, and its opacity ranges never too narrow, which every skip relies on. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "transfer_table.h"

/* The entry that a kernel looks up: scaled, offset and rounded in floats. */
static size_t look_up(const struct pel_transfer_table *table, double value)
{
    double scale = (double)(table->count - 1) / (table->hi - table->lo);
    float at = (float)value * (float)scale + (float)(0.5 - table->lo * scale);
    return at > 0 ? at < (float)(table->count - 1) ? (size_t)at : table->count - 1 : 0;
}

static void build(struct pel_transfer_table *table, const char *opacity, const char *map, double map_lo, double map_hi, double lo,
                  double hi)
{
    struct pel_transfer t;
    assert_true(pel_transfer_init(&t, NULL));
    assert_true(pel_transfer_parse_opacity(&t, opacity, NULL));
    assert_true(pel_transfer_set_colormap(&t, map, map_lo, map_hi, NULL));
    assert_true(pel_transfer_table_build(table, &t, lo, hi, NULL));
    pel_transfer_finish(&t);
}

static const struct {
    const char *opacity;
    double map_lo, map_hi, lo, hi;
} cases[] = {
    { "40:0,80:0.2,255:0.9", 0, 255, 0, 255 },
    { "0:0,255:1", 0, 255, 0, 255 },
    { "0.4", 0, 255, 0, 255 },
    { "100:0,100.5:1,101:0", 0, 255, 0, 255 },
    { "-1e-3:0,1e-3:1", -1e-3, 1e-3, -1e-3, 1e-3 },
    { "-2000:0.3,3000:0.1", -1000, 4000, -1024, 3071 },
    { "0:0,1e30:1", 0, 1e30, 0, 1e30 },
    { "1000:0,1001:1", 1000, 1001, 1000, 1001 },
    { "0.2:0.1,0.25:0.9,0.3:0.1,0.9:0.5", 0, 1, 0, 1 },
};

static void is_near_the_exact_curves(void **state)
{
    (void)state;
    struct pel_transfer_table table = { 0 };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        build(&table, cases[i].opacity, "turbo", cases[i].map_lo, cases[i].map_hi, cases[i].lo, cases[i].hi);
        assert_true(table.lo < table.hi);
        assert_true(table.count >= 4096 && table.count <= 65536 && (table.count & (table.count - 1)) == 0);
        for (int k = -100; k <= 10100; k++) {
            double value = cases[i].lo + (cases[i].hi - cases[i].lo) * k / 10000, rgb[3];
            size_t entry = look_up(&table, value);
            pel_transfer_color(&table.transfer, value, rgb);
            /* Half an entry of a curve whose points are at least 16 entries apart. */
            assert_true(fabs((double)table.opacity[entry] - pel_transfer_opacity(&table.transfer, value)) < 0.04);
            assert_true(fabs((double)table.red[entry] - rgb[0]) < 0.04 && fabs((double)table.green[entry] - rgb[1]) < 0.04 &&
                        fabs((double)table.blue[entry] - rgb[2]) < 0.04);
        }
    }
    pel_transfer_table_finish(&table);
}

static void ranges_hold_every_look_up(void **state)
{
    (void)state;
    struct pel_transfer_table table = { 0 };
    uint32_t seed = 7;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        build(&table, cases[i].opacity, "gray", cases[i].map_lo, cases[i].map_hi, cases[i].lo, cases[i].hi);
        for (int k = 0; k < 4000; k++) {
            double width = cases[i].hi - cases[i].lo, a, b;
            seed = seed * 1664525u + 1013904223u;
            a = cases[i].lo + width * (seed / 4294967296.0);
            seed = seed * 1664525u + 1013904223u;
            b = a + width * (seed / 4294967296.0) * (k % 4 == 0 ? 0 : k % 4 == 1 ? 0.001 : 0.3);
            float least, most;
            pel_transfer_table_opacity_range(&table, a, b, &least, &most);
            assert_true(pel_transfer_table_visible(&table, a, b) == (most > 0));
            for (int j = 0; j <= 16; j++) {
                float opacity = table.opacity[look_up(&table, a + (b - a) * j / 16)];
                assert_true(opacity >= least && opacity <= most);
            }
        }
    }
    pel_transfer_table_finish(&table);
}

/* What makes skipping worth while: air stays air under a ramp that begins at it. */
static void air_under_a_ramp_is_clear(void **state)
{
    (void)state;
    struct pel_transfer_table table = { 0 };
    float least, most;
    build(&table, "0:0,255:1", "gray", 0, 255, 0, 255);
    pel_transfer_table_opacity_range(&table, 0, 0, &least, &most);
    assert_true(most == 0);
    build(&table, "40:0,80:0.2,255:0.9", "gray", 0, 255, 0, 255);
    pel_transfer_table_opacity_range(&table, 0, 39, &least, &most);
    assert_true(most == 0);
    pel_transfer_table_opacity_range(&table, 0, 50, &least, &most);
    assert_true(least == 0 && most >= 0.05f && most < 0.06f);
    pel_transfer_table_opacity_range(&table, -1e30, 1e30, &least, &most);
    assert_true(least == 0 && most == 0.9f);
    pel_transfer_table_opacity_range(&table, NAN, NAN, &least, &most);
    assert_true(least == 0 && most == 0.9f);
    assert_false(pel_transfer_table_visible(&table, -1e30, 39));
    assert_true(pel_transfer_table_visible(&table, 39, 41));
    assert_true(pel_transfer_table_visible(&table, NAN, NAN));
    assert_false(pel_transfer_table_visible(&table, -1e30, 39));
    assert_true(pel_transfer_table_visible(&table, 39, 41));
    assert_true(pel_transfer_table_visible(&table, NAN, NAN));
    pel_transfer_table_finish(&table);
}

static void jumps_hold_at_their_value(void **state)
{
    (void)state;
    static const char *const jumps[] = { "40:0,40:0.5", "40:0,40:0.5,200:0.7", "10:0.1,40:0,40:0.5", "0:0,40:0,40:0.5,255:0.5" };
    struct pel_transfer_table table = { 0 };
    for (size_t i = 0; i < sizeof jumps / sizeof *jumps; i++)
        for (int map = 0; map < 2; map++) {
            build(&table, jumps[i], "gray", map ? 0 : 40, map ? 255 : 40, 0, 255);
            for (int value = 0; value < 256; value++) {
                double exact = pel_transfer_opacity(&table.transfer, value), found = (double)table.opacity[look_up(&table, value)];
                if (!(fabs(exact - found) < 1e-3))
                    fail_msg("%s: at %d the table has %g, the curve %g", jumps[i], value, found, exact);
            }
        }
    pel_transfer_table_finish(&table);
}

static void odd_ranges_are_ordered_and_wide_enough(void **state)
{
    (void)state;
    static const double ranges[][2] = { { 5, 5 },         { 9, -9 },          { NAN, NAN },
                                        { 0, 0 },         { 1e300, 1e300 },   { -DBL_MAX, DBL_MAX },
                                        { -INFINITY, 3 }, { 1e-310, 2e-310 }, { 1000, 2000 },
                                        { -3, -2 } };
    static const char *const opacities[] = { "0.5", "0:0,1:1", "-1e308:0,1e308:1", "1e300:0,1.0000000001e300:1", "0:0,1e-310:1" };
    struct pel_transfer_table table = { 0 };
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
        for (size_t j = 0; j < sizeof opacities / sizeof *opacities; j++) {
            build(&table, opacities[j], "viridis", 0, 1, ranges[i][0], ranges[i][1]);
            assert_true(table.lo < table.hi && isfinite(table.hi - table.lo));
            for (size_t k = 0; k < table.count; k += 97)
                assert_true(table.opacity[k] >= 0 && table.opacity[k] <= 1);
            float least, most;
            pel_transfer_table_opacity_range(&table, 0, 1, &least, &most);
            assert_true(least <= most);
        }
    pel_transfer_table_finish(&table);
}

static void unchanged_is_not_built_again(void **state)
{
    (void)state;
    struct pel_transfer t;
    struct pel_transfer_table table = { 0 };
    assert_true(pel_transfer_init(&t, NULL));
    assert_true(pel_transfer_table_build(&table, &t, 0, 1, NULL));
    table.opacity[7] = 42;
    assert_true(pel_transfer_table_build(&table, &t, 0, 1, NULL));
    assert_true(table.opacity[7] == 42);
    t.opacities[1].opacity = 0.5;
    assert_true(pel_transfer_table_build(&table, &t, 0, 1, NULL));
    assert_true(table.opacity[7] < 0.01f);
    pel_transfer_table_finish(&table);
    pel_transfer_table_finish(&table);
    pel_transfer_finish(&t);
    assert_false(pel_transfer_table_build(&table, &t, 0, 1, NULL)); /* a finished one has no points */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_near_the_exact_curves),
        cmocka_unit_test(ranges_hold_every_look_up),
        cmocka_unit_test(air_under_a_ramp_is_clear),
        cmocka_unit_test(jumps_hold_at_their_value),
        cmocka_unit_test(odd_ranges_are_ordered_and_wide_enough),
        cmocka_unit_test(unchanged_is_not_built_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
