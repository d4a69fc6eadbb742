/* SPDX-License-Identifier: MIT */
/* What may be opened: the files and folders that were named, and what lies below them. Paths are judged after links and ".." were followed.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "session_inside.h"

enum { MOST_ENTRIES = 4096, MOST_NAMES = 1 << 16, MOST_LISTINGS = 8, LOOK_AT = 32 };

static bool is_below(const char *path, const char *root)
{
    size_t length = strlen(root);
    if (strcmp(root, "/") == 0)
        return true;
    return strncmp(path, root, length) == 0 && (path[length] == 0 || path[length] == '/');
}

static bool is_allowed(const struct session *s, const char *real)
{
    bool fine = false;
    for (int i = 0; !fine && s->paths && s->paths[i]; i++)
        fine = is_below(real, s->paths[i]);
    return fine;
}

bool session_is_named(struct session *s, const char *path)
{
    struct stat st;
    char *real = realpath(path, NULL);
    bool file = real && stat(real, &st) == 0 && !S_ISDIR(st.st_mode), fine = false;
    pthread_mutex_lock(&s->lock);
    for (int i = 0; file && i < s->named; i++)
        fine |= strcmp(real, s->paths[i]) == 0;
    pthread_mutex_unlock(&s->lock);
    free(real);
    return fine;
}

/* The uploaded folder that a path is in, or is; NULL: none. With the lock held. */
static const char *upload_of(const struct session *s, const char *real)
{
    for (int i = s->named; s->paths && s->paths[i]; i++)
        if (is_below(real, s->paths[i]))
            return s->paths[i];
    return NULL;
}

bool session_is_upload(const struct session *s, const char *path)
{
    const char *upload = upload_of(s, path);
    return upload && strcmp(path, upload) != 0; /* a whole folder has no name of the user's */
}

bool session_may_open(struct session *s, const char *path)
{
    char *real = realpath(path, NULL);
    pthread_mutex_lock(&s->lock);
    bool fine = real && is_allowed(s, real);
    pthread_mutex_unlock(&s->lock);
    free(real);
    return fine;
}

bool session_may_read(struct session *s, const char *header, const char *path)
{
    char *real = realpath(path, NULL), *from = realpath(header, NULL);
    pthread_mutex_lock(&s->lock);
    const char *upload = from ? upload_of(s, from) : NULL;
    bool fine = real && (upload ? is_below(real, upload) : is_allowed(s, real));
    pthread_mutex_unlock(&s->lock);
    free(from);
    free(real);
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

bool session_forget(struct session *s, const char *path)
{
    char *real = realpath(path, NULL);
    pthread_mutex_lock(&s->lock);
    bool open = real && s->volume && is_below(s->scene.source.path, real);
    char **kept = s->paths ? s->paths + s->named : NULL;
    for (char **at = kept; at && *at && !open; at++)
        if (real && strcmp(*at, real) == 0)
            free(*at);
        else
            *kept++ = *at;
    if (kept && !open)
        *kept = NULL;
    pthread_mutex_unlock(&s->lock);
    free(real);
    return !open;
}

/* ---- list ---- */

static bool name_ends(const char *name, size_t length, const char *ending, size_t tail)
{
    return length > tail && strncasecmp(name + length - tail, ending, tail) == 0;
}

/* By the name alone: a folder is not read through to be listed. Raw samples are left out: a header beside them is what opens them. */
static bool looks_readable(const char *name)
{
    const struct pel_format_info *format;
    size_t length = strlen(name);
    if (name_ends(name, length, ".json", 5))
        return true;
    if (name_ends(name, length, ".gz", 3))
        length -= 3;
    for (size_t i = 0; (format = pel_format_at(i)); i++)
        for (const char *ending = format->endings; format->reads && strcmp(format->name, "raw") != 0 && ending && *ending;) {
            size_t tail = strcspn(ending, " ");
            if (tail > 0 && name_ends(name, length, ending, tail))
                return true;
            ending += tail + strspn(ending + tail, " ");
        }
    return name_ends(name, length, ".dcm", 4);
}

/* By its name, or by DICOM's sign: scanners write files without an ending. */
static bool looks_like_slice(int folder, const char *name)
{
    size_t length = strlen(name);
    char sign[4];
    struct stat st;
    if (name_ends(name, length, ".dcm", 4) || name_ends(name, length, ".tif", 4) || name_ends(name, length, ".tiff", 5))
        return true;
    if (strchr(name, '.') && strspn(name, "0123456789.") != length)
        return false;
    int fd = fstatat(folder, name, &st, 0) == 0 && S_ISREG(st.st_mode) ? openat(folder, name, O_RDONLY | O_CLOEXEC | O_NONBLOCK) : -1;
    bool found = fd >= 0 && pread(fd, sign, sizeof sign, 128) == (ssize_t)sizeof sign && memcmp(sign, "DICM", sizeof sign) == 0;
    if (fd >= 0)
        close(fd);
    return found;
}

/* Is a folder one to be opened as a whole? A look at its first files says so: a guess, but one that reads little. */
static bool holds_slices(const char *path)
{
    const struct dirent *entry;
    DIR *folder = opendir(path);
    int found = 0;
    for (int looked = 0; folder && found < 2 && looked < LOOK_AT && (entry = readdir(folder));) {
        if (entry->d_name[0] == '.' || entry->d_type == DT_DIR)
            continue;
        looked++;
        found += looks_like_slice(dirfd(folder), entry->d_name);
    }
    if (folder)
        closedir(folder);
    return found == 2;
}

/* NULL where it is nothing to be opened. */
static json_t *entry_json(const char *path, const char *name, bool named)
{
    struct stat st;
    if (stat(path, &st) != 0 || (!S_ISDIR(st.st_mode) && !S_ISREG(st.st_mode)) || (!named && !S_ISDIR(st.st_mode) && !looks_readable(name)))
        return NULL;
    bool folder = S_ISDIR(st.st_mode);
    return json_pack("{s:s, s:s, s:b, s:b, s:I}", "name", name, "path", path, "folder", (int)folder, "series",
                     (int)(folder && holds_slices(path)), "bytes", (json_int_t)st.st_size);
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

static int compare(const void *a, const void *b)
{
    return strverscmp(*(char *const *)a, *(char *const *)b);
}

/* The names in a folder, in order; what is hidden is left out, and what is beyond MOST_NAMES. Owned; negative: it cannot be read. */
static int read_names(const char *path, char ***names)
{
    const struct dirent *entry;
    DIR *folder = opendir(path);
    int count = 0;
    *names = folder ? malloc(MOST_NAMES * sizeof **names) : NULL;
    while (*names && count < MOST_NAMES && (entry = readdir(folder)))
        if (entry->d_name[0] != '.' && ((*names)[count] = strdup(entry->d_name)))
            count++;
    if (folder)
        closedir(folder);
    if (!*names)
        return -1;
    qsort(*names, (size_t)count, sizeof **names, compare);
    return count;
}

static bool list_folder(const char *path, json_t *list, struct pel_error *error)
{
    char **names;
    int count = read_names(path, &names);
    if (count < 0)
        return session_fail(error, PEL_ERROR_IO, "path: %.300s: %s", path, strerror(errno));
    for (int i = 0; i < count; i++) {
        char whole[PEL_OPTION_TEXT_SIZE];
        if (json_array_size(list) < MOST_ENTRIES &&
            snprintf(whole, sizeof whole, "%s/%s", strcmp(path, "/") ? path : "", names[i]) < (int)sizeof whole)
            add(list, entry_json(whole, names[i], false));
        free(names[i]);
    }
    free(names);
    return true;
}

/* A folder that is being listed. Its disk may be slow, or asleep, or behind a network: nobody waits for it but who asked. */
struct listing {
    struct session *session;
    int client;
    bool has_id;
    int64_t id;
    char path[PEL_OPTION_TEXT_SIZE]; /* "": what was named */
};

/* A folder of slices is told as one, what else was uploaded by its files: the name of their folder says nothing. */
static void list_upload(const char *path, json_t *list)
{
    char **names, title[300] = "";
    if (!holds_slices(path)) {
        list_folder(path, list, NULL);
        return;
    }
    int count = read_names(path, &names);
    if (count > 0)
        snprintf(title, sizeof title, "%s and %d more", names[0], count - 1);
    for (int i = 0; i < count; i++)
        free(names[i]);
    if (count >= 0)
        free(names);
    if (title[0])
        add(list, entry_json(path, title, true));
}

/* What was named, and uploads. */
static json_t *list_named(struct session *s)
{
    json_t *names = json_array(), *list = json_array(), *name;
    size_t i;
    pthread_mutex_lock(&s->lock);
    size_t named = (size_t)s->named;
    for (char **path = s->paths; path && *path; path++)
        add(names, json_string(*path));
    pthread_mutex_unlock(&s->lock);
    json_array_foreach(names, i, name) {
        const char *path = json_string_value(name);
        if (i < named)
            add(list, entry_json(path, last_part(path), true));
        else
            list_upload(path, list);
    }
    json_decref(names);
    return json_pack("{s:s, s:n, s:n, s:b, s:o}", "event", "files", "path", "parent", "series", 0, "entries", list);
}

/* The event; NULL on failure. */
static json_t *list_json(const struct listing *listing, struct pel_error *error)
{
    if (!listing->path[0])
        return list_named(listing->session);
    json_t *list = json_array(), *event = NULL;
    char *real = session_may_open(listing->session, listing->path) ? realpath(listing->path, NULL) : NULL;
    if (!real) {
        session_fail(error, PEL_ERROR_ARGUMENT, "path: it is not below the folders that may be opened");
    } else if (list_folder(real, list, error)) {
        char parent[PEL_OPTION_TEXT_SIZE];
        snprintf(parent, sizeof parent, "%s", real);
        char *slash = strrchr(parent, '/');
        slash[slash == parent] = 0;
        bool up = strcmp(real, "/") != 0 && session_may_open(listing->session, parent);
        event = json_pack("{s:s, s:s, s:s?, s:b, s:O}", "event", "files", "path", real, "parent", up ? parent : NULL, "series",
                          (int)holds_slices(real), "entries", list);
        if (!event)
            session_fail(error, PEL_ERROR_ARGUMENT, "path: " SESSION_NO_TEXT);
    }
    json_decref(list);
    free(real);
    return event;
}

static void *list_away(void *user)
{
    struct listing *listing = user;
    struct session *s = listing->session;
    const struct call call = { .name = "list", .has_id = listing->has_id, .id = listing->id };
    struct pel_error error = PEL_ERROR_INIT;
    json_t *event = list_json(listing, &error);
    pthread_mutex_lock(&s->lock);
    if (event)
        session_tell(s, listing->client, event, &call);
    else
        session_tell_error(s, listing->client, &error, &call);
    s->listings--;
    session_thread_ends(s);
    pthread_mutex_unlock(&s->lock);
    free(listing);
    return NULL;
}

bool run_list(struct call *call)
{
    struct session *s = call->session;
    const char *path = call_has(call, "path") ? call_text(call, "path", PEL_OPTION_TEXT_SIZE) : "";
    if (!path)
        return false;
    if (s->listings >= MOST_LISTINGS)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "%d folders are being listed; wait for them", s->listings);
    struct listing *listing = calloc(1, sizeof *listing);
    if (!listing)
        return session_fail(call->error, PEL_ERROR_MEMORY, "no memory to list a folder");
    listing->session = s;
    listing->client = call->client->number;
    listing->has_id = call->has_id;
    listing->id = call->id;
    strcpy(listing->path, path);
    if (!session_thread(s, list_away, listing, call->error)) {
        free(listing);
        return false;
    }
    s->listings++;
    return true;
}

bool run_open(struct call *call)
{
    const char *path = call_text(call, "path", PEL_OPTION_TEXT_SIZE), *array = NULL;
    if (!path || (call_has(call, "array") && !(array = call_text(call, "array", sizeof((struct pel_source *)0)->array))))
        return false;
    return session_open(call->session, call, path, array, NULL, 0,
                        call->error); /* whether it may, its thread finds out: a disk may be slow */
}
