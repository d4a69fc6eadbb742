/* SPDX-License-Identifier: MIT */
/* Image: RGBA, premultiplied, float32, sRGB display values; depth beside it. Row 0 is the top. 8 bits only at the writer. */
#ifndef PELLUCID_IMAGE_H
#define PELLUCID_IMAGE_H

#include <pellucid/error.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct pel_image {
    int width, height; /* pixels, 1 to PEL_IMAGE_MAX each */
    float *rgba;       /* owned; 4 * width * height, premultiplied by alpha, 0 to 1 */
    float *depth;      /* owned or NULL; width * height world distances along the ray; +inf where nothing was met */
};

#define PEL_IMAGE_MAX 32768

/* An empty image; finish accepts it. */
void pel_image_init(struct pel_image *image);
/* Gives it pixels: transparent black, depth (if asked for) +inf. What it held before is freed, or reused where the size is the same. */
bool pel_image_allocate(struct pel_image *image, int width, int height, bool with_depth, struct pel_error *error);
void pel_image_finish(struct pel_image *image);

/* How alike two pictures are, over the RGBA values (clamped to 0..1) of all pixels. */
struct pel_metrics {
    double psnr;                /* 10 log10(1 / mean square error), dB; +inf where equal */
    double
        ssim; /* mean structural similarity of the luma (Wang et al. 2004: 11x11 Gaussian, sigma 1.5), alpha premultiplied; 1 where equal */
    double max_error;           /* greatest difference of any channel, 0 to 1 */
    long differing_pixels;      /* pixels with a channel that differs by more than 0.1 */
};
/* Fails with PEL_ERROR_ARGUMENT where the sizes differ. */
bool pel_image_compare(const struct pel_image *a, const struct pel_image *b, struct pel_metrics *metrics, struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
