/* SPDX-License-Identifier: MIT */
/* Option: one row that declares one parameter. Tables of rows alone make the command-line flags, the scene file's keys, the viewer's
 * controls, docs/options.md, the man page, the shell completions and the option fuzzer. A parameter is declared in one place.
 *
 * A row says where its value lives in a plain C struct (`offset`), so C programs set the field directly and everything else goes through
 * pel_option_set and pel_option_get. A table ends with a row whose name is NULL. */
#ifndef PELLUCID_OPTION_H
#define PELLUCID_OPTION_H

#include <stdbool.h>
#include <stddef.h>

#include <pellucid/error.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The C type of the field and how its text is read. */
enum pel_option_type {
    PEL_OPTION_BOOL,   /* bool; "true" "false" "on" "off" "yes" "no" "1" "0"; a flag without a value on the command line means true */
    PEL_OPTION_INT,    /* int; within minimum..maximum */
    PEL_OPTION_DOUBLE, /* double; finite, within minimum..maximum */
    PEL_OPTION_CHOICE, /* enum (int): index into choices[] */
    PEL_OPTION_VEC2,   /* double[2]; "a,b" */
    PEL_OPTION_VEC3,   /* double[3]; "x,y,z" */
    PEL_OPTION_VEC6,   /* double[6]; six numbers with commas */
    PEL_OPTION_COLOR,  /* double[4] RGBA 0..1; "r,g,b", "r,g,b,a", "#rgb", "#rrggbb" (both with a too), "transparent", or a common name of
                          CSS: "red", "navy" */
    PEL_OPTION_SIZE,   /* int[2]; "1024x768", "512" (square) */
    PEL_OPTION_TEXT,   /* char[PEL_OPTION_TEXT_SIZE]; any text that fits */
};

#define PEL_OPTION_TEXT_SIZE 4096

struct pel_option {
    const char *name;            /* "camera-position"; the flag is --camera-position, the scene key camera-position */
    const char *label;           /* "Camera position"; for a control's caption */
    const char *help;            /* one or two sentences, no full stop needed at the end, no newline */
    enum pel_option_type type;
    size_t offset;               /* offsetof the field in the struct that the table describes */
    double minimum, maximum;     /* INT, DOUBLE and each number of a VEC; both ends allowed */
    const char *fallback;        /* default, as text; NULL: no default (unset until given) */
    const char *const *choices;  /* CHOICE: NULL-terminated names, else NULL */
    const char *unit;            /* "voxels", "degrees", "data value", ... or NULL */
};

/* Sets every field that has a default to it. */
void pel_option_defaults(const struct pel_option *table, void *object);

/* The row of that name, or NULL. */
const struct pel_option *pel_option_find(const struct pel_option *table, const char *name);

/* Reads text into the row's field. PEL_ERROR_ARGUMENT says which option, what was given and what is allowed; the field keeps its value. */
bool pel_option_set(const struct pel_option *row, void *object, const char *text, struct pel_error *error);

/* Writes the field as text that pel_option_set reads back to the same value. Returns the length that it has, like snprintf. */
int pel_option_get(const struct pel_option *row, const void *object, char *text, size_t size);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
