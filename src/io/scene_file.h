/* SPDX-License-Identifier: MIT */
/* The two halves of the scene file, apart from the file: so that tests and fuzzing need none. */
#ifndef PEL_IO_SCENE_FILE_H
#define PEL_IO_SCENE_FILE_H

#include <jansson.h>

#include <pellucid/io.h>

/* Reads a scene from JSON text. `path` is what relative paths are relative to. Messages name keys ("camera.camera-view-angle: ..."), no
 * file. */
bool pel_scene_parse(const char *text, size_t size, const char *path, struct pel_scene *scene, struct pel_scene_parts *has,
                     struct pel_error *error);

/* The scene as JSON, to be decref'd; NULL on failure. */
json_t *pel_scene_to_json(const struct pel_scene *scene, const char *path, struct pel_error *error);

#endif
