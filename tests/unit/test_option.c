/* SPDX-License-Identifier: MIT */
/* Options: every type read and written, what is refused, and that the field stays as it was then. */
#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/pellucid.h>

struct all {
    bool flag;
    int integer, choice, size[2];
    double number, open, pair[2], vector[3], six[6], color[4];
    char text[PEL_OPTION_TEXT_SIZE];
};

static const char *const choices[] = { "red", "green", "blue", NULL };

#define AT(field) offsetof(struct all, field)
static const struct pel_option table[] = {
    { "flag", "Flag", "A flag", PEL_OPTION_BOOL, AT(flag), 0, 1, "false", NULL, NULL },
    { "integer", "Integer", "An integer", PEL_OPTION_INT, AT(integer), -5, 100, "7", NULL, "things" },
    { "number", "Number", "A number", PEL_OPTION_DOUBLE, AT(number), 0, 10, "0.1", NULL, "voxels" },
    { "open", "Open", "A number without limits", PEL_OPTION_DOUBLE, AT(open), -DBL_MAX, DBL_MAX, NULL, NULL, NULL },
    { "choice", "Choice", "A choice", PEL_OPTION_CHOICE, AT(choice), 0, 0, "green", choices, NULL },
    { "pair", "Pair", "Two numbers", PEL_OPTION_VEC2, AT(pair), -10, 10, "1,2", NULL, NULL },
    { "vector", "Vector", "Three numbers", PEL_OPTION_VEC3, AT(vector), -10, 10, "1,2,3", NULL, NULL },
    { "six", "Six", "Six numbers", PEL_OPTION_VEC6, AT(six), -10, 10, "1,2,3,4,5,6", NULL, NULL },
    { "color", "Colour", "A colour", PEL_OPTION_COLOR, AT(color), 0, 1, "black", NULL, NULL },
    { "size", "Size", "A size", PEL_OPTION_SIZE, AT(size), 1, 32768, "512", NULL, "pixels" },
    { "text", "Text", "A text", PEL_OPTION_TEXT, AT(text), 0, 0, "hello", NULL, NULL },
    { NULL },
};

static bool set(struct all *object, const char *name, const char *text)
{
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_option *row = pel_option_find(table, name);
    assert_non_null(row);
    bool good = pel_option_set(row, object, text, &error);
    if (!good) {
        assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
        assert_memory_equal(error.message, name, strlen(name)); /* every error begins with the option's name */
        assert_null(strchr(error.message, '\n'));
    }
    return good;
}

static void test_find(void **state)
{
    (void)state;
    assert_string_equal(pel_option_find(table, "pair")->label, "Pair");
    assert_null(pel_option_find(table, "pai"));
    assert_null(pel_option_find(table, ""));
    assert_null(pel_option_find(NULL, "pair"));
}

static void test_defaults(void **state)
{
    (void)state;
    struct all a = { .open = 42 };
    pel_option_defaults(table, &a);
    assert_false(a.flag);
    assert_int_equal(a.integer, 7);
    assert_true(a.number == 0.1);
    assert_true(a.open == 42); /* no default: left alone */
    assert_int_equal(a.choice, 1);
    assert_true(a.pair[1] == 2 && a.vector[2] == 3 && a.six[5] == 6);
    assert_true(a.color[0] == 0 && a.color[3] == 1);
    assert_int_equal(a.size[1], 512);
    assert_string_equal(a.text, "hello");
}

static void test_good_texts(void **state)
{
    (void)state;
    struct all a = { 0 };
    assert_true(set(&a, "flag", "on") && a.flag);
    assert_true(set(&a, "flag", "No") && !a.flag);
    assert_true(set(&a, "flag", NULL) && a.flag); /* a flag without a value */
    assert_true(set(&a, "integer", "-5") && a.integer == -5);
    assert_true(set(&a, "number", "1e1") && a.number == 10);
    assert_true(set(&a, "open", "-1.7976931348623157e308") && a.open == -DBL_MAX);
    assert_true(set(&a, "choice", "BLUE") && a.choice == 2);
    assert_true(set(&a, "pair", "0.5, -0.25") && a.pair[0] == 0.5 && a.pair[1] == -0.25);
    assert_true(set(&a, "vector", "3,2,1") && a.vector[0] == 3 && a.vector[2] == 1);
    assert_true(set(&a, "six", "6,5,4,3,2,1") && a.six[0] == 6 && a.six[5] == 1);
    assert_true(set(&a, "color", "#ff000080") && a.color[0] == 1 && a.color[1] == 0 && a.color[3] == 128 / 255.0);
    assert_true(set(&a, "color", "0.1,0.2,0.3") && a.color[2] == 0.3 && a.color[3] == 1);
    assert_true(set(&a, "color", "0.1,0.2,0.3,0.4") && a.color[3] == 0.4);
    assert_true(set(&a, "color", "transparent") && a.color[3] == 0);
    assert_true(set(&a, "color", "white") && a.color[1] == 1 && a.color[3] == 1);
    assert_true(set(&a, "color", "gray") && a.color[1] == 0.5 && a.color[3] == 1);
    assert_true(set(&a, "color", "Orange") && a.color[0] == 1 && a.color[1] == 165 / 255.0 && a.color[2] == 0 && a.color[3] == 1);
    assert_true(set(&a, "color", "navy") && a.color[0] == 0 && a.color[2] == 128 / 255.0);
    assert_true(set(&a, "color", "#f08") && a.color[0] == 1 && a.color[1] == 0 && a.color[2] == 136 / 255.0 && a.color[3] == 1);
    assert_true(set(&a, "color", "#F083") && a.color[2] == 136 / 255.0 && a.color[3] == 0.2);
    assert_true(set(&a, "size", "1024x768") && a.size[0] == 1024 && a.size[1] == 768);
    assert_true(set(&a, "size", "64") && a.size[0] == 64 && a.size[1] == 64);
    assert_true(set(&a, "text", "") && a.text[0] == 0);
}

static void test_bad_texts(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } bad[] = {
        { "flag", "" },          { "flag", "maybe" },       { "flag", "2" },          { "integer", "" },       { "integer", "1.5" },
        { "integer", "101" },    { "integer", "-6" },       { "integer", "seven" },   { "integer", "9999999999999999999" },
        { "integer", "7x" },     { "number", "" },          { "number", "nan" },      { "number", "inf" },     { "number", "-0.001" },
        { "number", "10.01" },   { "number", "1,2" },       { "number", "1 2" },      { "number", "1e999" },   { "number", "0,5" },
        { "open", "nan" },       { "open", "-inf" },        { "choice", "" },         { "choice", "re" },      { "choice", "0" },
        { "pair", "1" },         { "pair", "1,2,3" },       { "pair", "1,11" },       { "pair", "1,,2" },      { "pair", "1,2," },
        { "vector", "1,2" },     { "vector", ",1,2" },      { "vector", "1,2,nan" },  { "vector", "1,2,3,4" },
        { "six", "1,2,3,4,5" },  { "six", "1,2,3,4,5,6,7" }, { "color", "" },         { "color", "reddish" },  { "color", "#12345" },
        { "color", "#12345g" },  { "color", "1,1" },        { "color", "1,1,1.5" },   { "color", "-1,0,0" },   { "color", "0,0,0,0,0" },
        { "size", "" },          { "size", "0" },           { "size", "x" },          { "size", "10x" },       { "size", "x10" },
        { "size", "10x10x10" },  { "size", "40000" },       { "size", "-5x5" },       { "size", "10 x 10" },   { "size", "1e3" },
        { "integer", NULL },     { "text", NULL },          { "size", "99999999999x1" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct all a = { 0 }, before;
        pel_option_defaults(table, &a);
        before = a;
        if (set(&a, bad[i].name, bad[i].text))
            fail_msg("%s took \"%s\"", bad[i].name, bad[i].text);
        assert_memory_equal(&a, &before, sizeof a);
    }
}

static void test_long_texts(void **state)
{
    (void)state;
    static char text[3 * PEL_OPTION_TEXT_SIZE];
    struct all a = { 0 };
    memset(text, 'a', PEL_OPTION_TEXT_SIZE - 1);
    assert_true(set(&a, "text", text));
    assert_string_equal(a.text, text);
    memset(text, '1', sizeof text - 1);
    for (const struct pel_option *row = table; row->name; row++)
        assert_false(set(&a, row->name, text));
}

static void test_errors_tell_what_is_allowed(void **state)
{
    (void)state;
    struct all a = { 0 };
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_option_set(pel_option_find(table, "number"), &a, "11", &error));
    assert_string_equal(error.message, "number: \"11\" is not a number from 0 to 10 voxels");
    assert_false(pel_option_set(pel_option_find(table, "choice"), &a, "pink", &error));
    assert_string_equal(error.message, "choice: \"pink\" is not one of red, green, blue");
    assert_false(pel_option_set(pel_option_find(table, "open"), &a, "?", &error));
    assert_string_equal(error.message, "open: \"?\" is not a number");
    assert_false(pel_option_set(pel_option_find(table, "choice"), &a, "pink", NULL));
}

/* Writing and reading gives the same bits, for numbers that are hard to write too. */
static void test_round_trip(void **state)
{
    (void)state;
    static const double numbers[] = { 0, -0.0, 0.1, 1.0 / 3, 1e-300, 1.7976931348623157e308, 4.9e-324, 123456789.123456789, -2.5 };
    const struct pel_option *row = pel_option_find(table, "open");
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        struct all a = { .open = numbers[i] }, b = { .open = 1 };
        char text[64];
        int length = pel_option_get(row, &a, text, sizeof text);
        assert_int_equal(length, (int)strlen(text));
        assert_true(pel_option_set(row, &b, text, NULL));
        assert_memory_equal(&a.open, &b.open, sizeof a.open);
    }
    struct all a = { .flag = true, .integer = -3, .choice = 2, .size = { 640, 480 }, .number = 0.1, .open = 1e10, .pair = { 0.1, 0.2 },
                     .vector = { 1, 1.0 / 3, -1 }, .six = { 1, 2, 3, 4, 5, 2.0 / 3 }, .color = { 0.1, 0.2, 0.3, 0.4 }, .text = "a b,c" };
    struct all b = { 0 };
    for (row = table; row->name; row++) {
        char text[PEL_OPTION_TEXT_SIZE];
        pel_option_get(row, &a, text, sizeof text);
        assert_true(pel_option_set(row, &b, text, NULL));
    }
    assert_true(a.flag == b.flag && a.integer == b.integer && a.choice == b.choice && a.number == b.number && a.open == b.open);
    assert_memory_equal(a.size, b.size, sizeof a.size);
    assert_memory_equal(a.pair, b.pair, sizeof a.pair);
    assert_memory_equal(a.vector, b.vector, sizeof a.vector);
    assert_memory_equal(a.six, b.six, sizeof a.six);
    assert_memory_equal(a.color, b.color, sizeof a.color);
    assert_string_equal(a.text, b.text);
}

static void test_get_like_snprintf(void **state)
{
    (void)state;
    struct all a = { .size = { 1024, 768 }, .choice = 9 };
    char text[4] = "zzz";
    assert_int_equal(pel_option_get(pel_option_find(table, "size"), &a, text, sizeof text), 8);
    assert_string_equal(text, "102");
    assert_int_equal(pel_option_get(pel_option_find(table, "size"), &a, NULL, 0), 8);
    pel_option_get(pel_option_find(table, "choice"), &a, text, sizeof text); /* a field that holds no choice */
    assert_false(set(&a, "choice", text));
}

/* A program with a comma for its decimal point reads and writes points all the same. */
static void test_locale(void **state)
{
    (void)state;
    static const char *const names[] = { "de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8" };
    bool found = false;
    for (int i = 0; i < 4 && !found; i++)
        found = setlocale(LC_ALL, names[i]) != NULL;
    if (!found) {
        print_message("no German or French locale here: skipped\n");
        skip();
    }
    struct all a = { 0 };
    char text[32];
    assert_true(set(&a, "number", "0.5") && a.number == 0.5);
    pel_option_get(pel_option_find(table, "number"), &a, text, sizeof text);
    setlocale(LC_ALL, "C");
    assert_string_equal(text, "0.5");
}

static void check_table(const struct pel_option *rows, void *object, const char *who)
{
    for (const struct pel_option *row = rows; row->name; row++) {
        struct pel_error error = PEL_ERROR_INIT;
        if (row->fallback && !pel_option_set(row, object, row->fallback, &error))
            fail_msg("%s: default: %s", who, error.message);
        assert_non_null(row->label);
        assert_non_null(row->help);
        assert_null(strchr(row->help, '\n'));
        assert_true(strspn(row->name, "abcdefghijklmnopqrstuvwxyz0123456789-") == strlen(row->name));
        assert_true(row->minimum <= row->maximum);
        assert_ptr_equal(pel_option_find(rows, row->name), row); /* no name twice */
        assert_true((row->type == PEL_OPTION_CHOICE) == (row->choices != NULL));
    }
}

/* Every table of the library holds good rows: the defaults are allowed, names are flags. */
static void test_library_tables(void **state)
{
    (void)state;
    struct pel_camera camera = PEL_CAMERA_INIT;
    struct pel_render_settings settings = { 0 };
    check_table(pel_camera_options, &camera, "camera");
    check_table(pel_render_options, &settings, "render");
    assert_true(settings.mode == PEL_MODE_COMPOSITE && settings.step == 0.5 && !settings.jitter && settings.termination == 0.998);
    assert_true(settings.skip && settings.shade && !settings.invert && settings.ambient == 0.3 && settings.diffuse == 0.7);
    assert_true(settings.specular == 0.2 && settings.specular_power == 20 && settings.classification == PEL_CLASSIFICATION_POST);
    for (size_t i = 0; pel_dataset_at(i); i++) {
        void *params = pel_dataset_create_params(pel_dataset_at(i));
        assert_non_null(params);
        check_table(pel_dataset_at(i)->options, params, pel_dataset_at(i)->name);
        free(params);
    }
}

/* Made-up texts into every kind of row: what is taken can be written and read back to the same bytes, what is refused changes nothing. */
static void test_made_up_texts(void **state)
{
    (void)state;
    static const char alphabet[] = "0123456789.,-+eExX# nafinftruo";
    uint32_t seed = 2463534242u;
    int taken = 0;
    for (int round = 0; round < 200000; round++) {
        char text[24], back[PEL_OPTION_TEXT_SIZE];
        struct all a = { 0 }, b;
        seed ^= seed << 13, seed ^= seed >> 17, seed ^= seed << 5;
        const struct pel_option *row = &table[seed % (sizeof table / sizeof *table - 1)];
        size_t length = (seed >> 8) % 12;
        for (size_t i = 0; i < length; i++) {
            seed ^= seed << 13, seed ^= seed >> 17, seed ^= seed << 5;
            text[i] = alphabet[seed % (sizeof alphabet - 1)];
        }
        text[length] = 0;
        b = a;
        if (pel_option_set(row, &a, text, NULL)) {
            taken += row->type != PEL_OPTION_TEXT;
            pel_option_get(row, &a, back, sizeof back);
            assert_true(pel_option_set(row, &b, back, NULL));
        }
        assert_memory_equal(&a, &b, offsetof(struct all, text));
        assert_string_equal(a.text, b.text);
    }
    assert_true(taken > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_find),
        cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_good_texts),
        cmocka_unit_test(test_bad_texts),
        cmocka_unit_test(test_long_texts),
        cmocka_unit_test(test_errors_tell_what_is_allowed),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_get_like_snprintf),
        cmocka_unit_test(test_locale),
        cmocka_unit_test(test_library_tables),
        cmocka_unit_test(test_made_up_texts),
    };
    return cmocka_run_group_tests_name("option", tests, NULL, NULL);
}
