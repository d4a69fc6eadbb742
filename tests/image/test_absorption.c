/* SPDX-License-Identifier: MIT */
/* Absorption and emission where the answer is known: constant boxes (equations 1.2 to 1.4), ramps, clipping, steps, units of length. */
#include "pictures.h"

enum { SIZE = 64 };

/* Greatest |alpha - (1 - exp(-tau L))| over the picture, L being the length of each pixel's ray in the box. */
static double worst_alpha(const struct pel_scene *scene, const struct pel_image *image, double tau, int *hits)
{
    double worst = 0, origin[3], direction[3], t[2];
    *hits = 0;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            bool hit = ray_stretch(scene, image->width, image->height, x, y, origin, direction, t);
            double expected = hit ? 1 - exp(-tau * (t[1] - t[0])) : 0;
            *hits += hit;
            worst = fmax(worst, fabs(channel(image, x, y, 3) - expected));
        }
    return worst;
}

/* A constant box with unequal spacings, opacity 0.3 a unit distance of 1.3, seen askew. */
static void make_box(struct pel_volume *volume, struct pel_scene *scene, bool sheared)
{
    make_volume(volume, 9, 7, 5, PEL_F32, constant_one);
    memcpy(volume->spacing, (double[3]){ 1, 1.5, 0.7 }, sizeof volume->spacing);
    memcpy(volume->origin, (double[3]){ 10, -20, 5 }, sizeof volume->origin);
    if (sheared) {
        memcpy(volume->direction[1], (double[3]){ 0.48, 0.8, 0.36 }, sizeof volume->direction[1]);
        memcpy(volume->direction[2], (double[3]){ 0, -0.28, 0.96 }, sizeof volume->direction[2]);
    }
    make_scene(scene, volume, "0.3");
    set_flat_color(scene, 0.2, 0.5, 0.9);
    scene->transfer.unit_distance = 1.3;
    scene->render.mode = PEL_MODE_XRAY;
}

static void check_box(const struct pel_scene *scene, const char *technique, const char *what)
{
    const double tau = -log(0.7) / scene->transfer.unit_distance;
    struct pel_image image;
    int hits;
    draw(scene, technique, SIZE, SIZE, &image);
    double worst = worst_alpha(scene, &image, tau, &hits);
    check_at_least(hits, 200, "%s: pixels that see the box, %s", technique, what);
    check_at_most(worst, 1e-5, "%s: error of alpha against 1 - exp(-tau L), %s", technique, what);
    pel_image_finish(&image);
}

static void test_xray_of_a_box(void **state)
{
    (void)state;
    const double steps[] = { 0.25, 0.5, 1, 7.7 };
    for (int variant = 0; variant < 8; variant++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_box(&volume, &scene, variant & 1);
        scene.camera.parallel = variant & 2;
        scene.render.jitter = variant & 4;
        for (size_t i = 0; i < sizeof steps / sizeof *steps; i++)
            for (int t = 0; techniques[t]; t++) {
                char what[80];
                scene.render.step = steps[i];
                snprintf(what, sizeof what, "%s%s%s step %g", variant & 1 ? "sheared " : "", variant & 2 ? "parallel" : "perspective",
                         variant & 4 ? " jitter" : "", steps[i]);
                check_box(&scene, techniques[t], what);
            }
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

static void test_xray_colors(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_box(&volume, &scene, false);
    for (int t = 0; techniques[t]; t++)
        for (int invert = 0; invert < 2; invert++) {
            struct pel_image image;
            double worst = 0;
            scene.render.invert = invert;
            draw(&scene, techniques[t], SIZE, SIZE, &image);
            for (int y = 0; y < SIZE; y++)
                for (int x = 0; x < SIZE; x++)
                    for (int c = 0; c < 3; c++)
                        worst = fmax(worst, fabs(channel(&image, x, y, c) - (invert ? channel(&image, x, y, 3) : 0)));
            check_at_most(worst, 1e-6, "%s: X-ray is black, or white x alpha inverted (%d)", techniques[t], invert);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_camera_inside(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_box(&volume, &scene, false);
    pel_volume_index_to_world(&volume, (const double[3]){ 3, 2, 1.5 }, scene.camera.position);
    scene.camera.view_angle = 80;
    for (int t = 0; techniques[t]; t++)
        check_box(&scene, techniques[t], "camera inside");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A volume of one slice is one spacing thick. */
static void test_lone_slice(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 12, 12, 1, PEL_U8, constant_one);
    make_scene(&scene, &volume, "0.3");
    scene.render.mode = PEL_MODE_XRAY;
    for (int t = 0; techniques[t]; t++)
        check_box(&scene, techniques[t], "a single slice");
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_clipping(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_box(&volume, &scene, true);
    double middle[3];
    pel_volume_index_to_world(&volume, (const double[3]){ 4, 3, 2 }, middle);
    for (int t = 0; techniques[t]; t++)
        for (int planes = 0; planes <= PEL_MAX_CLIP_PLANES; planes++)
            for (int box = 0; box < 2; box++) {
                char what[64];
                scene.clip_plane_count = planes;
                for (int i = 0; i < planes; i++)
                    for (int axis = 0; axis < 3; axis++) {
                        const double normal[6][3] = { { 1, 2, -1 }, { -1, 0.5, 3 }, { 0, 0, -0.1 },
                                                      { 2, -5, 1 }, { 0.1, 9, 0 },  { -8, 1, 1 } };
                        scene.clip_planes[i].normal[axis] = normal[i][axis];
                        scene.clip_planes[i].origin[axis] = middle[axis] - 1.5 * normal[i][axis] / sqrt(dot3(normal[i], normal[i]));
                    }
                scene.clip_box_enabled = box;
                for (int axis = 0; axis < 3; axis++) {
                    scene.clip_box[2 * axis] = middle[axis] - 1.25 - axis;
                    scene.clip_box[2 * axis + 1] = middle[axis] + 2.75;
                }
                scene.camera.parallel = planes & 1;
                snprintf(what, sizeof what, "%d clip planes%s", planes, box ? " and a box" : "");
                check_box(&scene, techniques[t], what);
            }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Everything is cut away: nothing is left. */
static void test_clipped_to_nothing(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_box(&volume, &scene, false);
    scene.clip_plane_count = 1;
    scene.clip_planes[0] = (struct pel_plane){ { 1000, 0, 0 }, { 1, 0, 0 } };
    const struct pel_isosurface surface = { 0.5, { 1, 1, 1 }, 1 };
    scene.isosurfaces[0] = surface;
    scene.isosurface_count = 1;
    memcpy(scene.slice.origin, volume.origin, sizeof volume.origin);
    memcpy(scene.slice.normal, (double[3]){ 0, 0, 1 }, sizeof scene.slice.normal);
    for (int t = 0; techniques[t]; t++)
        for (int mode = PEL_MODE_COMPOSITE; mode <= PEL_MODE_SLICE; mode++) {
            struct pel_image image;
            scene.render.mode = (enum pel_mode)mode;
            draw(&scene, techniques[t], 16, 16, &image);
            for (int i = 0; i < 4 * 16 * 16; i++)
                check_at_most(fabs((double)image.rgba[i]), 0, "%s: mode %d, what is clipped away", techniques[t], mode);
            for (int i = 0; i < 16 * 16; i++)
                assert_true(isinf(image.depth[i]));
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Composite of a homogeneous box: alpha as for the X-ray, colour = alpha x colour, any classification, any step. */
static void test_homogeneous_composite(void **state)
{
    (void)state;
    const double color[3] = { 0.2, 0.5, 0.9 };
    struct pel_volume volume;
    struct pel_scene scene;
    make_box(&volume, &scene, false);
    scene.render.mode = PEL_MODE_COMPOSITE;
    scene.render.ambient = 0.1, scene.render.diffuse = 0.7;
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < 6; variant++)
            for (double step = 4; step >= 0.25; step /= 4) {
                struct pel_image image;
                double worst = 0, light = variant >= 3 ? 0.8 : 1;
                int hits, kind = variant % 3;
                scene.render.classification = (enum pel_classification)kind;
                scene.render.shade = variant >= 3; /* without a slope there is ambient and diffuse light, and no highlight */
                scene.render.step = step;
                draw(&scene, techniques[t], SIZE, SIZE, &image);
                check_at_most(worst_alpha(&scene, &image, -log(0.7) / 1.3, &hits), 1e-5, "%s: alpha, classification %d, step %g",
                              techniques[t], kind, step);
                for (int y = 0; y < SIZE; y++)
                    for (int x = 0; x < SIZE; x++)
                        for (int c = 0; c < 3; c++)
                            worst = fmax(worst, fabs(channel(&image, x, y, c) - light * color[c] * channel(&image, x, y, 3)));
                check_at_most(worst, 1e-5, "%s: colour, classification %d, step %g, light %g", techniques[t], kind, step, light);
                pel_image_finish(&image);
            }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static double smooth(const double index[3])
{
    double d[3] = { index[0] - 20, index[1] - 22, index[2] - 17 };
    return exp(-dot3(d, d) / (2 * 9 * 9));
}

static double largest_alpha_difference(const struct pel_image *a, const struct pel_image *b)
{
    double largest = 0;
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++)
            largest = fmax(largest, fabs(channel(a, x, y, 3) - channel(b, x, y, 3)));
    return largest;
}

/* A smooth volume looks the same at steps 1 and 0.25, shaded or not, and where the world is measured in other units. */
static void test_step_and_scale(void **state)
{
    (void)state;
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < 6; variant++) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_image image[4];
            make_volume(&volume, 40, 44, 36, PEL_F32, smooth);
            make_scene(&scene, &volume, "0:0,0.2:0.02,1:0.12");
            assert_true(pel_transfer_set_colormap(&scene.transfer, "viridis", 0, 1, NULL));
            scene.render.shade = variant & 1;
            scene.render.classification = (enum pel_classification)(variant / 2);
            scene.render.step = 1;
            draw(&scene, techniques[t], SIZE, SIZE, &image[0]);
            scene.render.step = 0.25;
            draw(&scene, techniques[t], SIZE, SIZE, &image[1]);
            /* Opacity is what must not change; a highlight's colour, which lies within a voxel or two, may a little. */
            check_at_most(largest_alpha_difference(&image[0], &image[1]), 1.0 / 255,
                          "%s: alpha, step 1 against 0.25, classification %d, shade %d", techniques[t], variant / 2, variant & 1);
            check_at_most(largest_difference(&image[0], &image[1]), (variant & 1 ? 3.0 : 1.0) / 255,
                          "%s: colour, step 1 against 0.25, classification %d, shade %d", techniques[t], variant / 2, variant & 1);
            check_at_least(channel(&image[1], SIZE / 2, SIZE / 2, 3), 0.5, "%s: something is seen", techniques[t]);
            for (int up = 0; up < 2; up++) {
                double scale = up ? 1000 : 1e-3;
                struct pel_scene scaled = scene; /* borrows the curves of `scene` */
                struct pel_volume placed = volume;
                for (int i = 0; i < 3; i++) {
                    placed.spacing[i] *= scale, placed.origin[i] *= scale;
                    scaled.camera.position[i] *= scale, scaled.camera.focal_point[i] *= scale;
                }
                scaled.transfer.unit_distance *= scale;
                scaled.camera.parallel_scale *= scale;
                scaled.volume = &placed;
                draw(&scaled, techniques[t], SIZE, SIZE, &image[2 + up]);
                check_at_most(largest_difference(&image[1], &image[2 + up]), 1.0 / 2550, "%s: world scaled by %g", techniques[t], scale);
            }
            for (int i = 0; i < 4; i++)
                pel_image_finish(&image[i]);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
}

/* Where A first reaches a half: the middle of that segment. */
static void test_composite_depth(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 30, 30, 30, PEL_U8, constant_one);
    make_scene(&scene, &volume, "0.1");
    scene.render.mode = PEL_MODE_COMPOSITE;
    scene.render.step = 0.7;
    const double tau = -log(0.9);
    for (int t = 0; techniques[t]; t++)
        for (int parallel = 0; parallel < 2; parallel++) {
            struct pel_image image;
            double worst = 0, origin[3], direction[3], s[2];
            int reached = 0;
            scene.camera.parallel = parallel;
            draw(&scene, techniques[t], SIZE, SIZE, &image);
            for (int y = 0; y < SIZE; y++)
                for (int x = 0; x < SIZE; x++) {
                    bool hit = ray_stretch(&scene, SIZE, SIZE, x, y, origin, direction, s);
                    double expected = INFINITY, count = ceil(log(2) / tau / 0.7);
                    if (hit && tau * (s[1] - s[0]) >= log(2) + 1e-3)
                        expected = s[0] + fmin((count - 0.5) * 0.7, ((count - 1) * 0.7 + s[1] - s[0]) / 2);
                    else if (hit && tau * (s[1] - s[0]) > log(2) - 1e-3)
                        continue;
                    if (isinf(expected)) {
                        assert_true(isinf(depth_at(&image, x, y)));
                    } else {
                        reached++;
                        worst = fmax(worst, fabs(depth_at(&image, x, y) - expected));
                    }
                }
            check_at_least(reached, 500, "%s: pixels with a depth", techniques[t]);
            check_at_most(worst, 1e-3, "%s: depth of half opacity", techniques[t]);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static double ramp(const double index[3])
{
    return index[2] / 16;
}

/* Integral of -ln(1 - o(z)) over 0..16 along a ramp, by the midpoint rule with so many points that its error does not matter. */
static double ramp_integral(double (*opacity)(double z))
{
    double sum = 0;
    for (int i = 0; i < 200000; i++)
        sum -= log(1 - opacity(16 * (i + 0.5) / 200000)) * 16 / 200000;
    return sum;
}

static double post_opacity(double z)
{
    return z / 16 < 0.33 ? 0.01 : z / 16 < 0.7 ? 0.01 + (z / 16 - 0.33) / 0.37 * 0.3 : 0.05;
}

static double pre_opacity(double z)
{
    double base = floor(z), x = z - base;
    return post_opacity(base) * (1 - x) + post_opacity(base + 1) * x;
}

/* Along a ramp the preintegrated opacity is exact at any step; post and pre come to their own integrals as the step shrinks. */
static void test_classifications(void **state)
{
    (void)state;
    static const struct {
        enum pel_classification kind;
        double step, allowed;
        double (*opacity)(double z);
    } rows[] = {
        { PEL_CLASSIFICATION_POST, 1.0 / 64, 1e-3, post_opacity },
        { PEL_CLASSIFICATION_PRE, 1.0 / 64, 1e-3, pre_opacity },
        { PEL_CLASSIFICATION_PREINTEGRATED, 0.5, 3e-4, post_opacity },
        { PEL_CLASSIFICATION_PREINTEGRATED, 3.3, 3e-4, post_opacity },
        { PEL_CLASSIFICATION_PREINTEGRATED, 100, 3e-4, post_opacity },
    };
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 5, 5, 17, PEL_F32, ramp);
    make_scene(&scene, &volume, "0:0.01,0.33:0.01,0.7:0.31,0.7:0.05");
    set_flat_color(&scene, 1, 0.5, 0.25);
    for (int t = 0; techniques[t]; t++)
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
            for (int back = 0; back < 2; back++) {
                struct pel_image image;
                double expected = 1 - exp(-ramp_integral(rows[i].opacity));
                look_parallel(&scene, (const double[3]){ 0, 0, back ? -1 : 1 }, 20, 1);
                scene.render.classification = rows[i].kind;
                scene.render.step = rows[i].step;
                draw(&scene, techniques[t], 4, 4, &image);
                check_at_most(fabs(channel(&image, 1, 2, 3) - expected), rows[i].allowed,
                              "%s: classification %d, step %g, alpha (%g expected)", techniques[t], (int)rows[i].kind, rows[i].step,
                              expected);
                check_at_most(fabs(channel(&image, 1, 2, 1) - expected / 2), rows[i].allowed, "%s: classification %d, step %g, green",
                              techniques[t], (int)rows[i].kind, rows[i].step);
                pel_image_finish(&image);
            }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Equation 1.8 in full, with colours that change along the ray: each classification against the integral, at a small step. */
static void test_emission(void **state)
{
    (void)state;
    const struct pel_color_point colors[] = { { 0, { 1, 0, 0 } }, { 0.5, { 0, 1, 0.5 } }, { 1, { 0, 0, 1 } } };
    struct pel_volume volume;
    struct pel_scene scene;
    double expected[3] = { 0, 0, 0 }, transparency = 1;
    make_volume(&volume, 5, 5, 17, PEL_F32, ramp);
    make_scene(&scene, &volume, "0:0.05,1:0.2");
    assert_true(pel_transfer_set_colors(&scene.transfer, colors, 3, NULL));
    look_parallel(&scene, (const double[3]){ 0, 0, 1 }, 20, 1);
    scene.render.step = 1.0 / 32;
    for (int i = 0; i < 200000; i++) {
        double v = (i + 0.5) / 200000, alpha = 1 - pow(1 - (0.05 + 0.15 * v), 16.0 / 200000), rgb[3];
        pel_transfer_color(&scene.transfer, v, rgb);
        for (int c = 0; c < 3; c++)
            expected[c] += transparency * alpha * rgb[c];
        transparency *= 1 - alpha;
    }
    for (int t = 0; techniques[t]; t++)
        for (int kind = 0; kind < 3; kind++) {
            struct pel_image image;
            scene.render.classification = (enum pel_classification)kind;
            draw(&scene, techniques[t], 2, 2, &image);
            for (int c = 0; c < 3; c++)
                check_at_most(fabs(channel(&image, 0, 1, c) - expected[c]), kind == PEL_CLASSIFICATION_PRE ? 2e-3 : 2e-4,
                              "%s: classification %d, channel %d (%g expected)", techniques[t], kind, c, expected[c]);
            check_at_most(fabs(channel(&image, 0, 1, 3) - (1 - transparency)), 2e-4, "%s: classification %d, alpha", techniques[t], kind);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_xray_of_a_box),  cmocka_unit_test(test_xray_colors),           cmocka_unit_test(test_camera_inside),
        cmocka_unit_test(test_lone_slice),     cmocka_unit_test(test_clipping),              cmocka_unit_test(test_clipped_to_nothing),
        cmocka_unit_test(test_step_and_scale), cmocka_unit_test(test_homogeneous_composite), cmocka_unit_test(test_composite_depth),
        cmocka_unit_test(test_classifications), cmocka_unit_test(test_emission),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
