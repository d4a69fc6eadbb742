/* SPDX-License-Identifier: MIT */
/* Device: a GPU, or software that plays one, with an OpenGL 4.5 core context on it. No window, display or root is needed.
 *
 * The library looks for its GPU through EGL at run time. Where there is no libEGL or no OpenGL library, everything else still works, and
 * these functions say in their error what is missing. A program that has a context already (GLFW, SDL, Qt, GTK, on GLX, WGL or EGL) lends
 * it with pel_device_wrap_current instead.
 *
 * Threads: a device may be used by one thread at a time, by any. What the calling thread has current in EGL is current again when a
 * function of the library returns. A thread with a GLX context current can use no other device than that context, wrapped: EGL refuses to
 * take its place.
 *
 * EGL counts no users of its displays, so the library never terminates one: what the driver keeps for a display stays until the process
 * ends, once, however many devices come and go. */
#ifndef PELLUCID_DEVICE_H
#define PELLUCID_DEVICE_H

#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* What is known of a device. Texts are empty and numbers 0 where the driver did not tell. */
struct pel_device_info {
    char name[128];    /* GL_RENDERER: "NVIDIA H100 80GB HBM3", "llvmpipe (LLVM 15.0.6, 256 bits)" */
    char vendor[64];   /* GL_VENDOR */
    char version[64];  /* GL_VERSION */
    char path[32];     /* how its context was made: "EGL device", "EGL surfaceless", "EGL pbuffer", "borrowed" */
    char node[64];     /* what tells equal GPUs apart: "/dev/dri/renderD128", "CUDA device 1" */
    bool software;     /* drawn by the CPU (llvmpipe and the like) */
    bool usable;       /* has OpenGL 4.5 */
    bool chosen;       /* pel_device_create(-1) takes this one; set by pel_device_list alone */
    char note[256];    /* one line: why it is chosen, passed over, or not usable */
    uint64_t memory_bytes; /* of the device; where the driver tells free memory only (AMD), what was free. Software: 0 */

    /* Limits; 0 where it is not usable. */
    int max_texture_2d;                /* texels along an axis */
    int max_texture_3d;                /* voxels along an axis */
    int max_array_layers;
    uint64_t max_storage_buffer_bytes; /* of one shader storage block */
    int max_compute_invocations;       /* in one work group */
};

struct pel_device_params {
    /* Told what the driver has to say (GL_KHR_debug): errors, warnings about speed. One line without a newline. Called from within
     * functions of the library, perhaps from a thread of the driver unless `debug` is set. It must not call the library or GL. Nullable. */
    void (*log)(void *user, const char *message);
    void *log_user;
    bool debug; /* a debug context: the driver checks more, says more, in order, and is slower */
    /* Bytes of the device's memory to use at most for volumes, which are then drawn in bricks that come and go, and for what techniques
     * make of them: surfaces, lists, masks of cells (a technique that cannot do with it fails, and says so); pictures and tables come
     * beside. 0: what the driver says is free. Others may work on the same GPU. */
    uint64_t memory_limit;
};
#define PEL_DEVICE_PARAMS_INIT { NULL, NULL, false, 0 }

/* Lists the devices in EGL's order: the first `room` of them into infos (nullable where room is 0), usable or not. Returns how many there
 * are, which may be more than room. 0: there is none, and `error` says why; there is no other failure. Each device is opened to be
 * described, which can take a second; nothing stays open. */
int pel_device_list(struct pel_device_info *infos, int room, struct pel_error *error);

struct pel_device;

/* Makes a context on device `index` of the list; -1: on the first usable hardware GPU, else on the first usable software one (ask
 * `software` of pel_device_describe). params NULL: the defaults. Errors: PEL_ERROR_ARGUMENT, no such index; PEL_ERROR_UNSUPPORTED, no
 * usable GPU, and why. */
struct pel_device *pel_device_create(int index, const struct pel_device_params *params, struct pel_error *error);

/* Borrows the context that is current on the calling thread: OpenGL 4.5, core or compatibility, made by whatever means. It must be current
 * again, on whichever thread, whenever the device is used or destroyed, and outlive the device. No state of it that the library changes
 * stays changed, except that GL errors the host left pending are cleared. The host's debug callback stays. */
struct pel_device *pel_device_wrap_current(struct pel_error *error);

/* Destroys the context, if it is the library's own. What was made with the device must be destroyed before. NULL is fine. */
void pel_device_destroy(struct pel_device *device);

/* What the device is; valid as long as the device. */
const struct pel_device_info *pel_device_describe(const struct pel_device *device);

/* Live GL objects (textures, buffers, programs, ...) that the library made on the device: 0 before it is destroyed, or something leaks. */
int pel_device_objects(const struct pel_device *device);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
