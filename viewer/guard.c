/* SPDX-License-Identifier: MIT */
/* Who may come in. The token in the address proves that the request is of somebody who was shown it. The Host keeps a foreign name that
 * resolves to this machine (DNS rebinding) out, the Origin other sites' pages. */
#include <arpa/inet.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "server_inside.h"

bool guard_token(char token[TOKEN_LENGTH + 1])
{
    unsigned char bytes[TOKEN_LENGTH / 2];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return false;
    for (size_t i = 0; i < sizeof bytes; i++)
        snprintf(token + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

/* In a time that tells nothing of where they differ. */
static bool token_equal(const char *token, const char *path)
{
    unsigned char differs = 0;
    if (strlen(path) < 1 + TOKEN_LENGTH || path[0] != '/')
        return false;
    for (int i = 0; i < TOKEN_LENGTH; i++)
        differs |= (unsigned char)token[i] ^ (unsigned char)path[1 + i];
    return differs == 0 && (path[1 + TOKEN_LENGTH] == '/' || path[1 + TOKEN_LENGTH] == 0);
}

static bool is_numeric(const char *host)
{
    struct in_addr four;
    struct in6_addr six;
    char text[128];
    size_t length = strlen(host);
    if (inet_pton(AF_INET, host, &four) == 1)
        return true;
    if (length < 3 || length >= sizeof text || host[0] != '[' || host[length - 1] != ']')
        return false;
    memcpy(text, host + 1, length - 2);
    text[length - 2] = 0;
    return inet_pton(AF_INET6, text, &six) == 1;
}

/* Names of this server. Where it listens on all addresses any number is one, for a number cannot be rebound; and so is the machine's name.
 */
static bool host_known(const struct server *server, const char *authority)
{
    char host[192], port[16], name[128], given[256];
    const char *colon = strrchr(authority, ':');
    snprintf(port, sizeof port, ":%d", server->port);
    if (server->port == 80 && (!colon || colon[strspn(colon, ":0123456789")])) /* the usual port is not written; "[::1]" has colons, too */
        return strlen(authority) < sizeof given - 4 && host_known(server, strcat(strcpy(given, authority), port));
    if (!colon || strcmp(colon, port) != 0 || (size_t)(colon - authority) >= sizeof host)
        return false;
    memcpy(host, authority, (size_t)(colon - authority));
    host[colon - authority] = 0;
    bool all = strcmp(server->params.listen, "0.0.0.0") == 0 || strcmp(server->params.listen, "::") == 0;
    bool here = all || strcmp(server->params.listen, "127.0.0.1") == 0 || strcmp(server->params.listen, "::1") == 0;
    if (here && (strcmp(host, "localhost") == 0 || strcmp(host, "127.0.0.1") == 0 || strcmp(host, "[::1]") == 0))
        return true;
    if (all && (is_numeric(host) || (gethostname(name, sizeof name) == 0 && strcasecmp(host, name) == 0)))
        return true;
    return strcmp(authority, server->authority) == 0;
}

bool guard_request(const struct server *server, struct lws *wsi, const char *path, bool origin)
{
    char host[256], from[300];
    if (lws_hdr_copy(wsi, host, sizeof host, WSI_TOKEN_HOST) <= 0 || !host_known(server, host))
        return false;
    if (origin && lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) > 0 &&
        (lws_hdr_copy(wsi, from, sizeof from, WSI_TOKEN_ORIGIN) <= 0 || strncmp(from, "http://", 7) != 0 || strcmp(from + 7, host) != 0))
        return false;
    return token_equal(server->token, path);
}

const char *guard_rest(const char *path)
{
    path += 1 + TOKEN_LENGTH;
    return *path == '/' ? path + 1 : path;
}
