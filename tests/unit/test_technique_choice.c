/* SPDX-License-Identifier: MIT */
/* Techniques with their options as text: there and back, and what must be refused without changing anything. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/renderer.h>

/* A value that the option takes and that is not its default. */
static void another(const struct pel_option *row, char *text, size_t size)
{
    switch (row->type) {
    case PEL_OPTION_BOOL: snprintf(text, size, strcmp(row->fallback, "true") == 0 ? "false" : "true"); break;
    case PEL_OPTION_CHOICE: snprintf(text, size, "%s", row->choices[strcmp(row->fallback, row->choices[0]) == 0]); break;
    case PEL_OPTION_COLOR: snprintf(text, size, "0.12549019607843137,0.33333333333333331,0.66666666666666663,0.1"); break;
    default:
        snprintf(text, size, "%g", row->minimum == 0 ? row->maximum / 4 : 2 * row->minimum);
        if (strcmp(text, row->fallback) == 0)
            snprintf(text, size, "%g", row->minimum);
    }
}

static void test_round_trip(void **state)
{
    (void)state;
    struct pel_renderer *from = pel_renderer_create(NULL, NULL), *to = pel_renderer_create(NULL, NULL);
    const struct pel_technique_info *technique;
    struct pel_error error = PEL_ERROR_INIT;
    int options = 0;
    for (size_t i = 0; (technique = pel_technique_at(i)); i++) {
        struct pel_technique_choice choice, back;
        void *object = pel_renderer_options(from, technique->name);
        for (const struct pel_option *row = technique->options; row->name; row++, options++) {
            char text[256];
            another(row, text, sizeof text);
            if (!pel_option_set(row, object, text, &error))
                fail_msg("%s: %s", technique->name, error.message);
        }
        pel_technique_tell(technique, object, &choice);
        assert_string_equal(choice.name, technique->name);
        if (!pel_renderer_take_technique(NULL, &choice, &error) || !pel_renderer_take_technique(to, &choice, &error))
            fail_msg("%s: %s", technique->name, error.message);
        pel_technique_tell(technique, pel_renderer_options(to, technique->name), &back);
        assert_memory_equal(&choice, &back, sizeof choice);
        for (const struct pel_option *row = technique->options; row->name; row++) {
            char text[2][256];
            pel_option_get(row, object, text[0], sizeof text[0]);
            pel_option_get(row, pel_renderer_options(to, technique->name), text[1], sizeof text[1]);
            assert_string_equal(text[0], text[1]);
        }
    }
    assert_true(options > 0);
    pel_renderer_destroy(from);
    pel_renderer_destroy(to);
}

static void test_refusals(void **state)
{
    (void)state;
    const struct {
        struct pel_technique_choice choice;
        const char *message;
    } bad[] = {
        { { .name = "raymarch" }, "technique.name: there is no raymarch; there are: raycast" },
        { { .name = "raycast", .option_count = 1, .options = { { "rays", "1" } } }, "technique.options.rays: raycast has no such option" },
        { { .name = "slices2d", .option_count = 2, .options = { { "rays", "3" }, { "ray", "1" } } }, "technique.options.ray: slices2d" },
        { { .name = "slices2d", .option_count = 2, .options = { { "rays", "3" }, { "blend", "99" } } }, "technique.options.blend: " },
        { { .name = "slices2d", .option_count = 1, .options = { { "surface", "shiny" } } }, "technique.options.surface: " },
    };
    struct pel_renderer *renderer = pel_renderer_create(NULL, NULL);
    struct pel_technique_choice before, after;
    const struct pel_technique_info *technique = pel_technique_find("slices2d");
    pel_technique_tell(technique, pel_renderer_options(renderer, "slices2d"), &before);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        for (int check = 0; check < 2; check++) {
            struct pel_error error = PEL_ERROR_INIT;
            assert_false(pel_renderer_take_technique(check ? NULL : renderer, &bad[i].choice, &error));
            if (strncmp(error.message, bad[i].message, strlen(bad[i].message)) != 0)
                fail_msg("%s", error.message);
        }
    pel_technique_tell(technique, pel_renderer_options(renderer, "slices2d"), &after);
    assert_memory_equal(&before, &after, sizeof before);
    assert_true(pel_renderer_take_technique(renderer, &(struct pel_technique_choice) { .name = "" }, NULL)); /* not said */
    pel_renderer_destroy(renderer);
}

/* Whether a scene can be drawn is known before it is. */
static void test_check(void **state)
{
    (void)state;
    const struct {
        const char *name;
        enum pel_mode mode;
        enum pel_classification classification;
        bool gpu;
        const char *message; /* NULL: it can */
    } cases[] = {
        { "", PEL_MODE_MIP, PEL_CLASSIFICATION_PREINTEGRATED, false, NULL },
        { "raycast", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, false, NULL },
        { "auto", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, true, NULL },
        { "reference", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, true, NULL },
        { "slices2d", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, false, NULL },
        { "slices2d", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PRE, false, "slices2d classifies after interpolation" },
        { "slices2d", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PRE, true, NULL },
        { "slices2d", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PREINTEGRATED, true, "slices2d cannot pre-integrate" },
        { "slices2d", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, false, "slices2d draws mode composite alone" },
        { "slices2d", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, true, NULL },
        { "slices2d", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, true, "slices2d draws the modes" },
        { "slices3d", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, true, "slices3d draws mode composite alone" },
        { "mesh", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, true, NULL },
        { "mesh", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, false, "technique.name: mesh draws on a GPU alone" },
        { "mesh", PEL_MODE_SLICE, PEL_CLASSIFICATION_POST, true, "mesh draws mode isosurface alone" },
        { "peel", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, true, "peel draws mode isosurface alone" },
        { "raymarch", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, true, "technique.name: there is no raymarch" },
    };
    const struct pel_volume volume = { .dims = { 8, 8, 8 } };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct pel_error error = PEL_ERROR_INIT;
        struct pel_scene scene;
        assert_true(pel_scene_init(&scene, &error));
        scene.volume = &volume;
        scene.render.mode = cases[i].mode;
        scene.render.classification = cases[i].classification;
        strcpy(scene.technique.name, cases[i].name);
        bool can = pel_technique_check(&scene, cases[i].gpu, &error);
        if (can != !cases[i].message || strncmp(error.message, can ? "" : cases[i].message, can ? 1 : strlen(cases[i].message)) != 0)
            fail_msg("%zu: %s: %s", i, cases[i].name, error.message);
        pel_scene_finish(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_round_trip), cmocka_unit_test(test_refusals), cmocka_unit_test(test_check) };
    return cmocka_run_group_tests_name("technique_choice", tests, NULL, NULL);
}
