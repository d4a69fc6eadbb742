/* SPDX-License-Identifier: MIT */
/* How many trilinear samples of a volume's texture a device takes a second along a frame's rays, if it does nothing else. */
#ifndef PEL_RENDER_GPU_RATE_H
#define PEL_RENDER_GPU_RATE_H

#include "gpu_job.h"

struct pel_gpu_rate {
    struct pel_programs *programs;
    const struct pel_texture *volume;
    GLenum filter; /* that the texture has otherwise */
    const struct pel_texture *picture; /* its size is the rays' number; overwritten */
    struct pel_buffer *counters;       /* as march.glsl's; overwritten */
};

/* Measures with the uniform block, counters and volume that are bound. By the device's clock; in software by the wall's. */
bool pel_gpu_rate_measure(struct pel_device *device, const struct pel_gpu_rate *rate, double *samples_per_second, struct pel_error *error);

#endif
