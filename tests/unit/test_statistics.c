/* SPDX-License-Identifier: MIT */
/* Statistics and histograms against plain loops, for every type, with voids, NaN and infinity, and at any thread count. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <omp.h>

#include <pellucid/statistics.h>

/* A repeatable sequence that looks random (xorshift). */
static uint32_t next(uint32_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return *seed;
}

static void put(struct pel_volume *v, size_t i, double value)
{
    switch (v->type) {
    case PEL_U8: ((uint8_t *)v->data)[i] = (uint8_t)value; break;
    case PEL_I8: ((int8_t *)v->data)[i] = (int8_t)value; break;
    case PEL_U16: ((uint16_t *)v->data)[i] = (uint16_t)value; break;
    case PEL_I16: ((int16_t *)v->data)[i] = (int16_t)value; break;
    case PEL_U32: ((uint32_t *)v->data)[i] = (uint32_t)value; break;
    case PEL_I32: ((int32_t *)v->data)[i] = (int32_t)value; break;
    case PEL_F32: ((float *)v->data)[i] = (float)value; break;
    default: ((double *)v->data)[i] = value; break;
    }
}

/* Values 0 to 119, many of them 0, in each type. */
static struct pel_volume make(size_t x, size_t y, size_t z, enum pel_type type, int components)
{
    struct pel_volume v;
    uint32_t seed = 12345;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ x, y, z }, type, components, NULL));
    for (size_t i = 0; i < pel_volume_samples(&v) * (size_t)components; i++) {
        uint32_t r = next(&seed);
        put(&v, i, r & 0x10000 ? r % 120 : 0);
    }
    return v;
}

/* Value or length of a sample; NaN where void. */
static double value_at(const struct pel_volume *v, size_t x, size_t y, size_t z)
{
    double sum = 0;
    for (int c = 0; c < v->components; c++) {
        double n = pel_volume_get(v, x, y, z, c);
        if (pel_volume_is_void(v, n))
            return NAN;
        if (v->components == 1)
            return n;
        sum += n * n;
    }
    return sqrt(sum);
}

static void check_statistics(const struct pel_volume *v)
{
    struct pel_statistics s;
    double min = INFINITY, max = -INFINITY, sum = 0;
    uint64_t finite = 0, nonzero = 0, voids = 0, infinite = 0;
    for (size_t z = 0; z < v->dims[2]; z++)
        for (size_t y = 0; y < v->dims[1]; y++)
            for (size_t x = 0; x < v->dims[0]; x++) {
                double value = value_at(v, x, y, z);
                voids += isnan(value) != 0;
                infinite += isinf(value) != 0;
                if (!isfinite(value))
                    continue;
                min = fmin(min, value);
                max = fmax(max, value);
                sum += value;
                finite++;
                nonzero += value != 0;
            }
    pel_statistics_compute(v, &s);
    assert_true(s.min == min && s.max == max);
    assert_true(fabs(s.mean - sum / (double)finite) <= 1e-12 * fabs(s.mean));
    assert_int_equal(s.samples, pel_volume_samples(v));
    assert_int_equal(s.nonzero, nonzero);
    assert_int_equal(s.voids, voids);
    assert_int_equal(s.infinite, infinite);
}

static void test_statistics(void **state)
{
    (void)state;
    for (int t = 0; t < PEL_TYPE_COUNT; t++)
        for (int components = 1; components <= 4; components += 2) {
            struct pel_volume v = make(67, 45, 33, (enum pel_type)t, components);
            check_statistics(&v);
            v.has_void = true;
            v.void_value = 17;
            check_statistics(&v);
            if (t >= PEL_F32) {
                put(&v, 5, NAN);
                put(&v, 6, INFINITY);
                put(&v, 70000, -INFINITY);
                check_statistics(&v);
                v.has_void = false;
                check_statistics(&v);
            }
            pel_volume_finish(&v);
        }
}

static void test_nothing_but_voids(void **state)
{
    (void)state;
    struct pel_volume v;
    struct pel_statistics s;
    pel_volume_init(&v);
    pel_statistics_compute(&v, &s);
    assert_true(isnan(s.min) && isnan(s.max) && isnan(s.mean) && s.samples == 0);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ 3, 3, 3 }, PEL_U8, 1, NULL));
    v.has_void = true;
    pel_statistics_compute(&v, &s);
    assert_true(isnan(s.min) && isnan(s.max) && isnan(s.mean) && s.samples == 27 && s.voids == 27 && s.nonzero == 0);
    pel_volume_finish(&v);
}

/* Sums that a single precision or a naive loop would lose. */
static void test_mean_is_precise(void **state)
{
    (void)state;
    struct pel_volume v;
    struct pel_statistics s;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ 128, 128, 128 }, PEL_F32, 1, NULL));
    for (size_t i = 0; i < pel_volume_samples(&v); i++)
        ((float *)v.data)[i] = 0.1f;
    pel_statistics_compute(&v, &s);
    assert_true(fabs(s.mean - (double)0.1f) < 1e-16);
    pel_volume_finish(&v);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ 128, 128, 65 }, PEL_U16, 1, NULL));
    memset(v.data, 0xff, pel_volume_bytes(&v));
    pel_statistics_compute(&v, &s);
    assert_true(s.mean == 65535);
    pel_volume_finish(&v);
}

static double clamped(const struct pel_volume *v, size_t x, size_t y, size_t z, int axis, int step)
{
    size_t at[3] = { x, y, z };
    if (step < 0 && at[axis] > 0)
        at[axis]--;
    if (step > 0 && at[axis] + 1 < v->dims[axis])
        at[axis]++;
    return value_at(v, at[0], at[1], at[2]);
}

static void check_histogram(const struct pel_volume *v, double lo, double hi, size_t count)
{
    struct pel_histogram h;
    uint64_t *bins = calloc(count, sizeof *bins);
    double *gradient = calloc(count, sizeof *gradient);
    for (size_t z = 0; z < v->dims[2]; z++)
        for (size_t y = 0; y < v->dims[1]; y++)
            for (size_t x = 0; x < v->dims[0]; x++) {
                double value = value_at(v, x, y, z), sum = 0;
                if (!(value >= lo && value <= hi))
                    continue;
                size_t bin = (size_t)((value - lo) / (hi - lo) * (double)count);
                bin = bin < count ? bin : count - 1;
                bins[bin]++;
                for (int a = 0; a < 3; a++) {
                    double d = (clamped(v, x, y, z, a, 1) - clamped(v, x, y, z, a, -1)) / 2;
                    sum += d * d;
                }
                if (isfinite(sum))
                    gradient[bin] += sqrt(sum);
            }
    assert_true(pel_histogram_init(&h, v, lo, hi, count, true, NULL));
    assert_memory_equal(h.bins, bins, count * sizeof *bins);
    for (size_t i = 0; i < count; i++)
        assert_true(fabs(h.gradient_sum[i] - gradient[i]) <= 1e-5 * gradient[i]);
    pel_histogram_finish(&h);
    assert_true(pel_histogram_init(&h, v, lo, hi, count, false, NULL));
    assert_null(h.gradient_sum);
    assert_memory_equal(h.bins, bins, count * sizeof *bins);
    pel_histogram_finish(&h);
    free(bins);
    free(gradient);
}

static void test_histogram(void **state)
{
    (void)state;
    for (int t = 0; t < PEL_TYPE_COUNT; t++)
        for (int components = 1; components <= 4; components += 2) {
            struct pel_volume v = make(37, 21, 19, (enum pel_type)t, components);
            check_histogram(&v, 0, 119, 64);
            check_histogram(&v, -0.5, 119.5, 120);
            check_histogram(&v, 10.5, 20, 7);
            v.has_void = true;
            v.void_value = 17;
            check_histogram(&v, 0, 119, 64);
            if (t >= PEL_F32) {
                put(&v, 500, NAN);
                put(&v, 6, INFINITY);
                check_histogram(&v, 0, 119, 64);
            }
            pel_volume_finish(&v);
        }
}

static void test_histogram_of_odd_shapes(void **state)
{
    (void)state;
    static const size_t dims[][3] = { { 1, 1, 1 }, { 1, 9, 9 }, { 2, 1, 5 }, { 300, 1, 1 }, { 1, 1, 300 } };
    for (size_t i = 0; i < sizeof dims / sizeof *dims; i++) {
        struct pel_volume v = make(dims[i][0], dims[i][1], dims[i][2], PEL_U8, 1);
        check_histogram(&v, 0, 255, 256);
        pel_volume_finish(&v);
    }
}

static void test_histogram_refuses(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_histogram h;
    struct pel_volume v = make(3, 3, 3, PEL_U8, 1), empty;
    pel_volume_init(&empty);
    assert_false(pel_histogram_init(&h, &v, 0, 1, 0, false, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_false(pel_histogram_init(&h, &v, 2, 1, 10, false, &error));
    assert_false(pel_histogram_init(&h, &v, NAN, 1, 10, false, &error));
    assert_false(pel_histogram_init(&h, &empty, 0, 1, 10, false, &error));
    pel_histogram_finish(&h);
    assert_true(pel_histogram_init(&h, &v, 5, 5, 10, true, &error)); /* a constant volume has such a range */
    pel_histogram_finish(&h);
    pel_volume_finish(&v);
}

/* The same bits with one thread and with four. */
static void test_threads(void **state)
{
    (void)state;
    struct pel_statistics s[2];
    struct pel_histogram h[2];
    struct pel_volume v = make(67, 45, 63, PEL_F32, 1);
    for (size_t i = 0; i < pel_volume_samples(&v); i++)
        ((float *)v.data)[i] *= 0.3f;
    int before = omp_get_max_threads();
    for (int i = 0; i < 2; i++) {
        omp_set_num_threads(i ? 4 : 1);
        pel_statistics_compute(&v, &s[i]);
        assert_true(pel_histogram_init(&h[i], &v, 0, 40, 500, true, NULL));
    }
    omp_set_num_threads(before);
    assert_memory_equal(&s[0], &s[1], sizeof s[0]);
    assert_memory_equal(h[0].bins, h[1].bins, 500 * sizeof *h[0].bins);
    assert_memory_equal(h[0].gradient_sum, h[1].gradient_sum, 500 * sizeof *h[0].gradient_sum);
    pel_histogram_finish(&h[0]);
    pel_histogram_finish(&h[1]);
    pel_volume_finish(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_statistics),
        cmocka_unit_test(test_nothing_but_voids),
        cmocka_unit_test(test_mean_is_precise),
        cmocka_unit_test(test_histogram),
        cmocka_unit_test(test_histogram_of_odd_shapes),
        cmocka_unit_test(test_histogram_refuses),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests_name("statistics", tests, NULL, NULL);
}
