/* SPDX-License-Identifier: MIT */
/* Pictures as bytes: JPEG (libjpeg-turbo) until a picture is finished, then PNG. An encoder keeps its memory from picture to picture. */
#ifndef VIEWER_ENCODE_H
#define VIEWER_ENCODE_H

#include <stddef.h>

#include <pellucid/image.h>

struct encoder;

struct encoder *encoder_create(struct pel_error *error);
void encoder_destroy(struct encoder *encoder); /* accepts NULL */

/* The picture before `background` (RGBA, not premultiplied); `high`: so that nobody sees the loss. The bytes are the encoder's, until its
 * next picture. */
bool encode_jpeg(struct encoder *encoder, const struct pel_image *image, const double background[4], bool high, const void **bytes,
                 size_t *size, struct pel_error *error);
/* 8 bits, sRGB, lossless but for that; zlib level 1, unless `small`. background NULL: alpha is kept. `progress` (nullable) may end it. */
bool encode_png(struct encoder *encoder, const struct pel_image *image, const double *background, bool small,
                const struct pel_progress *progress, const void **bytes, size_t *size, struct pel_error *error);

/* The picture as bytes RGBX (or RGBA, unassociated, where background is NULL): 4 * width * height, the encoder's. NULL on failure. */
const unsigned char *encoder_pixels(struct encoder *encoder, const struct pel_image *image, const double *background,
                                    struct pel_error *error);

#endif
