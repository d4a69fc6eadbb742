/* SPDX-License-Identifier: MIT */
/* Paths relative to the file that names them, so that a scene and its volume can be moved together. */
#ifndef PEL_IO_SCENE_PATH_H
#define PEL_IO_SCENE_PATH_H

#include <stddef.h>

#include <pellucid/error.h>

/* What `path`, as written in `file`, means to the process: put behind the folder of `file` unless it is absolute. */
bool pel_path_from_file(const char *file, const char *path, char *out, size_t size, struct pel_error *error);

/* `path`, as the process sees it, as it should be written into `file`: relative to its folder, or absolute where they share nothing but the
 * root. Both need not exist. */
bool pel_path_to_file(const char *file, const char *path, char *out, size_t size, struct pel_error *error);

#endif
