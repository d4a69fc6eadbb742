/* SPDX-License-Identifier: MIT */
/* The table covers only the values between which the curves change: a narrow ramp in a wide range of data then gets as many entries as a
 * wide one. */
#include "transfer_table.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "alloc.h"
#include "fail.h"

enum { LEAST_COUNT = 4096, MOST_COUNT = 65536, ENTRIES_BETWEEN_POINTS = 16 };

/* Value of point i of a curve; the two kinds of points both begin with it. */
static double value_at(const void *points, size_t stride, size_t i)
{
    return *(const double *)((const char *)points + i * stride);
}

/* Widens [lo, hi] to hold all points, and tells whether the curve jumps at its first or last value. */
static void extend(const void *points, size_t count, size_t stride, double *lo, double *hi, bool *jump_lo, bool *jump_hi)
{
    double first = value_at(points, stride, 0), last = value_at(points, stride, count - 1);
    bool jumps_first = count > 1 && value_at(points, stride, 1) == first;
    bool jumps_last = count > 1 && value_at(points, stride, count - 2) == last;
    if (first <= *lo) {
        *jump_lo = jumps_first || (first == *lo && *jump_lo);
        *lo = first;
    }
    if (last >= *hi) {
        *jump_hi = jumps_last || (last == *hi && *jump_hi);
        *hi = last;
    }
}

/* The part of the data's range in which the curves change; lo < hi, and hi - lo can be had. */
static void choose_interval(const struct pel_transfer *transfer, double data_lo, double data_hi, double *lo, double *hi)
{
    const double most = DBL_MAX / 4;
    double a = isnan(data_lo) ? 0 : data_lo, b = isnan(data_hi) ? a : data_hi, curve_lo = INFINITY, curve_hi = -INFINITY;
    bool jump_lo = false, jump_hi = false;
    if (a > b) {
        double t = a;
        a = b;
        b = t;
    }
    extend(transfer->colors, transfer->color_count, sizeof *transfer->colors, &curve_lo, &curve_hi, &jump_lo, &jump_hi);
    extend(transfer->opacities, transfer->opacity_count, sizeof *transfer->opacities, &curve_lo, &curve_hi, &jump_lo, &jump_hi);
    *lo = fmin(fmax(a, curve_lo), most);
    *hi = fmax(fmin(b, curve_hi), -most);
    *lo = fmax(*lo, -most);
    *hi = fmin(*hi, most);
    if (*lo > *hi) /* the data lie wholly to one side of the curves: the end of the data that is nearer says it all */
        *lo = *hi = a > curve_hi ? *lo : *hi;
    /* Where a curve jumps at its end, the entry beyond must be on the far side of the jump. */
    double margin = (*hi - *lo) / (LEAST_COUNT / 2);
    bool pad_lo = jump_lo && curve_lo >= a, pad_hi = jump_hi && curve_hi <= b;
    double least = fmin(fmax(fmax(fabs(*lo), fabs(*hi)), b / 2 - a / 2), most) * 1e-6; /* the data's range may be infinite */
    if (!(margin > fmax(DBL_MIN * LEAST_COUNT, least * 1e-6))) {
        margin = least > 1e-290 ? least : 1e-290;
        pad_lo = pad_hi = true;
    }
    *lo -= pad_lo ? margin : 0;
    *hi += pad_hi ? margin : 0;
}

/* Least positive distance between successive points that lies in [lo, hi] at least in part. */
static double least_gap(const void *points, size_t count, size_t stride, double lo, double hi)
{
    double gap = INFINITY;
    for (size_t i = 1; i < count; i++) {
        double a = value_at(points, stride, i - 1), b = value_at(points, stride, i);
        if (b > lo && a < hi && b > a && b - a < gap)
            gap = b - a;
    }
    return gap;
}

static size_t choose_count(const struct pel_transfer *transfer, double lo, double hi)
{
    double gap = fmin(least_gap(transfer->colors, transfer->color_count, sizeof *transfer->colors, lo, hi),
                      least_gap(transfer->opacities, transfer->opacity_count, sizeof *transfer->opacities, lo, hi));
    size_t count = LEAST_COUNT;
    while (count < MOST_COUNT && (hi - lo) / (double)(count - 1) * ENTRIES_BETWEEN_POINTS > gap)
        count *= 2;
    return count;
}

static bool reserve(struct pel_transfer_table *table, size_t count, struct pel_error *error)
{
    if (table->opacity && table->count == count)
        return true;
    float *memory = pel_alloc_aligned(count * 5, sizeof *memory, "transfer table", error);
    if (!memory)
        return false;
    free(table->opacity); /* the five arrays are one block */
    table->opacity = memory;
    table->red = memory + count;
    table->green = memory + 2 * count;
    table->blue = memory + 3 * count;
    table->next_visible = (uint32_t *)(memory + 4 * count);
    table->count = count;
    return true;
}

static void set_entry(struct pel_transfer_table *table, size_t i, double value)
{
    double rgb[3];
    pel_transfer_color(&table->transfer, value, rgb);
    table->opacity[i] = (float)pel_transfer_opacity(&table->transfer, value);
    table->red[i] = (float)rgb[0];
    table->green[i] = (float)rgb[1];
    table->blue[i] = (float)rgb[2];
}

/* At the value of a jump the second point holds, so the entry which that value looks up must be from beyond the jump, wherever in the
 * entry's width the jump lies. */
static void set_jumps(struct pel_transfer_table *table, const void *points, size_t count, size_t stride)
{
    for (size_t i = 1; i < count; i++) {
        double value = value_at(points, stride, i);
        if (value != value_at(points, stride, i - 1) || value < table->lo || value > table->hi)
            continue;
        double entry = floor((value - table->lo) * table->scale + 0.5);
        if (entry >= 0 && entry < (double)table->count)
            set_entry(table, (size_t)entry, value);
    }
}

static void find_visible(struct pel_transfer_table *table)
{
    uint32_t next = (uint32_t)table->count;
    for (size_t i = table->count; i-- > 0;) {
        if (table->opacity[i] > 0)
            next = (uint32_t)i;
        table->next_visible[i] = next;
    }
}

bool pel_transfer_table_build(struct pel_transfer_table *table, const struct pel_transfer *transfer, double data_lo, double data_hi,
                              struct pel_error *error)
{
    if (!transfer->color_count || !transfer->opacity_count)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "transfer function: a curve has no points");
    double lo, hi;
    choose_interval(transfer, data_lo, data_hi, &lo, &hi);
    size_t count = choose_count(transfer, lo, hi);
    if (table->opacity && table->count == count && table->lo == lo && table->hi == hi && pel_transfer_equal(&table->transfer, transfer))
        return true;
    table->lo = NAN; /* nothing that a later call would take for built, until all is */
    if (!reserve(table, count, error) || !pel_transfer_copy(&table->transfer, transfer, error))
        return false;
    table->lo = lo;
    table->hi = hi;
    table->scale = (double)(count - 1) / (hi - lo);
    /* Kernels round to the nearest entry in floats. A whole entry to each side would make air at 0 visible below a ramp from 0. */
    table->slack = 0.25 + fmax(fabs(lo), fabs(hi)) * table->scale * 0x1p-20;
    for (size_t i = 0; i < count; i++) {
        double f = (double)i / (double)(count - 1);
        set_entry(table, i, lo * (1 - f) + hi * f);
    }
    set_jumps(table, transfer->colors, transfer->color_count, sizeof *transfer->colors);
    set_jumps(table, transfer->opacities, transfer->opacity_count, sizeof *transfer->opacities);
    find_visible(table);
    if (pel_range_table_build(&table->range, table->opacity, count, error))
        return true;
    table->lo = NAN;
    return false;
}

void pel_transfer_table_finish(struct pel_transfer_table *table)
{
    free(table->opacity);
    pel_range_table_finish(&table->range);
    pel_transfer_finish(&table->transfer);
    *table = (struct pel_transfer_table) { 0 };
}

void pel_transfer_table_opacity_range(const struct pel_transfer_table *table, double lo, double hi, float *least, float *most)
{
    size_t first, last;
    pel_transfer_table_entries(table, lo, hi, &first, &last);
    *least = pel_range_table_least(&table->range, first, last);
    *most = pel_range_table_most(&table->range, first, last);
}
