/* SPDX-License-Identifier: MIT */
#include "objects.h"

#include <string.h>

#include "fail.h"

static size_t texel_bytes(GLenum format)
{
    switch (format) {
    case GL_R8:
    case GL_R8UI:
        return 1;
    case GL_R16:
    case GL_R16UI:
    case GL_RG8:
        return 2;
    case GL_RG32F:
    case GL_RGBA16F:
        return 8;
    case GL_RGBA32F:
    case GL_RGBA32UI:
        return 16;
    default:
        return 4;
    }
}

/* `kind`: GL_TEXTURE_2D, GL_TEXTURE_3D, or GL_TEXTURE_2D_ARRAY. */
static bool reserve(struct pel_device *device, struct pel_texture *texture, GLenum kind, GLenum format, int width, int height, int depth,
                    GLenum filter, struct pel_error *error)
{
    int size[3] = { width, height, depth > 0 ? depth : 1 };
    if (texture->name && texture->format == format && !memcmp(texture->size, size, sizeof size))
        return true;
    pel_texture_destroy(device, texture);
    uint64_t bytes = texel_bytes(format) * (uint64_t)width * (uint64_t)height * (uint64_t)size[2];
    if (device->room && device->bytes + bytes > device->room)
        return pel_fail(error, PEL_ERROR_MEMORY, "texture: no memory on the device");
    glCreateTextures(kind, 1, &texture->name);
    if (!texture->name)
        return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more textures");
    if (kind != GL_TEXTURE_2D)
        glTextureStorage3D(texture->name, 1, format, width, height, depth);
    else
        glTextureStorage2D(texture->name, 1, format, width, height);
    glTextureParameteri(texture->name, GL_TEXTURE_MIN_FILTER, (GLint)filter);
    glTextureParameteri(texture->name, GL_TEXTURE_MAG_FILTER, (GLint)filter);
    for (int i = 0; i < 3; i++) {
        static const GLenum wraps[3] = { GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R };
        glTextureParameteri(texture->name, wraps[i], GL_CLAMP_TO_EDGE);
    }
    texture->format = format;
    memcpy(texture->size, size, sizeof size);
    texture->bytes = bytes;
    device->objects++;
    device->bytes += texture->bytes;
    if (pel_device_check(device, "texture", error))
        return true;
    pel_texture_destroy(device, texture);
    return false;
}

bool pel_texture_reserve(struct pel_device *device, struct pel_texture *texture, GLenum format, int width, int height, int depth,
                         GLenum filter, struct pel_error *error)
{
    return reserve(device, texture, depth > 0 ? GL_TEXTURE_3D : GL_TEXTURE_2D, format, width, height, depth, filter, error);
}

bool pel_texture_reserve_array(struct pel_device *device, struct pel_texture *texture, GLenum format, int width, int height, int layers,
                               GLenum filter, struct pel_error *error)
{
    return reserve(device, texture, GL_TEXTURE_2D_ARRAY, format, width, height, layers, filter, error);
}

void pel_texture_destroy(struct pel_device *device, struct pel_texture *texture)
{
    if (!texture->name)
        return;
    if (pel_device_is_current(device))
        glDeleteTextures(1, &texture->name);
    device->objects--;
    device->bytes -= texture->bytes;
    memset(texture, 0, sizeof *texture);
}

bool pel_buffer_fill(struct pel_device *device, struct pel_buffer *buffer, const void *data, size_t bytes, struct pel_error *error)
{
    if (buffer->name && buffer->bytes >= bytes) {
        if (data)
            glNamedBufferSubData(buffer->name, 0, (GLsizeiptr)bytes, data);
        return pel_device_check(device, "buffer", error);
    }
    pel_buffer_destroy(device, buffer);
    glCreateBuffers(1, &buffer->name);
    if (!buffer->name)
        return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more buffers");
    glNamedBufferStorage(buffer->name, (GLsizeiptr)bytes, data, GL_DYNAMIC_STORAGE_BIT);
    buffer->bytes = bytes;
    device->objects++;
    device->bytes += bytes;
    if (pel_device_check(device, "buffer", error))
        return true;
    pel_buffer_destroy(device, buffer);
    return false;
}

void pel_buffer_destroy(struct pel_device *device, struct pel_buffer *buffer)
{
    if (!buffer->name)
        return;
    if (pel_device_is_current(device))
        glDeleteBuffers(1, &buffer->name);
    device->objects--;
    device->bytes -= buffer->bytes;
    memset(buffer, 0, sizeof *buffer);
}

void pel_gpu_timer_begin(struct pel_device *device, struct pel_gpu_timer *timer, const char *stage)
{
    if (!timer->queries[0]) {
        glCreateQueries(GL_TIMESTAMP, 2, timer->queries);
        device->objects += 2;
    }
    glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, stage);
    glQueryCounter(timer->queries[0], GL_TIMESTAMP);
}

void pel_gpu_timer_end(struct pel_gpu_timer *timer)
{
    glQueryCounter(timer->queries[1], GL_TIMESTAMP);
    glPopDebugGroup();
}

double pel_gpu_timer_ms(struct pel_gpu_timer *timer)
{
    GLuint64 ns[2] = { 0, 0 };
    for (int i = 0; i < 2 && timer->queries[0]; i++)
        glGetQueryObjectui64v(timer->queries[i], GL_QUERY_RESULT, &ns[i]);
    return ns[1] > ns[0] ? (double)(ns[1] - ns[0]) * 1e-6 : 0;
}

void pel_gpu_timer_destroy(struct pel_device *device, struct pel_gpu_timer *timer)
{
    if (!timer->queries[0])
        return;
    if (pel_device_is_current(device))
        glDeleteQueries(2, timer->queries);
    device->objects -= 2;
    timer->queries[0] = timer->queries[1] = 0;
}
