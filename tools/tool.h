/* SPDX-License-Identifier: MIT */
/* What the commands of the tool share: the form of a command, exit statuses, how errors and notes are told, time, and JSON. */
#ifndef TOOL_TOOL_H
#define TOOL_TOOL_H

#include <stdio.h>

#include <jansson.h>

#include <pellucid/pellucid.h>

/* Exit statuses. Scripts rely on them. */
enum {
    EXIT_FINE = 0,
    EXIT_FAILED = 1,      /* bad data, the operating system refused, or `compare` found the pictures unlike */
    EXIT_USAGE = 2,       /* asked for something that makes no sense */
    EXIT_INTERRUPTED = 130,
};

/* What the command line knows of an option beyond its row. */
struct option_extra {
    const char *name;       /* the row's; NULL at the end */
    char letter;            /* -o for --output; 0: none */
    const char *metavar;    /* word for the value in help; NULL: from the type */
    const char *bare;       /* value where the flag is given without one; NULL: a value is needed */
    bool repeat;            /* may be given several times */
};

/* Options under one heading in the help. One table describes one C object. */
struct option_group {
    const char *title; /* NULL at the end */
    const struct pel_option *rows;
    const struct option_extra *extras; /* nullable */
};

struct command {
    const char *name, *summary;
    const char *usage;       /* what follows the name: "FILE -o PICTURE [options]" */
    const char *description; /* paragraphs, separated by an empty line; nullable */
    const char *examples;    /* lines; nullable */
    const struct option_group *groups;
    bool draws; /* takes the techniques' own options, too (option_groups) */
    int (*run)(const struct command *command, int argc, char **argv); /* argv[0] is the command's name; gives the exit status */
};

/* A command's groups of options: its own, and where it draws, a group more for each technique that has options. */
const struct option_group *option_groups(const struct command *command);

/* The commands in the order of the help; NULL at the end. */
const struct command *command_at(size_t index);
const struct command *command_find(const char *name);

/* Sets an error; always false. */
bool tool_fail(struct pel_error *error, enum pel_error_code code, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Puts "prefix: " before the message, unless it begins so already; always false. */
bool tool_fail_in(struct pel_error *error, const char *prefix);

/* "pellucid: message" on stderr, on one line whatever the message holds; gives the exit status that fits the code. */
int tool_report(const struct pel_error *error);

/* "pellucid: note: ..." on stderr. */
void tool_note(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Flushes standard output; a full disk or a closed pipe is an error. `status` where all is well. */
int tool_finish_stdout(int status);

/* Milliseconds of a clock that never jumps. */
double tool_milliseconds(void);

/* The known word nearest to `word`, or NULL where none is near: for "did you mean". `next` gives the known words, NULL at the end. */
const char *tool_nearest(const char *word, const char *(*next)(const void *user, size_t index), const void *user);

/* Whether two paths are one regular file, or would be once written. */
bool tool_same_file(const char *a, const char *b);
/* Whether writing `path` would replace the input (nullable), or data that its header names. */
bool tool_reads_from(const char *input, const char *path);

/* A JSON number that reads back to the same double; null for NaN, the greatest double for the infinities, which JSON cannot say. */
json_t *json_number(double value);
json_t *json_numbers(const double *values, size_t count);
/* A JSON string; bytes that are no UTF-8 are taken as Latin-1. */
json_t *json_text(const char *text);
/* Prints it to a stream, indented, and frees it. False: out of memory. */
bool json_print(json_t *json, FILE *stream);

#endif
