/* SPDX-License-Identifier: MIT */
/* pellucid options and pellucid man: the reference pages, from the same tables as the flags, so that they cannot disagree. */
#include <string.h>

#include "arguments.h"
#include "commands.h"

/* Markdown: what a table cell cannot hold as it is. */
static void markdown(const char *text)
{
    for (const char *c = text; *c; c++) {
        if (strchr("|<>*_", *c))
            putchar('\\');
        putchar(*c);
    }
}

static void markdown_group(const struct option_group *group, const char *heading, const char *title)
{
    if (!group->rows[0].name)
        return;
    printf("\n%s %s\n\n| option | what it does | values |\n| --- | --- | --- |\n", heading, title);
    for (const struct pel_option *row = group->rows; row->name; row++) {
        const struct option_extra *extra = option_extra_find(group, row->name);
        char metavar[64], facts[1024];
        option_metavar(row, extra, metavar, sizeof metavar);
        option_facts(row, extra, facts, sizeof facts);
        printf("| `");
        if (extra && extra->letter)
            printf("-%c`, `", extra->letter);
        printf("--%s", row->name);
        for (const char *c = metavar; *c; c++)
            printf("%s%s%c", c == metavar ? extra && extra->bare ? "=" : " " : "", *c == '|' ? "\\" : "", *c);
        printf("` | ");
        markdown(row->help);
        printf(" | ");
        markdown(facts);
        printf(" |\n");
    }
}

static bool is_shared(const struct option_group *group)
{
    for (const struct option_group *g = option_groups(&command_render); g->title; g++)
        if (g->rows == group->rows)
            return true;
    return false;
}

static void markdown_command(const struct command *command)
{
    printf("\n## pellucid %s\n\n`pellucid %s%s%s`\n\n", command->name, command->name, command->usage[0] ? " " : "", command->usage);
    markdown(command->summary);
    printf(".\n");
    if (command->description) {
        putchar('\n');
        markdown(command->description);
        putchar('\n');
    }
    bool shared = false;
    for (const struct option_group *group = option_groups(command); group && group->title; group++) {
        if (command != &command_render && is_shared(group))
            shared = true;
        else
            markdown_group(group, "###", group->title);
    }
    if (shared)
        printf("\nIt takes all options of [render](#pellucid-render) but those under *Output*, too.\n");
    if (command->examples)
        printf("\n```sh\n%s\n```\n", command->examples);
    const struct pel_dataset *dataset;
    for (size_t i = 0; command == &command_make && (dataset = pel_dataset_at(i)); i++) {
        const struct option_group group = { dataset->name, dataset->options, NULL };
        printf("\n### %s\n\n", dataset->name);
        markdown(dataset->summary);
        if (dataset->citation) {
            printf(". ");
            markdown(dataset->citation);
        }
        putchar('\n');
        markdown_group(&group, "####", "Parameters");
    }
}

static int run_options(const struct command *command, int argc, char **argv)
{
    struct arguments arguments = { .command = command };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status >= 0)
        return status;
    printf("# Options of the pellucid tool\n\n"
           "Made by `pellucid options` from the option tables; do not edit. The rows under *Optics*, *Camera* and of the techniques are "
           "the keys of a scene file, too.\n\n"
           "A flag is written `--name value` or `--name=value`. A switch is `--name`, `--no-name` or `--name=off`. Numbers of a vector are "
           "separated by commas. Colours are `r,g,b` or `r,g,b,a` from 0 to 1, `#rgb`, `#rrggbb` (with a digit or two more for "
           "opacity), `transparent`, or a common name of CSS such as `red`, `navy`, `orange`.\n\n"
           "Exit status: 0 done; 1 bad data, or the system refused (`compare`: not alike); 2 bad usage; 130 interrupted.\n");
    for (size_t i = 0; command_at(i); i++)
        markdown_command(command_at(i));
    return tool_finish_stdout(EXIT_FINE);
}

const struct command command_options = {
    .name = "options",
    .summary = "Print the reference of all options as Markdown",
    .usage = "",
    .run = run_options,
};

/* roff: a hyphen that is typed, a backslash, and lines that begin like a request. */
static void roff(const char *text)
{
    bool start = true;
    for (const char *c = text; *c; c++) {
        if (start && (*c == '.' || *c == '\''))
            fputs("\\&", stdout);
        start = *c == '\n';
        if (*c == '-')
            fputs("\\-", stdout);
        else if (*c == '\\')
            fputs("\\e", stdout);
        else if (*c == '\n' && c[1] == '\n') {
            fputs("\n.PP\n", stdout);
            c++;
        } else
            putchar(*c);
    }
}

static void roff_group(const struct option_group *group, const char *title)
{
    if (!group->rows[0].name)
        return;
    printf(".PP\n.I ");
    roff(title);
    putchar('\n');
    for (const struct pel_option *row = group->rows; row->name; row++) {
        const struct option_extra *extra = option_extra_find(group, row->name);
        char metavar[64], facts[1024], flag[128];
        option_metavar(row, extra, metavar, sizeof metavar);
        option_facts(row, extra, facts, sizeof facts);
        printf(".TP\n\\fB");
        if (extra && extra->letter)
            printf("\\-%c\\fR, \\fB", extra->letter);
        snprintf(flag, sizeof flag, "--%s", row->name);
        roff(flag);
        printf("\\fR%s\\fI", metavar[0] ? extra && extra->bare ? "=" : " " : "");
        roff(metavar);
        printf("\\fR\n");
        roff(row->help);
        if (facts[0]) {
            printf(" [");
            roff(facts);
            printf("]");
        }
        putchar('\n');
    }
}

static void roff_command(const struct command *command)
{
    printf(".SS pellucid %s ", command->name);
    roff(command->usage);
    putchar('\n');
    roff(command->summary);
    printf(".\n");
    if (command->description) {
        printf(".PP\n");
        roff(command->description);
        putchar('\n');
    }
    bool shared = false;
    for (const struct option_group *group = option_groups(command); group && group->title; group++) {
        if (command != &command_render && is_shared(group))
            shared = true;
        else
            roff_group(group, group->title);
    }
    if (shared)
        printf(".PP\nIt takes all options of render but those under Output, too.\n");
    const struct pel_dataset *dataset;
    for (size_t i = 0; command == &command_make && (dataset = pel_dataset_at(i)); i++) {
        char title[256];
        const struct option_group group = { dataset->name, dataset->options, NULL };
        snprintf(title, sizeof title, "%s: %s", dataset->name, dataset->summary);
        roff_group(&group, title);
    }
    if (command->examples) {
        printf(".PP\nExamples:\n.PP\n.nf\n");
        roff(command->examples);
        printf("\n.fi\n");
    }
}

static int run_man(const struct command *command, int argc, char **argv)
{
    struct arguments arguments = { .command = command };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status >= 0)
        return status;
    printf(".TH PELLUCID 1 \"\" \"pellucid %s\" \"User Commands\"\n", pel_version());
    printf(
        ".SH NAME\npellucid \\- see inside volumes and flows\n.SH SYNOPSIS\n.B pellucid\n.I command\n.RI [ arguments ]\n.SH DESCRIPTION\n");
    roff("Draws volumes and fields on a machine with or without a GPU, tells what files hold, converts and compares them.\n\n"
         "A flag is written --name value or --name=value. A switch is --name, --no-name or --name=off. Colours are r,g,b or r,g,b,a from "
         "0 to 1, #rgb, #rrggbb (with a digit or two more for opacity), transparent, or a common name of CSS such as red, navy, orange.\n");
    printf(".SH COMMANDS\n");
    for (size_t i = 0; command_at(i); i++)
        roff_command(command_at(i));
    printf(".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\nbad data, or the system refused; compare: not alike\n.TP\n2\nbad "
           "usage\n.TP\n130\ninterrupted\n");
    printf(".SH ENVIRONMENT\n.TP\n.B PELLUCID_ISA\nforces the instruction set of the CPU kernels: x86\\-64\\-v2, x86\\-64\\-v3 or "
           "x86\\-64\\-v4\n"
           ".TP\n.B OMP_NUM_THREADS\nthreads where \\-\\-threads does not say\n");
    return tool_finish_stdout(EXIT_FINE);
}

const struct command command_man = {
    .name = "man",
    .summary = "Print the manual page (roff)",
    .usage = "",
    .run = run_man,
};
