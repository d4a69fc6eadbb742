/* SPDX-License-Identifier: MIT */
#include "voxels.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"

void pel_voxels_finish(struct pel_voxels *voxels)
{
    pel_minmax_finish(&voxels->minmax);
    free(voxels->padded);
    memset(voxels, 0, sizeof *voxels);
}

/* A trilinear cell needs two voxels along each axis, and a 32-bit fetch of bytes four along x: thinner volumes get their last voxel again.
 */
static bool pad(struct pel_voxels *voxels, struct pel_job *job, struct pel_error *error)
{
    const struct pel_volume *v = voxels->volume;
    size_t least[3] = { 4, 2, 2 }, dims[3], size = pel_type_size(v->type);
    for (int a = 0; a < 3; a++)
        dims[a] = v->dims[a] < least[a] ? least[a] : v->dims[a];
    job->row = (int32_t)dims[0];
    job->slice = (int32_t)(dims[0] * dims[1]);
    job->data = v->data;
    if (!memcmp(dims, v->dims, sizeof dims))
        return true;
    voxels->padded = pel_alloc(dims[0] * dims[1] * dims[2], size, "thin volume", error);
    if (!voxels->padded)
        return false;
    char *to = voxels->padded;
    for (size_t z = 0; z < dims[2]; z++)
        for (size_t y = 0; y < dims[1]; y++)
            for (size_t x = 0; x < dims[0]; x++, to += size) {
                size_t from[3] = { x < v->dims[0] ? x : v->dims[0] - 1, y < v->dims[1] ? y : v->dims[1] - 1,
                                   z < v->dims[2] ? z : v->dims[2] - 1 };
                memcpy(to, (const char *)v->data + ((from[2] * v->dims[1] + from[1]) * v->dims[0] + from[0]) * size, size);
            }
    job->data = voxels->padded;
    return true;
}

/* Which kernel fetches this type, and how its raw values lie on the data's (kernel.h). */
static void describe(struct pel_voxels *voxels, struct pel_job *job)
{
    const struct pel_volume *v = voxels->volume;
    double lo = v->range[0], hi = v->range[1], half = hi / 2 - lo / 2; /* hi - lo could overflow */
    static const enum pel_kernel_kind kinds[PEL_TYPE_COUNT] = {
        [PEL_U8] = PEL_KERNEL_U8,    [PEL_I8] = PEL_KERNEL_U8,    [PEL_U16] = PEL_KERNEL_U16, [PEL_I16] = PEL_KERNEL_U16,
        [PEL_U32] = PEL_KERNEL_WIDE, [PEL_I32] = PEL_KERNEL_WIDE, [PEL_F32] = PEL_KERNEL_F32, [PEL_F64] = PEL_KERNEL_WIDE,
    };
    voxels->kind = kinds[v->type];
    job->type = v->type;
    job->flip = v->type == PEL_I8 ? (int32_t)0x80808080 : v->type == PEL_U16 ? (int32_t)0x80008000 : 0;
    voxels->raw = (struct pel_raw_scale) { 1.0 / 16384, v->type == PEL_I8 ? -128 : v->type == PEL_U16 ? 32768 : 0 };
    if (voxels->kind == PEL_KERNEL_F32)
        voxels->raw = (struct pel_raw_scale) { 1, 0 };
    if (voxels->kind == PEL_KERNEL_WIDE) {
        bool flat = !(half > 0) || !isfinite(half);
        voxels->raw = (struct pel_raw_scale) { flat ? 1 : 2 * half, isfinite(lo) ? lo : 0 };
        if (isinf(voxels->raw.scale))
            voxels->raw.scale = 1.7e308;
        job->wide_offset = voxels->raw.offset;
        job->wide_scale = 1 / voxels->raw.scale;
    }
    double range = (hi - lo) / voxels->raw.scale;
    job->gradient_scale = range > 0 && isfinite(range) ? (float)fmin(1 / range, 1e30) : 1;
    job->voids = voxels->minmax.has_voids;
    bool by_value = voxels->minmax.has_voids && v->has_void && !isnan(v->void_value);
    job->wide_void = by_value && voxels->kind == PEL_KERNEL_WIDE;
    job->has_void_value = by_value && voxels->kind != PEL_KERNEL_WIDE;
    job->void_value = v->void_value;
    job->void_raw = (float)((v->void_value - voxels->raw.offset) / voxels->raw.scale);
    for (int a = 0; a < 3; a++) {
        job->dims[a] = (int32_t)v->dims[a];
        job->last_cell[a] = v->dims[a] > 2 ? (int32_t)v->dims[a] - 2 : 0;
    }
}

bool pel_voxels_set(struct pel_voxels *voxels, const struct pel_volume *volume, int threads, struct pel_job *job, struct pel_error *error)
{
    pel_voxels_finish(voxels);
    size_t padded = 1;
    for (int a = 0; a < 3; a++)
        if (!pel_mul(padded, volume->dims[a] < 4 ? 4 : volume->dims[a], &padded) || padded > INT32_MAX)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                            "%zu x %zu x %zu voxels: the CPU engine takes up to 2^31 - 1; crop or downsample the volume", volume->dims[0],
                            volume->dims[1], volume->dims[2]);
    voxels->volume = volume;
    if (!pel_minmax_init(&voxels->minmax, volume, threads, error) || !pad(voxels, job, error)) {
        pel_voxels_finish(voxels);
        return false;
    }
    describe(voxels, job);
    return true;
}

size_t pel_voxels_bytes(const struct pel_voxels *voxels, const struct pel_job *job)
{
    size_t cells = 0;
    const struct pel_minmax_level *levels[2] = { &voxels->minmax.cells, &voxels->minmax.blocks };
    for (int l = 0; l < 2; l++)
        cells += levels[l]->dims[0] * levels[l]->dims[1] * levels[l]->dims[2];
    size_t padded = (size_t)job->slice * (size_t)(job->dims[2] < 2 ? 2 : job->dims[2]) * pel_type_size(job->type);
    return cells * 2 * sizeof(float) + (voxels->padded ? padded : 0);
}
