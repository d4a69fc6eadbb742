/* SPDX-License-Identifier: MIT */
/* A volume, or a box of it, as a 3D texture in its native type: 8 and 16 bits as they are (signed ones with the sign bit turned, so that
 * they rise from 0), float as it is; 32-bit integers and doubles become float parts of the volume's range. */
#ifndef PEL_RENDER_GPU_VOLUME_H
#define PEL_RENDER_GPU_VOLUME_H

#include <pellucid/volume.h>

#include "classify.h"
#include "objects.h"

/* How a volume's values lie on the device. */
struct pel_gpu_format {
    GLenum texture;                    /* sized internal format */
    int bytes;                         /* a voxel */
    struct pel_raw_scale raw;          /* of the shaders' raw values: value = raw * scale + offset */
    float texel_scale, texel_offset;   /* raw = texel * scale + offset */
    bool voids;                        /* some voxel may be void */
    float void_raw, void_within;       /* voxels as near to void_raw are, by value; negative: none */
    float least, most, gradient_scale; /* of the whole volume, raw; 1 / its range */
};

/* Looks through all samples of a real volume for values that are not finite. */
struct pel_gpu_format pel_gpu_format_of(const struct pel_device *device, const struct pel_volume *volume, int threads);

/* Can the device hold the whole volume as one texture, with `more` bytes beside it, in the memory that it is allowed? */
bool pel_gpu_volume_fits(const struct pel_device *device, const struct pel_gpu_format *format, const struct pel_volume *volume, uint64_t more);

/* May a buffer of so many bytes be made beside `held` bytes of what the technique keeps on the device? False with PEL_ERROR_UNSUPPORTED
 * where shaders could not see all of it, or the memory allowed would not do; `instead` ("use the technique raycast") ends the message. */
bool pel_gpu_check_room(const struct pel_device *device, uint64_t held, uint64_t bytes, const char *what, const char *instead,
                        struct pel_error *error);

/* Copies the box of `size` voxels from `origin` on to the device, in a texture of its size. */
bool pel_gpu_volume_upload(struct pel_device *device, const struct pel_gpu_format *format, const struct pel_volume *volume,
                           const int origin[3], const int size[3], int threads, struct pel_texture *to, struct pel_error *error);

/* The same of the whole volume as a stack of 2D slices along an index axis, an array texture: layer k is the slice at k. Axis 0: slices of
 * (y, z); 1: of (x, z); 2: of (x, y). */
bool pel_gpu_stack_upload(struct pel_device *device, const struct pel_gpu_format *format, const struct pel_volume *volume, int axis,
                          int threads, struct pel_texture *to, struct pel_error *error);

/* How samples are sent: GL's type, and the bytes of one; and samples from `from` on as they are sent. */
GLenum pel_gpu_sample_type(const struct pel_volume *volume, int *bytes);
void pel_gpu_samples(const struct pel_gpu_format *format, const struct pel_volume *volume, size_t from, size_t count, void *to);

#endif
