/* SPDX-License-Identifier: MIT */
/* Statistics of a volume's values: what `pellucid info` prints and what the automatic transfer function is made from. */
#ifndef PELLUCID_STATISTICS_H
#define PELLUCID_STATISTICS_H

#include <stdint.h>

#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Values are those of the samples, or their Euclidean length where a sample has several components. */
struct pel_statistics {
    double min, max;   /* of finite, non-void samples; NaN where there are none */
    double mean;       /* of finite, non-void samples, accumulated in double with pairwise blocks; NaN where there are none */
    uint64_t samples;  /* all */
    uint64_t nonzero;  /* finite, non-void and not 0 */
    uint64_t voids;    /* NaN, or equal to the void value */
    uint64_t infinite; /* +inf or -inf; neither void nor counted in min, max and mean */
};

void pel_statistics_compute(const struct pel_volume *volume, struct pel_statistics *statistics);

/* Histogram over [lo, hi] in `count` equal bins; a value equal to hi falls into the last bin, values outside are not counted.
 * For integer types whose range has at most `count` values, choose lo = min - 0.5 and hi = max + 0.5 to get a bin a value.
 * `gradient_sum` (nullable, count entries) gets the sum of the central-difference gradient magnitudes, in value per voxel, of each
 * bin's samples: gradient_sum[i] / bins[i] is the mean gradient at that value. */
struct pel_histogram {
    double lo, hi;
    size_t count;
    uint64_t *bins;        /* owned, count entries */
    double *gradient_sum;  /* owned or NULL */
};

bool pel_histogram_init(struct pel_histogram *histogram, const struct pel_volume *volume, double lo, double hi, size_t count,
                        bool with_gradient, struct pel_error *error);
void pel_histogram_finish(struct pel_histogram *histogram);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
