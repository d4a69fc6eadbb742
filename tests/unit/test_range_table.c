/* SPDX-License-Identifier: MIT */
/* The range table against a plain search, over every interval of arrays of many lengths. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "range_table.h"

static void fill(float *values, size_t count, uint32_t seed)
{
    for (size_t i = 0; i < count; i++) {
        seed = seed * 1664525u + 1013904223u;
        values[i] = (float)(int32_t)seed / 1e6f;
    }
}

static void check_all_intervals(const struct pel_range_table *table, const float *values, size_t count)
{
    for (size_t first = 0; first < count; first++) {
        float least = values[first], most = values[first];
        for (size_t last = first; last < count; last++) {
            least = values[last] < least ? values[last] : least;
            most = values[last] > most ? values[last] : most;
            assert_true(pel_range_table_least(table, first, last) == least);
            assert_true(pel_range_table_most(table, first, last) == most);
        }
    }
}

static void every_interval_has_its_extremes(void **state)
{
    (void)state;
    static const size_t counts[] = { 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 100, 255, 256, 257 };
    float values[257];
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        struct pel_range_table table = { 0 };
        fill(values, counts[i], (uint32_t)counts[i]);
        assert_true(pel_range_table_build(&table, values, counts[i], NULL));
        check_all_intervals(&table, values, counts[i]);
        pel_range_table_finish(&table);
    }
}

static void is_built_again_in_place(void **state)
{
    (void)state;
    float values[64];
    struct pel_range_table table = { 0 };
    fill(values, 64, 1);
    assert_true(pel_range_table_build(&table, values, 64, NULL));
    float *before = table.most;
    fill(values, 64, 2);
    assert_true(pel_range_table_build(&table, values, 64, NULL));
    assert_ptr_equal(table.most, before);
    check_all_intervals(&table, values, 64);
    assert_true(pel_range_table_build(&table, values, 33, NULL));
    check_all_intervals(&table, values, 33);
    pel_range_table_finish(&table);
    pel_range_table_finish(&table); /* a zeroed one */
}

static void nothing_is_refused(void **state)
{
    (void)state;
    struct pel_range_table table = { 0 };
    struct pel_error error = PEL_ERROR_INIT;
    float value = 1;
    assert_false(pel_range_table_build(&table, &value, 0, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_false(pel_range_table_build(&table, &value, SIZE_MAX / 2, &error));
    assert_int_equal(error.code, PEL_ERROR_MEMORY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_interval_has_its_extremes),
        cmocka_unit_test(is_built_again_in_place),
        cmocka_unit_test(nothing_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
