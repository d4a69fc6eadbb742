/* SPDX-License-Identifier: MIT */
/* What passes need that draw triangles instead of computing: targets, the fixed-function state of a pass, vertices without data, and the
 * GPU's own count of fragments. Counted like the objects of objects.h. */
#ifndef PEL_GPU_DRAWING_H
#define PEL_GPU_DRAWING_H

#include "objects.h"

/* A framebuffer over textures that somebody else owns. */
struct pel_target {
    GLuint name;
};

/* Hangs textures on the target, made if need be; NULL: none of that kind. A depth texture's stencil comes with it. All layers of an array
 * texture are drawn to, as the geometry shader says. */
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
    GLenum depth_func; /* GL_LESS, ...; 0: no test, and nothing is written */
    bool depth_write, color_write;
    enum pel_blending blending;
    bool logic_or;      /* in place of blending, on whole numbers: dst |= src */
    bool stencil_write; /* the fragment shader's value goes into the stencil buffer */
    bool stencil_test;  /* passes where the stencil buffer is at most the reference (pel_pass_stencil) */
};

/* Starts a pass on the target, over width x height pixels of it. */
void pel_pass_begin(const struct pel_target *target, const struct pel_pass *pass, int width, int height);
/* The reference of the stencil test, 0 to 255. */
void pel_pass_stencil(int reference);
/* GL's defaults again, for whoever comes next in a context of our own. */
void pel_pass_defaults(void);

/* A vertex array: without data, where shaders make their vertices from the vertex' and the instance's number, or over one buffer. */
struct pel_vertices {
    GLuint name;
};
bool pel_vertices_bind(struct pel_device *device, struct pel_vertices *vertices, struct pel_error *error);

enum pel_vertices_kind {
    PEL_VERTICES_PAIRS,   /* two unsigned integers an instance */
    PEL_VERTICES_CORNERS, /* four floats a vertex */
};

/* The same over a buffer, which is attribute 0, as it is now. */
bool pel_vertices_bind_buffer(struct pel_device *device, struct pel_vertices *vertices, enum pel_vertices_kind kind,
                              const struct pel_buffer *buffer, struct pel_error *error);
void pel_vertices_destroy(struct pel_device *device, struct pel_vertices *vertices); /* accepts a zeroed one */

/* A buffer of pairs of unsigned integers as a texture that vertex shaders may read; made anew, as the buffer may be another. */
bool pel_pairs_texture(struct pel_device *device, GLuint *texture, const struct pel_buffer *pairs, struct pel_error *error);
void pel_pairs_texture_destroy(struct pel_device *device, GLuint *texture);
/* How many pairs such a texture may have. */
size_t pel_pairs_limit(void);

/* Fragments that pass all tests between begin and end, as the GPU counts them. One at a time. */
struct pel_gpu_counter {
    GLuint query;
};
void pel_gpu_counter_begin(struct pel_device *device, struct pel_gpu_counter *counter);
void pel_gpu_counter_end(struct pel_gpu_counter *counter);
uint64_t pel_gpu_counter_value(struct pel_gpu_counter *counter); /* waits for it; 0 where it never ran */
void pel_gpu_counter_destroy(struct pel_device *device, struct pel_gpu_counter *counter);

#endif
