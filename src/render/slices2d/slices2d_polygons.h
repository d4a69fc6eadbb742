/* SPDX-License-Identifier: MIT */
/* Where slices lie on the device: which stacks a picture needs, the uniform block of slices2d_space.glsl, and what of each polygon can be
 * seen at all. */
#ifndef PEL_RENDER_SLICES2D_POLYGONS_H
#define PEL_RENDER_SLICES2D_POLYGONS_H

#include <pellucid/error.h>

#include "kernel.h"
#include "shear_factor.h"

/* A stack and its share in the picture. */
struct pel_slices2d_part {
    int axis, sign; /* -1 where the view goes down the axis */
    bool split;     /* several share the picture, each the rays that are nearest to its axis */
    double weight;  /* blended: of its picture; else 1 */
};

/* The stacks that the view needs: one in most; the main one first. Within `blend` degrees across the switch from one to another both, with
 * weights that add up to 1. */
int pel_slices2d_parts(const struct pel_job *job, bool perspective, double blend, struct pel_slices2d_part parts[PEL_SHEAR_PARTS]);

/* The shaders' SliceBlock, std140. */
struct pel_slices2d_block {
    float stack[4];
    int32_t polygons[4];
    float eye[4], to_picture[3][4], rules[4], ambient[4];
};

struct pel_slices2d_layout {
    int supersampling, every; /* slices for so many slices of voxels */
    int each;                 /* slices a polygon */
    bool surfaces;            /* polygons take the stretches from slice to slice, not slabs around slices */
};

/* Fills the block (but `ambient`) for a part; gives the number of polygons. */
int pel_slices2d_lay(const struct pel_job *job, bool perspective, const struct pel_slices2d_part *part,
                     const struct pel_slices2d_layout *layout, struct pel_slices2d_block *block);

/* For each polygon the stretches of u and v in which anything can be seen, as from | to << 16 in voxels; 0, 0 where nothing can. From the
 * marks of cells, unless `all`. Gives the number of polygons that can be seen. */
int pel_slices2d_seen(const struct pel_job *job, const struct pel_slices2d_part *part, const struct pel_slices2d_layout *layout,
                      int polygons, bool all, uint32_t (*seen)[2], struct pel_error *error);

/* The cross-sections of the job's slice planes with the box, cut at one another into pieces, the nearest first, and these into strips between
 * slices of voxels (section 9), as triangles. */
struct pel_slices2d_strips {
    float (*corners)[4]; /* stack space, and the slice of voxels before * PEL_MAX_SLICES + the plane */
    int count;
    int *ends; /* of each piece: how many corners there are up to its end */
    int pieces;
};

bool pel_slices2d_strips(const struct pel_job *job, bool perspective, int axis, struct pel_slices2d_strips *strips,
                         struct pel_error *error);
void pel_slices2d_strips_finish(struct pel_slices2d_strips *strips);

#endif
