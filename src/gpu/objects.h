/* SPDX-License-Identifier: MIT */
/* Programs, textures, buffers and timers of a device, counted, so that a test can see that none is left. All need the device's context to
 * be current (pel_device_begin). A handle of 0 is nothing: destroying it is allowed. */
#ifndef PEL_GPU_OBJECTS_H
#define PEL_GPU_OBJECTS_H

#include <stddef.h>

#include <epoxy/gl.h>

#include "device_gl.h"

/* A compute program from a shader file (shader_source.h) and lines of defines. A binary that an earlier run left in
 * $XDG_CACHE_HOME/pellucid is taken where driver and text are the same. 0 and the compiler's words on failure. */
GLuint pel_program_create(struct pel_device *device, const char *file, const char *defines, struct pel_error *error);
/* One that draws: a vertex shader's file and a fragment shader's, with the same defines; without the latter (NULL) depth alone is written. */
GLuint pel_program_create_drawing(struct pel_device *device, const char *vertex, const char *fragment, const char *defines,
                                  struct pel_error *error);
void pel_program_destroy(struct pel_device *device, GLuint program);

/* The programs that a renderer has asked for, made once each. */
enum { PEL_MAX_PROGRAMS = 64 };
struct pel_programs {
    struct pel_named_program {
        char *key;
        GLuint name;
    } list[PEL_MAX_PROGRAMS];
    int count;
};

/* The program of pel_program_create, made at its first use; the oldest is forgotten where there are too many. 0 on failure. */
GLuint pel_programs_find(struct pel_device *device, struct pel_programs *programs, const char *file, const char *defines,
                         struct pel_error *error);
/* The same of pel_program_create_drawing. */
GLuint pel_programs_find_drawing(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *fragment,
                                 const char *defines, struct pel_error *error);
/* One with a geometry shader between them, which may send primitives to layers of an array texture. */
GLuint pel_programs_find_layered(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *geometry,
                                 const char *fragment, const char *defines, struct pel_error *error);
void pel_programs_finish(struct pel_device *device, struct pel_programs *programs); /* accepts a zeroed one */

struct pel_texture {
    GLuint name;
    GLenum format; /* sized internal format */
    int size[3];   /* 1 beyond the texture's dimensions */
    uint64_t bytes;
};

/* Immutable storage of one level, 2D where depth is 0, else 3D. Filter GL_NEAREST or GL_LINEAR; coordinates are clamped to the edge. The
 * texture must be zeroed, or an older one, which is kept where it fits and else replaced; what it holds is undefined afterwards. */
bool pel_texture_reserve(struct pel_device *device, struct pel_texture *texture, GLenum format, int width, int height, int depth,
                         GLenum filter, struct pel_error *error);
/* The same of an array of 2D layers, which are filtered each for itself. */
bool pel_texture_reserve_array(struct pel_device *device, struct pel_texture *texture, GLenum format, int width, int height, int layers,
                               GLenum filter, struct pel_error *error);
void pel_texture_destroy(struct pel_device *device, struct pel_texture *texture); /* accepts a zeroed one */

struct pel_buffer {
    GLuint name;
    size_t bytes;
};

/* At least `bytes` bytes, copied from `data` where it is not NULL. Like textures, kept where it is large enough. */
bool pel_buffer_fill(struct pel_device *device, struct pel_buffer *buffer, const void *data, size_t bytes, struct pel_error *error);
void pel_buffer_destroy(struct pel_device *device, struct pel_buffer *buffer); /* accepts a zeroed one */

/* Time of what is submitted between begin and end, on the GPU: by its clock at both, so that nothing hinders a host's own timers. */
struct pel_gpu_timer {
    GLuint queries[2];
};
void pel_gpu_timer_begin(struct pel_device *device, struct pel_gpu_timer *timer,
                         const char *stage); /* opens a debug group of that name, too */
void pel_gpu_timer_end(struct pel_gpu_timer *timer);
double pel_gpu_timer_ms(struct pel_gpu_timer *timer); /* waits for it */
void pel_gpu_timer_destroy(struct pel_device *device, struct pel_gpu_timer *timer);

#endif
