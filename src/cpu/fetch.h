/* SPDX-License-Identifier: MIT */
/* Voxels into lanes: trilinear and nearest fetches, and the gradient, for the kind of voxel that PEL_KIND says (kernel.h tells what "raw" values are).
 *
 * Bytes and words: the two voxels along x that a lerp needs are neighbours in memory, so one 32-bit gather brings both, and one multiply-add of 16-bit pairs with the
 * weights (2^14 - w, w) lerps them exactly for equal voxels. The gradient's stencil, the 4^3 neighbourhood without its edges, is 12 rows of x. */
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
    vi w = vf_to_vi(fx * 16384.0f + 0.5f);
    return (w << 16) | (16384 - w);
}

#endif

#if PEL_KIND == PEL_KIND_U8

/* One voxel, raw before scaling by 2^14. */
PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    vi at = vi_min(x, vi_set(job->row - 4));
    vi word = vi_gather(job->data, at + y * job->row + z * job->slice) ^ job->flip;
    return vi_to_vf((word >> ((x - at) << 3)) & 0xff) * 16384.0f;
}

/* Four rows' words, the pair to lerp in their first two bytes, lerped along all axes. */
PEL_INLINE vf lerp_words(const vi word[4], vi w, vf fy, vf fz)
{
    vf row[4];
    for (int i = 0; i < 4; i++)
        row[i] = vi_to_vf(vi_madd16(vi_byte_pair(word[i], 0), w));
    return bilerp(row[0], row[1], row[2], row[3], fy, fz);
}

PEL_INLINE vf fetch_linear_raw(const struct pel_job *job, const struct spot *s)
{
    vi limit = vi_set(job->row - 4), rows = s->y * job->row + s->z * job->slice, word[4];
    const char *base = job->data;
    bool at_end = vi_any(s->x > limit), flips = job->flip != 0; /* hardly ever, and for i8 only */
    vi at = at_end ? vi_min(s->x, limit) : s->x;
    for (int i = 0; i < 4; i++)
        word[i] = vi_gather(base + (ptrdiff_t)job->row * (i & 1) + (ptrdiff_t)job->slice * (i >> 1), at + rows);
    if (__builtin_expect(at_end | flips, 0))
        for (int i = 0; i < 4; i++)
            word[i] = (word[i] ^ job->flip) >> ((s->x - at) << 3);
    return lerp_words(word, x_weights(s->fx), s->fy, s->fz);
}

/* Four voxels x-1 .. x+2 of a row in the bytes of a word; at the volume's ends the last voxel again. */
PEL_INLINE vi row_word(const struct pel_job *job, vi at, vi rows, vi before, vi behind, bool at_end)
{
    vi word = vi_gather(job->data, at + rows) ^ job->flip;
    if (at_end) {
        word = vi_select(before, (word << 8) | (word & 0xff), word);
        word = vi_select(behind, ((word >> 8) & 0xffffff) | (word & (int32_t)0xff000000), word);
    }
    return word;
}

PEL_INLINE vf middle_lerp(vi word, vi w)
{
    return vi_to_vf(vi_madd16(vi_byte_pair(word, 1), w));
}

/* (v(x+1) - v(x-1)) and (v(x+2) - v(x)), lerped. */
PEL_INLINE vf slope_lerp(vi word, vi w)
{
    return vi_to_vf(vi_madd16(vi_byte_pair(word, 2), w) - vi_madd16(vi_byte_pair(word, 0), w));
}

PEL_INLINE void fetch_gradient_raw(const struct pel_job *job, const struct spot *s, vf g[3])
{
    vi w = x_weights(s->fx);
    vi at = vi_max(vi_min(s->x - 1, vi_set(job->row - 4)), vi_set(0)), delta = s->x - 1 - at;
    vi before = delta < 0, behind = delta > 0;
    bool at_end = vi_any(delta != 0);
    vi y0 = vi_max(s->y - 1, vi_set(0)) * job->row, y1 = s->y * job->row, y2 = y1 + job->row;
    vi y3 = vi_min(s->y + 2, vi_set(job->dims[1] - 1)) * job->row;
    vi z0 = vi_max(s->z - 1, vi_set(0)) * job->slice, z1 = s->z * job->slice, z2 = z1 + job->slice;
    vi z3 = vi_min(s->z + 2, vi_set(job->dims[2] - 1)) * job->slice;
#define ROW(y, z) row_word(job, at, y + z, before, behind, at_end)
    vi w11 = ROW(y1, z1), w21 = ROW(y2, z1), w12 = ROW(y1, z2), w22 = ROW(y2, z2);
    g[0] = bilerp(slope_lerp(w11, w), slope_lerp(w21, w), slope_lerp(w12, w), slope_lerp(w22, w), s->fy, s->fz) * 0.5f;
    vf c11 = middle_lerp(w11, w), c21 = middle_lerp(w21, w), c12 = middle_lerp(w12, w), c22 = middle_lerp(w22, w);
#define EDGE(y, z) middle_lerp(ROW(y, z), w)
    vf fy = s->fy, fz = s->fz;
    g[1] = vf_lerp(vf_lerp(c21 - EDGE(y0, z1), EDGE(y3, z1) - c11, fy), vf_lerp(c22 - EDGE(y0, z2), EDGE(y3, z2) - c12, fy), fz) * 0.5f;
    g[2] = vf_lerp(vf_lerp(c12 - EDGE(y1, z0), EDGE(y1, z3) - c11, fz), vf_lerp(c22 - EDGE(y2, z0), EDGE(y2, z3) - c21, fz), fy) * 0.5f;
#undef EDGE
#undef ROW
}

#else /* words, floats and wide numbers: a gather an x-pair or a voxel */

#if PEL_KIND == PEL_KIND_U16

PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    vi at = vi_min(x, vi_set(job->row - 2));
    vi word = vi_gather2(job->data, at + y * job->row + z * job->slice) ^ job->flip;
    return vi_to_vf(vi_select(x == at, (word << 16) >> 16, word >> 16)) * 16384.0f;
}

PEL_INLINE vf row_lerp(const struct pel_job *job, const struct spot *s, vi rows)
{
    return vi_to_vf(vi_madd16(vi_gather2(job->data, s->x + rows) ^ job->flip, x_weights(s->fx)));
}

#elif PEL_KIND == PEL_KIND_F32

PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    return vf_gather(job->data, x + y * job->row + z * job->slice);
}

PEL_INLINE vf row_lerp(const struct pel_job *job, const struct spot *s, vi rows)
{
    vi at = s->x + rows;
    return vf_lerp(vf_gather(job->data, at), vf_gather((const float *)job->data + 1, at), s->fx);
}

#else

/* A call each, not inlined: its loads dwarf the call, and the kernels would be several times as long. */
__attribute__((noinline)) static vf wide_at(const struct pel_job *job, vi at)
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

PEL_INLINE vf fetch_voxel(const struct pel_job *job, vi x, vi y, vi z)
{
    return wide_at(job, x + y * job->row + z * job->slice);
}

PEL_INLINE vf row_lerp(const struct pel_job *job, const struct spot *s, vi rows)
{
    vi at = s->x + rows;
    return vf_lerp(wide_at(job, at), wide_at(job, at + 1), s->fx);
}

#endif

PEL_INLINE vf fetch_linear_raw(const struct pel_job *job, const struct spot *s)
{
    vi o = s->y * job->row + s->z * job->slice;
    return bilerp(row_lerp(job, s, o), row_lerp(job, s, o + job->row), row_lerp(job, s, o + job->slice), row_lerp(job, s, o + job->row + job->slice),
                  s->fy, s->fz);
}

/* (v(x+1) - v(x-1)) and (v(x+2) - v(x)), lerped. */
PEL_INLINE vf row_slope(const struct pel_job *job, const struct spot *s, vi y, vi z)
{
    vi x0 = vi_max(s->x - 1, vi_set(0)), x3 = vi_min(s->x + 2, vi_set(job->dims[0] - 1));
    return vf_lerp(fetch_voxel(job, s->x + 1, y, z) - fetch_voxel(job, x0, y, z), fetch_voxel(job, x3, y, z) - fetch_voxel(job, s->x, y, z), s->fx);
}

PEL_INLINE void fetch_gradient_raw(const struct pel_job *job, const struct spot *s, vf g[3])
{
    vf fy = s->fy, fz = s->fz;
    vi y0 = vi_max(s->y - 1, vi_set(0)) * job->row, y1 = s->y * job->row, y2 = y1 + job->row;
    vi y3 = vi_min(s->y + 2, vi_set(job->dims[1] - 1)) * job->row;
    vi z0 = vi_max(s->z - 1, vi_set(0)) * job->slice, z1 = s->z * job->slice, z2 = z1 + job->slice;
    vi z3 = vi_min(s->z + 2, vi_set(job->dims[2] - 1)) * job->slice;
    g[0] = bilerp(row_slope(job, s, s->y, s->z), row_slope(job, s, s->y + 1, s->z), row_slope(job, s, s->y, s->z + 1),
                  row_slope(job, s, s->y + 1, s->z + 1), fy, fz) * 0.5f;
#define ROW(y, z) row_lerp(job, s, y + z)
    vf c11 = ROW(y1, z1), c21 = ROW(y2, z1), c12 = ROW(y1, z2), c22 = ROW(y2, z2);
    g[1] = vf_lerp(vf_lerp(c21 - ROW(y0, z1), ROW(y3, z1) - c11, fy), vf_lerp(c22 - ROW(y0, z2), ROW(y3, z2) - c12, fy), fz) * 0.5f;
    g[2] = vf_lerp(vf_lerp(c12 - ROW(y1, z0), ROW(y1, z3) - c11, fz), vf_lerp(c22 - ROW(y2, z0), ROW(y2, z3) - c21, fz), fy) * 0.5f;
#undef ROW
}

#endif

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

/* Trilinear value; NaN where it reads a void. A NaN or infinite voxel leaves no finite value by itself. */
PEL_INLINE vf fetch_linear(const struct pel_job *job, const struct spot *s)
{
    vf raw = fetch_linear_raw(job, s);
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

/* Nearest voxel of a position; NaN where it is void. */
PEL_INLINE vf fetch_nearest(const struct pel_job *job, vi x, vi y, vi z)
{
    vf raw = fetch_voxel(job, x, y, z);
    if (job->voids)
        raw = vf_select(vf_abs(raw) <= FLT_MAX, raw, vf_set(NAN));
    return job->has_void_value ? voids_to_nan(job, raw) : raw;
}

/* Gradient in parts of the volume's range a voxel, so that its square neither vanishes nor overflows; NaN near voids. */
PEL_INLINE void fetch_gradient(const struct pel_job *job, const struct spot *s, vf g[3])
{
    fetch_gradient_raw(job, s, g);
    for (int a = 0; a < 3; a++)
        g[a] *= job->gradient_scale;
    if (__builtin_expect(job->has_void_value, 0)) {
        vi bad = vi_set(0);
        for (int a = 0; a < 6; a++)
            for (int i = 0; i < 8; i++) {
                int side = a & 1 ? 1 : -1, axis = a >> 1;
                vi x = s->x + (i & 1) + (axis == 0 ? side : 0), y = s->y + ((i >> 1) & 1) + (axis == 1 ? side : 0),
                   z = s->z + (i >> 2) + (axis == 2 ? side : 0);
                vi zero = vi_set(0);
                bad |= fetch_voxel(job, vi_max(vi_min(x, vi_set(job->dims[0] - 1)), zero), vi_max(vi_min(y, vi_set(job->dims[1] - 1)), zero),
                                   vi_max(vi_min(z, vi_set(job->dims[2] - 1)), zero)) == job->void_raw;
            }
        for (int a = 0; a < 3; a++)
            g[a] = vf_select(bad, vf_set(NAN), g[a]);
    }
}

#endif
