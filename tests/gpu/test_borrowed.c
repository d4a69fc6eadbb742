/* SPDX-License-Identifier: MIT */
/* Drawing in a host's context: what the host has bound and begun stays, in every mode and in bricks. */
#include "on_device.h"

#include "device_gl.h"

static const GLenum kinds[] = { GL_TEXTURE_1D,       GL_TEXTURE_2D,       GL_TEXTURE_3D,
                                GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BUFFER,   GL_TEXTURE_RECTANGLE,
                                GL_TEXTURE_CUBE_MAP, GL_TEXTURE_1D_ARRAY, GL_TEXTURE_CUBE_MAP_ARRAY };
static const GLenum bindings[] = { GL_TEXTURE_BINDING_1D,       GL_TEXTURE_BINDING_2D,       GL_TEXTURE_BINDING_3D,
                                   GL_TEXTURE_BINDING_2D_ARRAY, GL_TEXTURE_BINDING_BUFFER,   GL_TEXTURE_BINDING_RECTANGLE,
                                   GL_TEXTURE_BINDING_CUBE_MAP, GL_TEXTURE_BINDING_1D_ARRAY, GL_TEXTURE_BINDING_CUBE_MAP_ARRAY };
enum { KINDS = sizeof kinds / sizeof *kinds, UNITS = 6 };

/* Gives whether every unit has the host's texture of every kind, or binds them. */
static bool textures_bound(const GLuint textures[KINDS], bool bind)
{
    bool all = true;
    for (GLuint unit = 0; unit < UNITS; unit++) {
        glActiveTexture(GL_TEXTURE0 + unit);
        for (int k = 0; k < KINDS; k++) {
            GLint name = 0;
            if (bind)
                glBindTexture(kinds[k], textures[k]);
            glGetIntegerv(bindings[k], &name);
            all &= (GLuint)name == textures[k];
        }
    }
    return all;
}

static void test_host_keeps_its_own(void **state)
{
    (void)state;
    need_device();
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    make_typed(&volume, &scene, PEL_U8, blob);
    assert_true(pel_device_begin(device, &error)); /* the host is we */
    GLuint textures[KINDS], timer;
    for (int k = 0; k < KINDS; k++)
        glCreateTextures(kinds[k], 1, &textures[k]);
    glCreateQueries(GL_TIME_ELAPSED, 1, &timer);
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.device = pel_device_wrap_current(&error);
    assert_non_null(params.device);
    for (int bricks = 0; bricks < 2; bricks++) {
        struct pel_renderer *renderer = pel_renderer_create(&params, &error);
        if (bricks)
            params.device->info.max_texture_3d = 26;
        for (int mode = 0; mode <= PEL_MODE_SLICE; mode++) {
            GLint query = 0;
            scene.render.mode = (enum pel_mode)mode;
            pel_image_init(&image);
            assert_true(pel_image_allocate(&image, 32, 32, true, &error));
            textures_bound(textures, true);
            glBeginQuery(GL_TIME_ELAPSED, timer);
            if (!pel_renderer_draw(renderer, &scene, "raycast", &image, &error))
                fail_msg("mode %d: %s", mode, error.message);
            glGetQueryiv(GL_TIME_ELAPSED, GL_CURRENT_QUERY, &query);
            assert_int_equal(query, timer);
            glEndQuery(GL_TIME_ELAPSED);
            assert_true(textures_bound(textures, false));
            if (mode == PEL_MODE_ISOSURFACE && !bricks) { /* which draws with a logic operation, to layers */
                GLint operation = 0;
                glLogicOp(GL_XOR);
                glEnable(GL_COLOR_LOGIC_OP);
                if (!pel_renderer_draw(renderer, &scene, "peel", &image, &error))
                    fail_msg("peel: %s", error.message);
                glGetIntegerv(GL_LOGIC_OP_MODE, &operation);
                assert_int_equal(operation, GL_XOR);
                assert_true(glIsEnabled(GL_COLOR_LOGIC_OP));
                glDisable(GL_COLOR_LOGIC_OP);
                assert_true(textures_bound(textures, false));
            }
            pel_image_finish(&image);
        }
        pel_renderer_destroy(renderer);
    }
    assert_int_equal(pel_device_objects(params.device), 0);
    pel_device_destroy(params.device);
    glDeleteTextures(KINDS, textures);
    glDeleteQueries(1, &timer);
    pel_device_end(device);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A device that is lost under a renderer: errors, and no memory left (the address sanitizer says so). */
static void test_lost(void **state)
{
    (void)state;
    need_device();
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_device *doomed = pel_device_create(-1, NULL, &error);
    assert_non_null(doomed);
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.device = doomed;
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    make_typed(&volume, &scene, PEL_U8, blob);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 32, 32, true, &error));
    assert_true(pel_renderer_draw(renderer, &scene, "raycast", &image, &error));
    doomed->lost = true;
    assert_false(pel_renderer_draw(renderer, &scene, "raycast", &image, &error));
    assert_non_null(strstr(error.message, "lost"));
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(doomed), 0);
    pel_device_destroy(doomed);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_host_keeps_its_own), cmocka_unit_test(test_lost) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
