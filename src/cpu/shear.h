/* SPDX-License-Identifier: MIT */
/* What the shear-warp kernels are given beside the job (kernel.h): the factored view.
 *
 * Lacroute and Levoy (1994): along the principal axis, the index axis nearest to the view direction, the volume is a stack of slices. In
 * sheared space all rays are perpendicular to the slices, so that a ray is one pixel (u, v) of an intermediate image and meets every slice
 * at a place that is linear in u and v: i(u, m) = i0 + m i1 + u (di0 + m di1),    j(v, m) = j0 + m j1 + v (dj0 + m dj1),    k(m) = first +
 * m step for slice m, front to back. In parallel projection di1 = dj1 = 0 (a shear); in perspective each slice has its scale. What the
 * slices add up to is then warped to the picture in two dimensions (warp.h). */
#ifndef PEL_CPU_SHEAR_H
#define PEL_CPU_SHEAR_H

#include "kernel.h"

/* A coordinate of a ray at slice m: (at0 + m at1) + pixel * (by0 + m by1). */
struct pel_shear_axis {
    double at0, at1, by0, by1;
};

/* Where slice m lies. */
struct pel_slice {
    float position, weight; /* along the principal axis: the slice of voxels before it, and how far it is towards the next */
    int voxel;              /* that slice; `position` as a number */
    int cell;               /* the layer of cells that it is looked up in */
    int layer_last;         /* the last slice in that layer */
    int whole;              /* unit: the whole part of i, which is that of all pixels' places; `part` the rest */
    float part;
    int32_t pair;           /* the weights of two neighbours (x_weights of fetch.h) */
    double i, di, j, dj;    /* i(u, m) = i + u di, j likewise */
};

struct pel_shear {
    int axis[3];       /* index axes: along scanlines, across them, principal */
    int width, height; /* of the intermediate image */
    bool perspective;
    bool unit;   /* a pixel is a voxel: di = dj = 1 at all slices */
    bool near;   /* and neighbours are fetched whole (kernel_shear_fetch.h) */
    bool linear; /* opacity is corrected by the paper's linear approximation */
    struct pel_shear_axis i, j;
    double first, step; /* k(m) */
    double reference;   /* the slice plane on which pixels and voxels agree: i at k = reference */
    int slice_count;
    const struct pel_slice *slices;
    double slice_from; /* slices lie before the eye: m > slice_from */

    float length;    /* parallel: world distance from slice to slice along a ray, in job->step */
    float toward[3]; /* parallel: direction of the rays, index space, as long as job->step */
    float gram[6];   /* perspective: |to_world d|^2 = g0 d0^2 + g1 d1^2 + g2 d2^2 + g3 d0 d1 + g4 d0 d2 + g5 d1 d2, in (job->step)^2 */

    const void *rows; /* near: voxels in rows along axis[0]; and from row to row along axis[1], from slice to slice along axis[2] */
    ptrdiff_t next_row, next_slice;
    const uint64_t *runs; /* a bit a cell that may be seen: rows of run_words along axis[0], for each cell along axis[1], axis[2] */
    int run_words;
    const uint8_t *seen; /* nullable: a bit a patch that may be seen: rows of seen_row bytes for each voxel along axis[1], axis[2] */
    ptrdiff_t seen_row;

    float *rgba;  /* the intermediate image, with a border of one empty pixel: rows of stride pixels of four floats */
    float *depth; /* m where opacity passes 0.5, negative where it does not; or NULL; laid out likewise */
    int stride;
    int *row_from, *row_to; /* each row's pixels that hold something, in the bordered image */
};

/* What a scanline is gathered in: arrays of the image's width and 2 W more. */
struct pel_scanline {
    float *color[3], *alpha, *depth;
    float *from, *to;          /* the slices between which the ray runs: from the first to the last m, not whole */
    float *length, *toward[3]; /* perspective: as in struct pel_shear, a ray */
    uint32_t *open;            /* a bit a pixel that is not opaque yet */
    int first, last;           /* slices between which any of its rays runs */
    int low, high;             /* pixels from low up to high have gathered something; everything else is clear */
};
#define PEL_SCANLINE_ARRAYS 11

#define PEL_WIDEST 16 /* lanes of any instruction set */
#define PEL_SHEAR_BAND 16 /* scanlines that a thread draws one after another: what one fetched, the next finds in the cache */
#endif
