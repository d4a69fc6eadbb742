/* SPDX-License-Identifier: MIT */
/* A volume as a 3D texture in its native type: 8 and 16 bits as they are (signed ones with the sign bit turned, so that they rise from 0),
 * float as it is; 32-bit integers and doubles become float parts of the volume's range. */
#ifndef PEL_RENDER_GPU_VOLUME_H
#define PEL_RENDER_GPU_VOLUME_H

#include <pellucid/volume.h>

#include "classify.h"
#include "objects.h"

struct pel_gpu_volume {
    struct pel_texture texture;
    struct pel_raw_scale raw;            /* of the shaders' raw values: value = raw * scale + offset */
    float texel_scale, texel_offset;     /* raw = texel * scale + offset */
    bool voids, void_by_value;           /* some voxel may be void; by value */
    float void_raw;
    float least, most, gradient_scale;   /* of the whole volume, raw; 1 / its range */
};

/* Copies the samples to the device. Refuses a volume whose sides are longer than the device's 3D textures, naming both. */
bool pel_gpu_volume_upload(struct pel_device *device, struct pel_gpu_volume *to, const struct pel_volume *volume, int threads,
                           struct pel_error *error);
void pel_gpu_volume_destroy(struct pel_device *device, struct pel_gpu_volume *volume); /* accepts a zeroed one */

#endif
