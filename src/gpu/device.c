/* SPDX-License-Identifier: MIT */
/* Devices: found, opened, borrowed, made current, and asked what went wrong. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "describe.h"
#include "egl.h"
#include "fail.h"

/* Learns what a driver has that cannot make the context that we want; the reason is in the error already, and gets better where this works.
 */
static void describe_old(const struct pel_egl_candidate *candidate, struct pel_device_info *info)
{
    struct pel_egl egl;
    struct pel_egl_current before;
    if (!pel_egl_open(candidate, true, false, &egl, NULL))
        return;
    if (pel_egl_enter(&egl, &before, NULL)) {
        pel_gl_describe(info);
        pel_egl_leave(&egl, &before);
    }
    pel_egl_close(&egl);
    info->usable = false;
}

static bool open_and_describe(const struct pel_egl_candidate *candidate, bool debug, struct pel_egl *egl, struct pel_device_info *info,
                              struct pel_error *error)
{
    struct pel_egl_current before;
    pel_egl_describe(candidate, info);
    if (!pel_egl_open(candidate, false, debug, egl, error)) {
        describe_old(candidate, info);
        return false;
    }
    if (!pel_egl_enter(egl, &before, error)) {
        pel_egl_close(egl);
        return false;
    }
    bool ok = pel_gl_describe(info) && info->usable;
    pel_egl_leave(egl, &before);
    if (!ok) {
        pel_egl_close(egl);
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the context is no OpenGL 4.5");
    }
    return true;
}

static const char not_usable[] = "not usable: "; /* how such a note begins, pel_gl_describe's too */

/* Fills in the note of a device that did not open. */
static void note_failure(struct pel_device_info *info, const struct pel_error *error)
{
    if (!info->note[0])
        snprintf(info->note, sizeof info->note, "%s%.200s", not_usable, error->message);
}

static bool no_gpu(struct pel_error *error)
{
    return pel_fail_in(error, "there is no GPU: ");
}

int pel_device_list_paths(unsigned paths, struct pel_device_info *infos, int room, struct pel_error *error)
{
    struct pel_egl_candidate candidates[PEL_MAX_DEVICES];
    int count = pel_egl_candidates(paths, candidates, error);
    if (count == 0)
        return no_gpu(error);
    if (room <= 0)
        return count;
    /* All of them are looked at, as which is chosen depends on all. */
    struct pel_device_info *all = pel_alloc((size_t)count, sizeof *all, "the list of devices", error);
    if (!all)
        return 0;
    for (int i = 0; i < count; i++) {
        struct pel_egl egl;
        struct pel_error why = PEL_ERROR_INIT;
        if (open_and_describe(&candidates[i], false, &egl, &all[i], &why))
            pel_egl_close(&egl);
        else
            note_failure(&all[i], &why);
    }
    pel_devices_compare(all, count);
    memcpy(infos, all, (size_t)(room < count ? room : count) * sizeof *all);
    free(all);
    return count;
}

static const char *word_of(GLenum value)
{
    switch (value) {
    case GL_DEBUG_TYPE_ERROR:
        return "error";
    case GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR:
        return "deprecated";
    case GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR:
        return "undefined behaviour";
    case GL_DEBUG_TYPE_PORTABILITY:
        return "portability";
    case GL_DEBUG_TYPE_PERFORMANCE:
        return "performance";
    default:
        return "note";
    }
}

static void GLAPIENTRY on_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length, const GLchar *message,
                                  const void *user)
{
    const struct pel_device *device = user;
    (void)source, (void)id, (void)length;
    if (type == GL_DEBUG_TYPE_PUSH_GROUP || type == GL_DEBUG_TYPE_POP_GROUP ||
        (severity == GL_DEBUG_SEVERITY_NOTIFICATION && !device->params.debug))
        return;
    char text[512];
    snprintf(text, sizeof text, "GL %s: %s", word_of(type), message);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 32 || *c == 127)
            *c = ' ';
    device->params.log(device->params.log_user, text);
}

/* What is set once, as nobody else changes it. */
static bool prepare_context(struct pel_device *device, struct pel_error *error)
{
    if (!pel_device_begin(device, error))
        return false;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    if (device->params.log) {
        glDebugMessageCallback(on_message, device);
        glEnable(GL_DEBUG_OUTPUT);
        if (device->params.debug)
            glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    }
    bool ok = pel_device_check(device, "a new context", error);
    pel_device_end(device);
    return ok;
}

static struct pel_device *open_device(const struct pel_egl_candidate *candidate, const struct pel_device_params *params,
                                      struct pel_error *error)
{
    struct pel_device *device = pel_alloc(1, sizeof *device, "a device", error);
    struct pel_error why = PEL_ERROR_INIT;
    if (!device)
        return NULL;
    if (params)
        device->params = *params;
    if (!open_and_describe(candidate, device->params.debug, &device->egl, &device->info, &why)) {
        note_failure(&device->info, &why);
        pel_fail(error, why.code, "%s%s%s", device->info.node, device->info.node[0] ? ": " : "", device->info.note + strlen(not_usable));
        free(device);
        return NULL;
    }
    device->own = true;
    if (!prepare_context(device, error)) {
        pel_device_destroy(device);
        return NULL;
    }
    snprintf(device->info.note, sizeof device->info.note, "%s", device->info.software ? "software" : "hardware");
    return device;
}

/* The first hardware, and until one is found the first software is kept. */
static struct pel_device *open_best(const struct pel_egl_candidate *candidates, int count, const struct pel_device_params *params,
                                    struct pel_error *error)
{
    struct pel_device *best = NULL;
    struct pel_error first = PEL_ERROR_INIT;
    for (int i = 0; i < count && (!best || best->info.software); i++) {
        struct pel_error why = PEL_ERROR_INIT;
        struct pel_device *device = open_device(&candidates[i], params, &why);
        if (!device && first.code == PEL_ERROR_NONE)
            first = why;
        if (device && best && device->info.software) {
            pel_device_destroy(device);
        } else if (device) {
            pel_device_destroy(best);
            best = device;
        }
    }
    if (!best)
        pel_fail(error, first.code, "there is no usable GPU among %d: GPU 0: %s", count, first.message);
    return best;
}

struct pel_device *pel_device_create_path(unsigned paths, int index, const struct pel_device_params *params, struct pel_error *error)
{
    struct pel_egl_candidate candidates[PEL_MAX_DEVICES];
    if (index < -1) {
        pel_fail(error, PEL_ERROR_ARGUMENT, "there is no GPU %d; they are numbered from 0", index);
        return NULL;
    }
    int count = pel_egl_candidates(paths, candidates, error);
    if (count == 0) {
        no_gpu(error);
        return NULL;
    }
    if (index >= count) {
        pel_fail(error, PEL_ERROR_ARGUMENT, "there is no GPU %d; there %s %d, numbered from 0 (see pellucid devices)", index,
                 count == 1 ? "is" : "are", count);
        return NULL;
    }
    if (index < 0)
        return open_best(candidates, count, params, error);
    struct pel_device *device = open_device(&candidates[index], params, error);
    if (!device)
        pel_fail_in(error, "GPU %d: ", index);
    return device;
}

int pel_device_list(struct pel_device_info *infos, int room, struct pel_error *error)
{
    return pel_device_list_paths(PEL_PATH_ALL, infos, room, error);
}

struct pel_device *pel_device_create(int index, const struct pel_device_params *params, struct pel_error *error)
{
    return pel_device_create_path(PEL_PATH_ALL, index, params, error);
}

struct pel_device *pel_device_wrap_current(struct pel_error *error)
{
    struct pel_device *device = pel_alloc(1, sizeof *device, "a device", error);
    if (!device)
        return NULL;
    struct pel_egl_current current = { 0 };
    if (!pel_gl_available(error))
        goto fail;
    /* Without a libEGL the context is of another kind. */
    if (pel_egl_available(NULL))
        pel_egl_get_current(&current);
    device->borrowed = current.context;
    snprintf(device->info.path, sizeof device->info.path, "borrowed");
    if (!pel_gl_describe(&device->info)) {
        pel_fail(error, PEL_ERROR_ARGUMENT, "no OpenGL context is current on this thread");
        goto fail;
    }
    if (!device->info.usable) {
        pel_fail(error, PEL_ERROR_UNSUPPORTED, "the current context cannot be borrowed: %s", device->info.note + strlen(not_usable));
        goto fail;
    }
    snprintf(device->info.note, sizeof device->info.note, "borrowed from the host program");
    return device;
fail:
    free(device);
    return NULL;
}

void pel_device_destroy(struct pel_device *device)
{
    if (!device)
        return;
    if (device->own)
        pel_egl_close(&device->egl);
    free(device);
}

const struct pel_device_info *pel_device_describe(const struct pel_device *device)
{
    return &device->info;
}

int pel_device_objects(const struct pel_device *device)
{
    return device->objects;
}

bool pel_device_is_current(const struct pel_device *device)
{
    return device->depth > 0 && !device->lost;
}

/* Errors that a host left pending would be taken for ours. In a lost context glGetError may tell so for ever: hence the bound. */
static void clear_errors(void)
{
    for (int i = 0; i < 32 && glGetError() != GL_NO_ERROR; i++)
        ;
}

static bool borrowed_is_current(const struct pel_device *device, struct pel_error *error)
{
    struct pel_egl_current current = { 0 };
    if (device->borrowed)
        pel_egl_get_current(&current);
    if (current.context != device->borrowed || !glGetString(GL_VERSION))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the borrowed OpenGL context is not current on this thread");
    return true;
}

static bool own_is_current(const struct pel_device *device, struct pel_error *error)
{
    struct pel_egl_current current;
    pel_egl_get_current(&current);
    return current.context == device->egl.context ||
           pel_fail(error, PEL_ERROR_ARGUMENT, "another OpenGL context was made current while this device is in use");
}

bool pel_device_begin(struct pel_device *device, struct pel_error *error)
{
    if (device->lost)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "device lost: the GPU was reset; make a new device");
    bool ok = !device->own        ? borrowed_is_current(device, error) :
              device->depth == 0 ? pel_egl_enter(&device->egl, &device->before, error) :
                                    own_is_current(device, error);
    if (!ok)
        return false;
    if (device->depth++ == 0)
        clear_errors();
    return true;
}

void pel_device_end(struct pel_device *device)
{
    if (--device->depth == 0 && device->own)
        pel_egl_leave(&device->egl, &device->before);
}

static const char *gl_error_name(GLenum code)
{
    switch (code) {
    case GL_INVALID_ENUM:
        return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
        return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
        return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
        return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_STACK_OVERFLOW:
        return "GL_STACK_OVERFLOW";
    case GL_STACK_UNDERFLOW:
        return "GL_STACK_UNDERFLOW";
    default:
        return "an unknown GL error";
    }
}

bool pel_device_check(struct pel_device *device, const char *what, struct pel_error *error)
{
    GLenum first = glGetError(), code = first;
    bool memory = false, lost = glGetGraphicsResetStatus() != GL_NO_ERROR;
    for (int i = 0; i < 32 && code != GL_NO_ERROR; i++) {
        memory = memory || code == GL_OUT_OF_MEMORY;
        lost = lost || code == GL_CONTEXT_LOST;
        code = glGetError();
    }
    if (lost) {
        device->lost = true;
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s: device lost: the GPU was reset", what);
    }
    if (memory)
        return pel_fail(error, PEL_ERROR_MEMORY, "%s: out of memory on the GPU (%.100s)", what, device->info.name);
    return first == GL_NO_ERROR || pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s: %s (0x%x)", what, gl_error_name(first), first);
}
