/* SPDX-License-Identifier: MIT */
/* Reads a command line by its option tables. getopt_long does the splitting; its flags are built from the rows, so a parameter that is
 * added to a table is a flag at once, with its help, its limits and its completion. */
#include "arguments.h"

#include <getopt.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Flags that getopt_long may meet: one a row, one more ("no-...") a bool, and help. */
enum { MAX_FLAGS = 2 * MAX_GROUPS * MAX_ROWS + 2, FIRST_FLAG = 256 /* getopt_long gives FIRST_FLAG + index; letters are below */ };

struct flags {
    struct option list[MAX_FLAGS];
    struct {
        int group, row;
        bool negated;
    } meaning[MAX_FLAGS];
    char names[MAX_FLAGS / 2][64]; /* the "no-..." names */
    char letters[64];
    int count;
};

const struct option_extra *option_extra_find(const struct option_group *group, const char *name)
{
    for (const struct option_extra *extra = group->extras; extra && extra->name; extra++)
        if (strcmp(extra->name, name) == 0)
            return extra;
    return NULL;
}

/* One list a drawing command, made when it is first asked for. */
const struct option_group *option_groups(const struct command *command)
{
    enum { MOST_COMMANDS = 8 };
    static struct {
        const struct command *command;
        struct option_group groups[MAX_GROUPS + 1];
        char titles[MAX_GROUPS][64];
    } lists[MOST_COMMANDS];
    if (!command->draws)
        return command->groups;
    int l = 0, count = 0;
    while (l < MOST_COMMANDS - 1 && lists[l].command && lists[l].command != command)
        l++;
    if (lists[l].command == command)
        return lists[l].groups;
    memset(&lists[l], 0, sizeof lists[l]);
    lists[l].command = command;
    for (; command->groups[count].title; count++)
        lists[l].groups[count] = command->groups[count];
    const struct pel_technique_info *technique;
    for (size_t i = 0; count < MAX_GROUPS && (technique = pel_technique_at(i)); i++)
        if (technique->options[0].name) {
            snprintf(lists[l].titles[count], sizeof lists[l].titles[count], "Technique %s", technique->name);
            lists[l].groups[count] = (struct option_group) { lists[l].titles[count], technique->options, NULL };
            count++;
        }
    return lists[l].groups;
}

static void add_flag(struct flags *flags, const char *name, int has_argument, int group, int row, bool negated)
{
    flags->list[flags->count] = (struct option) { name, has_argument, NULL, FIRST_FLAG + flags->count };
    flags->meaning[flags->count].group = group;
    flags->meaning[flags->count].row = row;
    flags->meaning[flags->count].negated = negated;
    flags->count++;
}

static void build_flags(struct flags *flags, const struct command *command)
{
    memset(flags, 0, sizeof *flags);
    char *letter = flags->letters;
    *letter++ = ':'; /* a missing value is told apart from an unknown flag */
    *letter++ = 'h';
    add_flag(flags, "help", no_argument, -1, 0, false);
    const struct option_group *groups = option_groups(command);
    for (int g = 0; groups && groups[g].title && g < MAX_GROUPS; g++) {
        const struct option_group *group = &groups[g];
        for (int r = 0; group->rows[r].name && r < MAX_ROWS; r++) {
            const struct pel_option *row = &group->rows[r];
            const struct option_extra *extra = option_extra_find(group, row->name);
            bool optional = row->type == PEL_OPTION_BOOL || (extra && extra->bare);
            if (extra && extra->letter) {
                *letter++ = extra->letter;
                if (row->type != PEL_OPTION_BOOL)
                    *letter++ = ':';
            }
            if (row->type == PEL_OPTION_BOOL) {
                char *name = flags->names[flags->count / 2];
                snprintf(name, sizeof flags->names[0], "no-%s", row->name);
                add_flag(flags, row->name, optional_argument, g, r, false);
                add_flag(flags, name, no_argument, g, r, true);
            } else {
                add_flag(flags, row->name, optional ? optional_argument : required_argument, g, r, false);
            }
        }
    }
}

/* Index of the flag that a short letter stands for. */
static int flag_of_letter(const struct flags *flags, const struct command *command, int letter)
{
    for (int i = 1; i < flags->count; i++) {
        const struct option_group *group = &option_groups(command)[flags->meaning[i].group];
        const struct option_extra *extra = option_extra_find(group, group->rows[flags->meaning[i].row].name);
        if (extra && extra->letter == letter && !flags->meaning[i].negated)
            return i;
    }
    return 0; /* not reached: getopt_long knows only letters of the tables */
}

static const char *flag_name(const void *user, size_t index)
{
    const struct flags *flags = user;
    return index < (size_t)flags->count ? flags->list[index].name : NULL;
}

/* Why getopt_long refused a word: unknown, ambiguous, or a value where none belongs. */
static bool refuse_flag(const struct flags *flags, const struct command *command, const char *word, struct pel_error *error)
{
    char name[64];
    const char *start = word + (word[0] == '-') + (word[0] == '-' && word[1] == '-');
    size_t length = strcspn(start, "=");
    snprintf(name, sizeof name, "%.*s", (int)length, start);
    const char *first = NULL, *second = NULL;
    for (int i = 0; i < flags->count && length > 0; i++) {
        if (strcmp(flags->list[i].name, name) == 0)
            return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: --%s takes no value", command->name, name);
        if (strncmp(flags->list[i].name, name, length) == 0) {
            second = first ? second ? second : flags->list[i].name : NULL;
            first = first ? first : flags->list[i].name;
        }
    }
    if (second)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: --%s could be --%s or --%s", command->name, name, first, second);
    const char *nearest = tool_nearest(name, flag_name, flags);
    if (nearest)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: unknown option %.60s; did you mean --%s?", command->name, word, nearest);
    return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: unknown option %.60s; see pellucid %s --help", command->name, word, command->name);
}

/* A flag whose value may be left out takes the next word only if that is one of its choices: `--stats json`. */
static const char *optional_value(const struct pel_option *row, const char *next, const struct option_extra *extra)
{
    for (const char *const *choice = row->choices; next && choice && *choice; choice++)
        if (strcmp(*choice, next) == 0) {
            optind++;
            return next;
        }
    /* A word that is no flag and no file is a choice mistaken; the row says which there are. */
    if (row->choices && next && next[0] != '-' && !strpbrk(next, "./") && access(next, F_OK) != 0) {
        optind++;
        return next;
    }
    return extra ? extra->bare : NULL;
}

static bool assign(struct arguments *arguments, int g, int r, const char *text, struct pel_error *error)
{
    const struct pel_option *row = &option_groups(arguments->command)[g].rows[r];
    if (row->type == PEL_OPTION_TEXT && strlen(text) >= PEL_OPTION_TEXT_SIZE)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--%s: the text is longer than %d bytes", row->name, PEL_OPTION_TEXT_SIZE - 1);
    if (!pel_option_set(row, arguments->objects[g], text, error)) {
        char old[sizeof error->message];
        memcpy(old, error->message, sizeof old);
        return tool_fail(error, error->code, "--%.500s", old); /* the row's name begins it */
    }
    arguments->text[g][r] = text;
    const struct option_group *groups = option_groups(arguments->command);
    for (int other = g + 1; groups[other].title; other++) { /* techniques may share an option's name */
        const struct pel_option *same = pel_option_find(groups[other].rows, row->name);
        if (!same)
            continue;
        if (!pel_option_set(same, arguments->objects[other], text, error))
            return tool_fail_in(error, groups[other].title);
        arguments->text[other][same - groups[other].rows] = text;
    }
    return !arguments->assigned || arguments->assigned(arguments->user, row, error);
}

/* One flag that getopt_long found. */
static bool take_flag(struct arguments *arguments, const struct flags *flags, int index, int argc, char **argv, struct pel_error *error)
{
    int g = flags->meaning[index].group, r = flags->meaning[index].row;
    const struct option_group *group = &option_groups(arguments->command)[g];
    const char *text = optarg;
    if (flags->meaning[index].negated)
        text = "false";
    else if (!text && group->rows[r].type == PEL_OPTION_BOOL)
        text = "true";
    else if (!text)
        text = optional_value(&group->rows[r], optind < argc ? argv[optind] : NULL, option_extra_find(group, group->rows[r].name));
    return assign(arguments, g, r, text, error);
}

/* What getopt_long found, or why it found nothing. True: help was asked for. */
static bool take(struct arguments *arguments, const struct flags *flags, int found, int argc, char **argv, struct pel_error *error)
{
    const char *name = arguments->command->name;
    if (found == 'h' || found == FIRST_FLAG)
        return true;
    if (found >= FIRST_FLAG)
        take_flag(arguments, flags, found - FIRST_FLAG, argc, argv, error);
    else if (found == ':')
        tool_fail(error, PEL_ERROR_ARGUMENT, "%s: %s needs a value; see pellucid %s --help", name, argv[optind - 1], name);
    else if (found != '?')
        take_flag(arguments, flags, flag_of_letter(flags, arguments->command, found), argc, argv, error);
    else if (optopt > 0 && optopt < FIRST_FLAG)
        tool_fail(error, PEL_ERROR_ARGUMENT, "%s: unknown option -%c; see pellucid %s --help", name, optopt, name);
    else
        refuse_flag(flags, arguments->command, argv[optind - 1], error);
    return false;
}

static bool parse(struct arguments *arguments, int argc, char **argv, struct pel_error *error)
{
    struct flags *flags = malloc(sizeof *flags);
    if (!flags)
        return tool_fail(error, PEL_ERROR_MEMORY, "no memory for the command line");
    build_flags(flags, arguments->command);
    bool help = false;
    optind = 0; /* glibc: start anew */
    opterr = 0;
    while (!help && error->code == PEL_ERROR_NONE) {
        int found = getopt_long(argc, argv, flags->letters, flags->list, NULL);
        if (found == -1)
            break;
        help = take(arguments, flags, found, argc, argv, error);
    }
    arguments->operands = argv + optind;
    arguments->operand_count = argc - optind;
    free(flags);
    return help;
}

int arguments_parse(struct arguments *arguments, int argc, char **argv)
{
    const struct option_group *groups = option_groups(arguments->command);
    for (int g = 0; groups && groups[g].title; g++)
        pel_option_defaults(groups[g].rows, arguments->objects[g]);
    struct pel_error error = PEL_ERROR_INIT;
    if (parse(arguments, argc, argv, &error)) {
        help_command(arguments->command, stdout);
        return tool_finish_stdout(EXIT_FINE);
    }
    return error.code == PEL_ERROR_NONE ? -1 : tool_report(&error);
}

int arguments_parse_operands(struct arguments *arguments, int argc, char **argv, int least, int most)
{
    int status = arguments_parse(arguments, argc, argv);
    if (status >= 0)
        return status;
    if (arguments->operand_count >= least && arguments->operand_count <= most)
        return -1;
    struct pel_error error = PEL_ERROR_INIT;
    const char *name = arguments->command->name;
    if (arguments->operand_count > most)
        tool_fail(&error, PEL_ERROR_ARGUMENT, "%s: one word too many: %.200s; usage: pellucid %s %s", name, arguments->operands[most], name,
                  arguments->command->usage);
    else
        tool_fail(&error, PEL_ERROR_ARGUMENT, "%s: an argument is missing; usage: pellucid %s %s", name, name, arguments->command->usage);
    return tool_report(&error);
}

const char *arguments_given(const struct arguments *arguments, const char *name)
{
    const struct option_group *groups = option_groups(arguments->command);
    for (int g = 0; groups && groups[g].title; g++)
        for (int r = 0; groups[g].rows[r].name; r++)
            if (strcmp(groups[g].rows[r].name, name) == 0 && arguments->text[g][r])
                return arguments->text[g][r];
    return NULL;
}

bool arguments_overlay(const struct arguments *arguments, int group, void *object, struct pel_error *error)
{
    const struct pel_option *rows = option_groups(arguments->command)[group].rows;
    for (int r = 0; rows[r].name; r++)
        if (arguments->text[group][r] && !pel_option_set(&rows[r], object, arguments->text[group][r], error))
            return false;
    return true;
}
