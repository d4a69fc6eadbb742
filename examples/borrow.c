/* SPDX-License-Identifier: MIT */
/* A program that has an OpenGL context of its own lends it: the library draws on it and gives it back as it was. Here the context is EGL's
 * without a window; one of GLFW, SDL, Qt or GTK is lent the same way, once it is current.
 *
 *   borrow OUTPUT.png
 *   cc borrow.c $(pkg-config --cflags --libs pellucid egl gl) -o borrow */
#include <stdio.h>
#include <stdlib.h>

#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>

#include <pellucid/pellucid.h>

/* The host's own context, current on this thread; false where the machine has none to give. */
static bool make_context(EGLDisplay *display)
{
    const EGLint wanted[] = { EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE };
    const EGLint version[] = { EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5, EGL_NONE };
    const EGLint size[] = { EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE };
    EGLConfig config;
    EGLint count = 0;
    *display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
    if (!eglInitialize(*display, NULL, NULL)) { /* no display server: Mesa needs none */
        *display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
        if (!eglInitialize(*display, NULL, NULL))
            return false;
    }
    if (!eglBindAPI(EGL_OPENGL_API) || !eglChooseConfig(*display, wanted, &config, 1, &count) ||
        count < 1)
        return false;
    EGLContext context = eglCreateContext(*display, config, EGL_NO_CONTEXT, version);
    EGLSurface surface = eglCreatePbufferSurface(*display, config, size);
    return context != EGL_NO_CONTEXT && eglMakeCurrent(*display, surface, surface, context);
}

int main(int argc, char **argv)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = NULL;
    EGLDisplay display;
    bool ok = false;

    if (argc != 2) {
        fprintf(stderr, "usage: borrow OUTPUT.png\n");
        return 2;
    }
    if (!make_context(&display)) {
        fprintf(stderr, "borrow: this machine gives no OpenGL 4.5 context\n");
        return 77; /* Meson's word for a test that could not run */
    }
    GLuint texture, bound;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_3D, texture); /* something of the host's, to be found again */

    pel_volume_init(&volume);
    pel_image_init(&image);
    params.device = pel_device_wrap_current(&error);
    const struct pel_dataset *dataset = pel_dataset_find("hydrogen");
    void *dataset_params = pel_dataset_create_params(dataset);
    if (!params.device || !dataset_params || !pel_scene_init(&scene, &error))
        goto done;
    scene.volume = &volume;
    renderer = pel_renderer_create(&params, &error);
    ok = renderer && pel_dataset_make(dataset, dataset_params, &volume, &error) &&
         pel_transfer_automatic(&scene.transfer, &volume, PEL_TRANSFER_COMPOSITE, &error) &&
         pel_image_allocate(&image, 400, 300, false, &error);
    if (ok) {
        pel_scene_fit_camera(&scene, image.width, image.height);
        ok = pel_renderer_draw(renderer, &scene, "raycast", &image, &error) &&
             pel_write_image(argv[1], &image, &(struct pel_image_write_params)PEL_IMAGE_WRITE_PARAMS_INIT, &error);
    }
    pel_scene_finish(&scene);
    glGetIntegerv(GL_TEXTURE_BINDING_3D, (GLint *)&bound);
    printf("drawn on %s; the host's texture is %s\n", pel_device_describe(params.device)->name, bound == texture ? "bound still" : "lost");
    ok = ok && bound == texture && glGetError() == GL_NO_ERROR;

done:
    if (!ok)
        fprintf(stderr, "borrow: %s\n", error.message);
    pel_renderer_destroy(renderer); /* before the device, and while the context is current */
    pel_device_destroy(params.device);
    free(dataset_params);
    pel_image_finish(&image);
    pel_volume_finish(&volume);
    eglTerminate(display);
    return ok ? 0 : 1;
}
