/* SPDX-License-Identifier: MIT */
/* The scheduler of slices2d, with frames of known cost in place of a renderer. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../src/render/slices2d/slices2d_schedule.h"

#define VOXELS 257
static const struct pel_slices2d_quality best = { 4, 1, 4 };

/* What a frame would cost: less with more slices a polygon, but for 8. */
static double frame_ms(const struct pel_slices2d_quality *q, double scale)
{
    const double each = q->slices_per_polygon == 1 ? 1 : q->slices_per_polygon == 2 ? 0.6 : q->slices_per_polygon == 4 ? 0.4 : 0.5;
    return pel_slices2d_scheduled(q, VOXELS) * each * scale;
}

static struct pel_slices2d_quality run(struct pel_slices2d_scheduler *s, int frames, double budget, double scale)
{
    struct pel_slices2d_quality q = best;
    for (int i = 0; i < frames; i++) {
        q = pel_slices2d_schedule(s, true, budget, VOXELS, &best);
        pel_slices2d_measured(s, &q, VOXELS, frame_ms(&q, scale));
    }
    return q;
}

static void test_counts(void **state)
{
    (void)state;
    assert_int_equal(pel_slices2d_scheduled(&(struct pel_slices2d_quality) { 1, 1, 1 }, VOXELS), 257);
    assert_int_equal(pel_slices2d_scheduled(&(struct pel_slices2d_quality) { 4, 1, 1 }, VOXELS), 1025);
    assert_int_equal(pel_slices2d_scheduled(&(struct pel_slices2d_quality) { 1, 2, 1 }, VOXELS), 129);
    assert_int_equal(pel_slices2d_scheduled(&(struct pel_slices2d_quality) { 1, 8, 1 }, 10), 3);
    assert_int_equal(pel_slices2d_scheduled(&(struct pel_slices2d_quality) { 10, 1, 1 }, 1), 1);
}

static void test_nothing_known(void **state)
{
    (void)state;
    const struct pel_slices2d_scheduler s = { 0 };
    struct pel_slices2d_quality q = pel_slices2d_schedule(&s, false, 10, VOXELS, &best);
    assert_int_equal(q.supersampling, 4);
    assert_int_equal(q.slices_per_polygon, 4);
    q = pel_slices2d_schedule(&s, true, 10, VOXELS, &best);
    assert_int_equal(q.slices_per_polygon, 8); /* tried first */
}

/* It learns the cheapest number of slices a polygon, and keeps to the budget with the finest sampling that it allows. */
static void test_budget(void **state)
{
    (void)state;
    for (double scale = 0.01; scale < 3; scale *= 2) {
        struct pel_slices2d_scheduler s = { 0 };
        const double budget = 60;
        struct pel_slices2d_quality q = run(&s, 10, budget, scale), finer = q;
        assert_int_equal(q.slices_per_polygon, 4);
        assert_true(frame_ms(&q, scale) <= budget || (q.supersampling == 1 && q.every == 8));
        if (q.every > 1)
            finer.every--;
        else
            finer.supersampling++;
        assert_true(frame_ms(&finer, scale) > budget || q.supersampling == best.supersampling);
    }
}

static void test_rest_is_best(void **state)
{
    (void)state;
    struct pel_slices2d_scheduler s = { 0 };
    struct pel_slices2d_quality q = run(&s, 10, 1, 1);
    assert_int_equal(q.every, 8);
    q = pel_slices2d_schedule(&s, false, 1, VOXELS, &best);
    assert_int_equal(q.supersampling, best.supersampling);
    assert_int_equal(q.every, best.every);
    assert_int_equal(q.slices_per_polygon, 4);
}

/* A larger picture shows after some frames, and so does a smaller one. */
static void test_change_of_cost(void **state)
{
    (void)state;
    struct pel_slices2d_scheduler s = { 0 };
    run(&s, 10, 60, 0.1);
    struct pel_slices2d_quality q = run(&s, 12, 60, 1);
    assert_true(frame_ms(&q, 1) <= 60);
    q = run(&s, 12, 60, 0.01);
    assert_int_equal(q.supersampling, best.supersampling);
}

/* An engine that has no polygons: it keeps to the budget, and tries nothing. */
static void test_no_polygons(void **state)
{
    (void)state;
    struct pel_slices2d_scheduler s = { .no_polygons = true };
    for (int i = 0; i < 6; i++) {
        struct pel_slices2d_quality q = pel_slices2d_schedule(&s, true, 60, VOXELS, &best);
        assert_int_equal(q.slices_per_polygon, best.slices_per_polygon);
        assert_true(i == 0 || frame_ms(&q, 0.5) <= 60);
        pel_slices2d_measured(&s, &q, VOXELS, frame_ms(&q, 0.5));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),       cmocka_unit_test(test_nothing_known),  cmocka_unit_test(test_budget),
        cmocka_unit_test(test_rest_is_best), cmocka_unit_test(test_change_of_cost), cmocka_unit_test(test_no_polygons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
