/* SPDX-License-Identifier: MIT */
/* What a context says of itself, and which of several devices is the best. */
#include "describe.h"

#include <stdio.h>
#include <string.h>

static void copy_string(char *text, size_t size, GLenum name)
{
    const char *told = (const char *)glGetString(name);
    snprintf(text, size, "%s", told ? told : "");
}

/* EGL marks Mesa's software device, but a driver for hardware may fall back to software too: the name tells. */
static bool named_as_software(const char *renderer)
{
    static const char *const names[] = { "llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer", "lavapipe", "SwiftShader" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strstr(renderer, names[i]))
            return true;
    return false;
}

static int get_int(GLenum name)
{
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

static bool has_extension(const char *name)
{
    int count = get_int(GL_NUM_EXTENSIONS);
    for (int i = 0; i < count; i++) {
        const char *extension = (const char *)glGetStringi(GL_EXTENSIONS, (GLuint)i);
        if (extension && strcmp(extension, name) == 0)
            return true;
    }
    return false;
}

/* The extensions tell in KiB. */
static bool memory(bool now_free, uint64_t *bytes)
{
    GLint kib[4] = { 0 };
    bool told = true;
    if (has_extension("GL_NVX_gpu_memory_info"))
        glGetIntegerv(now_free ? GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX : GL_GPU_MEMORY_INFO_DEDICATED_VIDMEM_NVX, kib);
    else if (has_extension("GL_ATI_meminfo"))
        glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, kib);
    else
        told = false;
    *bytes = (uint64_t)(GLuint)kib[0] * 1024; /* over 2 TiB the sign is lost, not the number */
    return told;
}

bool pel_device_free_bytes(const struct pel_device *device, uint64_t *bytes)
{
    return !device->info.software && memory(true, bytes);
}

bool pel_gl_describe(struct pel_device_info *info)
{
    copy_string(info->version, sizeof info->version, GL_VERSION);
    if (!info->version[0])
        return false;
    copy_string(info->name, sizeof info->name, GL_RENDERER);
    copy_string(info->vendor, sizeof info->vendor, GL_VENDOR);
    info->software = info->software || named_as_software(info->name);
    int major = 0, minor = 0;
    bool embedded = strncmp(info->version, "OpenGL ES", 9) == 0;
    info->usable = !embedded && sscanf(info->version, "%d.%d", &major, &minor) == 2 && (major > 4 || (major == 4 && minor >= 5));
    if (!info->usable) {
        snprintf(info->note, sizeof info->note, "not usable: OpenGL 4.5 is needed, and this is %s%s", embedded ? "" : "OpenGL ",
                 info->version);
        return true;
    }
    if (!info->software)
        memory(false, &info->memory_bytes);
    info->max_texture_2d = get_int(GL_MAX_TEXTURE_SIZE);
    info->max_texture_3d = get_int(GL_MAX_3D_TEXTURE_SIZE);
    info->max_array_layers = get_int(GL_MAX_ARRAY_TEXTURE_LAYERS);
    info->max_compute_invocations = get_int(GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);
    GLint64 bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    info->max_storage_buffer_bytes = bytes > 0 ? (uint64_t)bytes : 0;
    return true;
}

void pel_devices_compare(struct pel_device_info *infos, int count)
{
    int best = -1;
    for (int i = count - 1; i >= 0; i--)
        if (infos[i].usable && (best < 0 || !infos[i].software || infos[best].software))
            best = i;
    for (int i = 0; i < count; i++) {
        struct pel_device_info *info = &infos[i];
        if (!info->usable)
            continue; /* its note says why */
        info->chosen = i == best;
        if (i == best)
            snprintf(info->note, sizeof info->note, "%s",
                     info->software ? "chosen where a GPU is asked for: software, as no hardware GPU is usable" : "chosen: the first usable GPU");
        else if (info->software && !infos[best].software)
            snprintf(info->note, sizeof info->note, "usable, but software: GPU %d comes first", best);
        else
            snprintf(info->note, sizeof info->note, "usable: GPU %d comes first", best);
    }
}
