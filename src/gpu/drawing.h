/* SPDX-License-Identifier: MIT */
/* What passes need that draw triangles instead of computing: targets, the fixed-function state of a pass, instances without vertices, and
 * the GPU's own count of fragments. Counted like the objects of objects.h. */
#ifndef PEL_GPU_DRAWING_H
#define PEL_GPU_DRAWING_H

#include "objects.h"

/* A framebuffer over textures that somebody else owns. */
struct pel_target {
    GLuint name;
};

/* Hangs textures on the target, made if need be; NULL: none of that kind. */
bool pel_target_set(struct pel_device *device, struct pel_target *target, const struct pel_texture *color, const struct pel_texture *depth,
                    struct pel_error *error);
void pel_target_destroy(struct pel_device *device, struct pel_target *target); /* accepts a zeroed one */

enum pel_blending {
    PEL_BLEND_NONE,
    PEL_BLEND_BEHIND, /* front to back: dst += (1 - dst.a) src */
    PEL_BLEND_OVER,   /* back to front: dst = src + (1 - src.a) dst */
};

/* All the fixed-function state of a pass; what is left out is off. */
struct pel_pass {
    GLenum depth_func;          /* GL_LESS, ...; 0: no test, and nothing is written */
    bool depth_write, color_write;
    enum pel_blending blending;
    GLenum cull;                /* GL_FRONT or GL_BACK faces are not drawn; 0: both are */
};

/* Starts a pass on the target, over width x height pixels of it. */
void pel_pass_begin(const struct pel_target *target, const struct pel_pass *pass, int width, int height);
/* GL's defaults again, for whoever comes next in a context of our own. */
void pel_pass_defaults(void);

/* A vertex array without vertices, whose instances may carry two unsigned integers each (attribute 0), from a buffer of pairs. */
struct pel_instances {
    GLuint name;
};
bool pel_instances_bind(struct pel_device *device, struct pel_instances *instances, const struct pel_buffer *pairs, struct pel_error *error);
void pel_instances_destroy(struct pel_device *device, struct pel_instances *instances); /* accepts a zeroed one */

/* Fragments that pass all tests between begin and end, as the GPU counts them. One at a time. */
struct pel_gpu_counter {
    GLuint query;
};
void pel_gpu_counter_begin(struct pel_device *device, struct pel_gpu_counter *counter);
void pel_gpu_counter_end(struct pel_gpu_counter *counter);
uint64_t pel_gpu_counter_value(struct pel_gpu_counter *counter); /* waits for it; 0 where it never ran */
void pel_gpu_counter_destroy(struct pel_device *device, struct pel_gpu_counter *counter);

#endif
