/* SPDX-License-Identifier: MIT */
/* The SIMD engine where lanes go wrong first: every sample type, volumes a few voxels thin, pictures that are no multiple of the lanes,
 * rays along the faces of what they are clipped to, and lone samples that stand for no data. */
#include "pictures.h"

enum { WIDTH = 21, HEIGHT = 17 }; /* no multiples of 2, 4, 8 or 16 */

/* Where a type's values lie: v = offset + gain * (0..100), so that most of the type is used. */
static const struct spread {
    double offset, gain;
} spreads[PEL_TYPE_COUNT] = {
    [PEL_U8] = { 0, 2.5 },   [PEL_I8] = { -125, 2.5 }, [PEL_U16] = { 0, 650 },   [PEL_I16] = { -32000, 640 },
    [PEL_U32] = { 0, 4e7 },  [PEL_I32] = { -2e9, 4e7 }, [PEL_F32] = { -0.5, 0.01 }, [PEL_F64] = { 1e3, 1e2 },
};
static struct spread spread;

static double waves(const double index[3])
{
    double x = index[0], y = index[1], z = index[2];
    return spread.offset + spread.gain * (50 + 28 * sin(0.55 * x + 0.4 * z - 0.6) + 22 * cos(0.7 * y - 0.25 * x));
}

/* Much that cannot be seen, so that there is something to skip. */
static double blobs(const double index[3])
{
    double dx = index[0] - 9, dy = index[1] - 8, dz = index[2] - 7, r = sqrt(dx * dx + dy * dy + dz * dz);
    return spread.offset + spread.gain * fmax(0, 90 - 16 * r);
}

static double at(double percent)
{
    return spread.offset + spread.gain * percent;
}

struct way {
    const char *name;
    enum pel_mode mode;
    enum pel_classification classification;
    bool shade;
};

static const struct way ways[] = {
    { "composite", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, false },
    { "composite shaded", PEL_MODE_COMPOSITE, PEL_CLASSIFICATION_POST, true },
    { "isosurface", PEL_MODE_ISOSURFACE, PEL_CLASSIFICATION_POST, false },
    { "mip", PEL_MODE_MIP, PEL_CLASSIFICATION_POST, false },
};
enum { WAYS = sizeof ways / sizeof *ways };

static void make_typed_scene(struct pel_scene *scene, const struct pel_volume *volume)
{
    const struct pel_opacity_point opacities[] = { { at(25), 0 }, { at(35), 0.1 }, { at(60), 0.05 }, { at(85), 0.5 } };
    make_scene(scene, volume, NULL);
    assert_true(pel_transfer_set_opacities(&scene->transfer, opacities, 4, NULL));
    assert_true(pel_transfer_set_colormap(&scene->transfer, "viridis", at(0), at(100), NULL));
    scene->isosurfaces[0] = (struct pel_isosurface){ at(40.3), { 1, 0.9, 0.8 }, 0.4 };
    scene->isosurfaces[1] = (struct pel_isosurface){ at(61.7), { 0.4, 0.6, 1 }, 0.7 };
    scene->isosurface_count = 2;
}

static void set_way(struct pel_scene *scene, const struct way *way)
{
    scene->render.mode = way->mode;
    scene->render.classification = way->classification;
    scene->render.shade = way->shade;
}

static int pixels_seen(const struct pel_image *image)
{
    int seen = 0;
    for (int p = 0; p < image->width * image->height; p++)
        seen += image->rgba[4 * p + 3] > 0.02f;
    return seen;
}

/* Against the reference, and each step with and without skipping. */
static void check_lanes(struct pel_scene *scene, const char *name)
{
    const double steps[] = { 0.5, 0.05, 3 };
    struct pel_image image, other;
    for (int i = 0; i < WAYS; i++) {
        char what[160];
        set_way(scene, &ways[i]);
        draw_with(scene, "reference", 1, WIDTH, HEIGHT, &image);
        draw_with(scene, "raycast", 1, WIDTH, HEIGHT, &other);
        check_at_least(pixels_seen(&image), 1, "%s, %s: pixels where something is seen", name, ways[i].name);
        check_at_least(psnr(&image, &other), 50, "%s, %s: PSNR of raycast against the reference, dB", name, ways[i].name);
        pel_image_finish(&image);
        pel_image_finish(&other);
        for (int s = 0; s < 3; s++) {
            scene->render.step = steps[s];
            draw_with(scene, "raycast", 1, WIDTH, HEIGHT, &image);
            scene->render.skip = false;
            draw_with(scene, "raycast", 1, WIDTH, HEIGHT, &other);
            scene->render.skip = true;
            snprintf(what, sizeof what, "%s, %s, step %g: skip or not", name, ways[i].name, steps[s]);
            check_same_bytes(&image, &other, what);
            pel_image_finish(&image);
            pel_image_finish(&other);
        }
        scene->render.step = 0.5;
    }
}

/* How far the instruction sets are apart at most, over all cases, and where. */
static double farthest;
static char farthest_at[160];

static void compare_isas(struct pel_scene *scene, const char *name)
{
    struct pel_image image[3];
    const char *isas[3];
    int count = available_isas(isas);
    for (int i = 0; i < WAYS; i++) {
        set_way(scene, &ways[i]);
        for (int a = 0; a < count; a++)
            draw_isa(scene, isas[a], WIDTH, HEIGHT, &image[a]);
        for (int a = 0; a < count; a++)
            for (int b = a + 1; b < count; b++)
                if (largest_difference(&image[a], &image[b]) > farthest) {
                    farthest = largest_difference(&image[a], &image[b]);
                    snprintf(farthest_at, sizeof farthest_at, "%s, %s: %s against %s", name, ways[i].name, isas[a], isas[b]);
                }
        for (int a = 0; a < count; a++)
            pel_image_finish(&image[a]);
    }
}

typedef void check(struct pel_scene *scene, const char *name);

static void check_volume(enum pel_type type, const size_t dims[3], formula *f, check *what)
{
    struct pel_volume volume;
    struct pel_scene scene;
    char name[64];
    spread = spreads[type];
    make_volume(&volume, dims[0], dims[1], dims[2], type, f);
    memcpy(volume.spacing, (double[3]){ 1, 1.2, 0.9 }, sizeof volume.spacing);
    make_typed_scene(&scene, &volume);
    snprintf(name, sizeof name, "%s %zu x %zu x %zu", pel_type_name(type), dims[0], dims[1], dims[2]);
    what(&scene, name);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Of every type: one with room around its object; 2 to 5 voxels along one axis (fetches at the last voxel, cells without neighbours, maps
 * of one cell); and two along two axes and all three. */
static void check_volumes(check *what)
{
    for (int type = 0; type < PEL_TYPE_COUNT; type++) {
        check_volume((enum pel_type)type, (const size_t[3]){ 19, 17, 15 }, blobs, what);
        check_volume((enum pel_type)type, (const size_t[3]){ 2, 2, 2 }, waves, what);
        for (int axis = 0; axis < 3; axis++) {
            size_t dims[3] = { 11, 13, 9 }, stick[3] = { 2, 2, 2 };
            stick[axis] = 14;
            check_volume((enum pel_type)type, stick, waves, what);
            for (dims[axis] = 2; dims[axis] <= 5; dims[axis]++)
                check_volume((enum pel_type)type, dims, waves, what);
        }
    }
}

static void test_types_and_thin_volumes(void **state)
{
    (void)state;
    check_volumes(check_lanes);
}

static void test_instruction_sets(void **state)
{
    (void)state;
    const char *isas[3];
    if (available_isas(isas) < 2) {
        print_message("SKIPPED: this machine or this build has one instruction set of the kernels at most\n");
        skip();
    }
    farthest = 0;
    check_volumes(compare_isas);
    check_at_most(farthest, 1e-4, "%s", farthest_at);
    print_message("instruction sets: %.2g apart at most (%s)\n", farthest, farthest_at);
}

static double ball01(const double index[3])
{
    double x = index[0] - 10, y = index[1] - 12, z = index[2] - 13;
    return exp(-(x * x + y * y + z * z) / 200);
}

static const double views[6][3] = { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } };

/* No pixel differs from the reference by more than 0.02, in any of the modes. */
static void check_close(struct pel_scene *scene, int size, const char *name)
{
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        for (int kind = 0; kind < (mode == PEL_MODE_COMPOSITE ? 3 : 1); kind++) {
            struct pel_image truth, image;
            scene->render.mode = (enum pel_mode)mode;
            scene->render.classification = (enum pel_classification)kind;
            scene->render.shade = mode == PEL_MODE_COMPOSITE && kind == 0;
            draw(scene, "reference", size, size, &truth);
            draw(scene, "raycast", size, size, &image);
            check_at_least(pixels_seen(&truth), 20, "%s, mode %d: pixels where something is seen", name, mode);
            check_at_most(largest_difference(&truth, &image), 0.02, "%s, mode %d, classification %d: against the reference", name, mode,
                          kind);
            pel_image_finish(&truth);
            pel_image_finish(&image);
        }
}

static void make_cube(struct pel_volume *volume, struct pel_scene *scene, formula *f)
{
    make_volume(volume, 24, 24, 24, PEL_F32, f);
    make_scene(scene, volume, "0:0.02,0.5:0.05,1:0.3");
    assert_true(pel_transfer_set_colormap(&scene->transfer, "viridis", 0, 1, NULL));
    scene->render.step = 1;
    scene->isosurfaces[0] = (struct pel_isosurface){ 0.613, { 1, 0.9, 0.8 }, 0.6 };
    scene->isosurface_count = 1;
    pel_volume_index_to_world(volume, (const double[3]){ 11.3, 11.4, 11.2 }, scene->slice.origin);
    memcpy(scene->slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof scene->slice.normal);
}

/* One pixel a voxel: the outermost rays run along the faces of the box, and none is lost. */
static void test_along_faces(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    char name[64];
    make_cube(&volume, &scene, ball01);
    for (int view = 0; view < 6; view++)
        for (int size = 24; size <= 25 - view % 2; size++) { /* 25: rays between the voxels, the outermost beside the box */
            look_parallel(&scene, views[view], 40, size / 2.0);
            snprintf(name, sizeof name, "view %d, %d pixels", view, size);
            check_close(&scene, size, name);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* The same of a homogeneous cube, whose answer is known: all 24 x 24 rays pass 23 voxels, those in the faces too. */
static void test_faces_are_seen(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_cube(&volume, &scene, constant_one);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "0.05", NULL));
    for (int t = 0; techniques[t]; t++)
        for (int view = 0; view < 6; view++)
            for (int kind = 0; kind < 4; kind++) {
                struct pel_image image;
                double worst = 0;
                look_parallel(&scene, views[view], 40, 12);
                scene.render.mode = kind < 3 ? PEL_MODE_COMPOSITE : PEL_MODE_XRAY;
                scene.render.classification = (enum pel_classification)(kind % 3);
                draw(&scene, techniques[t], 24, 24, &image);
                for (int y = 0; y < 24; y++)
                    for (int x = 0; x < 24; x++)
                        worst = fmax(worst, fabs(channel(&image, x, y, 3) - (1 - pow(0.95, 23))));
                check_at_most(worst, 1e-4, "%s: view %d, kind %d, alpha of a cube with its faces", techniques[t], view, kind);
                pel_image_finish(&image);
            }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A clip plane, then a face of the clip box, through the centre and seen edge-on: with an odd number of pixels a row of rays lies in it. */
static void test_along_clips(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    char name[64];
    make_cube(&volume, &scene, ball01);
    for (int view = 0; view < 6; view += 2)
        for (int axis = 0; axis < 3; axis++)
            for (int side = 0; side < 2; side++) {
                if (axis == view / 2)
                    continue; /* seen face-on */
                look_parallel(&scene, views[view], 40, 13.5);
                scene.clip_plane_count = 1;
                scene.clip_planes[0] = (struct pel_plane){ { 11.5, 11.5, 11.5 }, { 0, 0, 0 } };
                scene.clip_planes[0].normal[axis] = side ? -1 : 1;
                snprintf(name, sizeof name, "view %d, clip plane across %d, side %d", view, axis, side);
                check_close(&scene, 27, name);
                scene.clip_plane_count = 0;
                scene.clip_box_enabled = true;
                memcpy(scene.clip_box, (double[6]){ -9, 99, -9, 99, -9, 99 }, sizeof scene.clip_box);
                scene.clip_box[2 * axis + side] = 11.5;
                snprintf(name, sizeof name, "view %d, clip box face across %d, side %d", view, axis, side);
                check_close(&scene, 27, name);
                scene.clip_box_enabled = false;
            }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A dark volume in which whatever lies above its values would be white. */
static double dim(const double index[3])
{
    return 0.4 + 0.05 * sin(index[0] + 0.5 * index[1] - 0.7 * index[2]);
}

static void check_dim(struct pel_scene *scene, const char *name)
{
    const enum pel_mode modes[] = { PEL_MODE_COMPOSITE, PEL_MODE_COMPOSITE, PEL_MODE_COMPOSITE, PEL_MODE_COMPOSITE, PEL_MODE_MIP,
                                    PEL_MODE_MINIP,     PEL_MODE_AVERAGE,   PEL_MODE_ISOSURFACE };
    for (int i = 0; i < 8; i++) {
        struct pel_image truth, image;
        double brightest = 0;
        scene->render.mode = modes[i];
        scene->render.classification = (enum pel_classification)(i % 3);
        scene->render.shade = i == 3;
        draw(scene, "reference", WIDTH, HEIGHT, &truth);
        draw(scene, "raycast", WIDTH, HEIGHT, &image);
        for (int p = 0; p < 4 * WIDTH * HEIGHT; p++)
            if (p % 4 < 3 && !((double)image.rgba[p] <= brightest))
                brightest = isnan(image.rgba[p]) ? INFINITY : (double)image.rgba[p];
        if (modes[i] != PEL_MODE_ISOSURFACE) {
            check_at_least(pixels_seen(&truth), 50, "%s, way %d: pixels where something is seen", name, i);
            check_at_most(brightest, 0.25, "%s, way %d: brightest channel", name, i);
        } else {
            check_at_most(brightest, 0, "%s, way %d: a surface between a voxel and what is no data", name, i);
        }
        check_at_most(largest_difference(&truth, &image), 2e-3, "%s, way %d: against the reference", name, i);
        pel_image_finish(&truth);
        pel_image_finish(&image);
    }
}

/* A lone sample that is not finite, in each corner of a cell in the middle and in each corner of the volume: only the cells that read it
 * are lost, and nothing lights up. */
static void test_lone_infinite(void **state)
{
    (void)state;
    const double values[] = { INFINITY, -INFINITY, NAN };
    const struct pel_color_point colors[] = { { 0, { 0.9, 0.9, 0.9 } }, { 0.3, { 0.2, 0.2, 0.2 } }, { 0.5, { 0.2, 0.2, 0.2 } },
                                              { 0.6, { 1, 1, 1 } } };
    struct pel_volume volume;
    struct pel_scene scene;
    char name[96];
    make_volume(&volume, 8, 7, 9, PEL_F32, dim);
    make_scene(&scene, &volume, "0:0.9,0.3:0.1,0.5:0.15,0.6:1");
    assert_true(pel_transfer_set_colors(&scene.transfer, colors, 4, NULL));
    scene.isosurfaces[0] = (struct pel_isosurface){ 0.7, { 1, 1, 1 }, 1 };
    scene.isosurfaces[1] = (struct pel_isosurface){ 0.1, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 2;
    for (int corner = 0; corner < 16; corner++)
        for (int v = 0; v < (corner < 8 ? 3 : 1); v++) {
            size_t i[3];
            for (int axis = 0; axis < 3; axis++) {
                size_t up = (size_t)(corner >> axis & 1);
                i[axis] = corner < 8 ? 3 + up : up * (volume.dims[axis] - 1);
            }
            float *sample = (float *)volume.data + (i[2] * volume.dims[1] + i[1]) * volume.dims[0] + i[0], old = *sample;
            *sample = (float)values[v];
            scene.camera.parallel = corner & 1;
            snprintf(name, sizeof name, "%g at %zu %zu %zu", values[v], i[0], i[1], i[2]);
            check_dim(&scene, name);
            *sample = old;
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Wide numbers of which a float cannot tell one from the next: the void value in a quarter of the volume, its neighbours in value in the
 * three others, and the ends of the range in one corner. */
static double void_number, void_nearby, void_ends;

static double quarters(const double index[3])
{
    bool right = index[0] >= 8, low = index[1] >= 8;
    if (index[2] < 2 && index[0] == 0 && index[1] == 0)
        return index[2] < 1 ? -void_ends : void_ends;
    if (right)
        return low ? void_number + void_nearby : void_number;
    return low ? void_number + 2 * void_nearby : void_number - void_nearby;
}

static void check_quarters(enum pel_type type, const char *name)
{
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 16, 16, 16, type, quarters);
    volume.has_void = true;
    volume.void_value = void_number;
    pel_volume_update_range(&volume);
    make_scene(&scene, &volume, "0.1");
    look_parallel(&scene, (const double[3]){ 0, 0, 1 }, 40, 8);
    scene.render.step = 1;
    for (int t = 0; techniques[t]; t++)
        for (int i = 0; i < 2 * 8; i++) {
            const enum pel_mode modes[] = { PEL_MODE_COMPOSITE, PEL_MODE_COMPOSITE, PEL_MODE_COMPOSITE, PEL_MODE_COMPOSITE,
                                            PEL_MODE_MIP,       PEL_MODE_MINIP,     PEL_MODE_AVERAGE,   PEL_MODE_XRAY };
            struct pel_image image;
            int wrong = 0, first = -1;
            scene.render.mode = modes[i % 8];
            scene.render.classification = (enum pel_classification)(i % 8 % 3);
            scene.render.shade = i % 8 == 3;
            scene.render.reconstruction = i >= 8 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
            bool one = modes[i % 8] == PEL_MODE_MIP || modes[i % 8] == PEL_MODE_MINIP || modes[i % 8] == PEL_MODE_AVERAGE;
            double full = one ? 0.1 : 1 - pow(0.9, 15);
            draw(&scene, techniques[t], 16, 16, &image); /* a pixel a voxel: index x is the column, or its mirror */
            for (int y = 0; y < 16; y++)
                for (int x = 0; x < 16; x++) {
                    double origin[3], direction[3], index[3];
                    pel_camera_ray(&scene.camera, 16, 16, x, y, origin, direction);
                    pel_volume_world_to_index(&volume, origin, index);
                    /* On the border of the voids either answer may be right, and it does not matter here. */
                    bool beside = index[0] > 6.5 && index[1] < 8.5, border = beside && (index[0] < 8.5 || index[1] > 6.5);
                    bool empty = index[0] > 7.5 && index[1] < 7.5;
                    if (!border && !(fabs(channel(&image, x, y, 3) - (empty ? 0 : full)) <= 1e-4)) {
                        first = first < 0 ? y * 16 + x : first;
                        wrong++;
                    }
                }
            check_at_most(wrong, 0, "%s, %s, way %d: pixels with a wrong opacity, first (%d, %d)", techniques[t], name, i, first % 16,
                          first / 16);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_void_neighbours(void **state)
{
    (void)state;
    const double numbers[] = { 1234567890, -1999999937 };
    void_nearby = 30;
    void_ends = 2e9;
    for (int i = 0; i < 2; i++) {
        char name[64];
        void_number = numbers[i];
        snprintf(name, sizeof name, "i32 with void %.0f", void_number);
        check_quarters(PEL_I32, name);
    }
    void_number = 0.1;
    void_nearby = 1e-12;
    void_ends = 1e3;
    check_quarters(PEL_F64, "f64 with void 0.1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types_and_thin_volumes),
        cmocka_unit_test(test_instruction_sets),
        cmocka_unit_test(test_along_faces),
        cmocka_unit_test(test_faces_are_seen),
        cmocka_unit_test(test_along_clips),
        cmocka_unit_test(test_lone_infinite),
        cmocka_unit_test(test_void_neighbours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
