/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "server_inside.h"

enum { TICK_US = 200000, MOST_CONNECTIONS = 512 };

union connection {
    struct socket socket;
    struct exchange exchange;
};

static bool fail(struct pel_error *error, const char *why)
{
    if (error) {
        error->code = PEL_ERROR_IO;
        snprintf(error->message, sizeof error->message, "%s", why);
    }
    return false;
}

static bool offers_protocol(struct lws *wsi)
{
    char names[256];
    return lws_hdr_copy(wsi, names, sizeof names, WSI_TOKEN_PROTOCOL) > 0 && strstr(names, "pellucid-1");
}

/* A request to become a WebSocket: 0 lets it. */
static int confirm_upgrade(struct server *server, struct lws *wsi, const char *to)
{
    char path[256];
    bool fine = strcmp(to, "websocket") == 0 && lws_hdr_copy(wsi, path, sizeof path, WSI_TOKEN_GET_URI) > 0 &&
                guard_request(server, wsi, path, true) && strcmp(guard_rest(path), "socket") == 0 && offers_protocol(wsi);
    int sockets = 0;
    for (struct socket *socket = server->sockets; socket; socket = socket->next) /* only this thread changes the list */
        sockets++;
    if (fine && sockets < SESSION_MOST_CLIENTS)
        return 0;
    if (lws_return_http_status(wsi, fine ? HTTP_STATUS_SERVICE_UNAVAILABLE : HTTP_STATUS_FORBIDDEN, NULL))
        return -1;
    return 1;
}

static int on_event(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t length)
{
    struct server *server = lws_context_user(lws_get_context(wsi));
    union connection *connection = user;
    switch ((int)reason) {
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        sockets_wake(server);
        return 0;
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
        return confirm_upgrade(server, wsi, in);
    case LWS_CALLBACK_ESTABLISHED:
    case LWS_CALLBACK_CLOSED:
    case LWS_CALLBACK_SERVER_WRITEABLE:
    case LWS_CALLBACK_RECEIVE:
        return socket_event(server, wsi, reason, &connection->socket, in, length);
    case LWS_CALLBACK_HTTP:
    case LWS_CALLBACK_HTTP_BODY:
    case LWS_CALLBACK_HTTP_BODY_COMPLETION:
    case LWS_CALLBACK_HTTP_WRITEABLE:
    case LWS_CALLBACK_CLOSED_HTTP:
        return http_event(server, wsi, reason, connection ? &connection->exchange : NULL, in, length);
    }
    return 0;
}

static const struct lws_protocols protocols[] = {
    { "http", on_event, sizeof(union connection), 1 << 16, 0, NULL, 0 },
    { "pellucid-1", on_event, sizeof(union connection), 1 << 16, 0, NULL, 0 },
    { NULL, NULL, 0, 0, 0, NULL, 0 },
};

/* A client that went away without a word is noticed, and its hold released. */
static const lws_retry_bo_t keep_alive = { .secs_since_valid_ping = 15, .secs_since_valid_hangup = 35 };

static bool fail_listen(const struct server *server, struct pel_error *error)
{
    char why[256];
    snprintf(why, sizeof why, "the server cannot listen on %.100s port %d; choose another with --port or --listen, or 0 for a free port",
             server->params.listen, server->params.port);
    return fail(error, why);
}

static bool listen_on(struct server *server, struct pel_error *error)
{
    struct lws_context_creation_info info = { .port = server->params.port };
    bool six = strchr(server->params.listen, ':');
    lws_set_log_level(0, NULL);
    info.iface = server->params.listen;
    info.protocols = protocols;
    info.user = server;
    info.gid = (gid_t)-1;
    info.uid = (uid_t)-1;
    info.alpn = "http/1.1";
    info.timeout_secs = 10;
    info.keepalive_timeout = 10;
    info.fd_limit_per_thread = MOST_CONNECTIONS;
    info.retry_and_idle_policy = &keep_alive;
    info.vhost_name = "pellucid";
    info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_VALIDATE_UTF8 | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
    if (!six)
        info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    server->context = lws_create_context(&info);
    struct lws_vhost *vhost = server->context ? lws_create_vhost(server->context, &info) : NULL;
    server->port = vhost ? lws_get_vhost_listen_port(vhost) : -1;
    if (server->port <= 0)
        return fail_listen(server, error);
    const char *open = six ? "[" : "", *close = six ? "]" : "";
    const char *name = strcmp(server->params.listen, "0.0.0.0") == 0 ? "127.0.0.1"
                       : strcmp(server->params.listen, "::") == 0    ? "::1"
                                                                     : server->params.listen;
    snprintf(server->authority, sizeof server->authority, "%s%s%s:%d", open, name, close, server->port);
    snprintf(server->address, sizeof server->address, "http://%s/%s/", server->authority, server->token);
    return true;
}

struct server *server_create(const struct server_params *params, struct pel_error *error)
{
    struct server *server = calloc(1, sizeof *server);
    if (!server) {
        fail(error, "no memory for the server");
        return NULL;
    }
    server->params = *params;
    pthread_mutex_init(&server->lock, NULL);
    if ((guard_token(server->token) || fail(error, "the system gives no random numbers")) && listen_on(server, error))
        return server;
    server_destroy(server);
    return NULL;
}

void server_destroy(struct server *server)
{
    if (!server)
        return;
    server->session = NULL;
    if (server->context)
        lws_context_destroy(server->context);
    uploads_finish(server);
    pthread_mutex_destroy(&server->lock);
    free(server);
}

const char *server_address(const struct server *server)
{
    return server->address;
}

/* Ends a wait, so that `stop` is asked, too. */
static void tick(lws_sorted_usec_list_t *list)
{
    struct server *server = lws_container_of(list, struct server, tick);
    lws_sul_schedule(server->context, 0, &server->tick, tick, TICK_US);
    session_expire(server->session);
}

void server_run(struct server *server, struct session *session, bool (*stop)(void *user), void *user)
{
    server->session = session;
    lws_sul_schedule(server->context, 0, &server->tick, tick, TICK_US);
    while (!stop(user) && lws_service(server->context, 0) >= 0)
        ;
    lws_sul_schedule(server->context, 0, &server->tick, NULL, LWS_SET_TIMER_USEC_CANCEL);
}
