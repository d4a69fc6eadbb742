/* SPDX-License-Identifier: MIT */
/* Volumes: storage, types, placement, ranges with voids, magnitudes, and what the check refuses. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/volume.h>

static struct pel_volume make(size_t x, size_t y, size_t z, enum pel_type type, int components)
{
    struct pel_volume v;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ x, y, z }, type, components, NULL));
    return v;
}

/* Stores a number in any type. */
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

static void test_empty(void **state)
{
    (void)state;
    struct pel_volume v;
    pel_volume_init(&v);
    assert_int_equal(pel_volume_samples(&v), 0);
    assert_int_equal(pel_volume_bytes(&v), 0);
    assert_false(pel_volume_check(&v, NULL));
    pel_volume_update_range(&v);
    assert_false(pel_volume_detect_labels(&v));
    pel_volume_finish(&v);
    pel_volume_finish(&v);
}

static void test_allocate(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume v = make(3, 4, 5, PEL_I16, 2);
    assert_int_equal(pel_volume_samples(&v), 60);
    assert_int_equal(pel_volume_bytes(&v), 240);
    for (size_t i = 0; i < 240; i++)
        assert_int_equal(((char *)v.data)[i], 0);
    assert_true(pel_volume_check(&v, &error));

    assert_false(pel_volume_allocate(&v, (size_t[3]){ 3, 0, 5 }, PEL_U8, 1, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_false(pel_volume_allocate(&v, (size_t[3]){ 3, 4, 5 }, PEL_U8, 5, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_false(pel_volume_allocate(&v, (size_t[3]){ 3, 4, 5 }, PEL_U8, 0, &error));
    assert_false(pel_volume_allocate(&v, (size_t[3]){ 3, 4, 5 }, PEL_TYPE_COUNT, 1, &error));
    assert_false(pel_volume_allocate(&v, (size_t[3]){ (size_t)1 << 32, (size_t)1 << 32, 2 }, PEL_U8, 1, &error));
    assert_int_equal(error.code, PEL_ERROR_MEMORY);
    assert_false(pel_volume_allocate(&v, (size_t[3]){ (size_t)1 << 31, (size_t)1 << 30, 4 }, PEL_F64, 1, &error));
    assert_int_equal(error.code, PEL_ERROR_MEMORY);
    assert_int_equal(pel_volume_bytes(&v), 240); /* a failure leaves what was there */
    assert_true(pel_volume_allocate(&v, (size_t[3]){ 1, 1, 1 }, PEL_U8, 1, &error));
    pel_volume_finish(&v);
    assert_null(v.data);
}

static void test_types(void **state)
{
    (void)state;
    static const size_t sizes[] = { 1, 1, 2, 2, 4, 4, 4, 8 };
    for (int t = 0; t < PEL_TYPE_COUNT; t++) {
        assert_int_equal(pel_type_size((enum pel_type)t), sizes[t]);
        assert_int_equal(pel_type_from_name(pel_type_name((enum pel_type)t)), t);
    }
    assert_int_equal(pel_type_from_name("unsigned char"), PEL_U8);
    assert_int_equal(pel_type_from_name("UInt16"), PEL_U16);
    assert_int_equal(pel_type_from_name("Float32"), PEL_F32);
    assert_int_equal(pel_type_from_name("short"), PEL_I16);
    assert_int_equal(pel_type_from_name("double"), PEL_F64);
    assert_int_equal(pel_type_from_name("unsigned int"), PEL_U32);
    assert_int_equal(pel_type_from_name("long"), PEL_TYPE_COUNT);
    assert_int_equal(pel_type_from_name(""), PEL_TYPE_COUNT);
}

static void test_get(void **state)
{
    (void)state;
    for (int t = 0; t < PEL_TYPE_COUNT; t++) {
        struct pel_volume v = make(3, 4, 5, (enum pel_type)t, 2);
        for (size_t i = 0; i < 120; i++)
            put(&v, i, (double)i);
        assert_true(pel_volume_get(&v, 0, 0, 0, 1) == 1);
        assert_true(pel_volume_get(&v, 1, 0, 0, 0) == 2);
        assert_true(pel_volume_get(&v, 0, 1, 0, 0) == 6);
        assert_true(pel_volume_get(&v, 0, 0, 1, 0) == 24);
        assert_true(pel_volume_get(&v, 2, 3, 4, 1) == 119);
        pel_volume_finish(&v);
    }
}

static void set_sheared(struct pel_volume *v)
{
    v->origin[0] = 10, v->origin[1] = -20, v->origin[2] = 30;
    v->spacing[0] = 0.5, v->spacing[1] = 2, v->spacing[2] = 3;
    memcpy(v->direction, (double[3][3]){ { 0, 1, 0 }, { -0.6, 0.8, 0 }, { 0, 0.6, 0.8 } }, sizeof v->direction);
}

static void test_placement(void **state)
{
    (void)state;
    struct pel_volume v = make(5, 6, 7, PEL_U8, 1);
    set_sheared(&v);
    assert_true(pel_volume_check(&v, NULL));
    double index[3] = { 1.5, 2.5, -3.25 }, world[3], back[3], m[3][4];
    pel_volume_index_to_world(&v, index, world);
    assert_true(fabs(world[0] - (10 - 0.6 * 2 * 2.5)) < 1e-12);
    assert_true(fabs(world[1] - (-20 + 0.5 * 1.5 + 0.8 * 2 * 2.5 - 0.6 * 3 * 3.25)) < 1e-12);
    assert_true(fabs(world[2] - (30 - 0.8 * 3 * 3.25)) < 1e-12);
    pel_volume_world_to_index(&v, world, back);
    pel_volume_matrix(&v, m);
    for (int i = 0; i < 3; i++) {
        assert_true(fabs(back[i] - index[i]) < 1e-12);
        assert_true(fabs(m[i][0] * index[0] + m[i][1] * index[1] + m[i][2] * index[2] + m[i][3] - world[i]) < 1e-12);
    }
    pel_volume_index_to_world(&v, index, index); /* in place */
    assert_true(index[0] == world[0] && index[2] == world[2]);

    double b[6];
    pel_volume_bounds(&v, b);
    assert_true(fabs(b[0] - (10 - 6)) < 1e-12 && fabs(b[1] - 10) < 1e-12);
    assert_true(fabs(b[2] + 20) < 1e-12 && fabs(b[3] - (-20 + 2 + 8 + 10.8)) < 1e-12);
    assert_true(fabs(b[4] - 30) < 1e-12 && fabs(b[5] - (30 + 14.4)) < 1e-12);
    assert_true(fabs(pel_volume_mean_spacing(&v) - 5.5 / 3) < 1e-12);
    assert_true(pel_volume_least_spacing(&v) == 0.5);
    pel_volume_finish(&v);
}

static void test_tiny_spacing_inverts(void **state)
{
    (void)state;
    struct pel_volume v = make(5, 6, 7, PEL_U8, 1);
    v.spacing[0] = v.spacing[1] = v.spacing[2] = 1e-60;
    double index[3] = { 1, 2, 3 }, world[3], back[3];
    assert_true(pel_volume_check(&v, NULL));
    pel_volume_index_to_world(&v, index, world);
    pel_volume_world_to_index(&v, world, back);
    for (int i = 0; i < 3; i++)
        assert_true(fabs(back[i] - index[i]) < 1e-12);
    pel_volume_finish(&v);
}

/* A lone image is as thick as its spacing says. */
static void test_bounds_of_an_image(void **state)
{
    (void)state;
    struct pel_volume v = make(4, 1, 3, PEL_U8, 1);
    v.spacing[1] = 4;
    double b[6];
    pel_volume_bounds(&v, b);
    assert_true(b[0] == 0 && b[1] == 3 && b[2] == -2 && b[3] == 2 && b[4] == 0 && b[5] == 2);
    pel_volume_finish(&v);
}

static void test_check_refuses(void **state)
{
    (void)state;
    for (int fault = 0; fault < 9; fault++) {
        struct pel_error error = PEL_ERROR_INIT;
        struct pel_volume v = make(2, 2, 2, PEL_U8, 1);
        assert_true(pel_volume_check(&v, &error));
        switch (fault) {
        case 0: v.origin[1] = NAN; break;
        case 1: v.spacing[2] = 0; break;
        case 2: v.spacing[0] = -1; break;
        case 3: v.spacing[0] = INFINITY; break;
        case 4: v.direction[0][0] = 2; break;
        case 5: memcpy(v.direction[1], v.direction[0], sizeof v.direction[0]); break;
        case 6: v.components = 5; break;
        case 7: v.direction[2][2] = NAN; break;
        case 8: v.type = PEL_TYPE_COUNT; break;
        }
        if (pel_volume_check(&v, &error))
            fail_msg("fault %d was let through", fault);
        assert_true(error.code != PEL_ERROR_NONE && error.message[0]);
        pel_volume_finish(&v);
    }
}

static void test_spaces(void **state)
{
    (void)state;
    struct pel_volume v = make(2, 3, 4, PEL_U8, 1);
    double at[3] = { 1, 2, 3 }, before[3], after[3];
    set_sheared(&v);
    pel_volume_index_to_world(&v, at, before);
    pel_volume_to_space(&v, PEL_SPACE_LPS); /* from unknown: the word alone */
    pel_volume_index_to_world(&v, at, after);
    assert_memory_equal(before, after, sizeof before);
    assert_string_equal(pel_space_name(v.space), "LPS");
    pel_volume_to_space(&v, PEL_SPACE_RAS);
    pel_volume_index_to_world(&v, at, after);
    assert_true(fabs(after[0] + before[0]) < 1e-12 && fabs(after[1] + before[1]) < 1e-12 && after[2] == before[2]);
    assert_string_equal(pel_space_name(v.space), "RAS");
    assert_true(pel_volume_check(&v, NULL));
    pel_volume_to_space(&v, PEL_SPACE_RAS);
    pel_volume_to_space(&v, PEL_SPACE_LPS);
    pel_volume_index_to_world(&v, at, after);
    assert_memory_equal(before, after, sizeof before);
    pel_volume_finish(&v);
}

/* The extremes sit at odd places of a volume of several slabs. */
static void test_range(void **state)
{
    (void)state;
    static const double lo[] = { 1, -120, 1, -30000, 1, -2e9, -1.5, -1e300 }, hi[] = { 250, 120, 65000, 30000, 4e9, 2e9, 1e30, 1e300 };
    for (int t = 0; t < PEL_TYPE_COUNT; t++) {
        struct pel_volume v = make(71, 67, 61, (enum pel_type)t, 1);
        size_t n = pel_volume_samples(&v);
        for (size_t i = 0; i < n; i++)
            put(&v, i, 5);
        put(&v, n - 1, lo[t]);
        put(&v, n / 3, hi[t]);
        pel_volume_update_range(&v);
        assert_true(v.range[0] == lo[t]);
        assert_true(v.range[1] == (t == PEL_F32 ? (double)1e30f : hi[t]));
        v.has_void = true;
        v.void_value = lo[t];
        pel_volume_update_range(&v);
        assert_true(v.range[0] == 5);
        assert_true(pel_volume_is_void(&v, lo[t]) && pel_volume_is_void(&v, NAN) && !pel_volume_is_void(&v, 5));
        pel_volume_finish(&v);
    }
}

static void test_range_leaves_out_nan_and_infinity(void **state)
{
    (void)state;
    for (int t = PEL_F32; t <= PEL_F64; t++) {
        struct pel_volume v = make(9, 9, 9, (enum pel_type)t, 1);
        for (size_t i = 0; i < 729; i++)
            put(&v, i, i % 3 == 0 ? NAN : i % 3 == 1 ? INFINITY : -INFINITY);
        pel_volume_update_range(&v);
        assert_true(v.range[0] == 0 && v.range[1] == 0);
        put(&v, 400, -7);
        pel_volume_update_range(&v);
        assert_true(v.range[0] == -7 && v.range[1] == -7);
        pel_volume_finish(&v);
    }
}

/* A float void that is no float: -9999.9 in a header means the sample nearest to it. */
static void test_void_of_floats(void **state)
{
    (void)state;
    struct pel_volume v = make(2, 2, 2, PEL_F32, 1);
    put(&v, 3, -9999.9);
    v.has_void = true;
    v.void_value = -9999.9;
    pel_volume_update_range(&v);
    assert_true(v.range[0] == 0 && v.range[1] == 0);
    assert_true(pel_volume_is_void(&v, pel_volume_get(&v, 1, 1, 0, 0)));
    pel_volume_finish(&v);
}

static void test_magnitude(void **state)
{
    (void)state;
    struct pel_volume field = make(70, 80, 30, PEL_I16, 3), m;
    size_t n = pel_volume_samples(&field);
    for (size_t i = 0; i < n; i++) {
        put(&field, 3 * i, (double)(i % 100) * 2);
        put(&field, 3 * i + 1, (double)(i % 100) * -3);
        put(&field, 3 * i + 2, (double)(i % 100) * 6);
    }
    set_sheared(&field);
    field.space = PEL_SPACE_LPS;
    strcpy(field.units, "mm");
    strcpy(field.name, "wind");
    pel_volume_update_range(&field);
    assert_true(field.range[0] == 0 && field.range[1] == 693);
    pel_volume_init(&m);
    assert_true(pel_volume_magnitude(&field, &m, NULL));
    assert_int_equal(m.type, PEL_F32);
    assert_int_equal(m.components, 1);
    assert_true(m.range[1] == 693 && m.space == PEL_SPACE_LPS && m.spacing[2] == 3 && m.direction[2][1] == 0.6);
    assert_string_equal(m.units, "mm");
    assert_string_equal(m.name, "wind");
    for (size_t i = 0; i < n; i++)
        assert_true(((float *)m.data)[i] == (float)(i % 100) * 7);
    pel_volume_finish(&m);

    field.has_void = true; /* one void component makes the sample void */
    field.void_value = -3;
    assert_true(pel_volume_magnitude(&field, &m, NULL));
    assert_true(isnan(((float *)m.data)[1]) && isnan(((float *)m.data)[101]) && ((float *)m.data)[2] == 14);
    pel_volume_finish(&m);
    pel_volume_finish(&field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_empty),
        cmocka_unit_test(test_allocate),
        cmocka_unit_test(test_types),
        cmocka_unit_test(test_get),
        cmocka_unit_test(test_placement),
        cmocka_unit_test(test_tiny_spacing_inverts),
        cmocka_unit_test(test_bounds_of_an_image),
        cmocka_unit_test(test_check_refuses),
        cmocka_unit_test(test_spaces),
        cmocka_unit_test(test_range),
        cmocka_unit_test(test_range_leaves_out_nan_and_infinity),
        cmocka_unit_test(test_void_of_floats),
        cmocka_unit_test(test_magnitude),
    };
    return cmocka_run_group_tests_name("volume", tests, NULL, NULL);
}
