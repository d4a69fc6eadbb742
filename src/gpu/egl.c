/* SPDX-License-Identifier: MIT */
/* EGL without a window: devices by enumeration, else Mesa's surfaceless platform, else the default display with a pbuffer of one pixel.
 *
 * Displays are never terminated. EGL has one display a device in the process and counts no users of it, so terminating it would take the
 * context from under other devices, and from under a host program that draws on the same GPU. Extension functions are looked up by hand:
 * epoxy ends the process where it believes that there is none. */
#include "egl.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

#include <epoxy/egl.h>

#include "fail.h"

#ifndef EGL_DRM_RENDER_NODE_FILE_EXT /* younger than epoxy 1.5.10 */
#define EGL_DRM_RENDER_NODE_FILE_EXT 0x3377
#endif

static bool library_loads(const char *name, char *why, size_t size)
{
    void *library = dlopen(name, RTLD_LAZY | RTLD_LOCAL);
    if (!library) {
        const char *told = dlerror();
        snprintf(why, size, "%s", told ? told : name);
        return false;
    }
    dlclose(library);
    return true;
}

bool pel_gl_available(struct pel_error *error)
{
    char why[2][200];
    if (library_loads("libOpenGL.so.0", why[0], sizeof why[0]) || library_loads("libGL.so.1", why[1], sizeof why[1]))
        return true;
    return pel_fail(error, PEL_ERROR_UNSUPPORTED, "no OpenGL library (%s; %s)", why[0], why[1]);
}

bool pel_egl_available(struct pel_error *error)
{
    char why[400];
    if (!library_loads("libEGL.so.1", why, sizeof why))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "no EGL library (%s)", why);
    if (!epoxy_has_egl())
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "libEGL.so.1 is no EGL library");
    return pel_gl_available(error);
}

static const char *error_name(EGLint code)
{
    static const struct {
        EGLint code;
        const char *name;
    } names[] = {
        { EGL_SUCCESS, "no reason given" },
        { EGL_NOT_INITIALIZED, "EGL_NOT_INITIALIZED" },
        { EGL_BAD_ACCESS, "EGL_BAD_ACCESS" },
        { EGL_BAD_ALLOC, "EGL_BAD_ALLOC" },
        { EGL_BAD_ATTRIBUTE, "EGL_BAD_ATTRIBUTE" },
        { EGL_BAD_CONFIG, "EGL_BAD_CONFIG" },
        { EGL_BAD_CONTEXT, "EGL_BAD_CONTEXT" },
        { EGL_BAD_DISPLAY, "EGL_BAD_DISPLAY" },
        { EGL_BAD_MATCH, "EGL_BAD_MATCH" },
        { EGL_BAD_PARAMETER, "EGL_BAD_PARAMETER" },
        { EGL_BAD_SURFACE, "EGL_BAD_SURFACE" },
        { EGL_CONTEXT_LOST, "EGL_CONTEXT_LOST" },
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (names[i].code == code)
            return names[i].name;
    return "an unknown EGL error";
}

/* Fails with the call that EGL refused and its word for why. */
static bool fail_egl(struct pel_error *error, const char *call)
{
    EGLint code = eglGetError();
    return pel_fail(error, code == EGL_BAD_ALLOC ? PEL_ERROR_MEMORY : PEL_ERROR_UNSUPPORTED, "%s: %s", call, error_name(code));
}

static bool has(const char *extensions, const char *name)
{
    return extensions && epoxy_extension_in_string(extensions, name);
}

/* Extensions of EGL itself, before any display; EGL 1.4 without EGL_EXT_client_extensions has none, and raises an error that is taken away.
 */
static const char *client_extensions(void)
{
    const char *extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!extensions)
        eglGetError();
    return extensions;
}

static const char *device_extensions(void *device)
{
    PFNEGLQUERYDEVICESTRINGEXTPROC query = (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    return query ? query(device, EGL_EXTENSIONS) : NULL;
}

static int enumerate(const char *extensions, struct pel_egl_candidate *candidates)
{
    bool known = (has(extensions, "EGL_EXT_device_enumeration") || has(extensions, "EGL_EXT_device_base")) &&
                 has(extensions, "EGL_EXT_platform_device");
    PFNEGLQUERYDEVICESEXTPROC query = known ? (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT") : NULL;
    EGLDeviceEXT devices[PEL_MAX_DEVICES];
    EGLint count = 0;
    if (!query || !query(PEL_MAX_DEVICES, devices, &count)) {
        if (query)
            eglGetError();
        return 0;
    }
    for (int i = 0; i < count; i++)
        candidates[i] = (struct pel_egl_candidate){ .path = PEL_PATH_DEVICE, .device = devices[i] };
    return count;
}

int pel_egl_candidates(unsigned paths, struct pel_egl_candidate *candidates, struct pel_error *error)
{
    if (!pel_egl_available(error))
        return 0;
    const char *extensions = client_extensions();
    int count = paths & PEL_PATH_DEVICE ? enumerate(extensions, candidates) : 0;
    if (count > 0)
        return count;
    if (paths & PEL_PATH_SURFACELESS && has(extensions, "EGL_MESA_platform_surfaceless")) {
        candidates[0] = (struct pel_egl_candidate){ .path = PEL_PATH_SURFACELESS };
        return 1;
    }
    if (paths & PEL_PATH_PBUFFER) {
        candidates[0] = (struct pel_egl_candidate){ .path = PEL_PATH_PBUFFER };
        return 1;
    }
    pel_fail(error, PEL_ERROR_UNSUPPORTED, "EGL names no device");
    return 0;
}

void pel_egl_describe(const struct pel_egl_candidate *candidate, struct pel_device_info *info)
{
    const char *path = candidate->path == PEL_PATH_DEVICE        ? "EGL device"
                       : candidate->path == PEL_PATH_SURFACELESS ? "EGL surfaceless"
                                                                 : "EGL pbuffer";
    snprintf(info->path, sizeof info->path, "%s", path);
    if (candidate->path != PEL_PATH_DEVICE)
        return;
    const char *extensions = device_extensions(candidate->device), *node = NULL;
    PFNEGLQUERYDEVICESTRINGEXTPROC text = (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    PFNEGLQUERYDEVICEATTRIBEXTPROC number = (PFNEGLQUERYDEVICEATTRIBEXTPROC)eglGetProcAddress("eglQueryDeviceAttribEXT");
    EGLAttrib cuda = 0;
    if (has(extensions, "EGL_EXT_device_drm_render_node"))
        node = text(candidate->device, EGL_DRM_RENDER_NODE_FILE_EXT);
    if (!node && has(extensions, "EGL_EXT_device_drm"))
        node = text(candidate->device, EGL_DRM_DEVICE_FILE_EXT);
    if (node)
        snprintf(info->node, sizeof info->node, "%s", node);
    else if (number && has(extensions, "EGL_NV_device_cuda") && number(candidate->device, EGL_CUDA_DEVICE_NV, &cuda))
        snprintf(info->node, sizeof info->node, "CUDA device %d", (int)cuda);
    info->software = has(extensions, "EGL_MESA_device_software");
    eglGetError(); /* a driver that knows an extension but not the answer */
}

static EGLDisplay open_display(const struct pel_egl_candidate *candidate, struct pel_error *error)
{
    EGLDisplay display;
    if (candidate->path == PEL_PATH_PBUFFER) {
        display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
    } else {
        PFNEGLGETPLATFORMDISPLAYEXTPROC get = (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
        if (!get) {
            pel_fail(error, PEL_ERROR_UNSUPPORTED, "EGL lacks eglGetPlatformDisplayEXT");
            return EGL_NO_DISPLAY;
        }
        display = candidate->path == PEL_PATH_DEVICE ? get(EGL_PLATFORM_DEVICE_EXT, candidate->device, NULL) :
                                                       get(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    }
    if (display == EGL_NO_DISPLAY) {
        fail_egl(error, "EGL has no display");
        return EGL_NO_DISPLAY;
    }
    if (!eglInitialize(display, NULL, NULL)) {
        fail_egl(error, "the driver does not start (eglInitialize)");
        return EGL_NO_DISPLAY;
    }
    return display;
}

static bool choose_config(EGLDisplay display, bool pbuffer, EGLConfig *config, struct pel_error *error)
{
    const EGLint wanted[] = { EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, pbuffer ? EGL_PBUFFER_BIT : 0, EGL_NONE };
    EGLint count = 0;
    if (!eglChooseConfig(display, wanted, config, 1, &count))
        return fail_egl(error, "eglChooseConfig");
    return count > 0 || pel_fail(error, PEL_ERROR_UNSUPPORTED, "the driver has no OpenGL%s", pbuffer ? " with pbuffers" : "");
}

/* The attributes have the same numbers in EGL 1.5 and in EGL_KHR_create_context. Resets are asked to be told of, but not robust access: our
 * shaders stay within their buffers, and a driver that checks each access is slower. */
static EGLContext create_context(EGLDisplay display, EGLConfig config, bool any_version, bool debug, bool told_of_resets)
{
    EGLint attributes[16], n = 0;
    if (!any_version) {
        const EGLint core[] = { EGL_CONTEXT_MAJOR_VERSION_KHR, 4, EGL_CONTEXT_MINOR_VERSION_KHR, 5,
                                EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR };
        memcpy(attributes, core, sizeof core);
        n = sizeof core / sizeof core[0];
        if (debug)
            attributes[n++] = EGL_CONTEXT_FLAGS_KHR, attributes[n++] = EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR;
        if (told_of_resets)
            attributes[n++] = EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_KHR, attributes[n++] = EGL_LOSE_CONTEXT_ON_RESET_KHR;
    }
    attributes[n] = EGL_NONE;
    return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
}

bool pel_egl_open(const struct pel_egl_candidate *candidate, bool any_version, bool debug, struct pel_egl *egl, struct pel_error *error)
{
    *egl = (struct pel_egl){ 0 };
    EGLDisplay display = open_display(candidate, error);
    if (display == EGL_NO_DISPLAY)
        return false;
    EGLenum api = eglQueryAPI();
    if (!eglBindAPI(EGL_OPENGL_API))
        return fail_egl(error, "the driver has no OpenGL, only OpenGL ES (eglBindAPI)");
    const char *extensions = eglQueryString(display, EGL_EXTENSIONS);
    bool ok = false, pbuffer = candidate->path == PEL_PATH_PBUFFER || !has(extensions, "EGL_KHR_surfaceless_context");
    EGLConfig config = EGL_NO_CONFIG_KHR;
    egl->display = display;
    if (!any_version && epoxy_egl_version(display) < 15 && !has(extensions, "EGL_KHR_create_context")) {
        pel_fail(error, PEL_ERROR_UNSUPPORTED, "EGL is older than 1.5 and lacks EGL_KHR_create_context");
        goto out;
    }
    if ((pbuffer || !has(extensions, "EGL_KHR_no_config_context")) && !choose_config(display, pbuffer, &config, error))
        goto out;
    egl->context = create_context(display, config, any_version, debug, true);
    if (egl->context == EGL_NO_CONTEXT) {
        eglGetError();
        egl->context = create_context(display, config, any_version, debug, false);
    }
    if (egl->context == EGL_NO_CONTEXT) {
        fail_egl(error, any_version ? "no OpenGL context (eglCreateContext)" : "no OpenGL 4.5 core context (eglCreateContext)");
        goto out;
    }
    if (pbuffer) {
        const EGLint size[] = { EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE };
        egl->surface = eglCreatePbufferSurface(display, config, size);
        if (egl->surface == EGL_NO_SURFACE) {
            fail_egl(error, "eglCreatePbufferSurface");
            goto out;
        }
    }
    ok = true;
out:
    eglBindAPI(api);
    if (!ok)
        pel_egl_close(egl);
    return ok;
}

void pel_egl_close(struct pel_egl *egl)
{
    if (egl->surface)
        eglDestroySurface(egl->display, egl->surface);
    if (egl->context)
        eglDestroyContext(egl->display, egl->context);
    *egl = (struct pel_egl){ 0 };
}

/* A driver may keep what is current apart for OpenGL and OpenGL ES, and answer for the one that the thread has bound. */
void pel_egl_get_current(struct pel_egl_current *current)
{
    EGLenum api = eglQueryAPI();
    current->context = eglGetCurrentContext();
    if (!current->context && api != EGL_OPENGL_API && eglBindAPI(EGL_OPENGL_API))
        current->context = eglGetCurrentContext();
    current->display = eglGetCurrentDisplay();
    current->draw = eglGetCurrentSurface(EGL_DRAW);
    current->read = eglGetCurrentSurface(EGL_READ);
    eglBindAPI(api);
}

bool pel_egl_enter(const struct pel_egl *egl, struct pel_egl_current *before, struct pel_error *error)
{
    pel_egl_get_current(before);
    if (before->context == egl->context || eglMakeCurrent(egl->display, egl->surface, egl->surface, egl->context))
        return true;
    EGLint code = eglGetError();
    if (code == EGL_BAD_ACCESS)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                        "the context cannot be made current: it is current on another thread, or this thread has one that is not "
                        "EGL's (release that, or wrap it)");
    return pel_fail(error, code == EGL_BAD_ALLOC ? PEL_ERROR_MEMORY : PEL_ERROR_UNSUPPORTED, "the context cannot be made current: %s%s",
                    error_name(code), code == EGL_CONTEXT_LOST ? " (device lost)" : "");
}

void pel_egl_leave(const struct pel_egl *egl, const struct pel_egl_current *before)
{
    if (before->context == egl->context)
        return;
    if (before->context)
        eglMakeCurrent(before->display, before->draw, before->read, before->context);
    else
        eglMakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}
