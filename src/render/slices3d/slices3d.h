/* SPDX-License-Identifier: MIT */
/* Slice-based volume rendering on the GPU engine, and how isosurfaces make it fast (iSBVR: Xue, Zhang and Crawfis 2005; chapter 3 of Xue
 * 2008). The parts: octree.c and cubes.c find the surfaces on the CPU, slice_view.c says where slices lie, passes.c has a function for each
 * pass of the papers, slices3d.c makes a frame of them, cost.c counts and predicts, slices3d_technique.c has the options. */
#ifndef PEL_SLICES3D_H
#define PEL_SLICES3D_H

#include "cubes.h"
#include "drawing.h"
#include "gpu_frame.h"
#include "gpu_job.h"
#include "technique.h"

/* What is drawn into the z-buffer before the volume. */
enum pel_cull {
    PEL_CULL_NONE,    /* nothing: brute force */
    PEL_CULL_FRONT,   /* section 3.2: front faces of phi_t, and GL_GREATER */
    PEL_CULL_ERR,     /* 3.4: rays that meet nothing */
    PEL_CULL_ESS,     /* 3.3 and 3.4: back faces of phi_t; empty rays with them */
    PEL_CULL_ERT,     /* 3.1: front faces of phi_p */
    PEL_CULL_ESS_ERT, /* 3.3, combined */
    PEL_CULL_BAND,    /* section 5's wish: all of these, and front faces of phi_t in a second z-buffer */
};
enum pel_show { PEL_SHOW_PICTURE, PEL_SHOW_DEPTH, PEL_SHOW_NEAR, PEL_SHOW_PHI_T, PEL_SHOW_PHI_P };
enum pel_phi_p {
    PEL_PHI_P_FOLLOWED, /* a ray is followed behind the face until it is hidden */
    PEL_PHI_P_REDUCED,  /* the face hides at once, as in the papers */
    PEL_PHI_P_ORIGINAL, /* the same without the shrinking of figure 8 */
};
enum pel_slice_target { PEL_TARGET_FLOAT32, PEL_TARGET_FLOAT16, PEL_TARGET_BYTE };

struct pel_slices3d_options {
    enum pel_cull cull;
    int cube_t, cube_p; /* voxels along an edge */
    double opaque;
    enum pel_phi_p phi_p;
    int slab; /* slices after which full pixels are stopped; 0: never */
    bool back_to_front, early_out, shrink, cost;
    enum pel_slice_target target;
    enum pel_show show;
};

/* The shaders' SliceBlock (slice_space.glsl), in the same order. */
struct pel_slice_block {
    float clip_x[4], clip_y[4], clip_w[4], depth[4], range[4], lo[4], hi[4], eye[4], inflate[4];
    int32_t cubes[4];
    float walk[4];
};

/* Where slices lie. */
struct pel_slice_view {
    struct pel_slice_block block;
    int count;         /* of slices */
    bool eye_inside;   /* the plane through the eye cuts the box: what is behind it is not drawn */
    unsigned faces[2]; /* directions that may show their back, their front; a bit each */
};

/* `jitter` as in struct pel_frame: frames that refine a picture have their slices elsewhere, all of them together. */
bool pel_slice_view_setup(struct pel_slice_view *view, const struct pel_job *job, bool parallel, int jitter, struct pel_error *error);

enum pel_slices3d_stage { PEL_STAGE_VIEW, PEL_STAGE_SURFACES, PEL_STAGE_SLICES, PEL_STAGE_FINISH, PEL_STAGES };

struct pel_slices3d {
    struct pel_device *device;
    struct pel_programs programs;
    struct pel_slices3d_options options; /* of the frame; set by prepare */
    bool stencil;                        /* the driver lets shaders write stencil values */

    /* With the volume. */
    struct pel_gpu_format format;
    struct pel_gpu_box box;
    struct pel_texture volume;
    struct pel_octree octree;

    /* With the transfer function. */
    struct pel_classification_state tables;
    struct pel_job job;
    struct pel_texture entries, opacities;
    struct pel_buffer range;
    struct pel_cube_table cube_table;
    struct pel_cube_set phi_t, phi_p;
    struct pel_cube_faces {
        struct pel_buffer buffer;
        GLuint texture;
    } faces_t, faces_p, faces_box;
    bool has_t, has_p; /* their faces are on the device */

    /* With the view. */
    struct pel_slice_view view;
    struct pel_buffer block, slice_block;
    struct pel_texture picture, z, near, stretch, depth, finished;
    struct pel_target target, near_target, z_target, stretch_target, depth_target, finished_target;
    struct pel_vertices vertices;
    struct pel_gpu_stage stages[PEL_STAGES];
    struct pel_gpu_counter counters[4]; /* of phi_t and of phi_p in the z-buffer, of slices; cost.c's */
    int stops;                          /* passes between slabs */
};

/* ---- passes.c: the passes of a frame, each in the papers' words ---- */

/* What is bound for all passes. */
bool pel_slices3d_bind(struct pel_slices3d *s, struct pel_error *error);
/* Each ray's stretch; for a band with the second z-buffer, phi_t's front faces. */
bool pel_slices3d_measure_stretches(struct pel_slices3d *s, enum pel_cull cull, struct pel_error *error);
/* The z-buffer for the frame's way of culling (sections 3.1 to 3.4). */
bool pel_slices3d_init_z(struct pel_slices3d *s, enum pel_cull cull, struct pel_error *error);
/* The volume pass, and what stops full pixels between its slabs. */
bool pel_slices3d_draw_slices(struct pel_slices3d *s, enum pel_cull cull, int slab, struct pel_error *error);
/* Slices with the simple shader of section 2, which counts fragments and leaves the picture alone. */
bool pel_slices3d_count(struct pel_slices3d *s, enum pel_cull cull, struct pel_gpu_counter *counter, struct pel_error *error);
/* All fragments of phi_t's back faces, or of phi_p's front faces. */
bool pel_slices3d_count_faces(struct pel_slices3d *s, bool p, struct pel_gpu_counter *counter, struct pel_error *error);
bool pel_slices3d_find_depth(struct pel_slices3d *s, struct pel_error *error);
bool pel_slices3d_to_display(struct pel_slices3d *s, struct pel_error *error);
/* Figure 9. */
bool pel_slices3d_show(struct pel_slices3d *s, struct pel_error *error);

/* ---- cost.c ---- */

/* After a frame: measures what the cost model wants, and notes it as counters. What was drawn is gone then. */
bool pel_slices3d_note_cost(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error);

/* ---- slices3d.c ---- */

struct pel_slices3d *pel_slices3d_create(struct pel_device *device, struct pel_error *error);
void pel_slices3d_destroy(struct pel_slices3d *slices); /* accepts NULL */
/* Slices are cut from the whole volume's box, or from that of phi_t's cubes. */
bool pel_slices3d_use_box(struct pel_slices3d *s, bool shrunk, struct pel_error *error);
bool pel_slices3d_prepare(struct pel_slices3d *slices, const struct pel_frame *frame, struct pel_error *error);
bool pel_slices3d_draw(struct pel_slices3d *slices, const struct pel_frame *frame, struct pel_error *error);

#endif
