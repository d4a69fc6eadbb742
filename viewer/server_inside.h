/* SPDX-License-Identifier: MIT */
/* What the server's files share. */
#ifndef VIEWER_SERVER_INSIDE_H
#define VIEWER_SERVER_INSIDE_H

#include <pthread.h>

#include <libwebsockets.h>

#include "server.h"

enum {
    TOKEN_LENGTH = 32, /* hexadecimal digits of 128 random bits */
    VIEWS = 4,         /* main and three slices */
    MOST_EVENTS = 512,
    MOST_EVENT_BYTES = 16 << 20,
    UPLOADS_KEPT = 8,
    MOST_UPLOADING = 4,
    MOST_UPLOAD_FILES = 4096,
};

/* A frame that several clients may wait for. Under the server's lock. */
struct shared_frame {
    int users;
    uint64_t number, order; /* order: among those of its view */
    double since_ms, draw_ms, encode_ms;
    char *header;
    void *bytes;
    size_t size;
};

struct waiting_event {
    struct waiting_event *next;
    size_t size;
    char text[];
};

/* A WebSocket. What the session's threads touch is under the server's lock. */
struct socket {
    struct lws *wsi;
    int number; /* of the client, for the session */
    struct socket *next;

    struct {
        struct shared_frame *frame; /* the newest that was not sent yet, or NULL */
        int64_t id;
    } slots[VIEWS];
    uint64_t in_flight; /* number of the frame that is not shown yet; 0: none */
    struct waiting_event *events, **last_event;
    int event_count;
    size_t event_bytes;
    bool greeted; /* it said hello: it takes frames */
    bool lost;    /* it does not read: to be closed */

    char *message; /* what came of a message so far */
    size_t length, room;
    double credit, credit_bytes, credit_ms; /* messages and bytes that it may send */
};

/* An answer under way, or an upload. */
struct exchange {
    const unsigned char *bytes; /* of an embedded file, or owned below; NULL: from fd */
    void *owned;
    int fd;
    uint64_t size, sent;
    struct upload *upload;
};

/* Of files that were sent together. */
struct upload_folder {
    unsigned number;    /* its name */
    int files, writing; /* in it, and of these under way */
    uint64_t bytes;     /* of all of them, once they are there */
};

struct server {
    struct server_params params;
    struct lws_context *context;
    struct session *session;
    char token[TOKEN_LENGTH + 1];
    char address[256], authority[192]; /* "127.0.0.1:40123" */
    int port;
    int last_client;
    bool (*stop)(void *user);
    void *stop_user;
    lws_sorted_usec_list_t tick;

    pthread_mutex_t lock;
    struct socket *sockets;
    uint64_t orders[VIEWS];

    char *folder;                            /* of uploads, made with the first; NULL before */
    unsigned uploads;                        /* folders in it so far */
    int uploading;                           /* files under way now */
    struct upload_folder kept[UPLOADS_KEPT]; /* the oldest first */
    int kept_count;
};

/* ---- guard.c ---- */

bool guard_token(char token[TOKEN_LENGTH + 1]);
/* May this request be answered at all? `origin`: its Origin must be ours, too. */
bool guard_request(const struct server *server, struct lws *wsi, const char *path, bool origin);
/* What stands behind the token: "/T/style.css" -> "style.css". The path has passed the guard. */
const char *guard_rest(const char *path);

/* ---- socket.c ---- */

int socket_event(struct server *server, struct lws *wsi, enum lws_callback_reasons reason, struct socket *socket, const char *in,
                 size_t length);
/* Asks for a turn to write wherever something waits. */
void sockets_wake(struct server *server);

/* ---- http.c ---- */

int http_event(struct server *server, struct lws *wsi, enum lws_callback_reasons reason, struct exchange *exchange, const char *in,
               size_t length);
/* Answers with a short text. */
int http_answer(struct lws *wsi, struct exchange *exchange, unsigned status, const char *type, char *owned_text);
int http_refuse(struct lws *wsi, unsigned status);

/* ---- upload.c ---- */

int upload_begin(struct server *server, struct lws *wsi, struct exchange *exchange);
int upload_body(struct lws *wsi, struct exchange *exchange, const char *bytes, size_t size);
int upload_end(struct lws *wsi, struct exchange *exchange);
void upload_drop(struct exchange *exchange); /* accepts one without an upload */
/* Removes the files that were uploaded. */
void uploads_finish(struct server *server);

#endif
