/* SPDX-License-Identifier: MIT */
/* Picking in a volume whose values are x + 100 y, so that every place tells itself. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <pellucid/pellucid.h>

#define N 17

struct world {
    struct pel_volume volume;
    struct pel_scene scene;
};

/* Voxels of 2; seen along +y by a parallel camera, x to the right, z up, a world length of 0.5 a pixel. */
static int make(void **state)
{
    static struct world w;
    pel_volume_init(&w.volume);
    assert_true(pel_volume_allocate(&w.volume, (size_t[]) { N, N, N }, PEL_F32, 1, NULL));
    float *data = w.volume.data;
    for (size_t i = 0; i < N * N * N; i++)
        data[i] = (float)(i % N) + 100 * (float)(i / N % N);
    for (int a = 0; a < 3; a++)
        w.volume.spacing[a] = 2;
    pel_volume_update_range(&w.volume);
    assert_true(pel_scene_init(&w.scene, NULL));
    w.scene.volume = &w.volume;
    w.scene.camera = (struct pel_camera) { { 16, -100, 16 }, { 16, 16, 16 }, { 0, 0, 1 }, 30, true, 25 };
    w.scene.transfer.unit_distance = 2;
    *state = &w;
    return 0;
}

static int finish(void **state)
{
    struct world *w = *state;
    pel_scene_finish(&w->scene);
    pel_volume_finish(&w->volume);
    return 0;
}

static struct pel_pick pick_at(struct world *w, double x, double y, double opacity)
{
    struct pel_pick pick;
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_scene_pick(&w->scene, 100, 100, x, y, opacity, &pick, &error))
        fail_msg("%s", error.message);
    return pick;
}

static void near(double a, double b, double far)
{
    if (!(fabs(a - b) <= far))
        fail_msg("%g is not %g", a, b);
}

static void test_isosurface(void **state)
{
    struct world *w = *state;
    w->scene.render.mode = PEL_MODE_ISOSURFACE;
    w->scene.isosurface_count = 1;
    w->scene.isosurfaces[0] = (struct pel_isosurface) { 650, { 1, 1, 1 }, 1 };
    struct pel_pick p = pick_at(w, 50, 50, 0.1); /* the middle: x = 8 voxels */
    assert_true(p.hit && p.inside);
    near(p.value, 650, 1e-3);
    near(p.index[0], 8, 1e-9);
    near(p.index[1], 6.42, 1e-6);
    near(p.world[1], 12.84, 1e-5);
    near(p.distance, 112.84, 1e-5);
    p = pick_at(w, 60, 40, 0.1); /* 5 to the right, 5 up */
    near(p.world[0], 21, 1e-9);
    near(p.world[2], 21, 1e-9);
    p = pick_at(w, 1, 1, 0.1);
    assert_false(p.hit || p.inside);
    w->scene.isosurfaces[0].value = 5000;
    p = pick_at(w, 50, 50, 0.1);
    assert_true(!p.hit && p.inside);
}

/* Opacity 1 from the value 800 on: the first sample beyond it, however dense; with 0.1 a voxel the tenth part is passed at once and the half after seven voxels. */
static void test_composite(void **state)
{
    struct world *w = *state;
    w->scene.render.mode = PEL_MODE_COMPOSITE;
    w->scene.render.step = 0.05;
    const struct pel_opacity_point wall[] = { { 800, 0 }, { 800, 0.1 } };
    assert_true(pel_transfer_set_opacities(&w->scene.transfer, wall, 2, NULL));
    struct pel_pick p = pick_at(w, 50, 50, 0.001);
    assert_true(p.hit);
    near(p.index[1], 7.92, 0.1);
    p = pick_at(w, 50, 50, 0.5);
    near(p.index[1], 7.92 + log(0.5) / log(0.9), 0.1);
    p = pick_at(w, 50, 50, 0.999);
    assert_false(p.hit);
    w->scene.clip_box_enabled = true;
    for (int i = 0; i < 6; i++)
        w->scene.clip_box[i] = i % 2 ? 100 : i == 2 ? 24 : -100;
    near(pick_at(w, 50, 50, 0.001).index[1], 12, 0.1);
    w->scene.clip_box_enabled = false;
}

static void test_other_modes(void **state)
{
    struct world *w = *state;
    assert_true(pel_transfer_set_opacities(&w->scene.transfer, &(struct pel_opacity_point) { 0, 1 }, 1, NULL));
    w->scene.render.mode = PEL_MODE_SLICE;
    w->scene.slice = (struct pel_plane) { { 0, 10, 0 }, { 0, 1, 0 } };
    near(pick_at(w, 50, 50, 0.1).index[1], 5, 1e-9);
    static const enum pel_mode greatest[] = { PEL_MODE_MIP, PEL_MODE_AVERAGE, PEL_MODE_XRAY };
    for (int i = 0; i < 3; i++) {
        w->scene.render.mode = greatest[i];
        near(pick_at(w, 50, 50, 0.1).index[1], 16, 0.3);
    }
    w->scene.render.mode = PEL_MODE_MINIP;
    near(pick_at(w, 50, 50, 0.1).index[1], 0, 0.3);
}

static void test_refusals(void **state)
{
    struct world *w = *state;
    struct pel_pick pick;
    assert_false(pel_scene_pick(&w->scene, 0, 100, 1, 1, 0.1, &pick, NULL));
    assert_false(pel_scene_pick(&w->scene, 100, 100, NAN, 1, 0.1, &pick, NULL));
    assert_false(pel_scene_pick(&w->scene, 100, 100, 1, INFINITY, 0.1, &pick, NULL));
    assert_false(pel_scene_pick(&w->scene, 100, 100, 1, 1, 0, &pick, NULL));
    assert_false(pel_scene_pick(&w->scene, 100, 100, 1, 1, 1.5, &pick, NULL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_isosurface),
        cmocka_unit_test(test_composite),
        cmocka_unit_test(test_other_modes),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, make, finish);
}
