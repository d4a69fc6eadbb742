/* SPDX-License-Identifier: MIT */
/* The session's life, its clients, and a command's way in: parsed, noted in the recording, looked up, and run under the lock. */
#include "session.h"

#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "record.h"
#include "session_commands.h"
#include "session_inside.h"

double session_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

bool session_fail(struct pel_error *error, enum pel_error_code code, const char *format, ...)
{
    if (!error)
        return false;
    va_list list;
    va_start(list, format);
    vsnprintf(error->message, sizeof error->message, format, list);
    va_end(list);
    error->code = code;
    return false;
}

static bool allow_all(struct session *s, const char *const *paths, struct pel_error *error)
{
    for (; paths && paths[s->named]; s->named++)
        if (!session_allow(s, paths[s->named], error))
            return false;
    return true;
}

static void init_locks(struct session *s)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&s->lock, NULL);
    pthread_cond_init(&s->wake, &monotonic);
    pthread_cond_init(&s->settled, NULL);
    pthread_condattr_destroy(&monotonic);
}

static bool start_threads(struct session *s, struct pel_error *error)
{
    pthread_mutex_lock(&s->lock);
    bool opening = !s->params.open || session_open(s, NULL, NULL, NULL, NULL, 0, error);
    pthread_mutex_unlock(&s->lock);
    if (!opening)
        return false;
    if (pthread_create(&s->drawer, NULL, session_draw, s) == 0)
        return true;
    return session_fail(error, PEL_ERROR_MEMORY, "no thread can be started");
}

static void end(struct session *s)
{
    session_jobs_finish(s);
    downloads_finish(&s->downloads);
    history_finish(&s->history);
    if (s->volume)
        session_volume_release(s->volume);
    pel_scene_finish(&s->scene);
    pel_device_destroy(s->device);
    for (int i = 0; s->paths && s->paths[i]; i++)
        free(s->paths[i]);
    free(s->paths);
    pthread_cond_destroy(&s->wake);
    pthread_cond_destroy(&s->settled);
    pthread_mutex_destroy(&s->lock);
    free(s);
}

/* A thread that reads, lists or packs. It is joined: one that were still on its way out could meet the end of the process. */
struct session_helper {
    pthread_t thread;
    bool ended; /* it does nothing more under the lock */
    struct session_helper *next;
};

static void join_ended(struct session *s)
{
    for (struct session_helper **at = &s->helpers; *at;) {
        struct session_helper *helper = *at;
        if (!helper->ended) {
            at = &helper->next;
            continue;
        }
        pthread_join(helper->thread, NULL);
        *at = helper->next;
        free(helper);
    }
}

bool session_thread(struct session *s, void *(*run)(void *user), void *user, struct pel_error *error)
{
    join_ended(s);
    struct session_helper *helper = calloc(1, sizeof *helper);
    if (!helper || pthread_create(&helper->thread, NULL, run, user) != 0) {
        free(helper);
        return session_fail(error, PEL_ERROR_MEMORY, "no thread can be started");
    }
    helper->next = s->helpers; /* the caller holds the lock, so the thread cannot have ended */
    s->helpers = helper;
    s->readers++;
    return true;
}

void session_thread_ends(struct session *s)
{
    for (struct session_helper *helper = s->helpers; helper; helper = helper->next)
        helper->ended |= pthread_equal(helper->thread, pthread_self()) != 0;
    s->readers--;
    pthread_cond_signal(&s->wake);
    pthread_cond_broadcast(&s->settled);
}

static void wait_for_readers(struct session *s)
{
    pthread_mutex_lock(&s->lock);
    session_open_cancel(s);
    while (s->readers > 0)
        pthread_cond_wait(&s->settled, &s->lock);
    join_ended(s);
    pthread_mutex_unlock(&s->lock);
}

struct session *session_create(const struct session_params *params, struct pel_error *error)
{
    struct session *s = calloc(1, sizeof *s);
    if (!s) {
        session_fail(error, PEL_ERROR_MEMORY, "no memory for the session");
        return NULL;
    }
    s->params = *params;
    s->size[0] = s->size[1] = 768; /* a guess, so that what a picture needs is prepared before the first client comes */
    s->started_ms = session_now();
    s->revision = 1;
    init_locks(s);
    if (pel_scene_init(&s->scene, error) && allow_all(s, params->paths, error) &&
        (!s->params.record || record_begin(s->params.record, s->paths, error)) && start_threads(s, error))
        return s;
    wait_for_readers(s);
    end(s);
    return NULL;
}

void session_destroy(struct session *s)
{
    if (!s)
        return;
    pthread_mutex_lock(&s->lock);
    s->quit = true;
    atomic_store(&s->abort, SESSION_ENDS);
    pthread_cond_signal(&s->wake);
    pthread_mutex_unlock(&s->lock);
    pthread_join(s->drawer, NULL);
    wait_for_readers(s);
    end(s);
}

static struct session_client *client_of(struct session *s, int number, bool make)
{
    struct session_client *place = NULL;
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++) {
        if (s->clients[i].number == number)
            return &s->clients[i];
        if (!s->clients[i].number && !place)
            place = &s->clients[i];
    }
    if (!make || !place)
        return NULL;
    *place = (struct session_client) { .number = number, .id = -1 };
    return place;
}

void session_leave(struct session *s, int number)
{
    pthread_mutex_lock(&s->lock);
    struct session_client *client = client_of(s, number, false);
    if (client) {
        bool held = client->held;
        if (s->params.record) {
            record_leave(s->params.record, session_now() - s->started_ms, number);
            s->recorded++;
        }
        *client = (struct session_client) { .number = 0 };
        session_jobs_cancel(s, number, NULL);
        session_slices_leave(s);
        session_size_again(s);
        if (held) {
            s->release = !session_held(s);
            s->state_dirty = true;
        }
    }
    pthread_cond_signal(&s->wake);
    pthread_mutex_unlock(&s->lock);
}

void session_let_go(struct session *s)
{
    pthread_mutex_lock(&s->lock);
    s->release |= session_held(s);
    s->state_dirty |= s->release;
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++)
        s->clients[i].held = false;
    pthread_cond_signal(&s->wake);
    pthread_mutex_unlock(&s->lock);
}

void session_expire(struct session *s)
{
    pthread_mutex_lock(&s->lock);
    downloads_expire(&s->downloads, session_now());
    pthread_mutex_unlock(&s->lock);
}

void session_wake(struct session *s)
{
    pthread_mutex_lock(&s->lock);
    pthread_cond_signal(&s->wake);
    pthread_mutex_unlock(&s->lock);
}

static bool is_settled(const struct session *s, bool rest)
{
    if (s->opening || s->listings || s->wish.there || (s->volume && (s->shown != s->revision || s->state_dirty)))
        return false;
    return !rest || !s->volume || !s->greeted || session_held(s) ||
           (s->refined == s->revision && !s->jobs && !session_slices_due(s) && s->readers == 0);
}

bool session_settle(struct session *s, bool rest)
{
    pthread_mutex_lock(&s->lock);
    while (!is_settled(s, rest) && !s->quit)
        pthread_cond_wait(&s->settled, &s->lock);
    bool fine = !s->failed;
    pthread_mutex_unlock(&s->lock);
    return fine;
}

int session_download(struct session *s, unsigned number, char name[128], const char **type, uint64_t *bytes)
{
    int fd = -1;
    pthread_mutex_lock(&s->lock);
    const struct download *entry = downloads_find(&s->downloads, number, session_now());
    if (entry) {
        fd = fcntl(entry->fd, F_DUPFD_CLOEXEC, 0);
        memcpy(name, entry->name, sizeof entry->name);
        *type = entry->type;
        *bytes = entry->bytes;
    }
    pthread_mutex_unlock(&s->lock);
    return fd;
}

/* ---- commands in ---- */

static bool whole_number(const struct call *call, const char *key, int64_t *out, bool *there)
{
    const json_t *value = json_object_get(call->json, key);
    *there = value != NULL;
    if (!value)
        return true;
    *out = json_integer_value(value);
    if (json_is_integer(value) && *out >= 0 && *out <= (int64_t)1 << 53)
        return true;
    *there = false;
    return session_fail(call->error, PEL_ERROR_ARGUMENT, "%s: it must be a whole number from 0 to 2^53", key);
}

static bool read_common(struct call *call)
{
    bool gesture;
    if (!json_is_object(call->json))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "a command is a JSON object");
    const json_t *name = json_object_get(call->json, "do");
    if (json_is_string(name))
        call->name = json_string_value(name);
    if (!whole_number(call, "id", &call->id, &call->has_id))
        return false;
    if (!call->name)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "do: a command needs a name");
    return whole_number(call, "gesture", &call->gesture, &gesture);
}

bool session_command(struct session *s, int client, const json_t *json)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct call call = { .session = s, .json = json, .error = &error };
    pthread_mutex_lock(&s->lock);
    call.client = client_of(s, client, true);
    bool fine = call.client ? read_common(&call) && session_command_run(&call)
                            : session_fail(&error, PEL_ERROR_UNSUPPORTED, "there are %d clients already", SESSION_MOST_CLIENTS);
    if (call.client && call.has_id)
        call.client->id = call.id; /* a refused one, too: what it asked for is as shown as it will ever be */
    if (!fine)
        session_tell_error(s, client, &error, &call);
    pthread_cond_signal(&s->wake);
    pthread_mutex_unlock(&s->lock);
    return fine;
}

bool session_command_text(struct session *s, int client, const char *text, size_t size)
{
    json_error_t e;
    json_t *json = size <= SESSION_MOST_BYTES ? json_loadb(text, size, JSON_REJECT_DUPLICATES, &e) : NULL;
    bool fine = false;
    if (json) {
        fine = session_command(s, client, json);
    } else {
        struct pel_error error;
        if (size > SESSION_MOST_BYTES)
            session_fail(&error, PEL_ERROR_ARGUMENT, "a command of %zu bytes is too long; at most %d are taken", size, SESSION_MOST_BYTES);
        else
            session_fail(&error, PEL_ERROR_ARGUMENT, "no JSON: column %d: %.200s", e.column, e.text);
        pthread_mutex_lock(&s->lock);
        session_tell_error(s, client, &error, NULL);
        pthread_mutex_unlock(&s->lock);
    }
    json_decref(json);
    return fine;
}
