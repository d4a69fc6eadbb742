/* SPDX-License-Identifier: MIT */
/* pellucid replay: a session of the viewer again, without its page. */
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "arguments.h"
#include "commands.h"
#include "progress.h"
#include "record.h"
#include "session.h"

struct values {
    bool fast;
    int threads;
    double budget;
    char picture[PEL_OPTION_TEXT_SIZE];
};

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "fast", "Fast", "Each command as soon as a picture shows the last, in place of its time", PEL_OPTION_BOOL, FIELD(fast), 0, 0, "false",
      NULL, NULL },
    { "picture", "Picture", "Write the last picture, at rest", PEL_OPTION_TEXT, FIELD(picture), 0, 0, NULL, NULL, NULL },
    { "threads", "Threads", "Threads of the CPU engine; 0 is as many as the machine has", PEL_OPTION_INT, FIELD(threads), 0, 1024, "0",
      NULL, NULL },
    { "budget", "Budget", "Time for a picture while things move", PEL_OPTION_DOUBLE, FIELD(budget), 1, 10000, "33", NULL, "ms" },
    { NULL },
};
static const struct option_extra extras[] = { { "picture", 0, "FILE.png", NULL, false }, { NULL } };
static const struct option_group groups[] = { { "Options", rows, extras }, { NULL } };

/* What came out so far. */
struct watcher {
    pthread_mutex_t lock;
    struct {
        double *ms; /* draw and encode; owned */
        size_t count, room;
    } moving, rest;
    void *picture; /* owned; the last lossless main one */
    size_t size;
    struct recording *recording;
    int errors; /* that the recording did not have */
};

static void on_frame(void *user, const struct session_frame *frame)
{
    struct watcher *w = user;
    if (strcmp(frame->view, "main") != 0)
        return;
    double ms = frame->draw_ms + frame->encode_ms;
    pthread_mutex_lock(&w->lock);
    size_t *count = frame->lossless ? &w->rest.count : &w->moving.count, *room = frame->lossless ? &w->rest.room : &w->moving.room;
    double **list = frame->lossless ? &w->rest.ms : &w->moving.ms;
    if (*count == *room) {
        double *larger = realloc(*list, (2 * *room + 64) * sizeof *larger);
        *room = larger ? 2 * *room + 64 : *room;
        *list = larger ? larger : *list;
    }
    if (*count < *room)
        (*list)[(*count)++] = ms;
    void *copy = frame->lossless ? malloc(frame->size) : NULL;
    if (copy) {
        memcpy(copy, frame->bytes, frame->size);
        free(w->picture);
        w->picture = copy;
        w->size = frame->size;
    }
    pthread_mutex_unlock(&w->lock);
}

/* Was this error told when it was recorded, too? Each counts once. What was cancelled depends on the pace, so that is no matter. */
static bool was_told(struct recording *recording, int client, const char *command)
{
    for (size_t i = 0; i < recording->error_count; i++) {
        struct recorded_error *e = &recording->errors[i];
        if (e->client != client || strncmp(e->command, command, sizeof e->command - 1) != 0)
            continue;
        *e = recording->errors[--recording->error_count];
        return true;
    }
    return false;
}

static void on_event(void *user, int client, const char *text)
{
    struct watcher *w = user;
    json_t *event = json_loads(text, 0, NULL);
    const char *kind = json_string_value(json_object_get(event, "event"));
    if (kind && strcmp(kind, "error") == 0) {
        const char *command = json_string_value(json_object_get(event, "do")),
                   *message = json_string_value(json_object_get(event, "message")),
                   *code = json_string_value(json_object_get(event, "code"));
        pthread_mutex_lock(&w->lock);
        bool expected = was_told(w->recording, client, command ? command : "") || (code && strcmp(code, "cancelled") == 0);
        w->errors += !expected;
        pthread_mutex_unlock(&w->lock);
        tool_note("client %d: %s%s", client, message, expected ? "" : " (not so when it was recorded)");
    }
    json_decref(event);
}

static bool open_recorded(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    const struct recording *recording = user;
    bool fine = session_open_snapshot(recording->scene, opened, progress, error);
    opened->fit_camera = recording->fitted;
    return fine;
}

static void sleep_until(double ms)
{
    double left = ms - tool_milliseconds();
    if (left <= 0)
        return;
    struct timespec t = { (time_t)(left / 1e3), (long)((left - 1e3 * (double)(long)(left / 1e3)) * 1e6) };
    nanosleep(&t, NULL);
}

/* A file is read by a thread of the session's own: what comes after it here is meant for what it holds. */
static bool opens(const json_t *command)
{
    const char *name = json_string_value(json_object_get(command, "do"));
    return name && (strcmp(name, "open") == 0 || strcmp(name, "undo") == 0 || strcmp(name, "redo") == 0);
}

static void feed(struct session *session, const struct recording *recording, bool fast)
{
    double start = tool_milliseconds() - (recording->count ? recording->commands[0].at_ms : 0);
    for (size_t i = 0; i < recording->count && !interruption(); i++) {
        const struct recorded *r = &recording->commands[i];
        if (!r->client)
            continue;
        if (!fast)
            sleep_until(start + r->at_ms);
        if (r->command)
            session_command(session, r->client, r->command);
        else
            session_leave(session, r->client);
        if (r->command && (fast || opens(r->command)))
            session_settle(session, false);
    }
    session_let_go(session);
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void tell(const char *what, double *ms, size_t count)
{
    qsort(ms, count, sizeof *ms, compare);
    if (count)
        printf("%-14s %6zu frames, median %.1f ms, 95th percentile %.1f ms, longest %.1f ms\n", what, count, ms[count / 2],
               ms[count - 1 - count / 20], ms[count - 1]);
    else
        printf("%-14s %6d frames\n", what, 0);
}

static bool write_picture(const char *path, const struct watcher *w, struct pel_error *error)
{
    FILE *file = w->picture ? fopen(path, "wb") : NULL;
    if (!w->picture)
        return tool_fail(error, PEL_ERROR_FORMAT, "the recording made no picture; no client of it said hello");
    bool fine = file && fwrite(w->picture, 1, w->size, file) == w->size;
    fine = (!file || fclose(file) == 0) && fine;
    return fine || tool_fail(error, PEL_ERROR_IO, "%.300s: %s", path, strerror(errno));
}

/* What is gone cannot be opened; that matters only where the recording does. */
static void leave_out_missing(char **files)
{
    char **kept = files;
    for (; *files; files++)
        if (access(*files, F_OK) == 0) {
            *kept++ = *files;
        } else {
            tool_note("%s: %s", *files, strerror(errno));
            free(*files);
        }
    *kept = NULL;
}

static bool replay(const struct values *values, struct recording *recording, struct watcher *w, struct pel_error *error)
{
    const struct session_params params = {
        .user = w,
        .frame = on_frame,
        .event = on_event,
        .open = recording->scene ? open_recorded : NULL,
        .open_user = recording,
        .paths = (const char *const *)recording->files,
        .threads = values->threads,
        .budget_ms = values->budget,
    };
    leave_out_missing(recording->files);
    struct session *session = session_create(&params, error);
    if (!session)
        return false;
    bool fine = session_settle(session, false) || tool_fail(error, PEL_ERROR_IO, "the file of the recording cannot be opened");
    if (fine) {
        feed(session, recording, values->fast);
        session_settle(session, true);
    }
    session_destroy(session);
    if (fine && interruption())
        fine = tool_fail(error, PEL_ERROR_CANCELLED, "interrupted");
    if (fine && w->errors)
        fine = tool_fail(error, PEL_ERROR_FORMAT, "%d error%s that the recording did not have; its files or the device are others",
                         w->errors, w->errors == 1 ? "" : "s");
    return fine;
}

static int run(const struct command *command, int argc, char **argv)
{
    struct values values = { .fast = false };
    struct arguments arguments = { .command = command, .objects = { &values } };
    struct watcher w = { .lock = PTHREAD_MUTEX_INITIALIZER };
    struct recording recording;
    struct pel_error error = PEL_ERROR_INIT;
    int status = arguments_parse_operands(&arguments, argc, argv, 1, 1);
    if (status >= 0)
        return status;
    if (!recording_read(arguments.operands[0], &recording, &error))
        return tool_report(&error);
    w.recording = &recording;
    bool fine = replay(&values, &recording, &w, &error);
    if (fine || w.errors) {
        tell("in motion", w.moving.ms, w.moving.count);
        tell("at rest", w.rest.ms, w.rest.count);
        struct pel_error unwritten = PEL_ERROR_INIT;
        if (values.picture[0] && !write_picture(values.picture, &w, &unwritten) && fine) {
            error = unwritten;
            fine = false;
        }
    }
    recording_finish(&recording);
    free(w.moving.ms);
    free(w.rest.ms);
    free(w.picture);
    return tool_finish_stdout(fine ? EXIT_FINE : tool_report(&error));
}

const struct command command_replay = {
    .name = "replay",
    .summary = "Play a recording of the viewer again",
    .usage = "RECORDING [--fast] [--picture FILE.png] [options]",
    .description = "Gives the commands that `pellucid view --record` wrote to a session again, and tells what its pictures cost. The last "
                   "picture at rest is the same, "
                   "byte for byte.",
    .examples = "  pellucid view head.nrrd --record head.jsonl\n"
                "  pellucid replay head.jsonl --fast --picture last.png\n",
    .groups = groups,
    .run = run,
};
