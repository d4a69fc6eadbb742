/* SPDX-License-Identifier: MIT */
/* Samples of any type as doubles, a block at a time: for code that need not be the fastest. Kernels that must be have a loop a type. */
#ifndef PEL_DATA_SAMPLES_H
#define PEL_DATA_SAMPLES_H

#include <stddef.h>

#include <pellucid/volume.h>

/* Samples first .. first + count - 1 in memory order: the value, or the Euclidean length where there are several components; NaN where the
 * sample is void (any component NaN or the void value). */
void pel_samples_load(const struct pel_volume *volume, size_t first, size_t count, double *out);

/* Work over all samples is cut into this many slabs at most, whatever the thread count, and merged in their order: the same sums anywhere.
 */
#define PEL_MAX_SLABS 256
size_t pel_slab_count(size_t samples);
/* First sample of a slab; the next slab's first is its end. */
size_t pel_slab_first(size_t samples, size_t slabs, size_t slab);

#endif
