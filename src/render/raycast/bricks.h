/* SPDX-License-Identifier: MIT */
/* How a volume is cut into bricks that a device can hold: bricks own the samples in whole cells of the min-max grid, edge to edge, and hold
 * voxels of their neighbours around them, so that whatever a sample needs is in its brick. A volume that fits is one brick. */
#ifndef PEL_RENDER_BRICKS_H
#define PEL_RENDER_BRICKS_H

#include "gpu_job.h"

struct pel_brick_plan {
    int dims[3]; /* of the volume */
    int edge;    /* voxel steps that a brick owns along each axis; a multiple of the cell size */
    int border;  /* voxels of neighbours that it holds on each side */
    int count[3];
};

struct pel_brick_limits {
    int side;       /* texels along an axis of a 3D texture */
    uint64_t bytes; /* that the volume and its cells may take; 0: any */
    int voxel_bytes;
};

/* Voxels of neighbours that a brick needs for these settings: what a segment from its last sample reaches, and a gradient there. */
int pel_bricks_border(const struct pel_scene *scene);

/* One brick if the limits allow it and `cut` is not set, else bricks of which at least four fit. False where not even small bricks fit. */
bool pel_bricks_plan(struct pel_brick_plan *plan, const struct pel_volume *volume, int border, const struct pel_brick_limits *limits,
                     bool cut, struct pel_error *error);

int pel_bricks_count(const struct pel_brick_plan *plan);

/* Where brick `index` lies, x fastest. */
void pel_bricks_box(const struct pel_brick_plan *plan, int index, struct pel_gpu_box *box);

/* Bytes on the device for a box. */
uint64_t pel_bricks_bytes(const struct pel_gpu_box *box, int voxel_bytes);

/* The bricks in an order in which none hides one before it, for rays of the job. `order` has room for all. */
bool pel_bricks_sort(const struct pel_brick_plan *plan, const struct pel_job *job, bool parallel, int *order, struct pel_error *error);

#endif
