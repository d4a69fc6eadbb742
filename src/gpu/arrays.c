/* SPDX-License-Identifier: MIT */
#include "arrays.h"

#include "fail.h"

bool pel_array_bind(struct pel_device *device, struct pel_array *array, enum pel_array_kind kind, const struct pel_buffer *buffer,
                    struct pel_error *error)
{
    const bool pairs = kind == PEL_ARRAY_PAIRS;
    if (!array->name) {
        glCreateVertexArrays(1, &array->name);
        if (!array->name)
            return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more vertex arrays");
        device->objects++;
    }
    glVertexArrayVertexBuffer(array->name, 0, buffer->name, 0, pairs ? 2 * sizeof(GLuint) : 4 * sizeof(GLfloat));
    if (pairs)
        glVertexArrayAttribIFormat(array->name, 0, 2, GL_UNSIGNED_INT, 0);
    else
        glVertexArrayAttribFormat(array->name, 0, 4, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(array->name, 0, 0);
    glVertexArrayBindingDivisor(array->name, 0, pairs);
    glEnableVertexArrayAttrib(array->name, 0);
    glBindVertexArray(array->name);
    return pel_device_check(device, "vertex array", error);
}

void pel_array_destroy(struct pel_device *device, struct pel_array *array)
{
    if (!array->name)
        return;
    if (pel_device_is_current(device))
        glDeleteVertexArrays(1, &array->name);
    device->objects--;
    array->name = 0;
}
