/* SPDX-License-Identifier: MIT */
/* Isosurfaces as triangles on the GPU engine: against the ray caster's surfaces, extracted by the CPU and by the GPU, opaque and
 * translucent; what is refused; and that nothing is left behind. Skipped, loudly, where no device is usable. */
#include "on_device.h"

#include "device_gl.h"

static void set(struct pel_renderer *renderer, const char *name, const char *value)
{
    set_option_of(renderer, "mesh", name, value);
}

static void draw_mesh(struct pel_renderer *renderer, const struct pel_scene *scene, int width, int height, struct pel_image *image)
{
    draw_by(renderer, scene, "mesh", width, height, true, image);
}

/* The ray caster's picture, in steps that miss nothing: not by the roots in cells, which triangles are cut by, too. */
static void draw_truth(const struct pel_scene *scene, int width, int height, struct pel_image *image)
{
    struct pel_scene fine = *scene;
    fine.render.roots = PEL_ROOTS_STEPS;
    fine.render.step = 0.05;
    draw(&fine, "raycast", width, height, image);
}

/* Pixels that are covered in one picture alone, in thousandths of all. */
static double uncovered(const struct pel_image *a, const struct pel_image *b)
{
    size_t pixels = (size_t)a->width * (size_t)a->height, differ = 0;
    for (size_t i = 0; i < pixels; i++)
        differ += (a->rgba[4 * i + 3] > 0) != (b->rgba[4 * i + 3] > 0);
    return 1000.0 * (double)differ / (double)pixels;
}

/* Mean difference of depths where both have one; a silhouette apart, they are the same surface's. */
static double depth_off(const struct pel_image *a, const struct pel_image *b)
{
    size_t pixels = (size_t)a->width * (size_t)a->height, both = 0;
    double sum = 0;
    for (size_t i = 0; i < pixels; i++)
        if (isfinite(a->depth[i]) && isfinite(b->depth[i])) {
            sum += fabs((double)a->depth[i] - (double)b->depth[i]);
            both++;
        }
    assert_true(both > 100);
    return sum / (double)both;
}

static void make_surfaces(struct pel_volume *volume, struct pel_scene *scene, enum pel_type type, formula *f, double opacity)
{
    make_typed(volume, scene, type, f);
    scene->render.mode = PEL_MODE_ISOSURFACE;
    scene->isosurfaces[0].opacity = opacity;
    scene->isosurfaces[1].opacity = opacity > 0.5 ? 1 : 0.7;
}

/* In perspective and parallel, clipped and not, lit by a lamp, in linear light, opaque and translucent, with and without voids. */
static void test_raycast(void **state)
{
    (void)state;
    need_device();
    const struct {
        enum pel_type type;
        formula *f;
    } volumes[] = { { PEL_U8, blob }, { PEL_F64, blob }, { PEL_I16, holed } };
    struct pel_renderer *renderer = gpu_renderer();
    for (int i = 0; i < 3; i++)
        for (int variant = 0; variant < 8; variant++) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_image truth, mesh;
            make_surfaces(&volume, &scene, volumes[i].type, volumes[i].f, variant & 1 ? 0.4 : 1);
            scene.camera.parallel = variant & 2;
            scene.linear_light = variant == 5;
            if (variant & 4)
                clip(&scene);
            if (variant == 6)
                scene.lights[0] = (struct pel_light) { false, { 0.3, -1, 0.5 }, { 1, 0.8, 0.6 } };
            draw_truth(&scene, 200, 160, &truth);
            draw_mesh(renderer, &scene, 200, 160, &mesh);
            bool voids = volumes[i].f == holed; /* without gradients beside them, the ray caster lights otherwise there */
            check_at_most(uncovered(&truth, &mesh), 1, "volume %d, variant %d: thousandths of the pixels covered in one alone", i, variant);
            check_at_least(psnr(&truth, &mesh), voids ? 22 : 34, "volume %d, variant %d: PSNR", i, variant);
            check_at_most(depth_off(&truth, &mesh) / pel_volume_least_spacing(&volume), 0.03, "volume %d, variant %d: depth, in voxels", i,
                          variant);
            pel_image_finish(&truth);
            pel_image_finish(&mesh);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(device), 0);
}

/* Layers of shells, one behind the other: more than a handful of fragments a pixel, in their order. */
static double shells(const double index[3])
{
    double d[3] = { index[0] - 14, index[1] - 12, index[2] - 13 };
    return 50 + 45 * sin(sqrt(dot3(d, d)) * 1.2);
}

static void test_many_layers(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image truth, mesh;
    struct pel_renderer *renderer = gpu_renderer();
    make_surfaces(&volume, &scene, PEL_F32, shells, 0.1);
    scene.isosurfaces[1].opacity = 0.15;
    draw_truth(&scene, 160, 120, &truth);
    draw_mesh(renderer, &scene, 160, 120, &mesh);
    check_at_least((double)frame_counter(renderer, "fragments in lists") / (160 * 120), 1.5, "fragments a pixel");
    check_at_least(psnr(&truth, &mesh), 36, "shells: PSNR");
    pel_image_finish(&mesh);
    draw_mesh(renderer, &scene, 53, 40, &mesh); /* the lists are there already, and are longer than they need be */
    pel_image_finish(&truth);
    draw_truth(&scene, 53, 40, &truth);
    check_at_least(psnr(&truth, &mesh), 34, "shells, small: PSNR");
    pel_image_finish(&truth);
    pel_image_finish(&mesh);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Noise: every way to cut a cell. */
static double noise(const double index[3])
{
    uint32_t h = (uint32_t)(index[0] + 1000 * index[1] + 1000000 * index[2]) * 2654435761u;
    h ^= h >> 15;
    h *= 2246822519u;
    h ^= h >> 13;
    return (double)(h % 101);
}

static double holed_noise(const double index[3])
{
    double n = noise(index);
    return n < 3 ? NAN : n;
}

/* The GPU makes the triangles that the CPU makes, with as many vertices; and the picture is the same. */
static void test_extraction(void **state)
{
    (void)state;
    need_device();
    const struct {
        enum pel_type type;
        formula *f;
    } volumes[] = { { PEL_U8, noise }, { PEL_F32, holed_noise }, { PEL_I16, noise }, { PEL_U16, blob } };
    struct pel_renderer *renderer = gpu_renderer();
    set(renderer, "tolerance", "0");
    for (int i = 0; i < 4; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_image by_cpu, by_gpu;
        make_surfaces(&volume, &scene, volumes[i].type, volumes[i].f, 1);
        scene.isosurfaces[0].value =
            40.618034; /* the golden fraction: as far as can be from where whole numbers make an ambiguous face a */
        scene.isosurfaces[1].value = 71.618034; /* tie, which float and double would decide differently */
        set(renderer, "extract", "cpu");
        draw_mesh(renderer, &scene, 97, 81, &by_cpu);
        uint64_t vertices = frame_counter(renderer, "vertices"), triangles = frame_counter(renderer, "triangles");
        set(renderer, "extract", "gpu");
        draw_mesh(renderer, &scene, 97, 81, &by_gpu);
        assert_true(triangles > 1000);
        assert_int_equal(frame_counter(renderer, "vertices"), vertices);
        assert_int_equal(frame_counter(renderer, "triangles"), triangles);
        check_at_least(psnr(&by_cpu, &by_gpu), 60, "volume %d: PSNR of the GPU's extraction against the CPU's", i);
        pel_image_finish(&by_gpu);
        scene.isosurfaces[0].value = 1e6; /* one that nothing reaches, and another elsewhere */
        scene.isosurfaces[1].value = 30.618034;
        draw_mesh(renderer, &scene, 97, 81, &by_gpu);
        uint64_t after = frame_counter(renderer, "triangles");
        set(renderer, "extract", "cpu");
        pel_image_finish(&by_cpu);
        draw_mesh(renderer, &scene, 97, 81, &by_cpu);
        assert_int_equal(frame_counter(renderer, "triangles"), after);
        assert_true(after > 1000);
        pel_image_finish(&by_cpu);
        pel_image_finish(&by_gpu);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(device), 0);
}

static void expect_refused(struct pel_renderer *renderer, const struct pel_scene *scene, enum pel_error_code code, const char *words)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_image image;
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 20, 20, false, NULL));
    assert_false(pel_renderer_draw(renderer, scene, "mesh", &image, &error));
    assert_int_equal(error.code, code);
    assert_non_null(strstr(error.message, words));
    pel_image_finish(&image);
}

static void test_refusals(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume, flat;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_surfaces(&volume, &scene, PEL_U8, blob, 1);
    scene.render.mode = PEL_MODE_COMPOSITE;
    expect_refused(renderer, &scene, PEL_ERROR_ARGUMENT, "isosurface");
    scene.render.mode = PEL_MODE_ISOSURFACE;
    set(renderer, "extract", "gpu");
    set(renderer, "tolerance", "0.1");
    expect_refused(renderer, &scene, PEL_ERROR_ARGUMENT, "tolerance 0");
    set(renderer, "extract", "cpu");
    make_volume(&flat, 9, 1, 9, PEL_U8, constant_one);
    scene.volume = &flat;
    expect_refused(renderer, &scene, PEL_ERROR_UNSUPPORTED, "flat");
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&flat);
    pel_volume_finish(&volume);
}

/* A renderer on a device that may take so many bytes. */
static struct pel_renderer *limited_renderer(uint64_t limit, const char *extract, struct pel_device **on)
{
    struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
    struct pel_renderer_params of = PEL_RENDERER_PARAMS_INIT;
    params.memory_limit = limit;
    of.device = *on = pel_device_create(-1, &params, NULL);
    assert_non_null(*on);
    struct pel_renderer *renderer = pel_renderer_create(&of, NULL);
    set(renderer, "extract", extract);
    set(renderer, "tolerance", "0");
    return renderer;
}

/* Too little memory is refused, with how much it is; enough gives the picture that it always gave, and no more than that is taken. */
static void test_memory(void **state)
{
    (void)state;
    need_device();
    enum { SIDE = 24, PICTURE = SIDE * SIDE * 64 + 40000 /* pictures, tables, blocks: told apart in the option's help */ };
    struct pel_volume volume;
    struct pel_scene scene;
    const char *const ways[] = { "cpu", "gpu" };
    for (int variant = 0; variant < 4; variant++) {
        struct pel_image whole, image;
        struct pel_device *on;
        int refused = 0, drawn = 0;
        make_surfaces(&volume, &scene, PEL_U8, blob, variant & 1 ? 0.3 : 1);
        struct pel_renderer *renderer = gpu_renderer();
        set(renderer, "extract", ways[variant / 2]);
        set(renderer, "tolerance", "0");
        draw_mesh(renderer, &scene, SIDE, SIDE, &whole);
        pel_renderer_destroy(renderer);
        for (uint64_t limit = 20000; limit < 4000000; limit += limit / 4) {
            struct pel_error error = PEL_ERROR_INIT;
            renderer = limited_renderer(limit, ways[variant / 2], &on);
            pel_image_init(&image);
            assert_true(pel_image_allocate(&image, SIDE, SIDE, true, NULL));
            if (pel_renderer_draw(renderer, &scene, "mesh", &image, &error)) {
                check_same_bytes(&whole, &image, "under a limit");
                check_at_most((double)frame_counter(renderer, "bytes on the device"), (double)limit + PICTURE,
                              "variant %d: bytes, limit %d", variant, (int)limit);
                drawn++;
            } else {
                assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
                assert_non_null(strstr(error.message, "MB") ? strstr(error.message, "MB") : strstr(error.message, "whole volume"));
                assert_int_equal(drawn, 0); /* more memory is no less */
                refused++;
            }
            pel_image_finish(&image);
            pel_renderer_destroy(renderer);
            assert_int_equal(pel_device_objects(on), 0);
            pel_device_destroy(on);
        }
        print_message("extracted by the %s, %s: %d limits refused, %d drawn\n", ways[variant / 2], variant & 1 ? "translucent" : "opaque",
                      refused, drawn);
        assert_true(refused > 1 && drawn > 1);
        pel_image_finish(&whole);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* The eye amid the surfaces: what lies behind it is not drawn, what it looks along is cut by the picture's edges. */
static void test_close_ups(void **state)
{
    (void)state;
    need_device();
    static const double eyes[][3] = { { 14, 12, 13 }, { 6.5, 9, 20 }, { 20, 3, 8 } },
                        to[][3] = { { 28, 20, 3 }, { 14, 12, 13 }, { 2, 22, 25 } };
    struct pel_renderer *renderer = gpu_renderer();
    for (int view = 0; view < 6; view++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_image truth, mesh;
        make_surfaces(&volume, &scene, PEL_F32, blob, view & 1 ? 0.4 : 1);
        pel_volume_index_to_world(&volume, eyes[view / 2], scene.camera.position);
        pel_volume_index_to_world(&volume, to[view / 2], scene.camera.focal_point);
        scene.camera.view_angle = (double[]) { 60, 90, 120 }[view / 2];
        draw_truth(&scene, 200, 160, &truth);
        draw_mesh(renderer, &scene, 200, 160, &mesh);
        check_at_most(uncovered(&truth, &mesh), 1, "close-up %d: thousandths of the pixels covered in one alone", view);
        check_at_least(psnr(&truth, &mesh), 34, "close-up %d: PSNR", view);
        check_at_most(depth_off(&truth, &mesh) / pel_volume_least_spacing(&volume), 0.03, "close-up %d: depth, in voxels", view);
        pel_image_finish(&truth);
        pel_image_finish(&mesh);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
}

/* Anything may change between frames; what comes is what a new renderer draws. */
static void test_changes(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image kept, fresh;
    struct pel_renderer *renderer = gpu_renderer();
    make_surfaces(&volume, &scene, PEL_U8, blob, 1);
    for (int step = 0; step < 6; step++) {
        if (step == 1)
            scene.isosurfaces[0].opacity = 0.3;
        if (step == 2)
            scene.isosurfaces[0].value += 9;
        if (step == 3)
            scene.camera.parallel = true;
        if (step == 4)
            scene.isosurface_count = 1;
        if (step == 5)
            set(renderer, "extract", "gpu");
        struct pel_renderer *other = gpu_renderer();
        if (step == 5)
            set(other, "extract", "gpu");
        draw_mesh(renderer, &scene, WIDTH + step, HEIGHT, &kept);
        draw_mesh(other, &scene, WIDTH + step, HEIGHT, &fresh);
        check_same_bytes(&kept, &fresh, "a kept renderer against a new one");
        pel_image_finish(&kept);
        pel_image_finish(&fresh);
        pel_renderer_destroy(other);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static double sheet(const double index[3])
{
    return index[2] == 8 ? 100 : 0;
}

/* A layer of voxels at the isovalue itself: two sheets that lie in one another, and each counts. */
static void test_coincident(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 17, 17, 17, PEL_U8, sheet);
    make_scene(&scene, &volume, NULL);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.isosurface_count = 1;
    scene.isosurfaces[0] = (struct pel_isosurface) { .value = 100, .color = { 1, 0.5, 0.2 }, .opacity = 0.5 };
    struct pel_renderer *renderer = gpu_renderer();
    const char *ways[] = { "cpu", "gpu" };
    for (int i = 0; i < 2; i++) {
        struct pel_image image;
        set(renderer, "extract", ways[i]);
        draw_mesh(renderer, &scene, 128, 128, &image);
        size_t covered = 0, twice = 0;
        for (size_t p = 0; p < (size_t)128 * 128; p++) {
            covered += image.rgba[4 * p + 3] > 0;
            twice += fabsf(image.rgba[4 * p + 3] - 0.75f) < 1e-5f;
        }
        printf("%s: %zu pixels covered, %zu by two sheets\n", ways[i], covered, twice);
        assert_true(covered > 1000);
        assert_int_equal(twice, covered);
        pel_image_finish(&image);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_raycast),  cmocka_unit_test(test_many_layers), cmocka_unit_test(test_extraction),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_changes),     cmocka_unit_test(test_coincident),
        cmocka_unit_test(test_memory),   cmocka_unit_test(test_close_ups),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
