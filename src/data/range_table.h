/* SPDX-License-Identifier: MIT */
/* Least and greatest entry over any interval of an array, in O(1): a sparse table of the extremes of all runs of 2^k entries (Bender and
 * Farach-Colton). Every kind of skipping asks it, so it is rebuilt on each edit of a transfer function. */
#ifndef PEL_DATA_RANGE_TABLE_H
#define PEL_DATA_RANGE_TABLE_H

#include <stddef.h>

#include <pellucid/error.h>

struct pel_range_table {
    size_t count;  /* entries, >= 1 */
    int levels;    /* floor(log2(count)) + 1 */
    float *least;  /* owned; levels * count: least[k * count + i] is over entries i .. i + 2^k - 1 */
    float *most;   /* owned; the same for the greatest */
};

/* Builds over `count` floats (no NaN). May be called again with a table that was built before: memory is reused where the count is the
 * same. */
bool pel_range_table_build(struct pel_range_table *table, const float *values, size_t count, struct pel_error *error);
void pel_range_table_finish(struct pel_range_table *table); /* accepts a zeroed table */

/* Extremes over entries first .. last (both counted, first <= last < count). */
static inline float pel_range_table_most(const struct pel_range_table *table, size_t first, size_t last)
{
    int k = 63 - __builtin_clzll((unsigned long long)(last - first + 1));
    const float *row = table->most + (size_t)k * table->count;
    float a = row[first], b = row[last + 1 - ((size_t)1 << k)];
    return a > b ? a : b;
}

static inline float pel_range_table_least(const struct pel_range_table *table, size_t first, size_t last)
{
    int k = 63 - __builtin_clzll((unsigned long long)(last - first + 1));
    const float *row = table->least + (size_t)k * table->count;
    float a = row[first], b = row[last + 1 - ((size_t)1 << k)];
    return a < b ? a : b;
}

#endif
