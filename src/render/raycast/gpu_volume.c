/* SPDX-License-Identifier: MIT */
#include "gpu_volume.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"

/* How a type travels: the texture's format, and the factor from its texels to data values. */
static const struct {
    GLenum format, type;
    float texel_scale, texel_offset;
    bool native;    /* no conversion but the sign bit */
    uint32_t flip;  /* of a sample */
    int bytes;      /* of a sample on the device */
} types[PEL_TYPE_COUNT] = {
    [PEL_U8] = { GL_R8, GL_UNSIGNED_BYTE, 255, 0, true, 0, 1 },
    [PEL_I8] = { GL_R8, GL_UNSIGNED_BYTE, 255, -128, true, 0x80, 1 },
    [PEL_U16] = { GL_R16, GL_UNSIGNED_SHORT, 65535, 0, true, 0, 2 },
    [PEL_I16] = { GL_R16, GL_UNSIGNED_SHORT, 65535, -32768, true, 0x8000, 2 },
    [PEL_U32] = { GL_R32F, GL_FLOAT, 1, 0, false, 0, 4 },
    [PEL_I32] = { GL_R32F, GL_FLOAT, 1, 0, false, 0, 4 },
    [PEL_F32] = { GL_R32F, GL_FLOAT, 1, 0, true, 0, 4 },
    [PEL_F64] = { GL_R32F, GL_FLOAT, 1, 0, false, 0, 4 },
};

struct slices {
    const struct pel_volume *volume;
    const struct pel_gpu_volume *to;
    size_t slice;         /* samples */
    size_t first;         /* slice of this chunk */
    char *staging;
    atomic_bool odd;      /* some sample is not finite */
};

static double number_at(const struct pel_volume *v, size_t i)
{
    return v->type == PEL_F64   ? ((const double *)v->data)[i]
           : v->type == PEL_U32 ? (double)((const uint32_t *)v->data)[i]
                                : (double)((const int32_t *)v->data)[i];
}

/* Converts one slice into the staging memory. */
static void convert_slice(void *context, size_t z, int thread)
{
    (void)thread;
    struct slices *s = context;
    const struct pel_volume *v = s->volume;
    size_t from = (s->first + z) * s->slice, n = s->slice;
    uint32_t flip = types[v->type].flip;
    if (v->type == PEL_I8) {
        uint8_t *to = (uint8_t *)s->staging + z * n;
        for (size_t i = 0; i < n; i++)
            to[i] = (uint8_t)(((const uint8_t *)v->data)[from + i] ^ flip);
    } else if (v->type == PEL_I16) {
        uint16_t *to = (uint16_t *)s->staging + z * n;
        for (size_t i = 0; i < n; i++)
            to[i] = (uint16_t)(((const uint16_t *)v->data)[from + i] ^ flip);
    } else {
        float *to = (float *)s->staging + z * n;
        for (size_t i = 0; i < n; i++) {
            double value = number_at(v, from + i);
            bool is_void = v->has_void && value == v->void_value;
            to[i] = is_void ? NAN : (float)((value - s->to->raw.offset) / s->to->raw.scale);
        }
    }
}

/* Looks for samples that are not finite. */
static void search_slice(void *context, size_t z, int thread)
{
    (void)thread;
    struct slices *s = context;
    const struct pel_volume *v = s->volume;
    bool odd = false;
    for (size_t i = z * s->slice; i < (z + 1) * s->slice; i++)
        odd |= v->type == PEL_F32 ? !(fabsf(((const float *)v->data)[i]) <= FLT_MAX) : !(fabs(((const double *)v->data)[i]) <= DBL_MAX);
    if (odd)
        atomic_store_explicit(&s->odd, true, memory_order_relaxed);
}

/* How values lie on the device's numbers, and where voids are. */
static void describe(struct pel_gpu_volume *to, const struct pel_volume *v, bool odd)
{
    double lo = v->range[0], hi = v->range[1], span = hi - lo;
    bool native = types[v->type].native;
    to->raw =
        native ? (struct pel_raw_scale) { 1, 0 } : (struct pel_raw_scale) { span > 0 && isfinite(span) ? span : 1, isfinite(lo) ? lo : 0 };
    to->texel_scale = types[v->type].texel_scale;
    to->texel_offset = types[v->type].texel_offset;
    bool by_value = v->has_void && !isnan(v->void_value);
    to->voids = odd || by_value;
    to->void_by_value = by_value && native;
    to->void_raw = (float)v->void_value;
    to->least = (float)((lo - to->raw.offset) / to->raw.scale);
    to->most = (float)((hi - to->raw.offset) / to->raw.scale);
    to->gradient_scale = span > 0 && isfinite(span) ? (float)fmin(to->raw.scale / span, 1e30) : 1;
}

/* Slices go in chunks of some MB, converted on all threads where they must be. */
static bool send_slices(struct pel_gpu_volume *to, const struct pel_volume *v, struct slices *s, int threads, struct pel_error *error)
{
    int width = (int)v->dims[0], height = (int)v->dims[1], depth = (int)v->dims[2];
    size_t bytes = s->slice * (size_t)types[v->type].bytes, chunk = ((size_t)16 << 20) / bytes;
    bool as_it_is = types[v->type].native && !types[v->type].flip;
    chunk = chunk < 1 ? 1 : chunk > v->dims[2] ? v->dims[2] : chunk;
    if (!as_it_is && !(s->staging = pel_alloc_aligned(chunk, bytes, "slices for the GPU", error)))
        return false;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (int z = 0; z < depth; z += (int)chunk) {
        int count = depth - z < (int)chunk ? depth - z : (int)chunk;
        const void *from = (const char *)v->data + (size_t)z * bytes;
        if (!as_it_is) {
            s->first = (size_t)z;
            pel_parallel_for(threads, (size_t)count, convert_slice, s);
            from = s->staging;
        }
        glTextureSubImage3D(to->texture.name, 0, 0, 0, z, width, height, count, GL_RED, types[v->type].type, from);
    }
    free(s->staging);
    return true;
}

bool pel_gpu_volume_upload(struct pel_device *device, struct pel_gpu_volume *to, const struct pel_volume *v, int threads,
                           struct pel_error *error)
{
    const size_t most = (size_t)device->info.max_texture_3d;
    if (v->dims[0] > most || v->dims[1] > most || v->dims[2] > most)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                        "%zu x %zu x %zu voxels: this device's textures have up to %zu along a side; use --device cpu", v->dims[0],
                        v->dims[1], v->dims[2], most);
    struct slices s = { .volume = v, .to = to, .slice = v->dims[0] * v->dims[1] };
    if (v->type == PEL_F32 || v->type == PEL_F64)
        pel_parallel_for(threads, v->dims[2], search_slice, &s);
    describe(to, v, atomic_load(&s.odd));
    /* llvmpipe filters 8-bit texels in 8 bits; in 16 the same samples take as long and lose nothing. */
    GLenum format = types[v->type].format == GL_R8 && device->info.software ? GL_R16 : types[v->type].format;
    return pel_texture_reserve(device, &to->texture, format, (int)v->dims[0], (int)v->dims[1], (int)v->dims[2],
                               to->voids ? GL_NEAREST : GL_LINEAR, error) &&
           send_slices(to, v, &s, threads, error) && pel_device_check(device, "upload", error);
}

void pel_gpu_volume_destroy(struct pel_device *device, struct pel_gpu_volume *volume)
{
    pel_texture_destroy(device, &volume->texture);
}
