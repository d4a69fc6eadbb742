/* SPDX-License-Identifier: MIT */
/* What techniques on the GPU share about a frame: how long its stages took, and the way of the picture to the host. */
#ifndef PEL_RENDER_GPU_FRAME_H
#define PEL_RENDER_GPU_FRAME_H

#include "objects.h"
#include "technique.h"

/* A part of a frame, timed by the wall's clock and, where it runs once a frame and not in software, by the GPU's. */
struct pel_gpu_stage {
    struct pel_gpu_timer timer;
    double milliseconds;
    int runs;
};

void pel_gpu_stages_clear(struct pel_gpu_stage *stages, int count); /* at the beginning of a frame */
void pel_gpu_stage_begin(struct pel_device *device, struct pel_gpu_stage *stage, const char *name);
/* Software does its work when it is waited for, and its timers tell little: there the stage is waited for. */
void pel_gpu_stage_end(struct pel_device *device, struct pel_gpu_stage *stage);
void pel_gpu_stage_note(const struct pel_device *device, struct pel_gpu_stage *stage, const struct pel_frame *frame,
                        const char *name); /* nothing where it did not run */
void pel_gpu_stages_destroy(struct pel_device *device, struct pel_gpu_stage *stages, int count);

/* Can the device draw so large a picture? If not, what to do `instead` ("; use --device cpu", or nothing) ends the error. */
bool pel_gpu_check_picture(const struct pel_device *device, const struct pel_image *image, const char *instead, struct pel_error *error);

/* Copies the picture, and the depth if the image has one, from textures of the image's size. */
bool pel_gpu_read_back(struct pel_device *device, const struct pel_texture *picture, const struct pel_texture *depth,
                       struct pel_image *image, struct pel_error *error);

#endif
