/* SPDX-License-Identifier: MIT */
/* Command-line arguments from option tables: each row of a command's groups becomes a flag. --name value, --name=value; a bool as --name,
 * --no-name, --name=off. --help prints what the tables say. */
#ifndef TOOL_ARGUMENTS_H
#define TOOL_ARGUMENTS_H

#include "tool.h"

enum { MAX_GROUPS = 20, MAX_ROWS = 48 };

struct arguments {
    const struct command *command;
    void *objects[MAX_GROUPS]; /* what the rows of each group describe; the caller's */

    /* Called after each value was read into its object; appends the values of flags that may be repeated. Nullable. */
    bool (*assigned)(void *user, const struct pel_option *row, struct pel_error *error);
    void *user;

    const char *text[MAX_GROUPS][MAX_ROWS]; /* the last text given for each row, or NULL */
    int operand_count;                      /* what is no option: file names */
    char **operands;
};

/* Sets defaults, then reads argv into the objects. Negative: go on. Else the exit status: help was printed, or bad usage reported. */
int arguments_parse(struct arguments *arguments, int argc, char **argv);

/* The same for a command that takes between `least` and `most` operands. */
int arguments_parse_operands(struct arguments *arguments, int argc, char **argv, int least, int most);

/* The last text that was given for an option; NULL: it was not given. */
const char *arguments_given(const struct arguments *arguments, const char *name);

/* Sets in `object` what was given for a group's rows, and leaves the rest. */
bool arguments_overlay(const struct arguments *arguments, int group, void *object, struct pel_error *error);

/* What is known of a row, or NULL. */
const struct option_extra *option_extra_find(const struct option_group *group, const char *name);

/* "[default 0.5; 0 to 1; voxels]" without the brackets; empty where there is nothing to say. */
void option_facts(const struct pel_option *row, const struct option_extra *extra, char *text, size_t size);

/* Word for the value: "X,Y,Z", "post|pre|preintegrated". Empty for a bool. */
void option_metavar(const struct pel_option *row, const struct option_extra *extra, char *text, size_t size);

/* The help of one command, and of the whole tool. */
void help_command(const struct command *command, FILE *stream);
void help_overview(FILE *stream);

#endif
