/* SPDX-License-Identifier: MIT */
/* Object-aligned slices on the GPU engine: the paper's stacks of 2D textures, drawn as polygons. Its sections are in the .glsl files beside
 * this one; here is what they are given. */
#ifndef PEL_RENDER_SLICES2D_GPU_H
#define PEL_RENDER_SLICES2D_GPU_H

#include "device_gl.h"
#include "technique.h"

struct pel_gpu_slices2d;

/* The device is borrowed, must outlive this, and be current in every call, as the renderer sees to. */
struct pel_gpu_slices2d *pel_gpu_slices2d_create(struct pel_device *device, struct pel_error *error);
void pel_gpu_slices2d_destroy(struct pel_gpu_slices2d *slices); /* accepts NULL */
bool pel_gpu_slices2d_prepare(struct pel_gpu_slices2d *slices, const struct pel_frame *frame, struct pel_error *error);
bool pel_gpu_slices2d_draw(struct pel_gpu_slices2d *slices, const struct pel_frame *frame, struct pel_error *error);

#endif
