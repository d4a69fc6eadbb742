/* SPDX-License-Identifier: MIT */
/* What tests on a device share: the device (skipped, loudly, where none is usable), drawing with it, and scenes that have something of
 * everything. */
#ifndef PEL_TESTS_ON_DEVICE_H
#define PEL_TESTS_ON_DEVICE_H

#include "../image/pictures.h"

#define WIDTH 61
#define HEIGHT 47

extern struct pel_device *device;

int open_device(void **state);
int close_device(void **state);
void need_device(void);

struct pel_renderer *gpu_renderer(void);
void draw_gpu(struct pel_renderer *renderer, const struct pel_scene *scene, int width, int height, struct pel_image *image);

/* PSNR of at least 45 dB against the CPU engine at the same step. */
void check_against_cpu(struct pel_renderer *renderer, const struct pel_scene *scene, const char *what);

/* A ball in waves; the same with voids in it. */
double blob(const double index[3]);
double holed(const double index[3]);

/* A volume of 29 x 25 x 27 voxels, turned and with unequal spacing, and its scene. */
void make_typed(struct pel_volume *volume, struct pel_scene *scene, enum pel_type type, formula *f);
/* A volume as large as you like, with the same in it. */
void make_sized(struct pel_volume *volume, struct pel_scene *scene, const size_t dims[3], enum pel_type type, formula *f);

/* A plane and a box that cut into the volume. */
void clip(struct pel_scene *scene);

#endif
