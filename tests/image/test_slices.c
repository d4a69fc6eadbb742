/* SPDX-License-Identifier: MIT */
/* slices2d on the CPU engine: against the reference from all sides, and what may not change a byte. */
#include <sys/mman.h>

#include "pictures.h"

enum { SIZE = 72 };

struct setting {
    const char *name, *text;
};
static const struct setting plain[] = { { NULL, NULL } };
static const struct setting fine[] = { { "supersampling", "3" }, { "intermediate", "picture" }, { "rays", "2" }, { NULL, NULL } };
static const struct setting blended[] = {
    { "supersampling", "3" }, { "intermediate", "picture" }, { "rays", "2" }, { "blend", "8" }, { NULL, NULL }
};

static const struct setting fewer[][4] = {
    { { "slice-step", "2" }, { "intermediate", "picture" } },
    { { "slice-step", "5" }, { "intermediate", "picture" } },
    { { "slice-step", "8" }, { "intermediate", "picture" }, { "supersampling", "3" } },
};

static void set_options(struct pel_renderer *renderer, const struct setting *settings)
{
    for (; settings->name; settings++)
        set_option_of(renderer, "slices2d", settings->name, settings->text);
}

static void slices(const struct pel_scene *scene, const struct setting *settings, int threads, int size, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.threads = threads;
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    assert_non_null(renderer);
    set_options(renderer, settings);
    pel_image_init(image);
    if (!pel_image_allocate(image, size, size, true, &error) || !pel_renderer_draw(renderer, scene, "slices2d", image, &error))
        fail_msg("%s", error.message);
    pel_renderer_destroy(renderer);
}

static double against_reference(const struct pel_scene *scene, const struct setting *settings, int size)
{
    struct pel_image image, truth;
    slices(scene, settings, 2, size, &image);
    draw(scene, "reference", size, size, &truth);
    double decibels = psnr(&image, &truth);
    pel_image_finish(&image);
    pel_image_finish(&truth);
    return decibels;
}

static void make_dataset(struct pel_volume *volume, const char *name)
{
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_dataset *dataset = pel_dataset_find(name);
    void *params = pel_dataset_create_params(dataset);
    assert_true(pel_option_set(pel_option_find(dataset->options, "size"), params, "40", &error));
    pel_volume_init(volume);
    if (!pel_dataset_make(dataset, params, volume, &error))
        fail_msg("%s", error.message);
    free(params);
}

static double blobs(const double index[3])
{
    double x = index[0] - 17, y = index[1] - 19, z = index[2] - 15, r = sqrt(x * x + y * y + z * z), s = hypot(x - 8, z + 5);
    return fmax(0, 200 - 18 * fabs(r - 9)) + fmax(0, 120 - 30 * s);
}

static double labels(const double index[3])
{
    return hypot(index[0] - 17, index[1] - 19) < 9 ? 1 + (int)index[2] / 9 % 3 : 0;
}

static double holes(const double index[3])
{
    return (int)index[0] / 6 % 3 == 1 && (int)index[1] / 5 % 3 == 1 ? 255 : fmin(blobs(index), 250);
}

static void make_blobs(struct pel_volume *volume, struct pel_scene *scene, enum pel_type type, formula *f)
{
    make_volume(volume, 38, 41, 35, type, f);
    make_scene(scene, volume, "20:0,60:0.05,120:0.1,200:0.4");
    assert_true(pel_transfer_set_colormap(&scene->transfer, "viridis", 0, 200, NULL));
    scene->render.shade = true;
}

/* Direction d of 26. */
static void direction(int d, double to[3])
{
    d += d >= 13;
    to[0] = d % 3 - 1, to[1] = d / 3 % 3 - 1, to[2] = d / 9 - 1;
}

/* Fine slices and rays hold the reference at 40 dB: shaded and not, in parallel and in perspective, along each axis. */
static void check_ways(struct pel_volume *volume, const char *name, double lo, double hi, double zoom)
{
    struct pel_scene scene;
    double worst = INFINITY;
    make_scene(&scene, volume, NULL);
    const struct pel_opacity_point ramp[] = { { lo, 0 }, { hi, 0.4 } };
    assert_true(pel_transfer_set_opacities(&scene.transfer, ramp, 2, NULL));
    assert_true(pel_transfer_set_colormap(&scene.transfer, "viridis", lo, hi, NULL));
    scene.render.step = 0.25;
    for (int way = 0; way<8; way += zoom> 1 ? 3 : 1) {
        scene.camera = (struct pel_camera)PEL_CAMERA_INIT;
        pel_camera_fit(&scene.camera, volume, SIZE, SIZE);
        pel_camera_azimuth(&scene.camera, 33 + 50 * way);
        pel_camera_elevation(&scene.camera, way & 4 ? 55 : 10);
        scene.camera.parallel = way & 1;
        scene.camera.view_angle /= zoom;
        scene.camera.parallel_scale /= zoom;
        scene.render.shade = way & 2;
        double found = against_reference(&scene, fine, SIZE);
        worst = fmin(worst, found);
        check_at_least(found, 40, "%s, way %d: PSNR of slices2d against the reference, dB", name, way);
    }
    print_message("%s: least PSNR %.1f dB\n", name, worst);
    pel_scene_finish(&scene);
    pel_volume_finish(volume);
}

static void test_computed(void **state)
{
    (void)state;
    struct pel_volume volume;
    make_dataset(&volume, "marschner-lobb");
    check_ways(&volume, "Marschner-Lobb", 0.3, 1, 1);
    make_dataset(&volume, "hydrogen");
    check_ways(&volume, "hydrogen", 0.002 * volume.range[1], 0.2 * volume.range[1], 1);
}

static void test_bonsai(void **state)
{
    (void)state;
    struct pel_volume volume;
    if (!read_real(&volume, "bonsai.nii.gz"))
        skip();
    check_ways(&volume, "bonsai", 30, 160, 4); /* rays no farther apart than voxels: the reference does not filter */
}

/* A homogeneous medium is exact at any distance of slices, for each ray's own length. */
static void test_homogeneous(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 24, 20, 28, PEL_F32, constant_one);
    memcpy(volume.spacing, (double[3]) { 1, 1.7, 0.6 }, sizeof volume.spacing);
    make_scene(&scene, &volume, "0.07");
    for (int parallel = 0; parallel < 2; parallel++)
        for (int turn = 0; turn < 3; turn++) {
            struct pel_image image, truth;
            pel_camera_fit(&scene.camera, &volume, 33, 33);
            pel_camera_azimuth(&scene.camera, 20 + 50 * turn);
            pel_camera_elevation(&scene.camera, 30);
            scene.camera.parallel = parallel;
            slices(&scene, fine, 2, 33, &image);
            draw(&scene, "reference", 33, 33, &truth);
            check_at_most(fabs(channel(&image, 16, 16, 3) - channel(&truth, 16, 16, 3)), 2e-4, "opacity in the middle, turn %d", turn);
            check_at_least(psnr(&image, &truth), 45, "homogeneous, parallel %d, turn %d: PSNR, dB", parallel, turn);
            pel_image_finish(&image);
            slices(&scene, fewer[turn], 2, 33, &image); /* fewer slices are thicker */
            check_at_most(fabs(channel(&image, 16, 16, 3) - channel(&truth, 16, 16, 3)), 1e-3, "opacity of fewer slices, turn %d", turn);
            pel_image_finish(&image);
            pel_image_finish(&truth);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A slice for several slices of voxels is a coarser picture of the same, and costs less. */
static void test_slice_step(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = pel_renderer_create(NULL, NULL);
    const char *const steps[] = { "1", "2", "3" };
    make_blobs(&volume, &scene, PEL_U8, blobs);
    for (int d = 0; d < 26; d += 3) {
        struct pel_image images[3];
        uint64_t samples = 0;
        double forward[3];
        direction(d, forward);
        look_parallel(&scene, forward, 120, 22);
        scene.camera.parallel = d & 1;
        scene.camera.view_angle = 25;
        for (int i = 0; i < 3; i++) {
            set_option_of(renderer, "slices2d", "slice-step", steps[i]);
            draw_by(renderer, &scene, "slices2d", SIZE, SIZE, true, &images[i]);
            if (i == 0)
                samples = frame_counter(renderer, "samples taken");
            check_at_most((double)frame_counter(renderer, "samples taken"), 1.2 * (double)samples / (i + 1), "direction %d: samples of step %s", d,
                          steps[i]);
            check_at_least(psnr(&images[0], &images[i]), 29, "direction %d: PSNR of step %s, dB", d, steps[i]);
        }
        for (int i = 0; i < 3; i++)
            pel_image_finish(&images[i]);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static uint64_t slices_within(struct pel_renderer *renderer, const struct pel_scene *scene, const char *budget)
{
    struct pel_image image;
    set_option_of(renderer, "slices2d", "budget", budget);
    for (int i = 0; i < 12; i++) { /* what pictures cost becomes known */
        draw_by(renderer, scene, "slices2d", SIZE, SIZE, false, &image);
        pel_image_finish(&image);
    }
    return frame_counter(renderer, "slices");
}

/* Where there is no time, no slice is drawn that can be left out; where there is, or nobody is in a hurry, all are. */
static void test_budget(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = pel_renderer_create(NULL, NULL);
    make_blobs(&volume, &scene, PEL_U8, blobs);
    look_parallel(&scene, (const double[3]) { 0.1, 0.2, 1 }, 120, 22);
    assert_int_equal(slices_within(renderer, &scene, "0.0001"), 1 + (35 - 1 + 7) / 8);
    assert_int_equal(slices_within(renderer, &scene, "0"), 35);
    assert_int_equal(slices_within(renderer, &scene, "10000"), 35);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* From 26 directions: near the reference, and the same bytes with and without skipping, on one thread and on two. */
static void test_directions(void **state)
{
    (void)state;
    const enum pel_type types[] = { PEL_U8, PEL_I16, PEL_F32, PEL_U16, PEL_F64, PEL_I8 };
    for (int d = 0; d < 26; d++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_image one, two, whole;
        double forward[3];
        const struct setting *settings = d % 4 == 3 ? fine : plain;
        make_blobs(&volume, &scene, types[d % 6], blobs);
        direction(d, forward);
        forward[d % 3] += 0.2;
        look_parallel(&scene, forward, 120, 22);
        scene.camera.parallel = d % 5 != 4;
        scene.camera.view_angle = 25;
        scene.render.termination = 0.97;
        slices(&scene, settings, 1, SIZE, &one);
        slices(&scene, settings, 2, SIZE, &two);
        scene.render.skip = false;
        slices(&scene, settings, 2, SIZE, &whole);
        check_same_bytes(&one, &two, "slices2d on one thread and on two");
        check_same_bytes(&one, &whole, "slices2d with and without skipping");
        scene.render.termination = 1;
        check_at_least(against_reference(&scene, fine, SIZE), 38, "direction %d: PSNR, dB", d);
        pel_image_finish(&one);
        pel_image_finish(&two);
        pel_image_finish(&whole);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* What else a scene may ask for. */
static void test_scenes(void **state)
{
    (void)state;
    const double turned[3][3] = { { 0, 0.6, 0.8 }, { 1, 0, 0 }, { 0, 0.8, -0.6 } };
    for (int way = 0; way < 6; way++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_blobs(&volume, &scene, PEL_U8, way == 2 ? labels : way == 3 ? holes : blobs);
        memcpy(volume.spacing, (double[3]) { 1, 1.6, 0.7 }, sizeof volume.spacing);
        if (way == 0) {
            memcpy(volume.direction, turned, sizeof volume.direction);
            volume.origin[1] = -300;
        } else if (way == 1) {
            scene.clip_plane_count = 1;
            pel_volume_index_to_world(&volume, (const double[3]) { 17, 20, 16 }, scene.clip_planes[0].origin);
            memcpy(scene.clip_planes[0].normal, (double[3]) { 1, 0.5, -0.4 }, sizeof scene.clip_planes[0].normal);
            scene.clip_box_enabled = true;
            memcpy(scene.clip_box, (double[6]) { 4, 34, 10, 60, 2, 30 }, sizeof scene.clip_box);
        } else if (way == 2) {
            volume.labels = true;
            assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0,1:0.1,2:0.3,3:0.05", NULL));
        } else if (way == 3) {
            volume.has_void = true;
            volume.void_value = 255;
            pel_volume_update_range(&volume);
        } else if (way == 4) {
            scene.lights[0] = (struct pel_light) { false, { 1, 2, 1 }, { 1, 0.8, 0.6 } };
            scene.linear_light = true;
        }
        pel_camera_fit(&scene.camera, &volume, SIZE, SIZE);
        pel_camera_azimuth(&scene.camera, 20 + 40 * way);
        pel_camera_elevation(&scene.camera, 15);
        scene.camera.parallel = way == 5;
        const double wanted[6] = { 40, 34, 24, 30, 36, 40 }; /* edges of labels, holes and planes fall between rays and slices */
        check_at_least(against_reference(&scene, fine, SIZE), wanted[way], "scene %d: PSNR, dB", way);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* An eye among the slices, and angles so wide that rays of one picture go along different axes. */
static void test_wide(void **state)
{
    (void)state;
    const double angles[] = { 60, 100, 140 };
    for (int i = 0; i < 3; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_blobs(&volume, &scene, PEL_F32, blobs);
        memcpy(scene.camera.position, (double[3]) { 12, 25, 9 }, sizeof scene.camera.position);
        memcpy(scene.camera.focal_point, (double[3]) { 20, 14, 19 }, sizeof scene.camera.focal_point);
        scene.camera.view_angle = angles[i];
        check_at_least(against_reference(&scene, fine, SIZE), 36, "%g degrees: PSNR, dB", angles[i]);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* On either side of 45 degrees the stack is another, and the picture nearly the same. */
static void test_switch(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image before, after;
    make_blobs(&volume, &scene, PEL_U8, blobs);
    look_parallel(&scene, (const double[3]) { 0.9999, 0.2, 1 }, 120, 22);
    slices(&scene, plain, 2, SIZE, &before);
    look_parallel(&scene, (const double[3]) { 1.0001, 0.2, 1 }, 120, 22);
    slices(&scene, plain, 2, SIZE, &after);
    check_at_least(psnr(&before, &after), 36, "the principal axis changes: PSNR, dB");
    pel_image_finish(&before);
    pel_image_finish(&after);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_depth(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image, truth;
    make_blobs(&volume, &scene, PEL_U8, blobs);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "100:0,110:0.9", NULL));
    slices(&scene, fine, 2, SIZE, &image);
    draw(&scene, "reference", SIZE, SIZE, &truth);
    int both = 0, near = 0, one = 0;
    for (int p = 0; p < SIZE * SIZE; p++) {
        bool a = isfinite(image.depth[p]), b = isfinite(truth.depth[p]);
        both += a && b;
        one += a != b;
        near += a && b && fabsf(image.depth[p] - truth.depth[p]) < 1;
    }
    check_at_least(both, SIZE * SIZE / 20, "pixels with depth");
    check_at_least(near, 0.93 * both, "pixels whose depth is within a voxel, of %d", both);
    check_at_most(one, 0.1 * both, "pixels where one alone has depth, of %d", both);
    pel_image_finish(&image);
    pel_image_finish(&truth);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* The paper's linear correction is another picture, but a like one where opacities are small. */
static void test_linear_correction(void **state)
{
    (void)state;
    const struct setting linear[] = { { "opacity-correction", "linear" }, { NULL, NULL } };
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image exact, approximate;
    make_blobs(&volume, &scene, PEL_U8, blobs);
    for (int strong = 0; strong < 2; strong++) {
        assert_true(pel_transfer_parse_opacity(&scene.transfer, strong ? "20:0,200:0.9" : "20:0,200:0.04", NULL));
        slices(&scene, plain, 2, SIZE, &exact);
        slices(&scene, linear, 2, SIZE, &approximate);
        check_at_most(largest_difference(&exact, &approximate), strong ? 0.5 : 0.03, "linear against exact, strong %d", strong);
        check_at_least(largest_difference(&exact, &approximate), strong ? 0.015 : 1e-4, "linear against exact, strong %d", strong);
        pel_image_finish(&exact);
        pel_image_finish(&approximate);
    }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Across the switch of axes a blend changes by little what a switch changes at once; away from it there is nothing to blend. */
static void test_blend(void **state)
{
    (void)state;
    const struct setting ways[2][3] = { { { "blend", "0" } }, { { "blend", "10" } } };
    const double sides[2][3] = { { 1, 0.996, 0.2 }, { 0.996, 1, 0.2 } };
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image images[2][2], one;
    make_blobs(&volume, &scene, PEL_U8, blobs);
    for (int perspective = 0; perspective < 2; perspective++) {
        double jumps[2];
        for (int way = 0; way < 2; way++) {
            for (int side = 0; side < 2; side++) {
                look_parallel(&scene, sides[side], 120, 30);
                scene.camera.parallel = !perspective;
                slices(&scene, ways[way], 2, SIZE, &images[way][side]);
            }
            jumps[way] = psnr(&images[way][0], &images[way][1]);
        }
        check_at_least(jumps[1], jumps[0] + 3, "perspective %d: likeness across the switch with a blend, against %.1f without, dB",
                       perspective, jumps[0]);
        check_at_most(largest_depth_difference(&images[0][0], &images[1][0]), 0, "depth is the main axis'");
        slices(&scene, ways[1], 1, SIZE, &one);
        check_same_bytes(&one, &images[1][1], "a blend with 1 and 2 threads");
        pel_image_finish(&one);
        for (int i = 0; i < 4; i++)
            pel_image_finish(&images[i / 2][i % 2]);
    }
    look_parallel(&scene, (double[3]) { 1, 0.7, 0.2 }, 120, 30);
    slices(&scene, ways[0], 2, SIZE, &images[0][0]);
    slices(&scene, ways[1], 2, SIZE, &images[1][0]);
    check_same_bytes(&images[0][0], &images[1][0], "a blend far from the switch");
    pel_image_finish(&images[0][0]);
    pel_image_finish(&images[1][0]);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* What slices cannot draw is refused with the name of what can; options beyond their rows are refused. */
static void test_refusals(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *renderer = pel_renderer_create(NULL, &error);
    make_blobs(&volume, &scene, PEL_U8, blobs);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 8, 8, false, &error));
    scene.render.mode = PEL_MODE_MIP;
    assert_false(pel_renderer_draw(renderer, &scene, "slices2d", &image, &error));
    assert_non_null(strstr(error.message, "raycast"));
    scene.render.mode = PEL_MODE_COMPOSITE;
    scene.render.classification = PEL_CLASSIFICATION_PREINTEGRATED;
    assert_false(pel_renderer_draw(renderer, &scene, "slices2d", &image, &error));
    assert_non_null(strstr(error.message, "raycast"));
    scene.render.classification = PEL_CLASSIFICATION_POST;
    assert_true(pel_renderer_draw(renderer, &scene, "slices2d", &image, &error));
    const struct pel_option *row = pel_option_find(pel_technique_find("slices2d")->options, "supersampling");
    *(int *)((char *)pel_renderer_options(renderer, "slices2d") + row->offset) = 11;
    assert_false(pel_renderer_draw(renderer, &scene, "slices2d", &image, &error));
    assert_non_null(strstr(error.message, "supersampling"));
    assert_null(pel_renderer_options(renderer, "reference"));
    assert_null(pel_renderer_options(renderer, "no such technique"));
    pel_renderer_destroy(renderer);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* One renderer through changes gives what a new one would. */
static void test_changes(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *renderer = pel_renderer_create(NULL, &error);
    make_blobs(&volume, &scene, PEL_U8, blobs);
    for (int step = 0; step < 10; step++) {
        struct pel_image kept, fresh;
        const struct setting *settings = step >= 8 ? blended : step >= 6 ? fine : plain;
        const int size = step == 9 ? 70 : 48;
        if (step == 1)
            assert_true(pel_transfer_parse_opacity(&scene.transfer, "60:0,90:0.3", NULL));
        if (step == 2)
            pel_camera_azimuth(&scene.camera, 80);
        if (step == 3)
            scene.camera.parallel = true;
        if (step == 4)
            scene.transfer.unit_distance *= 3;
        if (step == 5)
            scene.render.skip = false;
        if (step == 6)
            set_options(renderer, fine);
        if (step == 7)
            scene.render.skip = true;
        if (step == 8) { /* at the switch of axes, blended; then a larger picture is mixed */
            look_parallel(&scene, (double[3]) { 1, 0.99, 0.2 }, 120, 30);
            set_options(renderer, blended);
        }
        pel_image_init(&kept);
        if (!pel_image_allocate(&kept, size, size, true, &error) || !pel_renderer_draw(renderer, &scene, "slices2d", &kept, &error))
            fail_msg("%s", error.message);
        slices(&scene, settings, 2, size, &fresh);
        check_same_bytes(&kept, &fresh, "after a change");
        pel_image_finish(&kept);
        pel_image_finish(&fresh);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Memory for `bytes` that ends (or begins) where no memory is. */
struct guarded {
    char *pages, *data;
    size_t length;
};

static void guard(struct guarded *g, const void *from, size_t bytes, bool at_end)
{
    const size_t page = 4096, room = (bytes + page - 1) / page * page;
    g->length = room + 2 * page;
    g->pages = mmap(NULL, g->length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(g->pages != MAP_FAILED);
    g->data = g->pages + page + (at_end ? room - bytes : 0);
    memcpy(g->data, from, bytes);
    assert_int_equal(mprotect(g->pages, page, PROT_NONE), 0);
    assert_int_equal(mprotect(g->pages + page + room, page, PROT_NONE), 0);
}

/* Whole vectors are loaded, but never from beyond the samples. */
static void test_no_read_beyond(void **state)
{
    (void)state;
    static const enum pel_type types[] = { PEL_U8, PEL_I16, PEL_F32 };
    static const size_t dims[][3] = { { 37, 35, 33 }, { 32, 33, 5 }, { 33, 47, 3 }, { 49, 32, 2 }, { 65, 34, 1 }, { 3, 65, 36 } };
    for (int i = 0; i < 6; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct guarded memory;
        make_volume(&volume, dims[i][0], dims[i][1], dims[i][2], types[i / 2], blobs);
        make_scene(&scene, &volume, "0.02");
        scene.render.shade = true;
        void *own = volume.data;
        guard(&memory, own, dims[i][0] * dims[i][1] * dims[i][2] * pel_type_size(volume.type), i % 2 == 0);
        volume.data = memory.data;
        for (int d = 0; d < 26; d++) {
            double forward[3];
            struct pel_image with, without;
            direction(d, forward);
            look_parallel(&scene, forward, 100, 30);
            slices(&scene, plain, 1, 48, &with);
            scene.render.skip = false;
            slices(&scene, plain, 1, 48, &without);
            scene.render.skip = true;
            check_same_bytes(&with, &without, "skipping, all of it seen");
            pel_image_finish(&with);
            pel_image_finish(&without);
        }
        volume.data = own;
        munmap(memory.pages, memory.length);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

static double other_blobs(const double index[3])
{
    const double moved[3] = { index[0] + 5, index[1] - 6, index[2] + 4 };
    return blobs(moved);
}

/* What is kept for a volume and its classification is made anew when they change, with x as principal axis too, where voxels are turned. */
static void test_changes_along_axes(void **state)
{
    (void)state;
    static const char *const opacities[] = { "150:0,190:0.5", "150:0,190:0.5", "20:0,60:0.05,120:0.1,200:0.4", "100:0,110:0.6,120:0", "1:0,30:0.2" };
    struct pel_volume volumes[2];
    struct pel_scene scene, unused;
    struct pel_error error = PEL_ERROR_INIT;
    make_blobs(&volumes[0], &scene, PEL_U8, blobs);
    make_blobs(&volumes[1], &unused, PEL_U8, other_blobs);
    pel_scene_finish(&unused);
    for (int axis = 0; axis < 3; axis++) {
        struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
        struct pel_renderer *renderer = pel_renderer_create(&params, &error);
        double forward[3] = { 0.2, 0.3, 0.1 };
        assert_non_null(renderer);
        forward[axis] = 1;
        look_parallel(&scene, forward, 120, 22);
        for (int step = 0; step < 10; step++) {
            struct pel_image kept, fresh;
            scene.volume = &volumes[step / 5];
            assert_true(pel_transfer_parse_opacity(&scene.transfer, opacities[step % 5], NULL));
            if (step == 9) { /* other samples in the same memory */
                fill_volume(&volumes[1], blobs);
                pel_renderer_invalidate(renderer);
            }
            pel_image_init(&kept);
            if (!pel_image_allocate(&kept, SIZE, SIZE, true, &error) || !pel_renderer_draw(renderer, &scene, "slices2d", &kept, &error))
                fail_msg("%s", error.message);
            slices(&scene, plain, 2, SIZE, &fresh);
            check_same_bytes(&kept, &fresh, "after a change along an axis");
            pel_image_finish(&kept);
            pel_image_finish(&fresh);
        }
        fill_volume(&volumes[1], other_blobs);
        pel_renderer_destroy(renderer);
    }
    pel_scene_finish(&scene);
    pel_volume_finish(&volumes[0]);
    pel_volume_finish(&volumes[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_computed),   cmocka_unit_test(test_bonsai),  cmocka_unit_test(test_homogeneous),
        cmocka_unit_test(test_directions), cmocka_unit_test(test_scenes),  cmocka_unit_test(test_wide),
        cmocka_unit_test(test_switch),     cmocka_unit_test(test_depth),   cmocka_unit_test(test_linear_correction),
        cmocka_unit_test(test_refusals),   cmocka_unit_test(test_changes), cmocka_unit_test(test_blend),
        cmocka_unit_test(test_no_read_beyond), cmocka_unit_test(test_changes_along_axes),
        cmocka_unit_test(test_slice_step), cmocka_unit_test(test_budget),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
