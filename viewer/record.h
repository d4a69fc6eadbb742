/* SPDX-License-Identifier: MIT */
/* Recordings: a line of JSON a command, so that a session can be replayed. */
#ifndef VIEWER_RECORD_H
#define VIEWER_RECORD_H

#include <stdint.h>
#include <stdio.h>

#include <jansson.h>

#include <pellucid/scene.h>

/* The first line; `files` ends with NULL. */
bool record_begin(FILE *file, char *const *files, struct pel_error *error);
/* A command, before it is run, so that one that ends the program is in the file. `aside`: it moves the camera while undo or redo reads a
 * file, which then says where the camera is. */
void record_command(FILE *file, double at_ms, int client, const json_t *command, bool aside);

/* A client is gone. */
void record_leave(FILE *file, double at_ms, int client);
/* The file that a command (number `entry` of the commands and clients gone, from 0) read took the scene's place; or was cancelled. What
 * came after the command was meant for the scene before. */
void record_opened(FILE *file, double at_ms, uint64_t entry, bool opened);
/* An error that a client (0: all) was told of. */
void record_error(FILE *file, double at_ms, int client, const char *command);

/* The scene that the first file gave, with all that flags said of it; `fitted`: its camera is to be fitted to the first client's picture.
 */
void record_scene(FILE *file, const struct pel_scene *scene, bool fitted);

/* A recording, whole. What reads a file stands where that took the scene's place. */
struct recording {
    char *scene; /* owned; text of the scene to begin with, or NULL where the session began without a file */
    bool fitted;
    char **files; /* owned; what could be opened. NULL at the end */
    size_t count;
    struct recorded {
        double at_ms;
        int client;      /* 0: to be left out, for nothing came of it */
        json_t *command; /* owned; NULL: the client leaves */
        bool aside;
    } *commands;         /* owned */
    size_t error_count;
    struct recorded_error {
        int client;
        char command[32];
    } *errors; /* owned */
};
bool recording_read(const char *path, struct recording *recording, struct pel_error *error);
void recording_finish(struct recording *recording); /* accepts a zeroed one */

#endif
