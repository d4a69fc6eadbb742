/* SPDX-License-Identifier: MIT */
/* Voxels of a scanline that are neighbours in memory: whole vectors are loaded where fetch.h gathers. This is what object-aligned slices
 * are for: at a pixel a voxel all lanes have the same weights.
 *
 * Along x the volume itself has such rows. Where scanlines run along y (the principal axis is x), what may be seen is turned (turned.h). The
 * arithmetic is that of fetch.h to the bit, since a pixel may be fetched either way. */
#ifndef PEL_CPU_KERNEL_SHEAR_FETCH_H
#define PEL_CPU_KERNEL_SHEAR_FETCH_H

#include "fetch.h"
#include "shear.h"

PEL_INLINE vf vf_load(const float *from)
{
    vf v;
    memcpy(&v, from, sizeof v);
    return v;
}

PEL_INLINE void vf_store(float *to, vf v)
{
    memcpy(to, &v, sizeof v);
}

/* A scanline's place in a slice. */
struct slice_row {
    float i, di;  /* i(u) = i + u di */
    int whole;    /* unit: the whole part of i; `i` is the rest */
    int j;        /* the row of voxels before it */
    float weight; /* how far it is towards the next */
    int m;
    bool near;                              /* unit steps in a slice of voxels that has others around: no gathering is needed */
    bool turned;                            /* then: the rows were turned */
    const void *rows;                       /* then: where they are */
    ptrdiff_t offset, next_row, next_slice; /* then: voxel of pixel 0, and from row to row and slice to slice */
    int32_t pair;                           /* then: the weights of two neighbours (x_weights of fetch.h) */
    int row_before, row_after, slice_before; /* then: rows and slices beside it that the gradient reads */
};

#if PEL_KIND != PEL_KIND_WIDE

#if PEL_KIND == PEL_KIND_U8
typedef uint8_t narrow_type;
#elif PEL_KIND == PEL_KIND_U16
typedef uint16_t narrow_type;
#else
typedef float narrow_type;
#endif

#if PEL_KIND == PEL_KIND_U8 || PEL_KIND == PEL_KIND_U16

typedef narrow_type narrow __attribute__((vector_size(W * sizeof(narrow_type))));
typedef vi row_voxels;

/* W neighbours along a row; 16-bit numbers in their lanes' lower halves. `j` rows, `k` slices and `x` voxels on. */
PEL_INLINE vi row_load(const struct pel_job *job, const struct slice_row *r, int u, int x, int j, int k)
{
    narrow n;
    memcpy(&n, (const narrow_type *)r->rows + r->offset + u + x + j * r->next_row + k * r->next_slice, sizeof n);
#if PEL_KIND == PEL_KIND_U8
    return __builtin_convertvector(n ^ (narrow_type)job->flip, vi);
#else
    typedef int16_t narrow_signed __attribute__((vector_size(W * 2)));
    return __builtin_convertvector((narrow_signed)(n ^ (narrow_type)job->flip), vi);
#endif
}

/* The raw value. */
PEL_INLINE vf row_float(vi voxels)
{
    return vi_to_vf(voxels) * 16384.0f;
}

PEL_INLINE vi row_pair(vi left, vi right)
{
    return (PEL_KIND == PEL_KIND_U8 ? left : left & 0xffff) | (right << 16);
}

PEL_INLINE vi row_weights(const struct slice_row *r)
{
    return vi_set(r->pair);
}

PEL_INLINE vi row_least(vi a, vi b)
{
    return vi_min(a, b);
}

PEL_INLINE vi row_most(vi a, vi b)
{
    return vi_max(a, b);
}

/* As middle_lerp and slope_lerp of fetch.h. */
PEL_INLINE vf row_lerp(const struct slice_row *r, vi left, vi right)
{
    return vi_to_vf(vi_madd16(row_pair(left, right), row_weights(r)));
}

PEL_INLINE vf row_slope(const struct slice_row *r, const vi v[4])
{
    vi w = row_weights(r), front = vi_madd16(row_pair(v[0], v[1]), w), back = vi_madd16(row_pair(v[2], v[3]), w);
#if PEL_KIND == PEL_KIND_U8
    return vi_to_vf(back - front);
#else
    return vi_to_vf(back) - vi_to_vf(front);
#endif
}

#else

typedef vf row_voxels;

PEL_INLINE vf row_load(const struct pel_job *job, const struct slice_row *r, int u, int x, int j, int k)
{
    (void)job;
    return vf_load((const float *)r->rows + r->offset + u + x + j * r->next_row + k * r->next_slice);
}

PEL_INLINE vf row_float(vf voxels)
{
    return voxels;
}

PEL_INLINE vf row_least(vf a, vf b)
{
    return vf_min(a, b);
}

PEL_INLINE vf row_most(vf a, vf b)
{
    return vf_max(a, b);
}

PEL_INLINE vf row_lerp(const struct slice_row *r, vf left, vf right)
{
    return vf_lerp(left, right, vf_set(r->i));
}

PEL_INLINE vf row_slope(const struct slice_row *r, const vf v[4])
{
    return vf_lerp(v[2] - v[0], v[3] - v[1], vf_set(r->i));
}

#endif

/* The next scanline reads a row farther: it is fetched while this one goes on. */
PEL_INLINE void near_prefetch(const struct slice_row *r, int u, int rows)
{
    __builtin_prefetch((const narrow_type *)r->rows + r->offset + u + rows * r->next_row);
}

PEL_INLINE vf row_value(const struct pel_job *job, const struct slice_row *r, int u, int j, int k)
{
    return row_lerp(r, row_load(job, r, u, 0, j, k), row_load(job, r, u, 1, j, k));
}

/* A turned voxel's raw value. */
PEL_INLINE vf turned(const struct pel_job *job, const struct slice_row *r, int u, int x, int j, int k)
{
    return row_float(row_load(job, r, u, x, j, k));
}

/* The value in a slice of voxels: bilinear. The same bits as fetch_value gives. */
PEL_INLINE vf near_value(const struct pel_job *job, const struct slice_row *r, int u)
{
    vf weight = vf_set(r->weight);
    if (!r->turned)
        return vf_lerp(row_value(job, r, u, 0, 0), row_value(job, r, u, 1, 0), weight);
    vf part = vf_set(r->i);
    return vf_lerp(vf_lerp(turned(job, r, u, 0, 0, 0), turned(job, r, u, 1, 0, 0), part),
                   vf_lerp(turned(job, r, u, 0, 1, 0), turned(job, r, u, 1, 1, 0), part), weight);
}

PEL_INLINE void straight_gradient(const struct pel_job *job, const struct slice_row *r, int u, vf to[3])
{
    vf weight = vf_set(r->weight), middle[2], slope[2];
    for (int j = 0; j < 2; j++) {
        row_voxels v[4];
        for (int x = 0; x < 4; x++)
            v[x] = row_load(job, r, u, x - 1, j, 0);
        middle[j] = row_lerp(r, v[1], v[2]);
        slope[j] = row_slope(r, v);
    }
    to[0] = vf_lerp(slope[0], slope[1], weight);
    to[1] = vf_lerp(middle[1] - row_value(job, r, u, r->row_before, 0), row_value(job, r, u, r->row_after, 0) - middle[0], weight);
    to[2] =
        vf_lerp(row_value(job, r, u, 0, 1) - row_value(job, r, u, 0, r->slice_before),
                row_value(job, r, u, 1, 1) - row_value(job, r, u, 1, r->slice_before), weight);
}

PEL_INLINE void turned_gradient(const struct pel_job *job, const struct slice_row *r, int u, vf to[3])
{
    vf weight = vf_set(r->weight), part = vf_set(r->i), along[2], across[2], through[2], v[2][2];
    for (int j = 0; j < 2; j++) {
        for (int x = 0; x < 2; x++)
            v[j][x] = turned(job, r, u, x, j, 0);
        along[j] = vf_lerp(v[j][1] - turned(job, r, u, -1, j, 0), turned(job, r, u, 2, j, 0) - v[j][0], part);
        through[j] = vf_lerp(turned(job, r, u, 0, j, 1) - turned(job, r, u, 0, j, r->slice_before),
                             turned(job, r, u, 1, j, 1) - turned(job, r, u, 1, j, r->slice_before), part);
    }
    for (int x = 0; x < 2; x++)
        across[x] = vf_lerp(v[1][x] - turned(job, r, u, x, r->row_before, 0), turned(job, r, u, x, r->row_after, 0) - v[0][x], weight);
    to[0] = vf_lerp(along[0], along[1], weight);
    to[1] = vf_lerp(across[0], across[1], part);
    to[2] = vf_lerp(through[0], through[1], weight);
}

/* As fetch_gradient. */
PEL_INLINE void near_gradient(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, int u, vf g[3])
{
    vf to[3];
    if (r->turned)
        turned_gradient(job, r, u, to);
    else
        straight_gradient(job, r, u, to);
    for (int a = 0; a < 3; a++)
        g[s->axis[a]] = to[a] * (0.5f * job->gradient_scale);
}

#endif

#endif
