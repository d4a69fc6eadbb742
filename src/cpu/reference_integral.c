/* SPDX-License-Identifier: MIT */
/* Preintegrated classification (docs/optics.md, "Classification"): the integrals over values
 *
 *     T(v) = integral of tau,    K(v) = integral of tau x colour,    tau = -ln(1 - opacity) / unit distance,
 *
 * piece by piece between the points of the two curves, where opacity and colour are straight lines and the integrals have a closed
 * form. Whole pieces are summed once; the parts of pieces at both ends of an interval are integrated where they are asked for, so no
 * difference of two nearly equal sums is ever taken. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "reference_parts.h"

/* With u = 1 - opacity going straight from a to b as x goes from 0 to 1: m[0] = integral of -ln u, m[1] = integral of -ln u x. */
static void moments(double a, double b, double m[2])
{
    a = fmax(a, 0x1p-24), b = fmax(b, 0x1p-24); /* opacity is held below 1 */
    if (fabs(a - b) > 0.5 * fmax(a, b)) {
        /* The antiderivatives of ln u and u ln u are u ln u - u and u^2/2 ln u - u^2/4; x = (a - u) / (a - b). */
        double d = a - b, first = (a * log(a) - a) - (b * log(b) - b);
        double second = (a * a / 2 * log(a) - a * a / 4) - (b * b / 2 * log(b) - b * b / 4);
        m[0] = -first / d;
        m[1] = -(a * first - second) / (d * d);
        return;
    }
    /* They cancel where a and b are near; there ln u is smooth, and eight Gauss-Legendre points give 12 digits. */
    static const double node[4] = { 0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363 };
    static const double weight[4] = { 0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763 };
    m[0] = m[1] = 0;
    for (int i = 0; i < 8; i++) {
        double x = 0.5 + (i & 1 ? 0.5 : -0.5) * node[i / 2], f = -0.5 * weight[i / 2] * log(a + (b - a) * x);
        m[0] += f;
        m[1] += f * x;
    }
}

/* Adds the integrals over [lo, hi], which lies within a piece, to t and k. */
static void integrate_part(const struct pel_reference_piece *piece, double unit, double lo, double hi, double *t, double k[3])
{
    double width = piece->value[1] - piece->value[0], m[2];
    double x = (lo - piece->value[0]) / width, y = (hi - piece->value[0]) / width, slope = piece->opacity[1] - piece->opacity[0];
    moments(1 - (piece->opacity[0] + slope * x), 1 - (piece->opacity[0] + slope * y), m);
    *t += (hi - lo) * m[0] / unit;
    for (int c = 0; c < 3; c++) {
        double rise = piece->color[1][c] - piece->color[0][c];
        k[c] += (hi - lo) * ((piece->color[0][c] + rise * x) * m[0] + rise * (y - x) * m[1]) / unit;
    }
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* What the curves come to from below at v: at a jump, its first point. */
static double opacity_below(const struct pel_transfer *transfer, double v)
{
    for (size_t i = 0; i < transfer->opacity_count; i++)
        if (transfer->opacities[i].value == v)
            return transfer->opacities[i].opacity;
    return pel_transfer_opacity(transfer, v);
}

static void color_below(const struct pel_transfer *transfer, double v, double rgb[3])
{
    pel_transfer_color(transfer, v, rgb);
    for (size_t i = transfer->color_count; i-- > 0;)
        if (transfer->colors[i].value == v)
            memcpy(rgb, transfer->colors[i].rgb, sizeof transfer->colors[i].rgb);
}

/* The piece between two neighbouring points, in display colours. */
static struct pel_reference_piece make_piece(const struct pel_transfer *transfer, double from, double to)
{
    struct pel_reference_piece piece = { .value = { from, to } };
    piece.opacity[0] = pel_transfer_opacity(transfer, from);
    piece.opacity[1] = opacity_below(transfer, to);
    pel_transfer_color(transfer, from, piece.color[0]);
    color_below(transfer, to, piece.color[1]);
    return piece;
}

/* Decoded from sRGB a straight line of colour is bent: so many straight parts stay within 1e-7 of it. */
static size_t parts_needed(const struct pel_reference_piece *piece, bool linear_light)
{
    double rise = 0;
    for (int c = 0; c < 3; c++)
        rise = fmax(rise, fabs(piece->color[1][c] - piece->color[0][c]));
    return linear_light ? 1 + (size_t)(2048 * rise) : 1;
}

/* Part `i` of `n` of a piece, decoded if asked. */
static struct pel_reference_piece cut(const struct pel_reference_piece *piece, size_t i, size_t n, bool linear_light)
{
    struct pel_reference_piece part = *piece;
    for (int end = 0; end < 2; end++) {
        double x = (double)(i + (size_t)end) / (double)n;
        if (n > 1) {
            part.value[end] = piece->value[0] * (1 - x) + piece->value[1] * x;
            part.opacity[end] = piece->opacity[0] * (1 - x) + piece->opacity[1] * x;
        }
        for (int c = 0; c < 3; c++) {
            double display = n > 1 ? piece->color[0][c] * (1 - x) + piece->color[1][c] * x : piece->color[end][c];
            part.color[end][c] = linear_light ? pel_reference_decode(display) : display;
        }
    }
    return part;
}

/* Sums the whole pieces between the first and the last, which reach to the ends of the numbers and are never whole. */
static void accumulate(struct pel_reference_integral *integral)
{
    double t = 0, k[3] = { 0, 0, 0 };
    for (size_t i = 0; i < integral->count; i++) {
        struct pel_reference_piece *piece = &integral->pieces[i];
        piece->t = t;
        memcpy(piece->k, k, sizeof k);
        if (i > 0 && i + 1 < integral->count)
            integrate_part(piece, integral->transfer->unit_distance, piece->value[0], piece->value[1], &t, k);
    }
}

bool pel_reference_integral_init(struct pel_reference_integral *integral, const struct pel_transfer *transfer, bool linear_light,
                                 struct pel_error *error)
{
    *integral = (struct pel_reference_integral){ .transfer = transfer, .linear_light = linear_light };
    bool done = false;
    size_t points = 0, total = 0;
    double *at = pel_alloc(transfer->color_count + transfer->opacity_count + 2, sizeof *at, "curve points", error);
    if (!at)
        return false;
    at[points++] = -DBL_MAX / 4;
    for (size_t i = 0; i < transfer->color_count; i++)
        at[points++] = transfer->colors[i].value;
    for (size_t i = 0; i < transfer->opacity_count; i++)
        at[points++] = transfer->opacities[i].value;
    at[points++] = DBL_MAX / 4;
    qsort(at, points, sizeof *at, compare_doubles);
    for (size_t i = 0; i + 1 < points; i++)
        if (at[i] < at[i + 1]) {
            struct pel_reference_piece piece = make_piece(transfer, at[i], at[i + 1]);
            total += parts_needed(&piece, linear_light);
        }
    integral->pieces = pel_alloc(total, sizeof *integral->pieces, "transfer function's integral", error);
    if (!integral->pieces)
        goto cleanup;
    for (size_t i = 0; i + 1 < points; i++)
        if (at[i] < at[i + 1]) {
            struct pel_reference_piece piece = make_piece(transfer, at[i], at[i + 1]);
            size_t n = parts_needed(&piece, linear_light);
            for (size_t part = 0; part < n; part++)
                integral->pieces[integral->count++] = cut(&piece, part, n, linear_light);
        }
    accumulate(integral);
    done = true;
cleanup:
    free(at);
    return done;
}

void pel_reference_integral_finish(struct pel_reference_integral *integral)
{
    free(integral->pieces);
    integral->pieces = NULL;
    integral->count = 0;
}

/* The piece that a value lies in: the last that begins at or below it. */
static size_t find_piece(const struct pel_reference_integral *integral, double value)
{
    size_t lo = 0, hi = integral->count;
    while (hi - lo > 1) {
        size_t middle = lo + (hi - lo) / 2;
        if (integral->pieces[middle].value[0] <= value)
            lo = middle;
        else
            hi = middle;
    }
    return lo;
}

void pel_reference_integrate(const struct pel_reference_integral *integral, double f, double g, double *extinction, double rgb[3])
{
    double unit = integral->transfer->unit_distance, lo = fmin(f, g), hi = fmax(f, g), t = 0, k[3] = { 0, 0, 0 };
    if (lo == hi) {
        *extinction = pel_reference_extinction(pel_transfer_opacity(integral->transfer, f), unit);
        pel_reference_color(integral->transfer, integral->linear_light, f, rgb);
        return;
    }
    size_t first = find_piece(integral, lo), last = find_piece(integral, hi);
    const struct pel_reference_piece *from = &integral->pieces[first], *to = &integral->pieces[last];
    if (first == last) {
        integrate_part(from, unit, lo, hi, &t, k);
    } else {
        t = to->t - from[1].t;
        for (int c = 0; c < 3; c++)
            k[c] = to->k[c] - from[1].k[c];
        integrate_part(from, unit, lo, from->value[1], &t, k);
        integrate_part(to, unit, to->value[0], hi, &t, k);
    }
    *extinction = t / (hi - lo);
    for (int c = 0; c < 3; c++)
        rgb[c] = t > 0 ? k[c] / t : 0;
}
