/* SPDX-License-Identifier: MIT */
/* Files sent by a page: those of one drop into a folder of their own below a temporary one, under the names that they were given, for
 * endings tell formats and headers name their data. Nothing else is put there, and nothing is written twice.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "downloads.h"
#include "server_inside.h"

struct upload {
    struct server *server;
    unsigned folder; /* its number */
    int fd;          /* -1: there is no file, or it is finished */
    uint64_t size, left;
    char path[4096];
};

/* The file's own name: no folders, nothing hidden, nothing that a terminal or header would take for more than a letter. */
static bool clean_name(char *name)
{
    char *slash = strrchr(name, '/'), *back = strrchr(name, '\\');
    if (back > slash)
        slash = back;
    if (slash)
        memmove(name, slash + 1, strlen(slash + 1) + 1);
    for (char *at = name; *at; at++)
        if ((unsigned char)*at < 32 || *at == 127 || *at == '"')
            return false;
    return name[0] && name[0] != '.' && strlen(name) < 128 && session_is_text(name);
}

/* ---- folders ---- */

enum { FOLDER_PATH = 3200 };

static void folder_path(const struct server *server, unsigned number, char path[FOLDER_PATH])
{
    snprintf(path, FOLDER_PATH, "%s/%u", server->folder, number);
}

static struct upload_folder *find_folder(struct server *server, unsigned number)
{
    for (int i = 0; i < server->kept_count; i++)
        if (server->kept[i].number == number)
            return &server->kept[i];
    return NULL;
}

static bool make_temporary(struct server *server)
{
    char path[3072];
    if (server->folder)
        return true;
    if (snprintf(path, sizeof path, "%s/pellucid-view-XXXXXX", temporary_folder()) >= (int)sizeof path || !mkdtemp(path))
        return false;
    server->folder = strdup(path);
    return server->folder;
}

/* With the files in it. */
static void remove_folder(struct server *server, struct upload_folder *folder)
{
    char path[FOLDER_PATH];
    const struct dirent *entry;
    folder_path(server, folder->number, path);
    DIR *listing = opendir(path);
    while (listing && (entry = readdir(listing)))
        unlinkat(dirfd(listing), entry->d_name, 0); /* not "." and "..", which it refuses */
    if (listing)
        closedir(listing);
    rmdir(path);
    server->kept_count--;
    memmove(folder, folder + 1, (size_t)(server->kept + server->kept_count - folder) * sizeof *folder);
}

/* The oldest makes room, but for those that files are being sent to, and what is open, which undo and a reload of the page may read again.
 */
static bool make_room(struct server *server)
{
    char path[FOLDER_PATH];
    for (int i = 0; server->kept_count == UPLOADS_KEPT && i < UPLOADS_KEPT; i++) {
        folder_path(server, server->kept[i].number, path);
        if (server->kept[i].writing == 0 && session_forget(server->session, path))
            remove_folder(server, &server->kept[i]);
    }
    return server->kept_count < UPLOADS_KEPT;
}

static struct upload_folder *new_folder(struct server *server)
{
    char path[FOLDER_PATH];
    if (!make_temporary(server) || !make_room(server))
        return NULL;
    folder_path(server, ++server->uploads, path);
    if (mkdir(path, 0700) != 0)
        return NULL;
    if (!session_allow(server->session, path, NULL)) {
        rmdir(path);
        return NULL;
    }
    struct upload_folder *folder = &server->kept[server->kept_count++];
    *folder = (struct upload_folder) { .number = server->uploads };
    return folder;
}

/* Where nothing came of its first file. */
static void drop_if_empty(struct server *server, struct upload_folder *folder)
{
    char path[FOLDER_PATH];
    if (folder->files > 0)
        return;
    folder_path(server, folder->number, path);
    if (server->session) /* else both are ending */
        session_forget(server->session, path);
    remove_folder(server, folder);
}

void uploads_finish(struct server *server)
{
    while (server->kept_count > 0)
        remove_folder(server, &server->kept[server->kept_count - 1]);
    if (server->folder)
        rmdir(server->folder);
    free(server->folder);
    server->folder = NULL;
}

/* ---- files ---- */

static void end_writing(struct upload *upload)
{
    close(upload->fd);
    upload->fd = -1;
    upload->server->uploading--;
    find_folder(upload->server, upload->folder)->writing--;
}

void upload_drop(struct exchange *exchange)
{
    struct upload *upload = exchange->upload;
    if (!upload)
        return;
    if (upload->fd >= 0) { /* not finished */
        struct upload_folder *folder = find_folder(upload->server, upload->folder);
        end_writing(upload);
        unlink(upload->path);
        folder->files--;
        folder->bytes -= upload->size;
        drop_if_empty(upload->server, folder);
    }
    free(upload);
    exchange->upload = NULL;
}

static int refuse(struct lws *wsi, struct exchange *exchange, unsigned status, const char *why)
{
    json_t *json = json_pack("{s:s}", "error", why);
    char *text = json ? json_dumps(json, JSON_COMPACT) : NULL;
    json_decref(json);
    upload_drop(exchange);
    return http_answer(wsi, exchange, status, "application/json", text);
}

/* What the address says behind "key=", or NULL. */
static const char *argument(struct lws *wsi, const char *key, char *text, size_t size)
{
    const char *value = lws_get_urlarg_by_name(wsi, key, text, (int)size - 1);
    return value && strncmp(value, key, strlen(key)) == 0 ? value + strlen(key) : value; /* as some versions give it */
}

/* Its size is known before anything is written, and counts from now on. */
static unsigned check_size(const struct server *server, struct lws *wsi, struct upload *upload, const struct upload_folder *folder,
                           char why[200])
{
    char length[32], *end;
    uint64_t most = server->params.most_upload;
    if (lws_hdr_copy(wsi, length, sizeof length, WSI_TOKEN_HTTP_CONTENT_LENGTH) <= 0) {
        strcpy(why, "the length of the file is missing");
        return 411;
    }
    errno = 0;
    upload->size = upload->left = strtoull(length, &end, 10);
    if (errno || *end || upload->size > most - (folder ? folder->bytes : 0)) {
        snprintf(why, 200, "%s larger than %.0f MB; start pellucid view with a larger --max-upload, or open %s from a folder",
                 folder ? "the files sent together are" : "the file is", (double)most / 1e6, folder ? "them" : "it");
        return 413;
    }
    if (folder && folder->files == MOST_UPLOAD_FILES) {
        snprintf(why, 200, "no more than %d files are taken at once; open them from a folder", MOST_UPLOAD_FILES);
        return 413;
    }
    return 0;
}

/* The folder that the page asks for: `*folder` is NULL where it asks for a new one. */
static bool asked_folder(struct server *server, struct lws *wsi, struct upload_folder **folder)
{
    char number[1024], *end = number;
    const char *value = argument(wsi, "folder=", number, sizeof number);
    *folder = NULL;
    if (!value)
        return true;
    unsigned long k = value[0] >= '0' && value[0] <= '9' ? strtoul(value, &end, 10) : 0;
    if (k > 0 && k <= server->uploads && !*end)
        *folder = find_folder(server, (unsigned)k);
    return *folder;
}

static unsigned open_file(struct server *server, struct upload *upload, struct upload_folder *folder, const char *name, char why[200])
{
    char path[FOLDER_PATH];
    strcpy(why, "no temporary file can be made; set TMPDIR to another folder");
    if (!folder && !(folder = new_folder(server)))
        return HTTP_STATUS_INTERNAL_SERVER_ERROR;
    folder_path(server, folder->number, path);
    snprintf(upload->path, sizeof upload->path, "%s/%.127s", path, name);
    upload->folder = folder->number;
    upload->fd = open(upload->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (upload->fd < 0 && errno == EEXIST) {
        strcpy(why, "a file of this name was sent already; send files of different names");
        return HTTP_STATUS_CONFLICT;
    }
    if (upload->fd < 0) {
        drop_if_empty(server, folder);
        return HTTP_STATUS_INTERNAL_SERVER_ERROR;
    }
    server->uploading++;
    folder->writing++;
    folder->files++;
    folder->bytes += upload->size;
    return 0;
}

/* 0, or the status of a refusal. */
static unsigned prepare(struct server *server, struct lws *wsi, struct upload *upload, char why[200])
{
    char text[1024], name[1024];
    struct upload_folder *folder;
    if (server->uploading >= MOST_UPLOADING) {
        strcpy(why, "other files are being sent already; send this one when they are done");
        return HTTP_STATUS_SERVICE_UNAVAILABLE;
    }
    if (!asked_folder(server, wsi, &folder)) {
        strcpy(why, "the files that it belongs to are no longer kept; send all of them again");
        return HTTP_STATUS_NOT_FOUND;
    }
    unsigned status = check_size(server, wsi, upload, folder, why);
    if (status)
        return status;
    const char *value = argument(wsi, "name=", text, sizeof text);
    snprintf(name, sizeof name, "%s", value ? value : "");
    if (!clean_name(name)) {
        strcpy(why, "the file's name is missing, or no name of a file");
        return HTTP_STATUS_BAD_REQUEST;
    }
    return open_file(server, upload, folder, name, why);
}

int upload_begin(struct server *server, struct lws *wsi, struct exchange *exchange)
{
    char why[200];
    struct upload *upload = calloc(1, sizeof *upload);
    if (!upload)
        return http_refuse(wsi, HTTP_STATUS_INTERNAL_SERVER_ERROR);
    upload->server = server;
    upload->fd = -1;
    exchange->upload = upload;
    unsigned status = prepare(server, wsi, upload, why);
    return status ? refuse(wsi, exchange, status, why) : 0;
}

int upload_body(struct lws *wsi, struct exchange *exchange, const char *bytes, size_t size)
{
    struct upload *upload = exchange->upload;
    if (!upload)
        return 0; /* refused already */
    if (size > upload->left)
        return -1;
    upload->left -= size;
    if (!download_write(upload->fd, bytes, size, NULL))
        return refuse(wsi, exchange, 507, "the server's disk is full");
    return 0;
}

int upload_end(struct lws *wsi, struct exchange *exchange)
{
    struct upload *upload = exchange->upload;
    if (!upload)
        return 0;
    if (upload->left > 0)
        return refuse(wsi, exchange, HTTP_STATUS_BAD_REQUEST, "the file ended too soon");
    end_writing(upload);
    json_t *json = json_pack("{s:s, s:I}", "path", upload->path, "folder", (json_int_t)upload->folder);
    char *text = json ? json_dumps(json, JSON_COMPACT) : NULL;
    json_decref(json);
    upload_drop(exchange);
    return http_answer(wsi, exchange, HTTP_STATUS_OK, "application/json", text);
}
