/* SPDX-License-Identifier: MIT */
/* The colour maps against published values. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/transfer.h>

static const struct {
    const char *name;
    double t, rgb[3], tolerance;
} known[] = {
    { "viridis", 0, { 0.267004, 0.004874, 0.329415 }, 1e-4 },
    { "viridis", 63 / 255.0, { 0.231674, 0.318106, 0.544834 }, 0.006 },
    { "viridis", 128 / 255.0, { 0.127568, 0.566949, 0.550556 }, 0.006 },
    { "viridis", 1, { 0.993248, 0.906157, 0.143936 }, 1e-4 },
    { "plasma", 0, { 0.050383, 0.029803, 0.527975 }, 1e-4 },
    { "plasma", 128 / 255.0, { 0.798216, 0.280197, 0.469538 }, 0.006 },
    { "plasma", 1, { 0.940015, 0.975158, 0.131326 }, 1e-4 },
    { "inferno", 0, { 0.001462, 0.000466, 0.013866 }, 1e-4 },
    { "inferno", 128 / 255.0, { 0.735683, 0.215906, 0.330245 }, 0.006 },
    { "inferno", 1, { 0.988362, 0.998364, 0.644924 }, 1e-4 },
    { "magma", 0, { 0.001462, 0.000466, 0.013866 }, 1e-4 },
    { "magma", 128 / 255.0, { 0.716387, 0.214982, 0.47529 }, 0.006 },
    { "magma", 1, { 0.987053, 0.991438, 0.749504 }, 1e-4 },
    { "cividis", 0, { 0, 0.135112, 0.304751 }, 1e-4 },
    { "cividis", 1, { 0.995737, 0.909344, 0.217772 }, 1e-4 },
    { "turbo", 0, { 0.18995, 0.07176, 0.23217 }, 1e-4 },
    { "turbo", 128 / 255.0, { 0.64362, 0.98999, 0.23356 }, 0.006 },
    { "turbo", 1, { 0.4796, 0.01583, 0.01055 }, 1e-4 },
    { "coolwarm", 0, { 0.230, 0.299, 0.754 }, 0.002 },
    { "coolwarm", 0.5, { 0.865, 0.865, 0.865 }, 0.005 },
    { "coolwarm", 1, { 0.706, 0.016, 0.150 }, 0.002 },
    { "gray", 0.25, { 0.25, 0.25, 0.25 }, 1e-12 },
    { "bone", 0.365079, { 0.319444, 0.319444, 0.444444 }, 0.001 },
    { "hot", 0.365079, { 1, 0, 0 }, 0.001 },
    { "hot", 1, { 1, 1, 1 }, 1e-12 },
    { "copper", 1, { 1, 0.7812, 0.4975 }, 1e-12 },
    { "jet", 0, { 0, 0, 0.5 }, 1e-12 },
    { "rainbow-desaturated", 1, { 0.878431, 0.301961, 0.301961 }, 1e-3 },
};

static void known_colors(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        double rgb[3];
        assert_true(pel_colormap_lookup(known[i].name, known[i].t, rgb));
        for (int c = 0; c < 3; c++)
            if (!(fabs(rgb[c] - known[i].rgb[c]) <= known[i].tolerance))
                fail_msg("%s at %g: channel %d is %g, not %g", known[i].name, known[i].t, c, rgb[c], known[i].rgb[c]);
    }
}

static void every_map_is_continuous_and_within_range(void **state)
{
    (void)state;
    size_t count = 0;
    for (; pel_colormap_name(count); count++) {
        const char *name = pel_colormap_name(count);
        double before[3], rgb[3];
        assert_true(pel_colormap_lookup(name, 0, before));
        for (int i = 0; i <= 1000; i++) {
            assert_true(pel_colormap_lookup(name, i / 1000.0, rgb));
            for (int c = 0; c < 3; c++) {
                assert_true(rgb[c] >= 0 && rgb[c] <= 1);
                assert_true(fabs(rgb[c] - before[c]) < 0.02);
                before[c] = rgb[c];
            }
        }
        for (size_t other = 0; other < count; other++)
            assert_string_not_equal(name, pel_colormap_name(other));
    }
    assert_true(count >= 14);
    assert_null(pel_colormap_name(count + 1));
}

static void names_and_ends(void **state)
{
    (void)state;
    double a[3], b[3];
    assert_false(pel_colormap_lookup("no such map", 0, a));
    assert_false(pel_colormap_lookup(NULL, 0, a));
    assert_true(pel_colormap_lookup("VIRIDIS", 0.3, a));
    assert_true(pel_colormap_lookup("viridis", 0.3, b));
    assert_memory_equal(a, b, sizeof a);
    assert_true(pel_colormap_lookup("viridis", -7, a));
    assert_true(pel_colormap_lookup("viridis", NAN, b));
    assert_memory_equal(a, b, sizeof a);
    assert_true(pel_colormap_lookup("viridis", 7, a));
    assert_true(pel_colormap_lookup("viridis", 1, b));
    assert_memory_equal(a, b, sizeof a);
}

/* A stretched map is the map, not a sampling of it. */
static void stretched_map_equals_the_map(void **state)
{
    (void)state;
    struct pel_transfer transfer;
    assert_true(pel_transfer_init(&transfer, NULL));
    for (size_t i = 0; pel_colormap_name(i); i++) {
        assert_true(pel_transfer_set_colormap(&transfer, pel_colormap_name(i), 300, -100, NULL)); /* reversed */
        assert_string_equal(transfer.colormap, pel_colormap_name(i));
        for (int k = 0; k <= 500; k++) {
            double from_map[3], from_transfer[3];
            pel_colormap_lookup(pel_colormap_name(i), k / 500.0, from_map);
            pel_transfer_color(&transfer, 300 - 400 * (k / 500.0), from_transfer);
            for (int c = 0; c < 3; c++)
                assert_true(fabs(from_map[c] - from_transfer[c]) < 1e-9);
        }
    }
    pel_transfer_finish(&transfer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_colors),
        cmocka_unit_test(every_map_is_continuous_and_within_range),
        cmocka_unit_test(names_and_ends),
        cmocka_unit_test(stretched_map_equals_the_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
