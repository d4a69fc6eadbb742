/* SPDX-License-Identifier: MIT */
/* What the session's files share. All of struct session is under its lock, but for what says otherwise. */
#ifndef VIEWER_SESSION_INSIDE_H
#define VIEWER_SESSION_INSIDE_H

#include <pthread.h>
#include <stdatomic.h>

#include "downloads.h"
#include "encode.h"
#include "history.h"
#include "pace.h"
#include "session.h"

/* A volume and what is told of it. The scene holds one, and whoever draws it or counts it while another is opened. */
struct session_volume {
    int users;
    uint64_t number; /* of this one alone, from 1: memory may come again at the same address */
    struct pel_volume volume;
    struct pel_file_info info;
    json_t *histogram; /* NULL until it is counted */
};

struct session_client {
    int number;                 /* 0: a free place */
    bool greeted, held, slices; /* slices: it asked for them */
    int64_t id;                 /* of its last command, -1 before the first */
    int size[2];                /* of the picture that it has room for; 0: it did not say */
};

/* What `slices` asked for. */
struct session_slices {
    bool on, windowed;
    double at[3], window[2];
    int size[2];
    struct {
        bool on; /* else the whole slice */
        double center[3], scale;
    } views[3];
};

enum { SESSION_CHANGED = 1, SESSION_ENDS = 2 }; /* of session.abort */

enum { SESSION_MOST_DEVICES = 16 };

/* Another device that a client asked for. */
struct session_wish {
    bool there, cpu;
    unsigned number; /* that tells it from the one before */
    int index, client;
    bool has_id;
    int64_t id;
};

struct session_job;     /* jobs.c: a picture or movie under way */
struct session_opening; /* opening.c: a file being read */

struct session {
    struct session_params params;
    pthread_mutex_t lock;
    pthread_cond_t wake;    /* there may be something to draw */
    pthread_cond_t settled; /* something is done */
    pthread_t drawer;
    bool quit, failed;              /* failed: the first file could not be opened */
    atomic_int abort;               /* the drawing under way is no longer wanted: SESSION_CHANGED, or SESSION_ENDS */
    int readers;                    /* threads of session_thread that are at work */
    struct session_helper *helpers; /* these, and those that ended and are not joined yet */
    int listings;                   /* of these, that list a folder */
    uint64_t recorded;              /* entries of the recording: commands, and clients that left */
    double started_ms;
    char **paths; /* real paths that may be opened; NULL at the end */
    int named;    /* so many of them were named at the start; the others are uploads */

    struct pel_scene scene; /* scene.volume is NULL before the first file is read */
    struct session_volume *volume;
    uint64_t volumes; /* read so far */
    struct pel_device *device;
    struct session_wish wish;
    struct {
        atomic_bool listed; /* or about to be */
        int count;
        struct pel_device_info infos[SESSION_MOST_DEVICES];
    } devices;
    struct pel_camera start; /* what `reset` goes back to */
    bool start_fitted;
    int size[2];
    struct session_client clients[SESSION_MOST_CLIENTS];
    bool greeted; /* any client ever said hello: the size is no guess */
    struct history history;

    uint64_t revision; /* counts changes of the picture */
    bool camera_only;  /* the changes since the last frame moved the camera alone */
    double changed_ms; /* when it last changed */
    bool release;      /* a hand went up: full quality at once */
    bool state_dirty;
    uint64_t frames;               /* sent; the drawing thread's alone */
    uint64_t shown, full, refined; /* revisions drawn, drawn in full quality, and finished */
    struct session_slices slices;
    uint64_t slices_revision, slices_shown;
    bool slices_moving; /* what was shown last was drawn under a hand */
    struct session_job *jobs;
    struct session_opening *opening;
    struct downloads downloads;
};

double session_now(void); /* milliseconds of a clock that never jumps */

/* Sets an error; always false. */
bool session_fail(struct pel_error *error, enum pel_error_code code, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Starts a thread that the session's end waits for; it says that it ends by the other, with the lock held. */
bool session_thread(struct session *session, void *(*run)(void *user), void *user, struct pel_error *error);
void session_thread_ends(struct session *session);

/* ---- events.c ---- */

/* Sends and frees an event; `call` (nullable) gives it its `id`. */
struct call;
void session_tell(struct session *session, int client, json_t *event, const struct call *call);
void session_tell_error(struct session *session, int client, const struct pel_error *error, const struct call *call);
void session_tell_volume(struct session *session, int client);
void session_tell_state(struct session *session, int client);
void session_tell_progress(struct session *session, int client, const char *what, double done);
void session_tell_hello(struct session *session, int client, const struct call *call);
/* Offers a file (taken over) for download. `call` is nullable. */
void session_offer(struct session *session, int client, int fd, const char *name, const char *type, const struct call *call);
json_t *session_numbers(const double *values, size_t count);
json_t *session_camera_json(const struct pel_camera *camera);

/* ---- drawing.c ---- */

void *session_draw(void *session); /* the thread */
bool session_held(const struct session *session);
/* The picture changed. */
void session_changed(struct session *session, bool camera_only);
/* What is being drawn is not to be waited for. */
void session_interrupt(struct session *session);
/* What draws the scene: the technique that it names, or the usual one. */
const char *session_technique(const struct pel_scene *scene);
/* Gives the renderer the technique's options that the scene names, the others their defaults. */
bool session_take_options(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, struct pel_error *error);

/* ---- opening.c ---- */

/* Starts to read `path` (NULL: what params.open gives), for `asker` (nullable), who is told where it fails. `step` (taken over, nullable)
 * is what undo (direction -1) or redo (1) go to with it; direction 0: it is a step of its own. */
bool session_open(struct session *session, const struct call *asker, const char *path, const char *array, const struct history_step *step,
                  int direction, struct pel_error *error);
void session_open_cancel(struct session *session);
/* Is a file being read for a step of undo or redo? */
bool session_open_steps(const struct session *session);
void session_volume_release(struct session_volume *volume); /* with the lock held */

/* ---- session_commands.c ---- */

/* One command on its way. */
struct call {
    struct session *session;
    struct session_client *client;
    const json_t *json;
    const char *name;
    bool has_id;
    int64_t id, gesture; /* gesture: 0 where there is none */
    bool nothing;        /* it was refused, for there is nothing for it to do: no fault */
    struct pel_error *error;
};

/* Reading of its keys; refusals name the key. */
bool call_numbers(const struct call *call, const char *key, size_t count, double *out);
bool call_number(const struct call *call, const char *key, double least, double most, double *out);
bool call_size(const struct call *call, const char *key, double most_side, double most_pixels, int size[2]);
const char *call_text(const struct call *call, const char *key, size_t most); /* NULL: refused */
bool call_has(const struct call *call, const char *key);                      /* there, and not null */

/* Takes over a changed scene (its transfer function, too) where it can be drawn. On failure nothing changes; `changed` is finished either
 * way. */
bool session_take_scene(struct session *session, struct pel_scene *changed, struct pel_error *error);
/* A scene file or snapshot may name a technique that cannot draw it here: then the usual one does. */
void session_drop_impossible_technique(const struct session *session, struct pel_scene *scene);
/* A copy to change, to be given to session_take_scene. */
bool session_copy_scene(const struct session *session, struct pel_scene *copy, struct pel_error *error);

/* The scene of a snapshot, to be finished; what the snapshot does not say is empty. */
bool session_scene_from_snapshot(const char *text, const struct pel_volume *volume, struct pel_scene *scene, struct pel_error *error);
/* What is now, as a step to come back to; its text is NULL on failure. */
struct history_step session_step(const struct session *session, struct pel_error *error);
/* A step of undo (-1) or redo (1) that gave `step` (taken over) could not be taken: not now, so it stays a step; or, as `error` says, not
 * ever: then it is dropped, with the steps beyond it that are of the same other file, and `error` tells of it. */
void session_history_back(struct session *session, int direction, struct history_step step, struct pel_error *error);
/* What `reset` goes back to is as it was at that step. */
void session_take_start(struct session *session, const struct history_step *step);
/* It stays a step. */
void session_history_keep(struct session *session, int direction, struct history_step step);

/* The picture's size, anew from what the clients that are there have room for. */
void session_size_again(struct session *session);

/* ---- moves.c: of the camera ---- */
bool run_rotate(struct call *call);
bool run_pan(struct call *call);
bool run_zoom(struct call *call);
bool run_roll(struct call *call);
bool run_view(struct call *call);
bool run_reset(struct call *call);
bool run_focus(struct call *call);
void session_fit_camera(const struct session *session, struct pel_camera *camera);
/* Where nobody has moved the camera of the start yet: fits it to the picture's present size. */
void session_fit_again(struct session *session);

/* ---- edits.c: of the scene ---- */
bool run_set(struct call *call);
bool run_automatic(struct call *call);
bool run_colormap(struct call *call);
bool run_import(struct call *call);
bool run_export(struct call *call);
bool run_scene(struct call *call);
bool run_undo(struct call *call);
bool run_redo(struct call *call);

/* ---- devices.c ---- */
bool run_device(struct call *call);
json_t *session_device_json(const struct session *session);
json_t *session_devices_json(const struct session *session);
void session_tell_devices(struct session *session);
void session_devices_list(struct session *session); /* once; without the lock */
/* Does what session.wish says, by the thread that draws, with the lock held, which is given up meanwhile. True: *renderer is another. */
bool session_device_change(struct session *session, struct pel_renderer **renderer, struct pel_renderer_params params);

/* ---- slices.c ---- */
bool run_slices(struct call *call);
/* A client no longer asks for slices: when none does, they end. */
void session_slices_leave(struct session *session);
bool session_slices_due(const struct session *session);
/* Draws the slices that were asked for and sends them; called without the lock. `*drawer` starts as NULL. */
struct slices_drawer;
struct frame_facts;
void session_slices_draw(struct session *session, struct slices_drawer **drawer, struct encoder *encoder,
                         const struct session_slices *asked, const struct frame_facts *facts);
void session_slices_finish(struct slices_drawer *drawer);

/* ---- probe.c ---- */
bool run_probe(struct call *call);
bool session_pick(struct call *call, double opacity, struct pel_pick *pick);

/* ---- jobs.c ---- */
bool run_picture(struct call *call);
bool run_movie(struct call *call);
bool run_cancel(struct call *call);
/* A picture beyond the machine's memory would be given by the operating system, and end the program halfway. */
bool session_check_memory(const int size[2], struct pel_error *error);
/* Those of one client end. */
void session_jobs_cancel(struct session *session, int client, const char *what); /* NULL: all of the client's */
/* Number of the oldest job's volume, which the renderer is to know. With the lock held. */
uint64_t session_job_volume(const struct session *session);
bool session_job_due(const struct session *session);
/* A step of the oldest job: called without the lock by the thread that draws. */
void session_job_step(struct session *session, struct pel_renderer *renderer);
/* The oldest job cannot be drawn. With the lock held. */
void session_job_fail(struct session *session, const struct pel_error *error);
void session_jobs_finish(struct session *session);

/* ---- folders.c ---- */

/* Is it a file that was named at the start, itself and not a folder that it is in? Without the lock. */
bool session_is_named(struct session *session, const char *path);
/* Is it a file that was uploaded? With the lock held. */
bool session_is_upload(const struct session *session, const char *path);
bool run_list(struct call *call);
bool run_open(struct call *call);

/* ---- frames.c ---- */

/* Encodes and sends a picture; `progress` may end that of a final one, which takes longest. Called without the lock. */
struct frame_facts {
    const char *view, *quality;
    int of[2];
    uint64_t revision, volume; /* volume: its number */
    double draw_ms;
    bool final; /* the last of its view until something changes: sent losslessly */
    const struct pel_scene *scene;
    const struct pel_frame_stats *stats;
    int64_t ids[SESSION_MOST_CLIENTS];
    int clients[SESSION_MOST_CLIENTS], client_count;
};
bool session_send_frame(struct session *session, struct encoder *encoder, const struct pel_image *image, struct frame_facts *facts,
                        const struct pel_progress *progress, struct pel_error *error);
/* Notes whose commands the scene has, of all clients or of those that asked for slices: they get the picture. With the lock held. */
void session_note_clients(const struct session *session, struct frame_facts *facts, bool slices);

#endif
