/* SPDX-License-Identifier: MIT */
/* The two sparse tables are built row by row, each from the row above it: an extreme over 2^k entries is that of two runs of 2^(k-1). */
#include "range_table.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"

static int level_count(size_t count)
{
    int levels = 1;
    while (count >> levels)
        levels++;
    return levels;
}

/* Gives the table memory for `count` entries; leaves it as it was on failure. */
static bool reserve(struct pel_range_table *table, size_t count, struct pel_error *error)
{
    if (table->most && table->count == count)
        return true;
    int levels = level_count(count);
    size_t entries;
    if (!pel_mul(count, (size_t)levels, &entries))
        return pel_fail(error, PEL_ERROR_MEMORY, "range table: %zu entries are more than can be addressed", count);
    float *least = pel_alloc_aligned(entries, sizeof *least, "range table", error);
    float *most = least ? pel_alloc_aligned(entries, sizeof *most, "range table", error) : NULL;
    if (!most) {
        free(least);
        return false;
    }
    pel_range_table_finish(table);
    *table = (struct pel_range_table) { count, levels, least, most };
    return true;
}

bool pel_range_table_build(struct pel_range_table *table, const float *values, size_t count, struct pel_error *error)
{
    if (count < 1)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "range table: no entries");
    if (!reserve(table, count, error))
        return false;
    memcpy(table->least, values, count * sizeof *values);
    memcpy(table->most, values, count * sizeof *values);
    for (int k = 1; k < table->levels; k++) {
        size_t half = (size_t)1 << (k - 1), filled = count - 2 * half + 1;
        const float *restrict least = table->least + (size_t)(k - 1) * count, *restrict most = table->most + (size_t)(k - 1) * count;
        float *restrict least_out = table->least + (size_t)k * count, *restrict most_out = table->most + (size_t)k * count;
        for (size_t i = 0; i < filled; i++)
            least_out[i] = least[i] < least[i + half] ? least[i] : least[i + half];
        for (size_t i = 0; i < filled; i++)
            most_out[i] = most[i] > most[i + half] ? most[i] : most[i + half];
        /* Runs that would leave the array are never asked for; they hold something all the same. */
        for (size_t i = filled; i < count; i++)
            least_out[i] = most_out[i] = 0;
    }
    return true;
}

void pel_range_table_finish(struct pel_range_table *table)
{
    free(table->least);
    free(table->most);
    *table = (struct pel_range_table) { 0 };
}
