/* SPDX-License-Identifier: MIT */
/* Volumes that the device cannot hold at once, because of its textures' sides or its memory: the same pictures in bricks. The device is
 * made small for it. */
#include "on_device.h"

#include "device_gl.h"

/* Changes what the device says of itself; 0: leaves it. Gives the side that it had. */
static int make_small(int side, uint64_t memory)
{
    int before = device->info.max_texture_3d;
    device->info.max_texture_3d = side ? side : before;
    device->params.memory_limit = memory;
    return before;
}

static uint64_t counter(const struct pel_renderer *renderer, const char *name)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    for (int i = 0; i < stats->counter_count; i++)
        if (strcmp(stats->counters[i].name, name) == 0)
            return stats->counters[i].value;
    return 0;
}

/* Across brick faces: the CPU engine's picture, and nearer still that of the whole volume on the device. */
static void check_bricks(struct pel_renderer *whole, struct pel_renderer *bricks, const struct pel_scene *scene, int side, uint64_t memory,
                         const char *what)
{
    struct pel_image cpu, one, many;
    draw(scene, "raycast", WIDTH, HEIGHT, &cpu);
    draw_gpu(whole, scene, WIDTH, HEIGHT, &one);
    assert_int_equal(counter(whole, "bricks"), 0);
    int before = make_small(side, memory);
    draw_gpu(bricks, scene, WIDTH, HEIGHT, &many);
    make_small(before, 0);
    check_at_least((double)counter(bricks, "bricks"), 8, "%s: bricks", what);
    check_at_least(psnr(&cpu, &many), 50, "%s: PSNR of bricks against the CPU, dB", what);
    check_at_least(psnr(&one, &many), 75, "%s: PSNR of bricks against the whole, dB", what);
    if (scene->render.mode == PEL_MODE_COMPOSITE) { /* rounding can move the place of half the opacity by a step */
        int apart = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            apart += isfinite(one.depth[i]) != isfinite(many.depth[i]) || (isfinite(one.depth[i]) && fabsf(one.depth[i] - many.depth[i]) > 0.01f);
        check_at_most(apart, WIDTH * HEIGHT / 100.0, "%s: pixels of another depth", what);
    }
    pel_image_finish(&cpu);
    pel_image_finish(&one);
    pel_image_finish(&many);
}

static void check_ways(struct pel_scene *scene, int side, uint64_t memory, int stride, const char *name)
{
    struct pel_renderer *whole = gpu_renderer(), *bricks = gpu_renderer();
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        for (int variant = 0; variant < 12; variant += stride) {
            char what[128];
            if (mode != PEL_MODE_COMPOSITE && variant % 6 && stride == 1)
                continue; /* classification and shade concern composite alone */
            scene->render.mode = (enum pel_mode)mode;
            scene->render.classification = (enum pel_classification)(variant % 3);
            scene->render.shade = variant / 3 & 1;
            scene->render.reconstruction = variant / 6 & 1 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
            scene->render.jitter = variant & 2;
            scene->camera.parallel = variant & 1;
            pel_camera_azimuth(&scene->camera, 50);
            pel_camera_elevation(&scene->camera, variant % 2 ? 40 : -40);
            snprintf(what, sizeof what, "%s, mode %d, classification %d, shade %d, nearest %d", name, mode, variant % 3, variant / 3 & 1,
                     variant / 6);
            check_bricks(whole, bricks, scene, side, memory, what);
        }
    pel_renderer_destroy(bricks);
    pel_renderer_destroy(whole);
    assert_int_equal(pel_device_objects(device), 0);
}

/* A ball in a larger volume: outside of it there is nothing to see. */
static double far_blob(const double index[3])
{
    double x = index[0] - 30, y = index[1] - 28, z = index[2] - 29, r = sqrt(x * x + y * y + z * z);
    return fmax(0, 110 - 5 * r) + 4 + 4 * sin(0.6 * x + 0.4 * y);
}

static double far_holed(const double index[3])
{
    return (int)index[0] % 9 == 4 && (int)index[1] % 7 == 3 ? NAN : far_blob(index);
}

static const size_t dims[3] = { 61, 57, 59 };

/* Sides too long: textures of 30, so bricks of 16 with four more voxels on each side. */
static void test_sides(void **state)
{
    (void)state;
    need_device();
    const struct {
        enum pel_type type;
        formula *f;
    } cases[] = { { PEL_U8, far_blob }, { PEL_F32, far_holed } };
    for (int i = 0; i < 2; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_sized(&volume, &scene, dims, cases[i].type, cases[i].f);
        check_ways(&scene, 30, 0, i ? 5 : 1, pel_type_name(cases[i].type));
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* Memory for a part of the volume: bricks of all types come and go within a frame. */
static void test_memory(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    for (int type = 0; type < PEL_TYPE_COUNT; type++) {
        struct pel_renderer *whole = gpu_renderer(), *bricks = gpu_renderer();
        make_sized(&volume, &scene, dims, (enum pel_type)type, far_blob);
        scene.render.shade = true;
        check_bricks(whole, bricks, &scene, 0, 200000, pel_type_name((enum pel_type)type));
        check_at_least((double)counter(bricks, "bricks sent"), (double)counter(bricks, "bricks on the device") + 1, "bricks that came and went");
        pel_renderer_destroy(bricks);
        pel_renderer_destroy(whole);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* Inside the volume, near a face, along an axis, through corners: every sample belongs to one brick. */
static void test_views(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *whole = gpu_renderer(), *bricks = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_U8, far_blob);
    static const double from[][3] = { { 30, 28, 29 }, { 16, 16, 16 }, { 32, 28, 0 }, { 16, 32, -40 }, { -20, 16, 48 }, { 100, 100, 100 } };
    static const double to[][3] = { { 31, 28, 29 }, { 60, 60, 60 }, { 32, 28, 50 }, { 16, 32, 20 }, { 30, 16, 48 }, { 0, 0, 0 } };
    for (int mode = 0; mode <= PEL_MODE_ISOSURFACE; mode++)
        for (int i = 0; i < 12; i++) {
            char what[64];
            scene.render.mode = (enum pel_mode)mode;
            scene.render.shade = i & 1;
            scene.camera.parallel = i >= 6;
            scene.camera.parallel_scale = 30;
            pel_volume_index_to_world(&volume, from[i % 6], scene.camera.position);
            pel_volume_index_to_world(&volume, to[i % 6], scene.camera.focal_point);
            memcpy(scene.camera.view_up, (double[3]){ 0.1, 0.9, 0.2 }, sizeof scene.camera.view_up);
            snprintf(what, sizeof what, "mode %d, view %d", mode, i);
            check_bricks(whole, bricks, &scene, 30, 0, what);
        }
    pel_renderer_destroy(bricks);
    pel_renderer_destroy(whole);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Steps of several voxels: what a segment reaches is in its brick, and bricks are cut anew where it is not. */
static void test_long_steps(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *whole = gpu_renderer(), *bricks = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_U8, far_blob);
    static const double steps[] = { 0.3, 1, 1.9, 5.5, 9, 0.5 };
    for (int mode = 0; mode <= PEL_MODE_ISOSURFACE; mode += PEL_MODE_ISOSURFACE)
        for (int i = 0; i < 12; i++) {
            char what[64];
            scene.render.mode = (enum pel_mode)mode;
            scene.render.classification = i < 6 ? PEL_CLASSIFICATION_PREINTEGRATED : PEL_CLASSIFICATION_POST;
            scene.render.shade = i / 3 & 1; /* so that the step alone changes, too */
            scene.render.step = steps[i % 6];
            snprintf(what, sizeof what, "mode %d, step %g", mode, scene.render.step);
            check_bricks(whole, bricks, &scene, 48, 0, what);
        }
    /* A longer step that ends skipping, in bricks that were found empty at a short one. */
    scene.render.mode = PEL_MODE_ISOSURFACE;
    for (int i = 0; i < 4; i++) {
        scene.render.step = i & 1 ? 16.7 : 0.5;
        scene.isosurfaces[0].value = i < 2 ? 85.2 : 85.4;
        check_bricks(whole, bricks, &scene, 48, 0, "a longer step");
    }
    pel_renderer_destroy(bricks);
    pel_renderer_destroy(whole);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A view at rest, from a long step to half a voxel and back. */
static void test_refine(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image one, many;
    struct pel_renderer *whole = gpu_renderer(), *bricks = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_U8, far_blob);
    scene.render.step = 5.5;
    scene.render.refine = 3;
    for (int mode = 0; mode <= PEL_MODE_ISOSURFACE; mode += PEL_MODE_ISOSURFACE) {
        scene.render.mode = (enum pel_mode)mode;
        do {
            draw_gpu(whole, &scene, WIDTH, HEIGHT, &one);
            int before = make_small(48, 0);
            draw_gpu(bricks, &scene, WIDTH, HEIGHT, &many);
            make_small(before, 0);
            assert_int_equal(counter(whole, "frames averaged"), counter(bricks, "frames averaged"));
            check_at_least(psnr(&one, &many), 75, "mode %d, %d frames averaged: PSNR of bricks against the whole, dB", mode,
                           (int)counter(whole, "frames averaged"));
            pel_image_finish(&one);
            pel_image_finish(&many);
        } while (!pel_renderer_finished(whole));
        assert_true(pel_renderer_finished(bricks));
    }
    pel_renderer_destroy(bricks);
    pel_renderer_destroy(whole);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Bricks that cannot be seen never travel, those that can be stay where there is room, and a transfer function sends what it shows. */
static void test_what_travels(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_U8, far_blob);
    int before = make_small(30, 0);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "95:0,100:0.6", NULL));
    draw_gpu(renderer, &scene, WIDTH, HEIGHT, &image);
    pel_image_finish(&image);
    uint64_t all = counter(renderer, "bricks"), sent = counter(renderer, "bricks sent");
    assert_int_equal(all, 64);
    check_at_least((double)sent, 1, "bricks sent that may be seen");
    check_at_most((double)sent, 8, "bricks sent that may be seen");
    pel_camera_azimuth(&scene.camera, 100);
    draw_gpu(renderer, &scene, WIDTH, HEIGHT, &image);
    pel_image_finish(&image);
    assert_int_equal(counter(renderer, "bricks sent"), 0);
    assert_int_equal(counter(renderer, "bricks on the device"), sent);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0.1,100:0.6", NULL));
    draw_gpu(renderer, &scene, WIDTH, HEIGHT, &image);
    pel_image_finish(&image);
    assert_int_equal(counter(renderer, "bricks sent"), all - sent);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0,200:0", NULL));
    draw_gpu(renderer, &scene, WIDTH, HEIGHT, &image);
    assert_int_equal(counter(renderer, "samples taken"), 0);
    pel_image_finish(&image);
    make_small(before, 0);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A view that needs fewer bricks than the one before keeps them: what only the old one needed makes room. */
static void test_changed_view(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_U8, far_blob);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0.01,100:0.05", NULL));
    make_small(30, 1000000); /* room for about half */
    uint64_t sent[6];
    for (int i = 0; i < 6; i++) {
        if (i == 2)
            pel_camera_zoom(&scene.camera, 12);
        draw_gpu(renderer, &scene, WIDTH, HEIGHT, &image);
        pel_image_finish(&image);
        sent[i] = counter(renderer, "bricks sent");
    }
    check_at_least((double)sent[1], 10, "bricks sent again, as not all fit");
    assert_int_equal(sent[4], 0); /* the first frames of the new view do not know yet what the old one leaves */
    assert_int_equal(sent[5], 0);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A device that has less memory than it told: the volume in bricks after all, and those in place of each other. */
static void test_short_memory(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image cpu, gpu;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_F32, far_blob);
    scene.render.shade = true;
    draw(&scene, "raycast", WIDTH, HEIGHT, &cpu);
    draw_gpu(renderer, &scene, WIDTH, HEIGHT, &gpu);
    pel_image_finish(&gpu);
    uint64_t whole = device->bytes; /* of which the volume takes 820000 */
    pel_renderer_destroy(renderer);
    renderer = gpu_renderer();
    device->room = whole - 400000;
    draw_gpu(renderer, &scene, WIDTH, HEIGHT, &gpu);
    check_at_least((double)counter(renderer, "bricks"), 8, "bricks");
    check_at_least((double)counter(renderer, "bricks sent"), (double)counter(renderer, "bricks on the device") + 1, "bricks that came and went");
    check_at_least(psnr(&cpu, &gpu), 50, "PSNR of bricks against the CPU, dB");
    pel_image_finish(&cpu);
    pel_image_finish(&gpu);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* As on hardware, where the device makes the distance maps of bricks. */
static void test_maps_of_its_own(void **state)
{
    (void)state;
    need_device();
    const struct {
        enum pel_type type;
        formula *f;
    } cases[] = { { PEL_U16, far_blob }, { PEL_F32, far_holed } };
    device->info.software = false;
    for (int i = 0; i < 2; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_sized(&volume, &scene, dims, cases[i].type, cases[i].f);
        check_ways(&scene, 30, 0, 5, pel_type_name(cases[i].type));
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* Memory for hardly anything is refused in words; and a volume that is longer than the device's own textures is drawn. */
static void test_limits(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, dims, PEL_U8, far_blob);
    make_small(0, 1000);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 8, 8, false, NULL));
    assert_false(pel_renderer_draw(renderer, &scene, "raycast", &image, &error));
    assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "bricks"));
    make_small(0, 0);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    const size_t long_dims[3] = { (size_t)pel_device_describe(device)->max_texture_3d + 5, 6, 5 };
    make_sized(&volume, &scene, long_dims, PEL_U8, far_blob);
    check_against_cpu(renderer, &scene, "a long volume");
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* The device as it was, also where a test has failed. */
static struct pel_device_info real_info;

static int open_and_note(void **state)
{
    int status = open_device(state);
    if (device)
        real_info = device->info;
    return status;
}

static int restore_device(void **state)
{
    (void)state;
    if (device) {
        device->info = real_info;
        device->params.memory_limit = device->room = 0;
    }
    return 0;
}

#define TEST(name) cmocka_unit_test_teardown(name, restore_device)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_sides),        TEST(test_memory),       TEST(test_views),           TEST(test_long_steps), TEST(test_what_travels),
        TEST(test_changed_view), TEST(test_short_memory), TEST(test_maps_of_its_own), TEST(test_limits),     TEST(test_refine),
    };
    return cmocka_run_group_tests(tests, open_and_note, close_device);
}
