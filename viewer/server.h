/* SPDX-License-Identifier: MIT */
/* The viewer's server: the page's files, a WebSocket for commands and frames, uploads and downloads (protocol.md). One thread serves, that
 * of server_run; the session's threads put events and frames where it finds them. */
#ifndef VIEWER_SERVER_H
#define VIEWER_SERVER_H

#include "session.h"

struct server_params {
    const char *listen;   /* address: "127.0.0.1"; "0.0.0.0" for all */
    int port;             /* 0: a free one */
    uint64_t most_upload; /* bytes of the files that are uploaded together */
};

struct server;

/* Listens. Nothing is answered before server_run. */
struct server *server_create(const struct server_params *params, struct pel_error *error);
void server_destroy(struct server *server); /* after its session; accepts NULL */

/* Where the page is: "http://127.0.0.1:40123/TOKEN/". */
const char *server_address(const struct server *server);

/* The callbacks for a session's params (user: the server). */
void server_frame(void *server, const struct session_frame *frame);
void server_event(void *server, int client, const char *text);
bool server_wanted(void *server);

/* Serves this session until `stop` says so, which is asked a few times a second. */
void server_run(struct server *server, struct session *session, bool (*stop)(void *user), void *user);

#endif
