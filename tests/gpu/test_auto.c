/* SPDX-License-Identifier: MIT */
/* The technique auto: it draws the picture of the technique that it says it took, tells why, stays with it until the scene changes in what
 * counts, and refuses nothing that the ray caster draws. Skipped, loudly, where no device is usable. */
#include "on_device.h"

/* Draws by auto, and what it took by name with another renderer: the same bytes. Gives what it took. */
static const char *check_frame(struct pel_renderer *renderer, struct pel_renderer *other, const struct pel_scene *scene)
{
    struct pel_image chosen, named;
    draw_by(renderer, scene, "auto", WIDTH, HEIGHT, true, &chosen);
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    const char *took = stats->technique;
    assert_true(strcmp(took, "raycast") == 0 || strcmp(took, "peel") == 0);
    assert_non_null(stats->reason);
    assert_true(stats->reason[0] != 0 && stats->stage_count > 0);
    draw_by(other, scene, took, WIDTH, HEIGHT, true, &named);
    assert_null(pel_renderer_stats(other)->reason);
    assert_string_equal(pel_renderer_stats(other)->technique, took);
    check_same_bytes(&chosen, &named, took);
    assert_memory_equal(chosen.depth, named.depth, sizeof(float) * WIDTH * HEIGHT);
    pel_image_finish(&chosen);
    pel_image_finish(&named);
    return took;
}

static void make_surfaces(struct pel_volume *volume, struct pel_scene *scene)
{
    make_typed(volume, scene, PEL_F32, blob);
    scene->render.mode = PEL_MODE_ISOSURFACE;
}

static bool measuring(const struct pel_renderer *renderer)
{
    return strstr(pel_renderer_stats(renderer)->reason, "measuring") != NULL;
}

/* Both are measured, each three times; then one of them draws, with its cost told, until there are other surfaces. */
static void test_choice(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer(), *other = gpu_renderer();
    make_surfaces(&volume, &scene);
    for (int round = 0; round < 4; round++) {
        const char *winner = NULL;
        for (int i = 0; i < 9; i++) {
            pel_camera_azimuth(&scene.camera, 11);
            scene.isosurfaces[0].value += 0.3; /* a live isovalue starts no new trial */
            const char *took = check_frame(renderer, other, &scene);
            assert_int_equal(measuring(renderer), i < 6);
            if (i < 6) {
                assert_string_equal(took, i < 3 ? "raycast" : "peel");
            } else {
                assert_true(!winner || strcmp(took, winner) == 0);
                winner = took;
                assert_non_null(strstr(pel_renderer_stats(renderer)->reason, "ms by peel"));
            }
        }
        if (round == 0)
            scene.isosurface_count = 3 - scene.isosurface_count;
        else if (round == 1)
            scene.render.roots = PEL_ROOTS_STEPS;
        else
            pel_renderer_invalidate(renderer); /* as another volume does */
    }
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(other);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    assert_int_equal(pel_device_objects(device), 0);
}

/* The frames averaged of a view at rest are of one technique, whatever the trial is at. */
static void test_rest(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer(), *other = gpu_renderer();
    make_surfaces(&volume, &scene);
    scene.render.refine = 4;
    scene.render.step = 1;
    for (int view = 0; view < 8; view++) {
        const char *took = check_frame(renderer, other, &scene);
        if (view < 6)
            assert_string_equal(took, view < 3 ? "raycast" : "peel");
        while (!pel_renderer_finished(renderer))
            assert_string_equal(check_frame(renderer, other, &scene), took);
        struct pel_image again; /* nothing is drawn any more, and still it is told */
        draw_by(renderer, &scene, "auto", WIDTH, HEIGHT, true, &again);
        pel_image_finish(&again);
        assert_string_equal(pel_renderer_stats(renderer)->technique, took);
        assert_non_null(pel_renderer_stats(renderer)->reason);
        pel_camera_azimuth(&scene.camera, 13);
    }
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(other);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* All modes and classifications, on the device and on the CPU, go to the ray caster, between isosurfaces, too. */
static void test_modes(void **state)
{
    (void)state;
    for (int on_device = 0; on_device < 2; on_device++) {
        struct pel_volume volume;
        struct pel_scene scene;
        if (on_device && !device)
            skip();
        struct pel_renderer *renderer = on_device ? gpu_renderer() : pel_renderer_create(NULL, NULL);
        struct pel_renderer *other = on_device ? gpu_renderer() : pel_renderer_create(NULL, NULL);
        make_typed(&volume, &scene, PEL_U16, holed);
        for (int i = 0; i < 3 * (PEL_MODE_SLICE + 1); i++) {
            scene.render.mode = (enum pel_mode)(i % (PEL_MODE_SLICE + 1));
            const char *took = check_frame(renderer, other, &scene);
            if (!on_device || scene.render.mode != PEL_MODE_ISOSURFACE) {
                assert_string_equal(took, "raycast");
                assert_non_null(strstr(pel_renderer_stats(renderer)->reason, "always raycast"));
            }
        }
        pel_renderer_destroy(renderer);
        pel_renderer_destroy(other);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* A device that has no room for what peeling keeps: the ray caster draws, and it is said why. */
static void test_gives_way(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
    struct pel_renderer_params on = PEL_RENDERER_PARAMS_INIT;
    make_surfaces(&volume, &scene);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, WIDTH, HEIGHT, true, NULL));
    params.memory_limit = 95000; /* the volume has 78300 bytes, what peeling keeps some 100000 */
    on.device = pel_device_create(-1, &params, NULL);
    assert_non_null(on.device);
    struct pel_renderer *renderer = pel_renderer_create(&on, NULL), *other = pel_renderer_create(&on, NULL);
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_renderer_draw(other, &scene, "peel", &image, &error));
    for (int i = 0; i < 8; i++) {
        pel_camera_azimuth(&scene.camera, 11);
        assert_string_equal(check_frame(renderer, other, &scene), "raycast");
        assert_int_equal(measuring(renderer), i < 3);
        assert_int_equal(strstr(pel_renderer_stats(renderer)->reason, "whole volume") != NULL, i >= 3);
    }
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(other);
    assert_int_equal(pel_device_objects(on.device), 0);
    pel_device_destroy(on.device);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static bool ask(void *user, double fraction)
{
    (void)fraction;
    return !*(bool *)user;
}

/* Whoever stops a frame gets no picture of another technique in its place, and the trial goes on. */
static void test_cancelled(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params on = PEL_RENDERER_PARAMS_INIT;
    bool stop = false;
    on.device = device;
    on.progress = (struct pel_progress){ ask, &stop };
    struct pel_renderer *renderer = pel_renderer_create(&on, NULL), *other = gpu_renderer();
    make_surfaces(&volume, &scene);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, WIDTH, HEIGHT, true, NULL));
    for (int i = 0; i < 7; i++) {
        if (i == 4) {
            stop = true;
            assert_false(pel_renderer_draw(renderer, &scene, "auto", &image, &error));
            assert_int_equal(error.code, PEL_ERROR_CANCELLED);
            stop = false;
        }
        const char *took = check_frame(renderer, other, &scene);
        if (i < 6)
            assert_string_equal(took, i < 3 ? "raycast" : "peel");
    }
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(other);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_modes),  cmocka_unit_test(test_choice),    cmocka_unit_test(test_rest), cmocka_unit_test(test_gives_way),
        cmocka_unit_test(test_cancelled),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
