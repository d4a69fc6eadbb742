/* SPDX-License-Identifier: MIT */
/* pellucid techniques: the ways in which a picture can be made. */
#include "arguments.h"
#include "commands.h"

struct values {
    bool json;
};

static const struct pel_option rows[] = {
    { "json", "JSON", "Print a JSON list of objects with name, summary, citation, engines and options", PEL_OPTION_BOOL,
      offsetof(struct values, json), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_group groups[] = { { "Options", rows, NULL }, { NULL } };

static json_t *json_options(const struct pel_option *options)
{
    json_t *list = json_array();
    for (const struct pel_option *row = options; row && row->name; row++)
        json_array_append_new(
            list, json_pack("{s:s, s:s, s:s?, s:s?}", "name", row->name, "help", row->help, "default", row->fallback, "unit", row->unit));
    return list;
}

static json_t *json_technique(const struct pel_technique_info *technique)
{
    json_t *engines = json_array();
    if (technique->engines & PEL_ENGINE_CPU)
        json_array_append_new(engines, json_string("cpu"));
    if (technique->engines & PEL_ENGINE_GPU)
        json_array_append_new(engines, json_string("gpu"));
    return json_pack("{s:s, s:s, s:s?, s:o, s:o}", "name", technique->name, "summary", technique->summary, "citation", technique->citation,
                     "engines", engines, "options", json_options(technique->options));
}

static int run(const struct command *command, int argc, char **argv)
{
    struct values values;
    struct arguments arguments = { .command = command, .objects = { &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status >= 0)
        return status;
    const struct pel_technique_info *technique;
    if (values.json) {
        json_t *list = json_array();
        for (size_t i = 0; (technique = pel_technique_at(i)); i++)
            json_array_append_new(list, json_technique(technique));
        return tool_finish_stdout(json_print(list, stdout) ? EXIT_FINE : EXIT_FAILED);
    }
    for (size_t i = 0; (technique = pel_technique_at(i)); i++) {
        printf("%-12s %s\n", technique->name, technique->summary);
        if (technique->citation)
            printf("%-12s %s\n", "", technique->citation);
    }
    return tool_finish_stdout(EXIT_FINE);
}

const struct command command_techniques = {
    .name = "techniques",
    .summary = "List the rendering techniques",
    .usage = "[--json]",
    .groups = groups,
    .run = run,
};
