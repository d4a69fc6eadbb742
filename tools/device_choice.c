/* SPDX-License-Identifier: MIT */
/* --device: auto, cpu, gpu, gpu:N. */
#include <glob.h>
#include <stdlib.h>
#include <string.h>

#include "scene_arguments.h"

/* Is there a device file of a GPU's driver? Opening EGL only to find software costs a tenth of a second, which is most of what a small
 * picture takes. */
static bool gpu_file_exists(void)
{
    static const char *const patterns[] = { "/dev/dri/renderD*", "/dev/nvidia[0-9]*", "/dev/dxg" };
    bool found = false;
    for (size_t i = 0; i < sizeof patterns / sizeof *patterns && !found; i++) {
        glob_t paths;
        found = glob(patterns[i], GLOB_NOSORT, NULL, &paths) == 0;
        if (found)
            globfree(&paths);
    }
    return found;
}

/* Hardware, or software where there is no CPU engine to take its place. */
static void choose_automatically(struct loaded_scene *loaded, const struct pel_technique_info *technique,
                                 const struct pel_device_params *params)
{
    bool on_cpu = technique->engines & PEL_ENGINE_CPU;
    struct pel_error why = PEL_ERROR_INIT;
    if (on_cpu && !gpu_file_exists()) {
        snprintf(loaded->device_note, sizeof loaded->device_note, "no hardware GPU");
        return;
    }
    loaded->device = pel_device_create(-1, params, &why);
    if (!loaded->device) {
        snprintf(loaded->device_note, sizeof loaded->device_note, "%.200s", why.message);
        return;
    }
    if (on_cpu && pel_device_describe(loaded->device)->software) {
        snprintf(loaded->device_note, sizeof loaded->device_note, "no hardware GPU; software OpenGL would be slower");
        pel_device_destroy(loaded->device);
        loaded->device = NULL;
    }
}

/* Of gpu and gpu:N: the device's number, -1 for the best. */
static int device_number(const char *text)
{
    return text[3] ? (int)strtol(text + 4, NULL, 10) : -1;
}

bool scene_check_device(const struct loaded_scene *loaded, const struct scene_arguments *values, struct pel_error *error)
{
    const struct pel_technique_info *technique = pel_technique_find(loaded->technique);
    const char *text = values->device;
    bool cpu = strcmp(text, "cpu") == 0;
    size_t digits = strncmp(text, "gpu:", 4) == 0 ? strspn(text + 4, "0123456789") : 0;
    bool gpu = strcmp(text, "gpu") == 0 || (digits > 0 && digits < 4 && !text[4 + digits]);
    if (!cpu && !gpu && strcmp(text, "auto") != 0)
        return tool_fail(error, PEL_ERROR_ARGUMENT,
                         "--device: there is no %.40s; say auto, cpu, gpu, or gpu:N (`pellucid devices` lists them)", text);
    if (cpu && !(technique->engines & PEL_ENGINE_CPU))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--device cpu: %s draws on a GPU alone", technique->name);
    if (gpu && !(technique->engines & PEL_ENGINE_GPU))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--device %s: %s draws on the CPU alone", text, technique->name);
    return true;
}

bool scene_leave_device(struct loaded_scene *loaded, const struct scene_arguments *values, const char *why)
{
    const struct pel_technique_info *technique = pel_technique_find(loaded->technique);
    if (!loaded->device || strcmp(values->device, "auto") != 0 || !(technique->engines & PEL_ENGINE_CPU))
        return false;
    snprintf(loaded->device_note, sizeof loaded->device_note, "the GPU refused: %.200s", why);
    loaded->device = NULL;
    return true;
}

bool scene_open_device(struct loaded_scene *loaded, const struct scene_arguments *values, struct pel_error *error)
{
    const struct pel_technique_info *technique = pel_technique_find(loaded->technique);
    struct pel_device_params params = PEL_DEVICE_PARAMS_INIT;
    params.memory_limit = (uint64_t)(values->gpu_memory * 1e6);
    if (strcmp(values->device, "cpu") == 0)
        return true;
    if (strcmp(values->device, "auto") == 0) {
        if (technique->engines & PEL_ENGINE_GPU)
            choose_automatically(loaded, technique, &params);
        return true;
    }
    loaded->device = pel_device_create(device_number(values->device), &params, error);
    return loaded->device || tool_fail_in(error, "--device");
}
