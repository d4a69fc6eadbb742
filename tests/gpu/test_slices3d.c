/* SPDX-License-Identifier: MIT */
/* View-aligned slices: no way of culling changes the picture; they give the reference's and the ray caster's picture; what they refuse; and
 * that they leave nothing behind. Skipped, loudly, where no device is usable, and where there is no real data. */
#include "on_device.h"

static void set_option(struct pel_renderer *renderer, const char *name, const char *value)
{
    set_option_of(renderer, "slices3d", name, value);
}

static void draw_slices(struct pel_renderer *renderer, const struct pel_scene *scene, int width, int height, bool depth, struct pel_image *image)
{
    draw_by(renderer, scene, "slices3d", width, height, depth, image);
}

static const char *const culls[] = { "front", "err", "ess", "ert", "ess+ert", "band" };
enum { CULLS = 6, BAND = 5 };

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

/* A camera that looks along an axis sees faces of cubes edge on; one that is turned a little does not. */
static void check_culls(struct pel_renderer *renderer, struct pel_scene *scene, int size, int directions, int stride, const char *name)
{
    for (int i = 0; i < directions; i++)
        for (int parallel = 0; parallel < 2; parallel++) {
            struct pel_image whole, culled;
            look_from(scene, i * 26 / directions);
            if (i & 1)
                pel_camera_azimuth(&scene->camera, 7);
            scene->camera.parallel = parallel;
            set_option(renderer, "cull", "none");
            draw_slices(renderer, scene, size, size * 3 / 4, false, &whole);
            for (int c = (i + parallel) % stride; c < CULLS; c += stride) {
                set_option(renderer, "cull", culls[c]);
                draw_slices(renderer, scene, size, size * 3 / 4, false, &culled);
                check_at_most(largest_difference(&whole, &culled), 1.0 / 255, "%s, direction %d, parallel %d: cull %s", name, i, parallel,
                              culls[c]);
                pel_image_finish(&culled);
            }
            pel_image_finish(&whole);
        }
}

/* Several bands, opaque shells in translucent stuff and the other way round, falling and rising, with jumps and without. */
static const char *const adversarial =
    "0:0.02,4:0.02,4:0,14:0,14:0.3,20:1,26:1,26:0,38:0,40:0.05,52:0.05,52:1,56:1,56:0.02,70:0.02,74:0,80:0,80:0.97,92:0.97,96:0,110:0.4";

static double lattice(const double index[3])
{
    return 55 + 50 * sin(index[0] * 0.55) * sin(index[1] * 0.45 + 1) * sin(index[2] * 0.5 + 2) + 4 * sin(7 * index[0] + 3 * index[1]);
}

static double lattice_with_holes(const double index[3])
{
    return (int)index[0] % 9 == 4 && (int)index[1] % 7 == 3 ? NAN : lattice(index);
}

static void test_culling(void **state)
{
    (void)state;
    need_device();
    const struct {
        enum pel_type type;
        formula *f;
        const char *opacity;
    } cases[] = { { PEL_U8, blob, NULL }, { PEL_U8, lattice, adversarial }, { PEL_F32, lattice_with_holes, adversarial }, { PEL_I16, blob, adversarial } };
    for (int i = 0; i < 4; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_renderer *renderer = gpu_renderer();
        char what[64];
        snprintf(what, sizeof what, "case %d", i);
        make_sized(&volume, &scene, (const size_t[3]){ 45, 38, 41 }, cases[i].type, cases[i].f);
        if (cases[i].opacity)
            assert_true(pel_transfer_parse_opacity(&scene.transfer, cases[i].opacity, NULL));
        scene.render.shade = i & 1;
        check_culls(renderer, &scene, 61, 26, 1, what);
        pel_renderer_destroy(renderer);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    assert_int_equal(pel_device_objects(device), 0);
}

/* All ways to sample and to classify, cubes of other sizes, and thresholds that hide much. */
static void test_culling_ways(void **state)
{
    (void)state;
    need_device();
    static const char *const edges[] = { "1", "2", "4", "8", "16", "32" };
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    for (int way = 0; way < 24; way++) {
        char what[128];
        make_sized(&volume, &scene, (const size_t[3]){ 45, 38, 41 }, PEL_U8, lattice);
        assert_true(pel_transfer_parse_opacity(&scene.transfer, adversarial, NULL));
        scene.render.classification = (enum pel_classification)(way % 3);
        scene.render.reconstruction = way / 3 & 1 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
        scene.render.shade = way / 6 & 1;
        scene.render.step = way < 12 ? 0.5 : way % 2 ? 1 : 2.3;
        scene.linear_light = way & 1;
        set_option(renderer, "cube-t", edges[way % 6]);
        set_option(renderer, "cube-p", edges[(way / 2) % 3]);
        set_option(renderer, "opaque", way & 1 ? "0.1" : "1");
        set_option(renderer, "shrink", way & 2 ? "true" : "false");
        set_option(renderer, "early-out", way & 4 ? "true" : "false");
        if (way % 4 == 3) {
            scene.clip_plane_count = 1;
            memcpy(scene.clip_planes[0].origin, scene.slice.origin, sizeof scene.slice.origin);
            memcpy(scene.clip_planes[0].normal, (double[3]){ 1, 1, 0.3 }, sizeof scene.clip_planes[0].normal);
        }
        snprintf(what, sizeof what, "way %d", way);
        check_culls(renderer, &scene, 61, 6, 1, what);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
}

/* The eye in the volume, in something visible and in nothing, near its faces, and looking away. */
static void test_eye_inside(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, (const size_t[3]){ 45, 38, 41 }, PEL_U8, lattice);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0,30:0,60:0.2,100:1", NULL));
    static const double from[][3] = { { 22, 18, 20 }, { 5, 30, 11 }, { 44, 20, 20 }, { 46, 39, 42 }, { -3, 18, 20 }, { 60, 60, 60 } };
    static const double to[][3] = { { 23, 18, 20 }, { 40, 5, 30 }, { 0, 22, 21 }, { 0, 0, 0 }, { -9, 18, 20 }, { 20, 20, 21 } };
    for (int i = 0; i < 6; i++) {
        struct pel_image whole, culled, cast;
        pel_volume_index_to_world(&volume, from[i], scene.camera.position);
        pel_volume_index_to_world(&volume, to[i], scene.camera.focal_point);
        memcpy(scene.camera.view_up, (double[3]){ 0.1, 0.9, 0.2 }, sizeof scene.camera.view_up);
        scene.camera.view_angle = 60;
        set_option(renderer, "cull", "none");
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &whole);
        for (int c = 0; c < CULLS; c++) {
            set_option(renderer, "cull", culls[c]);
            draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &culled);
            check_at_most(largest_difference(&whole, &culled), 1.0 / 255, "eye %d: cull %s", i, culls[c]);
            pel_image_finish(&culled);
        }
        draw(&scene, "raycast", WIDTH, HEIGHT, &cast);
        check_at_least(psnr(&whole, &cast), 30, "eye %d: PSNR against the ray caster, dB", i); /* few samples lie before the first opaque one */
        pel_image_finish(&cast);
        pel_image_finish(&whole);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Full pixels stopped, slices in the other order, other targets. */
static void test_orders(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image plain, other;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, (const size_t[3]){ 45, 38, 41 }, PEL_U8, lattice);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, adversarial, NULL));
    scene.render.termination = 0.998;
    for (int c = -1; c < CULLS; c++) {
        set_option(renderer, "cull", c < 0 ? "none" : culls[c]);
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &plain);
        uint64_t fragments = frame_counter(renderer, "fragments drawn");
        static const char *const slabs[] = { "1", "4", "16", "1000" };
        for (int i = 0; i < 4; i++) {
            set_option(renderer, "slab", slabs[i]);
            draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &other);
            check_at_most(largest_difference(&plain, &other), 1.0 / 255, "cull %d, slab %s", c, slabs[i]);
            if (i == 0)
                check_at_most((double)frame_counter(renderer, "fragments drawn"), 0.95 * (double)fragments, "cull %d: fragments", c);
            pel_image_finish(&other);
        }
        set_option(renderer, "slab", "0");
        set_option(renderer, "back-to-front", "true");
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &other);
        check_at_most(largest_difference(&plain, &other), 1e-5, "cull %d, back to front", c);
        set_option(renderer, "back-to-front", "false");
        pel_image_finish(&other);
        set_option(renderer, "target", "float16");
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &other);
        check_at_least(psnr(&plain, &other), 50, "cull %d, half floats", c);
        pel_image_finish(&other);
        set_option(renderer, "target", "byte");
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &other);
        check_at_least(psnr(&plain, &other), 20, "cull %d, bytes", c);
        set_option(renderer, "target", "float32");
        pel_image_finish(&other);
        pel_image_finish(&plain);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Each way culls what it should. */
static void test_what_is_culled(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, (const size_t[3]){ 61, 57, 59 }, PEL_U8, blob); /* a ball in a corner */
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0,15:0,30:0.2,60:1,110:1", NULL));
    set_option(renderer, "early-out", "false");
    uint64_t drawn[CULLS + 1];
    for (int c = 0; c <= CULLS; c++) {
        set_option(renderer, "cull", c == CULLS ? "none" : culls[c]);
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &image);
        drawn[c] = frame_counter(renderer, "fragments drawn");
        pel_image_finish(&image);
    }
    for (int c = 0; c < CULLS; c++)
        check_at_most((double)drawn[c], 0.999 * (double)drawn[CULLS], "cull %s: fragments", culls[c]);
    assert_true(drawn[2] <= drawn[1]);                         /* exits cull more than empty rays */
    assert_true(drawn[4] < drawn[2] && drawn[4] < drawn[3]);   /* both cull more than each */
    assert_true(drawn[BAND] < drawn[4] && drawn[BAND] < drawn[0]); /* and all the most */
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0,255:0", NULL));
    for (int c = 0; c < CULLS; c++) {
        set_option(renderer, "cull", culls[c]);
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &image);
        if (c != 3) /* nothing is opaque */
            assert_int_equal(frame_counter(renderer, "fragments drawn"), 0);
        pel_image_finish(&image);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* ---- the picture itself ---- */

static void make_computed(struct pel_volume *volume, const char *name, const char *size)
{
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_dataset *dataset = pel_dataset_find(name);
    void *params = pel_dataset_create_params(dataset);
    assert_true(pel_option_set(pel_option_find(dataset->options, "size"), params, size, &error));
    pel_volume_init(volume);
    if (!pel_dataset_make(dataset, params, volume, &error))
        fail_msg("%s", error.message);
    free(params);
}

static void make_ramp(struct pel_scene *scene, const struct pel_volume *volume, double low, double high)
{
    const struct pel_opacity_point points[] = { { low, 0 }, { low + 0.3 * (high - low), 0.1 }, { high, 0.8 } };
    make_scene(scene, volume, NULL);
    assert_true(pel_transfer_set_opacities(&scene->transfer, points, 3, NULL));
    assert_true(pel_transfer_set_colormap(&scene->transfer, "viridis", low, high, NULL));
}

static void check_picture(struct pel_scene *scene, int size, const char *name)
{
    struct pel_renderer *renderer = gpu_renderer();
    double worst = INFINITY;
    for (int way = 0; way < 8; way++) {
        struct pel_image truth, cast, slices;
        scene->render.shade = way & 1;
        scene->camera.parallel = way >> 1 & 1;
        scene->render.classification = way & 4 ? PEL_CLASSIFICATION_PREINTEGRATED : PEL_CLASSIFICATION_POST;
        pel_camera_azimuth(&scene->camera, 35);
        draw(scene, "reference", size, size, &truth);
        draw(scene, "raycast", size, size, &cast);
        draw_slices(renderer, scene, size, size, true, &slices);
        double found = psnr(&truth, &slices);
        worst = fmin(worst, found);
        check_at_least(found, 40, "%s, way %d: PSNR of slices against the reference, dB", name, way);
        check_at_least(psnr(&cast, &slices), 40, "%s, way %d: PSNR of slices against the ray caster, dB", name, way);
        int off = 0;
        for (int p = 0; p < size * size; p++) /* the half is reached at a sample, and the samples lie elsewhere, at most a step away */
            off += !(truth.depth[p] == slices.depth[p] || fabsf(truth.depth[p] - slices.depth[p]) <= 1.01f * (float)pel_volume_least_spacing(scene->volume));
        check_at_most(off, size * size / 50, "%s, way %d: pixels whose depth differs", name, way);
        pel_image_finish(&truth);
        pel_image_finish(&cast);
        pel_image_finish(&slices);
    }
    print_message("%s: least PSNR against the reference %.1f dB\n", name, worst);
    pel_renderer_destroy(renderer);
}

static void test_reference(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    make_computed(&volume, "marschner-lobb", "41");
    make_ramp(&scene, &volume, 0.3, 1);
    check_picture(&scene, 96, "Marschner-Lobb");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    make_computed(&volume, "hydrogen", "64");
    make_ramp(&scene, &volume, 0.002 * volume.range[1], 0.2 * volume.range[1]);
    check_picture(&scene, 96, "hydrogen");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_bonsai(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    if (!read_real(&volume, "bonsai.nii.gz"))
        skip();
    make_ramp(&scene, &volume, 30, 160);
    check_picture(&scene, 96, "bonsai");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Culling again, on volumes as they are. */
static void test_real_volumes(void **state)
{
    (void)state;
    need_device();
    static const char *const names[] = { "aneurism.nrrd", "engine.nhdr", "tooth.nhdr", "neghip.nrrd", "template_T2.nrrd", "HeadMRVolume.mhd" };
    int read = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        if (!read_real(&volume, names[i]))
            continue;
        read++;
        double lo = volume.range[0], d = volume.range[1] - lo;
        const struct pel_opacity_point bands[] = { { lo + 0.08 * d, 0 },   { lo + 0.12 * d, 0.1 }, { lo + 0.18 * d, 0 },  { lo + 0.24 * d, 0 },
                                                   { lo + 0.24 * d, 1 },   { lo + 0.3 * d, 1 },    { lo + 0.3 * d, 0.03 }, { lo + 0.5 * d, 0 },
                                                   { lo + 0.6 * d, 0.95 } };
        struct pel_renderer *renderer = gpu_renderer();
        make_ramp(&scene, &volume, lo, lo + d);
        assert_true(pel_transfer_set_opacities(&scene.transfer, bands, 9, NULL));
        scene.render.step = 1;
        scene.render.shade = true;
        check_culls(renderer, &scene, 64, DIRECTIONS, STRIDE, names[i]);
        pel_renderer_destroy(renderer);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    if (!read)
        skip();
}

/* A homogeneous medium is exact at any distance of slices, at any angle: the opacity of a slab follows its length along the ray. */
static void test_homogeneous(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_volume(&volume, 20, 21, 22, PEL_F32, constant_one);
    make_scene(&scene, &volume, "0:0.02,2:0.02");
    for (int i = 0; i < 12; i++) {
        struct pel_image truth, slices;
        int off = 0;
        scene.camera.parallel = i & 1;
        scene.camera.view_angle = i & 2 ? 90 : 30;
        scene.render.step = i & 4 ? 0.3 : 2.2;
        scene.render.classification = i & 8 ? PEL_CLASSIFICATION_PREINTEGRATED : PEL_CLASSIFICATION_POST;
        pel_camera_fit(&scene.camera, &volume, WIDTH, HEIGHT);
        pel_camera_azimuth(&scene.camera, 31 * i);
        pel_camera_elevation(&scene.camera, 20);
        draw(&scene, "reference", WIDTH, HEIGHT, &truth);
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &slices);
        for (int p = 0; p < WIDTH * HEIGHT; p++) /* a ray that passes between two slices at an edge of the box meets none */
            off += fabsf(truth.rgba[4 * p + 3] - slices.rgba[4 * p + 3]) > 2e-4f && truth.rgba[4 * p + 3] > 0.05f;
        check_at_most(off, 0, "view %d: pixels of another opacity", i);
        pel_image_finish(&truth);
        pel_image_finish(&slices);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* ---- the rest ---- */

static void expect_refusal(struct pel_renderer *renderer, const struct pel_scene *scene, const char *word)
{
    expect_refusal_by(renderer, scene, "slices3d", word);
}

static void test_refusals(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int mode = 1; mode <= PEL_MODE_SLICE; mode++) {
        scene.render.mode = (enum pel_mode)mode;
        expect_refusal(renderer, &scene, "raycast");
    }
    scene.render.mode = PEL_MODE_COMPOSITE;
    set_option(renderer, "cube-t", "7");
    expect_refusal(renderer, &scene, "edges");
    set_option(renderer, "cube-t", "8");
    set_option(renderer, "slab", "8");
    set_option(renderer, "back-to-front", "true");
    expect_refusal(renderer, &scene, "slab");
    pel_renderer_destroy(renderer);
    struct pel_renderer *cpu = pel_renderer_create(NULL, NULL);
    expect_refusal(cpu, &scene, "GPU");
    pel_renderer_destroy(cpu);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Figure 9's pictures show something, and what a changed transfer function leaves behind is what it would have made at once. */
static void test_show_and_changes(void **state)
{
    (void)state;
    need_device();
    static const char *const shows[] = { "depth", "near", "phi_t", "phi_p" };
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image, again;
    struct pel_renderer *renderer = gpu_renderer(), *fresh = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int i = 0; i < 4; i++) {
        int seen = 0;
        set_option(renderer, "show", shows[i]);
        draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &image);
        for (int p = 0; p < WIDTH * HEIGHT; p++)
            seen += image.rgba[4 * p + 3] > 0 && image.rgba[4 * p] > 0.05f && image.rgba[4 * p] < 0.95f;
        if (i < 3)
            check_at_least(seen, WIDTH * HEIGHT / 20, "show %s: pixels", shows[i]);
        pel_image_finish(&image);
    }
    set_option(renderer, "show", "picture");
    assert_true(pel_transfer_parse_opacity(&scene.transfer, adversarial, NULL));
    set_option(renderer, "cull", "none");
    draw_slices(renderer, &scene, WIDTH, HEIGHT, false, &image);
    pel_image_finish(&image);
    set_option(renderer, "cull", "band"); /* the surfaces are extracted for the function of now */
    draw_slices(renderer, &scene, WIDTH, HEIGHT, true, &image);
    draw_slices(fresh, &scene, WIDTH, HEIGHT, true, &again);
    check_same_bytes(&image, &again, "after changes");
    pel_image_finish(&image);
    pel_image_finish(&again);
    pel_renderer_destroy(fresh);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    assert_int_equal(pel_device_objects(device), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_culling),     cmocka_unit_test(test_culling_ways), cmocka_unit_test(test_eye_inside),
        cmocka_unit_test(test_orders),      cmocka_unit_test(test_what_is_culled), cmocka_unit_test(test_reference),
        cmocka_unit_test(test_bonsai),      cmocka_unit_test(test_real_volumes), cmocka_unit_test(test_homogeneous),
        cmocka_unit_test(test_refusals),    cmocka_unit_test(test_show_and_changes),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
