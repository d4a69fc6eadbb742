/* SPDX-License-Identifier: MIT */
/* The viewer's session: a scene, its volume, a renderer and what can be undone, with no face. Commands go in as JSON, one at a time; frames
 * and events come out through callbacks. What they are is in protocol.md. A thread of the session draws: commands that arrive while it does
 * are merged into its next frame. Another reads files. */
#ifndef VIEWER_SESSION_H
#define VIEWER_SESSION_H

#include <stdint.h>
#include <stdio.h>

#include <jansson.h>

#include <pellucid/pellucid.h>

enum {
    SESSION_MOST_CLIENTS = 64,
    SESSION_LEAST_SIDE = 16,
    SESSION_MOST_SIDE = 8192,
    SESSION_MOST_PIXELS = 1 << 25,
    SESSION_MOST_PICTURE_PIXELS = 1 << 26, /* of the command `picture` */
    SESSION_MOST_BYTES = 1 << 20,          /* of a command */
    SESSION_REFINE = 8,                    /* frames averaged at rest where nobody says how many */
};

/* What opening a file gives: the session takes all of it. */
struct session_opened {
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_file_info info;
    bool fit_camera;           /* nobody said where the camera stands: it is to be fitted to the picture's size */
    struct pel_device *device; /* the first one's only: what the session draws on; NULL: the CPU */
};

struct session_frame {
    uint64_t number;
    const char *view;   /* "main", "slice-i", ... */
    const char *header; /* a JSON object, to which whoever sends it adds `ms`, and the client's own: `id` and `age` */
    double draw_ms, encode_ms;
    const void *bytes;  /* the encoded picture */
    size_t size;
    bool lossless;
    int client_count;
    struct {
        int client;
        int64_t id; /* of its last command that the picture shows, or -1 */
    } clients[SESSION_MOST_CLIENTS];
};

/* Callbacks come from any thread, `event` and `wanted` with the session locked: none may call it, nor wait. */
struct session_params {
    void *user;
    void (*frame)(void *user, const struct session_frame *frame);
    void (*event)(void *user, int client, const char *text); /* client 0: to all */
    bool (*wanted)(void *user); /* can any face take a further picture of motion? session_wake tells when that changes. NULL: always */

    bool (*open)(void *user, struct session_opened *opened, const struct pel_progress *progress,
                 struct pel_error *error); /* what to begin with; nullable */
    void *open_user;
    const char *const *paths; /* files and folders that may be opened, and what is below these; NULL at the end */

    int threads;         /* of the CPU engine; 0: the machine's */
    double budget_ms;    /* of a picture of motion */
    bool list_devices;   /* tell of GPUs that may be chosen in place of the first one's device */
    uint64_t gpu_memory; /* bytes to use at most of a device that is chosen so; 0: what is free */
    FILE *record;        /* borrowed; each command becomes a line of it. Nullable */
};
#define SESSION_PARAMS_INIT                                                                                                                \
    {                                                                                                                                      \
        .budget_ms = 33                                                                                                                    \
    }

struct session;

struct session *session_create(const struct session_params *params, struct pel_error *error);
/* Ends drawing and reading at their next report. Accepts NULL. */
void session_destroy(struct session *session);

/* One command of a client (1 and above; each number once). A refused one is told by an event, and changes nothing; false then. */
bool session_command(struct session *session, int client, const json_t *command);
bool session_command_text(struct session *session, int client, const char *text, size_t size);

/* A client is gone: its hold is released. */
void session_leave(struct session *session, int client);
/* Whatever hands are down go up; nobody leaves. */
void session_let_go(struct session *session);

/* What was offered and kept long enough is closed. To be called from time to time. */
void session_expire(struct session *session);

/* `wanted` may have changed. */
void session_wake(struct session *session);

/* Waits until all changes so far are in a picture; `rest`: until nothing is left to do (refinement, files being opened, pictures). False:
 * what was to be opened first could not be. */
bool session_settle(struct session *session, bool rest);

/* Reads what a snapshot of a scene (a scene file's text that says everything) is of: what `open` of a replay does. */
bool session_open_snapshot(const char *text, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error);

/* Is it UTF-8, as JSON must be? A path that is not cannot be opened. */
bool session_is_text(const char *text);
#define SESSION_NO_TEXT "its name is no UTF-8 text, which the page and scene files need; rename it, or open it through a link"

/* Is this path one that the session may open? Links are followed before they are judged. */
bool session_may_open(struct session *session, const char *path);
/* Is this path one that the file at `header` may name as its data? An uploaded one names what was uploaded with it, nothing else. */
bool session_may_read(struct session *session, const char *header, const char *path);
/* From now on, too: an upload, as a folder. */
bool session_allow(struct session *session, const char *path, struct pel_error *error);

/* An uploaded folder no longer: it is to be removed. False: what is open now is in it. */
bool session_forget(struct session *session, const char *path);

/* A file that a `download` event offered: a descriptor of its own for the caller to close, -1 where there is none of that number. `name`
 * gets the file's name. */
int session_download(struct session *session, unsigned number, char name[128], const char **type, uint64_t *bytes);

#endif
