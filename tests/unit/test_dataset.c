/* SPDX-License-Identifier: MIT */
/* Computed data sets against what is known of them: integrals, radii, values at points, symmetries, and the same bytes anywhere. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <omp.h>

#include <pellucid/dataset.h>

#include "datasets/formula.h"

/* Makes a data set with options given as pairs of name and text. */
static struct pel_volume make(const char *name, const char *const *pairs)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume v;
    const struct pel_dataset *dataset = pel_dataset_find(name);
    assert_non_null(dataset);
    void *params = pel_dataset_create_params(dataset);
    assert_non_null(params);
    for (; pairs && pairs[0]; pairs += 2)
        if (!pel_option_set(pel_option_find(dataset->options, pairs[0]), params, pairs[1], &error))
            fail_msg("%s: %s", name, error.message);
    pel_volume_init(&v);
    if (!pel_dataset_make(dataset, params, &v, &error))
        fail_msg("%s", error.message);
    free(params);
    return v;
}
#define MAKE(name, ...) make(name, (const char *const[]){ __VA_ARGS__, NULL })

static void position(const struct pel_volume *v, size_t x, size_t y, size_t z, double p[3])
{
    pel_volume_index_to_world(v, (double[3]){ (double)x, (double)y, (double)z }, p);
}

static uint64_t checksum(const struct pel_volume *v)
{
    uint64_t hash = 1469598103934665603u; /* FNV-1a */
    for (size_t i = 0; i < pel_volume_bytes(v); i++)
        hash = (hash ^ ((const unsigned char *)v->data)[i]) * 1099511628211u;
    return hash;
}

/* Our own sine, cosine and exponential against the C library's. */
static void test_formulas(void **state)
{
    (void)state;
    for (int i = -20000; i <= 20000; i++) {
        double x = i * 0.0173;
        assert_true(fabs(pel_sin(x) - sin(x)) < 3e-16);
        assert_true(fabs(pel_cos(x) - cos(x)) < 3e-16);
        double e = exp(x);
        assert_true(fabs(pel_exp(x) - e) <= 1e-15 * e);
    }
    assert_true(fabs(pel_sin(123456.789) - sin(123456.789)) < 1e-15);
    assert_true(pel_exp(-800) == 0 && isinf(pel_exp(800)) && pel_exp(0) == 1 && pel_sin(0) == 0 && pel_cos(0) == 1);
}

static void test_list(void **state)
{
    (void)state;
    size_t count = 0;
    for (; pel_dataset_at(count); count++) {
        const struct pel_dataset *d = pel_dataset_at(count);
        assert_ptr_equal(pel_dataset_find(d->name), d);
        assert_non_null(d->summary);
        assert_string_equal(d->options[0].name, "size");
        struct pel_volume v = MAKE(d->name, "size", "9");
        assert_true(pel_volume_check(&v, NULL));
        assert_int_equal(pel_volume_samples(&v), 729);
        assert_int_equal(v.type, PEL_F32);
        assert_string_equal(v.name, d->name);
        for (size_t i = 0; i < 729 * (size_t)v.components; i++)
            assert_true(isfinite(((float *)v.data)[i]));
        assert_true(v.range[0] <= v.range[1]);
        assert_false(pel_volume_detect_labels(&v));
        pel_volume_finish(&v);
    }
    assert_int_equal(count, 11);
    assert_null(pel_dataset_at(count + 5));
    assert_null(pel_dataset_find("no such"));
}

/* One thread and four give the same bytes; so does any other machine: the checksums were taken on x86-64. */
static void test_same_bytes(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint64_t sum;
    } known[] = {
        { "hydrogen", 0x819d2be81352db6f }, { "marschner-lobb", 0xb05bfa45684ebed0 }, { "shepp-logan", 0x0292d8cd1de98dc3 },
        { "gyroid", 0x1725fb008512ea73 }, { "sphere", 0x63350349b870bf1b }, { "shell", 0x3e5e05fd55907236 },
        { "box", 0xd7378846721bd120 }, { "torus", 0x0900a5d42cdd7770 }, { "constant", 0x9eb5128eadee435a },
        { "tornado", 0xd51534ed1281faee }, { "abc", 0xf3ab2109e7af6076 },
    };
    int before = omp_get_max_threads(), wrong = 0;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        uint64_t sums[2];
        for (int k = 0; k < 2; k++) {
            omp_set_num_threads(k ? 4 : 1);
            struct pel_volume v = MAKE(known[i].name, "size", "33");
            sums[k] = checksum(&v);
            pel_volume_finish(&v);
        }
        assert_true(sums[0] == sums[1]);
        if (sums[0] != known[i].sum)
            print_error("{ \"%s\", 0x%016llx },\n", known[i].name, (unsigned long long)sums[0]);
        wrong += sums[0] != known[i].sum;
    }
    omp_set_num_threads(before);
    assert_int_equal(wrong, 0);
}

static void test_size_limits(void **state)
{
    (void)state;
    for (size_t i = 0; pel_dataset_at(i); i++) {
        const struct pel_dataset *d = pel_dataset_at(i);
        static const int bad[] = { -1, 0, 1, 2049, 1 << 30 };
        struct pel_error error = PEL_ERROR_INIT;
        struct pel_volume v;
        void *params = pel_dataset_create_params(d);
        pel_volume_init(&v);
        for (int k = 0; k < 5; k++) {
            memcpy((char *)params + d->options[0].offset, &bad[k], sizeof bad[k]); /* past the option's own check */
            assert_false(pel_dataset_make(d, params, &v, &error));
            assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
            assert_memory_equal(error.message, d->name, strlen(d->name));
            assert_null(v.data);
        }
        free(params);
        struct pel_volume least = MAKE(d->name, "size", "2");
        assert_int_equal(pel_volume_samples(&least), 8);
        pel_volume_finish(&least);
    }
}

/* ---- hydrogen ---- */

static double integral(const struct pel_volume *v)
{
    double sum = 0;
    for (size_t i = 0; i < pel_volume_samples(v); i++)
        sum += (double)((float *)v->data)[i];
    return sum * v->spacing[0] * v->spacing[1] * v->spacing[2];
}

/* The electron is somewhere: the density integrates to 1 for any n, l, m. */
static void test_hydrogen_integral(void **state)
{
    (void)state;
    static const char *const orbitals[][3] = {
        { "1", "0", "0" }, { "2", "0", "0" }, { "2", "1", "0" }, { "2", "1", "-1" }, { "3", "2", "0" },  { "3", "2", "2" },
        { "4", "2", "1" }, { "4", "3", "0" }, { "5", "4", "-3" }, { "6", "1", "1" }, { "7", "6", "6" }, { "10", "9", "5" },
    };
    for (size_t i = 0; i < sizeof orbitals / sizeof *orbitals; i++) {
        struct pel_volume v = MAKE("hydrogen", "size", "81", "n", orbitals[i][0], "l", orbitals[i][1], "m", orbitals[i][2]);
        double total = integral(&v);
        if (!(fabs(total - 1) < 0.01))
            fail_msg("psi(%s,%s,%s) integrates to %g", orbitals[i][0], orbitals[i][1], orbitals[i][2], total);
        assert_string_equal(v.units, "bohr");
        pel_volume_finish(&v);
    }
}

/* The textbook's closed forms, in Bohr radii. */
static double textbook(int n, int l, int m, const double p[3])
{
    const double pi = 3.14159265358979323846;
    double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), x2y2 = p[0] * p[0] + p[1] * p[1];
    if (n == 1)
        return exp(-2 * r) / pi;
    if (n == 2 && l == 0)
        return (2 - r) * (2 - r) * exp(-r) / (32 * pi);
    if (n == 2 && m == 0)
        return p[2] * p[2] * exp(-r) / (32 * pi);
    if (n == 2)
        return x2y2 * exp(-r) / (64 * pi);
    if (n == 3 && l == 2 && m == 0) /* (3z^2 - r^2)^2 e^(-2r/3) / (6 81^2 pi) */
        return pow(3 * p[2] * p[2] - r * r, 2) * exp(-2 * r / 3) / (6 * 81.0 * 81.0 * pi);
    return x2y2 * x2y2 * exp(-2 * r / 3) / (4 * 81.0 * 81.0 * pi); /* 3, 2, +-2 */
}

static void test_hydrogen_textbook(void **state)
{
    (void)state;
    static const int orbitals[][3] = { { 1, 0, 0 }, { 2, 0, 0 }, { 2, 1, 0 }, { 2, 1, 1 }, { 3, 2, 0 }, { 3, 2, -2 } };
    for (size_t i = 0; i < sizeof orbitals / sizeof *orbitals; i++) {
        char n[8], l[8], m[8];
        snprintf(n, sizeof n, "%d", orbitals[i][0]);
        snprintf(l, sizeof l, "%d", orbitals[i][1]);
        snprintf(m, sizeof m, "%d", orbitals[i][2]);
        struct pel_volume v = MAKE("hydrogen", "size", "21", "n", n, "l", l, "m", m, "extent", "10");
        assert_true(v.origin[0] == -10 && v.spacing[0] == 1);
        for (size_t z = 0; z < 21; z++)
            for (size_t y = 0; y < 21; y++)
                for (size_t x = 0; x < 21; x++) {
                    double p[3];
                    position(&v, x, y, z, p);
                    double expected = textbook(orbitals[i][0], orbitals[i][1], orbitals[i][2], p);
                    assert_true(fabs(pel_volume_get(&v, x, y, z, 0) - expected) <= 2e-7 * expected + 1e-20);
                }
        pel_volume_finish(&v);
    }
}

/* Mirrored in each plane through the nucleus, and turned by a quarter about z: exactly the same. */
static void test_hydrogen_symmetry(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("hydrogen", "size", "32", "n", "5", "l", "3", "m", "1");
    for (size_t z = 0; z < 32; z++)
        for (size_t y = 0; y < 32; y++)
            for (size_t x = 0; x < 32; x++) {
                double value = pel_volume_get(&v, x, y, z, 0);
                assert_true(value == pel_volume_get(&v, 31 - x, y, z, 0));
                assert_true(value == pel_volume_get(&v, x, 31 - y, z, 0));
                assert_true(value == pel_volume_get(&v, x, y, 31 - z, 0));
                assert_true(value == pel_volume_get(&v, y, x, z, 0));
            }
    pel_volume_finish(&v);
}

static void test_hydrogen_large_numbers(void **state)
{
    (void)state;
    static const char *const l[] = { "0", "31", "63" };
    for (int i = 0; i < 3; i++) {
        struct pel_volume v = MAKE("hydrogen", "size", "24", "n", "64", "l", l[i], "m", i ? "-31" : "0");
        for (size_t k = 0; k < pel_volume_samples(&v); k++)
            assert_true(isfinite(((float *)v.data)[k]) && ((float *)v.data)[k] >= 0);
        assert_true(v.range[1] > 0);
        pel_volume_finish(&v);
    }
}

static void test_hydrogen_refuses(void **state)
{
    (void)state;
    static const char *const bad[][3] = { { "2", "2", "0" }, { "1", "1", "0" }, { "3", "1", "2" }, { "3", "1", "-2" } };
    const struct pel_dataset *d = pel_dataset_find("hydrogen");
    for (int i = 0; i < 4; i++) {
        struct pel_error error = PEL_ERROR_INIT;
        struct pel_volume v;
        void *params = pel_dataset_create_params(d);
        assert_true(pel_option_set(pel_option_find(d->options, "n"), params, bad[i][0], NULL));
        assert_true(pel_option_set(pel_option_find(d->options, "l"), params, bad[i][1], NULL));
        assert_true(pel_option_set(pel_option_find(d->options, "m"), params, bad[i][2], NULL));
        pel_volume_init(&v);
        assert_false(pel_dataset_make(d, params, &v, &error));
        assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
        free(params);
    }
}

/* ---- the others ---- */

static void test_marschner_lobb(void **state)
{
    (void)state;
    struct pel_volume v = make("marschner-lobb", NULL);
    assert_int_equal(v.dims[0], 41);
    assert_true(fabs(v.origin[0] + 1) < 1e-15 && fabs(v.spacing[0] - 0.05) < 1e-15);
    /* On the axis cos(2 pi 6 cos 0) = 1: (1 - sin(pi z / 2) + 0.5) / 2.5 */
    assert_true(fabs(pel_volume_get(&v, 20, 20, 20, 0) - 0.6) < 1e-7);
    assert_true(fabs(pel_volume_get(&v, 20, 20, 0, 0) - 1) < 1e-7);
    assert_true(fabs(pel_volume_get(&v, 20, 20, 40, 0) - 0.2) < 1e-7);
    for (size_t i = 0; i < 41; i++) {
        double p[3];
        position(&v, i, 7, 30, p);
        double r = sqrt(p[0] * p[0] + p[1] * p[1]), rings = cos(2 * PEL_PI * 6 * cos(PEL_PI * r / 2));
        double expected = (1 - sin(PEL_PI * p[2] / 2) + 0.25 * (1 + rings)) / 2.5;
        assert_true(fabs(pel_volume_get(&v, i, 7, 30, 0) - expected) < 1e-6);
    }
    assert_true(v.range[0] >= 0 && v.range[1] <= 1);
    pel_volume_finish(&v);
}

/* Where the trilinear signal crosses 0 along rays from the centre: the true radius within a hundredth of a voxel. */
static void test_sphere_radius(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("sphere", "size", "129", "radius", "0.7");
    for (int i = 0; i < 129; i++) {
        double p[3];
        position(&v, (size_t)i, 64, 64, p);
        assert_true(fabs(pel_volume_get(&v, (size_t)i, 64, 64, 0) - (0.7 - fabs(p[0]))) < 1e-7);
    }
    for (int k = 0; k < 200; k++) {
        double a = k * 0.7, b = k * 1.3, d[3] = { cos(a) * sin(b), sin(a) * sin(b), cos(b) }, lo = 0.6, hi = 0.8;
        for (int step = 0; step < 50; step++) {
            double middle = (lo + hi) / 2, value = 0, index[3], f[3];
            size_t base[3];
            pel_volume_world_to_index(&v, (double[3]){ d[0] * middle, d[1] * middle, d[2] * middle }, index);
            for (int j = 0; j < 3; j++)
                base[j] = (size_t)index[j], f[j] = index[j] - floor(index[j]);
            for (int c = 0; c < 8; c++)
                value += (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]) *
                         pel_volume_get(&v, base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2 & 1), 0);
            *(value > 0 ? &lo : &hi) = middle;
        }
        assert_true(fabs(lo - 0.7) / v.spacing[0] < 0.01);
    }
    pel_volume_finish(&v);
}

static void test_shapes(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("shell", "size", "21", "radius", "0.6", "thickness", "0.2");
    assert_true(fabs(pel_volume_get(&v, 16, 10, 10, 0) - 0.1) < 1e-7); /* in the middle of the wall */
    assert_true(fabs(pel_volume_get(&v, 10, 10, 10, 0) + 0.5) < 1e-7);
    assert_true(fabs(pel_volume_get(&v, 10, 0, 10, 0) + 0.3) < 1e-7);
    pel_volume_finish(&v);
    v = MAKE("box", "size", "21", "half-edge", "0.7,0.5,0.4");
    assert_true(fabs(pel_volume_get(&v, 10, 10, 10, 0) - 0.4) < 1e-7); /* to the nearest face */
    assert_true(fabs(pel_volume_get(&v, 20, 10, 10, 0) + 0.3) < 1e-7);
    assert_true(fabs(pel_volume_get(&v, 0, 0, 0, 0) + sqrt(0.09 + 0.25 + 0.36)) < 1e-7); /* to the corner */
    pel_volume_finish(&v);
    v = MAKE("torus", "size", "21", "radius", "0.6", "tube", "0.25");
    assert_true(fabs(pel_volume_get(&v, 10, 16, 10, 0) - 0.25) < 1e-7);
    assert_true(fabs(pel_volume_get(&v, 10, 10, 10, 0) - (0.25 - 0.6)) < 1e-7);
    assert_true(fabs(pel_volume_get(&v, 10, 16, 12, 0) - 0.05) < 1e-7);
    pel_volume_finish(&v);
    v = MAKE("constant", "size", "21", "value", "-2.5");
    assert_true(v.range[0] == -2.5 && v.range[1] == -2.5);
    pel_volume_finish(&v);
}

static void test_gyroid(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("gyroid", "size", "65", "periods", "2");
    assert_true(fabs(v.origin[0] + 2 * PEL_PI) < 1e-12);
    assert_true(fabs(pel_volume_get(&v, 32, 32, 32, 0)) < 1e-6);
    /* A period is 32 samples, and the middle inverts: f(-p) = sum of -sin cos */
    for (size_t i = 0; i < 32; i++) {
        assert_true(fabs(pel_volume_get(&v, i, 5, 9, 0) - pel_volume_get(&v, i + 32, 37, 41, 0)) < 1e-6);
        double p[3];
        position(&v, i, 5, 9, p);
        double expected = sin(p[0]) * cos(p[1]) + sin(p[1]) * cos(p[2]) + sin(p[2]) * cos(p[0]);
        assert_true(fabs(pel_volume_get(&v, i, 5, 9, 0) - expected) < 1e-6);
    }
    assert_true(v.range[1] <= 1.5 + 1e-6 && v.range[1] > 1.49);
    pel_volume_finish(&v);
}

static void test_shepp_logan(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("shepp-logan", "size", "101", "subvoxels", "1");
    assert_true(v.range[0] == 0 && v.range[1] == 1);
    assert_true(pel_volume_get(&v, 0, 0, 0, 0) == 0);                           /* air */
    assert_true(pel_volume_get(&v, 50, 95, 50, 0) == 1);                        /* (0, 0.9, 0): skull */
    assert_true(pel_volume_get(&v, 50, 50, 50, 0) == (double)0.2f);             /* the middle: brain */
    assert_true(pel_volume_get(&v, 61, 50, 50, 0) == 0);                        /* (0.22, 0, 0): ventricle */
    assert_true(pel_volume_get(&v, 39, 50, 50, 0) == 0);                        /* (-0.22, 0, 0): the other */
    assert_true(pel_volume_get(&v, 50, 68, 42, 0) == (double)0.3f);             /* (0, 0.36, -0.16): the large lesion */
    assert_true(pel_volume_get(&v, 46, 20, 50, 0) == (double)0.3f);             /* (-0.08, -0.6, 0): a small one */
    /* The ventricles lean towards each other at the bottom: (0.16, -0.2) is inside the right one, (0.32, -0.2) is not. */
    assert_true(pel_volume_get(&v, 58, 40, 50, 0) == 0 && pel_volume_get(&v, 66, 40, 50, 0) == (double)0.2f);
    pel_volume_finish(&v);
    v = MAKE("shepp-logan", "size", "40", "subvoxels", "4"); /* mean density: volumes of the ellipsoids by their densities */
    double volumes[] = { 0.69 * 0.92 * 0.81, -0.8 * 0.6624 * 0.874 * 0.78, -0.2 * 0.11 * 0.31 * 0.22, -0.2 * 0.16 * 0.41 * 0.28,
                         0.1 * 0.21 * 0.25 * 0.41 }, expected = 0;
    for (int i = 0; i < 5; i++)
        expected += volumes[i] * 4 / 3 * PEL_PI;
    assert_true(fabs(integral(&v) - expected) < 0.005 * expected);
    pel_volume_finish(&v);
}

static void test_abc(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("abc", "size", "33", "a", "2", "b", "3", "c", "5");
    assert_int_equal(v.components, 3);
    assert_true(fabs(v.origin[0]) < 1e-12 && fabs(v.spacing[0] * 32 - 2 * PEL_PI) < 1e-12);
    assert_true(fabs(pel_volume_get(&v, 0, 0, 8, 0) - 7) < 1e-6); /* A sin(pi/2) + C cos 0 */
    assert_true(fabs(pel_volume_get(&v, 8, 0, 0, 1) - 5) < 1e-6); /* B sin(pi/2) + A cos 0 */
    assert_true(fabs(pel_volume_get(&v, 0, 8, 0, 2) - 8) < 1e-6); /* C sin(pi/2) + B cos 0 */
    for (size_t z = 1; z < 32; z++)
        for (size_t y = 1; y < 32; y++)
            for (size_t x = 1; x < 32; x++) { /* each component is constant along its own axis, so this is exact */
                double du = pel_volume_get(&v, x + 1, y, z, 0) - pel_volume_get(&v, x - 1, y, z, 0);
                double dv = pel_volume_get(&v, x, y + 1, z, 1) - pel_volume_get(&v, x, y - 1, z, 1);
                double dw = pel_volume_get(&v, x, y, z + 1, 2) - pel_volume_get(&v, x, y, z - 1, 2);
                assert_true(du == 0 && dv == 0 && dw == 0);
            }
    pel_volume_finish(&v);
}

/* Values worked out by hand from the formula's steps, and a field that turns with time. */
static void test_tornado(void **state)
{
    (void)state;
    struct pel_volume v = MAKE("tornado", "size", "11"), later = MAKE("tornado", "size", "11", "time", "20");
    assert_int_equal(v.components, 3);
    assert_true(v.origin[2] == 0 && fabs(v.spacing[0] - 0.1) < 1e-12);
    /* z = 0: centre (0.5, 0.6), funnel 0.1, wall 0.2, lift 0.01. At (0.7, 0.6): d = 0.2, |0.1 - 0.2| within the wall,
     * q = sqrt(0.0401), swirl = (0.3 - q) / q */
    double q = sqrt(0.0401), swirl = (0.3 - q) / q;
    assert_true(fabs(pel_volume_get(&v, 7, 6, 0, 0) - 0.02) < 1e-6);
    assert_true(fabs(pel_volume_get(&v, 7, 6, 0, 1) + swirl * 0.2) < 1e-6);
    assert_true(fabs(pel_volume_get(&v, 7, 6, 0, 2) - swirl * 0.01) < 1e-6);
    /* At (0.5, 0): d = 0.6, |0.1 - 0.6| = 0.5 beyond the wall: damping 0.3; q = sqrt(0.3601), swirl (0.3 - q) 0.3 / q, dy = -0.6 */
    q = sqrt(0.3601), swirl = (0.3 - q) * 0.3 / q;
    assert_true(fabs(pel_volume_get(&v, 5, 0, 0, 0) + swirl * 0.6) < 1e-6);
    assert_true(fabs(pel_volume_get(&v, 5, 0, 0, 1) + 0.06) < 1e-6);
    assert_true(checksum(&v) != checksum(&later));
    assert_true(v.range[1] < 1);
    pel_volume_finish(&v);
    pel_volume_finish(&later);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formulas),
        cmocka_unit_test(test_list),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_size_limits),
        cmocka_unit_test(test_hydrogen_integral),
        cmocka_unit_test(test_hydrogen_textbook),
        cmocka_unit_test(test_hydrogen_symmetry),
        cmocka_unit_test(test_hydrogen_large_numbers),
        cmocka_unit_test(test_hydrogen_refuses),
        cmocka_unit_test(test_marschner_lobb),
        cmocka_unit_test(test_sphere_radius),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_gyroid),
        cmocka_unit_test(test_shepp_logan),
        cmocka_unit_test(test_abc),
        cmocka_unit_test(test_tornado),
    };
    return cmocka_run_group_tests_name("dataset", tests, NULL, NULL);
}
