/* SPDX-License-Identifier: MIT */
/* What may be opened: the files and folders that were named, and what lies below them. Paths are judged after links and ".." were followed. */
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "session_inside.h"

enum { MOST_ENTRIES = 4096 };

static bool is_below(const char *path, const char *root)
{
    size_t length = strlen(root);
    if (strcmp(root, "/") == 0)
        return true;
    return strncmp(path, root, length) == 0 && (path[length] == 0 || path[length] == '/');
}

bool session_path_allowed(const struct session *s, const char *path)
{
    char *real = realpath(path, NULL);
    bool fine = false;
    for (int i = 0; real && !fine && s->paths && s->paths[i]; i++)
        fine = is_below(real, s->paths[i]);
    free(real);
    return fine;
}

bool session_may_open(struct session *s, const char *path)
{
    pthread_mutex_lock(&s->lock);
    bool fine = session_path_allowed(s, path);
    pthread_mutex_unlock(&s->lock);
    return fine;
}

bool session_allow(struct session *s, const char *path, struct pel_error *error)
{
    char *real = realpath(path, NULL);
    if (!real)
        return session_fail(error, PEL_ERROR_IO, "%.300s: %s", path, strerror(errno));
    pthread_mutex_lock(&s->lock);
    int count = 0;
    while (s->paths && s->paths[count])
        count++;
    char **larger = realloc(s->paths, (size_t)(count + 2) * sizeof *larger);
    if (larger) {
        s->paths = larger;
        s->paths[count] = real;
        s->paths[count + 1] = NULL;
    }
    pthread_mutex_unlock(&s->lock);
    if (larger)
        return true;
    free(real);
    return session_fail(error, PEL_ERROR_MEMORY, "no memory for a path");
}

/* ---- list ---- */

static bool name_ends(const char *name, size_t length, const char *ending, size_t tail)
{
    return length > tail && strncasecmp(name + length - tail, ending, tail) == 0;
}

/* By the name alone: a folder is not read through to be listed. */
static bool looks_readable(const char *name)
{
    const struct pel_format_info *format;
    size_t length = strlen(name);
    if (name_ends(name, length, ".json", 5))
        return true;
    if (name_ends(name, length, ".gz", 3))
        length -= 3;
    for (size_t i = 0; (format = pel_format_at(i)); i++)
        for (const char *ending = format->endings; format->reads && ending && *ending;) {
            size_t tail = strcspn(ending, " ");
            if (tail > 0 && name_ends(name, length, ending, tail))
                return true;
            ending += tail + strspn(ending + tail, " ");
        }
    return name_ends(name, length, ".dcm", 4);
}

/* NULL where it is nothing to be opened. */
static json_t *entry_json(const char *path, const char *name, bool named)
{
    struct stat st;
    if (stat(path, &st) != 0 || (!S_ISDIR(st.st_mode) && !S_ISREG(st.st_mode)) || (!named && !S_ISDIR(st.st_mode) && !looks_readable(name)))
        return NULL;
    return json_pack("{s:s, s:s, s:b, s:I}", "name", name, "path", path, "folder", S_ISDIR(st.st_mode) ? 1 : 0, "bytes", (json_int_t)st.st_size);
}

static void add(json_t *list, json_t *entry)
{
    if (entry)
        json_array_append_new(list, entry);
}

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

static bool list_folder(const char *path, json_t *list, struct pel_error *error)
{
    struct dirent **names;
    int count = scandir(path, &names, NULL, versionsort);
    if (count < 0)
        return session_fail(error, PEL_ERROR_IO, "path: %.300s: %s", path, strerror(errno));
    for (int i = 0; i < count; i++) {
        char whole[PEL_OPTION_TEXT_SIZE];
        if (names[i]->d_name[0] != '.' && json_array_size(list) < MOST_ENTRIES &&
            snprintf(whole, sizeof whole, "%s/%s", strcmp(path, "/") ? path : "", names[i]->d_name) < (int)sizeof whole)
            add(list, entry_json(whole, names[i]->d_name, false));
        free(names[i]);
    }
    free(names);
    return true;
}

bool run_list(struct call *call)
{
    struct session *s = call->session;
    json_t *list = json_array();
    if (!call_has(call, "path")) {
        for (int i = 0; s->paths && s->paths[i]; i++)
            add(list, entry_json(s->paths[i], last_part(s->paths[i]), true));
        session_tell(s, call->client->number, json_pack("{s:s, s:n, s:n, s:o}", "event", "files", "path", "parent", "entries", list), call);
        return true;
    }
    const char *path = call_text(call, "path", PEL_OPTION_TEXT_SIZE);
    char *real = path && session_path_allowed(s, path) ? realpath(path, NULL) : NULL;
    bool fine = real ? list_folder(real, list, call->error) : path ? session_fail(call->error, PEL_ERROR_ARGUMENT, "path: it is not below the folders that may be opened") : false;
    if (fine) {
        char parent[PEL_OPTION_TEXT_SIZE];
        snprintf(parent, sizeof parent, "%s", real);
        char *slash = strrchr(parent, '/');
        slash[slash == parent] = 0;
        bool up = strcmp(real, "/") != 0 && session_path_allowed(s, parent);
        session_tell(s, call->client->number,
                     json_pack("{s:s, s:s, s:s?, s:O}", "event", "files", "path", real, "parent", up ? parent : NULL, "entries", list), call);
    }
    json_decref(list);
    free(real);
    return fine;
}

bool run_open(struct call *call)
{
    const char *path = call_text(call, "path", PEL_OPTION_TEXT_SIZE), *array = NULL;
    if (!path || (call_has(call, "array") && !(array = call_text(call, "array", sizeof((struct pel_source *)0)->array))))
        return false;
    if (!session_path_allowed(call->session, path))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "path: it is not below the folders that may be opened");
    return session_open(call->session, path, array, NULL, 0, call->error);
}
