/* SPDX-License-Identifier: MIT */
/* How every part of a scene file is read (which parts there are is in scene_read.c): by tables of keys or of options, with a note of where
 * in the file the reader stands. */
#ifndef PEL_IO_SCENE_READING_H
#define PEL_IO_SCENE_READING_H

#include <jansson.h>

#include <pellucid/io.h>

struct pel_scene_reading {
    struct pel_scene scene; /* a copy, being changed */
    struct pel_scene_parts has;
    const char *path; /* the scene file's, or NULL: paths are as the process sees them */
    char where[256];  /* "transfer.colors[2]" */
    struct pel_error *error;
};

struct pel_scene_key {
    const char *name;
    bool (*read)(struct pel_scene_reading *r, const json_t *value, void *object);
    size_t offset; /* of what it reads in the object that the table is for */
};

/* Append to `where`; give the length to go back to. Where something fails nobody goes back: `where` tells. */
size_t pel_scene_enter(struct pel_scene_reading *r, const char *key);
size_t pel_scene_enter_entry(struct pel_scene_reading *r, size_t index);
void pel_scene_leave(struct pel_scene_reading *r, size_t length);

/* Reads every member of an object by a table that ends with a NULL name. */
bool pel_scene_read_object(struct pel_scene_reading *r, const json_t *value, const struct pel_scene_key *keys, void *object);

/* The same by a table of options. */
bool pel_scene_read_options(struct pel_scene_reading *r, const json_t *value, const struct pel_option *table, void *object);

/* A value as the text that an option reads: numbers of an array with commas between. */
bool pel_scene_value_text(struct pel_scene_reading *r, const json_t *value, char *text, size_t size);

/* Is it an array of `most` entries or fewer? */
bool pel_scene_check_array(struct pel_scene_reading *r, const json_t *value, size_t most);

#endif
