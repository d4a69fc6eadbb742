/* SPDX-License-Identifier: MIT */
/* Transfer functions: two curves that own their points. Every setter builds the new curve beside the old one and swaps at the end, so a
 * refused edit leaves the function as it was. Evaluation here is by binary search, exact and unhurried; kernels use transfer_table.h. */
#include <pellucid/transfer.h>

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "c_locale.h"
#include "colormaps.h"
#include "fail.h"

bool pel_transfer_init(struct pel_transfer *transfer, struct pel_error *error)
{
    static const struct pel_color_point colors[] = { { 0, { 0, 0, 0 } }, { 1, { 1, 1, 1 } } };
    static const struct pel_opacity_point opacities[] = { { 0, 0 }, { 1, 1 } };
    *transfer = (struct pel_transfer) { .unit_distance = 1 };
    if (pel_transfer_set_colors(transfer, colors, 2, error) && pel_transfer_set_opacities(transfer, opacities, 2, error)) {
        snprintf(transfer->colormap, sizeof transfer->colormap, "gray");
        return true;
    }
    pel_transfer_finish(transfer);
    return false;
}

void pel_transfer_finish(struct pel_transfer *transfer)
{
    free(transfer->colors);
    free(transfer->opacities);
    *transfer = (struct pel_transfer) { 0 };
}

bool pel_transfer_copy(struct pel_transfer *to, const struct pel_transfer *from, struct pel_error *error)
{
    if (to == from)
        return true;
    struct pel_color_point *colors = pel_alloc(from->color_count, sizeof *colors, "transfer function", error);
    struct pel_opacity_point *opacities = pel_alloc(from->opacity_count, sizeof *opacities, "transfer function", error);
    if (!colors || !opacities) {
        free(colors);
        free(opacities);
        return false;
    }
    if (from->color_count)
        memcpy(colors, from->colors, from->color_count * sizeof *colors);
    if (from->opacity_count)
        memcpy(opacities, from->opacities, from->opacity_count * sizeof *opacities);
    pel_transfer_finish(to);
    *to = *from;
    to->colors = colors;
    to->opacities = opacities;
    return true;
}

static bool same_colors(const struct pel_transfer *a, const struct pel_transfer *b)
{
    if (a->color_count != b->color_count)
        return false;
    for (size_t i = 0; i < a->color_count; i++) {
        const struct pel_color_point *p = &a->colors[i], *q = &b->colors[i];
        if (p->value != q->value || p->rgb[0] != q->rgb[0] || p->rgb[1] != q->rgb[1] || p->rgb[2] != q->rgb[2])
            return false;
    }
    return true;
}

bool pel_transfer_equal(const struct pel_transfer *a, const struct pel_transfer *b)
{
    if (a->opacity_count != b->opacity_count || a->unit_distance != b->unit_distance || strcmp(a->colormap, b->colormap) != 0)
        return false;
    for (size_t i = 0; i < a->opacity_count; i++)
        if (a->opacities[i].value != b->opacities[i].value || a->opacities[i].opacity != b->opacities[i].opacity)
            return false;
    return same_colors(a, b);
}

static bool is_fraction(double x)
{
    return x >= 0 && x <= 1;
}

/* Sorting must be stable, since two points at one value are a jump from the first to the second. Points mostly arrive sorted, and
 * insertion is linear then; lists long enough for its square to hurt arrive sorted from a file or not at all. */
#define SORT_POINTS(points, count, type)                                                                                                   \
    for (size_t i_ = 1; i_ < (count); i_++) {                                                                                              \
        type point_ = (points)[i_];                                                                                                        \
        size_t j_ = i_;                                                                                                                    \
        for (; j_ > 0 && (points)[j_ - 1].value > point_.value; j_--)                                                                      \
            (points)[j_] = (points)[j_ - 1];                                                                                               \
        (points)[j_] = point_;                                                                                                             \
    }

enum { MAX_POINTS = 65536 }; /* more points than a table of a curve ever has entries */

static bool check_count(const char *curve, const void *points, size_t count, struct pel_error *error)
{
    if (count < 1 || !points)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s curve: no points; at least one is needed", curve);
    if (count > MAX_POINTS)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s curve: %zu points; at most %d are allowed", curve, count, MAX_POINTS);
    return true;
}

bool pel_transfer_set_colors(struct pel_transfer *transfer, const struct pel_color_point *points, size_t count, struct pel_error *error)
{
    if (!check_count("color", points, count, error))
        return false;
    for (size_t i = 0; i < count; i++) {
        const struct pel_color_point *p = &points[i];
        if (!isfinite(p->value))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "color point %zu: value %g is not finite", i + 1, p->value);
        if (!is_fraction(p->rgb[0]) || !is_fraction(p->rgb[1]) || !is_fraction(p->rgb[2]))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "color point %zu (value %g): color %g,%g,%g is outside 0..1", i + 1, p->value,
                            p->rgb[0], p->rgb[1], p->rgb[2]);
    }
    struct pel_color_point *copy = pel_alloc(count, sizeof *copy, "color curve", error);
    if (!copy)
        return false;
    memcpy(copy, points, count * sizeof *copy);
    SORT_POINTS(copy, count, struct pel_color_point)
    free(transfer->colors);
    transfer->colors = copy;
    transfer->color_count = count;
    transfer->colormap[0] = 0;
    return true;
}

bool pel_transfer_set_opacities(struct pel_transfer *transfer, const struct pel_opacity_point *points, size_t count,
                                struct pel_error *error)
{
    if (!check_count("opacity", points, count, error))
        return false;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(points[i].value))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "opacity point %zu: value %g is not finite", i + 1, points[i].value);
        if (!is_fraction(points[i].opacity))
            return pel_fail(error, PEL_ERROR_ARGUMENT, "opacity point %zu (value %g): opacity %g is outside 0..1", i + 1, points[i].value,
                            points[i].opacity);
    }
    struct pel_opacity_point *copy = pel_alloc(count, sizeof *copy, "opacity curve", error);
    if (!copy)
        return false;
    memcpy(copy, points, count * sizeof *copy);
    SORT_POINTS(copy, count, struct pel_opacity_point)
    free(transfer->opacities);
    transfer->opacities = copy;
    transfer->opacity_count = count;
    return true;
}

bool pel_transfer_set_colormap(struct pel_transfer *transfer, const char *name, double lo, double hi, struct pel_error *error)
{
    const struct pel_colormap *map = pel_colormap_find(name);
    if (!map)
        return pel_colormap_fail_unknown(name, error);
    if (!isfinite(lo) || !isfinite(hi))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "colormap %s: range %g,%g is not finite", name, lo, hi);
    struct pel_color_point *points = pel_alloc(map->count, sizeof *points, "color curve", error);
    if (!points)
        return false;
    for (size_t i = 0; i < map->count; i++) {
        /* Reversed maps are filled from their end, so that the list is sorted already and jumps keep their order. */
        const struct pel_colormap_point *from = &map->points[lo <= hi ? i : map->count - 1 - i];
        points[i].value = lo * (1 - from->t) + hi * from->t;
        for (int c = 0; c < 3; c++)
            points[i].rgb[c] = from->rgb[c];
    }
    bool ok = pel_transfer_set_colors(transfer, points, map->count, error);
    free(points);
    if (ok)
        snprintf(transfer->colormap, sizeof transfer->colormap, "%s", map->name);
    return ok;
}

static const char *skip_space(const char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    return text;
}

/* One "value:opacity" of a list; moves *text past it. */
static bool parse_point(const char **text, const char *whole, struct pel_opacity_point *point, struct pel_error *error)
{
    char *end;
    const char *start = skip_space(*text);
    point->value = strtod(start, &end);
    const char *colon = skip_space(end);
    if (end == start || *colon != ':')
        return pel_fail(error, PEL_ERROR_ARGUMENT, "opacity '%s': expected value:opacity at '%.20s'", whole, start);
    start = skip_space(colon + 1);
    point->opacity = strtod(start, &end);
    if (end == start)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "opacity '%s': expected a number after ':' at '%.20s'", whole, start);
    *text = skip_space(end);
    return true;
}

static bool parse_opacity(struct pel_transfer *transfer, const char *text, struct pel_error *error)
{
    char *end;
    double alone = strtod(text, &end);
    if (end != text && !*skip_space(end))
        return pel_transfer_set_opacities(transfer, &(struct pel_opacity_point) { 0, alone }, 1, error);

    size_t count = 1;
    for (const char *p = text; *p; p++)
        count += *p == ',';
    if (!check_count("opacity", text, count, error))
        return false;
    struct pel_opacity_point *points = pel_alloc(count, sizeof *points, "opacity curve", error);
    if (!points)
        return false;
    const char *at = text;
    bool ok = true;
    for (size_t i = 0; i < count && ok; i++) {
        ok = parse_point(&at, text, &points[i], error);
        char expected = i + 1 < count ? ',' : 0;
        if (ok && *at != expected)
            ok = pel_fail(error, PEL_ERROR_ARGUMENT, "opacity '%s': expected %s at '%.20s'", text, expected ? "a comma" : "the end", at);
        at += ok && expected;
    }
    ok = ok && pel_transfer_set_opacities(transfer, points, count, error);
    free(points);
    return ok;
}

bool pel_transfer_parse_opacity(struct pel_transfer *transfer, const char *text, struct pel_error *error)
{
    const struct pel_c_locale locale = pel_c_locale_begin();
    bool ok = parse_opacity(transfer, text, error);
    pel_c_locale_end(&locale);
    return ok;
}

/* Where `value` lies between a and b (a < b), 0 to 1; also where b - a is beyond the largest double. */
static double fraction_between(double value, double a, double b)
{
    double width = b - a;
    return isfinite(width) ? (value - a) / width : (value / 2 - a / 2) / (b / 2 - a / 2);
}

/* The number of points (a sorted list, `stride` bytes each, value first) at or below `value`. */
static size_t points_up_to(const void *points, size_t count, size_t stride, double value)
{
    size_t first = 0;
    while (count > 0) {
        size_t half = count / 2;
        if (*(const double *)((const char *)points + (first + half) * stride) <= value) {
            first += half + 1;
            count -= half + 1;
        } else {
            count = half;
        }
    }
    return first;
}

double pel_transfer_opacity(const struct pel_transfer *transfer, double value)
{
    if (isnan(value) || !transfer->opacity_count)
        return 0;
    const struct pel_opacity_point *p = transfer->opacities;
    size_t n = points_up_to(p, transfer->opacity_count, sizeof *p, value);
    if (n == 0)
        return p[0].opacity;
    if (n == transfer->opacity_count)
        return p[n - 1].opacity;
    double f = fraction_between(value, p[n - 1].value, p[n].value);
    return p[n - 1].opacity * (1 - f) + p[n].opacity * f;
}

void pel_transfer_color(const struct pel_transfer *transfer, double value, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (isnan(value) || !transfer->color_count)
        return;
    const struct pel_color_point *p = transfer->colors;
    size_t n = points_up_to(p, transfer->color_count, sizeof *p, value);
    const struct pel_color_point *a = &p[n ? n - 1 : 0], *b = &p[n < transfer->color_count ? n : n - 1];
    double f = a == b ? 0 : n == 0 ? 0 : fraction_between(value, a->value, b->value);
    for (int c = 0; c < 3; c++)
        rgb[c] = a->rgb[c] * (1 - f) + b->rgb[c] * f;
}

static double rescaled(double value, double from_lo, double scale, double to_lo)
{
    double r = to_lo + (value - from_lo) * scale;
    return isnan(r) ? to_lo : r > DBL_MAX ? DBL_MAX : r < -DBL_MAX ? -DBL_MAX : r;
}

void pel_transfer_rescale(struct pel_transfer *transfer, double from_lo, double from_hi, double to_lo, double to_hi)
{
    /* An empty range says where the values lie but not how wide they are: move, keep the width. */
    double scale = from_hi != from_lo ? (to_hi - to_lo) / (from_hi - from_lo) : 1;
    for (size_t i = 0; i < transfer->color_count; i++)
        transfer->colors[i].value = rescaled(transfer->colors[i].value, from_lo, scale, to_lo);
    for (size_t i = 0; i < transfer->opacity_count; i++)
        transfer->opacities[i].value = rescaled(transfer->opacities[i].value, from_lo, scale, to_lo);
    if (!(scale < 0))
        return;
    for (size_t i = 0, j = transfer->color_count; i + 1 < j; i++) {
        struct pel_color_point t = transfer->colors[i];
        transfer->colors[i] = transfer->colors[--j];
        transfer->colors[j] = t;
    }
    for (size_t i = 0, j = transfer->opacity_count; i + 1 < j; i++) {
        struct pel_opacity_point t = transfer->opacities[i];
        transfer->opacities[i] = transfer->opacities[--j];
        transfer->opacities[j] = t;
    }
}
