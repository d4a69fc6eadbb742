/* SPDX-License-Identifier: MIT */
/* A scanline of shear-warp's intermediate image: what its pixels gathered, which of them are open, and how it is stored. */
#ifndef PEL_CPU_KERNEL_SHEAR_LINE_H
#define PEL_CPU_KERNEL_SHEAR_LINE_H

#include "kernel_common.h"
#include "kernel_shear_fetch.h"

PEL_INLINE vi bits_to_lanes(unsigned bits)
{
#if PEL_AVX512
    return (vi)_mm512_movm_epi32((__mmask16)bits);
#else
    return -((vi_set((int32_t)bits) >> vi_lane()) & 1);
#endif
}

/* Bits of lanes from up to end. */
PEL_INLINE unsigned lane_range(int from, int end)
{
    from = from > 0 ? from : 0;
    end = end < W ? end : W;
    return end > from ? ((1u << (end - from)) - 1) << from : 0;
}

PEL_INLINE struct gathered line_load(const struct pel_scanline *line, int u)
{
    struct gathered g;
    for (int c = 0; c < 3; c++)
        g.color[c] = vf_load(line->color[c] + u);
    g.alpha = vf_load(line->alpha + u);
    g.depth = vf_load(line->depth + u);
    return g;
}

PEL_INLINE void line_put(struct pel_scanline *line, int u, const struct gathered *g)
{
    for (int c = 0; c < 3; c++)
        vf_store(line->color[c] + u, g->color[c]);
    vf_store(line->alpha + u, g->alpha);
    vf_store(line->depth + u, g->depth);
    line->low = u < line->low ? u : line->low;
    line->high = u + W > line->high ? u + W : line->high;
}

/* The first open pixel from u on, `end` where there is none before; and which of W pixels from there on, before `end`, are open. */
PEL_INLINE int next_open(const struct pel_scanline *line, int u, int end, unsigned *bits)
{
    while (u < end) {
        uint64_t pair;
        memcpy(&pair, line->open + (u >> 5), sizeof pair);
        pair >>= u & 31;
        if ((uint32_t)pair) {
            int skip = __builtin_ctz((uint32_t)pair);
            memcpy(&pair, line->open + ((u + skip) >> 5), sizeof pair);
            *bits = (unsigned)(pair >> ((u + skip) & 31)) & lane_range(0, end - u - skip);
            return *bits ? u + skip : end;
        }
        u += 32;
    }
    return end;
}

/* Up to 33 pixels from u on: a bit each that is open. */
PEL_INLINE uint64_t open_pixels(const struct pel_scanline *line, int u)
{
    uint64_t pair;
    memcpy(&pair, line->open + (u >> 5), sizeof pair);
    return pair >> (u & 31);
}

PEL_INLINE void close_pixels(struct pel_scanline *line, int u, unsigned opaque)
{
    uint64_t pair;
    memcpy(&pair, line->open + (u >> 5), sizeof pair);
    pair &= ~((uint64_t)opaque << (u & 31));
    memcpy(line->open + (u >> 5), &pair, sizeof pair);
}

/* The first bit from `at` on that is set (or, with all bits of `flip` set, that is not); `end` where there is none before. */
PEL_INLINE int next_bit(const uint64_t *words, int at, int end, uint64_t flip)
{
    while (at < end) {
        uint64_t rest = (words[at >> 6] ^ flip) >> (at & 63);
        if (rest) {
            at += __builtin_ctzll(rest);
            return at < end ? at : end;
        }
        at = (at | 63) + 1;
    }
    return end;
}

/* The last bit that is set; some are. */
PEL_INLINE int last_bit(const uint64_t *words, int count)
{
    while (!words[count - 1])
        count--;
    return count * 64 - 1 - __builtin_clzll(words[count - 1]);
}

/* Clears the pixels from `low` up to `high`. */
PEL_INLINE void line_clear(struct pel_scanline *line, int low, int high)
{
    for (int u = low; u < high; u += W) {
        for (int c = 0; c < 3; c++)
            vf_store(line->color[c] + u, vf_set(0));
        vf_store(line->alpha + u, vf_set(0));
        vf_store(line->depth + u, vf_set(-1));
    }
}

/* Lanes 0, W, 1, W + 1, ... or, from the upper halves, HALF, W + HALF, ... of two vectors. */
PEL_INLINE vf zip(vf a, vf b, int upper)
{
    vi take;
    for (int l = 0; l < W; l++)
        take[l] = (l & 1) * W + (l >> 1) + upper * HALF;
    return __builtin_shuffle(a, b, take);
}

PEL_INLINE vf zip_pairs(vf a, vf b, int upper)
{
    vl take;
    for (int l = 0; l < HALF; l++)
        take[l] = (l & 1) * HALF + (l >> 1) + upper * (HALF / 2);
    return (vf)__builtin_shuffle((vd)a, (vd)b, take);
}

/* W pixels of four floats. */
PEL_INLINE void store_pixels(float *to, vf red, vf green, vf blue, vf alpha)
{
    for (int upper = 0; upper < 2; upper++) {
        vf rg = zip(red, green, upper), ba = zip(blue, alpha, upper);
        vf_store(to + upper * 2 * W, zip_pairs(rg, ba, 0));
        vf_store(to + upper * 2 * W + W, zip_pairs(rg, ba, 1));
    }
}

/* Puts a scanline into the intermediate image, whose rows have room for 2 W pixels more, and clears it. */
PEL_INLINE void line_store(const struct pel_shear *s, int v, struct pel_scanline *line)
{
    float *to = s->rgba + ((size_t)(v + 1) * (size_t)s->stride + 1) * 4;
    const int low = line->low < line->high ? line->low : 0, high = line->high;
    memset(to - 4, 0, ((size_t)low + 1) * 4 * sizeof *to);
    for (int u = low; u < high; u += W)
        store_pixels(to + 4 * u, vf_load(line->color[0] + u), vf_load(line->color[1] + u), vf_load(line->color[2] + u),
                     vf_load(line->alpha + u));
    const int end = high < s->width ? high : s->width;
    memset(to + 4 * end, 0, (size_t)(s->width + 1 - end) * 4 * sizeof *to);
    if (s->depth) {
        float *depth = s->depth + (size_t)(v + 1) * (size_t)s->stride;
        depth[0] = depth[s->width + 1] = -1;
        memcpy(depth + 1, line->depth, (size_t)s->width * sizeof(float));
    }
    s->row_from[v + 1] = low + 1;
    s->row_to[v + 1] = end + 1;
    line_clear(line, low, high);
    line->low = s->width;
    line->high = 0;
}

#endif
