/* SPDX-License-Identifier: MIT */
/* The clients' WebSockets. Of frames each has one place a view, where a newer one takes the place of an older one that waits, and is sent
 * the next only when it has shown the last: so nothing queues, and a slow client gets fewer frames and holds up no other. Events queue, for
 * none may be lost; a client that does not read them is dropped. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server_inside.h"

/* Messages a second that a client may send, and how many at once. A page sends one for each of its animation frames and inputs. */
#define RATE 1000.0
#define BURST 3000.0
/* And their bytes, for one may have a million. */
#define RATE_BYTES 4e6
#define BURST_BYTES 16e6

static double now_ms(void)
{
    return (double)lws_now_usecs() * 1e-3;
}

static int view_number(const char *view)
{
    static const char *const names[VIEWS] = { "main", "slice-i", "slice-j", "slice-k" };
    int i = 0;
    while (i < VIEWS - 1 && strcmp(names[i], view) != 0)
        i++;
    return i;
}

static void frame_release(struct shared_frame *frame)
{
    if (!frame || --frame->users > 0)
        return;
    free(frame->header);
    free(frame->bytes);
    free(frame);
}

/* ---- from the session ---- */

static struct shared_frame *frame_share(const struct session_frame *from)
{
    struct shared_frame *frame = calloc(1, sizeof *frame);
    if (!frame)
        return NULL;
    frame->users = 1;
    frame->number = from->number;
    frame->since_ms = now_ms();
    frame->header = strdup(from->header);
    frame->draw_ms = from->draw_ms;
    frame->encode_ms = from->encode_ms;
    frame->bytes = malloc(from->size);
    frame->size = from->size;
    if (frame->header && frame->bytes) {
        memcpy(frame->bytes, from->bytes, from->size);
        return frame;
    }
    frame_release(frame);
    return NULL;
}

static int64_t id_of(const struct session_frame *frame, int client)
{
    for (int i = 0; i < frame->client_count; i++)
        if (frame->clients[i].client == client)
            return frame->clients[i].id;
    return INT64_MIN; /* it did not ask yet */
}

void server_frame(void *user, const struct session_frame *from)
{
    struct server *server = user;
    struct shared_frame *frame = frame_share(from); /* without memory a frame is left out; the next one may find some */
    int view = view_number(from->view);
    if (!frame)
        return;
    pthread_mutex_lock(&server->lock);
    frame->order = ++server->orders[view];
    for (struct socket *socket = server->sockets; socket; socket = socket->next) {
        int64_t id = id_of(from, socket->number);
        if (id == INT64_MIN)
            continue;
        frame_release(socket->slots[view].frame);
        socket->slots[view].frame = frame;
        socket->slots[view].id = id;
        frame->users++;
    }
    frame_release(frame);
    pthread_mutex_unlock(&server->lock);
    lws_cancel_service(server->context);
}

static void push_event(struct socket *socket, const char *text)
{
    size_t size = strlen(text);
    struct waiting_event *event = malloc(sizeof *event + size + 1);
    if (!event || socket->event_count >= MOST_EVENTS || socket->event_bytes + size > MOST_EVENT_BYTES) {
        free(event);
        socket->lost = true;
        return;
    }
    event->next = NULL;
    event->size = size;
    memcpy(event->text, text, size + 1);
    *socket->last_event = event;
    socket->last_event = &event->next;
    socket->event_count++;
    socket->event_bytes += size;
}

void server_event(void *user, int client, const char *text)
{
    struct server *server = user;
    pthread_mutex_lock(&server->lock);
    for (struct socket *socket = server->sockets; socket; socket = socket->next)
        if ((client == 0 || socket->number == client) && !socket->lost)
            push_event(socket, text);
    pthread_mutex_unlock(&server->lock);
    lws_cancel_service(server->context);
}

bool server_wanted(void *user)
{
    struct server *server = user;
    bool any = false;
    pthread_mutex_lock(&server->lock);
    for (struct socket *socket = server->sockets; socket && !any; socket = socket->next)
        any = socket->greeted && !socket->lost && !socket->slots[0].frame;
    pthread_mutex_unlock(&server->lock);
    return any;
}

void sockets_wake(struct server *server)
{
    pthread_mutex_lock(&server->lock);
    for (struct socket *socket = server->sockets; socket; socket = socket->next) {
        bool frame = false;
        for (int i = 0; i < VIEWS; i++)
            frame |= socket->slots[i].frame != NULL;
        if (socket->events || socket->lost || (frame && !socket->in_flight))
            lws_callback_on_writable(socket->wsi);
    }
    pthread_mutex_unlock(&server->lock);
}

/* ---- to the client ---- */

static struct waiting_event *pop_event(struct server *server, struct socket *socket)
{
    pthread_mutex_lock(&server->lock);
    struct waiting_event *event = socket->events;
    if (event) {
        socket->events = event->next;
        if (!socket->events)
            socket->last_event = &socket->events;
        socket->event_count--;
        socket->event_bytes -= event->size;
    }
    pthread_mutex_unlock(&server->lock);
    return event;
}

/* The main picture before the slices. */
static struct shared_frame *pop_frame(struct server *server, struct socket *socket, int64_t *id, uint64_t *age)
{
    struct shared_frame *frame = NULL;
    pthread_mutex_lock(&server->lock);
    for (int i = 0; i < VIEWS && !frame && !socket->in_flight; i++)
        if ((frame = socket->slots[i].frame)) {
            socket->slots[i].frame = NULL;
            *id = socket->slots[i].id;
            *age = server->orders[i] - frame->order;
        }
    if (frame)
        socket->in_flight = frame->number;
    pthread_mutex_unlock(&server->lock);
    return frame;
}

static bool write_event(struct socket *socket, const struct waiting_event *event)
{
    unsigned char *message = malloc(LWS_PRE + event->size);
    if (!message)
        return false;
    memcpy(message + LWS_PRE, event->text, event->size);
    bool fine = lws_write(socket->wsi, message + LWS_PRE, event->size, LWS_WRITE_TEXT) >= (int)event->size;
    free(message);
    return fine;
}

static bool write_frame(struct socket *socket, const struct shared_frame *frame, int64_t id, uint64_t age)
{
    char tail[200];
    size_t head = strlen(frame->header) - 1; /* but for its closing brace */
    int length = snprintf(tail, sizeof tail, ",\"ms\":{\"draw\":%.3f,\"encode\":%.3f,\"wait\":%.3f},\"id\":%lld,\"age\":%llu}",
                          frame->draw_ms, frame->encode_ms, now_ms() - frame->since_ms, (long long)id, (unsigned long long)age);
    uint32_t count = (uint32_t)(head + (size_t)length);
    size_t size = 4 + count + frame->size;
    unsigned char *message = malloc(LWS_PRE + size), *at = message ? message + LWS_PRE : NULL;
    if (!message)
        return false;
    for (int i = 0; i < 4; i++)
        *at++ = (unsigned char)(count >> 8 * i);
    memcpy(at, frame->header, head);
    memcpy(at + head, tail, (size_t)length);
    memcpy(at + count, frame->bytes, frame->size);
    bool fine = lws_write(socket->wsi, message + LWS_PRE, size, LWS_WRITE_BINARY) >= (int)size;
    free(message);
    return fine;
}

/* One message a turn, as libwebsockets wants it. Negative: the socket is closed. */
static int write_next(struct server *server, struct socket *socket)
{
    struct waiting_event *event;
    struct shared_frame *frame;
    int64_t id;
    uint64_t age;
    bool fine = true;
    pthread_mutex_lock(&server->lock);
    bool lost = socket->lost;
    pthread_mutex_unlock(&server->lock);
    if (lost)
        return -1;
    if ((event = pop_event(server, socket))) {
        fine = write_event(socket, event);
        free(event);
    } else if ((frame = pop_frame(server, socket, &id, &age))) {
        fine = write_frame(socket, frame, id, age);
        pthread_mutex_lock(&server->lock);
        frame_release(frame);
        pthread_mutex_unlock(&server->lock);
        session_wake(server->session); /* its place is free */
    } else {
        return 0;
    }
    if (fine)
        lws_callback_on_writable(socket->wsi);
    return fine ? 0 : -1;
}

/* ---- from the client ---- */

static bool is_called(const json_t *command, const char *name)
{
    const json_t *called = json_object_get(command, "do");
    return json_is_string(called) && strcmp(json_string_value(called), name) == 0;
}

/* From now on it takes pictures. */
static void greet(struct server *server, struct socket *socket)
{
    pthread_mutex_lock(&server->lock);
    socket->greeted = true;
    pthread_mutex_unlock(&server->lock);
    session_wake(server->session);
}

static bool shown(struct server *server, struct socket *socket, const json_t *command)
{
    if (!is_called(command, "shown"))
        return false;
    pthread_mutex_lock(&server->lock);
    if ((uint64_t)json_integer_value(json_object_get(command, "frame")) == socket->in_flight)
        socket->in_flight = 0;
    pthread_mutex_unlock(&server->lock);
    lws_callback_on_writable(socket->wsi);
    session_wake(server->session);
    return true;
}

static void obey(struct server *server, struct socket *socket)
{
    json_t *command = json_loadb(socket->message, socket->length, JSON_REJECT_DUPLICATES, NULL);
    if (!command)
        session_command_text(server->session, socket->number, socket->message, socket->length); /* tells what is wrong */
    else if (!shown(server, socket, command) && session_command(server->session, socket->number, command) && is_called(command, "hello"))
        greet(server, socket);
    json_decref(command);
    socket->length = 0;
}

static bool within_rate(struct socket *socket, bool message, size_t bytes)
{
    double now = now_ms(), seconds = (now - socket->credit_ms) / 1000;
    socket->credit_ms = now;
    socket->credit = fmin(BURST, socket->credit + seconds * RATE) - message;
    socket->credit_bytes = fmin(BURST_BYTES, socket->credit_bytes + seconds * RATE_BYTES) - (double)bytes;
    return socket->credit >= 0 && socket->credit_bytes >= 0;
}

static int refuse(struct socket *socket, enum lws_close_status status, const char *why)
{
    lws_close_reason(socket->wsi, status, (unsigned char *)why, strlen(why));
    return -1;
}

static int receive(struct server *server, struct socket *socket, const char *in, size_t length)
{
    if (lws_frame_is_binary(socket->wsi))
        return refuse(socket, LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE, "commands are text");
    if (length > SESSION_MOST_BYTES - socket->length)
        return refuse(socket, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, "a command is too long");
    if (!within_rate(socket, lws_is_first_fragment(socket->wsi), length))
        return refuse(socket, LWS_CLOSE_STATUS_POLICY_VIOLATION, "too many commands");
    if (socket->length + length > socket->room) {
        size_t room = 2 * (socket->length + length);
        char *larger = realloc(socket->message, room);
        if (!larger)
            return refuse(socket, LWS_CLOSE_STATUS_UNEXPECTED_CONDITION, "no memory");
        socket->message = larger;
        socket->room = room;
    }
    if (length)
        memcpy(socket->message + socket->length, in, length);
    socket->length += length;
    if (lws_is_final_fragment(socket->wsi) && lws_remaining_packet_payload(socket->wsi) == 0)
        obey(server, socket);
    return 0;
}

static void open_socket(struct server *server, struct socket *socket, struct lws *wsi)
{
    memset(socket, 0, sizeof *socket);
    socket->wsi = wsi;
    socket->number = ++server->last_client;
    socket->last_event = &socket->events;
    socket->credit = BURST;
    socket->credit_bytes = BURST_BYTES;
    socket->credit_ms = now_ms();
    pthread_mutex_lock(&server->lock);
    socket->next = server->sockets;
    server->sockets = socket;
    pthread_mutex_unlock(&server->lock);
}

static void close_socket(struct server *server, struct socket *socket)
{
    pthread_mutex_lock(&server->lock);
    for (struct socket **at = &server->sockets; *at; at = &(*at)->next)
        if (*at == socket) {
            *at = socket->next;
            break;
        }
    for (int i = 0; i < VIEWS; i++)
        frame_release(socket->slots[i].frame);
    pthread_mutex_unlock(&server->lock);
    while (socket->events) {
        struct waiting_event *event = socket->events;
        socket->events = event->next;
        free(event);
    }
    free(socket->message);
    if (server->session)
        session_leave(server->session, socket->number);
}

int socket_event(struct server *server, struct lws *wsi, enum lws_callback_reasons reason, struct socket *socket, const char *in,
                 size_t length)
{
    switch ((int)reason) {
    case LWS_CALLBACK_ESTABLISHED:
        open_socket(server, socket, wsi);
        break;
    case LWS_CALLBACK_CLOSED:
        close_socket(server, socket);
        break;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return write_next(server, socket);
    case LWS_CALLBACK_RECEIVE:
        return receive(server, socket, in, length);
    }
    return 0;
}
