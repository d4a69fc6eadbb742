/* SPDX-License-Identifier: MIT */
/* The inside of a device, for the engines that draw with it. Whoever calls GL brackets it with pel_device_begin and pel_device_end, and
 * asks pel_device_check at the end of each stage. Passes use direct state access; in a context that is not ours they put back what they
 * bind (pel_gl_save, pel_gl_restore). */
#ifndef PEL_GPU_DEVICE_GL_H
#define PEL_GPU_DEVICE_GL_H

#include <epoxy/gl.h>

#include <pellucid/device.h>

/* A context of our own; all NULL in a borrowed device. The types are EGL's, which are pointers. */
struct pel_egl {
    void *display, *context, *surface;
};

/* What a thread had current in EGL. */
struct pel_egl_current {
    void *display, *context, *draw, *read;
};

struct pel_device {
    struct pel_device_info info;
    struct pel_device_params params;
    int objects;    /* live GL objects: whoever makes one adds one, whoever deletes it takes one away */
    uint64_t bytes; /* in textures and buffers, as asked for: counted likewise */

    /* device.c's own. */
    struct pel_egl egl;
    struct pel_egl_current before; /* what pel_device_begin found */
    void *borrowed;                /* the EGL context that was wrapped; NULL: ours, or one of another kind (GLX, WGL) */
    uint64_t room; /* tests: as if the device had memory for so many bytes in all; 0: what it has */
    bool own;
    bool lost; /* the GPU was reset: nothing works any more */
    int depth; /* of nested begins */
};

/* Ways to a context, in the order in which they are tried: a later one only where those before it do not exist. Tests ask for one alone. */
enum { PEL_PATH_DEVICE = 1 << 0, PEL_PATH_SURFACELESS = 1 << 1, PEL_PATH_PBUFFER = 1 << 2, PEL_PATH_ALL = 7 };

/* pel_device_list and pel_device_create over some of the ways. */
int pel_device_list_paths(unsigned paths, struct pel_device_info *infos, int room, struct pel_error *error);
struct pel_device *pel_device_create_path(unsigned paths, int index, const struct pel_device_params *params, struct pel_error *error);

/* Makes the context current on this thread, and remembers what was, for pel_device_end to bring back. A borrowed one must be current
 * already. May be nested, and another device begun within, where the ends come in reverse order. Fails where the device is lost, or the
 * thread holds a context that EGL cannot replace. */
bool pel_device_begin(struct pel_device *device, struct pel_error *error);
void pel_device_end(struct pel_device *device); /* only after a begin that worked */

/* Whether GL has had no error since the last check (or begin). `what` heads the message: "upload: GL_INVALID_VALUE". Out of memory is
 * PEL_ERROR_MEMORY, a lost device and everything else PEL_ERROR_UNSUPPORTED. Clears the errors. */
bool pel_device_check(struct pel_device *device, const char *what, struct pel_error *error);

/* Bytes that the driver calls free now, between begin and end. False: it does not tell. */
bool pel_device_free_bytes(const struct pel_device *device, uint64_t *bytes);

/* Whether GL may be called on this thread, between begin and end: objects of a context that is gone are gone with it. */
bool pel_device_is_current(const struct pel_device *device);

enum {
    PEL_SAVED_UNITS = 16,
    PEL_SAVED_IMAGES = 8,
    PEL_SAVED_BUFFERS = 16,
    PEL_SAVED_TARGETS = 11,
    PEL_SAVED_STORES = 16,
    PEL_SAVED_SWITCHES = 22,
    PEL_SAVED_COLORS = 8,
};

/* How a host program draws: what decides which fragments of ours arrive, and what becomes of them. */
struct pel_gl_saved_drawing {
    GLint switches[PEL_SAVED_SWITCHES]; /* glEnable's */
    GLint scissor;                      /* viewport 0's */
    GLint logic_op, depth_func, cull_face, front_face, polygon_mode[2], clip_origin, clip_depth;
    GLboolean depth_mask;
    struct {
        GLint func, reference, value_mask, write_mask, fail, depth_fail, pass;
    } stencil[2]; /* of front and of back faces */
    GLfloat depth_range[2], viewport[4]; /* viewport 0's */
    struct {
        GLint blend, source, target, alpha_source, alpha_target, equation, alpha_equation;
        GLboolean mask[4];
    } colors[PEL_SAVED_COLORS];
};

/* The state that our passes change, as a host program had it: program, texture units 0..15 (all targets; samplers), image
 * units 0..7, storage and uniform buffers 0..15, pixel store, pixel pack and unpack buffers, framebuffers, vertex array, and how it draws. */
struct pel_gl_saved {
    GLint program, active_texture, vertex_array, draw_framebuffer, read_framebuffer;
    GLint pack_buffer, unpack_buffer, storage_buffer, uniform_buffer, dispatch_buffer;
    GLint stores[PEL_SAVED_STORES];
    GLint textures[PEL_SAVED_UNITS][PEL_SAVED_TARGETS], samplers[PEL_SAVED_UNITS];
    struct {
        GLint name, level, layered, layer, access, format;
    } images[PEL_SAVED_IMAGES];
    struct pel_gl_saved_range {
        GLint name;
        GLint64 start, size;
    } storage[PEL_SAVED_BUFFERS], uniform[PEL_SAVED_BUFFERS];
    struct pel_gl_saved_drawing drawing;
};

/* Takes note of it, then sets what would mislead us to GL's defaults: pixel store (with alignment 1), no pixel buffers, no samplers, and
 * nothing that keeps or alters fragments. A context of our own wants neither, as nobody else changes it. */
void pel_gl_save(struct pel_gl_saved *saved);
void pel_gl_restore(const struct pel_gl_saved *saved);

#endif
