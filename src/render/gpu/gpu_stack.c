/* SPDX-License-Identifier: MIT */
/* A volume as a stack of 2D slices on the device (gpu_volume.h). Slices along z lie in memory as they are sent. Those along x and y are
 * gathered, some at a time, so that each row of voxels is read in stretches and not voxel by voxel. */
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "gpu_volume.h"
#include "parallel.h"

#define STAGING ((size_t)16 << 20)

struct sending {
    const struct pel_gpu_format *format;
    const struct pel_volume *volume;
    int axis, bytes;
    size_t first, count; /* layers that are gathered */
    size_t width, height;
    char *layers;
    char *stretch; /* axis 0: room for a stretch of a row, one a thread */
};

/* Axis 0: row z of every layer, from stretches of the volume's rows; layer x, at (y, z). */
static void gather_across(const struct sending *s, size_t z, int thread)
{
    const size_t *dims = s->volume->dims, bytes = (size_t)s->bytes;
    char *stretch = s->stretch + (size_t)thread * s->count * bytes;
    for (size_t y = 0; y < dims[1]; y++) {
        pel_gpu_samples(s->format, s->volume, (z * dims[1] + y) * dims[0] + s->first, s->count, stretch);
        char *to = s->layers + (z * s->width + y) * bytes;
        for (size_t i = 0; i < s->count; i++, to += s->width * s->height * bytes)
            memcpy(to, stretch + i * bytes, bytes);
    }
}

/* Row v of every layer. */
static void gather_row(void *context, size_t v, int thread)
{
    const struct sending *s = context;
    const size_t *dims = s->volume->dims;
    if (s->axis == 0) {
        gather_across(s, v, thread);
        return;
    }
    for (size_t i = 0; i < s->count; i++) {
        size_t k = s->first + i, from = s->axis == 1 ? (v * dims[1] + k) * dims[0] : (k * dims[1] + v) * dims[0];
        pel_gpu_samples(s->format, s->volume, from, s->width, s->layers + (i * s->height + v) * s->width * (size_t)s->bytes);
    }
}

bool pel_gpu_stack_upload(struct pel_device *device, const struct pel_gpu_format *format, const struct pel_volume *volume, int axis,
                          int threads, struct pel_texture *to, struct pel_error *error)
{
    const size_t *dims = volume->dims;
    struct sending s = { .format = format, .volume = volume, .axis = axis, .width = dims[axis == 0], .height = dims[axis == 2 ? 1 : 2] };
    GLenum type = pel_gpu_sample_type(volume, &s.bytes);
    if (!pel_texture_reserve_array(device, to, format->texture, (int)s.width, (int)s.height, (int)dims[axis],
                                   format->voids ? GL_NEAREST : GL_LINEAR, error))
        return false;
    size_t layer = s.width * s.height * (size_t)s.bytes, chunk = STAGING / layer;
    chunk = chunk < 1 ? 1 : chunk > dims[axis] ? dims[axis] : chunk;
    s.layers = pel_alloc_aligned(chunk, layer, "slices for the GPU", error);
    s.stretch = s.layers ? pel_alloc_aligned((size_t)threads * chunk, (size_t)s.bytes, "slices for the GPU", error) : NULL;
    bool ok = s.stretch != NULL;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (; ok && s.first < dims[axis]; s.first += s.count) {
        s.count = dims[axis] - s.first < chunk ? dims[axis] - s.first : chunk;
        pel_parallel_for(threads, s.height, gather_row, &s);
        glTextureSubImage3D(to->name, 0, 0, 0, (GLint)s.first, (GLsizei)s.width, (GLsizei)s.height, (GLsizei)s.count, GL_RED, type,
                            s.layers);
    }
    free(s.layers);
    free(s.stretch);
    return ok && pel_device_check(device, "upload", error);
}
