/* SPDX-License-Identifier: MIT */
/* Ray casting on the GPU engine: the frame of the CPU engine (docs/optics.md) through compute shaders. What it keeps on the device comes in
 * the same three layers (raycast.h): the volume with its min-max grid; tables, marks and distance maps; the picture. */
#ifndef PEL_RENDER_RAYCAST_GPU_H
#define PEL_RENDER_RAYCAST_GPU_H

#include "device_gl.h"
#include "technique.h"

struct pel_gpu_raycaster;

/* The device is borrowed, must outlive the caster, and be current (pel_device_begin) in every call, as the renderer sees to. */
struct pel_gpu_raycaster *pel_gpu_raycaster_create(struct pel_device *device, struct pel_error *error);
void pel_gpu_raycaster_destroy(struct pel_gpu_raycaster *raycaster); /* accepts NULL */
bool pel_gpu_raycaster_prepare(struct pel_gpu_raycaster *raycaster, const struct pel_frame *frame, struct pel_error *error);
bool pel_gpu_raycaster_draw(struct pel_gpu_raycaster *raycaster, const struct pel_frame *frame, struct pel_error *error);
/* Of the last frame's rays (gpu_rate.h). Not for volumes in bricks. */
bool pel_gpu_raycaster_sample_limit(struct pel_gpu_raycaster *raycaster, double *samples_per_second, struct pel_error *error);

#endif
