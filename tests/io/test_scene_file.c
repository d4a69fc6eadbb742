/* SPDX-License-Identifier: MIT */
/* Scene files: everything comes back to the last bit, messages name the key, nothing changes on failure, paths follow the file. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scene_file.h"

static struct pel_scene scene;

static int make(void **state)
{
    (void)state;
    return pel_scene_init(&scene, NULL) ? 0 : -1;
}

static int drop(void **state)
{
    (void)state;
    pel_scene_finish(&scene);
    return 0;
}

/* Numbers with all their bits in use. */
static double odd_number(int i)
{
    return sin(i + 1.0) * pow(10, i % 7 - 3);
}

static void fill(struct pel_scene *s)
{
    for (int a = 0; a < 3; a++) {
        s->camera.position[a] = odd_number(a);
        s->camera.focal_point[a] = odd_number(a + 10);
        s->camera.view_up[a] = odd_number(a + 20);
        s->slice.origin[a] = odd_number(a + 30);
        s->slice.normal[a] = odd_number(a + 40);
        for (int i = 0; i < PEL_MAX_SLICES - 1; i++) {
            s->more_slices[i].origin[a] = odd_number(7 * i + a);
            s->more_slices[i].normal[a] = odd_number(5 * i + a + 1);
        }
    }
    s->more_slice_count = PEL_MAX_SLICES - 1;
    s->camera.view_angle = 100 / 3.0;
    s->camera.parallel = true;
    s->camera.parallel_scale = 1 / 3.0;
    s->render.mode = PEL_MODE_ISOSURFACE;
    s->render.step = 0.7 / 3;
    s->render.jitter = true;
    s->render.classification = PEL_CLASSIFICATION_PREINTEGRATED;
    s->render.reconstruction = PEL_RECONSTRUCTION_NEAREST;
    s->render.termination = 1;
    s->render.skip = false;
    s->render.shade = false;
    s->render.ambient = 0.1;
    s->render.invert = true;
    s->isosurface_count = PEL_MAX_ISOSURFACES;
    for (int i = 0; i < PEL_MAX_ISOSURFACES; i++)
        s->isosurfaces[i] = (struct pel_isosurface) { odd_number(i) * 1e30, { 0.1, 1 / 3.0, i / 16.0 }, 1 / (i + 1.0) };
    s->light_count = 3;
    s->lights[0] = (struct pel_light) { false, { 1, -2, 1e-9 }, { 0.5, 0.25, 1 } };
    s->lights[1] = (struct pel_light) { true, { 0, 0, 1 }, { 1, 0.9, 0.8 } };
    s->lights[2] = (struct pel_light) { false, { 0, 0, -1 }, { 0, 0, 0 } };
    s->clip_plane_count = PEL_MAX_CLIP_PLANES;
    for (int i = 0; i < PEL_MAX_CLIP_PLANES; i++)
        s->clip_planes[i] = (struct pel_plane) { { odd_number(i), 0, 1 }, { 0, odd_number(i + 3), 1 } };
    s->clip_box_enabled = true;
    for (int i = 0; i < 6; i++)
        s->clip_box[i] = odd_number(i);
    for (int i = 0; i < 4; i++)
        s->background[i] = 1 / (i + 2.0);
    s->linear_light = true;
    s->technique = (struct pel_technique_choice) { "slices2d", 5, { { "a", "true" }, { "b", "-7" }, { "c", "0.10000000000000001" }, { "d", "#0a1b2c" }, { "e", "voxel" } } };
    assert_true(pel_transfer_set_colormap(&s->transfer, "plasma", -1e-5, 1e5, NULL));
    assert_true(pel_transfer_parse_opacity(&s->transfer, "-1:0,0.1:0.123456789,0.1:1", NULL));
    s->transfer.unit_distance = 1 / 7.0;
}

static void expect_same_scene(const struct pel_scene *a, const struct pel_scene *b)
{
    assert_true(pel_transfer_equal(&a->transfer, &b->transfer));
    assert_memory_equal(a->camera.position, b->camera.position, sizeof a->camera.position);
    assert_memory_equal(a->camera.focal_point, b->camera.focal_point, sizeof a->camera.focal_point);
    assert_memory_equal(a->camera.view_up, b->camera.view_up, sizeof a->camera.view_up);
    assert_true(a->camera.view_angle == b->camera.view_angle && a->camera.parallel == b->camera.parallel);
    assert_true(a->camera.parallel_scale == b->camera.parallel_scale);
    for (const struct pel_option *row = pel_render_options; row->name; row++) {
        char text[2][PEL_OPTION_TEXT_SIZE];
        pel_option_get(row, &a->render, text[0], sizeof text[0]);
        pel_option_get(row, &b->render, text[1], sizeof text[1]);
        assert_string_equal(text[0], text[1]);
    }
    assert_true(a->render.step == b->render.step);
    assert_int_equal(a->isosurface_count, b->isosurface_count);
    assert_memory_equal(a->isosurfaces, b->isosurfaces, sizeof(struct pel_isosurface) * (size_t)a->isosurface_count);
    assert_memory_equal(&a->slice, &b->slice, sizeof a->slice);
    assert_int_equal(a->more_slice_count, b->more_slice_count);
    assert_memory_equal(a->more_slices, b->more_slices, sizeof(struct pel_plane) * (size_t)a->more_slice_count);
    assert_int_equal(a->light_count, b->light_count);
    for (int i = 0; i < a->light_count; i++) {
        assert_int_equal(a->lights[i].headlight, b->lights[i].headlight);
        if (!a->lights[i].headlight)
            assert_memory_equal(a->lights[i].direction, b->lights[i].direction, sizeof a->lights[i].direction);
        assert_memory_equal(a->lights[i].color, b->lights[i].color, sizeof a->lights[i].color);
    }
    assert_int_equal(a->clip_plane_count, b->clip_plane_count);
    assert_memory_equal(a->clip_planes, b->clip_planes, sizeof(struct pel_plane) * (size_t)a->clip_plane_count);
    assert_int_equal(a->clip_box_enabled, b->clip_box_enabled);
    assert_memory_equal(a->clip_box, b->clip_box, sizeof a->clip_box);
    assert_memory_equal(a->background, b->background, sizeof a->background);
    assert_int_equal(a->linear_light, b->linear_light);
    assert_string_equal(a->technique.name, b->technique.name);
    assert_int_equal(a->technique.option_count, b->technique.option_count);
    for (int i = 0; i < a->technique.option_count; i++) {
        assert_string_equal(a->technique.options[i].name, b->technique.options[i].name);
        assert_string_equal(a->technique.options[i].value, b->technique.options[i].value);
    }
}

static void read_scene(const char *path, struct pel_scene *s, struct pel_scene_parts *has)
{
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_read_scene(path, s, has, &error))
        fail_msg("%s", error.message);
}

static void round_trip(void **state)
{
    (void)state;
    struct pel_scene back;
    struct pel_scene_parts has;
    struct pel_error error = PEL_ERROR_INIT;
    fill(&scene);
    snprintf(scene.source.array, sizeof scene.source.array, "velocity \"x\"");
    snprintf(scene.source.raw, sizeof scene.source.raw, "4x4x4:u8");
    scene.source.has_spacing = scene.source.has_void = true;
    memcpy(scene.source.spacing, (double[3]) { 1, 0.3, 1e-9 }, sizeof scene.source.spacing);
    scene.source.void_value = -32768;
    snprintf(scene.source.path, sizeof scene.source.path, "%s", scratch("volume \\ \u00e9.raw"));
    write_text(scene.source.path, "x");
    if (!pel_write_scene(scratch("a.json"), &scene, &error))
        fail_msg("%s", error.message);
    assert_true(pel_scene_init(&back, NULL));
    read_scene(scratch("a.json"), &back, &has);
    expect_same_scene(&scene, &back);
    assert_string_equal(back.source.array, scene.source.array);
    assert_string_equal(back.source.raw, scene.source.raw);
    assert_true(back.source.has_spacing && back.source.has_void && back.source.void_value == -32768);
    assert_memory_equal(back.source.spacing, scene.source.spacing, sizeof scene.source.spacing);
    assert_true(has.transfer && has.colors && has.opacities && has.unit_distance && has.camera && has.isosurfaces && has.slice);
    assert_int_equal(access(back.source.path, R_OK), 0);
    pel_scene_finish(&back);

    pel_scene_finish(&scene); /* the scene as it starts, over a filled one: what the file says replaces what was there */
    assert_true(pel_scene_init(&scene, NULL));
    assert_true(pel_write_scene(scratch("b.json"), &scene, NULL));
    assert_true(pel_scene_init(&back, NULL));
    fill(&back);
    scene.isosurface_count = back.isosurface_count; /* none are not said */
    memcpy(scene.isosurfaces, back.isosurfaces, sizeof back.isosurfaces);
    read_scene(scratch("b.json"), &back, &has);
    if (scene.slice.normal[0] == 0 && scene.slice.normal[1] == 0 && scene.slice.normal[2] == 0)
        scene.slice = back.slice;
    memcpy(scene.clip_box, back.clip_box, sizeof back.clip_box);
    scene.technique = back.technique; /* nor is none */
    expect_same_scene(&scene, &back);
    pel_scene_finish(&back);
}

static void paths_follow_the_file(void **state)
{
    (void)state;
    char folder[4096], path[4096 + 64];
    snprintf(folder, sizeof folder, "%s", scratch("sub"));
    assert_int_equal(mkdir(folder, 0777), 0);
    write_text(scratch("here.raw"), "x");
    snprintf(path, sizeof path, "%s/scene.json", folder);
    snprintf(scene.source.path, sizeof scene.source.path, "%s", scratch("here.raw"));
    assert_true(pel_write_scene(path, &scene, NULL));
    size_t size;
    char *text = (char *)read_file(path, &size);
    text = realloc(text, size + 1);
    text[size] = 0;
    assert_non_null(strstr(text, "\"../here.raw\""));
    free(text);
    read_scene(path, &scene, NULL);
    assert_int_equal(access(scene.source.path, R_OK), 0);

    write_text(path, "{\"volume\": {\"path\": \"/absolute/a.nrrd\"}}");
    read_scene(path, &scene, NULL);
    assert_string_equal(scene.source.path, "/absolute/a.nrrd");
    write_text(path, "{\"volume\": {\"path\": \"a.nrrd\", \"array\": \"p\"}}");
    read_scene(path, &scene, NULL);
    assert_string_equal(scene.source.array, "p");
    char expected[4096 + 64];
    snprintf(expected, sizeof expected, "%s/a.nrrd", folder);
    assert_string_equal(scene.source.path, expected);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

static void parse(const char *text, struct pel_scene_parts *has)
{
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_scene_from_text(text, strlen(text), "scene.json", &scene, has, &error))
        fail_msg("%s", error.message);
}

static void what_is_not_said_stays(void **state)
{
    (void)state;
    struct pel_scene_parts has;
    struct pel_camera camera = scene.camera;
    parse("{}", &has);
    assert_false(has.transfer || has.colors || has.opacities || has.unit_distance || has.camera || has.isosurfaces || has.slice);
    parse("{\"camera\": {\"camera-view-angle\": 45}, \"transfer\": {\"opacities\": [[0, 0.5]]}}", &has);
    assert_true(scene.camera.view_angle == 45);
    assert_memory_equal(scene.camera.position, camera.position, sizeof camera.position);
    assert_true(has.camera && has.transfer && has.opacities && !has.colors && !has.unit_distance && !has.slice);
    assert_true(pel_transfer_opacity(&scene.transfer, 99) == 0.5);
    assert_string_equal(scene.transfer.colormap, "gray");
}

static void by_hand(void **state)
{
    (void)state;
    parse("{\"transfer\": {\"colormap\": \"Viridis\", \"range\": [10, 20]}, \"background\": [1, 1, 1], \"render\": {\"mode\": \"mip\", "
          "\"step\": 1},"
          "\"isosurfaces\": [{\"value\": 7}], \"lights\": [{\"direction\": [0, 1, 0]}, {}], \"clip-box\": null}",
          NULL);
    assert_string_equal(scene.transfer.colormap, "viridis");
    assert_true(scene.transfer.colors[0].value == 10);
    assert_true(scene.background[3] == 1 && scene.background[0] == 1);
    assert_int_equal(scene.render.mode, PEL_MODE_MIP);
    assert_true(scene.isosurfaces[0].value == 7 && scene.isosurfaces[0].opacity == 1 && scene.isosurfaces[0].color[1] == 1);
    assert_true(!scene.lights[0].headlight && scene.lights[1].headlight && scene.lights[1].color[0] == 1);
    assert_false(scene.clip_box_enabled);
    parse("{\"slice\": [{\"origin\": [1, 2, 3]}, {\"normal\": [1, 0, 0]}, {}]}", NULL);
    assert_int_equal(scene.more_slice_count, 2);
    assert_true(scene.slice.origin[2] == 3 && scene.more_slices[0].normal[0] == 1 && scene.more_slices[1].normal[2] == 1);
    parse("{\"slice\": {\"normal\": [0, 5, 0]}}", NULL); /* one plane replaces them all */
    assert_true(scene.more_slice_count == 0 && scene.slice.normal[1] == 5);
}

static const struct {
    const char *text, *where;
} bad[] = {
    { "", "" },
    { "[]", "expected an object" },
    { "{\"volume\": {\"spacing\": [1, 0, 1]}}", "volume.spacing: " },
    { "{\"volume\": {\"void\": \"none\"}}", "volume.void: " },
    { "{\"camera\": 3}", "camera: " },
    { "{\"camera\": {\"camera-view-angle\": \"wide\"}}", "camera.camera-view-angle: " },
    { "{\"camera\": {\"camera-view-angle\": 300}}", "camera.camera-view-angle: " },
    { "{\"camera\": {\"camera-position\": [1, 2]}}", "camera.camera-position: " },
    { "{\"camera\": {\"camera-position\": [1, 2, {}]}}", "camera.camera-position: " },
    { "{\"camera\": {\"camera-position\": [0,0,0], \"camera-focal-point\": [0,0,0]}}", "camera: " },
    { "{\"camera\": {\"position\": [0,0,0]}}", "camera.position: there is no such key" },
    { "{\"kamera\": {}}", "kamera: there is no such key" },
    { "{\"render\": {\"mode\": \"quick\"}}", "render.mode: " },
    { "{\"render\": {\"step\": 0}}", "render.step: " },
    { "{\"render\": {\"step\": null}}", "render.step: " },
    { "{\"transfer\": {\"colors\": []}}", "transfer.colors: " },
    { "{\"transfer\": {\"colors\": [[0,0,0,0],[1,0,0]]}}", "transfer.colors[1]: expected 4 numbers, found 3" },
    { "{\"transfer\": {\"colors\": [[0,0,0,1.5]]}}", "transfer.colors: " },
    { "{\"transfer\": {\"opacities\": [[0,2]]}}", "transfer.opacities: " },
    { "{\"transfer\": {\"opacities\": 0.5}}", "transfer.opacities: " },
    { "{\"transfer\": {\"unit-distance\": 0}}", "transfer.unit-distance: " },
    { "{\"transfer\": {\"colormap\": \"viridis\"}}", "transfer.colormap: " },
    { "{\"transfer\": {\"colormap\": \"virids\", \"range\": [0, 1]}}", "transfer.colormap: " },
    { "{\"transfer\": {\"range\": [0, 1]}}", "transfer.range: " },
    { "{\"transfer\": {\"colormap\": \"viridis\", \"range\": [0]}}", "transfer.range: " },
    { "{\"isosurfaces\": [{}]}", "isosurfaces[0]: " },
    { "{\"isosurfaces\": [{\"value\": 1}, {\"value\": 1, \"opacity\": -1}]}", "isosurfaces[1].opacity: " },
    { "{\"isosurfaces\": [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17]}", "isosurfaces: 17 entries" },
    { "{\"slice\": {\"normal\": [0,0,0]}}", "slice.normal: " },
    { "{\"slice\": [{}, {\"normal\": [0,0,0]}]}", "slice[1].normal: " },
    { "{\"slice\": []}", "slice: an empty list" },
    { "{\"slice\": [{},{},{},{},{},{},{},{},{}]}", "slice: 9 entries" },
    { "{\"lights\": [{\"color\": [2,0,0]}]}", "lights[0].color: " },
    { "{\"clip-planes\": [{\"origin\": 7}]}", "clip-planes[0].origin: " },
    { "{\"clip-box\": [1,2,3]}", "clip-box: " },
    { "{\"background\": [0,0,0,9]}", "background: " },
    { "{\"linear-light\": 1}", "linear-light: " },
    { "{\"pellucid-scene\": 2}", "pellucid-scene: " },
    { "{\"volume\": {\"path\": 3}}", "volume.path: " },
    { "{\"volume\": {\"raw\": \"0123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890123456789"
      "01234567890123456789012345678901234567890123456789\"}}",
      "volume.raw: " },
    { "{\"technique\": \"slices2d\"}", "technique: expected an object" },
    { "{\"technique\": {\"options\": {\"blend\": 3}}}", "technique: the technique's name is missing" },
    { "{\"technique\": {\"nmae\": \"raycast\"}}", "technique.nmae: there is no such key" },
    { "{\"technique\": {\"name\": \"a name that is far longer than any technique's\"}}", "technique.name: " },
    { "{\"technique\": {\"name\": \"slices2d\", \"options\": [1]}}", "technique.options: expected an object" },
    { "{\"technique\": {\"name\": \"slices2d\", \"options\": {\"blend\": {}}}}", "technique.options.blend: " },
    { "{\"background\": [0,0,0], \"background\": [0,0,0]}", "uplicate" },
    { "{\"background\": [1e999,0,0]}", "" },
    { "{\"a\": \"\xff\"}", "" },
};

static void messages_name_the_key_and_nothing_changes(void **state)
{
    (void)state;
    struct pel_scene before;
    assert_true(pel_scene_init(&before, NULL));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct pel_error error = PEL_ERROR_INIT;
        write_text(scratch("bad.json"), bad[i].text);
        if (pel_read_scene(scratch("bad.json"), &scene, NULL, &error))
            fail_msg("accepted: %s", bad[i].text);
        const char *name = strstr(error.message, "bad.json: ");
        if (!name || !strstr(name, bad[i].where) || strchr(error.message, '\n'))
            fail_msg("%s: %s", bad[i].text, error.message);
        assert_int_not_equal(error.code, PEL_ERROR_NONE);
        assert_int_not_equal(error.code, PEL_ERROR_ARGUMENT);
        expect_same_scene(&scene, &before);
    }
    pel_scene_finish(&before);
}

static void files_that_are_none(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_read_scene(scratch("missing.json"), &scene, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_IO);
    char *long_text = malloc(17 << 20);
    memset(long_text, ' ', 17 << 20);
    write_file(scratch("long.json"), long_text, 17 << 20);
    free(long_text);
    assert_false(pel_read_scene(scratch("long.json"), &scene, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "16 MiB"));
    char deep[8192];
    memset(deep, '[', sizeof deep - 1);
    deep[sizeof deep - 1] = 0;
    assert_false(pel_scene_from_text(deep, strlen(deep), "a", &scene, NULL, &error));
}

static void what_json_cannot_say_is_not_written(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    scene.camera.position[1] = INFINITY;
    assert_false(pel_write_scene(scratch("inf.json"), &scene, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    scene.camera.position[1] = 0;
    snprintf(scene.source.path, sizeof scene.source.path, "bad-\xff");
    assert_false(pel_write_scene(scratch("inf.json"), &scene, &error));
    assert_non_null(strstr(error.message, "UTF-8"));
    assert_int_not_equal(access(scratch("inf.json"), F_OK), 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make, drop)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(round_trip),
        TEST(paths_follow_the_file),
        TEST(what_is_not_said_stays),
        TEST(by_hand),
        TEST(messages_name_the_key_and_nothing_changes),
        TEST(files_that_are_none),
        TEST(what_json_cannot_say_is_not_written),
    };
    return cmocka_run_group_tests(tests, make_scratch, remove_scratch);
}
