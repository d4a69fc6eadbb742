/* SPDX-License-Identifier: MIT */
/* Devices: found, opened many times over, side by side and by each way; what was current before stays so; errors are told. */
#include <dirent.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <epoxy/egl.h>

#include "device_gl.h"
#include "egl.h"

/* A device, or the test is skipped and says so. */
static struct pel_device *device_or_skip(unsigned paths)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_device *device = pel_device_create_path(paths, -1, NULL, &error);
    if (!device) {
        print_message("SKIPPED: %s\n", error.message);
        skip();
    }
    return device;
}

static int open_files(void)
{
    int count = 0;
    DIR *folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    while (readdir(folder))
        count++;
    closedir(folder);
    return count;
}

/* Resident memory, KiB. */
static long resident(void)
{
    long kib = 0;
    char line[256];
    FILE *file = fopen("/proc/self/status", "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        if (sscanf(line, "VmRSS: %ld", &kib) == 1)
            break;
    fclose(file);
    return kib;
}

static bool nothing_current(void)
{
    return eglGetCurrentContext() == EGL_NO_CONTEXT;
}

static void test_list(void **state)
{
    (void)state;
    struct pel_device_info infos[PEL_MAX_DEVICES];
    struct pel_error error = PEL_ERROR_INIT;
    int count = pel_device_list(infos, PEL_MAX_DEVICES, &error);
    if (count == 0) {
        assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, "there is no GPU: "));
        print_message("SKIPPED: %s\n", error.message);
        skip();
    }
    assert_int_equal(pel_device_list(NULL, 0, NULL), count);
    int chosen = 0;
    for (int i = 0; i < count; i++) {
        print_message("GPU %d: %s, %s %s: %s\n", i, infos[i].name, infos[i].path, infos[i].node, infos[i].note);
        assert_true(infos[i].note[0] && infos[i].path[0]);
        assert_true(infos[i].usable || !infos[i].chosen);
        assert_true(!infos[i].usable || (infos[i].name[0] && infos[i].version[0] && infos[i].max_texture_3d >= 2048));
        chosen += infos[i].chosen;
    }
    struct pel_device *device = pel_device_create(-1, NULL, &error);
    assert_int_equal(chosen, device ? 1 : 0);
    if (device) /* the one that the list names */
        for (int i = 0; i < count; i++)
            assert_true(!infos[i].chosen || strcmp(infos[i].name, pel_device_describe(device)->name) == 0);
    pel_device_destroy(device);
    struct pel_device_info one[2] = { 0 }; /* room for fewer than there are */
    assert_int_equal(pel_device_list(one, 1, NULL), count);
    assert_string_equal(one[0].note, infos[0].note);
    assert_false(one[1].path[0]);
}

static void test_bad_index(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    assert_null(pel_device_create(-2, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_null(pel_device_create(PEL_MAX_DEVICES, NULL, &error));
    assert_true(error.code == PEL_ERROR_ARGUMENT || error.code == PEL_ERROR_UNSUPPORTED);
    assert_null(pel_device_create(-2, NULL, NULL));
    pel_device_destroy(NULL);
}

/* Each way to a context draws the same, and leaves nothing current. */
static void test_paths(void **state)
{
    (void)state;
    static const struct {
        unsigned path;
        const char *name;
    } paths[] = { { PEL_PATH_DEVICE, "EGL device" }, { PEL_PATH_SURFACELESS, "EGL surfaceless" }, { PEL_PATH_PBUFFER, "EGL pbuffer" } };
    int opened = 0;
    for (int i = 0; i < 3; i++) {
        struct pel_error error = PEL_ERROR_INIT;
        struct pel_device *device = pel_device_create_path(paths[i].path, -1, NULL, &error);
        if (!device) {
            print_message("SKIPPED: %s: %s\n", paths[i].name, error.message);
            continue;
        }
        opened++;
        assert_string_equal(pel_device_describe(device)->path, paths[i].name);
        assert_true(nothing_current());
        assert_true(pel_device_begin(device, &error));
        GLuint buffer;
        const uint32_t four[4] = { 1, 2, 3, 4 };
        uint32_t back[4] = { 0 };
        glCreateBuffers(1, &buffer);
        glNamedBufferStorage(buffer, sizeof four, four, 0);
        glGetNamedBufferSubData(buffer, 0, sizeof back, back);
        glDeleteBuffers(1, &buffer);
        assert_true(pel_device_check(device, paths[i].name, &error));
        pel_device_end(device);
        assert_memory_equal(four, back, sizeof four);
        assert_true(nothing_current());
        pel_device_destroy(device);
    }
    if (opened == 0)
        skip();
}

static void test_many(void **state)
{
    (void)state;
    pel_device_destroy(device_or_skip(PEL_PATH_ALL));
    struct pel_device_info info;
    int files = 0;
    long memory = 0;
    for (int i = 0; i < 200; i++) {
        struct pel_device *device = pel_device_create(-1, NULL, NULL);
        assert_non_null(device);
        assert_int_equal(pel_device_objects(device), 0);
        pel_device_destroy(device);
        if (i % 20 == 0)
            assert_true(pel_device_list(&info, 1, NULL) > 0);
        if (i == 40)
            files = open_files(), memory = resident();
    }
    assert_int_equal(open_files(), files);
    print_message("growth over 160 rounds: %ld KiB\n", resident() - memory);
#ifndef __SANITIZE_ADDRESS__ /* which keeps freed memory for a while */
    assert_true(resident() - memory < 16 * 1024);
#endif
    assert_true(nothing_current());
}

/* A context as a host program would have one. */
static struct pel_egl host_context(unsigned path)
{
    struct pel_egl_candidate candidates[PEL_MAX_DEVICES];
    struct pel_egl host = { 0 };
    int count = pel_egl_candidates(path, candidates, NULL);
    for (int i = 0; i < count && !host.context; i++)
        pel_egl_open(&candidates[i], false, false, &host, NULL);
    return host;
}

static void test_before_is_restored(void **state)
{
    (void)state;
    struct pel_device *device = device_or_skip(PEL_PATH_ALL);
    struct pel_egl host = host_context(PEL_PATH_ALL);
    assert_non_null(host.context);
    assert_true(eglMakeCurrent(host.display, host.surface, host.surface, host.context));
    eglBindAPI(EGL_OPENGL_ES_API); /* the thread's own choice stays too */
    assert_true(pel_device_begin(device, NULL));
    eglBindAPI(EGL_OPENGL_API);
    assert_ptr_equal(eglGetCurrentContext(), device->egl.context);
    eglBindAPI(EGL_OPENGL_ES_API);
    assert_true(pel_device_begin(device, NULL)); /* nested */
    pel_device_end(device);
    eglBindAPI(EGL_OPENGL_API);
    assert_ptr_equal(eglGetCurrentContext(), device->egl.context);
    eglBindAPI(EGL_OPENGL_ES_API);
    pel_device_end(device);
    pel_device_list(NULL, 0, NULL);
    struct pel_device_info info;
    pel_device_list(&info, 1, NULL);
    struct pel_device *second = pel_device_create(-1, NULL, NULL);
    assert_non_null(second);
    pel_device_destroy(second);
    pel_device_destroy(device);
    assert_int_equal(eglQueryAPI(), EGL_OPENGL_ES_API);
    eglBindAPI(EGL_OPENGL_API);
    assert_ptr_equal(eglGetCurrentContext(), host.context);
    assert_ptr_equal(eglGetCurrentDisplay(), host.display);
    assert_non_null(glGetString(GL_VERSION));
    eglMakeCurrent(host.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    pel_egl_close(&host);
}

/* Objects of one device are none of the other's; begins may be nested, one in the other. */
static void test_side_by_side(void **state)
{
    (void)state;
    struct pel_device *a = device_or_skip(PEL_PATH_ALL), *b = device_or_skip(PEL_PATH_ALL);
    GLuint buffers[3];
    assert_true(pel_device_begin(a, NULL));
    glCreateBuffers(3, buffers);
    assert_true(pel_device_begin(b, NULL));
    assert_false(glIsBuffer(buffers[2]));
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_device_begin(a, &error)); /* begun already, and not what is current */
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    pel_device_end(b);
    assert_true(glIsBuffer(buffers[2]));
    pel_device_destroy(b);
    assert_true(glIsBuffer(buffers[2]));
    glDeleteBuffers(3, buffers);
    assert_true(pel_device_check(a, "side by side", NULL));
    pel_device_end(a);
    pel_device_destroy(a);
    assert_true(nothing_current());
}

static void test_check(void **state)
{
    (void)state;
    struct pel_device *device = device_or_skip(PEL_PATH_ALL);
    struct pel_error error = PEL_ERROR_INIT;
    assert_true(pel_device_begin(device, NULL));
    assert_true(pel_device_check(device, "nothing", &error));
    glEnable(0xffff);
    glUseProgram(12345);
    assert_false(pel_device_check(device, "a stage", &error));
    assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
    assert_string_equal(error.message, "a stage: GL_INVALID_ENUM (0x500)");
    assert_true(pel_device_check(device, "cleared", &error));
    glEnable(0xffff); /* left pending: not the next one's */
    pel_device_end(device);
    assert_true(pel_device_begin(device, NULL));
    assert_true(pel_device_check(device, "cleared", &error));
    pel_device_end(device);
    device->lost = true;
    assert_false(pel_device_begin(device, &error));
    assert_non_null(strstr(error.message, "device lost"));
    pel_device_destroy(device);
}

static void count_messages(void *user, const char *message)
{
    *(int *)user += strstr(message, "GL error: ") == message && !strchr(message, '\n');
}

static void test_log(void **state)
{
    (void)state;
    pel_device_destroy(device_or_skip(PEL_PATH_ALL));
    int count = 0;
    struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
    params.log = count_messages, params.log_user = &count, params.debug = true;
    struct pel_device *device = pel_device_create(-1, &params, NULL);
    assert_non_null(device);
    assert_true(pel_device_begin(device, NULL));
    assert_int_equal(count, 0);
    glEnable(0xffff);
    assert_int_equal(count, 1);
    assert_false(pel_device_check(device, "logged", NULL));
    pel_device_end(device);
    pel_device_destroy(device);
}

static void test_wrap(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    pel_device_destroy(device_or_skip(PEL_PATH_ALL));
    assert_null(pel_device_wrap_current(&error)); /* nothing is current */
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    struct pel_egl host = host_context(PEL_PATH_ALL);
    assert_true(eglMakeCurrent(host.display, host.surface, host.surface, host.context));
    struct pel_device *device = pel_device_wrap_current(&error);
    assert_non_null(device);
    assert_string_equal(pel_device_describe(device)->path, "borrowed");
    assert_true(pel_device_describe(device)->max_texture_3d >= 2048);
    assert_true(pel_device_begin(device, &error));
    assert_true(pel_device_check(device, "borrowed", &error));
    struct pel_device *inner = pel_device_create(-1, NULL, &error); /* one of its own beside it */
    assert_non_null(inner);
    assert_true(pel_device_begin(inner, &error));
    assert_false(pel_device_begin(device, NULL)); /* begun, but its context is not current now */
    pel_device_end(inner);
    assert_true(pel_device_begin(device, NULL));
    pel_device_end(device);
    pel_device_end(device);
    assert_int_equal(device->depth, 0);
    pel_device_destroy(inner);
    assert_ptr_equal(eglGetCurrentContext(), host.context);
    struct pel_egl other = host_context(PEL_PATH_ALL); /* another context in its place is not the one */
    assert_true(eglMakeCurrent(other.display, other.surface, other.surface, other.context));
    assert_false(pel_device_begin(device, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    eglMakeCurrent(host.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    assert_false(pel_device_begin(device, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    pel_device_destroy(device);
    assert_true(eglMakeCurrent(host.display, host.surface, host.surface, host.context)); /* the host's lives on */
    assert_non_null(glGetString(GL_VERSION));
    eglMakeCurrent(host.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    pel_egl_close(&other);
    pel_egl_close(&host);
}

/* OpenGL ES is refused in words. */
static void test_wrap_es(void **state)
{
    (void)state;
    struct pel_device *device = device_or_skip(PEL_PATH_ALL);
    EGLDisplay display = device->egl.display;
    const EGLint version[] = { EGL_CONTEXT_CLIENT_VERSION, 3, EGL_NONE };
    eglBindAPI(EGL_OPENGL_ES_API);
    EGLContext es = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, version);
    if (!es || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, es)) {
        print_message("SKIPPED: no OpenGL ES here\n");
        pel_device_destroy(device);
        skip();
    }
    struct pel_error error = PEL_ERROR_INIT;
    assert_null(pel_device_wrap_current(&error));
    assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "OpenGL ES"));
    assert_true(pel_device_begin(device, &error)); /* a device of our own goes on over it */
    pel_device_end(device);
    assert_ptr_equal(eglGetCurrentContext(), es);
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, es);
    pel_device_destroy(device);
}

/* Binds something everywhere; `name` says what: objects made by glCreate*, two of each. */
/* Two ways to draw that have nothing in common, and what would mislead ours in both. */
static void draw_oddly(int number)
{
    static const GLenum some[2][6] = { { GL_DEPTH_TEST, GL_STENCIL_TEST, GL_CLIP_DISTANCE0 + 3, GL_RASTERIZER_DISCARD, GL_DEPTH_CLAMP, GL_SAMPLE_MASK },
                                       { GL_CULL_FACE, GL_COLOR_LOGIC_OP, GL_FRAMEBUFFER_SRGB, GL_POLYGON_OFFSET_FILL, GL_CLIP_DISTANCE0, GL_SCISSOR_TEST } };
    for (int i = 0; i < 6; i++) {
        glEnable(some[number][i]);
        glDisable(some[1 - number][i]);
    }
    glDepthFunc(number ? GL_GREATER : GL_NEVER);
    glDepthMask(number != 0);
    glDepthRange(0.25 * number, 0.75);
    glCullFace(number ? GL_FRONT : GL_FRONT_AND_BACK);
    glFrontFace(number ? GL_CW : GL_CCW);
    glPolygonMode(GL_FRONT_AND_BACK, number ? GL_LINE : GL_POINT);
    glClipControl(number ? GL_UPPER_LEFT : GL_LOWER_LEFT, number ? GL_NEGATIVE_ONE_TO_ONE : GL_ZERO_TO_ONE);
    glStencilFuncSeparate(number ? GL_FRONT : GL_BACK, GL_GREATER, 3, 7);
    glStencilOpSeparate(number ? GL_FRONT : GL_BACK, GL_INCR, GL_DECR, GL_INVERT);
    glStencilMaskSeparate(number ? GL_FRONT : GL_BACK, 5);
    glBlendFuncSeparate(GL_DST_COLOR, GL_ONE, number ? GL_ZERO : GL_DST_ALPHA, GL_ONE);
    glBlendEquationSeparate(GL_MIN, number ? GL_MAX : GL_FUNC_SUBTRACT);
    for (GLuint i = 0; i < 4; i++) { /* target by target */
        glColorMaski(i, number != 0, i == 2, GL_TRUE, number == 0);
        if ((int)(i & 1) == number)
            glEnablei(GL_BLEND, i);
        else
            glDisablei(GL_BLEND, i);
    }
}

static void bind_all(GLuint program, const GLuint textures[PEL_SAVED_TARGETS], GLuint sampler, GLuint buffer, GLuint array, GLuint frame,
                     int number)
{
    for (GLuint unit = 0; unit < PEL_SAVED_UNITS; unit++) {
        for (int t = 0; t < PEL_SAVED_TARGETS; t++)
            glBindTextureUnit(unit, textures[t]);
        glBindSampler(unit, sampler);
    }
    for (GLuint i = 0; i < PEL_SAVED_IMAGES; i++)
        glBindImageTexture(i, textures[2], 0, number == 0, number, number ? GL_WRITE_ONLY : GL_READ_ONLY, number ? GL_R32F : GL_R32UI);
    for (GLuint i = 0; i < 8; i++) {
        glBindBufferRange(GL_SHADER_STORAGE_BUFFER, i, buffer, 256 * number, 512);
        glBindBufferBase(GL_UNIFORM_BUFFER, i, buffer);
    }
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
    glPixelStorei(GL_UNPACK_ALIGNMENT, number ? 8 : 2);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 7 + number);
    glPixelStorei(GL_PACK_SKIP_ROWS, 3 + number);
    glUseProgram(program);
    glBindVertexArray(array);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glViewport(number, 2, 3, 4);
    draw_oddly(number);
    glActiveTexture(GL_TEXTURE3 + (GLenum)number);
}

static GLuint compute_program(void)
{
    const char *text = "#version 450\nlayout(local_size_x = 1) in;\nvoid main() {}\n";
    return glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &text);
}

static void test_saved_state(void **state)
{
    (void)state;
    static const GLenum kinds[PEL_SAVED_TARGETS] = { GL_TEXTURE_1D, GL_TEXTURE_2D, GL_TEXTURE_3D, GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BUFFER, GL_TEXTURE_RECTANGLE,
                                                     GL_TEXTURE_CUBE_MAP, GL_TEXTURE_1D_ARRAY, GL_TEXTURE_CUBE_MAP_ARRAY, GL_TEXTURE_2D_MULTISAMPLE,
                                                     GL_TEXTURE_2D_MULTISAMPLE_ARRAY };
    struct pel_device *device = device_or_skip(PEL_PATH_ALL);
    assert_true(pel_device_begin(device, NULL));
    GLuint programs[2] = { compute_program(), compute_program() }, textures[2][PEL_SAVED_TARGETS], samplers[2], buffers[2], arrays[2],
           frames[2];
    glCreateSamplers(2, samplers);
    glCreateBuffers(2, buffers);
    glCreateVertexArrays(2, arrays);
    glCreateFramebuffers(2, frames);
    for (int i = 0; i < 2; i++) {
        for (int t = 0; t < PEL_SAVED_TARGETS; t++)
            glCreateTextures(kinds[t], 1, &textures[i][t]);
        glTextureStorage3D(textures[i][2], 1, GL_R32F, 4, 4, 4);
        glNamedBufferStorage(buffers[i], 4096, NULL, 0);
    }
    static struct pel_gl_saved before, inside, after; /* static: their padding is zero */
    bind_all(programs[0], textures[0], samplers[0], buffers[0], arrays[0], frames[0], 0);
    assert_true(pel_device_check(device, "the host's state", NULL));
    pel_gl_save(&before);
    assert_int_equal(before.textures[15][3], textures[0][3]);
    assert_int_equal(before.stores[0], 2);
    assert_int_equal(before.program, programs[0]);
    assert_int_equal(before.storage[3].size, 512);
    pel_gl_save(&inside); /* what would mislead us is gone */
    assert_int_equal(inside.stores[0], 1);
    assert_int_equal(inside.stores[1], 0);
    assert_int_equal(inside.unpack_buffer, 0);
    assert_int_equal(inside.samplers[5], 0);
    for (int i = 0; i < PEL_SAVED_SWITCHES; i++)
        assert_int_equal(inside.drawing.switches[i], 0);
    assert_int_equal(inside.drawing.scissor, 0);
    assert_int_equal(inside.drawing.polygon_mode[0], GL_FILL);
    assert_int_equal(inside.drawing.clip_depth, GL_NEGATIVE_ONE_TO_ONE);
    assert_int_equal(before.drawing.switches[0], 1);
    assert_int_equal(before.drawing.depth_func, GL_NEVER);
    assert_int_equal(before.drawing.colors[2].blend, 1);
    assert_int_equal(before.drawing.colors[1].blend, 0);
    bind_all(programs[1], textures[1], samplers[1], buffers[1], arrays[1], frames[1], 1);
    pel_gl_restore(&before);
    assert_true(pel_device_check(device, "restored", NULL));
    pel_gl_save(&after);
    assert_memory_equal(&before, &after, sizeof before);
    pel_gl_restore(&after);
    struct pel_error error = PEL_ERROR_INIT;
    assert_true(pel_device_check(device, "the end", &error));
    pel_device_end(device);
    pel_device_destroy(device);
}

int main(void)
{
    setenv("EGL_PLATFORM", "surfaceless", 0); /* so that Mesa's default display needs no X server */
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_list),  cmocka_unit_test(test_bad_index),         cmocka_unit_test(test_paths),
        cmocka_unit_test(test_many),  cmocka_unit_test(test_before_is_restored), cmocka_unit_test(test_side_by_side),
        cmocka_unit_test(test_check), cmocka_unit_test(test_log),               cmocka_unit_test(test_wrap),
        cmocka_unit_test(test_wrap_es), cmocka_unit_test(test_saved_state),
    };
    return cmocka_run_group_tests_name("device", tests, NULL, NULL);
}
