/* SPDX-License-Identifier: MIT */
/* Exact roots of isosurfaces: the step does not matter, nothing thin is missed, and rays along the volume's own faces are no exception. */
#include "pictures.h"

enum { SIZE = 96 };

static double offset, scale; /* so that types of whole numbers have the same surfaces */

/* Sheets and threads a voxel thick at most, at any angle, on a smooth ground. */
static double threads(const double index[3])
{
    double sheet = index[0] + 0.37 * index[1] - 0.61 * index[2] - 3.3, u = index[1] - 0.4 * index[0] - 12.2,
           w = index[2] + 0.3 * index[0] - 19.7;
    double value = fmax(1.1 - fabs(sheet), 1.2 - sqrt(u * u + w * w)) + 0.05 * sin(index[0] * 0.7);
    return offset + scale * fmax(value, -1.5);
}

static int lone(const struct pel_image *a, const struct pel_image *b)
{
    int count = 0;
    for (int i = 0; i < SIZE * SIZE; i++)
        count += isfinite(a->depth[i]) && !isfinite(b->depth[i]);
    return count;
}

static void test_step_does_not_matter(void **state)
{
    (void)state;
    const struct {
        enum pel_type type;
        double offset, scale;
    } cases[] = { { PEL_U8, 100, 50 }, { PEL_I16, 2000, 1000 }, { PEL_F32, 0, 1 }, { PEL_F64, 1e6, 1 } };
    for (int t = 0; t < 4; t++)
        for (int view = 0; view < 4; view++) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_image fine, coarse, truth, stepped;
            char what[64];
            offset = cases[t].offset, scale = cases[t].scale;
            make_volume(&volume, 30, 26, 28, cases[t].type, threads);
            memcpy(volume.spacing, (double[3]) { 1, 1.4, 0.7 }, sizeof volume.spacing);
            make_scene(&scene, &volume, NULL);
            scene.render.mode = PEL_MODE_ISOSURFACE;
            scene.isosurfaces[0] = (struct pel_isosurface) { offset + 0.806 * scale, { 1, 0.8, 0.6 }, view & 1 ? 0.4 : 1 };
            scene.isosurfaces[1] = (struct pel_isosurface) { offset + 0.946 * scale, { 0.3, 0.5, 1 }, 0.6 };
            scene.isosurface_count = 1 + (view & 1);
            scene.camera.parallel = view & 2;
            pel_camera_azimuth(&scene.camera, 40 + 70 * view);
            draw(&scene, "raycast", SIZE, SIZE, &fine);
            draw(&scene, "reference", SIZE, SIZE, &truth);
            scene.render.step = 7;
            draw(&scene, "raycast", SIZE, SIZE, &coarse);
            scene.render.roots = PEL_ROOTS_STEPS;
            draw(&scene, "raycast", SIZE, SIZE, &stepped);
            snprintf(what, sizeof what, "%s, view %d", pel_type_name(cases[t].type), view);
            check_at_least(psnr(&coarse, &fine), 75, "%s: a step of 7 voxels beside one of a half, PSNR in dB", what);
            check_at_most(lone(&coarse, &fine) + lone(&fine, &coarse), 0, "%s: rays that hit at one step alone", what);
            check_at_most(lone(&truth, &fine) + lone(&fine, &truth), 1, "%s: rays that hit in the reference or in the engine alone", what);
            check_at_least(lone(&fine, &stepped), 100, "%s: rays that steps of 7 voxels miss", what);
            struct pel_image *images[] = { &fine, &coarse, &truth, &stepped };
            for (int i = 0; i < 4; i++)
                pel_image_finish(images[i]);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
}

static double up(const double index[3])
{
    return index[2];
}

/* One ray a row of voxels, along them: the outermost run in the volume's faces, all of them along edges of cells. */
static void test_rays_in_faces(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 9, 9, 9, PEL_F32, up);
    make_scene(&scene, &volume, NULL);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.isosurfaces[0] = (struct pel_isosurface) { 4.3, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 1;
    for (int side = -1; side <= 1; side += 2)
        for (int t = 0; techniques[t]; t++) {
            struct pel_image image;
            int seen = 0;
            look_parallel(&scene, (double[3]) { 0, 0, -side }, 20, 4.5); /* pixels as large as voxels */
            draw(&scene, techniques[t], 9, 9, &image);
            for (int i = 0; i < 81; i++)
                seen += fabs(image.depth[i] - (20 - side * 0.3)) < 1e-3;
            check_at_least(seen, 81, "%s: rays along rows of voxels that hit where the surface is, side %d", techniques[t], side);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_step_does_not_matter), cmocka_unit_test(test_rays_in_faces) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
