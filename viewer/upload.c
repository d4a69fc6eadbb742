/* SPDX-License-Identifier: MIT */
/* Volumes sent by a page: each into a folder of its own below a temporary one, under the name that it was given, for endings tell formats.
 */
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
    int fd; /* -1: there is no file, or it is finished */
    uint64_t left;
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

static bool make_folder(struct server *server)
{
    char path[3072];
    if (server->folder)
        return true;
    if (snprintf(path, sizeof path, "%s/pellucid-view-XXXXXX", temporary_folder()) >= (int)sizeof path || !mkdtemp(path))
        return false;
    server->folder = strdup(path);
    return server->folder;
}

/* The file and its folder. */
static void remove_upload(const char *path)
{
    char folder[4096];
    snprintf(folder, sizeof folder, "%s", path);
    *strrchr(folder, '/') = 0;
    unlink(path);
    rmdir(folder);
}

/* Keeps a finished one; the oldest make room, but for what is open, which undo and a reload of the page may read again. */
static bool keep(struct server *server, const char *path)
{
    char *copy = strdup(path);
    int i = 0;
    while (server->kept_count == UPLOADS_KEPT && i < UPLOADS_KEPT && !session_forget(server->session, server->kept[i]))
        i++;
    if (!copy || i == UPLOADS_KEPT) {
        free(copy);
        return false;
    }
    if (server->kept_count == UPLOADS_KEPT) {
        remove_upload(server->kept[i]);
        free(server->kept[i]);
        memmove(server->kept + i, server->kept + i + 1, (size_t)(--server->kept_count - i) * sizeof *server->kept);
    }
    server->kept[server->kept_count++] = copy;
    return true;
}

void uploads_finish(struct server *server)
{
    while (server->kept_count > 0) {
        remove_upload(server->kept[--server->kept_count]);
        free(server->kept[server->kept_count]);
    }
    if (server->folder)
        rmdir(server->folder);
    free(server->folder);
    server->folder = NULL;
}

static void end_writing(struct upload *upload)
{
    close(upload->fd);
    upload->fd = -1;
    upload->server->uploading--;
}

void upload_drop(struct exchange *exchange)
{
    struct upload *upload = exchange->upload;
    if (!upload)
        return;
    if (upload->fd >= 0) { /* not finished */
        end_writing(upload);
        remove_upload(upload->path);
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

static bool open_file(struct server *server, struct upload *upload, const char *name)
{
    char folder[3200];
    if (!make_folder(server))
        return false;
    snprintf(folder, sizeof folder, "%s/%u", server->folder, ++server->uploads);
    snprintf(upload->path, sizeof upload->path, "%s/%.127s", folder, name);
    if (mkdir(folder, 0700) != 0)
        return false;
    upload->fd = open(upload->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (upload->fd < 0)
        rmdir(folder);
    else
        server->uploading++;
    return upload->fd >= 0;
}

int upload_begin(struct server *server, struct lws *wsi, struct exchange *exchange)
{
    char name[1024], length[32], *end;
    struct upload *upload = calloc(1, sizeof *upload);
    if (!upload)
        return http_refuse(wsi, HTTP_STATUS_INTERNAL_SERVER_ERROR);
    upload->server = server;
    upload->fd = -1;
    exchange->upload = upload;
    if (server->uploading >= MOST_UPLOADING)
        return refuse(wsi, exchange, HTTP_STATUS_SERVICE_UNAVAILABLE,
                      "other files are being sent already; send this one when they are done");
    if (lws_hdr_copy(wsi, length, sizeof length, WSI_TOKEN_HTTP_CONTENT_LENGTH) <= 0)
        return refuse(wsi, exchange, 411, "the length of the file is missing");
    errno = 0;
    upload->left = strtoull(length, &end, 10);
    if (errno || *end || upload->left > server->params.most_upload) {
        char why[160];
        snprintf(why, sizeof why,
                 "the file is larger than %.0f MB; start pellucid view with a larger --max-upload, or open it from a folder",
                 (double)server->params.most_upload / 1e6);
        return refuse(wsi, exchange, 413, why);
    }
    const char *value = lws_get_urlarg_by_name(wsi, "name=", name, sizeof name - 1);
    if (value && strncmp(value, "name=", 5) == 0) /* as some versions give it */
        value += 5;
    if (value)
        memmove(name, value, strlen(value) + 1);
    if (!value || !clean_name(name))
        return refuse(wsi, exchange, HTTP_STATUS_BAD_REQUEST, "the file's name is missing, or no name of a file");
    if (!open_file(server, upload, name))
        return refuse(wsi, exchange, HTTP_STATUS_INTERNAL_SERVER_ERROR, "no temporary file can be made; set TMPDIR to another folder");
    return 0;
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

int upload_end(struct server *server, struct lws *wsi, struct exchange *exchange)
{
    struct upload *upload = exchange->upload;
    struct pel_error error = PEL_ERROR_INIT;
    if (!upload)
        return 0;
    if (upload->left > 0)
        return refuse(wsi, exchange, HTTP_STATUS_BAD_REQUEST, "the file ended too soon");
    end_writing(upload);
    if (!session_allow(server->session, upload->path, &error) || !keep(server, upload->path)) {
        session_forget(server->session, upload->path);
        remove_upload(upload->path);
        if (!error.code)
            strcpy(error.message, "no memory to keep another file");
        return refuse(wsi, exchange, HTTP_STATUS_INTERNAL_SERVER_ERROR, error.message);
    }
    json_t *json = json_pack("{s:s}", "path", upload->path);
    char *text = json ? json_dumps(json, JSON_COMPACT) : NULL;
    json_decref(json);
    upload_drop(exchange);
    return http_answer(wsi, exchange, HTTP_STATUS_OK, "application/json", text);
}
