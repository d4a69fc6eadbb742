/* SPDX-License-Identifier: MIT */
/* Lanes: W floats or 32-bit integers side by side, W chosen by the instruction set that this file is compiled for.
 *
 * Arithmetic, comparison and bit operations are GCC's vector extensions (a comparison gives 0 or -1 in each lane). What they cannot say -
 * selecting, gathering, reducing, the multiply-add of 16-bit pairs - has one function each here, with an intrinsic where the machine has
 * the instruction and a loop that any compiler turns into something sound where it has not. */
#ifndef PEL_CPU_SIMD_H
#define PEL_CPU_SIMD_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#if defined(__AVX512BW__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
#define PEL_AVX512 1
#define W 16
#elif defined(__AVX2__) && defined(__FMA__)
#define PEL_AVX2 1
#define W 8
#else
#define W 4
#endif

typedef float vf __attribute__((vector_size(W * 4)));
typedef int32_t vi __attribute__((vector_size(W * 4)));
/* Doubles fill a register with half as many lanes: code that needs them goes over a packet in two halves. */
#define HALF (W / 2)
typedef double vd __attribute__((vector_size(HALF * 8)));
typedef int64_t vl __attribute__((vector_size(HALF * 8)));

#define PEL_INLINE static inline __attribute__((always_inline, unused))

PEL_INLINE vf vf_set(float x)
{
    return x - (vf){ 0 };
}

PEL_INLINE vi vi_set(int32_t x)
{
    return x - (vi){ 0 };
}

PEL_INLINE vd vd_set(double x)
{
    return x - (vd){ 0 };
}

PEL_INLINE vf vi_to_vf(vi x)
{
    return __builtin_convertvector(x, vf);
}

PEL_INLINE vd vd_select(vl mask, vd a, vd b)
{
#if PEL_AVX512
    return (vd)_mm512_mask_blend_pd(_mm512_movepi64_mask((__m512i)mask), (__m512d)b, (__m512d)a);
#elif PEL_AVX2
    return (vd)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)mask);
#else
    return (vd)((mask & (vl)a) | (~mask & (vl)b));
#endif
}

PEL_INLINE vd vd_min(vd a, vd b)
{
#if PEL_AVX512
    return (vd)_mm512_min_pd((__m512d)a, (__m512d)b);
#elif PEL_AVX2
    return (vd)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    return vd_select(a < b, a, b);
#endif
}

PEL_INLINE vd vd_max(vd a, vd b)
{
#if PEL_AVX512
    return (vd)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif PEL_AVX2
    return (vd)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    return vd_select(a > b, a, b);
#endif
}

PEL_INLINE vd vd_sqrt(vd a)
{
#if PEL_AVX512
    return (vd)_mm512_sqrt_pd((__m512d)a);
#elif PEL_AVX2
    return (vd)_mm256_sqrt_pd((__m256d)a);
#else
    for (int i = 0; i < HALF; i++)
        a[i] = __builtin_sqrt(a[i]);
    return a;
#endif
}

/* Towards zero, as C does. */
PEL_INLINE vi vf_to_vi(vf x)
{
#if PEL_AVX512
    return (vi)_mm512_cvttps_epi32((__m512)x);
#elif PEL_AVX2
    return (vi)_mm256_cvttps_epi32((__m256)x);
#elif defined(__SSE2__)
    return (vi)_mm_cvttps_epi32((__m128)x);
#else
    return __builtin_convertvector(x, vi);
#endif
}

/* mask ? a : b, lane by lane; a mask's lanes are 0 or -1. */
PEL_INLINE vf vf_select(vi mask, vf a, vf b)
{
#if PEL_AVX512
    return (vf)_mm512_mask_blend_ps(_mm512_movepi32_mask((__m512i)mask), (__m512)b, (__m512)a);
#elif PEL_AVX2
    return (vf)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)mask);
#else
    return (vf)((mask & (vi)a) | (~mask & (vi)b));
#endif
}

PEL_INLINE vi vi_select(vi mask, vi a, vi b)
{
    return (vi)vf_select(mask, (vf)a, (vf)b);
}

/* b where a is NaN. */
PEL_INLINE vf vf_min(vf a, vf b)
{
#if PEL_AVX512
    return (vf)_mm512_min_ps((__m512)a, (__m512)b);
#elif PEL_AVX2
    return (vf)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined(__SSE2__)
    return (vf)_mm_min_ps((__m128)a, (__m128)b);
#else
    return vf_select(a < b, a, b);
#endif
}

PEL_INLINE vf vf_max(vf a, vf b)
{
#if PEL_AVX512
    return (vf)_mm512_max_ps((__m512)a, (__m512)b);
#elif PEL_AVX2
    return (vf)_mm256_max_ps((__m256)a, (__m256)b);
#elif defined(__SSE2__)
    return (vf)_mm_max_ps((__m128)a, (__m128)b);
#else
    return vf_select(a > b, a, b);
#endif
}

PEL_INLINE vi vi_min(vi a, vi b)
{
#if PEL_AVX512
    return (vi)_mm512_min_epi32((__m512i)a, (__m512i)b);
#elif PEL_AVX2
    return (vi)_mm256_min_epi32((__m256i)a, (__m256i)b);
#else
    return vi_select(a < b, a, b);
#endif
}

PEL_INLINE vi vi_max(vi a, vi b)
{
#if PEL_AVX512
    return (vi)_mm512_max_epi32((__m512i)a, (__m512i)b);
#elif PEL_AVX2
    return (vi)_mm256_max_epi32((__m256i)a, (__m256i)b);
#else
    return vi_select(a > b, a, b);
#endif
}

PEL_INLINE vf vf_abs(vf a)
{
    return (vf)((vi)a & 0x7fffffff);
}

/* One bit a lane. */
PEL_INLINE unsigned vi_bits(vi mask)
{
#if PEL_AVX512
    return _mm512_movepi32_mask((__m512i)mask);
#elif PEL_AVX2
    return (unsigned)_mm256_movemask_ps((__m256)mask);
#elif defined(__SSE2__)
    return (unsigned)_mm_movemask_ps((__m128)mask);
#else
    unsigned bits = 0;
    for (int i = 0; i < W; i++)
        bits |= (unsigned)(mask[i] != 0) << i;
    return bits;
#endif
}

PEL_INLINE bool vi_any(vi mask)
{
    return vi_bits(mask) != 0;
}

/* 0, 1, 2 ... */
PEL_INLINE vi vi_lane(void)
{
    vi lane;
    for (int i = 0; i < W; i++)
        lane[i] = i;
    return lane;
}

PEL_INLINE int32_t vi_least(vi a)
{
#if PEL_AVX512
    return _mm512_reduce_min_epi32((__m512i)a);
#else
    int32_t least = a[0];
    for (int i = 1; i < W; i++)
        least = a[i] < least ? a[i] : least;
    return least;
#endif
}

PEL_INLINE int32_t vi_most(vi a)
{
    return -vi_least(-a);
}

/* base[byte offset], 32 bits a lane, any alignment. */
PEL_INLINE vi vi_gather(const void *base, vi bytes)
{
#if PEL_AVX512
    return (vi)_mm512_i32gather_epi32((__m512i)bytes, base, 1);
#elif PEL_AVX2
    return (vi)_mm256_i32gather_epi32((const int *)base, (__m256i)bytes, 1);
#else
    vi r;
    for (int i = 0; i < W; i++) {
        int32_t word;
        memcpy(&word, (const char *)base + bytes[i], 4);
        r[i] = word;
    }
    return r;
#endif
}

/* 32-bit items that start at every 2 bytes. */
PEL_INLINE vi vi_gather2(const void *base, vi index)
{
#if PEL_AVX512
    return (vi)_mm512_i32gather_epi32((__m512i)index, base, 2);
#elif PEL_AVX2
    return (vi)_mm256_i32gather_epi32((const int *)base, (__m256i)index, 2);
#else
    vi r;
    for (int i = 0; i < W; i++) {
        int32_t word;
        memcpy(&word, (const char *)base + (ptrdiff_t)index[i] * 2, 4);
        r[i] = word;
    }
    return r;
#endif
}

PEL_INLINE vf vf_gather(const float *base, vi index)
{
#if PEL_AVX512
    return (vf)_mm512_i32gather_ps((__m512i)index, base, 4);
#elif PEL_AVX2
    return (vf)_mm256_i32gather_ps(base, (__m256i)index, 4);
#else
    vf r;
    for (int i = 0; i < W; i++)
        r[i] = base[index[i]];
    return r;
#endif
}

/* Each lane as two signed 16-bit numbers: a.low * b.low + a.high * b.high. */
PEL_INLINE vi vi_madd16(vi a, vi b)
{
#if PEL_AVX512
    return (vi)_mm512_madd_epi16((__m512i)a, (__m512i)b);
#elif PEL_AVX2
    return (vi)_mm256_madd_epi16((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
    return (vi)_mm_madd_epi16((__m128i)a, (__m128i)b);
#else
    return ((a << 16) >> 16) * ((b << 16) >> 16) + (a >> 16) * (b >> 16);
#endif
}

/* Each lane as two signed 16-bit numbers: the lesser, the greater of each. */
PEL_INLINE vi vi_min16(vi a, vi b)
{
#if PEL_AVX512
    return (vi)_mm512_min_epi16((__m512i)a, (__m512i)b);
#elif PEL_AVX2
    return (vi)_mm256_min_epi16((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
    return (vi)_mm_min_epi16((__m128i)a, (__m128i)b);
#else
    return (vi_min((a << 16) >> 16, (b << 16) >> 16) & 0xffff) | (vi_min(a >> 16, b >> 16) << 16);
#endif
}

PEL_INLINE vi vi_max16(vi a, vi b)
{
#if PEL_AVX512
    return (vi)_mm512_max_epi16((__m512i)a, (__m512i)b);
#elif PEL_AVX2
    return (vi)_mm256_max_epi16((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
    return (vi)_mm_max_epi16((__m128i)a, (__m128i)b);
#else
    return (vi_max((a << 16) >> 16, (b << 16) >> 16) & 0xffff) | (vi_max(a >> 16, b >> 16) << 16);
#endif
}

/* Bytes i and i + 1 of each lane, unsigned, as its two 16-bit numbers; i is a constant 0 to 2. */
PEL_INLINE vi vi_byte_pair(vi a, int i)
{
#if defined(__SSSE3__)
    const int32_t take = (int32_t)(0x80008000u | (uint32_t)i | (uint32_t)(i + 1) << 16);
#if PEL_AVX512
    const __m128i quarter = _mm_set_epi32(take + 0x0c000c, take + 0x080008, take + 0x040004, take);
    return (vi)_mm512_shuffle_epi8((__m512i)a, _mm512_broadcast_i32x4(quarter));
#elif PEL_AVX2
    const __m128i half = _mm_set_epi32(take + 0x0c000c, take + 0x080008, take + 0x040004, take);
    return (vi)_mm256_shuffle_epi8((__m256i)a, _mm256_broadcastsi128_si256(half));
#else
    return (vi)_mm_shuffle_epi8((__m128i)a, _mm_set_epi32(take + 0x0c000c, take + 0x080008, take + 0x040004, take));
#endif
#else
    a >>= 8 * i;
    return (a & 0xff) | ((a & 0xff00) << 8);
#endif
}

/* 1 / sqrt(a) to about 22 bits; a > 0. */
PEL_INLINE vf vf_rsqrt(vf a)
{
#if PEL_AVX512
    vf r = (vf)_mm512_rsqrt14_ps((__m512)a);
#elif PEL_AVX2
    vf r = (vf)_mm256_rsqrt_ps((__m256)a);
#elif defined(__SSE2__)
    vf r = (vf)_mm_rsqrt_ps((__m128)a);
#else
    vf r;
    for (int i = 0; i < W; i++)
        r[i] = 1 / sqrtf(a[i]);
#endif
    return r * (1.5f - 0.5f * a * r * r);
}

PEL_INLINE vf vf_sqrt(vf a)
{
#if PEL_AVX512
    return (vf)_mm512_sqrt_ps((__m512)a);
#elif PEL_AVX2
    return (vf)_mm256_sqrt_ps((__m256)a);
#elif defined(__SSE2__)
    return (vf)_mm_sqrt_ps((__m128)a);
#else
    for (int i = 0; i < W; i++)
        a[i] = __builtin_sqrtf(a[i]);
    return a;
#endif
}

/* Natural exponential for x <= 0 (to a few units in the last place; below -87 it is 0), by 2^n times a polynomial on [-ln2/2, ln2/2]. */
PEL_INLINE vf vf_exp(vf x)
{
    x = vf_max(x, vf_set(-87));
    vf n = x * 1.44269504f;
    vi k = vf_to_vi(n - 0.5f);
    vf f = vi_to_vf(k);
    vf r = (x - f * 0.693359375f) - f * -2.12194440e-4f;
    vf p = 1 + r * (1 + r * (0.5f + r * (1.66666667e-1f + r * (4.16666667e-2f + r * (8.33333333e-3f + r * 1.38888889e-3f)))));
    vf scaled = (vf)((vi)p + (k << 23));
    return vf_select(x <= -86.9f, vf_set(0), scaled);
}

/* Natural logarithm for x > 0, normal numbers; about 1e-6 absolute or better. */
PEL_INLINE vf vf_log(vf x)
{
    vi bits = (vi)x;
    vi e = ((bits - 0x3f3504f3) >> 23);         /* mantissa into [sqrt(1/2), sqrt(2)) */
    vf m = (vf)(bits - (e << 23));
    vf s = (m - 1) / (m + 1), z = s * s;        /* ln m = 2 atanh(s) */
    vf p = s * (2 + z * (0.66666667f + z * (0.4f + z * (0.285714286f + z * 0.222222222f))));
    return p + vi_to_vf(e) * 0.69314718f;
}

/* base^exponent, base in [0, 1]; 0 where base is 0. A whole exponent up to 255 goes by squaring. */
PEL_INLINE vf vf_power(vf base, float exponent)
{
    int whole = (int)exponent;
    if ((float)whole == exponent && whole >= 0 && whole < 256) {
        vf result = vf_set(1);
        for (; whole > 1; whole >>= 1, base *= base)
            if (whole & 1)
                result *= base;
        return whole ? result * base : result;
    }
    vf positive = vf_max(base, vf_set(1e-30f));
    return vf_select(base > 1e-30f, vf_exp(exponent * vf_log(positive)), vf_set(0));
}

/* Numbers below 1e-38 count as 0 from here on: a highlight's power soon ends there, and each such number costs a hundred cycles. Gives what to
 * give back to flush_restore. */
PEL_INLINE unsigned flush_tiny(void)
{
#if defined(__SSE2__)
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | 0x8040); /* FTZ, DAZ */
    return before;
#else
    return 0;
#endif
}

PEL_INLINE void flush_restore(unsigned before)
{
#if defined(__SSE2__)
    _mm_setcsr(before);
#else
    (void)before;
#endif
}

PEL_INLINE vf vf_lerp(vf a, vf b, vf t)
{
    return a + t * (b - a);
}

#endif
