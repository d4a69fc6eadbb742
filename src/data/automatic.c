/* SPDX-License-Identifier: MIT */
/* Transfer functions that show what is in a volume without being asked twice. survey.c says where the object's values lie; here they
 * get colours and opacities, by three rules:
 *   - background and noise are clear;
 *   - what is common is translucent and what is rare is dense (flesh hides bone, bone does not hide flesh), scaled to the object's size, so
 *     that a ray through the object is neither empty nor stopped at once;
 *   - values that lie on boundaries (great mean gradient) are denser than those inside a material, so that surfaces show. */
#include <pellucid/transfer.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "label_transfer.h"
#include "samples.h"
#include "survey.h"

enum { KNOTS = 33 };

static double clamp01(double x)
{
    return x > 0 ? x < 1 ? x : 1 : 0;
}

/* Opacity of the object's values from the threshold to the top. */
static void object_opacities(const struct pel_survey *s, struct pel_opacity_point points[KNOTS])
{
    int first = pel_survey_bin(s, s->threshold);
    double base = fmin(1 - exp(-(s->kind == PEL_SURVEY_MATERIALS ? 4.6 : 2.3) / s->extent), 0.3), dense = 0.5, total = 0, below = 0;
    double common = s->kind == PEL_SURVEY_MATERIALS ? 0.6 : 0.4;
    if (s->kind != PEL_SURVEY_FULL) { /* a material that fills the box is rather a fog around what is rare */
        double crowded = clamp01((s->fill - 0.5) / 0.25);
        base *= 1 - 0.85 * crowded;
        common += (0.92 - common) * crowded;
    }
    for (int i = first; i < s->bins; i++)
        total += s->count[i];
    for (int k = 0, bin = first; k < KNOTS; k++) {
        double value = s->threshold + (s->top - s->threshold) * k / (KNOTS - 1);
        for (; bin < s->bins && pel_survey_value(s, bin) < value; bin++)
            below += s->count[bin];
        double rank = total > 0 ? below / total : 0, rare = clamp01((rank - common) / (1 - common));
        double rise = clamp01((value - s->threshold) / (s->isovalue - s->threshold));
        double inside = s->kind == PEL_SURVEY_MATERIALS ? 0.2 + 0.8 * s->gradient[pel_survey_bin(s, value)] : 1;
        double edge = inside + (1 - inside) * rare * rare; /* what is rare has small parts: nearly all of it is boundary */
        points[k].value = value;
        points[k].opacity = clamp01(rise * (base + (dense - base) * rare * sqrt(rare)) * edge);
    }
    points[0].opacity = 0;
}

/* Both sides of the background, mirrored, as deep as the longer side goes. */
static bool composite_signed(struct pel_transfer *transfer, const struct pel_survey *s, struct pel_error *error)
{
    double zero = s->background, near = s->threshold - zero, iso = s->isovalue - zero, far = fmax(fmax(s->top - zero, zero - s->lo), iso);
    double base = fmin(1 - exp(-4.6 / s->extent), 0.3);
    struct pel_opacity_point points[] = { { zero - far, 0.5 }, { zero - iso, base }, { zero - near, 0 },
                                          { zero + near, 0 },  { zero + iso, base }, { zero + far, 0.5 } };
    return pel_transfer_set_colormap(transfer, "coolwarm", zero - far, zero + far, error) &&
           pel_transfer_set_opacities(transfer, points, 6, error);
}

/* Cuts the colours off below a value, and leaves those above as they are: nothing is told of values that there are none of. */
static void begin_colors(struct pel_transfer *transfer, double value)
{
    struct pel_color_point first = { .value = value };
    size_t below = 0;
    pel_transfer_color(transfer, value, first.rgb);
    while (below < transfer->color_count && transfer->colors[below].value < value)
        below++;
    if (below == 0)
        return;
    transfer->colors[below - 1] = first;
    transfer->color_count -= below - 1;
    memmove(transfer->colors, transfer->colors + below - 1, transfer->color_count * sizeof first);
}

static bool composite(struct pel_transfer *transfer, const struct pel_volume *volume, const struct pel_survey *s, struct pel_error *error)
{
    struct pel_opacity_point points[KNOTS] = { { s->lo, 0.05 } };
    switch (s->kind) {
    case PEL_SURVEY_EMPTY: /* nothing to tell apart: a faint box */
        return pel_transfer_set_colormap(transfer, "gray", s->lo - 1, s->lo + 1, error) &&
               pel_transfer_set_opacities(transfer, points, 1, error);
    case PEL_SURVEY_SIGNED:
        return composite_signed(transfer, s, error);
    case PEL_SURVEY_MATERIALS:
        object_opacities(s, points);
        return pel_transfer_set_colormap(transfer, "ct", s->threshold, s->top, error) &&
               pel_transfer_set_opacities(transfer, points, KNOTS, error);
    case PEL_SURVEY_FIELD:
    case PEL_SURVEY_FULL:
        break;
    }
    /* The map begins below the threshold, since its darkest colours would not be seen on a dark background, and ends before the few
     * greatest values, which would take most of it. */
    object_opacities(s, points);
    if (!pel_transfer_set_colormap(transfer, "plasma", s->threshold - 0.3 * (s->common - s->threshold), s->common, error))
        return false;
    begin_colors(transfer, volume->range[0]);
    return pel_transfer_set_opacities(transfer, points, KNOTS, error);
}

/* Gray from lo to hi. The opacity rises fast: the gray alone should tell the value, not its square. */
static bool window(struct pel_transfer *transfer, double lo, double hi, struct pel_error *error)
{
    struct pel_opacity_point points[] = { { lo, 0 }, { lo * 0.75 + hi * 0.25, 1 } };
    return pel_transfer_set_colormap(transfer, "gray", lo, hi, error) && pel_transfer_set_opacities(transfer, points, 2, error);
}

static double window_start(const struct pel_survey *s)
{
    return s->kind == PEL_SURVEY_SIGNED ? s->lo : s->background;
}

static bool opaque(struct pel_transfer *transfer, const struct pel_survey *s, struct pel_error *error)
{
    bool flat = s->kind == PEL_SURVEY_EMPTY;
    double lo = flat ? s->lo - 1 : fmin(s->background, s->lo), hi = flat ? s->lo + 1 : s->top;
    struct pel_opacity_point points[] = { { lo, 1 } };
    return pel_transfer_set_colormap(transfer, "gray", lo, hi, error) && pel_transfer_set_opacities(transfer, points, 1, error);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sum of (value - background) / (top - background), held to 0..1, along each of a grid of rays in y: the third quartile of those that meet
 * anything, in samples. 0 where nothing is met. */
static double typical_depth(const struct pel_volume *volume, const struct pel_survey *s)
{
    enum { RAYS = 48 };
    bool met[RAYS * RAYS] = { false };
    size_t nx = volume->dims[0], ny = volume->dims[1], nz = volume->dims[2], found = 0;
    double *sums = calloc(RAYS * RAYS + nx, sizeof *sums), *row = sums ? sums + RAYS * RAYS : NULL, result = 0;
    if (!sums)
        return 0;
    for (size_t k = 0; k < RAYS; k++)
        for (size_t y = 0; y < ny; y++) {
            pel_samples_load(volume, ((2 * k + 1) * nz / (2 * RAYS) * ny + y) * nx, nx, row);
            for (size_t i = 0; i < RAYS; i++) {
                double value = row[(2 * i + 1) * nx / (2 * RAYS)];
                if (value > s->threshold) /* not NaN, and not noise */
                    sums[k * RAYS + i] += fmin((value - s->background) / (s->top - s->background), 1);
                met[k * RAYS + i] |= value > s->isovalue;
            }
        }
    for (size_t i = 0; i < RAYS * RAYS; i++)
        if (met[i])
            sums[found++] = sums[i];
    if (found > 0) {
        qsort(sums, found, sizeof *sums, by_value);
        result = sums[found * 3 / 4] * volume->spacing[1] / pel_volume_mean_spacing(volume);
    }
    free(sums);
    return result;
}

/* Extinction proportional to the value above the background; the object's thicker rays let exp(-1.2) through. */
static bool xray(struct pel_transfer *transfer, const struct pel_volume *volume, const struct pel_survey *s, struct pel_error *error)
{
    enum { STEPS = 17 };
    struct pel_opacity_point points[STEPS];
    double depth = typical_depth(volume, s), tau = depth > 0 ? fmin(1.2 / depth, 8) : 0.01;
    if (s->kind == PEL_SURVEY_EMPTY) { /* one value everywhere: all of it is the object */
        depth = (double)volume->dims[1] * volume->spacing[1] / pel_volume_mean_spacing(volume);
        points[0] = (struct pel_opacity_point) { s->background, 1 - exp(-1.2 / depth) };
        return pel_transfer_set_colormap(transfer, "gray", s->background, s->top, error) &&
               pel_transfer_set_opacities(transfer, points, 1, error);
    }
    for (int i = 0; i < STEPS; i++) {
        double f = (double)i / (STEPS - 1);
        points[i].value = s->background * (1 - f) + s->top * f;
        points[i].opacity = 1 - exp(-tau * f);
    }
    return pel_transfer_set_colormap(transfer, "gray", s->background, s->top, error) &&
           pel_transfer_set_opacities(transfer, points, STEPS, error);
}

/* A ray's mean is diluted by the background that it crosses. */
static bool average(struct pel_transfer *transfer, const struct pel_volume *volume, const struct pel_survey *s, struct pel_error *error)
{
    double length = (double)volume->dims[1] * volume->spacing[1] / pel_volume_mean_spacing(volume);
    double part = fmin(1.5 * typical_depth(volume, s) / length, 1), lo = window_start(s);
    return window(transfer, lo, part > 1e-6 ? lo + (s->top - lo) * part : s->top, error);
}

bool pel_transfer_automatic(struct pel_transfer *transfer, const struct pel_volume *volume, enum pel_transfer_purpose purpose,
                            struct pel_error *error)
{
    struct pel_survey survey;
    bool ok = false;
    if (volume->labels && purpose != PEL_TRANSFER_XRAY && purpose != PEL_TRANSFER_AVERAGE) {
        ok = pel_label_transfer(transfer, volume, purpose != PEL_TRANSFER_COMPOSITE, error);
    } else {
        pel_survey_volume(volume, &survey);
        switch (purpose) {
        case PEL_TRANSFER_COMPOSITE:
            ok = composite(transfer, volume, &survey, error);
            break;
        case PEL_TRANSFER_PROJECTION:
            ok = window(transfer, window_start(&survey), survey.top, error);
            break;
        case PEL_TRANSFER_AVERAGE:
            ok = average(transfer, volume, &survey, error);
            break;
        case PEL_TRANSFER_OPAQUE:
            ok = opaque(transfer, &survey, error);
            break;
        case PEL_TRANSFER_XRAY:
            ok = xray(transfer, volume, &survey, error);
            break;
        }
    }
    if (ok)
        transfer->unit_distance = pel_volume_mean_spacing(volume);
    return ok;
}

double pel_isovalue_automatic(const struct pel_volume *volume)
{
    struct pel_survey survey;
    if (volume->labels && isfinite(volume->range[0]))
        return volume->range[0] + 0.5; /* around everything that has a name */
    pel_survey_volume(volume, &survey);
    return survey.isovalue;
}
