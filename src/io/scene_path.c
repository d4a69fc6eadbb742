/* SPDX-License-Identifier: MIT */
#include "scene_path.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"

/* Length of the folder's part of a path, with its slash. */
static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

static bool store(char *out, size_t size, int length, struct pel_error *error)
{
    (void)out;
    if (length < 0 || (size_t)length >= size)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the path is too long");
    return true;
}

bool pel_path_from_file(const char *file, const char *path, char *out, size_t size, struct pel_error *error)
{
    size_t folder = path[0] == '/' ? 0 : folder_length(file);
    return store(out, size, snprintf(out, size, "%.*s%s", (int)folder, file, path), error);
}

/* The real path of the folder that `path` lies in (its last part too where `whole`), or false. */
static bool real_path(const char *path, bool whole, char out[PATH_MAX])
{
    char folder[PATH_MAX];
    if (whole)
        return realpath(path, out) != NULL;
    size_t length = folder_length(path);
    if (length >= sizeof folder)
        return false;
    memcpy(folder, path, length);
    folder[length] = 0;
    return realpath(length ? folder : ".", out) != NULL;
}

bool pel_path_to_file(const char *file, const char *path, char *out, size_t size, struct pel_error *error)
{
    char folder[PATH_MAX], target[PATH_MAX];
    if (!real_path(file, false, folder) || !real_path(path, true, target))
        return store(out, size, snprintf(out, size, "%s", path), error);
    size_t same = 0;
    for (size_t i = 0;; i++) { /* the length of the folders that both have */
        bool folder_ends = folder[i] == '/' || !folder[i], target_ends = target[i] == '/' || !target[i];
        if (folder_ends && target_ends)
            same = i;
        if (folder[i] != target[i] || !folder[i])
            break;
    }
    if (same == 0 || (same == 1 && folder[0] == '/' && folder[1]))
        return store(out, size, snprintf(out, size, "%s", target), error);
    size_t used = 0;
    out[0] = 0;
    for (const char *p = folder + same; *p; p++)
        if (*p == '/' && p[1] && used + 3 < size) {
            memcpy(out + used, "../", 4);
            used += 3;
        }
    const char *rest = target[same] == '/' ? target + same + 1 : target + same;
    return store(out, size, (int)used + snprintf(out + used, size - used, "%s", *rest ? rest : "."), error);
}
