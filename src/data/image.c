/* SPDX-License-Identifier: MIT */
/* Image storage, and the one place where pictures are compared. */
#include <pellucid/image.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"

void pel_image_init(struct pel_image *image)
{
    *image = (struct pel_image){ 0 };
}

void pel_image_finish(struct pel_image *image)
{
    free(image->rgba);
    free(image->depth);
    pel_image_init(image);
}

bool pel_image_allocate(struct pel_image *image, int width, int height, bool with_depth, struct pel_error *error)
{
    if (width < 1 || height < 1 || width > PEL_IMAGE_MAX || height > PEL_IMAGE_MAX)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a picture of %d x %d pixels; each side must be 1 to %d", width, height, PEL_IMAGE_MAX);
    size_t pixels = (size_t)width * (size_t)height;
    bool same = image->rgba && image->width == width && image->height == height;
    float *rgba = same ? image->rgba : pel_alloc(pixels, 4 * sizeof *rgba, "picture", error);
    float *depth = !with_depth ? NULL : same && image->depth ? image->depth : pel_alloc(pixels, sizeof *depth, "depth", error);
    if (!rgba || (with_depth && !depth)) {
        if (rgba != image->rgba)
            free(rgba);
        if (depth != image->depth)
            free(depth);
        return false;
    }
    if (same)
        memset(rgba, 0, pixels * 4 * sizeof *rgba);
    else
        free(image->rgba);
    if (depth != image->depth)
        free(image->depth);
    for (size_t i = 0; depth && i < pixels; i++)
        depth[i] = INFINITY;
    *image = (struct pel_image){ .width = width, .height = height, .rgba = rgba, .depth = depth };
    return true;
}

/* ---- comparison ---- */

static double clamp01(float x)
{
    return x >= 1 ? 1 : x > 0 ? (double)x : 0;
}

/* NaN against a number is as different as can be. */
static double difference(float a, float b)
{
    if (isnan(a) || isnan(b))
        return isnan(a) && isnan(b) ? 0 : 1;
    return fabs(clamp01(a) - clamp01(b));
}

static void compare_pixels(const struct pel_image *a, const struct pel_image *b, struct pel_metrics *metrics)
{
    double total = 0;
    metrics->max_error = 0;
    metrics->differing_pixels = 0;
    for (int y = 0; y < a->height; y++) {
        double row = 0; /* summed by rows, so that small differences in large pictures are not lost */
        for (int x = 0; x < a->width; x++) {
            size_t i = 4 * ((size_t)y * (size_t)a->width + (size_t)x);
            double most = 0;
            for (int c = 0; c < 4; c++) {
                double d = difference(a->rgba[i + (size_t)c], b->rgba[i + (size_t)c]);
                row += d * d;
                most = fmax(most, d);
            }
            metrics->max_error = fmax(metrics->max_error, most);
            metrics->differing_pixels += most > 0.1;
        }
        total += row;
    }
    double mean = total / (4.0 * a->width * a->height);
    metrics->psnr = mean > 0 ? 10 * log10(1 / mean) : INFINITY;
}

/* Structural similarity after Wang, Bovik, Sheikh, Simoncelli: Image Quality Assessment: From Error Visibility to Structural Similarity,
 * 2004. Only windows that lie wholly inside count, as in the authors' program; a picture narrower than the window shrinks it. The Gaussian
 * is separable: rows are filtered as they come into a ring of as many rows as the window is high, then the ring is filtered downwards. */
enum { MEAN_A, MEAN_B, SQUARE_A, SQUARE_B, PRODUCT, MOMENTS };
#define WINDOW 11

static int make_window(int length, double weights[WINDOW])
{
    int taps = length >= WINDOW ? WINDOW : length % 2 ? length : length - 1;
    double sum = 0;
    if (taps < 1)
        taps = 1;
    for (int i = 0; i < taps; i++) {
        double d = i - taps / 2;
        sum += weights[i] = exp(-d * d / (2 * 1.5 * 1.5));
    }
    for (int i = 0; i < taps; i++)
        weights[i] /= sum;
    return taps;
}

static double luma(const float *rgba)
{
    return 0.299 * clamp01(rgba[0]) + 0.587 * clamp01(rgba[1]) + 0.114 * clamp01(rgba[2]);
}

/* Moments of one row, filtered along it. `lines` holds the two rows' luma. */
static void filter_row(const struct pel_image *a, const struct pel_image *b, int y, const double *weights, int taps, double *lines,
                       double *out)
{
    int width = a->width, valid = width - taps + 1;
    double *la = lines, *lb = lines + width;
    for (int x = 0; x < width; x++) {
        size_t i = 4 * ((size_t)y * (size_t)width + (size_t)x);
        la[x] = luma(a->rgba + i);
        lb[x] = luma(b->rgba + i);
    }
    for (int x = 0; x < valid; x++) {
        double m[MOMENTS] = { 0 };
        for (int k = 0; k < taps; k++) {
            double va = la[x + k], vb = lb[x + k], w = weights[k];
            m[MEAN_A] += w * va;
            m[MEAN_B] += w * vb;
            m[SQUARE_A] += w * va * va;
            m[SQUARE_B] += w * vb * vb;
            m[PRODUCT] += w * va * vb;
        }
        memcpy(out + (size_t)x * MOMENTS, m, sizeof m);
    }
}

static double similarity(const double m[MOMENTS])
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double aa = m[MEAN_A] * m[MEAN_A], bb = m[MEAN_B] * m[MEAN_B], ab = m[MEAN_A] * m[MEAN_B];
    double va = m[SQUARE_A] - aa, vb = m[SQUARE_B] - bb, cov = m[PRODUCT] - ab;
    return (2 * ab + c1) * (2 * cov + c2) / ((aa + bb + c1) * (va + vb + c2));
}

static bool compute_ssim(const struct pel_image *a, const struct pel_image *b, double *ssim, struct pel_error *error)
{
    double across[WINDOW], down[WINDOW], total = 0;
    int taps_x = make_window(a->width, across), taps_y = make_window(a->height, down);
    size_t valid = (size_t)(a->width - taps_x + 1), row = valid * MOMENTS;
    double *lines = pel_alloc(2 * (size_t)a->width, sizeof *lines, "comparison", error);
    double *ring = pel_alloc(row * (size_t)taps_y, sizeof *ring, "comparison", error);
    bool good = lines && ring;
    for (int y = 0; good && y < a->height; y++) {
        filter_row(a, b, y, across, taps_x, lines, ring + row * (size_t)(y % taps_y));
        if (y + 1 < taps_y)
            continue;
        double sum = 0;
        for (size_t x = 0; x < valid; x++) {
            double m[MOMENTS] = { 0 };
            for (int k = 0; k < taps_y; k++) {
                const double *from = ring + row * (size_t)((y - taps_y + 1 + k) % taps_y) + x * MOMENTS;
                for (int i = 0; i < MOMENTS; i++)
                    m[i] += down[k] * from[i];
            }
            sum += similarity(m);
        }
        total += sum;
    }
    *ssim = total / ((double)valid * (a->height - taps_y + 1));
    free(lines);
    free(ring);
    return good;
}

bool pel_image_compare(const struct pel_image *a, const struct pel_image *b, struct pel_metrics *metrics, struct pel_error *error)
{
    if (!a->rgba || !b->rgba)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "one of the pictures is empty");
    if (a->width != b->width || a->height != b->height)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the pictures differ in size: %d x %d and %d x %d", a->width, a->height, b->width,
                        b->height);
    compare_pixels(a, b, metrics);
    return compute_ssim(a, b, &metrics->ssim, error);
}
