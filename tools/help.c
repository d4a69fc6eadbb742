/* SPDX-License-Identifier: MIT */
/* --help: what the option tables say, in columns. */
#include "arguments.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

enum { WIDTH = 100, HELP_COLUMN = 30 };

/* Limits beyond this are no limits that anybody needs to read. */
static const double UNBOUNDED = 1e100;

void option_metavar(const struct pel_option *row, const struct option_extra *extra, char *text, size_t size)
{
    static const char *const words[] = {
        [PEL_OPTION_BOOL] = "",     [PEL_OPTION_INT] = "N",         [PEL_OPTION_DOUBLE] = "X",      [PEL_OPTION_CHOICE] = "CHOICE",
        [PEL_OPTION_VEC2] = "A,B",  [PEL_OPTION_VEC3] = "X,Y,Z",    [PEL_OPTION_VEC6] = "A,B,C,D,E,F", [PEL_OPTION_COLOR] = "COLOR",
        [PEL_OPTION_SIZE] = "WxH",  [PEL_OPTION_TEXT] = "TEXT",
    };
    snprintf(text, size, "%s", extra && extra->metavar ? extra->metavar : words[row->type]);
}

/* Appends to a text of limited size. */
static void append(char *text, size_t size, const char *separator, const char *more)
{
    size_t used = strlen(text);
    snprintf(text + used, size - used, "%s%s", used ? separator : "", more);
}

void option_facts(const struct pel_option *row, const struct option_extra *extra, char *text, size_t size)
{
    char part[256];
    text[0] = 0;
    for (const char *const *choice = row->choices; choice && *choice; choice++)
        append(text, size, choice == row->choices ? "" : ", ", *choice);
    if (extra && extra->repeat)
        append(text, size, "; ", "may be repeated");
    if (row->fallback && row->fallback[0] && (row->type != PEL_OPTION_BOOL || strcmp(row->fallback, "false") != 0)) {
        snprintf(part, sizeof part, "default %s", row->fallback);
        append(text, size, "; ", part);
    }
    bool number =
        row->type != PEL_OPTION_BOOL && row->type != PEL_OPTION_CHOICE && row->type != PEL_OPTION_COLOR && row->type != PEL_OPTION_TEXT;
    if (number && row->minimum < row->maximum) {
        bool low = row->minimum > -UNBOUNDED, high = row->maximum < UNBOUNDED;
        if (low && high)
            snprintf(part, sizeof part, "%g to %g", row->minimum, row->maximum);
        else
            snprintf(part, sizeof part, low ? "at least %g" : "at most %g", low ? row->minimum : row->maximum);
        if (low || high)
            append(text, size, "; ", part);
    }
    if (row->unit)
        append(text, size, "; ", row->unit);
}

/* Prints words from `column` on, wrapped at WIDTH and continued at `indent`. */
static void print_wrapped(FILE *stream, const char *text, int column, int indent)
{
    while (*text) {
        while (*text == ' ')
            text++;
        int length = (int)strcspn(text, " \n");
        if (column > indent && column + 1 + length > WIDTH) {
            fprintf(stream, "\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            fputc(' ', stream);
            column++;
        }
        fprintf(stream, "%.*s", length, text);
        column += length;
        text += length;
        if (*text == '\n') {
            fprintf(stream, "\n%*s", indent, "");
            column = indent;
            text++;
        }
    }
    fputc('\n', stream);
}

static void print_option(FILE *stream, const struct option_group *group, const struct pel_option *row)
{
    const struct option_extra *extra = option_extra_find(group, row->name);
    char metavar[64], facts[1024], head[192], help[2048];
    option_metavar(row, extra, metavar, sizeof metavar);
    option_facts(row, extra, facts, sizeof facts);
    char letter[8] = "    ";
    if (extra && extra->letter)
        snprintf(letter, sizeof letter, "-%c, ", extra->letter);
    bool switchable = row->type == PEL_OPTION_BOOL && (!row->fallback || strcmp(row->fallback, "true") == 0);
    snprintf(head, sizeof head, extra && extra->bare ? "  %s--%s%s[=%s]" : "  %s--%s%s%s", letter, row->name,
             metavar[0] && !(extra && extra->bare) ? " " : switchable ? ", --no-" : "", switchable ? row->name : metavar);
    int column = fprintf(stream, "%s", head);
    if (column > HELP_COLUMN - 2) {
        fputc('\n', stream);
        column = 0;
    }
    fprintf(stream, "%*s", HELP_COLUMN - column, "");
    snprintf(help, sizeof help, facts[0] ? "%s [%s]" : "%s", row->help, facts);
    print_wrapped(stream, help, HELP_COLUMN, HELP_COLUMN);
}

void help_command(const struct command *command, FILE *stream)
{
    fprintf(stream, "Usage: pellucid %s%s%s\n\n", command->name, command->usage[0] ? " " : "", command->usage);
    print_wrapped(stream, command->summary, 0, 0);
    if (command->description) {
        fputc('\n', stream);
        print_wrapped(stream, command->description, 0, 0);
    }
    for (const struct option_group *group = option_groups(command); group && group->title; group++) {
        if (!group->rows[0].name)
            continue;
        fprintf(stream, "\n%s:\n", group->title);
        for (const struct pel_option *row = group->rows; row->name; row++)
            print_option(stream, group, row);
    }
    fprintf(stream, "\n  -h, --help%*sShow this text\n", HELP_COLUMN - 12, "");
    if (command->examples)
        fprintf(stream, "\nExamples:\n%s\n", command->examples);
}

void help_overview(FILE *stream)
{
    fprintf(stream, "Usage: pellucid COMMAND [arguments]\n\nLets you see inside volumes and flows.\n\nCommands:\n");
    const struct command *command;
    for (size_t i = 0; (command = command_at(i)); i++)
        fprintf(stream, "  %-12s %s\n", command->name, command->summary);
    fprintf(stream, "\n`pellucid COMMAND --help` tells all about a command; `pellucid --version` the version.\n"
                    "\nTo start with:\n"
                    "  pellucid info scan.nii.gz\n"
                    "  pellucid render scan.nii.gz -o scan.png\n"
                    "  pellucid make hydrogen -o orbital.nrrd\n");
}
