/* SPDX-License-Identifier: MIT */
#include "gpu_rate.h"

#include <math.h>

#include "fail.h"
#include "timer.h"

#define ROUNDS 5 /* the best counts: the first pays for warming up, any for what else the machine does */

static void set_filter(const struct pel_texture *volume, GLenum filter)
{
    glTextureParameteri(volume->name, GL_TEXTURE_MIN_FILTER, (GLint)filter);
    glTextureParameteri(volume->name, GL_TEXTURE_MAG_FILTER, (GLint)filter);
}

static double samples_of(uint32_t counted[64][4])
{
    double samples = 0;
    for (int i = 0; i < 64; i++)
        samples += (double)counted[i][0] + 0x1p32 * counted[i][1];
    return samples;
}

bool pel_gpu_rate_measure(struct pel_device *device, const struct pel_gpu_rate *rate, double *samples_per_second, struct pel_error *error)
{
    const int *size = rate->picture->size;
    struct pel_gpu_timer timer = { 0 };
    GLuint program = pel_gpu_program(device, rate->programs, "rate.glsl", 0, PEL_MODE_COMPOSITE, error);
    bool ok = program != 0;
    *samples_per_second = 0;
    set_filter(rate->volume, GL_LINEAR);
    for (int i = 0; i < ROUNDS && ok; i++) {
        uint32_t counted[64][4] = { { 0 } }; /* tile.glsl */
        if (!(ok = pel_buffer_fill(device, rate->counters, counted, sizeof counted, error)))
            break;
        glUseProgram(program);
        glProgramUniform4i(program, 0, 0, 0, 0, 0);
        glBindImageTexture(0, rate->picture->name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
        glFinish();
        double start = pel_now_ms();
        pel_gpu_timer_begin(device, &timer, "sample rate");
        glDispatchCompute((GLuint)(size[0] - 1) / PEL_TILE_SIDE + 1, (GLuint)(size[1] - 1) / PEL_TILE_SIDE + 1, 1);
        pel_gpu_timer_end(&timer);
        glFinish();
        double wall_ms = pel_now_ms() - start, gpu_ms = pel_gpu_timer_ms(&timer), ms = device->info.software ? wall_ms : gpu_ms;
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        glGetNamedBufferSubData(rate->counters->name, 0, sizeof counted, counted);
        if (ms > 0)
            *samples_per_second = fmax(*samples_per_second, samples_of(counted) / (ms * 1e-3));
        ok = pel_device_check(device, "sample rate", error);
    }
    if (ok && *samples_per_second <= 0)
        ok = pel_fail(error, PEL_ERROR_UNSUPPORTED, "the device's clock told no time");
    set_filter(rate->volume, rate->filter);
    pel_gpu_timer_destroy(device, &timer);
    return ok;
}
