/* SPDX-License-Identifier: MIT */
/* A transfer function sampled into equal steps of value, for kernels that look up instead of searching curves, with the range table over
 * its opacities. Entry i stands for the value lo + i * (hi - lo) / (count - 1); values outside [lo, hi] get the first or last entry. */
#ifndef PEL_DATA_TRANSFER_TABLE_H
#define PEL_DATA_TRANSFER_TABLE_H

#include <stdint.h>

#include <pellucid/transfer.h>

#include "range_table.h"

struct pel_transfer_table {
    double lo, hi;   /* lo < hi */
    size_t count;    /* a power of two, 4096 to 65536 */
    float *opacity;  /* owned; per unit distance, 0..1 */
    float *red, *green, *blue; /* owned; display values, not multiplied by opacity */
    struct pel_range_table range; /* over `opacity` */
    uint32_t *next_visible; /* owned; the first entry from i on that is not clear, `count` where there is none */
    double scale, slack;    /* entries a unit of value; entries by which kernels' look-ups may be off */
    struct pel_transfer transfer; /* owned copy: what the table was built from */
};

/* Builds for values in [data_lo, data_hi] (the volume's range; need not be ordered or distinct). [lo, hi] is the part of it in which the
 * curves change, widened to something where that is empty; `count` is 4096, or more (up to 65536) where two successive points are so near
 * that they would share fewer than 16 entries. May be called again on a table built before (reuses memory; returns at once where nothing
 * changed). Under 1 ms for 4096 entries. */
bool pel_transfer_table_build(struct pel_transfer_table *table, const struct pel_transfer *transfer, double data_lo, double data_hi,
                              struct pel_error *error);
void pel_transfer_table_finish(struct pel_transfer_table *table); /* accepts a zeroed table */

/* The entries that any value in [lo, hi] can look up as the nearest, with a quarter of an entry of rounding to each side (more where values
 * are so large against their range that floats are coarser). first <= last < count; a NaN widens them to all. */
static inline void pel_transfer_table_entries(const struct pel_transfer_table *table, double lo, double hi, size_t *first, size_t *last)
{
    double a = (lo - table->lo) * table->scale + 0.5 - table->slack, b = (hi - table->lo) * table->scale + 0.5 + table->slack;
    int32_t most = (int32_t)table->count - 1;
    int32_t from = a > 0 ? a < most ? (int32_t)a : most : 0, to = b < most ? b > 0 ? (int32_t)b : 0 : most;
    *first = (size_t)(from < to ? from : to);
    *last = (size_t)to;
}

/* May any value in [lo, hi] be seen? O(1), and but one look at memory: it is asked of every cell at each edit of a transfer function. */
static inline bool pel_transfer_table_visible(const struct pel_transfer_table *table, double lo, double hi)
{
    size_t first, last;
    pel_transfer_table_entries(table, lo, hi, &first, &last);
    return table->next_visible[first] <= last;
}

/* Least and greatest opacity that any value in [lo, hi] can look up. O(1). */
void pel_transfer_table_opacity_range(const struct pel_transfer_table *table, double lo, double hi, float *least, float *most);

#endif
