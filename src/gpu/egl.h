/* SPDX-License-Identifier: MIT */
/* EGL, from the search for devices to a context and what was current before it. Only src/gpu sees this. */
#ifndef PEL_GPU_EGL_H
#define PEL_GPU_EGL_H

#include "device_gl.h"

enum { PEL_MAX_DEVICES = 64 };

/* One way to a context. */
struct pel_egl_candidate {
    unsigned path; /* PEL_PATH_* */
    void *device;  /* EGLDeviceEXT where the path is PEL_PATH_DEVICE */
};

/* Whether the libraries are there. To be asked before any other function, epoxy's included: epoxy ends the process where it finds none. */
bool pel_egl_available(struct pel_error *error);
bool pel_gl_available(struct pel_error *error);

/* The ways to a context, at most PEL_MAX_DEVICES. 0: none, and why. */
int pel_egl_candidates(unsigned paths, struct pel_egl_candidate *candidates, struct pel_error *error);

/* Fills in path and node. */
void pel_egl_describe(const struct pel_egl_candidate *candidate, struct pel_device_info *info);

/* Makes a context: OpenGL 4.5 core, told of resets where the driver can; or, to learn what a driver has that cannot do that, any OpenGL. */
bool pel_egl_open(const struct pel_egl_candidate *candidate, bool any_version, bool debug, struct pel_egl *egl, struct pel_error *error);
void pel_egl_close(struct pel_egl *egl);

/* The context on this thread, and the one before it again. */
bool pel_egl_enter(const struct pel_egl *egl, struct pel_egl_current *before, struct pel_error *error);
void pel_egl_leave(const struct pel_egl *egl, const struct pel_egl_current *before);
void pel_egl_get_current(struct pel_egl_current *current);

#endif
