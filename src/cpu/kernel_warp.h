/* SPDX-License-Identifier: MIT */
/* The warp: a row of the picture from the intermediate image, bilinear (warp.h). Where in the row anything can be is solved for first, so
 * that no pixel asks whether it is inside; then the lanes say where pixels lie, and each pixel is two loads of eight floats. */
#ifndef PEL_CPU_KERNEL_WARP_H
#define PEL_CPU_KERNEL_WARP_H

#include "simd.h"
#include "warp.h"

typedef float v4 __attribute__((vector_size(16)));
typedef float v8 __attribute__((vector_size(32)));

/* Narrows [*from, *to] to where value + x slope >= 0. */
PEL_INLINE void keep_where(double value, double slope, double *from, double *to)
{
    if (slope > 0)
        *from = -value / slope > *from ? -value / slope : *from;
    else if (slope < 0)
        *to = -value / slope < *to ? -value / slope : *to;
    else if (value < 0)
        *to = -1;
}

/* The row's pixels whose four rays are in the image and hold something. */
PEL_INLINE void warp_stretch(const struct pel_job *job, const struct pel_warp *p, const double at[3], int *first, int *end)
{
    double from = 0, to = job->width - 1;
    const double by[3] = { p->u[1], p->v[1], p->w[1] };
    keep_where(at[2] - 1e-12, by[2], &from, &to);
    for (int a = 0; a < 2; a++) { /* lo w < u < hi w */
        keep_where(at[a] - p->lo[a] * at[2], by[a] - p->lo[a] * by[2], &from, &to);
        keep_where(p->hi[a] * at[2] - at[a], p->hi[a] * by[2] - by[a], &from, &to);
    }
    *first = to >= from ? (int)(from + (1 - 1e-9)) : 0;
    *end = to >= from ? (int)to + 1 : 0;
}

/* Where W pixels from x on lie: offset of the upper left ray, and how far they are from it. */
PEL_INLINE void warp_places(const struct pel_shear *s, const struct pel_warp *p, const double at[3], int x, int32_t offset[W], float fu[W],
                            float fv[W])
{
    typedef int32_t half_int __attribute__((vector_size(HALF * 4)));
    typedef float half_float __attribute__((vector_size(HALF * 4)));
    for (int h = 0; h < 2; h++) {
        vd pixel;
        for (int l = 0; l < HALF; l++)
            pixel[l] = x + h * HALF + l;
        vd u = at[0] + pixel * p->u[1], v = at[1] + pixel * p->v[1];
        if (s->perspective) {
            vd inverse = 1 / (at[2] + pixel * p->w[1]);
            u *= inverse;
            v *= inverse;
        }
        u = vd_min(vd_max(u, vd_set(0)), vd_set(s->width + 0.999999)); /* lanes beyond the stretch, and rounding at its ends */
        v = vd_min(vd_max(v, vd_set(0)), vd_set(s->height + 0.999999));
        half_int iu = __builtin_convertvector(u, half_int), iv = __builtin_convertvector(v, half_int);
        half_float du = __builtin_convertvector(u - __builtin_convertvector(iu, vd), half_float);
        half_float dv = __builtin_convertvector(v - __builtin_convertvector(iv, vd), half_float);
        half_int o = iv * s->stride + iu;
        memcpy(offset + h * HALF, &o, sizeof o);
        memcpy(fu + h * HALF, &du, sizeof du);
        memcpy(fv + h * HALF, &dv, sizeof dv);
    }
}

PEL_INLINE v4 warp_color(const struct pel_shear *s, int32_t offset, float fu, float fv)
{
    v8 upper, lower;
    const float *at = s->rgba + (size_t)offset * 4;
    memcpy(&upper, at, sizeof upper);
    memcpy(&lower, at + (size_t)s->stride * 4, sizeof lower);
    v8 mixed = upper + fv * (lower - upper);
    v4 left = { mixed[0], mixed[1], mixed[2], mixed[3] }, right = { mixed[4], mixed[5], mixed[6], mixed[7] };
    return left + fu * (right - left);
}

#if PEL_AVX512

/* Two pixels' pairs of rays in one vector. */
PEL_INLINE __m512 warp_two(const float *first, const float *second)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(first)), _mm256_loadu_ps(second), 1);
}

/* Four pixels at once, to the bits that warp_color gives. */
PEL_INLINE void warp_four(const struct pel_shear *s, const int32_t offset[4], const float fu[4], const float fv[4], float *to)
{
    const __m512i spread = _mm512_set_epi32(1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0);
    const __m512 down = _mm512_castps128_ps512(_mm_loadu_ps(fv)), along = _mm512_castps128_ps512(_mm_loadu_ps(fu));
    const size_t below = (size_t)s->stride * 4;
    __m512 mixed[2];
    for (int i = 0; i < 2; i++) {
        const float *a = s->rgba + (size_t)offset[2 * i] * 4, *b = s->rgba + (size_t)offset[2 * i + 1] * 4;
        const __m512 upper = warp_two(a, b), lower = warp_two(a + below, b + below);
        const __m512 weight = _mm512_permutexvar_ps(_mm512_add_epi32(spread, _mm512_set1_epi32(2 * i)), down);
        mixed[i] = _mm512_add_ps(upper, _mm512_mul_ps(weight, _mm512_sub_ps(lower, upper)));
    }
    const __m512 left = _mm512_shuffle_f32x4(mixed[0], mixed[1], 0x88), right = _mm512_shuffle_f32x4(mixed[0], mixed[1], 0xdd);
    const __m512 part = _mm512_permutexvar_ps(_mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0), along);
    _mm512_storeu_ps(to, _mm512_add_ps(left, _mm512_mul_ps(part, _mm512_sub_ps(right, left))));
}

#endif

static void warp_row(const struct pel_job *job, const struct pel_shear *s, const struct pel_warp *p, int y)
{
    float *to = job->rgba + (size_t)y * (size_t)job->width * 4;
    const double at[3] = { p->u[0] + p->u[2] * y, p->v[0] + p->v[2] * y, p->w[0] + p->w[2] * y };
    int first, end;
    warp_stretch(job, p, at, &first, &end);
    if (!p->split) {
        memset(to, 0, (size_t)first * 4 * sizeof *to);
        memset(to + (size_t)end * 4, 0, (size_t)(job->width - end) * 4 * sizeof *to);
    }
    for (int x = first; x < end; x += W) {
        int32_t offset[W];
        float fu[W], fv[W];
        const int count = end - x < W ? end - x : W;
        warp_places(s, p, at, x, offset, fu, fv);
        int l = 0;
#if PEL_AVX512
        for (; !p->split && !job->depth && l + 4 <= count; l += 4)
            warp_four(s, offset + l, fu + l, fv + l, to + 4 * (x + l));
#endif
        for (; l < count; l++) {
            if (p->split && !pel_warp_belongs(job, p, x + l, y))
                continue;
            v4 color = warp_color(s, offset[l], fu[l], fv[l]);
            memcpy(to + 4 * (x + l), &color, sizeof color);
            if (job->depth && color[3] >= 0.5f)
                job->depth[(size_t)y * (size_t)job->width + (size_t)(x + l)] = pel_warp_depth(job, s, offset[l], fu[l], fv[l], x + l, y);
        }
    }
}

#endif
