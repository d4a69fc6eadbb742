/* SPDX-License-Identifier: MIT */
/* Scenes: what they start as, and everything that the check must refuse. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/scene.h>
#include <pellucid/version.h>

static void test_start(void **state)
{
    (void)state;
    struct pel_scene s;
    assert_true(pel_scene_init(&s, NULL));
    assert_null(s.volume);
    assert_int_equal(s.light_count, 1);
    assert_true(s.lights[0].headlight && s.lights[0].color[2] == 1);
    assert_true(s.background[0] == 0 && s.background[3] == 1);
    assert_true(s.render.mode == PEL_MODE_COMPOSITE && s.render.step == 0.5 && s.render.skip);
    assert_true(s.camera.view_angle == 30 && s.transfer.color_count >= 1 && s.transfer.opacity_count >= 1);
    pel_scene_finish(&s);
}

/* Breaks a good scene in one way. */
static const char *damage(struct pel_scene *s, struct pel_volume *v, int fault)
{
    switch (fault) {
    case 0: return s->volume = NULL, "no volume";
    case 1: return v->components = 3, "three components";
    case 2: return v->spacing[1] = 0, "a bad volume";
    case 3: return memcpy(s->camera.focal_point, s->camera.position, sizeof s->camera.position), "a bad camera";
    case 4: return s->render.step = 0, "step 0";
    case 5: return s->render.step = NAN, "step NaN";
    case 6: return s->render.mode = (enum pel_mode)17, "an unknown mode";
    case 7: return s->render.mode = (enum pel_mode)-1, "a negative mode";
    case 8: return s->render.termination = 2, "termination 2";
    case 9: return s->render.ambient = -1, "ambient -1";
    case 10: return s->render.mode = PEL_MODE_ISOSURFACE, "no isosurface";
    case 11: return s->isosurface_count = PEL_MAX_ISOSURFACES + 1, "too many isosurfaces";
    case 12: return s->isosurface_count = 1, s->isosurfaces[0].value = NAN, "an isovalue of NaN";
    case 13: return s->isosurface_count = 1, s->isosurfaces[0].opacity = 1.5, "an opacity of 1.5";
    case 14: return s->light_count = PEL_MAX_LIGHTS + 1, "too many lights";
    case 15: return s->lights[0].headlight = false, "a light without direction";
    case 16: return s->lights[0].color[1] = INFINITY, "an infinite light";
    case 17: return s->clip_plane_count = -1, "-1 clip planes";
    case 18: return s->clip_plane_count = 1, "a clip plane without normal";
    case 19: return s->clip_box_enabled = true, s->clip_box[0] = 1, "a clip box upside down";
    case 20: return s->clip_box_enabled = true, s->clip_box[5] = NAN, "a clip box of NaN";
    case 21: return s->background[1] = 2, "a background of 2";
    case 22: return s->transfer.unit_distance = 0, "unit distance 0";
    case 23: return s->render.mode = PEL_MODE_SLICE, s->slice.normal[2] = 0, "a slice without normal";
    case 24: return s->render.mode = PEL_MODE_SLICE, s->slice.origin[0] = NAN, "a slice at NaN";
    case 25: return s->render.classification = (enum pel_classification)3, "an unknown classification";
    case 26: return s->clip_plane_count = PEL_MAX_CLIP_PLANES + 1, "too many clip planes";
    case 27: return s->more_slice_count = PEL_MAX_SLICES, "too many slices";
    case 28: return s->more_slice_count = -1, "-1 further slices";
    case 29: return s->render.mode = PEL_MODE_SLICE, s->more_slice_count = 1, "a second slice without normal";
    default: return NULL;
    }
}

static void test_check(void **state)
{
    (void)state;
    for (int fault = -1;; fault++) {
        struct pel_volume v;
        struct pel_scene s;
        struct pel_error error = PEL_ERROR_INIT;
        pel_volume_init(&v);
        assert_true(pel_volume_allocate(&v, (size_t[3]){ 4, 4, 4 }, PEL_U8, 1, NULL));
        assert_true(pel_scene_init(&s, NULL));
        s.volume = &v;
        pel_camera_fit(&s.camera, &v, 64, 64);
        if (!pel_scene_check(&s, &error))
            fail_msg("a good scene was refused: %s", error.message);
        const char *what = damage(&s, &v, fault);
        if (what && pel_scene_check(&s, &error))
            fail_msg("%s was let through", what);
        if (what)
            assert_true(error.message[0] && error.code != PEL_ERROR_NONE);
        pel_scene_finish(&s);
        pel_volume_finish(&v);
        if (fault >= 0 && !what)
            break;
    }
}

static void test_version(void **state)
{
    (void)state;
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", PEL_VERSION_MAJOR, PEL_VERSION_MINOR, PEL_VERSION_PATCH);
    assert_string_equal(pel_version(), text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_start),
        cmocka_unit_test(test_check),
        cmocka_unit_test(test_version),
    };
    return cmocka_run_group_tests_name("scene", tests, NULL, NULL);
}
