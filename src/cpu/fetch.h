/* SPDX-License-Identifier: MIT */
/* Voxels into lanes: trilinear and nearest fetches, and the gradient, for the kind of voxel that PEL_KIND says (kernel.h tells what "raw"
 * values are).
 *
 * Bytes and words: the two voxels along x that a lerp needs are neighbours in memory, so one 32-bit gather brings both, and one
 * multiply-add of 16-bit pairs with the weights (2^14 - w, w) lerps them exactly for equal voxels. The gradient's stencil, the 4^3
 * neighbourhood without its edges, is 12 rows of x, of which the value has fetched four. */
#ifndef PEL_CPU_FETCH_H
#define PEL_CPU_FETCH_H

#include <float.h>

#include "kernel.h"
#include "simd.h"

/* A place between voxels: the corner of its cell and how far along each axis. */
struct spot {
    vi x, y, z;
    vf fx, fy, fz;
};

PEL_INLINE struct spot spot_at(const struct pel_job *job, vf px, vf py, vf pz)
{
    struct spot s;
    s.x = vi_min(vf_to_vi(px), vi_set(job->last_cell[0]));
    s.y = vi_min(vf_to_vi(py), vi_set(job->last_cell[1]));
    s.z = vi_min(vf_to_vi(pz), vi_set(job->last_cell[2]));
    s.fx = px - vi_to_vf(s.x);
    s.fy = py - vi_to_vf(s.y);
    s.fz = pz - vi_to_vf(s.z);
    return s;
}

PEL_INLINE vf bilerp(vf v00, vf v10, vf v01, vf v11, vf fy, vf fz)
{
    return vf_lerp(vf_lerp(v00, v10, fy), vf_lerp(v01, v11, fy), fz);
}

#if PEL_KIND == PEL_KIND_U8 || PEL_KIND == PEL_KIND_U16

PEL_INLINE vi x_weights(vf fx)
{
    vi w = vi_min(vf_to_vi(fx * 16384.0f + 0.5f), vi_set(16384)); /* a place on the last voxel may be rounded beyond it */
    return (w << 16) | (16384 - w);
}

#endif

/* The four rows of voxels along x around a cell: (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1). A value needs voxels x and x + 1 of them;
 * the gradient needs x - 1 and x + 2 too, and eight rows more. */
struct rows {
    vi y[4], z[4]; /* offsets of rows y - 1 .. y + 2 and of slices z - 1 .. z + 2, at the volume's ends the last one again; only 1 and 2
                      until the gradient is taken */
#if PEL_KIND == PEL_KIND_U8
    vi at;         /* where the words start along x */
    bool at_end;   /* some lane's word does not start at x - 1 */
    vi word[4];    /* voxels x - 1 .. x + 2 */
#elif PEL_KIND == PEL_KIND_U16
    vi word[4];    /* voxels x and x + 1 */
#else
    vf left[4], right[4]; /* voxels x and x + 1 */
#endif
};

#if PEL_KIND == PEL_KIND_U8

/* One voxel, raw before scaling by 2^14. */
PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    vi at = vi_min(x, vi_set(job->row - 4));
    vi word = vi_gather(job->data, at + y * job->row + z * job->slice) ^ job->flip;
    return vi_to_vf((word >> ((x - at) << 3)) & 0xff) * 16384.0f;
}

/* The word of voxels x - 1 .. x + 2 of a row; at the volume's ends the last voxel again. */
PEL_INLINE vi row_word(const struct pel_job *job, const struct spot *s, const struct rows *r, vi offset)
{
    vi word = vi_gather(job->data, r->at + offset);
    if (__builtin_expect(job->flip != 0, 0))
        word ^= job->flip;
    if (__builtin_expect(r->at_end, 0)) {
        vi shift = s->x - 1 - r->at;
        word = vi_select(shift < 0, (word << 8) | (word & 0xff), word);
        word = vi_select(shift > 0, ((word >> 8) & 0xffffff) | (word & (int32_t)0xff000000), word);
    }
    return word;
}

PEL_INLINE void fetch_row(const struct pel_job *job, const struct spot *s, struct rows *r, int i, vi offset)
{
    if (i == 0) {
        r->at = vi_max(vi_min(s->x - 1, vi_set(job->row - 4)), vi_set(0));
        r->at_end = vi_any(r->at != s->x - 1);
    }
    r->word[i] = row_word(job, s, r, offset);
}

/* Voxels x and x + 1 of a row, two 16-bit numbers a lane. */
PEL_INLINE vi pair_words(const struct rows *r, int i)
{
    return vi_byte_pair(r->word[i], 1);
}

/* A row's value at x. */
PEL_INLINE vf middle_lerp(const struct spot *s, const struct rows *r, int i)
{
    return vi_to_vf(vi_madd16(vi_byte_pair(r->word[i], 1), x_weights(s->fx)));
}

/* (v(x+1) - v(x-1)) and (v(x+2) - v(x)), lerped. */
PEL_INLINE vf slope_lerp(const struct pel_job *job, const struct spot *s, const struct rows *r, int i, vi offset)
{
    (void)job, (void)offset;
    vi w = x_weights(s->fx);
    return vi_to_vf(vi_madd16(vi_byte_pair(r->word[i], 2), w) - vi_madd16(vi_byte_pair(r->word[i], 0), w));
}

/* The value at x of a row farther out. */
PEL_INLINE vf outer_lerp(const struct pel_job *job, const struct spot *s, const struct rows *r, vi offset)
{
    return vi_to_vf(vi_madd16(vi_byte_pair(row_word(job, s, r, offset), 1), x_weights(s->fx)));
}

#elif PEL_KIND == PEL_KIND_U16

PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    vi at = vi_min(x, vi_set(job->row - 2));
    vi word = vi_gather2(job->data, at + y * job->row + z * job->slice) ^ job->flip;
    return vi_to_vf(vi_select(x == at, (word << 16) >> 16, word >> 16)) * 16384.0f;
}

PEL_INLINE void fetch_row(const struct pel_job *job, const struct spot *s, struct rows *r, int i, vi offset)
{
    r->word[i] = vi_gather2(job->data, s->x + offset) ^ job->flip;
}

PEL_INLINE vi pair_words(const struct rows *r, int i)
{
    return r->word[i];
}

PEL_INLINE vf middle_lerp(const struct spot *s, const struct rows *r, int i)
{
    return vi_to_vf(vi_madd16(r->word[i], x_weights(s->fx)));
}

PEL_INLINE vf slope_lerp(const struct pel_job *job, const struct spot *s, const struct rows *r, int i, vi offset)
{
    (void)r, (void)i;
    vi before = vi_max(s->x - 1, vi_set(0)), behind = vi_min(s->x + 1, vi_set(job->row - 2)), w = x_weights(s->fx);
    vi front = vi_gather2(job->data, before + offset) ^ job->flip, back = vi_gather2(job->data, behind + offset) ^ job->flip;
    front = vi_select(s->x < 1, (front << 16) | (front & 0xffff), front); /* at the volume's ends the last voxel again */
    back = vi_select(s->x >= job->row - 2, ((back >> 16) & 0xffff) | (back & (int32_t)0xffff0000), back);
    return vi_to_vf(vi_madd16(back, w)) - vi_to_vf(vi_madd16(front, w));
}

PEL_INLINE vf outer_lerp(const struct pel_job *job, const struct spot *s, const struct rows *r, vi offset)
{
    (void)r;
    return vi_to_vf(vi_madd16(vi_gather2(job->data, s->x + offset) ^ job->flip, x_weights(s->fx)));
}

#else

#if PEL_KIND == PEL_KIND_F32

PEL_INLINE vf voxel_at(const struct pel_job *job, vi at)
{
    return vf_gather(job->data, at);
}

#else

/* A call each, not inlined: its loads dwarf the call, and the kernels would be several times as long. */
__attribute__((noinline)) static vf voxel_at(const struct pel_job *job, vi at)
{
    float raw[W];
    for (int i = 0; i < W; i++) {
        double v = job->type == PEL_F64   ? ((const double *)job->data)[at[i]]
                   : job->type == PEL_U32 ? (double)((const uint32_t *)job->data)[at[i]]
                                          : (double)((const int32_t *)job->data)[at[i]];
        raw[i] = job->wide_void && v == job->void_value ? NAN : (float)((v - job->wide_offset) * job->wide_scale);
    }
    vf result;
    memcpy(&result, raw, sizeof result);
    return result;
}

#endif

PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    return voxel_at(job, x + y * job->row + z * job->slice);
}

PEL_INLINE void fetch_row(const struct pel_job *job, const struct spot *s, struct rows *r, int i, vi offset)
{
    r->left[i] = voxel_at(job, s->x + offset);
    r->right[i] = voxel_at(job, s->x + offset + 1);
}

PEL_INLINE vf middle_lerp(const struct spot *s, const struct rows *r, int i)
{
    return vf_lerp(r->left[i], r->right[i], s->fx);
}

PEL_INLINE vf slope_lerp(const struct pel_job *job, const struct spot *s, const struct rows *r, int i, vi offset)
{
    vf before = voxel_at(job, vi_max(s->x - 1, vi_set(0)) + offset),
       behind = voxel_at(job, vi_min(s->x + 2, vi_set(job->dims[0] - 1)) + offset);
    return vf_lerp(r->right[i] - before, behind - r->left[i], s->fx);
}

PEL_INLINE vf outer_lerp(const struct pel_job *job, const struct spot *s, const struct rows *r, vi offset)
{
    (void)r;
    return vf_lerp(voxel_at(job, s->x + offset), voxel_at(job, s->x + offset + 1), s->fx);
}

#endif

/* Voxels x and x + 1 of a row. */
PEL_INLINE void pair_floats(const struct rows *r, int i, vf pair[2])
{
#if PEL_KIND == PEL_KIND_U8 || PEL_KIND == PEL_KIND_U16
    vi words = pair_words(r, i);
    pair[0] = vi_to_vf((words << 16) >> 16) * 16384.0f;
    pair[1] = vi_to_vf(words >> 16) * 16384.0f;
#else
    pair[0] = r->left[i];
    pair[1] = r->right[i];
#endif
}

PEL_INLINE void fetch_rows(const struct pel_job *job, const struct spot *s, struct rows *r)
{
    r->y[1] = s->y * job->row, r->y[2] = r->y[1] + job->row;
    r->z[1] = s->z * job->slice, r->z[2] = r->z[1] + job->slice;
    for (int i = 0; i < 4; i++)
        fetch_row(job, s, r, i, r->y[1 + (i & 1)] + r->z[1 + (i >> 1)]);
}

/* The trilinear value. */
PEL_INLINE vf rows_value(const struct spot *s, const struct rows *r)
{
    return bilerp(middle_lerp(s, r, 0), middle_lerp(s, r, 1), middle_lerp(s, r, 2), middle_lerp(s, r, 3), s->fy, s->fz);
}

/* The eight voxels of the cell, x fastest. */
PEL_INLINE void rows_corners(const struct rows *r, vf corner[8])
{
    for (int i = 0; i < 4; i++)
        pair_floats(r, i, corner + 2 * i);
}

/* The least and the greatest of them. */
PEL_INLINE void rows_range(const struct rows *r, vf *least, vf *most)
{
#if PEL_KIND == PEL_KIND_U8 || PEL_KIND == PEL_KIND_U16
    vi low = pair_words(r, 0), high = low; /* two voxels a lane */
    for (int i = 1; i < 4; i++) {
        low = vi_min16(low, pair_words(r, i));
        high = vi_max16(high, pair_words(r, i));
    }
    *least = vi_to_vf(vi_min((low << 16) >> 16, low >> 16)) * 16384.0f;
    *most = vi_to_vf(vi_max((high << 16) >> 16, high >> 16)) * 16384.0f;
#else
    *least = vf_min(r->left[0], r->right[0]);
    *most = vf_max(r->left[0], r->right[0]);
    for (int i = 1; i < 4; i++) {
        *least = vf_min(*least, vf_min(r->left[i], r->right[i]));
        *most = vf_max(*most, vf_max(r->left[i], r->right[i]));
    }
#endif
}

/* Central differences at the cell's corners, interpolated: twice the gradient. */
PEL_INLINE void rows_gradient(const struct pel_job *job, const struct spot *s, struct rows *r, vf g[3])
{
    vf fy = s->fy, fz = s->fz, x[4], c[4];
    r->y[0] = vi_max(s->y - 1, vi_set(0)) * job->row;
    r->y[3] = vi_min(s->y + 2, vi_set(job->dims[1] - 1)) * job->row;
    r->z[0] = vi_max(s->z - 1, vi_set(0)) * job->slice;
    r->z[3] = vi_min(s->z + 2, vi_set(job->dims[2] - 1)) * job->slice;
    for (int i = 0; i < 4; i++) {
        x[i] = slope_lerp(job, s, r, i, r->y[1 + (i & 1)] + r->z[1 + (i >> 1)]);
        c[i] = middle_lerp(s, r, i);
    }
    g[0] = bilerp(x[0], x[1], x[2], x[3], fy, fz);
#define OUTER(j, k) outer_lerp(job, s, r, r->y[j] + r->z[k])
    g[1] = vf_lerp(vf_lerp(c[1] - OUTER(0, 1), OUTER(3, 1) - c[0], fy), vf_lerp(c[3] - OUTER(0, 2), OUTER(3, 2) - c[2], fy), fz);
    g[2] = vf_lerp(vf_lerp(c[2] - OUTER(1, 0), OUTER(1, 3) - c[0], fz), vf_lerp(c[3] - OUTER(2, 0), OUTER(2, 3) - c[1], fz), fy);
#undef OUTER
}

/* The eight voxels of a cell, x fastest. */
PEL_INLINE void fetch_corners(const struct pel_job *job, const struct spot *s, vf corner[8])
{
    for (int i = 0; i < 8; i++)
        corner[i] = fetch_voxel(job, s->x + (i & 1), s->y + ((i >> 1) & 1), s->z + (i >> 2));
}

PEL_INLINE vf voids_to_nan(const struct pel_job *job, vf voxel)
{
    return vf_select(voxel == job->void_raw, vf_set(NAN), voxel);
}

/* Trilinear value, and the rows that it was made of; NaN where it reads a void. A NaN or infinite voxel leaves no finite value by itself.
 */
PEL_INLINE vf fetch_value(const struct pel_job *job, const struct spot *s, struct rows *rows)
{
    fetch_rows(job, s, rows);
    vf raw = rows_value(s, rows);
    if (__builtin_expect(job->voids, 0))
        raw = vf_select(vf_abs(raw) <= FLT_MAX, raw, vf_set(NAN));
    if (__builtin_expect(job->has_void_value, 0)) {
        vf corner[8];
        fetch_corners(job, s, corner);
        for (int i = 0; i < 8; i++)
            raw = vf_select(corner[i] == job->void_raw, vf_set(NAN), raw);
    }
    return raw;
}

PEL_INLINE vf fetch_linear(const struct pel_job *job, const struct spot *s)
{
    struct rows rows;
    return fetch_value(job, s, &rows);
}

/* Nearest voxel of a position; NaN where it is void. */
PEL_INLINE vf fetch_nearest(const struct pel_job *job, vi x, vi y, vi z)
{
    vf raw = fetch_voxel(job, x, y, z);
    if (job->voids)
        raw = vf_select(vf_abs(raw) <= FLT_MAX, raw, vf_set(NAN));
    return job->has_void_value ? voids_to_nan(job, raw) : raw;
}

/* Gradient in parts of the volume's range a voxel, so that its square neither vanishes nor overflows; NaN near voids. The rows are those of
 * the value there. */
PEL_INLINE void fetch_gradient(const struct pel_job *job, const struct spot *s, struct rows *rows, vf g[3])
{
    rows_gradient(job, s, rows, g);
    for (int a = 0; a < 3; a++)
        g[a] *= 0.5f * job->gradient_scale;
    if (__builtin_expect(job->has_void_value, 0)) {
        vi bad = vi_set(0);
        for (int a = 0; a < 6; a++)
            for (int i = 0; i < 8; i++) {
                int side = a & 1 ? 1 : -1, axis = a >> 1;
                vi x = s->x + (i & 1) + (axis == 0 ? side : 0), y = s->y + ((i >> 1) & 1) + (axis == 1 ? side : 0),
                   z = s->z + (i >> 2) + (axis == 2 ? side : 0);
                vi zero = vi_set(0);
                bad |=
                    fetch_voxel(job, vi_max(vi_min(x, vi_set(job->dims[0] - 1)), zero), vi_max(vi_min(y, vi_set(job->dims[1] - 1)), zero),
                                vi_max(vi_min(z, vi_set(job->dims[2] - 1)), zero)) == job->void_raw;
            }
        for (int a = 0; a < 3; a++)
            g[a] = vf_select(bad, vf_set(NAN), g[a]);
    }
}

#endif
