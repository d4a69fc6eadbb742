/* SPDX-License-Identifier: MIT */
/* What the shaders are told of a frame: the uniform block of job.glsl and the transfer function's tables, from the CPU engine's job and
 * classification, so that both engines draw the same thing. */
#ifndef PEL_RENDER_GPU_JOB_H
#define PEL_RENDER_GPU_JOB_H

#include "gpu_volume.h"

/* Bindings, as the shaders name them. */
enum {
    PEL_UNIT_VOLUME,
    PEL_UNIT_DISTANCES,
    PEL_UNIT_GRID,
    PEL_UNIT_FROM,
    PEL_UNIT_ENTRIES,
    PEL_UNIT_FACES,
    PEL_UNIT_OPACITIES,
    PEL_UNIT_STRETCHES,
    PEL_UNIT_NEAR,
    PEL_UNIT_PICTURE,
};
enum { PEL_TILE_SIDE = 8 }; /* pixels along a side of a work group's tile (tile.glsl) */
enum { PEL_BUFFER_COUNTERS = 2, PEL_BUFFER_SEEN, PEL_BUFFER_RANGE };

/* A part of the volume that is drawn by itself; the whole volume is one. Index positions and voxels. */
struct pel_gpu_box {
    int origin[3], size[3];         /* voxels that its texture holds */
    int first[3], last[3];          /* it takes the samples in [first, last); far beyond the volume where it ends there */
    int first_cell[3], cells[3];    /* its cells of the min-max grid */
};

/* A box that is the whole volume. */
void pel_gpu_box_whole(struct pel_gpu_box *box, const struct pel_volume *volume);

struct pel_gpu_job {
    const struct pel_job *job;
    const struct pel_scene *scene;
    const struct pel_gpu_format *format;
    const struct pel_gpu_box *box;
};

/* Sends the uniform block. */
bool pel_gpu_job_send(struct pel_device *device, const struct pel_gpu_job *job, struct pel_buffer *to, struct pel_error *error);

/* Sends the look-up table (transfer.glsl) and the range table (classify.glsl). */
bool pel_gpu_tables_send(struct pel_device *device, const struct pel_classification_state *from, struct pel_texture *entries,
                         struct pel_buffer *range, struct pel_error *error);

/* What a program is compiled for. */
enum pel_gpu_has {
    PEL_HAS_VOIDS = 1,
    PEL_HAS_NEAREST = 2,
    PEL_HAS_SHADE = 4,
    PEL_HAS_HEADLIGHTS = 8,
    PEL_HAS_PRE = 16,
    PEL_HAS_MINIMUM = 32,
    PEL_HAS_BRICKS = 64,
    PEL_HAS_PREINTEGRATED = 128, /* these are of slices */
    PEL_HAS_BAND = 256,
    PEL_HAS_EARLY_OUT = 512,
    PEL_HAS_SHOW = 1024,
    PEL_HAS_GREATER = 2048,
    PEL_HAS_ONE_ISOVALUE = 4096,
};

/* The program of a shader file for these; 0 on failure. */
GLuint pel_gpu_program(struct pel_device *device, struct pel_programs *programs, const char *file, unsigned has, enum pel_mode mode,
                       struct pel_error *error);
/* The same with a vertex and a fragment shader. */
GLuint pel_gpu_program_drawing(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *fragment,
                               unsigned has, struct pel_error *error);

#endif
