/* SPDX-License-Identifier: MIT */
/* A scene as a tree of JSON, between the scene and its text or file. */
#ifndef PEL_IO_SCENE_FILE_H
#define PEL_IO_SCENE_FILE_H

#include <jansson.h>

#include <pellucid/io.h>

/* The scene as JSON, to be decref'd; NULL on failure. */
json_t *pel_scene_to_json(const struct pel_scene *scene, const char *path, struct pel_error *error);

#endif
