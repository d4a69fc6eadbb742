/* SPDX-License-Identifier: MIT */
#include "encode.h"

#include <math.h>

#include "parallel.h"

static float to_display(float c)
{
    return c <= 0.0031308f ? c * 12.92f : 1.055f * powf(c, 1 / 2.4f) - 0.055f;
}

static void encode_row(void *context, size_t y, int thread)
{
    (void)thread;
    const struct pel_job *job = context;
    for (int x = 0; x < job->width; x++) {
        float *p = job->rgba + (y * (size_t)job->width + (size_t)x) * 4;
        for (int c = 0; c < 3 && p[3] > 0; c++)
            p[c] = to_display(p[c] / p[3]) * p[3];
    }
}

void pel_encode_picture(const struct pel_job *job, int threads)
{
    pel_parallel_for(threads, (size_t)job->height, encode_row, (void *)job);
}
