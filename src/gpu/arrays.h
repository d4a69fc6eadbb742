/* SPDX-License-Identifier: MIT */
/* Vertex arrays over one buffer, which is their attribute 0. Counted like the objects of objects.h. */
#ifndef PEL_GPU_ARRAYS_H
#define PEL_GPU_ARRAYS_H

#include "objects.h"

struct pel_array {
    GLuint name;
};

enum pel_array_kind {
    PEL_ARRAY_PAIRS,   /* two unsigned integers an instance */
    PEL_ARRAY_CORNERS, /* four floats a vertex */
};

/* Binds the array, made if need be, for the buffer that there is now. */
bool pel_array_bind(struct pel_device *device, struct pel_array *array, enum pel_array_kind kind, const struct pel_buffer *buffer,
                    struct pel_error *error);
void pel_array_destroy(struct pel_device *device, struct pel_array *array); /* accepts a zeroed one */

#endif
