/* SPDX-License-Identifier: MIT */
/* The ray caster on the GPU engine against the CPU engine and the reference, in all its ways; and that it leaves nothing behind. Skipped,
 * loudly, where no device is usable. */
#include "on_device.h"

#include <unistd.h>

/* Every mode, classification, shading, reconstruction and projection. */
static void check_ways(struct pel_renderer *renderer, struct pel_scene *scene, const char *name)
{
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        for (int variant = 0; variant < 12; variant++) {
            char what[128];
            if (mode != PEL_MODE_COMPOSITE && variant % 6)
                continue; /* classification and shade concern composite alone */
            scene->render.mode = (enum pel_mode)mode;
            scene->render.classification = (enum pel_classification)(variant % 3);
            scene->render.shade = variant / 3 & 1;
            scene->render.reconstruction = variant / 6 & 1 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
            scene->camera.parallel = variant & 1;
            snprintf(what, sizeof what, "%s, mode %d, classification %d, shade %d, nearest %d", name, mode, variant % 3, variant / 3 & 1,
                     variant / 6);
            check_against_cpu(renderer, scene, what);
        }
}

static void test_ways(void **state)
{
    (void)state;
    need_device();
    struct pel_renderer *renderer = gpu_renderer();
    const struct {
        enum pel_type type;
        formula *f;
    } cases[] = { { PEL_U8, blob }, { PEL_F32, holed } };
    for (int i = 0; i < 2; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_typed(&volume, &scene, cases[i].type, cases[i].f);
        check_ways(renderer, &scene, pel_type_name(cases[i].type));
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(device), 0);
}

/* Every type; a void by value; settings that change the rays. */
static void test_types_and_settings(void **state)
{
    (void)state;
    need_device();
    struct pel_renderer *renderer = gpu_renderer();
    for (int type = 0; type < PEL_TYPE_COUNT; type++) {
        struct pel_volume volume;
        struct pel_scene scene;
        char what[64];
        make_typed(&volume, &scene, (enum pel_type)type, blob);
        snprintf(what, sizeof what, "%s", pel_type_name((enum pel_type)type));
        scene.render.shade = true;
        check_against_cpu(renderer, &scene, what);
        scene.render.mode = PEL_MODE_MIP;
        check_against_cpu(renderer, &scene, what);
        scene.render.mode = PEL_MODE_COMPOSITE;
        volume.has_void = true;
        volume.void_value = type == PEL_F32 || type == PEL_F64 ? 0 : 50;
        pel_volume_update_range(&volume);
        check_against_cpu(renderer, &scene, "a void value");
        scene.clip_plane_count = 1;
        memcpy(scene.clip_planes[0].origin, scene.slice.origin, sizeof scene.slice.origin);
        memcpy(scene.clip_planes[0].normal, (double[3]){ 1, 1, 0.3 }, sizeof scene.clip_planes[0].normal);
        scene.render.jitter = true;
        scene.linear_light = true;
        scene.light_count = 2;
        scene.lights[1] = (struct pel_light){ .headlight = false, .direction = { 1, 2, -1 }, .color = { 0.6, 0.5, 0.3 } };
        scene.render.step = 0.8;
        check_against_cpu(renderer, &scene, "clip plane, jitter, linear light, two lights");
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
}

/* Passing over cells leaves out nothing that can be seen: the same as without, but for rounding. */
static void test_skipping(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int mode = 0; mode <= PEL_MODE_ISOSURFACE; mode++)
        for (int azimuth = 0; azimuth < 360; azimuth += 60) {
            struct pel_image with, without;
            scene.render.mode = (enum pel_mode)mode;
            pel_camera_azimuth(&scene.camera, 60);
            scene.render.skip = true;
            draw_gpu(renderer, &scene, WIDTH, HEIGHT, &with);
            uint64_t taken = pel_renderer_stats(renderer)->counters[0].value;
            scene.render.skip = false;
            draw_gpu(renderer, &scene, WIDTH, HEIGHT, &without);
            check_at_most(largest_difference(&with, &without), 1e-6, "mode %d, turned %d degrees: skipping", mode, azimuth);
            if (mode == PEL_MODE_COMPOSITE || mode == PEL_MODE_ISOSURFACE)
                check_at_most((double)taken, 0.8 * (double)pel_renderer_stats(renderer)->counters[0].value, "mode %d: samples taken", mode);
            pel_image_finish(&with);
            pel_image_finish(&without);
        }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* As on hardware, where the device makes its min-max grid and distance maps itself; in software the CPU makes them. */
static void test_grids_of_its_own(void **state)
{
    (void)state;
    need_device();
    struct pel_device_info *info = (struct pel_device_info *)(uintptr_t)pel_device_describe(device);
    bool software = info->software;
    info->software = false;
    const struct {
        enum pel_type type;
        formula *f;
    } cases[] = { { PEL_U16, blob }, { PEL_F32, holed } };
    for (int i = 0; i < 2; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_renderer *renderer = gpu_renderer();
        make_typed(&volume, &scene, cases[i].type, cases[i].f);
        for (int mode = 0; mode <= PEL_MODE_ISOSURFACE; mode++)
            for (int turn = 0; turn < 4; turn++) {
                struct pel_image with, without;
                scene.render.mode = (enum pel_mode)mode;
                pel_camera_azimuth(&scene.camera, 77);
                pel_camera_elevation(&scene.camera, turn % 2 ? 50 : -50);
                scene.render.skip = true;
                check_against_cpu(renderer, &scene, pel_type_name(cases[i].type));
                draw_gpu(renderer, &scene, WIDTH, HEIGHT, &with);
                scene.render.skip = false;
                draw_gpu(renderer, &scene, WIDTH, HEIGHT, &without);
                check_at_most(largest_difference(&with, &without), 1e-6, "mode %d, turn %d: skipping", mode, turn);
                pel_image_finish(&with);
                pel_image_finish(&without);
            }
        pel_renderer_destroy(renderer);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    info->software = software;
}

/* Against the reference at half a voxel, on a signal that is hard to sample. */
static void test_reference(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_F32, blob);
    const enum pel_mode modes[] = { PEL_MODE_COMPOSITE, PEL_MODE_ISOSURFACE, PEL_MODE_XRAY, PEL_MODE_MIP };
    for (int i = 0; i < 4; i++) {
        struct pel_image truth, gpu;
        scene.render.mode = modes[i];
        scene.render.shade = true;
        draw(&scene, "reference", WIDTH, HEIGHT, &truth);
        draw_gpu(renderer, &scene, WIDTH, HEIGHT, &gpu);
        check_at_least(psnr(&truth, &gpu), 40, "mode %d: PSNR of the GPU against the reference, dB", modes[i]);
        if (modes[i] == PEL_MODE_ISOSURFACE)
            for (int p = 0; p < WIDTH * HEIGHT; p++)
                if (isfinite(truth.depth[p]) && isfinite(gpu.depth[p]))
                    check_at_most(fabs((double)truth.depth[p] - (double)gpu.depth[p]), 0.02, "depth of the isosurface, pixel %d", p);
        pel_image_finish(&truth);
        pel_image_finish(&gpu);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Refined on both engines alike; one refined frame is what its settings draw by themselves, also where the first frame's step is so long
 * that nothing is passed over, and the interactive step comes back. */
static void test_refine(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params on_cpu = PEL_RENDERER_PARAMS_INIT;
    struct pel_renderer *renderer = gpu_renderer(), *cpu = pel_renderer_create(&on_cpu, &error);
    make_typed(&volume, &scene, PEL_U8, blob);
    scene.render.shade = true;
    for (int way = 0; way <= PEL_MODE_SLICE + 1; way++) {
        struct pel_image fine, gpu, image;
        char what[64];
        snprintf(what, sizeof what, "way %d", way);
        scene.render.mode = way <= PEL_MODE_SLICE ? (enum pel_mode)way : PEL_MODE_COMPOSITE;
        scene.render.classification = way <= PEL_MODE_SLICE ? PEL_CLASSIFICATION_POST : PEL_CLASSIFICATION_PREINTEGRATED;
        scene.render.step = way % 2 ? 6 : 1.2;
        check_against_cpu(renderer, &scene, what);
        scene.render.step = 0.5;
        scene.render.jitter = true;
        check_against_cpu(renderer, &scene, what);
        draw_gpu(renderer, &scene, WIDTH, HEIGHT, &fine);
        scene.render.step = way % 2 ? 6 : 1.2;
        scene.render.jitter = false;
        scene.render.refine = 4;
        pel_image_init(&image);
        assert_true(pel_image_allocate(&image, WIDTH, HEIGHT, true, NULL));
        draw_gpu(renderer, &scene, WIDTH, HEIGHT, &gpu);
        for (int i = 1; !pel_renderer_finished(renderer); i++) {
            pel_image_finish(&gpu);
            draw_gpu(renderer, &scene, WIDTH, HEIGHT, &gpu);
            if (i == 1)
                check_at_most(largest_difference(&fine, &gpu), 1e-6, "%s: one refined frame", what);
        }
        do
            if (!pel_renderer_draw(cpu, &scene, "raycast", &image, &error))
                fail_msg("%s", error.message);
        while (!pel_renderer_finished(cpu));
        check_at_least(psnr(&image, &gpu), 45, "%s: PSNR of the refined pictures, dB", what);
        scene.render.refine = 0;
        pel_camera_azimuth(&scene.camera, 15);
        check_against_cpu(renderer, &scene, what);
        pel_image_finish(&fine);
        pel_image_finish(&gpu);
        pel_image_finish(&image);
    }
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(cpu);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* The measure is of the device, and leaves the renderer as it was; nothing is measured before a draw, or of the CPU. */
static void test_sample_limit(void **state)
{
    (void)state;
    need_device();
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *cpu = pel_renderer_create(&(struct pel_renderer_params)PEL_RENDERER_PARAMS_INIT, &error);
    const struct {
        enum pel_type type;
        formula *f;
    } cases[] = { { PEL_U8, blob }, { PEL_F32, holed } };
    for (int i = 0; i < 2; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_image before, after;
        struct pel_renderer *renderer = gpu_renderer();
        double rate = 0;
        make_typed(&volume, &scene, cases[i].type, cases[i].f);
        assert_false(pel_renderer_sample_limit(renderer, &rate, &error));
        assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
        draw_gpu(renderer, &scene, WIDTH, HEIGHT, &before);
        if (!pel_renderer_sample_limit(renderer, &rate, &error))
            fail_msg("%s", error.message);
        check_at_least(rate, 1000, "texture samples a second");
        draw_gpu(renderer, &scene, WIDTH, HEIGHT, &after);
        check_at_most(largest_difference(&before, &after), 0, "after measuring");
        pel_image_finish(&after);
        pel_image_finish(&before);
        pel_image_init(&after);
        assert_true(pel_image_allocate(&after, 8, 8, false, NULL) && pel_renderer_draw(cpu, &scene, "raycast", &after, NULL));
        assert_false(pel_renderer_sample_limit(cpu, &rate, &error));
        pel_image_finish(&after);
        pel_renderer_destroy(renderer);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(cpu);
    assert_int_equal(pel_device_objects(device), 0);
}

static long resident_kb(void)
{
    long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file) {
        if (fscanf(file, "%ld %ld", &pages, &resident) != 2)
            resident = 0;
        fclose(file);
    }
    return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

/* A thousand renderers, one after the other: no GL object stays, and no memory. */
static void test_nothing_stays(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    make_typed(&volume, &scene, PEL_U8, blob);
    long before = 0;
    for (int round = 0; round < ROUNDS; round++) {
        struct pel_renderer *renderer = gpu_renderer();
        draw_gpu(renderer, &scene, 16, 16, &image);
        pel_image_finish(&image);
        assert_true(pel_device_objects(device) > 0);
        pel_renderer_destroy(renderer);
        assert_int_equal(pel_device_objects(device), 0);
        if (round == ROUNDS / 4)
            before = resident_kb();
    }
#if !defined(__SANITIZE_ADDRESS__)
    check_at_most((double)(resident_kb() - before), 8192, "KB that %d renderers left", ROUNDS * 3 / 4);
#else
    (void)before;
#endif
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ways),         cmocka_unit_test(test_types_and_settings),
        cmocka_unit_test(test_skipping),     cmocka_unit_test(test_grids_of_its_own),
        cmocka_unit_test(test_reference),    cmocka_unit_test(test_refine),
        cmocka_unit_test(test_sample_limit), cmocka_unit_test(test_nothing_stays),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
