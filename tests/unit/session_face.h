/* SPDX-License-Identifier: MIT */
/* A face of the viewer's session for its tests: it remembers what came out. */
#ifndef SESSION_FACE_H
#define SESSION_FACE_H

#include <pthread.h>

#include "session.h"

/* A session on a computed volume, and what came out of it. */
struct face {
    struct session *session;
    pthread_mutex_t lock;
    json_t *events; /* an array */
    int frames, moving;
    int64_t id;    /* of client 1, in the last main frame */
    void *picture; /* the last lossless main one */
    size_t size;
    bool final;                /* of the last main frame */
    int finals;                /* main frames that said so */
    char views[256];           /* that came */
    int full;                  /* main frames in full quality */
    int slices, slice_clients; /* frames of slices, and who got the last one: a bit for each client */
    bool unwanted;
};

/* A small volume, with all that can be seen in it. */
bool compute(struct pel_volume *volume, struct pel_error *error);
bool open_computed(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error);
/* `open` and `record` may be NULL. */
void start_with(struct face *face, const char *const *paths, FILE *record,
                bool (*open)(void *, struct session_opened *, const struct pel_progress *, struct pel_error *), void *open_user);
/* A command of a client; false: it was refused. */
bool say(struct face *face, int client, const char *text);
/* Of every kind of command one that is taken; NULL at the end. */
extern const char *const good_commands[];
/* With a first client that said hello. */
void start(struct face *face);
void finish(struct face *face);
/* The last event of a kind; NULL: there was none. Borrowed. */
json_t *last(struct face *face, const char *kind);
/* The scene, at rest, as the last `state` tells it. Borrowed. */
json_t *scene(struct face *face);
/* A member of a member of it. */
json_t *part(struct face *face, const char *a, const char *b);
/* The picture at rest, owned. */
void *rest(struct face *face, size_t *size);
/* Is that the picture at rest still? */
bool same(struct face *face, const void *picture, size_t size);
/* How many were told. */
int errors(struct face *face);

/* A session whose files are in a folder of its own, at first two volumes. */
struct files {
    struct face face;
    char folder[64], a[256], b[256];
};

void make(struct files *f); /* the files alone */
void begin(struct files *f);
void done(struct files *f);
bool say_of(struct files *f, const char *format, const char *path);
/* Opens it. */
void show(struct files *f, const char *path);
/* How many there are of "undo", "redo". */
int steps(struct files *f, const char *which);
/* Writes into a file. */
void put(const char *folder, const char *name, size_t at, const char *bytes);

#endif
