/* SPDX-License-Identifier: MIT */
/* The parts of picture input and output. Messages name no path; image_file.c puts it in front. */
#ifndef PEL_IO_IMAGE_IO_H
#define PEL_IO_IMAGE_IO_H

#include <stdio.h>

#include <pellucid/io.h>

#include "safe_file.h"

bool pel_png_write(FILE *file, const struct pel_image *image, const struct pel_image_write_params *params, struct pel_error *error);
bool pel_png_read(const char *path, struct pel_image *image, struct pel_error *error);

/* A float32 NRRD of `channels` numbers a pixel: axes (channel, x, y), or (x, y) for one. */
bool pel_nrrd_write_pixels(struct pel_safe_file *out, const float *pixels, int width, int height, int channels, const char *name,
                           struct pel_error *error);
bool pel_nrrd_read_image(const char *path, struct pel_image *image, struct pel_error *error);

#endif
