/* SPDX-License-Identifier: MIT */
/* The page's files, embedded or (PELLUCID_WEB) from a folder, and downloads. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server_inside.h"
#include "web_files.h"

enum { CHUNK = 1 << 16, MOST_FILE = 16 << 20 };

int http_refuse(struct lws *wsi, unsigned status)
{
    if (lws_return_http_status(wsi, status, NULL))
        return -1;
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

static const char *type_of(const char *name)
{
    static const struct {
        const char *ending, *type;
    } types[] = { { ".html", "text/html; charset=utf-8" },
                  { ".js", "text/javascript; charset=utf-8" },
                  { ".css", "text/css; charset=utf-8" },
                  { ".svg", "image/svg+xml" },
                  { ".png", "image/png" } };
    const char *ending = strrchr(name, '.');
    for (size_t i = 0; ending && i < sizeof types / sizeof *types; i++)
        if (strcmp(types[i].ending, ending) == 0)
            return types[i].type;
    return "application/octet-stream";
}

/* Headers that every answer has: nothing from elsewhere, nothing kept, nothing guessed, no address (with its token) told to others. */
static bool add_safety(const struct server *server, struct lws *wsi, unsigned char **at, unsigned char *end)
{
    char policy[512];
    snprintf(policy, sizeof policy,
             "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws://%s ws://localhost:%d; base-uri 'none'; form-action "
             "'none'; frame-ancestors 'none'",
             server->authority, server->port);
    const char *const headers[][2] = { { "content-security-policy:", policy },
                                       { "x-content-type-options:", "nosniff" },
                                       { "cache-control:", "no-store" },
                                       { "referrer-policy:", "no-referrer" },
                                       { "cross-origin-resource-policy:", "same-origin" } };
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++)
        if (lws_add_http_header_by_name(wsi, (const unsigned char *)headers[i][0], (const unsigned char *)headers[i][1],
                                        (int)strlen(headers[i][1]), at, end))
            return false;
    return true;
}

/* Sends the head; the body follows when the socket can take it. */
static int begin(const struct server *server, struct lws *wsi, const struct exchange *exchange, unsigned status, const char *type,
                 const char *name)
{
    unsigned char buffer[LWS_PRE + 2048], *start = buffer + LWS_PRE, *at = start, *end = buffer + sizeof buffer - 1;
    char disposition[200];
    if (lws_add_http_common_headers(wsi, status, type, exchange->size, &at, end) || !add_safety(server, wsi, &at, end))
        return -1;
    if (name) {
        snprintf(disposition, sizeof disposition, "attachment; filename=\"%s\"", name);
        if (lws_add_http_header_by_name(wsi, (const unsigned char *)"content-disposition:", (const unsigned char *)disposition,
                                        (int)strlen(disposition), &at, end))
            return -1;
    }
    if (lws_finalize_write_http_header(wsi, start, &at, end))
        return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

int http_answer(struct lws *wsi, struct exchange *exchange, unsigned status, const char *type, char *text)
{
    if (!text)
        return http_refuse(wsi, HTTP_STATUS_INTERNAL_SERVER_ERROR);
    exchange->owned = text;
    exchange->bytes = (const unsigned char *)text;
    exchange->size = strlen(text);
    exchange->sent = 0;
    return begin(lws_context_user(lws_get_context(wsi)), wsi, exchange, status, type, NULL);
}

static void finish(struct exchange *exchange)
{
    free(exchange->owned);
    if (exchange->fd > 0)
        close(exchange->fd);
    upload_drop(exchange);
    memset(exchange, 0, sizeof *exchange);
}

/* ---- the page ---- */

/* Names are flat and plain, so that none can lead out of the folder. */
static bool is_plain(const char *name)
{
    return name[0] && name[0] != '.' && strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") == strlen(name);
}

static bool read_from_folder(const char *folder, const char *name, struct exchange *exchange)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    char *bytes = file ? malloc(MOST_FILE) : NULL;
    if (bytes) {
        exchange->size = fread(bytes, 1, MOST_FILE, file);
        exchange->owned = bytes;
        exchange->bytes = (unsigned char *)bytes;
    }
    if (file)
        fclose(file);
    return bytes;
}

static bool find_file(const char *name, struct exchange *exchange)
{
    const char *folder = getenv("PELLUCID_WEB");
    if (!is_plain(name))
        return false;
    if (folder)
        return read_from_folder(folder, name, exchange);
    for (const struct web_file *file = web_files; file->name; file++)
        if (strcmp(file->name, name) == 0) {
            exchange->bytes = file->bytes;
            exchange->size = file->size;
            return true;
        }
    return false;
}

static int get_download(struct server *server, struct lws *wsi, struct exchange *exchange, const char *number)
{
    char name[128], *end;
    const char *type;
    unsigned long k = strtoul(number, &end, 10);
    int fd = *end || !number[0] || k > 1u << 30 ? -1 : session_download(server->session, (unsigned)k, name, &type, &exchange->size);
    if (fd < 0)
        return http_refuse(wsi, HTTP_STATUS_NOT_FOUND);
    exchange->fd = fd;
    return begin(server, wsi, exchange, HTTP_STATUS_OK, type, name);
}

static int get(struct server *server, struct lws *wsi, struct exchange *exchange, const char *path)
{
    const char *name = guard_rest(path);
    if (path[1 + TOKEN_LENGTH] == 0) { /* relative addresses need the slash */
        unsigned char buffer[LWS_PRE + 512], *at = buffer + LWS_PRE;
        char to[TOKEN_LENGTH + 3];
        int length = snprintf(to, sizeof to, "/%s/", server->token);
        if (lws_http_redirect(wsi, HTTP_STATUS_MOVED_PERMANENTLY, (unsigned char *)to, length, &at, buffer + sizeof buffer) < 0)
            return -1;
        return lws_http_transaction_completed(wsi) ? -1 : 0;
    }
    if (strncmp(name, "download/", 9) == 0)
        return get_download(server, wsi, exchange, name + 9);
    if (!name[0])
        name = "index.html";
    if (!find_file(name, exchange))
        return http_refuse(wsi, HTTP_STATUS_NOT_FOUND);
    return begin(server, wsi, exchange, HTTP_STATUS_OK, type_of(name), NULL);
}

static int request(struct server *server, struct lws *wsi, struct exchange *exchange, const char *path)
{
    bool post = lws_hdr_total_length(wsi, WSI_TOKEN_POST_URI) > 0;
    finish(exchange);
    if (!guard_request(server, wsi, path, post))
        return http_refuse(wsi, HTTP_STATUS_FORBIDDEN);
    if (post && strcmp(guard_rest(path), "upload") == 0)
        return upload_begin(server, wsi, exchange);
    if (post || lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0)
        return http_refuse(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED);
    return get(server, wsi, exchange, path);
}

/* The next piece of the body. */
static int write_more(struct lws *wsi, struct exchange *exchange)
{
    unsigned char buffer[LWS_PRE + CHUNK];
    uint64_t left = exchange->size - exchange->sent;
    size_t count = left < CHUNK ? (size_t)left : CHUNK;
    if (exchange->bytes) {
        memcpy(buffer + LWS_PRE, exchange->bytes + exchange->sent, count);
    } else if (exchange->fd > 0) {
        ssize_t got = pread(exchange->fd, buffer + LWS_PRE, count, (off_t)exchange->sent);
        if (got <= 0 && count > 0)
            return -1;
        count = (size_t)(got > 0 ? got : 0);
    } else {
        return 0;
    }
    exchange->sent += count;
    bool last = exchange->sent == exchange->size;
    if (lws_write(wsi, buffer + LWS_PRE, count, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < (int)count)
        return -1;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    finish(exchange);
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

int http_event(struct server *server, struct lws *wsi, enum lws_callback_reasons reason, struct exchange *exchange, const char *in,
               size_t length)
{
    switch ((int)reason) {
    case LWS_CALLBACK_HTTP:
        return request(server, wsi, exchange, in);
    case LWS_CALLBACK_HTTP_BODY:
        return upload_body(wsi, exchange, in, length);
    case LWS_CALLBACK_HTTP_BODY_COMPLETION:
        return upload_end(wsi, exchange);
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return write_more(wsi, exchange);
    case LWS_CALLBACK_CLOSED_HTTP:
        if (exchange)
            finish(exchange);
        break;
    }
    return 0;
}
