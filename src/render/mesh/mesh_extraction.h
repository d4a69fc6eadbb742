/* SPDX-License-Identifier: MIT */
/* Marching cubes on the device, by HistoPyramids (Dyken, Ziegler, Theobalt and Seidel 2008): one of bricks finds where the surface may be,
 * one of vertices and one of triangles tell who makes which. Only the three totals are read back. The triangles are those that
 * src/data/mesh makes without a tolerance, from the same table of cells, with shared vertices. */
#ifndef PEL_MESH_EXTRACTION_H
#define PEL_MESH_EXTRACTION_H

#include "gpu_job.h"
#include "histopyramid.h"
#include "minmax.h"

struct pel_mesh_extraction {
    struct pel_texture volume;
    struct pel_buffer bounds, table; /* of bricks; of cells */
    struct pel_buffer list, slots, first;
    struct pel_histopyramid bricks, vertices, triangles;
    size_t brick_count;
    uint64_t beside;   /* bytes that the caller keeps on the device beside these: set before each run */
    bool voids, ready; /* ready: the volume is there */
};

/* A surface on the device: places and gradients (six floats a vertex, index space), corners of triangles. */
struct pel_mesh_surface {
    struct pel_buffer vertices, elements;
    GLuint array;
    size_t vertex_count, element_count;
    GLint base; /* added to the corners' numbers */
};

/* With the volume: its texture and its bricks' bounds. */
bool pel_mesh_extraction_take(struct pel_device *device, struct pel_mesh_extraction *x, const struct pel_gpu_format *format,
                              const struct pel_gpu_box *box, const struct pel_volume *volume, const struct pel_minmax *minmax, int threads,
                              struct pel_error *error);
/* The surface of job.iso[number]; the frame's uniform block must be bound. */
bool pel_mesh_extraction_run(struct pel_device *device, struct pel_programs *programs, struct pel_mesh_extraction *x, int number,
                             struct pel_mesh_surface *to, struct pel_error *error);
/* Bytes on the device. */
uint64_t pel_mesh_extraction_held(const struct pel_mesh_extraction *x);
void pel_mesh_extraction_finish(struct pel_device *device, struct pel_mesh_extraction *x); /* accepts a zeroed one */

#endif
