/* SPDX-License-Identifier: MIT */
/* pellucid completion: what a shell needs to complete commands, flags and their values, from the tables. */
#include <string.h>

#include "arguments.h"
#include "commands.h"

/* Calls back for each option of a command; `make` has those of all data sets. */
typedef void option_visitor(const struct command *command, const struct pel_option *row, const struct option_extra *extra);

static void each_option(const struct command *command, option_visitor *visit)
{
    for (const struct option_group *group = option_groups(command); group && group->title; group++)
        for (const struct pel_option *row = group->rows; row->name; row++)
            visit(command, row, option_extra_find(group, row->name));
    const struct pel_dataset *dataset;
    for (size_t i = 0; command == &command_make && (dataset = pel_dataset_at(i)); i++)
        for (const struct pel_option *row = dataset->options; row->name; row++) {
            bool before = false; /* several data sets have a size */
            for (size_t j = 0; j < i; j++)
                before |= pel_option_find(pel_dataset_at(j)->options, row->name) != NULL;
            if (!before)
                visit(command, row, NULL);
        }
}

/* Prints the words that the value may be, separated by spaces; false where it may be anything. */
static bool print_values(const struct pel_option *row)
{
    const char *name;
    if (row->choices) {
        for (size_t i = 0; row->choices[i]; i++)
            printf("%s%s", i ? " " : "", row->choices[i]);
        return true;
    }
    if (strcmp(row->name, "colormap") == 0) {
        for (size_t i = 0; (name = pel_colormap_name(i)); i++)
            printf("%s%s", i ? " " : "", name);
        return true;
    }
    if (strcmp(row->name, "technique") == 0) {
        for (size_t i = 0; pel_technique_at(i); i++)
            printf("%s%s", i ? " " : "", pel_technique_at(i)->name);
        return true;
    }
    return false;
}

static bool has_values(const struct pel_option *row)
{
    return row->choices || strcmp(row->name, "colormap") == 0 || strcmp(row->name, "technique") == 0;
}

/* Words that may come as operands, beside files. */
static void print_operands(const struct command *command)
{
    if (command == &command_completion)
        printf("bash zsh fish");
    for (size_t i = 0; command == &command_make && pel_dataset_at(i); i++)
        printf("%s%s", i ? " " : "", pel_dataset_at(i)->name);
}

static bool takes_files(const struct command *command)
{
    return command == &command_info || command == &command_render || command == &command_convert || command == &command_compare ||
           command == &command_bench;
}

static void print_commands(void)
{
    for (size_t i = 0; command_at(i); i++)
        printf("%s%s", i ? " " : "", command_at(i)->name);
}

static void bash_flag(const struct command *command, const struct pel_option *row, const struct option_extra *extra)
{
    (void)command;
    printf(" --%s", row->name);
    if (row->type == PEL_OPTION_BOOL && (!row->fallback || strcmp(row->fallback, "true") == 0))
        printf(" --no-%s", row->name);
    if (extra && extra->letter)
        printf(" -%c", extra->letter);
}

static void bash_value(const struct command *command, const struct pel_option *row, const struct option_extra *extra)
{
    if (row->type == PEL_OPTION_BOOL)
        return;
    printf("    %s:--%s", command->name, row->name);
    if (extra && extra->letter)
        printf("|%s:-%c", command->name, extra->letter);
    printf(") ");
    if (has_values(row)) {
        printf("COMPREPLY=($(compgen -W '");
        print_values(row);
        printf("' -- \"$word\"))");
        if (strcmp(row->name, "colormap") == 0)
            printf("; COMPREPLY+=($(compgen -f -- \"$word\"))");
    } else if (row->type == PEL_OPTION_TEXT) {
        printf("COMPREPLY=($(compgen -f -- \"$word\"))");
    } else {
        printf("COMPREPLY=()");
    }
    printf("; return ;;\n");
}

static void print_bash(void)
{
    printf("# bash completion of pellucid; made by `pellucid completion bash`\n"
           "_pellucid()\n{\n"
           "    local word=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD - 1]}\" command=\"${COMP_WORDS[1]}\" flags=\n"
           "    if ((COMP_CWORD == 1)); then\n        COMPREPLY=($(compgen -W '");
    print_commands();
    printf(" --help --version' -- \"$word\"))\n        return\n    fi\n    case \"$command:$before\" in\n");
    for (size_t i = 0; command_at(i); i++)
        each_option(command_at(i), bash_value);
    printf("    esac\n    case \"$command\" in\n");
    for (size_t i = 0; command_at(i); i++) {
        printf("    %s) flags='--help", command_at(i)->name);
        each_option(command_at(i), bash_flag);
        printf("' words='");
        print_operands(command_at(i));
        printf("' ;;\n");
    }
    printf("    esac\n"
           "    if [[ $word == -* ]]; then\n        COMPREPLY=($(compgen -W \"$flags\" -- \"$word\"))\n"
           "    else\n        COMPREPLY=($(compgen -W \"$words\" -- \"$word\") $(compgen -f -- \"$word\"))\n    fi\n"
           "}\ncomplete -o filenames -F _pellucid pellucid\n");
}

/* Inside single quotes; a bracket or colon has a meaning for zsh's _arguments. */
static void quoted(const char *text, bool zsh)
{
    for (const char *c = text; *c; c++) {
        if (*c == '\'')
            fputs("'\\''", stdout);
        else if (zsh && strchr("[]:\\", *c))
            printf("\\%c", *c);
        else if (!zsh && *c == '\\')
            fputs("\\\\", stdout);
        else
            putchar(*c);
    }
}

static void zsh_option(const struct command *command, const struct pel_option *row, const struct option_extra *extra)
{
    (void)command;
    const char *star = extra && extra->repeat ? "*" : "";
    for (int form = 0; form < 2; form++) {
        if (form == 1 && !(extra && extra->letter))
            break;
        printf("            '%s", star);
        if (form == 1)
            printf("-%c[", extra->letter);
        else
            printf("--%s%s[", row->name, row->type == PEL_OPTION_BOOL ? "" : extra && extra->bare ? "=-" : "=");
        quoted(row->help, true);
        printf("]");
        if (row->type != PEL_OPTION_BOOL) {
            printf("%s:%s:", extra && extra->bare ? ":" : "", row->name);
            if (has_values(row)) {
                printf("(");
                print_values(row);
                printf(")");
            } else if (row->type == PEL_OPTION_TEXT) {
                printf("_files");
            }
        }
        printf("' \\\n");
    }
    if (row->type == PEL_OPTION_BOOL && (!row->fallback || strcmp(row->fallback, "true") == 0))
        printf("            '--no-%s[Not\\: %s]' \\\n", row->name, row->name);
}

static void print_zsh(void)
{
    printf("#compdef pellucid\n# zsh completion of pellucid; made by `pellucid completion zsh`\n_pellucid()\n{\n    local -a commands\n    "
           "commands=(\n");
    for (size_t i = 0; command_at(i); i++) {
        printf("        '%s:", command_at(i)->name);
        quoted(command_at(i)->summary, true);
        printf("'\n");
    }
    printf("    )\n    if ((CURRENT == 2)); then\n        _describe command commands\n        return\n    fi\n    local command=$words[2]\n"
           "    shift words\n    ((CURRENT--))\n    case $command in\n");
    for (size_t i = 0; command_at(i); i++) {
        printf("    %s)\n        _arguments \\\n", command_at(i)->name);
        each_option(command_at(i), zsh_option);
        printf("            '--help[Show the help]' \\\n            '*:argument:");
        if (takes_files(command_at(i))) {
            printf("_files");
        } else {
            printf("(");
            print_operands(command_at(i));
            printf(")");
        }
        printf("'\n        ;;\n");
    }
    printf("    esac\n}\n_pellucid \"$@\"\n");
}

static void fish_option(const struct command *command, const struct pel_option *row, const struct option_extra *extra)
{
    printf("complete -c pellucid -n '__fish_seen_subcommand_from %s' -l %s", command->name, row->name);
    if (extra && extra->letter)
        printf(" -s %c", extra->letter);
    if (has_values(row)) {
        printf(" -x -a '");
        print_values(row);
        printf("'");
    } else if (row->type != PEL_OPTION_BOOL) {
        printf(row->type == PEL_OPTION_TEXT ? " -r -F" : " -x");
    }
    printf(" -d '");
    quoted(row->help, false);
    printf("'\n");
    if (row->type == PEL_OPTION_BOOL && (!row->fallback || strcmp(row->fallback, "true") == 0))
        printf("complete -c pellucid -n '__fish_seen_subcommand_from %s' -l no-%s\n", command->name, row->name);
}

static void print_fish(void)
{
    printf("# fish completion of pellucid; made by `pellucid completion fish`\n");
    for (size_t i = 0; command_at(i); i++) {
        const struct command *command = command_at(i);
        printf("complete -c pellucid -n __fish_use_subcommand -f -a %s -d '", command->name);
        quoted(command->summary, false);
        printf("'\n");
        if (!takes_files(command)) {
            printf("complete -c pellucid -n '__fish_seen_subcommand_from %s' -f -a '", command->name);
            print_operands(command);
            printf("'\n");
        }
        each_option(command, fish_option);
    }
}

static int run(const struct command *command, int argc, char **argv)
{
    struct arguments arguments = { .command = command };
    int status = arguments_parse_operands(&arguments, argc, argv, 1, 1);
    if (status >= 0)
        return status;
    const char *shell = arguments.operands[0];
    if (strcmp(shell, "bash") == 0)
        print_bash();
    else if (strcmp(shell, "zsh") == 0)
        print_zsh();
    else if (strcmp(shell, "fish") == 0)
        print_fish();
    else {
        struct pel_error error = PEL_ERROR_INIT;
        tool_fail(&error, PEL_ERROR_ARGUMENT, "completion: there is none for %.60s; there is bash, zsh and fish", shell);
        return tool_report(&error);
    }
    return tool_finish_stdout(EXIT_FINE);
}

const struct command command_completion = {
    .name = "completion",
    .summary = "Print the completion script for a shell",
    .usage = "bash|zsh|fish",
    .examples = "  source <(pellucid completion bash)",
    .run = run,
};
