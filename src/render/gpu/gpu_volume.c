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
#include "samples.h"

/* How a type travels: the texture's format, and the factor from its texels to data values. */
static const struct {
    GLenum format, type;
    float texel_scale, texel_offset;
    bool native;    /* no conversion but the sign bit */
    uint32_t flip;  /* of a sample */
    int bytes;      /* of a sample as it is sent */
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

struct search {
    const struct pel_volume *volume;
    atomic_bool odd; /* some sample is not finite */
};

static void search_slice(void *context, size_t z, int thread)
{
    (void)thread;
    struct search *s = context;
    const struct pel_volume *v = s->volume;
    size_t slice = v->dims[0] * v->dims[1];
    bool odd = false;
    for (size_t i = z * slice; i < (z + 1) * slice; i++)
        odd |= v->type == PEL_F32 ? !(fabsf(((const float *)v->data)[i]) <= FLT_MAX) : !(fabs(((const double *)v->data)[i]) <= DBL_MAX);
    if (odd)
        atomic_store_explicit(&s->odd, true, memory_order_relaxed);
}

struct pel_gpu_format pel_gpu_format_of(const struct pel_device *device, const struct pel_volume *v, int threads)
{
    struct search search = { .volume = v };
    if (v->type == PEL_F32 || v->type == PEL_F64)
        pel_parallel_for(threads, v->dims[2], search_slice, &search);
    double lo = v->range[0], hi = v->range[1], span = hi - lo;
    bool native = types[v->type].native, by_value = v->has_void && !isnan(v->void_value), finite = span > 0 && isfinite(span);
    struct pel_gpu_format f = { .texture = types[v->type].format };
    /* llvmpipe filters 8-bit texels in 8 bits; in 16 the same samples take as long and lose nothing. */
    if (f.texture == GL_R8 && device->info.software)
        f.texture = GL_R16;
    f.bytes = f.texture == GL_R8 ? 1 : f.texture == GL_R16 ? 2 : 4;
    f.raw = native ? (struct pel_raw_scale) { 1, 0 } : (struct pel_raw_scale) { finite ? span : 1, isfinite(lo) ? lo : 0 };
    f.texel_scale = types[v->type].texel_scale;
    f.texel_offset = types[v->type].texel_offset;
    f.voids = atomic_load(&search.odd) || by_value;
    /* Integers come through a float in 0..1, which need not give them back to the last bit. */
    f.void_within = !by_value || !native ? -1 : f.texture == GL_R32F ? 0 : 0.25f;
    f.void_raw = (float)v->void_value;
    f.least = (float)((lo - f.raw.offset) / f.raw.scale);
    f.most = (float)((hi - f.raw.offset) / f.raw.scale);
    f.gradient_scale = finite ? (float)fmin(f.raw.scale / span, 1e30) : 1;
    return f;
}

/* A box on its way, some slices at a time. */
struct parcel {
    const struct pel_volume *volume;
    const struct pel_gpu_format *format;
    const int *origin, *size;
    size_t first; /* slice of the box that comes first in the staging memory */
    char *staging;
};

#define BLOCK 256

static void convert_wide(const struct pel_volume *v, struct pel_raw_scale raw, size_t from, size_t n, float *to)
{
    double values[BLOCK];
    for (size_t i = 0; i < n; i += BLOCK) {
        size_t count = n - i < BLOCK ? n - i : BLOCK;
        pel_samples_load(v, from + i, count, values);
        for (size_t j = 0; j < count; j++)
            to[i + j] = (float)((values[j] - raw.offset) / raw.scale);
    }
}

GLenum pel_gpu_sample_type(const struct pel_volume *volume, int *bytes)
{
    *bytes = types[volume->type].bytes;
    return types[volume->type].type;
}

void pel_gpu_samples(const struct pel_gpu_format *format, const struct pel_volume *v, size_t from, size_t n, void *to)
{
    if (v->type == PEL_I8)
        for (size_t i = 0; i < n; i++)
            ((uint8_t *)to)[i] = (uint8_t)(((const uint8_t *)v->data)[from + i] ^ types[PEL_I8].flip);
    else if (v->type == PEL_I16)
        for (size_t i = 0; i < n; i++)
            ((uint16_t *)to)[i] = (uint16_t)(((const uint16_t *)v->data)[from + i] ^ types[PEL_I16].flip);
    else if (types[v->type].native)
        memcpy(to, (const char *)v->data + from * (size_t)types[v->type].bytes, n * (size_t)types[v->type].bytes);
    else
        convert_wide(v, format->raw, from, n, to);
}

/* Converts one slice of the box into the staging memory. */
static void convert_slice(void *context, size_t z, int thread)
{
    (void)thread;
    const struct parcel *p = context;
    const struct pel_volume *v = p->volume;
    size_t n = (size_t)p->size[0], rows = (size_t)p->size[1], bytes = (size_t)types[v->type].bytes;
    for (size_t y = 0; y < rows; y++) {
        size_t from = (((size_t)p->origin[2] + p->first + z) * v->dims[1] + (size_t)p->origin[1] + y) * v->dims[0] + (size_t)p->origin[0];
        pel_gpu_samples(p->format, v, from, n, p->staging + (z * rows + y) * n * bytes);
    }
}

/* Slices go in chunks of some MB, converted on all threads where they must be. */
static bool send_slices(struct parcel *p, int threads, GLuint texture, struct pel_error *error)
{
    const struct pel_volume *v = p->volume;
    const int *size = p->size, *origin = p->origin;
    size_t bytes = (size_t)types[v->type].bytes, slice = (size_t)size[0] * (size_t)size[1] * bytes, chunk = ((size_t)16 << 20) / slice;
    bool as_it_is = types[v->type].native && !types[v->type].flip;
    chunk = chunk < 1 ? 1 : chunk > (size_t)size[2] ? (size_t)size[2] : chunk;
    if (!as_it_is && !(p->staging = pel_alloc_aligned(chunk, slice, "slices for the GPU", error)))
        return false;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, as_it_is ? (GLint)v->dims[0] : 0);
    glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, as_it_is ? (GLint)v->dims[1] : 0);
    for (int z = 0; z < size[2]; z += (int)chunk) {
        int count = size[2] - z < (int)chunk ? size[2] - z : (int)chunk;
        const void *from = (const char *)v->data + ((((size_t)(origin[2] + z)) * v->dims[1] + (size_t)origin[1]) * v->dims[0] +
                                                    (size_t)origin[0]) * bytes;
        if (!as_it_is) {
            p->first = (size_t)z;
            pel_parallel_for(threads, (size_t)count, convert_slice, p);
            from = p->staging;
        }
        glTextureSubImage3D(texture, 0, 0, 0, z, size[0], size[1], count, GL_RED, types[v->type].type, from);
    }
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, 0);
    free(p->staging);
    return true;
}

bool pel_gpu_volume_upload(struct pel_device *device, const struct pel_gpu_format *format, const struct pel_volume *volume,
                           const int origin[3], const int size[3], int threads, struct pel_texture *to, struct pel_error *error)
{
    struct parcel parcel = { .volume = volume, .format = format, .origin = origin, .size = size };
    return pel_texture_reserve(device, to, format->texture, size[0], size[1], size[2], format->voids ? GL_NEAREST : GL_LINEAR, error) &&
           send_slices(&parcel, threads, to->name, error) && pel_device_check(device, "upload", error);
}

bool pel_gpu_volume_fits(const struct pel_device *device, const struct pel_gpu_format *format, const struct pel_volume *volume, uint64_t more)
{
    const uint64_t limit = device->params.memory_limit;
    uint64_t bytes = (uint64_t)format->bytes;
    bool fits = true;
    for (int a = 0; a < 3; a++) {
        fits &= volume->dims[a] <= (size_t)device->info.max_texture_3d;
        bytes *= volume->dims[a];
    }
    return fits && (!limit || bytes + more <= limit);
}

bool pel_gpu_check_room(const struct pel_device *device, uint64_t held, uint64_t bytes, const char *what, const char *instead,
                        struct pel_error *error)
{
    const uint64_t limit = device->params.memory_limit, most = device->info.max_storage_buffer_bytes;
    if (bytes > most)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s: %.6g MB in one buffer, and those of the GPU hold %.6g MB; %s", what,
                        (double)bytes / 1e6, (double)most / 1e6, instead);
    return !limit || (held <= limit && bytes <= limit - held) ||
           pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s: %.6g MB beside %.6g MB of the GPU, of which %.6g MB may be taken (--gpu-memory); %s",
                    what, (double)bytes / 1e6, (double)held / 1e6, (double)limit / 1e6, instead);
}
