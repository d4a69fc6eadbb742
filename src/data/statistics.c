/* SPDX-License-Identifier: MIT */
/* Statistics and histogram. Both cut the samples into slabs that do not depend on the thread count and merge them in order, so sums of
 * floating-point numbers are the same on any machine. Integers of one component without a void value, the common case of large files, have
 * loops of their own; everything else goes through doubles. */
#include <pellucid/statistics.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"
#include "samples.h"

#define BLOCK 4096 /* sums of as many u16 fit in 32 bits */

/* Pairwise summation, fed a block's sum at a time: level k holds the sum of 2^k blocks, as the bits of `count` say. */
struct pairwise {
    double level[64];
    uint64_t count;
};

static void pairwise_add(struct pairwise *p, double sum)
{
    int k = 0;
    for (uint64_t bits = p->count++; bits & 1; bits >>= 1)
        sum += p->level[k++];
    p->level[k] = sum;
}

static double pairwise_total(const struct pairwise *p)
{
    double sum = 0;
    for (int k = 0; k < 64; k++)
        if (p->count >> k & 1)
            sum += p->level[k];
    return sum;
}

struct slab_statistics {
    double min, max, sum;
    uint64_t finite, nonzero, voids, infinite;
};

struct statistics_pass {
    const struct pel_volume *volume;
    size_t samples, slabs;
    struct slab_statistics slab[PEL_MAX_SLABS];
};

#define INTEGER_BLOCK(T, S)                                                                                                                \
    do {                                                                                                                                   \
        const T *p = (const T *)volume->data + first;                                                                                      \
        T lo = p[0], hi = p[0];                                                                                                            \
        S sum = 0;                                                                                                                         \
        uint32_t nonzero = 0;                                                                                                              \
        for (size_t i = 0; i < count; i++) {                                                                                               \
            lo = p[i] < lo ? p[i] : lo;                                                                                                    \
            hi = p[i] > hi ? p[i] : hi;                                                                                                    \
            sum += (S)p[i];                                                                                                                \
            nonzero += p[i] != 0;                                                                                                          \
        }                                                                                                                                  \
        s->min = fmin(s->min, lo);                                                                                                         \
        s->max = fmax(s->max, hi);                                                                                                         \
        s->finite += count;                                                                                                                \
        s->nonzero += nonzero;                                                                                                             \
        return (double)sum;                                                                                                                \
    } while (0)

static double integer_block(const struct pel_volume *volume, size_t first, size_t count, struct slab_statistics *s)
{
    switch (volume->type) {
    case PEL_U8: INTEGER_BLOCK(uint8_t, uint32_t);
    case PEL_I8: INTEGER_BLOCK(int8_t, int32_t);
    case PEL_U16: INTEGER_BLOCK(uint16_t, uint32_t);
    case PEL_I16: INTEGER_BLOCK(int16_t, int32_t);
    case PEL_U32: INTEGER_BLOCK(uint32_t, uint64_t);
    case PEL_I32: INTEGER_BLOCK(int32_t, int64_t);
    default: return 0;
    }
}

static double any_block(const struct pel_volume *volume, size_t first, size_t count, struct slab_statistics *s)
{
    double values[BLOCK], sum = 0;
    pel_samples_load(volume, first, count, values);
    for (size_t i = 0; i < count; i++) {
        double v = values[i];
        if (isnan(v)) {
            s->voids++;
        } else if (isinf(v)) {
            s->infinite++;
        } else {
            s->min = v < s->min ? v : s->min;
            s->max = v > s->max ? v : s->max;
            s->finite++;
            s->nonzero += v != 0;
            sum += v;
        }
    }
    return sum;
}

static void statistics_slab(void *context, size_t slab, int thread)
{
    (void)thread;
    struct statistics_pass *pass = context;
    const struct pel_volume *volume = pass->volume;
    struct slab_statistics *s = &pass->slab[slab];
    bool simple = volume->components == 1 && !volume->has_void && volume->type < PEL_F32;
    size_t end = pel_slab_first(pass->samples, pass->slabs, slab + 1);
    struct pairwise sum = { .count = 0 };
    s->min = INFINITY, s->max = -INFINITY;
    for (size_t i = pel_slab_first(pass->samples, pass->slabs, slab); i < end; i += BLOCK) {
        size_t n = end - i < BLOCK ? end - i : BLOCK;
        pairwise_add(&sum, simple ? integer_block(volume, i, n, s) : any_block(volume, i, n, s));
    }
    s->sum = pairwise_total(&sum);
}

void pel_statistics_compute(const struct pel_volume *volume, struct pel_statistics *statistics)
{
    struct statistics_pass pass = { .volume = volume, .samples = volume->data ? pel_volume_samples(volume) : 0 };
    *statistics = (struct pel_statistics){ .min = NAN, .max = NAN, .mean = NAN, .samples = pass.samples };
    if (pass.samples == 0)
        return;
    pass.slabs = pel_slab_count(pass.samples);
    pel_parallel_for(0, pass.slabs, statistics_slab, &pass);
    struct pairwise sum = { .count = 0 };
    double min = INFINITY, max = -INFINITY;
    uint64_t finite = 0;
    for (size_t i = 0; i < pass.slabs; i++) {
        const struct slab_statistics *s = &pass.slab[i];
        min = fmin(min, s->min);
        max = fmax(max, s->max);
        pairwise_add(&sum, s->sum);
        finite += s->finite;
        statistics->nonzero += s->nonzero;
        statistics->voids += s->voids;
        statistics->infinite += s->infinite;
    }
    if (finite) {
        statistics->min = min;
        statistics->max = max;
        statistics->mean = pairwise_total(&sum) / (double)finite;
    }
}
