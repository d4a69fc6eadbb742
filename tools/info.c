/* SPDX-License-Identifier: MIT */
/* pellucid info: what a file holds, for people and for scripts. */
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "scene_arguments.h"

struct values {
    char array[PEL_OPTION_TEXT_SIZE], raw[PEL_OPTION_TEXT_SIZE];
    bool json, histogram, quiet;
    double void_value;
};

static const struct pel_option rows[] = {
    { "json", "JSON", "Print one JSON object", PEL_OPTION_BOOL, offsetof(struct values, json), 0, 0, "false", NULL, NULL },
    { "histogram", "Histogram", "Add a histogram of the values, as text", PEL_OPTION_BOOL, offsetof(struct values, histogram), 0, 0,
      "false", NULL, NULL },
    { "array", "Array", "Which array of a file that holds several", PEL_OPTION_TEXT, offsetof(struct values, array), 0, 0, NULL, NULL,
      NULL },
    { "raw", "Raw layout", "Read raw samples of this layout: 256x256x256:u8, 64x64x64:f32:be+1024 (skips 1024 bytes)", PEL_OPTION_TEXT,
      offsetof(struct values, raw), 0, 0, NULL, NULL, NULL },
    { "void", "Void value", "Samples with this value stand for no data", PEL_OPTION_DOUBLE, offsetof(struct values, void_value), -DBL_MAX,
      DBL_MAX, NULL, NULL, "data value" },
    { "quiet", "Quiet", "No notes and no progress bar", PEL_OPTION_BOOL, offsetof(struct values, quiet), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_extra extras[] = { { "array", 0, "NAME", NULL, false },
                                              { "raw", 0, "LAYOUT", NULL, false },
                                              { "void", 0, "VALUE", NULL, false },
                                              { "quiet", 'q', NULL, NULL, false },
                                              { NULL } };
static const struct option_group groups[] = { { "Options", rows, extras }, { NULL } };

static json_t *json_direction(const struct pel_volume *volume)
{
    json_t *list = json_array();
    for (int a = 0; a < 3; a++)
        json_array_append_new(list, json_numbers(volume->direction[a], 3));
    return list;
}

static json_t *json_arrays(const struct pel_file_info *info)
{
    json_t *list = json_array();
    for (int i = 0; i < info->array_count; i++)
        json_array_append_new(list, json_pack("{s:o, s:s, s:i}", "name", json_text(info->arrays[i].name), "type",
                                              pel_type_name(info->arrays[i].type), "components", info->arrays[i].components));
    return list;
}

static bool print_json(const char *path, const struct pel_volume *v, const struct pel_file_info *info, const struct pel_statistics *s)
{
    json_t *notes = json_array();
    for (int i = 0; i < info->note_count; i++)
        json_array_append_new(notes, json_text(info->notes[i]));
    json_t *json = json_object();
    json_object_set_new(json, "file", json_text(path));
    json_object_set_new(json, "format", json_text(info->format));
    json_object_set_new(json, "dims", json_pack("[I, I, I]", (json_int_t)v->dims[0], (json_int_t)v->dims[1], (json_int_t)v->dims[2]));
    json_object_set_new(json, "type", json_text(pel_type_name(v->type)));
    json_object_set_new(json, "components", json_integer(v->components));
    json_object_set_new(json, "spacing", json_numbers(v->spacing, 3));
    json_object_set_new(json, "origin", json_numbers(v->origin, 3));
    json_object_set_new(json, "direction", json_direction(v));
    json_object_set_new(json, "space", json_text(pel_space_name(v->space)));
    json_object_set_new(json, "units", json_text(v->units));
    json_object_set_new(json, "min", json_number(s->min));
    json_object_set_new(json, "max", json_number(s->max));
    json_object_set_new(json, "mean", json_number(s->mean));
    json_object_set_new(json, "nonzero", json_integer((json_int_t)s->nonzero));
    json_object_set_new(json, "voids", json_integer((json_int_t)s->voids));
    json_object_set_new(json, "infinite", json_integer((json_int_t)s->infinite));
    json_object_set_new(json, "labels", json_boolean(v->labels));
    json_object_set_new(json, "name", json_text(v->name));
    json_object_set_new(json, "arrays", json_arrays(info));
    json_object_set_new(json, "notes", notes);
    return json_print(json, stdout);
}

/* Text from a file, made fit for a terminal. */
static void print_text(const char *label, const char *text)
{
    printf("%-11s ", label);
    for (const char *c = text; *c; c++)
        putchar((unsigned char)*c < 32 || *c == 127 ? '?' : *c);
    putchar('\n');
}

static void print_placement(const struct pel_volume *v)
{
    double bounds[6];
    pel_volume_bounds(v, bounds);
    printf("spacing     %.9g x %.9g x %.9g%s%s\n", v->spacing[0], v->spacing[1], v->spacing[2], v->units[0] ? " " : "", v->units);
    printf("origin      %.9g, %.9g, %.9g\n", v->origin[0], v->origin[1], v->origin[2]);
    printf("direction   x: %.6g, %.6g, %.6g   y: %.6g, %.6g, %.6g   z: %.6g, %.6g, %.6g\n", v->direction[0][0], v->direction[0][1],
           v->direction[0][2], v->direction[1][0], v->direction[1][1], v->direction[1][2], v->direction[2][0], v->direction[2][1],
           v->direction[2][2]);
    printf("space       %s\n", pel_space_name(v->space));
    printf("bounds      %.9g to %.9g, %.9g to %.9g, %.9g to %.9g\n", bounds[0], bounds[1], bounds[2], bounds[3], bounds[4], bounds[5]);
}

static void print_text_info(const char *path, const struct pel_volume *v, const struct pel_file_info *info, const struct pel_statistics *s)
{
    print_text("file", path);
    printf("format      %s\n", info->format);
    if (v->name[0])
        print_text("name", v->name);
    printf("size        %zu x %zu x %zu %s", v->dims[0], v->dims[1], v->dims[2], pel_type_name(v->type));
    if (v->components > 1)
        printf(", %d components", v->components);
    printf(", %.1f MB\n", (double)pel_volume_bytes(v) / 1e6);
    print_placement(v);
    printf("values      %.9g to %.9g, mean %.9g%s\n", s->min, s->max, s->mean, v->components > 1 ? " (magnitude)" : "");
    printf("non-zero    %" PRIu64 " of %" PRIu64 " (%.1f %%)\n", s->nonzero, s->samples,
           s->samples ? 100.0 * (double)s->nonzero / (double)s->samples : 0);
    if (s->voids)
        printf("void        %" PRIu64 "\n", s->voids);
    if (s->infinite)
        printf("infinite    %" PRIu64 "\n", s->infinite);
    if (v->labels)
        printf("labels      yes: values are not interpolated\n");
    for (int i = 0; info->array_count > 1 && i < info->array_count; i++) {
        char text[192];
        snprintf(text, sizeof text, "%s: %s, %d component%s", info->arrays[i].name, pel_type_name(info->arrays[i].type),
                 info->arrays[i].components, info->arrays[i].components == 1 ? "" : "s");
        print_text("array", text);
    }
}

/* Bars on a logarithmic scale, since the air of a scan would leave nothing to see of all else. */
static bool print_histogram(const struct pel_volume *volume, const struct pel_statistics *s, struct pel_error *error)
{
    enum { BINS = 24, BAR = 60 };
    struct pel_histogram histogram;
    if (!(s->min < s->max))
        return true;
    if (!pel_histogram_init(&histogram, volume, s->min, s->max, BINS, false, error))
        return false;
    uint64_t most = 1;
    for (size_t i = 0; i < BINS; i++)
        most = histogram.bins[i] > most ? histogram.bins[i] : most;
    printf("histogram   (bars: logarithm of the count)\n");
    for (size_t i = 0; i < BINS; i++) {
        int length = (int)(BAR * log1p((double)histogram.bins[i]) / log1p((double)most));
        printf("%12.6g %-*.*s %" PRIu64 "\n", s->min + (s->max - s->min) * (double)i / BINS, BAR, length,
               "############################################################", histogram.bins[i]);
    }
    pel_histogram_finish(&histogram);
    return true;
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    struct arguments arguments = { .command = command, .objects = { &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 1, 1);
    if (status >= 0)
        return status;
    struct pel_volume volume;
    struct pel_file_info info;
    struct pel_error error = PEL_ERROR_INIT;
    struct progress progress;
    const char *path = arguments.operands[0];
    progress_init(&progress, values.quiet);
    /* The JSON object and the text both hold the notes. */
    if (!volume_load(path, values.array, values.raw, false, &progress, values.quiet || values.json, &volume, &info, &error))
        return tool_report(&error);
    if (arguments_given(&arguments, "void")) {
        volume.has_void = true;
        volume.void_value = values.void_value;
    }
    struct pel_statistics statistics;
    pel_statistics_compute(&volume, &statistics);
    bool fine = true;
    if (values.json)
        fine = print_json(path, &volume, &info, &statistics) || tool_fail(&error, PEL_ERROR_MEMORY, "no memory for the JSON text");
    else
        print_text_info(path, &volume, &info, &statistics);
    if (fine && values.histogram && !values.json)
        fine = print_histogram(&volume, &statistics, &error);
    pel_volume_finish(&volume);
    return tool_finish_stdout(fine ? EXIT_FINE : tool_report(&error));
}

const struct command command_info = {
    .name = "info",
    .summary = "Tell what a file holds",
    .usage = "FILE [options]",
    .description =
        "Prints the size, type, placement and values of a volume or field: a file, or a folder with a DICOM series or TIFF slices. The "
        "values of a vector field are told by their magnitude.\n\n"
        "--json prints one object with the keys file, format, dims, type, components, spacing, origin, direction (one unit vector for "
        "each index axis), space, units, min, max, mean, nonzero, voids, infinite, labels, name, arrays and notes. min, max and mean are "
        "of finite values, and null where there are none.",
    .examples = "  pellucid info scan.nii.gz\n"
                "  pellucid info --json scan.nii.gz | python3 -m json.tool\n"
                "  pellucid info volume.raw --raw 256x256x256:u8 --histogram",
    .groups = groups,
    .run = run,
};
