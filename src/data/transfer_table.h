/* SPDX-License-Identifier: MIT */
/* A transfer function sampled into equal steps of value, for kernels that look up instead of searching curves, with the range table over
 * its opacities. Entry i stands for the value lo + i * (hi - lo) / (count - 1); values outside [lo, hi] get the first or last entry. */
#ifndef PEL_DATA_TRANSFER_TABLE_H
#define PEL_DATA_TRANSFER_TABLE_H

#include <pellucid/transfer.h>

#include "range_table.h"

struct pel_transfer_table {
    double lo, hi;   /* lo < hi */
    size_t count;    /* a power of two, 4096 to 65536 */
    float *opacity;  /* owned; per unit distance, 0..1 */
    float *red, *green, *blue; /* owned; display values, not multiplied by opacity */
    struct pel_range_table range; /* over `opacity` */
    struct pel_transfer transfer; /* owned copy: what the table was built from */
};

/* Builds for values in [data_lo, data_hi] (the volume's range; need not be ordered or distinct). [lo, hi] is the part of it in which the
 * curves change, widened to something where that is empty; `count` is 4096, or more (up to 65536) where two successive points are so near
 * that they would share fewer than 16 entries. May be called again on a table built before (reuses memory; returns at once where nothing
 * changed). Under 1 ms for 4096 entries. */
bool pel_transfer_table_build(struct pel_transfer_table *table, const struct pel_transfer *transfer, double data_lo, double data_hi,
                              struct pel_error *error);
void pel_transfer_table_finish(struct pel_transfer_table *table); /* accepts a zeroed table */

/* Least and greatest opacity that any value in [lo, hi] can look up at the nearest entry, with a quarter of an entry of rounding to each
 * side (more where values are so large against their range that floats are coarser). O(1). */
void pel_transfer_table_opacity_range(const struct pel_transfer_table *table, double lo, double hi, float *least, float *most);

#endif
