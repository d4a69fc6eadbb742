/* SPDX-License-Identifier: MIT */
/* pellucid make: computed data sets. Their options come from the data set's own table. */
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "scene_arguments.h"

struct values {
    char output[PEL_OPTION_TEXT_SIZE];
    bool compress, list, quiet;
};

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "output", "Output", "File to write: .nrrd, .nhdr, .vti, .mha, .mhd or .raw", PEL_OPTION_TEXT, FIELD(output), 0, 0, NULL, NULL, NULL },
    { "compress", "Compress", "Compress inside the format, where it can", PEL_OPTION_BOOL, FIELD(compress), 0, 0, "false", NULL, NULL },
    { "list", "List", "List the data sets", PEL_OPTION_BOOL, FIELD(list), 0, 0, "false", NULL, NULL },
    { "quiet", "Quiet", "No progress bar", PEL_OPTION_BOOL, FIELD(quiet), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_extra extras[] = { { "output", 'o', "FILE", NULL, false }, { "quiet", 'q', NULL, NULL, false }, { NULL } };
static const struct option_group groups[] = { { "Options", rows, extras }, { NULL } };

static const char *dataset_name(const void *user, size_t index)
{
    (void)user;
    const struct pel_dataset *dataset = pel_dataset_at(index);
    return dataset ? dataset->name : NULL;
}

static int list_datasets(void)
{
    const struct pel_dataset *dataset;
    for (size_t i = 0; (dataset = pel_dataset_at(i)); i++)
        printf("%-16s %s\n", dataset->name, dataset->summary);
    return tool_finish_stdout(EXIT_FINE);
}

static bool make(const struct pel_dataset *dataset, const void *params, const struct values *values, struct pel_error *error)
{
    struct pel_write_params write = PEL_WRITE_PARAMS_INIT;
    struct pel_volume volume;
    struct progress progress;
    if (!values->output[0])
        return tool_fail(error, PEL_ERROR_ARGUMENT, "make: nowhere to put the data; give -o FILE");
    progress_init(&progress, values->quiet);
    pel_volume_init(&volume);
    interruption_at_once(true);
    bool made = pel_dataset_make(dataset, params, &volume, error);
    interruption_at_once(false);
    if (!made)
        return tool_fail_in(error, dataset->name);
    write.compress = values->compress;
    write.progress = progress_callback(&progress);
    progress_begin(&progress, "writing", 1);
    bool fine = !interruption() || tool_fail(error, PEL_ERROR_CANCELLED, "interrupted");
    fine = fine && (pel_write_volume(values->output, &volume, &write, error) || tool_fail_in(error, values->output));
    progress_end(&progress);
    pel_volume_finish(&volume);
    return fine;
}

/* `make NAME ...`: the data set's options join the command's own. */
static int run_dataset(const struct command *command, const struct pel_dataset *dataset, int argc, char **argv)
{
    char usage[128], description[1024];
    const struct option_group both[] = { { "Parameters", dataset->options, NULL }, groups[0], { NULL } };
    struct command named = *command;
    static struct values values;
    struct pel_error error = PEL_ERROR_INIT;
    snprintf(usage, sizeof usage, "%s -o FILE [options]", dataset->name);
    snprintf(description, sizeof description, dataset->citation ? "%s\n\n%s" : "%s", dataset->summary, dataset->citation);
    named.groups = both;
    named.usage = usage;
    named.description = description;
    named.examples = NULL;
    void *params = pel_dataset_create_params(dataset);
    if (!params) {
        tool_fail(&error, PEL_ERROR_MEMORY, "no memory for the parameters");
        return tool_report(&error);
    }
    struct arguments arguments = { .command = &named, .objects = { params, &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status < 0)
        status = make(dataset, params, &values, &error) ? EXIT_FINE : tool_report(&error);
    free(params);
    return status;
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_dataset *dataset = argc > 1 ? pel_dataset_find(argv[1]) : NULL;
    if (dataset)
        return run_dataset(command, dataset, argc - 1, argv + 1);
    if (argc > 1 && argv[1][0] != '-') {
        const char *nearest = tool_nearest(argv[1], dataset_name, NULL);
        tool_fail(&error, PEL_ERROR_ARGUMENT,
                  nearest ? "make: there is no data set %.60s; did you mean %s?"
                          : "make: there is no data set %.60s; see "
                            "pellucid make --list",
                  argv[1], nearest);
        return tool_report(&error);
    }
    struct arguments arguments = { .command = command, .objects = { &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status >= 0)
        return status;
    if (values.list)
        return list_datasets();
    tool_fail(&error, PEL_ERROR_ARGUMENT, "make: which data set? The name comes first; see pellucid make --list");
    return tool_report(&error);
}

const struct command command_make = {
    .name = "make",
    .summary = "Compute a data set from a formula",
    .usage = "NAME -o FILE [options]",
    .description = "`pellucid make --list` lists the data sets, `pellucid make NAME --help` the parameters of one.",
    .examples = "  pellucid make hydrogen -o orbital.nrrd --size 128\n"
                "  pellucid make --list",
    .groups = groups,
    .run = run,
};
