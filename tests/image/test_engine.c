/* SPDX-License-Identifier: MIT */
/* The SIMD engine against the reference, and against itself: threads, skipping, instruction sets and what it remembers between draws must
 * not be seen in the picture. */
#include "pictures.h"

enum { SIZE = 72 };

/* One way to draw: mode, classification and the switches that matter to it. */
struct way {
    const char *name;
    enum pel_mode mode;
    enum pel_classification classification;
    bool shade, jitter, linear_light, parallel;
};

static const struct way ways[] = {
    { "post", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, .shade = false },
    { "post shaded", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, .shade = true },
    { "post shaded jitter", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, .shade = true, .jitter = true },
    { "post shaded linear light", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, .shade = true, .linear_light = true },
    { "post shaded parallel", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, .shade = true, .parallel = true },
    { "pre", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PRE, .shade = false },
    { "pre shaded", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PRE, .shade = true, .jitter = true },
    { "preintegrated", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PREINTEGRATED, .shade = false },
    { "preintegrated shaded", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PREINTEGRATED, .shade = true },
    { "preintegrated linear light", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PREINTEGRATED, .linear_light = true, .jitter = true },
    { "mip", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, .shade = false },
    { "mip jitter", PEL_MODE_MIP, PEL_CLASSIFICATION_PRE, .shade = true, .jitter = true },
    { "minip", PEL_MODE_MINIP, PEL_CLASSIFICATION_POST, .shade = false },
    { "average", PEL_MODE_AVERAGE, PEL_CLASSIFICATION_POST, .jitter = true },
    { "xray", PEL_MODE_XRAY, PEL_CLASSIFICATION_POST, .shade = false },
    { "xray jitter parallel", PEL_MODE_XRAY, PEL_CLASSIFICATION_PREINTEGRATED, .jitter = true, .parallel = true },
    { "isosurface", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, .shade = false },
    { "isosurface linear light parallel", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, .linear_light = true, .parallel = true },
    { "slice", PEL_MODE_SLICE, PEL_CLASSIFICATION_POST, .shade = false },
};
enum { WAYS = sizeof ways / sizeof *ways };

static void set_way(struct pel_scene *scene, const struct way *way)
{
    scene->render.mode = way->mode;
    scene->render.classification = way->classification;
    scene->render.shade = way->shade;
    scene->render.jitter = way->jitter;
    scene->linear_light = way->linear_light;
    scene->camera.parallel = way->parallel;
}

/* A scene whose surfaces, slice and clip planes say something about the volume; `low` and `high` are values that bound its object. */
static void make_full_scene(struct pel_scene *scene, const struct pel_volume *volume, double low, double high)
{
    struct pel_error error = PEL_ERROR_INIT;
    const double d = high - low;
    make_scene(scene, volume, NULL);
    const struct pel_opacity_point opacities[] = { { low, 0 },             { low + 0.1 * d, 0.05 }, { low + 0.3 * d, 0.02 },
                                                   { low + 0.5 * d, 0.3 }, { low + 0.8 * d, 0.25 }, { high, 0.8 } };
    if (!pel_transfer_set_opacities(&scene->transfer, opacities, 6, &error) ||
        !pel_transfer_set_colormap(&scene->transfer, "viridis", low, high, &error))
        fail_msg("%s", error.message);
    scene->isosurfaces[0] = (struct pel_isosurface){ low + 0.6 * d, { 1, 0.9, 0.8 }, 1 };
    scene->isosurfaces[1] = (struct pel_isosurface){ low + 0.25 * d, { 0.4, 0.6, 1 }, 0.3 };
    scene->isosurface_count = 2;
    const double middle[3] = { (double)volume->dims[0] * 0.47, (double)volume->dims[1] * 0.47, (double)volume->dims[2] * 0.47 };
    pel_volume_index_to_world(volume, middle, scene->slice.origin);
    memcpy(scene->slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof scene->slice.normal);
    scene->more_slices[0] = scene->more_slices[1] = scene->slice; /* three that cross */
    memcpy(scene->more_slices[0].normal, (double[3]){ 1, 0, 0 }, sizeof scene->slice.normal);
    memcpy(scene->more_slices[1].normal, (double[3]){ 0.3, 1, 2 }, sizeof scene->slice.normal);
    scene->more_slice_count = 2;
}

/* A computed data set, `size` samples along each axis; parameters as text, in pairs, NULL at the end. */
static void compute(struct pel_volume *volume, const char *name, const char *const settings[])
{
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_dataset *dataset = pel_dataset_find(name);
    assert_non_null(dataset);
    void *params = pel_dataset_create_params(dataset);
    assert_non_null(params);
    for (int i = 0; settings[i]; i += 2) {
        const struct pel_option *row = pel_option_find(dataset->options, settings[i]);
        if (!row || !pel_option_set(row, params, settings[i + 1], &error))
            fail_msg("%s: %s: %s", name, settings[i], error.message);
    }
    pel_volume_init(volume);
    if (!pel_dataset_make(dataset, params, volume, &error))
        fail_msg("%s", error.message);
    free(params);
}

/* Every way of drawing at half a voxel: PSNR of the engine against the reference, 50 dB or more; depth in all but a few pixels. */
static void check_against_reference(struct pel_scene *scene, const char *name)
{
    double worst = INFINITY;
    const float near = 0.01f * (float)pel_volume_least_spacing(scene->volume);
    scene->render.step = 0.5;
    /* The least value along a ray is mostly that of empty space, the mean is near it: they get an opacity that shows it. */
    const struct pel_opacity_point ramp[] = { { scene->volume->range[0], 0.3 }, { scene->volume->range[1], 1 } };
    struct pel_transfer composite = scene->transfer, all_seen;
    assert_true(pel_transfer_init(&all_seen, NULL) && pel_transfer_copy(&all_seen, &composite, NULL));
    assert_true(pel_transfer_set_opacities(&all_seen, ramp, 2, NULL));
    for (int i = 0; i < WAYS; i++) {
        struct pel_image truth, image;
        int off = 0, seen = 0;
        set_way(scene, &ways[i]);
        scene->transfer = ways[i].mode == PEL_MODE_MINIP || ways[i].mode == PEL_MODE_AVERAGE ? all_seen : composite;
        draw(scene, "reference", SIZE, SIZE, &truth);
        draw(scene, "raycast", SIZE, SIZE, &image);
        for (int p = 0; p < SIZE * SIZE; p++) {
            seen += truth.rgba[4 * p + 3] > 0.02f;
            /* A sample more or less until the half is reached, or another of two equal extremes: in a few pixels rounding may decide. */
            off += !(truth.depth[p] == image.depth[p] || fabsf(truth.depth[p] - image.depth[p]) < near);
        }
        double found = psnr(&truth, &image);
        worst = fmin(worst, found);
        check_at_least(seen, SIZE * SIZE / 40, "%s, %s: pixels where something is seen", name, ways[i].name);
        check_at_least(found, 50, "%s, %s: PSNR of raycast against the reference, dB", name, ways[i].name);
        check_at_most(off, SIZE * SIZE / 50, "%s, %s: pixels whose depth differs", name, ways[i].name);
        pel_image_finish(&truth);
        pel_image_finish(&image);
    }
    scene->transfer = composite;
    pel_transfer_finish(&all_seen);
    print_message("%s: least PSNR %.1f dB\n", name, worst);
}

static void test_marschner_lobb(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    compute(&volume, "marschner-lobb", (const char *const[]){ "size", "41", NULL });
    make_full_scene(&scene, &volume, 0.3, 1);
    check_against_reference(&scene, "Marschner-Lobb");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_hydrogen(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    compute(&volume, "hydrogen", (const char *const[]){ "size", "64", NULL });
    make_full_scene(&scene, &volume, 0.002 * volume.range[1], 0.2 * volume.range[1]);
    check_against_reference(&scene, "hydrogen");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_bonsai(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    if (!read_real(&volume, "bonsai.nii.gz"))
        skip();
    make_full_scene(&scene, &volume, 30, 160);
    check_against_reference(&scene, "bonsai");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A small volume with everything in it: materials, empty space, a hole of NaN. */
static double assortment(const double index[3])
{
    double x = index[0] - 18, y = index[1] - 15, z = index[2] - 21, r = sqrt(x * x + y * y + z * z);
    if (fabs(x + 4) < 2 && fabs(y) < 2 && fabs(z - 3) < 3)
        return NAN;
    return r > 13 ? 0 : r > 8 ? 40 + 10 * sin(x * 0.7) : 90 + 20 * cos(y * 0.9 + z * 0.4);
}

struct assorted {
    struct pel_volume volume;
    struct pel_scene scene;
};

static int make_assorted(void **state)
{
    struct assorted *a = calloc(1, sizeof *a);
    make_volume(&a->volume, 37, 31, 43, PEL_F32, assortment);
    memcpy(a->volume.spacing, (double[3]){ 1, 1.3, 0.9 }, sizeof a->volume.spacing);
    make_full_scene(&a->scene, &a->volume, 5, 110);
    a->scene.render.step = 0.7;
    a->scene.render.termination = 0.98;
    a->scene.clip_plane_count = 1;
    pel_volume_index_to_world(&a->volume, (const double[3]){ 20, 20, 20 }, a->scene.clip_planes[0].origin);
    memcpy(a->scene.clip_planes[0].normal, (double[3]){ 1, 5, 5 }, sizeof a->scene.clip_planes[0].normal);
    *state = a;
    return 0;
}

static int finish_assorted(void **state)
{
    struct assorted *a = *state;
    pel_scene_finish(&a->scene);
    pel_volume_finish(&a->volume);
    free(a);
    return 0;
}

static void test_threads(void **state)
{
    struct assorted *a = *state;
    for (int t = 0; techniques[t]; t++)
        for (int i = 0; i < WAYS; i++) {
            struct pel_image one, image;
            char what[96];
            set_way(&a->scene, &ways[i]);
            draw_with(&a->scene, techniques[t], 1, SIZE, SIZE - 5, &one);
            for (int threads = 2; threads <= 3; threads++) {
                draw_with(&a->scene, techniques[t], threads, SIZE, SIZE - 5, &image);
                snprintf(what, sizeof what, "%s, %s: 1 thread against %d", techniques[t], ways[i].name, threads);
                check_same_bytes(&one, &image, what);
                pel_image_finish(&image);
            }
            pel_image_finish(&one);
        }
}

/* Every mode, classification, shade, jitter, reconstruction and projection, with and without skipping. */
static void check_skipping(struct pel_scene *scene, const char *name)
{
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        for (int variant = 0; variant < 3 * 2 * 2 * 2 * 2; variant++) {
            struct pel_image with, without;
            char what[128];
            scene->render.mode = (enum pel_mode)mode;
            scene->render.classification = (enum pel_classification)(variant % 3);
            scene->render.shade = variant / 3 & 1;
            scene->render.jitter = variant / 6 & 1;
            scene->render.reconstruction = variant / 12 & 1 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
            scene->camera.parallel = variant / 24 & 1;
            if (mode != PEL_MODE_COMPOSITE && variant % 6)
                continue; /* classification and shade concern composite alone */
            scene->render.skip = true;
            draw(scene, "raycast", 40, 36, &with);
            scene->render.skip = false;
            draw(scene, "raycast", 40, 36, &without);
            snprintf(what, sizeof what, "%s, mode %d, classification %d, shade %d, jitter %d, nearest %d, parallel %d: skip or not",
                     name, mode, variant % 3, variant / 3 & 1, variant / 6 & 1, variant / 12 & 1, variant / 24 & 1);
            check_same_bytes(&with, &without, what);
            pel_image_finish(&with);
            pel_image_finish(&without);
        }
}

static void test_skipping(void **state)
{
    struct assorted *a = *state;
    check_skipping(&a->scene, "assortment");
    a->scene.render.termination = 1;
    a->scene.clip_plane_count = 0;
    a->scene.linear_light = true;
    a->scene.render.step = 1.7;
    check_skipping(&a->scene, "assortment, long steps");
}

/* The same through integer samples and a sparse object: most of the volume is passed over. */
static double sparse(const double index[3])
{
    double x = index[0] - 30, y = index[1] - 31, z = index[2] - 29, r = sqrt(x * x + y * y);
    return fabs(r - 18) < 1.5 && fabs(z) < 20 ? 200 : fabs(z - 0.4 * x) < 0.7 ? 60 : 0;
}

static double sparse_small(const double index[3])
{
    double x = index[0] - 10, y = index[1] - 10, z = index[2] - 11;
    return fmax(0, 210 - 24 * sqrt(x * x + y * y + z * z));
}

static void test_skipping_sparse(void **state)
{
    (void)state;
    const enum pel_type types[] = { PEL_U8, PEL_I16 };
    for (int i = 0; i < 2; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_volume(&volume, 64, 61, 58, types[i], sparse);
        make_full_scene(&scene, &volume, 30, 220);
        scene.render.step = 1;
        check_skipping(&scene, pel_type_name(types[i]));
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* Single voxels and a thin sheet: surfaces that lie in few voxel cells, and voxels that have an isovalue exactly. */
static double grains(const double index[3])
{
    unsigned i = (unsigned)index[0] * 73856093u ^ (unsigned)index[1] * 19349663u ^ (unsigned)index[2] * 83492791u;
    return fabs(index[0] + 0.3 * index[1] - 0.6 * index[2] - 4) < 0.6 ? 55 : (i >> 7) % 40 ? 0 : i & 1 ? 40 : 60;
}

/* Isosurfaces are passed over voxel by voxel where a voxel covers pixels, else cell by cell: near, far, from afar, along faces, sheared. */
static void test_skipping_surfaces(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double azimuth, elevation, zoom, away;
        bool parallel;
    } views[] = {
        { "fitted", 25, 10, 1, 1, false },        { "along a face", 0, 0, 1, 1, true },
        { "zoomed in", 130, -40, 8, 1, false },   { "a voxel below a pixel", 60, 50, 1, 5, false },
        { "telephoto", 200, 5, 4e4, 4e4, false }, { "among the voxels", 300, 20, 1, 0.3, false },
        { "parallel", 250, -65, 2, 1, true },
    };
    const enum pel_type types[] = { PEL_U8, PEL_I8, PEL_U16, PEL_F32, PEL_F64 };
    for (int t = 0; t < 10; t++)
        for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_image with, without;
            char what[96];
            const enum pel_roots roots = t / 5 ? PEL_ROOTS_STEPS : PEL_ROOTS_CUBIC;
            make_volume(&volume, 41, 35, 46, types[t % 5], grains);
            memcpy(volume.spacing, (double[3]){ 1, 1.3, 0.8 }, sizeof volume.spacing);
            memcpy(volume.direction[1], (double[3]){ 0.28, 0.96, 0 }, sizeof volume.direction[1]);
            make_full_scene(&scene, &volume, 10, 60); /* isovalues 40, which voxels have, and 22.5 */
            scene.render.mode = PEL_MODE_ISOSURFACE;
            scene.render.step = 0.2;
            scene.render.roots = roots;
            pel_camera_azimuth(&scene.camera, views[i].azimuth);
            pel_camera_elevation(&scene.camera, views[i].elevation);
            scene.camera.parallel = views[i].parallel;
            for (int a = 0; a < 3; a++)
                scene.camera.position[a] =
                    scene.camera.focal_point[a] + views[i].away * (scene.camera.position[a] - scene.camera.focal_point[a]);
            pel_camera_zoom(&scene.camera, views[i].zoom);
            snprintf(what, sizeof what, "isosurfaces of %s, %s, roots %d: skip or not", pel_type_name(types[t % 5]), views[i].name, roots);
            draw(&scene, "raycast", 170, 130, &with);
            scene.render.skip = false;
            draw(&scene, "raycast", 170, 130, &without);
            check_same_bytes(&with, &without, what);
            int seen = 0;
            for (int p = 0; p < 170 * 130; p++)
                seen += without.rgba[4 * p + 3] > 0;
            check_at_least(seen, 50, "%s: pixels where something is seen", what);
            pel_image_finish(&with);
            pel_image_finish(&without);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
}

/* The same bytes with and without skipping, and no pixel farther than `allowed` from the reference; something is seen. */
static void check_picture(struct pel_scene *scene, int width, int height, double allowed, const char *what)
{
    struct pel_image with, without, truth;
    scene->render.skip = true;
    draw(scene, "raycast", width, height, &with);
    scene->render.skip = false;
    draw(scene, "raycast", width, height, &without);
    draw(scene, "reference", width, height, &truth);
    check_same_bytes(&with, &without, what);
    check_at_most(largest_difference(&with, &truth), allowed, "%s: against the reference", what);
    int seen = 0;
    for (int p = 0; p < width * height; p++)
        seen += truth.rgba[4 * p + 3] > 0;
    check_at_least(seen, scene->render.mode == PEL_MODE_MINIP ? 0 : 20, "%s: pixels where something is seen",
                   what); /* the least sample is often invisible */
    pel_image_finish(&with);
    pel_image_finish(&without);
    pel_image_finish(&truth);
}

/* Long enough for a place on the last voxel to be rounded beyond it, and with values far from 0. */
static double far_from_zero(const double index[3])
{
    return -900 + 60 * sin(index[0] * 0.13) + 12 * index[1];
}

static void test_long_volumes(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum pel_mode mode;
        enum pel_classification classification;
    } draws[] = { { "isosurface", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST },
                 { "preintegrated", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_PREINTEGRATED },
                 { "mip", PEL_MODE_MIP, PEL_CLASSIFICATION_POST },
                 { "slice", PEL_MODE_SLICE, PEL_CLASSIFICATION_POST } };
    const enum pel_type types[] = { PEL_I16, PEL_F32, PEL_F64 };
    for (int t = 0; t < 3; t++)
        for (int i = 0; i < 4; i++) {
            struct pel_volume volume;
            struct pel_scene scene;
            char what[64];
            make_volume(&volume, 700, 6, 5, types[t], far_from_zero);
            make_full_scene(&scene, &volume, -1000, -780);
            /* The end of the volume along x, where rays leave it. */
            look_parallel(&scene, (const double[3]){ 0.9, 0.3, 0.25 }, 30, 4);
            scene.camera.position[0] += 699 / 2.0;
            scene.camera.focal_point[0] += 699 / 2.0;
            memcpy(scene.slice.origin, scene.camera.focal_point, sizeof scene.slice.origin);
            memcpy(scene.slice.normal, (double[3]){ 1, 0, 0 }, sizeof scene.slice.normal);
            scene.more_slice_count = 0;
            scene.render.mode = draws[i].mode;
            scene.render.classification = draws[i].classification;
            snprintf(what, sizeof what, "long volume of %s, %s", pel_type_name(types[t]), draws[i].name);
            check_picture(&scene, 60, 50, 0.02, what);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
}

static double layers(const double index[3])
{
    double d = index[2] + 0.15 * index[0];
    return fabs(d - 5) < 1.6 ? 0.4 + 0.02 * sin(7 * index[1]) : fabs(d - 21) < 2.2 ? 0.7 + 0.02 * cos(5 * index[0]) : 0;
}

/* Many pixels a voxel, so that whole packets jump together: sums must not remember whether they did. And so many that pixel coordinates
 * leave the whole numbers. */
static void test_close_ups(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 26, 24, 27, PEL_F32, layers);
    make_full_scene(&scene, &volume, 0.05, 1);
    scene.isosurfaces[0].value = 0.3;
    scene.isosurface_count = 1;
    for (int mode = PEL_MODE_COMPOSITE; mode <= PEL_MODE_SLICE; mode++) {
        const double scales[] = { 7, 0.9, 1e-4, 1e-7 };
        for (int i = 0; i < (mode == PEL_MODE_ISOSURFACE || mode == PEL_MODE_XRAY ? 4 : 2); i++) {
            char what[64];
            scene.render.mode = (enum pel_mode)mode;
            look_parallel(&scene, (const double[3]){ 0.2, 0.3, 1 }, 40, scales[i]);
            snprintf(what, sizeof what, "close-up of mode %d, %g high", mode, scales[i]);
            check_picture(&scene, 130, 110, 0.02, what);
        }
    }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static double one_void(const double index[3])
{
    bool is = (int)index[0] == 8 && (int)index[1] == 7 && (int)index[2] == 8;
    return is ? NAN : index[2] + 0.2 * index[0];
}

/* A crossing whose segment cuts the corner of a void cell is none. The engine and the reference search in steps of their own, so single
 * pixels at the hole's edge may differ. */
static void test_surface_at_void(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image, truth;
    make_volume(&volume, 17, 16, 17, PEL_F32, one_void);
    make_full_scene(&scene, &volume, 0, 20);
    scene.isosurfaces[0] = (struct pel_isosurface){ 9.7, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 1;
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.render.step = 1.5;
    look_parallel(&scene, (const double[3]){ 0.5, 0.4, 1 }, 40, 5);
    draw(&scene, "raycast", 120, 120, &image);
    draw(&scene, "reference", 120, 120, &truth);
    int holes = 0, apart = 0;
    for (int p = 0; p < 120 * 120; p++) {
        bool empty = truth.rgba[4 * p + 3] == 0;
        holes += empty;
        apart += empty != (image.rgba[4 * p + 3] == 0);
    }
    check_at_least(holes, 100, "pixels of the hole");
    check_at_most(apart, 0.02 * holes, "pixels of the hole where engine and reference differ, of %d", holes);
    pel_image_finish(&image);
    pel_image_finish(&truth);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Nothing may depend on the unit of length. */
static void test_units(void **state)
{
    (void)state;
    const double units[] = { 1e-12, 1e12 };
    for (int i = 0; i < 2; i++)
        for (int mode = PEL_MODE_COMPOSITE; mode <= PEL_MODE_SLICE; mode++) {
            struct pel_volume volume;
            struct pel_scene scene;
            char what[64];
            make_volume(&volume, 20, 21, 22, PEL_U8, sparse_small);
            for (int a = 0; a < 3; a++)
                volume.spacing[a] = units[i];
            make_full_scene(&scene, &volume, 30, 220);
            scene.render.mode = (enum pel_mode)mode;
            look_parallel(&scene, (const double[3]){ 0, 0, 1 }, 60 * units[i], 13 * units[i]); /* along the clip plane */
            scene.clip_plane_count = 1;
            pel_volume_index_to_world(&volume, (const double[3]){ 9.6, 0, 0 }, scene.clip_planes[0].origin);
            memcpy(scene.clip_planes[0].normal, (double[3]){ 1, 0, 0 }, sizeof scene.clip_planes[0].normal);
            snprintf(what, sizeof what, "voxels of %g, mode %d", units[i], mode);
            check_picture(&scene, 50, 50, 0.02, what);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
}

static void test_instruction_sets(void **state)
{
    struct assorted *a = *state;
    const char *names[3];
    int count = available_isas(names);
    if (count < 2) {
        print_message("SKIPPED: this machine or this build has one instruction set of the kernels at most\n");
        skip();
    }
    for (int i = 0; i < WAYS; i++) {
        struct pel_image first, image;
        set_way(&a->scene, &ways[i]);
        draw_isa(&a->scene, names[0], SIZE, SIZE, &first);
        for (int isa = 1; isa < count; isa++) {
            draw_isa(&a->scene, names[isa], SIZE, SIZE, &image);
            check_at_most(largest_difference(&first, &image), 1e-4, "%s: %s against %s", ways[i].name, names[isa], names[0]);
            pel_image_finish(&image);
        }
        pel_image_finish(&first);
    }
}

/* One renderer through a series of changes gives what a new one would: nothing stale is kept. */
static void check_fresh(struct pel_renderer *renderer, const struct pel_scene *scene, const char *what)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_image kept, fresh;
    pel_image_init(&kept);
    if (!pel_image_allocate(&kept, SIZE, SIZE, true, &error) || !pel_renderer_draw(renderer, scene, "raycast", &kept, &error))
        fail_msg("%s: %s", what, error.message);
    draw(scene, "raycast", SIZE, SIZE, &fresh);
    check_same_bytes(&kept, &fresh, what);
    pel_image_finish(&kept);
    pel_image_finish(&fresh);
}

static void test_changes(void **state)
{
    struct assorted *a = *state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    assert_non_null(renderer);
    check_fresh(renderer, &a->scene, "first draw");
    assert_true(pel_transfer_parse_opacity(&a->scene.transfer, "30:0,35:0.5,60:0", NULL));
    check_fresh(renderer, &a->scene, "changed opacity");
    assert_true(pel_transfer_set_colormap(&a->scene.transfer, "plasma", 0, 60, NULL));
    check_fresh(renderer, &a->scene, "changed colours");
    a->scene.transfer.unit_distance *= 3;
    check_fresh(renderer, &a->scene, "changed unit distance");
    for (int i = 0; i < WAYS; i++) {
        set_way(&a->scene, &ways[i]);
        check_fresh(renderer, &a->scene, ways[i].name);
    }
    set_way(&a->scene, &ways[16]);
    a->scene.isosurfaces[0].value = 95;
    check_fresh(renderer, &a->scene, "changed isovalue");
    a->scene.isosurface_count = 1;
    check_fresh(renderer, &a->scene, "one isosurface less");
    set_way(&a->scene, &ways[1]);
    a->scene.render.reconstruction = PEL_RECONSTRUCTION_NEAREST;
    check_fresh(renderer, &a->scene, "changed reconstruction");
    a->scene.render.step = 0.3;
    pel_camera_azimuth(&a->scene.camera, 50);
    check_fresh(renderer, &a->scene, "changed step and camera");
    for (size_t i = 0; i < pel_volume_samples(&a->volume); i++)
        ((float *)a->volume.data)[i] = 100 - ((float *)a->volume.data)[i];
    pel_volume_update_range(&a->volume);
    pel_renderer_invalidate(renderer);
    check_fresh(renderer, &a->scene, "changed samples");
    struct pel_volume other;
    make_volume(&other, 30, 31, 32, PEL_U8, sparse);
    a->scene.volume = &other;
    pel_camera_fit(&a->scene.camera, &other, SIZE, SIZE);
    check_fresh(renderer, &a->scene, "another volume");
    pel_volume_finish(&other);
    pel_renderer_destroy(renderer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_marschner_lobb),
        cmocka_unit_test(test_hydrogen),
        cmocka_unit_test(test_bonsai),
        cmocka_unit_test_setup_teardown(test_threads, make_assorted, finish_assorted),
        cmocka_unit_test_setup_teardown(test_skipping, make_assorted, finish_assorted),
        cmocka_unit_test(test_skipping_sparse),
        cmocka_unit_test(test_skipping_surfaces),
        cmocka_unit_test(test_long_volumes),
        cmocka_unit_test(test_close_ups),
        cmocka_unit_test(test_surface_at_void),
        cmocka_unit_test(test_units),
        cmocka_unit_test_setup_teardown(test_instruction_sets, make_assorted, finish_assorted),
        cmocka_unit_test_setup_teardown(test_changes, make_assorted, finish_assorted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
