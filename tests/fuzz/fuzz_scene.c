/* SPDX-License-Identifier: MIT */
/* libFuzzer target for scene files: what is read must be valid, and must be written and read again. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void check_again(const struct pel_scene *scene)
{
    struct pel_scene again;
    struct pel_error error = PEL_ERROR_INIT;
    json_t *json = pel_scene_to_json(scene, "scene.json", &error);
    char *text = json ? json_dumps(json, JSON_REAL_PRECISION(17)) : NULL;
    if (!text || !pel_scene_init(&again, NULL))
        abort();
    if (!pel_scene_from_text(text, strlen(text), "scene.json", &again, NULL, &error))
        abort();
    if (!pel_transfer_equal(&scene->transfer, &again.transfer))
        abort();
    pel_scene_finish(&again);
    free(text);
    json_decref(json);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    struct pel_scene scene;
    struct pel_scene_parts has;
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_scene_init(&scene, &error))
        return 0;
    if (pel_scene_from_text((const char *)bytes, size, "folder/scene.json", &scene, &has, &error))
        check_again(&scene);
    else if (error.code == PEL_ERROR_NONE || !error.message[0] || strchr(error.message, '\n'))
        abort();
    pel_scene_finish(&scene);
    return 0;
}
