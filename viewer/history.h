/* SPDX-License-Identifier: MIT */
/* Undo and redo: what the scene was before each step, as the text of a scene file, and the camera that `reset` went back to then. A gesture
 * (a drag) is one step, however many changes it makes: only the first of them asks for a text. */
#ifndef VIEWER_HISTORY_H
#define VIEWER_HISTORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <pellucid/camera.h>

enum { HISTORY_MOST_STEPS = 256, HISTORY_MOST_BYTES = 32 << 20 };

struct history_step {
    char *text; /* owned by whoever has the step */
    struct pel_camera start;
    bool fitted; /* the start is fitted to the picture's size */
};

struct history_list {
    struct history_step steps[HISTORY_MOST_STEPS]; /* the last is the nearest one */
    int count;
    size_t bytes;
};

/* Starts zeroed. */
struct history {
    struct history_list undo, redo;
    int client; /* whose gesture made the last step; 0: it cannot be continued */
    int64_t gesture;
};

void history_finish(struct history *history);

/* Does a change of this client's gesture (0: none) begin a new step, for which history_push is owed? */
bool history_begins(const struct history *history, int client, int64_t gesture);

/* A step was made, before which the scene was `before` (taken over). What was undone cannot be redone any more. */
void history_push(struct history *history, int client, int64_t gesture, struct history_step before);

/* A step back or forward: gives the one to return to (its text is the caller's to free) and keeps `now` (taken over) for the way back. The
 * text is NULL where there is none: then that of `now` is freed. */
struct history_step history_undo(struct history *history, struct history_step now);
struct history_step history_redo(struct history *history, struct history_step now);

/* The step back (direction -1) or forward (1) that was just taken led nowhere: the scene is still what it was, and that step is no more;
 * nor are the nearest ones beyond it that `same` (nullable) is true of. Gives how many these were. */
int history_drop(struct history *history, int direction, bool (*same)(const char *text, const void *user), const void *user);

#endif
