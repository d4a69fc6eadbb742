/* SPDX-License-Identifier: MIT */
/* Isosurfaces drawn as triangles on the GPU engine: what the paper on multi-layer depth peeling (Liu, Clapworthy and Dong 2010) is measured
 * against. The parts: mesh_surfaces.c gets triangles from the volume on to the device, by way of the CPU or of mesh_extraction.c;
 * mesh_passes.c has a function for each pass, mesh_frame.c makes a frame of them, mesh_technique.c has the options. */
#ifndef PEL_MESH_RENDER_H
#define PEL_MESH_RENDER_H

#include "drawing.h"
#include "gpu_frame.h"
#include "gpu_job.h"
#include "mesh_extraction.h"
#include "minmax.h"
#include "technique.h"

enum pel_mesh_extract { PEL_MESH_EXTRACT_CPU, PEL_MESH_EXTRACT_GPU };

struct pel_mesh_options {
    enum pel_mesh_extract extract;
    double tolerance; /* as in struct pel_mesh_params */
};

enum pel_mesh_stage { PEL_MESH_OPAQUE, PEL_MESH_TRANSLUCENT, PEL_MESH_FINISH, PEL_MESH_STAGES };

/* The shaders' MeshBlock (mesh_space.glsl), in the same order. */
struct pel_mesh_block {
    float clip_x[4], clip_y[4], clip_z[4], clip_w[4], depth[4], from_z[4];
    uint32_t room[4];
};

struct pel_mesh_renderer {
    struct pel_device *device;
    struct pel_programs programs;
    struct pel_mesh_options options; /* of the frame; set by prepare */

    /* With the volume. */
    struct pel_gpu_format format;
    struct pel_gpu_box box;
    struct pel_minmax minmax;

    /* With the isovalues: in the order of job.iso. */
    struct pel_mesh_surface surfaces[PEL_MAX_ISOSURFACES];
    struct pel_mesh_extraction extraction;

    /* With the scene's settings. */
    struct pel_classification_state tables;
    struct pel_job job;

    /* With the view. */
    struct pel_mesh_block view;
    struct pel_buffer block, mesh_block;
    struct pel_texture picture, finished, z, depth; /* finished: in display values, where colours were gathered in linear light */
    struct pel_target surface_target, finished_target;
    struct pel_vertices whole;
    struct pel_buffer heads, links, nodes; /* lists of translucent fragments */
    uint32_t listed;                       /* fragments in them */
    struct pel_gpu_stage stages[PEL_MESH_STAGES];
};

/* ---- mesh_surfaces.c ---- */

/* Extracts the surfaces of the scene's isovalues. The frame's uniform block must be there. */
bool pel_mesh_surfaces_make(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error);
void pel_mesh_surfaces_finish(struct pel_mesh_renderer *m);

/* Bytes of surfaces, of lists and of the extraction on the device: what the memory allowed is held against. */
uint64_t pel_mesh_held(const struct pel_mesh_renderer *m);

/* ---- mesh_passes.c ---- */

/* Buffers of lists for so many fragments, at least. */
bool pel_mesh_reserve_lists(struct pel_mesh_renderer *m, uint64_t fragments, struct pel_error *error);
bool pel_mesh_draw_opaque(struct pel_mesh_renderer *m, struct pel_error *error);
/* Gathers lists and resolves them; nothing where no surface is translucent. */
bool pel_mesh_draw_translucent(struct pel_mesh_renderer *m, struct pel_error *error);
bool pel_mesh_find_depth(struct pel_mesh_renderer *m, struct pel_error *error);
bool pel_mesh_to_display(struct pel_mesh_renderer *m, struct pel_error *error);

/* ---- mesh_frame.c ---- */

struct pel_mesh_renderer *pel_mesh_renderer_create(struct pel_device *device, struct pel_error *error);
void pel_mesh_renderer_destroy(struct pel_mesh_renderer *m); /* accepts NULL */
bool pel_mesh_renderer_prepare(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error);
bool pel_mesh_renderer_draw(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error);

#endif
