/* SPDX-License-Identifier: MIT */
/* pellucid: the command-line tool. Finds the command and gives it its arguments. */
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "arguments.h"
#include "commands.h"
#include "progress.h"

static const struct command *const commands[] = {
    &command_info,       &command_render,  &command_convert, &command_compare, &command_make,       &command_mesh,    &command_bench,
#ifdef HAVE_VIEWER
    &command_view,       &command_replay,
#endif
    &command_techniques, &command_devices, &command_formats, &command_options, &command_completion, &command_man,
    NULL,
};

const struct command *command_at(size_t index)
{
    return index < sizeof commands / sizeof commands[0] ? commands[index] : NULL;
}

const struct command *command_find(const char *name)
{
    for (size_t i = 0; commands[i]; i++)
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    return NULL;
}

static const char *command_name(const void *user, size_t index)
{
    (void)user;
    const struct command *command = command_at(index);
    return command ? command->name : NULL;
}

static int refuse(const char *word)
{
    struct pel_error error = PEL_ERROR_INIT;
    const char *nearest = tool_nearest(word, command_name, NULL);
    if (nearest)
        tool_fail(&error, PEL_ERROR_ARGUMENT, "there is no command %.60s; did you mean %s?", word, nearest);
    else
        tool_fail(&error, PEL_ERROR_ARGUMENT, "there is no command %.60s; see pellucid --help", word);
    return tool_report(&error);
}

/* A program started with a closed standard stream would get that stream's number for the first file that it opens, and print into it.
 * The stream is opened the wrong way round, so that using it is an error still. */
static void hold_standard_streams(void)
{
    static const int wrong[] = { O_WRONLY, O_RDONLY, O_RDONLY };
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) == -1 && open("/dev/null", wrong[fd]) < 0)
            _exit(EXIT_FAILED);
}

int main(int argc, char **argv)
{
    hold_standard_streams();
    interruption_catch();
    signal(SIGXFSZ, SIG_IGN); /* beyond a limit of file size, writing fails, and that is told */
    if (argc < 2) {
        help_overview(stderr);
        return EXIT_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
        printf("pellucid %s\n", pel_version());
        return tool_finish_stdout(EXIT_FINE);
    }
    bool help = strcmp(word, "help") == 0;
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || (help && argc == 2)) {
        help_overview(stdout);
        return tool_finish_stdout(EXIT_FINE);
    }
    if (help)
        word = argv[2];
    const struct command *command = command_find(word);
    if (!command)
        return refuse(word);
    if (help) {
        help_command(command, stdout);
        return tool_finish_stdout(EXIT_FINE);
    }
    return command->run(command, argc - 1, argv + 1);
}
