/* SPDX-License-Identifier: MIT */
/* pellucid devices: the GPUs that OpenGL reaches without a display, and why one is or is not taken. */
#include <string.h>

#include "arguments.h"
#include "commands.h"

enum { MOST_DEVICES = 64 };

struct values {
    bool json;
};

static const struct pel_option rows[] = {
    { "json", "JSON", "Print a JSON object with the list devices and, where it is empty, the reason", PEL_OPTION_BOOL,
      offsetof(struct values, json), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_group groups[] = { { "Options", rows, NULL }, { NULL } };

static json_t *json_device(int index, const struct pel_device_info *d)
{
    json_t *limits = json_pack("{s:i, s:i, s:i, s:I, s:i}", "texture_2d", d->max_texture_2d, "texture_3d", d->max_texture_3d,
                               "array_layers", d->max_array_layers, "storage_buffer_bytes", (json_int_t)d->max_storage_buffer_bytes,
                               "compute_invocations", d->max_compute_invocations);
    return json_pack("{s:i, s:o, s:o, s:o, s:s, s:o, s:b, s:b, s:b, s:o, s:I, s:o}", "index", index, "name", json_text(d->name), "vendor",
                     json_text(d->vendor), "version", json_text(d->version), "path", d->path, "node", json_text(d->node), "software",
                     d->software, "usable", d->usable, "chosen", d->chosen, "note", json_text(d->note), "memory_bytes",
                     (json_int_t)d->memory_bytes, "limits", limits);
}

/* "2 GiB", "79.6 GiB", "128 MiB". */
static const char *bytes_text(uint64_t bytes, char *text, size_t size)
{
    double mib = (double)bytes / (1 << 20);
    snprintf(text, size, "%.4g %s", mib < 1024 ? mib : mib / 1024, mib < 1024 ? "MiB" : "GiB");
    return text;
}

static void print_device(int index, const struct pel_device_info *d)
{
    char text[32];
    printf("%d  %s\n", index, d->name[0] ? d->name : "(unknown)");
    printf("   %s%s%s", d->path, d->node[0] ? " " : "", d->node);
    if (d->version[0])
        printf("; %s, %s%s", d->vendor, strncmp(d->version, "OpenGL", 6) == 0 ? "" : "OpenGL ", d->version);
    printf("\n");
    if (d->usable) {
        if (d->software)
            printf("   memory: the machine's\n");
        else
            printf("   memory: %s\n", d->memory_bytes ? bytes_text(d->memory_bytes, text, sizeof text) : "not told by the driver");
        printf("   limits: textures %d (2D), %d (3D), %d layers; storage buffers of %s; work groups of %d\n", d->max_texture_2d,
               d->max_texture_3d, d->max_array_layers, bytes_text(d->max_storage_buffer_bytes, text, sizeof text),
               d->max_compute_invocations);
    }
    printf("   %s\n", d->note);
}

static int run(const struct command *command, int argc, char **argv)
{
    struct values values;
    struct arguments arguments = { .command = command, .objects = { &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status >= 0)
        return status;
    struct pel_device_info devices[MOST_DEVICES];
    struct pel_error error = PEL_ERROR_INIT;
    int count = pel_device_list(devices, MOST_DEVICES, &error);
    if (count == 0 && error.code == PEL_ERROR_MEMORY)
        return tool_report(&error);
    if (count > MOST_DEVICES)
        count = MOST_DEVICES;
    if (values.json) {
        json_t *list = json_array(), *whole = json_pack("{s:o}", "devices", list);
        for (int i = 0; i < count; i++)
            json_array_append_new(list, json_device(i, &devices[i]));
        if (count == 0)
            json_object_set_new(whole, "reason", json_text(error.message));
        return tool_finish_stdout(json_print(whole, stdout) ? EXIT_FINE : EXIT_FAILED);
    }
    for (int i = 0; i < count; i++)
        print_device(i, &devices[i]);
    if (count == 0)
        printf("%s\n", error.message);
    return tool_finish_stdout(EXIT_FINE);
}

const struct command command_devices = {
    .name = "devices",
    .summary = "List the GPUs, what they can do, and which is chosen",
    .usage = "[--json]",
    .description = "Devices are found through EGL; no display is needed. Their numbers are EGL's order. Where there is none, it says why "
                   "and succeeds: the CPU engine needs none.",
    .groups = groups,
    .run = run,
};
