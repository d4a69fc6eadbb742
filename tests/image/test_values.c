/* SPDX-License-Identifier: MIT */
/* Modes that show a value of the volume, the reconstruction itself, sample types and voids. */
#include "pictures.h"

enum { SIZE = 48 };

/* Noise: a hash of the position, 0..1 in steps of 1/100, the same everywhere. */
static double noise(const double index[3])
{
    uint32_t h = (uint32_t)index[0] * 73856093u ^ (uint32_t)index[1] * 19349663u ^ (uint32_t)index[2] * 83492791u;
    h = (h ^ (h >> 13)) * 0x5bd1e995u;
    return (double)((h >> 9) % 101);
}

static double noise01(const double index[3])
{
    return noise(index) / 100;
}

/* What a ray's samples come to by brute force: value and, where an extreme is asked for, the t of its first sample. */
static double brute(const struct pel_scene *scene, const double origin[3], const double direction[3], const double stretch[2], double *t)
{
    const double dt = scene->render.step * pel_volume_least_spacing(scene->volume);
    const enum pel_mode mode = scene->render.mode;
    double best = mode == PEL_MODE_MIP ? -INFINITY : INFINITY, sum = 0;
    *t = INFINITY;
    long n = (long)ceil((stretch[1] - stretch[0]) / dt - 0.001);
    for (long i = 0; i < (n < 1 ? 1 : n); i++) {
        double from = stretch[0] + (double)i * dt, to = i + 1 >= n ? stretch[1] : from + dt, at = (from + to) / 2;
        double world[3] = { origin[0] + at * direction[0], origin[1] + at * direction[1], origin[2] + at * direction[2] };
        double value = reconstruct(scene->volume, world);
        sum += value * (to - from);
        if (mode == PEL_MODE_MIP ? value > best : value < best) {
            best = value;
            *t = at;
        }
    }
    return mode == PEL_MODE_AVERAGE ? sum / (stretch[1] - stretch[0]) : best;
}

/* MIP is the largest reconstructed sample, MinIP the least, average their mean; opacity over 0..1 is the value itself, so alpha
 * tells it. */
static void test_projections(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 20, 17, 13, PEL_F32, noise01);
    memcpy(volume.spacing, (double[3]){ 1, 1.2, 1.7 }, sizeof volume.spacing);
    memcpy(volume.direction[2], (double[3]){ 0.36, 0.48, 0.8 }, sizeof volume.direction[2]);
    make_scene(&scene, &volume, "0:0,1:1");
    set_flat_color(&scene, 1, 0.5, 0);
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < 6; variant++) {
            struct pel_image image;
            double worst = 0, worst_depth = 0, worst_color = 0, origin[3], direction[3], s[2], at;
            const enum pel_mode modes[] = { PEL_MODE_MIP, PEL_MODE_MINIP, PEL_MODE_AVERAGE };
            scene.render.mode = modes[variant % 3];
            scene.camera.parallel = variant / 3;
            draw(&scene, techniques[t], SIZE, SIZE, &image);
            for (int y = 0; y < SIZE; y++)
                for (int x = 0; x < SIZE; x++) {
                    double alpha = channel(&image, x, y, 3), depth = depth_at(&image, x, y), expected = 0;
                    at = INFINITY;
                    if (ray_stretch(&scene, SIZE, SIZE, x, y, origin, direction, s))
                        expected = brute(&scene, origin, direction, s, &at);
                    worst = fmax(worst, fabs(alpha - expected));
                    worst_color = fmax(worst_color, fabs(channel(&image, x, y, 1) - alpha / 2));
                    if (scene.render.mode == PEL_MODE_AVERAGE || isinf(at) || alpha == 0) {
                        assert_true(isinf(depth));
                    } else if (fabs(depth - at) > 1e-3) { /* another sample may be as good, within rounding */
                        double world[3];
                        for (int i = 0; i < 3; i++)
                            world[i] = origin[i] + depth * direction[i];
                        worst_depth = fmax(worst_depth, fabs(reconstruct(&volume, world) - expected));
                    }
                }
            check_at_most(worst, 2e-4, "%s: mode %d, error of the projected value", techniques[t], (int)scene.render.mode);
            check_at_most(worst_color, 1e-6, "%s: mode %d, colour x opacity", techniques[t], (int)scene.render.mode);
            check_at_most(worst_depth, 2e-4, "%s: mode %d, value at the depth told", techniques[t], (int)scene.render.mode);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A slice shows the reconstructed value where the ray meets the plane, and only inside what is not clipped away. */
static void test_slice(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 20, 17, 13, PEL_F32, noise01);
    memcpy(volume.spacing, (double[3]){ 1, 1.2, 1.7 }, sizeof volume.spacing);
    make_scene(&scene, &volume, "0:0,1:1");
    scene.render.mode = PEL_MODE_SLICE;
    pel_volume_index_to_world(&volume, (const double[3]){ 9, 8, 6 }, scene.slice.origin);
    memcpy(scene.slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof scene.slice.normal);
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < 4; variant++) {
            struct pel_image image;
            double worst = 0, worst_depth = 0, origin[3], direction[3], s[2], from[3];
            int seen = 0;
            scene.camera.parallel = variant & 1;
            scene.clip_box_enabled = variant & 2;
            memcpy(scene.clip_box, (double[6]){ 3.1, 12.3, -100, 100, 2, 100 }, sizeof scene.clip_box);
            draw(&scene, techniques[t], SIZE, SIZE, &image);
            for (int y = 0; y < SIZE; y++)
                for (int x = 0; x < SIZE; x++) {
                    bool hit = ray_stretch(&scene, SIZE, SIZE, x, y, origin, direction, s);
                    for (int i = 0; i < 3; i++)
                        from[i] = scene.slice.origin[i] - origin[i];
                    double at = dot3(from, scene.slice.normal) / dot3(direction, scene.slice.normal), expected = 0;
                    double world[3] = { origin[0] + at * direction[0], origin[1] + at * direction[1], origin[2] + at * direction[2] };
                    if (hit && (fabs(at - s[0]) < 1e-4 || fabs(at - s[1]) < 1e-4))
                        continue; /* on the edge: either answer is right */
                    hit = hit && at > s[0] && at < s[1];
                    if (hit) {
                        expected = reconstruct(&volume, world);
                        worst_depth = fmax(worst_depth, fabs(depth_at(&image, x, y) - at));
                    } else {
                        assert_true(isinf(depth_at(&image, x, y)));
                    }
                    seen += hit;
                    worst = fmax(worst, fabs(channel(&image, x, y, 3) - expected));
                }
            check_at_least(seen, 100, "%s: pixels of the slice", techniques[t]);
            check_at_most(worst, 2e-4, "%s: error of a slice's value", techniques[t]);
            check_at_most(worst_depth, 1e-4, "%s: error of a slice's depth", techniques[t]);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* What a pixel is by sorting the planes and compositing their values, whose opacity and gray they are; and how near the ray comes to an end
 * of its stretch, or two planes to one another, where either answer is right. */
static double brute_slices(const struct pel_scene *scene, const double origin[3], const double direction[3], const double s[2],
                           double expected[2], double *depth)
{
    double at[PEL_MAX_SLICES], nearest = INFINITY;
    int count = 0;
    expected[0] = expected[1] = 0;
    *depth = INFINITY;
    for (int i = 0; i <= scene->more_slice_count; i++) {
        const struct pel_plane *plane = i ? &scene->more_slices[i - 1] : &scene->slice;
        double from[3];
        for (int a = 0; a < 3; a++)
            from[a] = plane->origin[a] - origin[a];
        double t = dot3(from, plane->normal) / dot3(direction, plane->normal);
        nearest = fmin(nearest, fmin(fabs(t - s[0]), fabs(t - s[1])));
        if (t >= s[0] && t <= s[1])
            at[count++] = t;
    }
    for (; count > 0; count--) { /* the nearest, which is then taken out */
        int least = 0;
        for (int i = 1; i < count; i++)
            least = at[i] < at[least] ? i : least;
        double t = at[least], world[3] = { origin[0] + t * direction[0], origin[1] + t * direction[1], origin[2] + t * direction[2] };
        double value = reconstruct(scene->volume, world);
        at[least] = at[count - 1];
        for (int i = 0; i < count - 1; i++)
            nearest = fmin(nearest, fabs(at[i] - t));
        if (value > 0)
            *depth = fmin(*depth, t);
        expected[1] += (1 - expected[0]) * value * value;
        expected[0] += (1 - expected[0]) * value;
    }
    return nearest;
}

/* Several planes: each pixel composites what it meets in the order along its ray, whatever the order they are named in. */
static void test_several_slices(void **state)
{
    (void)state;
    static const double normals[PEL_MAX_SLICES][3] = { { 1, 0, 0 },   { 0, 0, 1 },   { 0, 1, 0 },     { 1, -2, 0.5 },
                                                       { 1, 1, 1.3 }, { -1, 2, -1 }, { 0.2, 0.1, 1 }, { 3, 1, -1 } };
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 20, 17, 13, PEL_F32, noise01);
    memcpy(volume.spacing, (double[3]){ 1, 1.2, 1.7 }, sizeof volume.spacing);
    make_scene(&scene, &volume, "0:0,1:1");
    scene.render.mode = PEL_MODE_SLICE;
    for (int i = 0; i < PEL_MAX_SLICES; i++) {
        struct pel_plane *plane = i ? &scene.more_slices[i - 1] : &scene.slice;
        pel_volume_index_to_world(&volume, (const double[3]){ 9.3 + 0.4 * i, 8.2, 6.1 - 0.3 * i }, plane->origin);
        memcpy(plane->normal, normals[i], sizeof plane->normal);
    }
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < 4; variant++) {
            struct pel_image image;
            double worst = 0, worst_depth = 0, origin[3], direction[3], s[2], expected[2], depth;
            int seen = 0;
            pel_camera_fit(&scene.camera, &volume, SIZE, SIZE);
            pel_camera_azimuth(&scene.camera, 30 + 70 * variant);
            pel_camera_elevation(&scene.camera, 35 - 20 * variant);
            scene.camera.parallel = variant & 1;
            scene.more_slice_count = variant < 2 ? 2 : PEL_MAX_SLICES - 1;
            draw(&scene, techniques[t], SIZE, SIZE, &image);
            for (int y = 0; y < SIZE; y++)
                for (int x = 0; x < SIZE; x++) {
                    if (!ray_stretch(&scene, SIZE, SIZE, x, y, origin, direction, s) ||
                        brute_slices(&scene, origin, direction, s, expected, &depth) < 1e-3)
                        continue;
                    worst = fmax(worst, fmax(fabs(channel(&image, x, y, 3) - expected[0]), fabs(channel(&image, x, y, 1) - expected[1])));
                    assert_int_equal(isinf(depth), isinf(depth_at(&image, x, y)));
                    if (!isinf(depth))
                        worst_depth = fmax(worst_depth, fabs(depth_at(&image, x, y) - depth));
                    seen += expected[0] > 0;
                }
            check_at_least(seen, 400, "%s: pixels of several slices", techniques[t]);
            check_at_most(worst, 1e-3, "%s, variant %d: error of several slices", techniques[t], variant);
            check_at_most(worst_depth, 1e-4, "%s, variant %d: error of their depth", techniques[t], variant);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* The same values in any type give the same picture, in every mode. */
static void test_types(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image first[PEL_MODE_SLICE + 1][2];
    for (int type = PEL_U8; type < PEL_TYPE_COUNT; type++) {
        make_volume(&volume, 14, 13, 12, (enum pel_type)type, noise);
        make_scene(&scene, &volume, "0:0,20:0.02,100:0.4");
        assert_true(pel_transfer_set_colormap(&scene.transfer, "viridis", 0, 100, NULL));
        scene.render.shade = true;
        scene.isosurfaces[0] = (struct pel_isosurface){ 60.3, { 1, 0.8, 0.6 }, 0.5 };
        scene.isosurface_count = 1;
        pel_volume_index_to_world(&volume, (const double[3]){ 7, 6, 6 }, scene.slice.origin);
        memcpy(scene.slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof scene.slice.normal);
        for (int t = 0; techniques[t]; t++)
            for (int mode = 0; mode <= PEL_MODE_SLICE; mode++) {
                struct pel_image image;
                scene.render.mode = (enum pel_mode)mode;
                draw(&scene, techniques[t], 32, 32, type == PEL_U8 ? &first[mode][t] : &image);
                if (type == PEL_U8)
                    continue;
                check_at_most(largest_difference(&first[mode][t], &image), mode == PEL_MODE_ISOSURFACE ? 2e-3 : 5e-4,
                              "%s: mode %d, %s against u8", techniques[t], mode, pel_type_name((enum pel_type)type));
                pel_image_finish(&image);
            }
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        for (int t = 0; techniques[t]; t++)
            pel_image_finish(&first[mode][t]);
}

/* Values a long way from 1 (densities in SI units, counts) give the same picture when the curves are as far away. */
static double value_scale;

static double scaled_noise(const double index[3])
{
    return noise01(index) * value_scale;
}

static void test_value_scale(void **state)
{
    (void)state;
    const double scales[] = { 1, 1e-20, 1e20 };
    const enum pel_type types[] = { PEL_F32, PEL_F64 };
    for (int t = 0; techniques[t]; t++)
        for (int type = 0; type < 2; type++)
            for (int mode = 0; mode <= PEL_MODE_SLICE; mode++) {
                struct pel_image first, image;
                for (int i = 0; i < 3; i++) {
                    struct pel_volume volume;
                    struct pel_scene scene;
                    value_scale = scales[i];
                    make_volume(&volume, 14, 13, 12, types[type], scaled_noise);
                    const struct pel_opacity_point opacities[] = { { 0, 0 }, { 0.2 * value_scale, 0.02 }, { value_scale, 0.4 } };
                    make_scene(&scene, &volume, NULL);
                    assert_true(pel_transfer_set_opacities(&scene.transfer, opacities, 3, NULL));
                    assert_true(pel_transfer_set_colormap(&scene.transfer, "viridis", 0, value_scale, NULL));
                    scene.render.mode = (enum pel_mode)mode;
                    scene.render.shade = true;
                    scene.isosurfaces[0] = (struct pel_isosurface){ 0.603 * value_scale, { 1, 0.8, 0.6 }, 0.5 };
                    scene.isosurface_count = 1;
                    pel_volume_index_to_world(&volume, (const double[3]){ 7, 6, 6 }, scene.slice.origin);
                    memcpy(scene.slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof scene.slice.normal);
                    draw(&scene, techniques[t], 32, 32, i ? &image : &first);
                    if (i) {
                        check_at_most(largest_difference(&first, &image), 2e-3, "%s: mode %d, %s, values times %g", techniques[t], mode,
                                      pel_type_name(types[type]), value_scale);
                        pel_image_finish(&image);
                    }
                    pel_scene_finish(&scene);
                    pel_volume_finish(&volume);
                }
                pel_image_finish(&first);
            }
}

/* Labels 0 and 2 side by side: only label 1 could be seen, and a trilinear signal would make it up. */
static double two_labels(const double index[3])
{
    return index[0] + index[1] > 13 ? 2 : 0;
}

static void test_labels(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 16, 16, 16, PEL_U8, two_labels);
    make_scene(&scene, &volume, "0.5:0,0.5:0.9,1.5:0.9,1.5:0");
    const struct {
        bool labels;
        enum pel_reconstruction how;
        bool seen;
    } rows[] = {
        { true, PEL_RECONSTRUCTION_AUTO, false },     { false, PEL_RECONSTRUCTION_AUTO, true },
        { true, PEL_RECONSTRUCTION_LINEAR, true },    { false, PEL_RECONSTRUCTION_LINEAR, true },
        { true, PEL_RECONSTRUCTION_NEAREST, false },  { false, PEL_RECONSTRUCTION_NEAREST, false },
    };
    for (int t = 0; techniques[t]; t++)
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
            for (int kind = 0; kind < 3; kind++) {
                struct pel_image image;
                double most = 0;
                volume.labels = rows[i].labels;
                scene.render.reconstruction = rows[i].how;
                scene.render.classification = (enum pel_classification)kind;
                draw(&scene, techniques[t], SIZE, SIZE, &image);
                for (int p = 0; p < SIZE * SIZE; p++)
                    most = fmax(most, (double)image.rgba[4 * p + 3]);
                if (rows[i].seen && kind != PEL_CLASSIFICATION_PRE)
                    check_at_least(most, 0.5, "%s: row %zu, a made-up label is seen where interpolation is wanted", techniques[t], i);
                else
                    check_at_most(most, 0, "%s: row %zu, classification %d, a label that is not there", techniques[t], i, kind);
                pel_image_finish(&image);
            }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A slab of label 1, four voxels thick: nearest reconstruction makes it four spacings long, to the half voxel. */
static double label_slab(const double index[3])
{
    return index[2] >= 5 && index[2] < 9 ? 1 : 0;
}

static void test_nearest_is_exact(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 6, 6, 16, PEL_U8, label_slab);
    make_scene(&scene, &volume, "0.9:0,0.9:0.2");
    scene.render.reconstruction = PEL_RECONSTRUCTION_NEAREST;
    look_parallel(&scene, (const double[3]){ 0, 0, 1 }, 20, 1);
    for (int t = 0; techniques[t]; t++)
        for (int mode = 0; mode < 3; mode++) {
            struct pel_image image;
            scene.render.mode = mode < 2 ? PEL_MODE_COMPOSITE : PEL_MODE_XRAY;
            scene.render.classification = mode == 1 ? PEL_CLASSIFICATION_PRE : PEL_CLASSIFICATION_POST;
            draw(&scene, techniques[t], 8, 8, &image);
            for (int y = 0; y < 8; y++)
                for (int x = 0; x < 8; x++)
                    check_at_most(fabs(channel(&image, x, y, 3) - (1 - pow(0.8, 4))), 1e-5, "%s: a slab of labels, variant %d",
                                  techniques[t], mode);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* 1 everywhere, but 200 (the void) in slices 8 to 10: the cells from 7 to 11 are void. Clipped to begin at 0.1, a ray along z has
 * segments of a half with their ends at 0.1, 0.6, ... 20: the eight whose middles are void are lost, 15.9 is left; preintegrated, where a
 * segment is void if an end is, the nine from 6.6 to 11.1 are lost, and 15.4 is left. */
static double void_slab(const double index[3])
{
    return index[2] >= 8 && index[2] <= 10 ? 200 : 1;
}

static void fill_void(struct pel_volume *volume, double value)
{
    for (size_t i = 0; i < pel_volume_samples(volume); i++)
        if (volume->type == PEL_F32 && ((float *)volume->data)[i] == 200)
            ((float *)volume->data)[i] = (float)value;
        else if (volume->type == PEL_F64 && ((double *)volume->data)[i] == 200)
            ((double *)volume->data)[i] = value;
    pel_volume_update_range(volume);
}

/* Every mode over the volume with a void slab: alpha of the middle pixel against what the rest alone gives. */
static void check_void_modes(struct pel_volume *volume, const char *what)
{
    struct pel_scene scene;
    make_scene(&scene, volume, "0.1");
    look_parallel(&scene, (const double[3]){ 0, 0, 1 }, 30, 1);
    scene.isosurfaces[0] = (struct pel_isosurface){ 50, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 1;
    pel_volume_index_to_world(volume, (const double[3]){ 3, 3, 9.2 }, scene.slice.origin);
    memcpy(scene.slice.normal, (double[3]){ 0, 0, 1 }, sizeof scene.slice.normal);
    scene.clip_box_enabled = true;
    memcpy(scene.clip_box, (double[6]){ -9, 99, -9, 99, 0.1, 99 }, sizeof scene.clip_box);
    const double expected[] = { 1 - pow(0.9, 15.9), 0.1, 0.1, 0.1, 1 - pow(0.9, 15.9), 0, 0 };
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < PEL_MODE_SLICE + 1 + 5; variant++) {
            struct pel_image image;
            int mode = variant <= PEL_MODE_SLICE ? variant : PEL_MODE_COMPOSITE, extra = variant - PEL_MODE_SLICE;
            scene.render.mode = (enum pel_mode)mode;
            scene.render.classification = extra < 1 ? PEL_CLASSIFICATION_POST : (enum pel_classification)(extra % 3);
            scene.render.shade = extra >= 3;
            double alpha = scene.render.classification == PEL_CLASSIFICATION_PREINTEGRATED ? 1 - pow(0.9, 15.4) : expected[mode];
            draw(&scene, techniques[t], 8, 8, &image);
            for (int y = 0; y < 8; y++)
                for (int x = 0; x < 8; x++)
                    check_at_most(fabs(channel(&image, x, y, 3) - alpha), 1e-5, "%s: %s, mode %d, variant %d, alpha with a void slab",
                                  techniques[t], what, mode, variant);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
}

static void test_voids(void **state)
{
    (void)state;
    const double floats[] = { NAN, INFINITY, -INFINITY };
    for (int type = PEL_U8; type < PEL_TYPE_COUNT; type++) {
        struct pel_volume volume;
        if (type == PEL_I8)
            continue; /* cannot hold 200 */
        make_volume(&volume, 7, 7, 21, (enum pel_type)type, void_slab);
        volume.has_void = true;
        volume.void_value = 200;
        pel_volume_update_range(&volume);
        check_void_modes(&volume, pel_type_name((enum pel_type)type));
        pel_volume_finish(&volume);
        for (int i = 0; i < 3 && type >= PEL_F32; i++) {
            char what[32];
            make_volume(&volume, 7, 7, 21, (enum pel_type)type, void_slab);
            fill_void(&volume, floats[i]);
            snprintf(what, sizeof what, "%s %g", pel_type_name((enum pel_type)type), floats[i]);
            check_void_modes(&volume, what);
            pel_volume_finish(&volume);
        }
    }
}

/* A volume of voids only is empty in every mode. */
static double not_a_number(const double index[3])
{
    (void)index;
    return NAN;
}

static void test_all_void(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 9, 8, 7, PEL_F32, not_a_number);
    make_scene(&scene, &volume, "1");
    scene.isosurfaces[0] = (struct pel_isosurface){ 0.5, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 1;
    pel_volume_index_to_world(&volume, (const double[3]){ 4, 4, 3 }, scene.slice.origin);
    memcpy(scene.slice.normal, (double[3]){ 0, 1, 1 }, sizeof scene.slice.normal);
    for (int t = 0; techniques[t]; t++)
        for (int mode = 0; mode <= PEL_MODE_SLICE; mode++) {
            struct pel_image image;
            double most = 0;
            scene.render.mode = (enum pel_mode)mode;
            draw(&scene, techniques[t], 16, 16, &image);
            for (int i = 0; i < 4 * 16 * 16; i++)
                most = fmax(most, fabs((double)image.rgba[i]) >= 0 ? fabs((double)image.rgba[i]) : INFINITY);
            check_at_most(most, 0, "%s: mode %d of a volume of voids", techniques[t], mode);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_projections), cmocka_unit_test(test_slice),            cmocka_unit_test(test_several_slices), cmocka_unit_test(test_types),
        cmocka_unit_test(test_labels),      cmocka_unit_test(test_nearest_is_exact), cmocka_unit_test(test_voids),
        cmocka_unit_test(test_all_void),    cmocka_unit_test(test_value_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
