/* SPDX-License-Identifier: MIT */
#include "gpu_frame.h"

#include "device_gl.h"
#include "fail.h"
#include "timer.h"

void pel_gpu_stages_clear(struct pel_gpu_stage *stages, int count)
{
    for (int i = 0; i < count; i++) {
        stages[i].milliseconds = 0;
        stages[i].runs = 0;
    }
}

void pel_gpu_stage_begin(struct pel_device *device, struct pel_gpu_stage *stage, const char *name)
{
    stage->runs++;
    stage->milliseconds -= pel_now_ms();
    pel_gpu_timer_begin(device, &stage->timer, name);
}

void pel_gpu_stage_end(struct pel_device *device, struct pel_gpu_stage *stage)
{
    pel_gpu_timer_end(&stage->timer);
    if (device->info.software)
        glFinish();
    stage->milliseconds += pel_now_ms();
}

void pel_gpu_stage_note(const struct pel_device *device, struct pel_gpu_stage *stage, const struct pel_frame *frame, const char *name)
{
    if (!stage->runs)
        return;
    const bool clocked = !device->info.software && stage->runs == 1;
    pel_frame_stage_gpu(frame, name, pel_now_ms() - stage->milliseconds, clocked ? pel_gpu_timer_ms(&stage->timer) : -1);
}

void pel_gpu_stages_destroy(struct pel_device *device, struct pel_gpu_stage *stages, int count)
{
    for (int i = 0; i < count; i++)
        pel_gpu_timer_destroy(device, &stages[i].timer);
}

bool pel_gpu_check_picture(const struct pel_device *device, const struct pel_image *image, const char *instead, struct pel_error *error)
{
    const int most = device->info.max_texture_2d, w = image->width, h = image->height;
    return (w <= most && h <= most && (uint64_t)w * (uint64_t)h <= INT32_MAX / (4 * sizeof(float))) ||
           pel_fail(error, PEL_ERROR_UNSUPPORTED, "a picture of %d x %d is more than the GPU engine draws%s", w, h, instead);
}

bool pel_gpu_read_back(struct pel_device *device, const struct pel_texture *picture, const struct pel_texture *depth,
                       struct pel_image *image, struct pel_error *error)
{
    const GLsizei pixels = image->width * image->height;
    glGetTextureImage(picture->name, 0, GL_RGBA, GL_FLOAT, pixels * 4 * (GLsizei)sizeof(float), image->rgba);
    if (image->depth)
        glGetTextureImage(depth->name, 0, GL_RED, GL_FLOAT, pixels * (GLsizei)sizeof(float), image->depth);
    return pel_device_check(device, "reading the picture back", error);
}
