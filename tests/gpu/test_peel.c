/* SPDX-License-Identifier: MIT */
/* Peeling: no crack and no miss. With the ray caster's steps the picture is the brute-force ray caster's to the last bit; with exact roots
 * it is that of the same roots along whole rays; whatever the view, the granularity, the cover, the way to make masks. What is refused, and
 * that nothing is left behind. Skipped, loudly, where no device is usable. */
#include "on_device.h"

static void set_option(struct pel_renderer *renderer, const char *name, const char *value)
{
    set_option_of(renderer, "peel", name, value);
}

/* Whole rays by the ray caster. */
static void draw_brute(struct pel_renderer *renderer, const struct pel_scene *scene, int width, int height, struct pel_image *image)
{
    struct pel_scene whole = *scene;
    whole.render.skip = false;
    whole.render.roots = PEL_ROOTS_STEPS;
    draw_by(renderer, &whole, "raycast", width, height, true, image);
}

/* Rays that meet a surface in one picture alone. */
static int lone_hits(const struct pel_image *a, const struct pel_image *b)
{
    int count = 0;
    for (int i = 0; i < a->width * a->height; i++)
        count += isfinite(a->depth[i]) && !isfinite(b->depth[i]);
    return count;
}

static int hits(const struct pel_image *image)
{
    int count = 0;
    for (int i = 0; i < image->width * image->height; i++)
        count += isfinite(image->depth[i]) != 0;
    return count;
}

/* The options of check number `i`: all of each are met, and pairs of them. */
static void take_options(struct pel_renderer *renderer, int i, char *what, size_t size)
{
    static const char *const paths[] = { "raster", "compute" }, *const covers[] = { "disc", "box" }, *const interiors[] = { "true", "true", "false" },
                      *const grains[] = { "1", "2", "3", "4", "5", "8", "6", "7" };
    set_option(renderer, "mask-path", paths[i % 2]);
    set_option(renderer, "cover", covers[i / 2 % 2]);
    set_option(renderer, "interior", interiors[i % 3]);
    set_option(renderer, "granularity", grains[(i + i / 8) % 8]);
    snprintf(what, size, "%s, cover %s, interior %s, granularity %s", paths[i % 2], covers[i / 2 % 2], interiors[i % 3], grains[(i + i / 8) % 8]);
}

/* The same view by the ray caster's steps, by the steps and a binary search, and by exact roots; each before whole rays. */
static void check_view(struct pel_renderer *renderer, const struct pel_scene *scene, int number, const char *name)
{
    struct pel_image brute, peeled, whole;
    struct pel_scene all = *scene, steps = *scene;
    char options[128], what[256];
    take_options(renderer, number, options, sizeof options);
    snprintf(what, sizeof what, "%s, view %d: %s", name, number, options);
    steps.render.roots = PEL_ROOTS_STEPS;
    draw_brute(renderer, &steps, WIDTH, HEIGHT, &brute);
    draw_by(renderer, &steps, "peel", WIDTH, HEIGHT, true, &peeled);
    check_same_bytes(&brute, &peeled, what);
    assert_memory_equal(brute.depth, peeled.depth, sizeof(float) * WIDTH * HEIGHT);
    pel_image_finish(&peeled);

    set_option(renderer, "segments", "tree"); /* the rival must be right, too */
    set_option(renderer, "interior", "true");
    draw_by(renderer, &steps, "peel", WIDTH, HEIGHT, true, &peeled);
    check_same_bytes(&brute, &peeled, what);
    pel_image_finish(&peeled);
    set_option(renderer, "segments", "masks");
    take_options(renderer, number, options, sizeof options);

    set_option(renderer, "bisect", "true");
    draw_by(renderer, &steps, "peel", WIDTH, HEIGHT, true, &peeled);
    check_at_most(lone_hits(&brute, &peeled) + lone_hits(&peeled, &brute), 0, "%s: rays that hit with a binary search or without it alone", what);
    pel_image_finish(&peeled);

    set_option(renderer, "bisect", "false");
    draw_by(renderer, scene, "peel", WIDTH, HEIGHT, true, &peeled);
    all.render.skip = false;
    draw_by(renderer, &all, "peel", WIDTH, HEIGHT, true, &whole);
    check_same_bytes(&whole, &peeled, what);
    assert_memory_equal(whole.depth, peeled.depth, sizeof(float) * WIDTH * HEIGHT);
    check_at_most(lone_hits(&brute, &peeled), 0, "%s: rays whose hit the exact roots miss", what);
    pel_image_finish(&whole);
    pel_image_finish(&peeled);
    pel_image_finish(&brute);
}

/* The camera from direction `number` of 26: the corners, edges and faces of a cube. */
static void look_from(struct pel_scene *scene, int number)
{
    int code = number < 13 ? number : number + 1; /* 13 is the middle */
    double from[3] = { code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1 }, along[3];
    double distance = 0, length = sqrt(dot3(from, from));
    for (int i = 0; i < 3; i++) {
        along[i] = scene->camera.position[i] - scene->camera.focal_point[i];
        distance += along[i] * along[i];
    }
    for (int i = 0; i < 3; i++) {
        scene->camera.position[i] = scene->camera.focal_point[i] + from[i] / length * sqrt(distance);
        scene->camera.view_up[i] = i == 1 ? 1 : 0;
    }
    if (from[0] == 0 && from[2] == 0)
        memcpy(scene->camera.view_up, (double[3]){ 0, 0, 1 }, sizeof scene->camera.view_up);
}

/* Crumbs: surfaces around single voxels, shells, and noise that rays meet anywhere. */
static double crumbs(const double index[3])
{
    double wave = 55 + 50 * sin(index[0] * 0.55) * sin(index[1] * 0.45 + 1) * sin(index[2] * 0.5 + 2);
    uint32_t h = (uint32_t)index[0] * 73856093u ^ (uint32_t)index[1] * 19349663u ^ (uint32_t)index[2] * 83492791u;
    h = (h ^ h >> 13) * 2654435761u;
    return h >> 24 < 6 ? 110 : wave;
}

static double crumbs_with_holes(const double index[3])
{
    return (int)index[0] % 9 == 4 && (int)index[1] % 7 == 3 ? NAN : crumbs(index);
}

static const struct {
    const char *name;
    enum pel_type type;
    formula *f;
    size_t dims[3];
} volumes[] = {
    { "bytes", PEL_U8, blob, { 29, 25, 27 } },           { "signed words", PEL_I16, crumbs, { 33, 18, 41 } },
    { "float with voids", PEL_F32, crumbs_with_holes, { 30, 26, 35 } }, { "double", PEL_F64, crumbs, { 9, 40, 70 } },
    { "one slice", PEL_F32, blob, { 29, 25, 1 } },       { "two slices", PEL_U16, crumbs, { 2, 25, 21 } },
};

static void test_views(void **state)
{
    (void)state;
    need_device();
    int number = 0;
    for (size_t i = 0; i < sizeof volumes / sizeof *volumes; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_renderer *renderer = gpu_renderer();
        make_sized(&volume, &scene, volumes[i].dims, volumes[i].type, volumes[i].f);
        scene.render.mode = PEL_MODE_ISOSURFACE;
        for (int v = 0; v < VIEWS; v++, number++) {
            look_from(&scene, v * 26 / VIEWS);
            if (v & 1)
                pel_camera_azimuth(&scene.camera, 7);
            scene.camera.parallel = v / 2 & 1;
            check_view(renderer, &scene, number, volumes[i].name);
        }
        pel_renderer_destroy(renderer);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    assert_int_equal(pel_device_objects(device), 0);
}

/* The eye among the cells, in views so wide that rays go every way along the major axis, and voxels that are much longer one way. */
static void test_close_ups(void **state)
{
    (void)state;
    need_device();
    static const double eyes[][3] = { { 12.3, 10.1, 17.7 }, { 12, 10, 17 }, { 0.001, 12.4, 20 }, { 5.5, 24, 33.9 }, { 15, 1e-6, 30 } };
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, (const size_t[3]){ 30, 26, 35 }, PEL_U8, crumbs);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    for (int number = 0; number < 4 * VIEWS; number++) {
        const double spacings[3][3] = { { 1, 1, 1 }, { 1, 1.2, 0.2 }, { 3, 0.4, 1 } };
        double at[3], to[3] = { (7 * number) % 30, (11 * number) % 26, (5 * number + 3) % 35 };
        char what[64];
        memcpy(volume.spacing, spacings[number % 3], sizeof volume.spacing);
        memcpy(at, eyes[number % 5], sizeof at);
        pel_volume_index_to_world(&volume, at, scene.camera.position);
        pel_volume_index_to_world(&volume, to, scene.camera.focal_point);
        memcpy(scene.camera.view_up, (double[3]){ 0.3, 1, 0.1 }, sizeof scene.camera.view_up);
        scene.camera.parallel = number % 4 == 3;
        scene.camera.parallel_scale = 6;
        scene.camera.view_angle = (double[]){ 30, 80, 120, 160 }[number % 4];
        scene.isosurfaces[0].opacity = number % 3 ? 0.3 : 1;
        snprintf(what, sizeof what, "close-up %d", number);
        check_view(renderer, &scene, number, what);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Clip planes and a clip box, lights of the scene, a longer and a shorter step, early termination, linear light, jitter. */
static void test_scenes(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_renderer *renderer = gpu_renderer();
    for (int number = 0; number < 8; number++) {
        struct pel_scene scene;
        char what[64];
        make_sized(&volume, &scene, (const size_t[3]){ 33, 29, 31 }, number & 1 ? PEL_F32 : PEL_U8, number & 1 ? crumbs_with_holes : crumbs);
        scene.render.mode = PEL_MODE_ISOSURFACE;
        look_from(&scene, 3 * number);
        scene.render.step = (double[]){ 0.5, 1, 0.31, 2.7 }[number % 4];
        scene.render.termination = number % 3 ? 0.9 : 1;
        scene.linear_light = number & 2;
        scene.render.jitter = number & 4;
        if (number & 1) {
            scene.lights[0] = (struct pel_light){ false, { 1, 2, 0.5 }, { 1, 0.8, 0.6 } };
            memcpy(scene.clip_planes[0].origin, scene.slice.origin, sizeof scene.slice.origin);
            memcpy(scene.clip_planes[0].normal, (double[3]){ 1, -0.3, 0.7 }, sizeof scene.slice.normal);
            scene.clip_plane_count = 1;
        }
        if (number & 2) {
            scene.clip_box_enabled = true;
            memcpy(scene.clip_box, (double[6]){ 4, 21.5, -9, 17, 8.25, 90 }, sizeof scene.clip_box);
        }
        scene.isosurfaces[2] = (struct pel_isosurface){ 20.1, { 0.2, 1, 0.3 }, 0.25 };
        scene.isosurface_count = 3;
        snprintf(what, sizeof what, "scene %d", number);
        check_view(renderer, &scene, number, what);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(device), 0);
}

/* Where the ray caster's steps are short, it finds what the exact roots find: hits and depths, in a smooth volume. */
static void test_exact_roots(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image fine, exact;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_F32, blob);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.camera.view_angle = 8;
    draw_by(renderer, &scene, "peel", 3 * WIDTH, 3 * HEIGHT, true, &exact);
    scene.render.step = 0.01;
    draw_brute(renderer, &scene, 3 * WIDTH, 3 * HEIGHT, &fine);
    check_at_least(hits(&fine), 1000, "rays that hit");
    check_at_most(lone_hits(&fine, &exact), 0, "rays that exact roots miss");
    check_at_most(lone_hits(&exact, &fine), 2, "rays that hit by exact roots alone");
    int far = 0;
    for (int i = 0; i < fine.width * fine.height; i++)
        far += isfinite(fine.depth[i]) && isfinite(exact.depth[i]) && fabsf(fine.depth[i] - exact.depth[i]) > 0.01f * 0.9f;
    check_at_most(far, 2, "depths that differ by a hundredth of a voxel");
    pel_image_finish(&fine);
    pel_image_finish(&exact);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* What a changed isovalue, granularity or view leaves behind is what a fresh renderer makes; nothing is found anew that did not change. */
static void test_changes(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, crumbs);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    uint64_t before = 0;
    for (int i = 0; i < 6; i++) {
        struct pel_image image, again;
        struct pel_renderer *fresh = gpu_renderer();
        scene.isosurfaces[0].value = i < 3 ? 40.3 + 9 * i : 90;
        scene.render.skip = i != 4;
        if (i == 3)
            pel_camera_azimuth(&scene.camera, 30);
        if (i == 5)
            set_option(renderer, "granularity", "3"), set_option(fresh, "granularity", "3");
        draw_by(renderer, &scene, "peel", WIDTH, HEIGHT, true, &image);
        draw_by(fresh, &scene, "peel", WIDTH, HEIGHT, true, &again);
        check_same_bytes(&image, &again, "after changes");
        if (i == 1) /* another isovalue, other cells */
            assert_int_not_equal(frame_counter(renderer, "active cells"), before);
        if (i != 4)
            before = frame_counter(renderer, "active cells");
        pel_image_finish(&image);
        pel_image_finish(&again);
        pel_renderer_destroy(fresh);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    assert_int_equal(pel_device_objects(device), 0);
}

/* Counters say what was skipped; with interior skipping off there is one segment a ray, and more is looked into. */
static void test_counters(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, (const size_t[3]){ 70, 70, 70 }, PEL_U8, crumbs);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.isosurfaces[0] = (struct pel_isosurface){ 108, { 1, 1, 1 }, 0.2 };
    scene.isosurface_count = 1;
    set_option(renderer, "granularity", "1");
    set_option(renderer, "mask-path", "raster");
    draw_by(renderer, &scene, "peel", WIDTH, HEIGHT, true, &image);
    pel_image_finish(&image);
    uint64_t segments = frame_counter(renderer, "segments"), looked = frame_counter(renderer, "voxel cells looked into");
    assert_int_equal(frame_counter(renderer, "cells"), 69 * 69 * 69);
    assert_int_equal(frame_counter(renderer, "cell-slices"), 69);
    assert_int_equal(frame_counter(renderer, "layers of masks"), 5);
    assert_true(frame_counter(renderer, "active cells") > 1000 && frame_counter(renderer, "active cells") < 69 * 69 * 69 / 2);
    assert_true(segments > 2 * frame_counter(renderer, "rays with segments"));
    set_option(renderer, "interior", "false");
    draw_by(renderer, &scene, "peel", WIDTH, HEIGHT, true, &image);
    pel_image_finish(&image);
    assert_int_equal(frame_counter(renderer, "segments"), frame_counter(renderer, "rays with segments"));
    check_at_least((double)frame_counter(renderer, "voxel cells looked into"), 1.2 * (double)looked, "cells looked into without interior skipping");
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Masks that are more than the memory allowed: the screen in tiles, and the same picture. */
static void test_tiles(void **state)
{
    (void)state;
    need_device();
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image whole, tiled;
    struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
    params.memory_limit = 60000; /* the volume has some 39000 bytes in 16 bits, its cells some 13000 */
    struct pel_device *small = pel_device_create(-1, &params, &error);
    assert_non_null(small);
    struct pel_renderer_params on = PEL_RENDERER_PARAMS_INIT;
    on.device = small;
    make_typed(&volume, &scene, PEL_U8, crumbs);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    for (int path = 0; path < 2; path++) {
        struct pel_renderer *renderer = gpu_renderer(), *limited = pel_renderer_create(&on, &error);
        set_option(limited, "mask-path", path ? "compute" : "raster");
        draw_by(renderer, &scene, "peel", 3 * WIDTH, 3 * HEIGHT, true, &whole);
        draw_by(limited, &scene, "peel", 3 * WIDTH, 3 * HEIGHT, true, &tiled);
        assert_int_equal(frame_counter(renderer, "tiles of the screen"), 1);
        assert_true(frame_counter(limited, "tiles of the screen") > 3);
        check_same_bytes(&whole, &tiled, "in tiles");
        pel_image_finish(&whole);
        pel_image_finish(&tiled);
        pel_renderer_destroy(renderer);
        pel_renderer_destroy(limited);
    }
    assert_int_equal(pel_device_objects(small), 0);
    pel_device_destroy(small);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* What it keeps is held against the memory allowed: too little is refused, be it for the volume or for the masks beside it. */
static void test_memory(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image whole, image;
    struct pel_renderer *free_one = gpu_renderer();
    int no_volume = 0, no_masks = 0, drawn = 0;
    make_typed(&volume, &scene, PEL_U8, crumbs);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    draw_by(free_one, &scene, "peel", 24, 24, true, &whole);
    for (uint64_t limit = 20000; limit < 80000; limit += 256) {
        struct pel_error error = PEL_ERROR_INIT;
        struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
        struct pel_renderer_params on = PEL_RENDERER_PARAMS_INIT;
        params.memory_limit = limit;
        on.device = pel_device_create(-1, &params, NULL);
        struct pel_renderer *renderer = pel_renderer_create(&on, NULL);
        set_option(renderer, "mask-path", "compute");
        pel_image_init(&image);
        assert_true(pel_image_allocate(&image, 24, 24, true, NULL));
        if (pel_renderer_draw(renderer, &scene, "peel", &image, &error)) {
            check_same_bytes(&whole, &image, "under a limit");
            drawn++;
            limit += 8192; /* that more does is looked at in longer steps */
        } else {
            assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
            assert_int_equal(drawn, 0);
            no_volume += strstr(error.message, "whole volume") != NULL;
            no_masks += strstr(error.message, "masks beside them") != NULL;
        }
        pel_image_finish(&image);
        pel_renderer_destroy(renderer);
        pel_device_destroy(on.device);
        limit += no_volume && !no_masks && limit < 38000 ? 4096 : 0;
    }
    print_message("%d limits hold no volume, %d no masks beside it, %d do\n", no_volume, no_masks, drawn);
    assert_true(no_volume > 0 && no_masks > 0 && drawn > 0);
    pel_image_finish(&whole);
    pel_renderer_destroy(free_one);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* What the active cells of one frame are: how many, and the segments that rays across them have in them, which other cells would change.
 * Pictures would differ where a voxel is exactly the isovalue: on software devices 8 bits are kept in 16. */
struct activity {
    uint64_t cells, rays, segments;
};

static struct activity active_cells(struct pel_renderer *renderer, const struct pel_scene *scene)
{
    struct pel_image image;
    draw_by(renderer, scene, "peel", 24, 20, true, &image);
    pel_image_finish(&image);
    return (struct activity) { frame_counter(renderer, "active cells"), frame_counter(renderer, "rays with segments"),
                               frame_counter(renderer, "segments") };
}

/* In software the CPU makes the cells' ranges: they are those that the device makes on hardware. */
static void test_ranges(void **state)
{
    (void)state;
    need_device();
    struct pel_device_info *info = (struct pel_device_info *)(uintptr_t)pel_device_describe(device);
    const bool software = info->software;
    for (int type = 0; type < PEL_TYPE_COUNT; type++)
        for (int voids = 0; voids < 2; voids++) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_renderer *by[2] = { gpu_renderer(), gpu_renderer() };
            make_sized(&volume, &scene, (const size_t[3]){ 33, 18, 41 }, (enum pel_type)type, voids && type >= PEL_F32 ? crumbs_with_holes : crumbs);
            scene.render.mode = PEL_MODE_ISOSURFACE;
            scene.isosurface_count = 1;
            look_from(&scene, 19);
            pel_camera_azimuth(&scene.camera, 11);
            volume.has_void = voids;
            volume.void_value = 110; /* the crumbs' */
            for (int grain = 1; grain <= 8; grain++)
                for (int i = 0; i < 5; i++) {
                    struct activity cells[2];
                    scene.isosurfaces[0].value = (double[]){ 6.5, 55, 80.5, 104.9, 109.5 }[i];
                    for (int k = 0; k < 2; k++) {
                        info->software = k;
                        set_option(by[k], "mask-path", "compute");
                        set_option(by[k], "granularity", (const char[]){ (char)('0' + grain), 0 });
                        cells[k] = active_cells(by[k], &scene);
                    }
                    info->software = software;
                    if (memcmp(&cells[0], &cells[1], sizeof *cells) || (i < 3 && cells[0].cells == 0) ||
                        (i == 4 && (cells[0].cells == 0) != voids))
                        fail_msg("%s, voids %d, granularity %d, surface %d: %d cells and %d segments by the device, %d and %d by the CPU",
                                 pel_type_name((enum pel_type)type), voids, grain, i, (int)cells[0].cells, (int)cells[0].segments,
                                 (int)cells[1].cells, (int)cells[1].segments);
                }
            pel_renderer_destroy(by[0]);
            pel_renderer_destroy(by[1]);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
}

static void expect_refusal(struct pel_renderer *renderer, const struct pel_scene *scene, const char *word)
{
    expect_refusal_by(renderer, scene, "peel", word);
}

static void test_refusals(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++) {
        scene.render.mode = (enum pel_mode)mode;
        if (mode != PEL_MODE_ISOSURFACE)
            expect_refusal(renderer, &scene, "raycast");
    }
    scene.render.mode = PEL_MODE_ISOSURFACE;
    set_option(renderer, "segments", "tree");
    set_option(renderer, "interior", "false");
    expect_refusal(renderer, &scene, "layer");
    set_option(renderer, "segments", "masks");
    scene.camera.focal_point[0] += 1e5; /* nothing in view */
    draw_by(renderer, &scene, "peel", WIDTH, HEIGHT, true, &image);
    assert_int_equal(hits(&image), 0);
    pel_image_finish(&image);
    scene.isosurfaces[0].value = scene.isosurfaces[1].value = 1e4; /* no active cell */
    scene.camera.focal_point[0] -= 1e5;
    draw_by(renderer, &scene, "peel", WIDTH, HEIGHT, true, &image);
    assert_int_equal(hits(&image), 0);
    assert_int_equal(frame_counter(renderer, "active cells"), 0);
    pel_image_finish(&image);
    pel_renderer_destroy(renderer);
    struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
    struct pel_renderer_params on = PEL_RENDERER_PARAMS_INIT;
    params.memory_limit = 30000;
    on.device = pel_device_create(-1, &params, NULL);
    renderer = pel_renderer_create(&on, NULL);
    expect_refusal(renderer, &scene, "whole volume");
    pel_renderer_destroy(renderer);
    pel_device_destroy(on.device);
    struct pel_renderer *cpu = pel_renderer_create(NULL, NULL);
    expect_refusal(cpu, &scene, "GPU");
    pel_renderer_destroy(cpu);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),   cmocka_unit_test(test_close_ups), cmocka_unit_test(test_scenes), cmocka_unit_test(test_exact_roots),
        cmocka_unit_test(test_changes), cmocka_unit_test(test_counters),  cmocka_unit_test(test_tiles),  cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_ranges),  cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
