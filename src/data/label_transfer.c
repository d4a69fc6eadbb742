/* SPDX-License-Identifier: MIT */
/* Labels name things, so their colours must tell them apart and their order means nothing: hues step by the golden angle, which puts any
 * number of them well apart, in three shades. The background is label 0, or without one the label of most voxels. */
#include "label_transfer.h"

#include <math.h>
#include <stdlib.h>

#include <pellucid/statistics.h>

#include "alloc.h"
#include "fail.h"

enum { MAX_LABEL_BINS = 65536, MAX_LABELS = 4096 };

/* Hue, saturation and value, each 0 to 1. */
static void from_hsv(double h, double s, double v, double rgb[3])
{
    for (int c = 0; c < 3; c++) {
        double k = fmod(5 - 2 * c + h * 6, 6), m = fmin(fmin(k, 4 - k), 1);
        rgb[c] = v - v * s * (m > 0 ? m : 0);
    }
}

static void label_color(size_t index, double rgb[3])
{
    static const double shades[3][2] = { { 0.6, 1 }, { 0.8, 0.85 }, { 0.35, 0.95 } };
    from_hsv(fmod(0.09 + 0.61803398875 * (double)index, 1), shades[index % 3][0], shades[index % 3][1], rgb);
}

static size_t find_background(const struct pel_histogram *h)
{
    size_t zero = h->lo < 0 && h->hi > 0 ? (size_t)(-h->lo / (h->hi - h->lo) * (double)h->count) : h->count;
    if (zero < h->count && h->bins[zero] > 0)
        return zero;
    size_t most = 0;
    for (size_t i = 0; i < h->count; i++)
        most = h->bins[i] > h->bins[most] ? i : most;
    return most;
}

/* Two points a label: its colour from half a step below to half a step above. */
static bool set_points(struct pel_transfer *transfer, const struct pel_histogram *h, bool opaque, struct pel_error *error)
{
    size_t background = find_background(h), labels = 0, n = 0;
    for (size_t i = 0; i < h->count; i++)
        labels += h->bins[i] > 0;
    if (labels < 1 || labels > MAX_LABELS)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%zu labels: more than the %d that can be told apart", labels, MAX_LABELS);
    struct pel_color_point *colors = pel_alloc(2 * labels, sizeof *colors, "label colors", error);
    struct pel_opacity_point *opacities = colors ? pel_alloc(2 * labels, sizeof *opacities, "label opacities", error) : NULL;
    double width = (h->hi - h->lo) / (double)h->count;
    for (size_t i = 0, index = 0; opacities && i < h->count; i++) {
        if (!h->bins[i])
            continue;
        double rgb[3] = { 0, 0, 0 }, opacity = fmin(fmax(8 / cbrt((double)h->bins[i]), 0.05), 0.8);
        if (i != background)
            label_color(index++, rgb);
        else
            opacity = 0;
        for (int side = 0; side < 2; side++, n++) {
            double value = h->lo + width * (double)(i + (size_t)side);
            colors[n] = (struct pel_color_point) { value, { rgb[0], rgb[1], rgb[2] } };
            opacities[n] = (struct pel_opacity_point) { value, opaque ? 1 : opacity };
        }
    }
    bool ok = opacities && pel_transfer_set_colors(transfer, colors, n, error) && pel_transfer_set_opacities(transfer, opacities, n, error);
    free(colors);
    free(opacities);
    return ok;
}

bool pel_label_transfer(struct pel_transfer *transfer, const struct pel_volume *volume, bool opaque, struct pel_error *error)
{
    double lo = volume->range[0], hi = volume->range[1];
    if (!(lo <= hi)) /* every sample is void */
        lo = hi = 0;
    if (ceil(lo) > floor(hi)) /* no whole number between: fractions that somebody calls labels */
        lo = hi = floor(lo);
    double values = floor(hi) - ceil(lo) + 1, width = ceil(values / MAX_LABEL_BINS);
    struct pel_histogram h;
    lo = ceil(lo) - 0.5;
    if (!pel_histogram_init(&h, volume, lo, lo + ceil(values / width) * width, (size_t)ceil(values / width), false, error))
        return false;
    if (!(volume->range[0] <= volume->range[1]) || (h.count == 1 && !h.bins[0]))
        h.bins[0] = 1;
    bool ok = set_points(transfer, &h, opaque, error);
    pel_histogram_finish(&h);
    return ok;
}
