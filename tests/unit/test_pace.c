/* SPDX-License-Identifier: MIT */
/* Pace against machines that are made up: cost is a constant and a slope. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "pace.h"

static const int whole[2] = { 800, 600 };

static double cost(double constant, double per_megapixel, const int size[2])
{
    return constant + per_megapixel * 1e-6 * size[0] * size[1];
}

/* What the pace comes to after some pictures. */
static void settle(struct pace *pace, double constant, double per_megapixel, int pictures, int size[2])
{
    for (int i = 0; i < pictures; i++) {
        pace_choose(pace, PACE_CAMERA, whole, size);
        pace_measured(pace, PACE_CAMERA, size, cost(constant, per_megapixel, size));
    }
    pace_choose(pace, PACE_CAMERA, whole, size);
}

static void test_unknown_is_whole(void **state)
{
    (void)state;
    struct pace pace;
    int size[2];
    pace_init(&pace, 33);
    pace_choose(&pace, PACE_CAMERA, whole, size);
    assert_int_equal(size[0], 800);
    assert_int_equal(size[1], 600);
}

static void test_fits_the_budget(void **state)
{
    (void)state;
    static const double machines[][2] = { { 2, 30 }, { 2, 100 }, { 10, 300 }, { 0, 1000 }, { 20, 100 } };
    for (size_t i = 0; i < sizeof machines / sizeof *machines; i++) {
        struct pace pace;
        int size[2];
        pace_init(&pace, 33);
        settle(&pace, machines[i][0], machines[i][1], 12, size);
        double ms = cost(machines[i][0], machines[i][1], size), most = cost(machines[i][0], machines[i][1], whole);
        assert_true(ms <= 33);
        assert_true(most <= 33 ? size[0] == 800 : ms >= 33 * 0.8 / 2); /* and does not waste it */
        assert_true(fabs((double)size[0] / size[1] - 800.0 / 600) < 0.02);
    }
}

/* Where the constant is more than the budget, a tiny picture would gain nothing. */
static void test_constant_cost(void **state)
{
    (void)state;
    struct pace pace;
    int size[2];
    pace_init(&pace, 33);
    settle(&pace, 60, 5, 12, size);
    assert_int_equal(size[0], 800);
}

static void test_grows_again(void **state)
{
    (void)state;
    struct pace pace;
    int size[2];
    pace_init(&pace, 33);
    settle(&pace, 5, 800, 12, size);
    assert_true(size[0] < 300);
    settle(&pace, 5, 20, 30, size);
    assert_int_equal(size[0], 800);
}

static void test_kinds(void **state)
{
    (void)state;
    struct pace pace;
    int size[2];
    pace_init(&pace, 33);
    for (int i = 0; i < 6; i++)
        pace_measured(&pace, PACE_SCENE, whole, 400);
    pace_choose(&pace, PACE_CAMERA, whole, size);
    assert_true(size[0] < 800); /* known from the other kind */
    settle(&pace, 1, 1, 20, size);
    assert_int_equal(size[0], 800); /* and then from its own */
    pace_choose(&pace, PACE_SCENE, whole, size);
    assert_true(size[0] < 800);
    const int tiny[2] = { 20, 16 };
    pace_choose(&pace, PACE_SCENE, tiny, size);
    assert_true(size[0] >= 16 && size[1] >= 16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_unknown_is_whole), cmocka_unit_test(test_fits_the_budget), cmocka_unit_test(test_constant_cost),
        cmocka_unit_test(test_grows_again),      cmocka_unit_test(test_kinds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
