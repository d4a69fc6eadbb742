/* SPDX-License-Identifier: MIT */
/* pellucid convert: a volume from one format into another, with another number type, spacing or orientation if asked for. */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "commands.h"
#include "scene_arguments.h"

struct values {
    char array[PEL_OPTION_TEXT_SIZE], raw[PEL_OPTION_TEXT_SIZE];
    double spacing[3], range[2];
    int type, space; /* index into the names; 0: as it is */
    bool magnitude, compress, quiet;
};

static const char *const type_names[] = { "keep", "u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64", NULL };
static const char *const space_names[] = { "keep", "RAS", "LPS", NULL };

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "type", "Type", "Number type to convert to", PEL_OPTION_CHOICE, FIELD(type), 0, 0, "keep", type_names, NULL },
    { "range", "Range", "Values to stretch over all that the new type holds (0 to 1 for f32 and f64); needs --type", PEL_OPTION_VEC2,
      FIELD(range), -DBL_MAX, DBL_MAX, NULL, NULL, "data values" },
    { "space", "Space", "What the world axes shall mean: the placement is turned, the samples stay", PEL_OPTION_CHOICE, FIELD(space), 0, 0,
      "keep", space_names, NULL },
    { "spacing", "Spacing", "Distance between samples along each axis, in place of the file's", PEL_OPTION_VEC3, FIELD(spacing),
      PEL_LEAST_SPACING, PEL_MOST_SPACING, NULL, NULL, "world" },
    { "magnitude", "Magnitude", "Write the length of each vector", PEL_OPTION_BOOL, FIELD(magnitude), 0, 0, "false", NULL, NULL },
    { "array", "Array", "Which array of a file that holds several", PEL_OPTION_TEXT, FIELD(array), 0, 0, NULL, NULL, NULL },
    { "raw", "Raw layout", "Read raw samples of this layout: 256x256x256:u8, 64x64x64:f32:be+1024 (skips 1024 bytes)", PEL_OPTION_TEXT,
      FIELD(raw), 0, 0, NULL, NULL, NULL },
    { "compress", "Compress", "Compress inside the format, where it can", PEL_OPTION_BOOL, FIELD(compress), 0, 0, "false", NULL, NULL },
    { "quiet", "Quiet", "No notes and no progress bar", PEL_OPTION_BOOL, FIELD(quiet), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_extra extras[] = { { "array", 0, "NAME", NULL, false },
                                              { "raw", 0, "LAYOUT", NULL, false },
                                              { "range", 0, "LO,HI", NULL, false },
                                              { "quiet", 'q', NULL, NULL, false },
                                              { NULL } };
static const struct option_group groups[] = { { "Options", rows, extras }, { NULL } };

static double number_at(const void *data, enum pel_type type, size_t i)
{
    switch (type) {
    case PEL_U8:
        return ((const uint8_t *)data)[i];
    case PEL_I8:
        return ((const int8_t *)data)[i];
    case PEL_U16:
        return ((const uint16_t *)data)[i];
    case PEL_I16:
        return ((const int16_t *)data)[i];
    case PEL_U32:
        return ((const uint32_t *)data)[i];
    case PEL_I32:
        return ((const int32_t *)data)[i];
    case PEL_F32:
        return (double)((const float *)data)[i];
    default:
        return ((const double *)data)[i];
    }
}

/* The value must lie within the type's limits. */
static void number_put(void *data, enum pel_type type, size_t i, double value)
{
    switch (type) {
    case PEL_U8:
        ((uint8_t *)data)[i] = (uint8_t)value;
        break;
    case PEL_I8:
        ((int8_t *)data)[i] = (int8_t)value;
        break;
    case PEL_U16:
        ((uint16_t *)data)[i] = (uint16_t)value;
        break;
    case PEL_I16:
        ((int16_t *)data)[i] = (int16_t)value;
        break;
    case PEL_U32:
        ((uint32_t *)data)[i] = (uint32_t)value;
        break;
    case PEL_I32:
        ((int32_t *)data)[i] = (int32_t)value;
        break;
    case PEL_F32:
        ((float *)data)[i] = (float)value;
        break;
    default:
        ((double *)data)[i] = value;
    }
}

static void type_limits(enum pel_type type, double limits[2])
{
    static const double table[PEL_TYPE_COUNT][2] = {
        [PEL_U8] = { 0, UINT8_MAX },          [PEL_I8] = { INT8_MIN, INT8_MAX }, [PEL_U16] = { 0, UINT16_MAX },
        [PEL_I16] = { INT16_MIN, INT16_MAX }, [PEL_U32] = { 0, UINT32_MAX },     [PEL_I32] = { INT32_MIN, INT32_MAX },
        [PEL_F32] = { -FLT_MAX, FLT_MAX },    [PEL_F64] = { -DBL_MAX, DBL_MAX },
    };
    limits[0] = table[type][0];
    limits[1] = table[type][1];
}

/* What could not be kept. */
struct losses {
    size_t clamped, rounded, nans;
};

static double fit(double value, double limits[2], bool whole, struct losses *losses)
{
    if (whole && isnan(value)) {
        losses->nans++;
        value = 0;
    }
    if (whole && value != rint(value)) {
        losses->rounded++;
        value = rint(value);
    }
    if ((value < limits[0] || value > limits[1]) && (whole || isfinite(value))) {
        losses->clamped++;
        value = value < limits[0] ? limits[0] : limits[1];
    }
    return value;
}

static void tell_losses(const char *path, const char *type, const struct losses *losses)
{
    if (losses->clamped)
        tool_note("%s: %zu values lie beyond what %s holds and were clamped; --range stretches them", path, losses->clamped, type);
    if (losses->rounded)
        tool_note("%s: %zu values were rounded to whole numbers; --range stretches them", path, losses->rounded);
    if (losses->nans)
        tool_note("%s: %zu NaN samples became 0", path, losses->nans);
}

/* Replaces the samples by those of another type; `range` (nullable) is stretched over all that the type holds. */
static bool convert_type(struct pel_volume *volume, enum pel_type type, const double *range, struct losses *losses, struct pel_error *error)
{
    double limits[2], scale = 1, offset = 0;
    bool whole = type != PEL_F32 && type != PEL_F64;
    type_limits(type, limits);
    if (range) {
        double lo = whole ? limits[0] : 0, hi = whole ? limits[1] : 1;
        scale = (hi - lo) / (range[1] - range[0]);
        offset = lo - range[0] * scale;
    }
    struct pel_volume to = *volume;
    to.data = NULL;
    if (!pel_volume_allocate(&to, volume->dims, type, volume->components, error))
        return false;
    size_t count = pel_volume_samples(volume) * (size_t)volume->components, mistaken = 0;
    struct losses stretched = { 0 }, none = { 0 };
    to.void_value = fit(volume->void_value, limits, whole, &none);
    bool keeps = !volume->has_void || isnan(volume->void_value) || !(none.clamped + none.rounded);
    for (size_t i = 0; keeps && i < count; i++) {
        double value = number_at(volume->data, volume->type, i);
        if (value == value && pel_volume_is_void(volume, value)) {
            value = to.void_value;
        } else { /* rounding and clamping are what a stretch is for */
            value = fit(value * scale + offset, limits, whole, range ? &stretched : losses);
            mistaken += volume->has_void && pel_volume_is_void(&to, type == PEL_F32 ? (double)(float)value : value) && value == value;
        }
        number_put(to.data, type, i, value);
    }
    if (!keeps || mistaken) {
        pel_volume_finish(&to);
        return keeps ? tool_fail(error, PEL_ERROR_UNSUPPORTED,
                                 "%zu samples would become %g, which stands for no data; choose another --type or --range", mistaken,
                                 volume->void_value)
                     : tool_fail(error, PEL_ERROR_UNSUPPORTED, "%s cannot hold %g, which stands for no data; choose another --type",
                                 pel_type_name(type), volume->void_value);
    }
    losses->nans += stretched.nans;
    pel_volume_finish(volume);
    *volume = to;
    pel_volume_update_range(volume);
    return true;
}

static bool to_magnitude(struct pel_volume *volume, struct pel_error *error)
{
    struct pel_volume magnitude;
    pel_volume_init(&magnitude);
    if (!pel_volume_magnitude(volume, &magnitude, error))
        return false;
    pel_volume_finish(volume);
    *volume = magnitude;
    return true;
}

static bool change(struct pel_volume *volume, const struct arguments *arguments, const struct values *values, struct pel_error *error)
{
    const char *path = arguments->operands[0];
    struct losses losses = { 0 };
    if (values->magnitude && volume->components > 1 && !to_magnitude(volume, error))
        return tool_fail_in(error, path);
    if (arguments_given(arguments, "spacing"))
        memcpy(volume->spacing, values->spacing, sizeof volume->spacing);
    if (values->space) {
        if (volume->space == PEL_SPACE_UNKNOWN && !values->quiet)
            tool_note("%s: the file does not say what its axes mean; taken as %s", path, space_names[values->space]);
        pel_volume_to_space(volume, values->space == 1 ? PEL_SPACE_RAS : PEL_SPACE_LPS);
    }
    if (values->type) {
        enum pel_type type = pel_type_from_name(type_names[values->type]);
        if (!convert_type(volume, type, arguments_given(arguments, "range") ? values->range : NULL, &losses, error))
            return tool_fail_in(error, path);
        if (!values->quiet)
            tell_losses(path, type_names[values->type], &losses);
    }
    return true;
}

/* The samples go into OUT, or beside a detached header under one of these endings. */
static bool check_output(const char *in, const char *out, struct pel_error *error)
{
    static const char *const endings[] = { ".raw", ".raw.gz", ".zraw" };
    const char *dot = strrchr(out, '.');
    char data[4096];
    if (tool_reads_from(in, out))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%.300s: the input is read from this file; choose another name for the output", out);
    bool detached = dot && (strcasecmp(dot, ".mhd") == 0 || strcasecmp(dot, ".nhdr") == 0);
    for (size_t i = 0; detached && i < sizeof endings / sizeof endings[0]; i++) {
        int length = snprintf(data, sizeof data, "%.*s%s", (int)(dot - out), out, endings[i]);
        if (length < (int)sizeof data && tool_reads_from(in, data))
            return tool_fail(error, PEL_ERROR_ARGUMENT,
                             "%.300s: its data would replace %.300s, which the input is read from; choose another name or an "
                             "attached format (.mha, .nrrd)",
                             out, data);
    }
    return true;
}

static bool convert(const struct arguments *arguments, const struct values *values, struct pel_error *error)
{
    struct pel_write_params write = PEL_WRITE_PARAMS_INIT;
    struct pel_volume volume;
    struct pel_file_info info;
    struct progress progress;
    if (arguments_given(arguments, "range") && (!values->type || values->range[0] == values->range[1]))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--range: needs two different values, and --type to stretch them over");
    if (!check_output(arguments->operands[0], arguments->operands[1], error))
        return false;
    progress_init(&progress, values->quiet);
    if (!volume_load(arguments->operands[0], values->array, values->raw, false, &progress, values->quiet, &volume, &info, error))
        return false;
    bool fine = change(&volume, arguments, values, error);
    write.compress = values->compress;
    write.progress = progress_callback(&progress);
    progress_begin(&progress, "writing", 1);
    const char *dot = strrchr(arguments->operands[1], '.');
    if (fine && values->space == 1 && !values->quiet && dot && (strcasecmp(dot, ".mha") == 0 || strcasecmp(dot, ".mhd") == 0))
        tool_note("%s: MetaImage is always LPS; the axes were turned back", arguments->operands[1]);
    fine = fine && (!interruption() || tool_fail(error, PEL_ERROR_CANCELLED, "interrupted"));
    fine = fine && (pel_write_volume(arguments->operands[1], &volume, &write, error) || tool_fail_in(error, arguments->operands[1]));
    progress_end(&progress);
    pel_volume_finish(&volume);
    return fine;
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    struct arguments arguments = { .command = command, .objects = { &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 2, 2);
    if (status >= 0)
        return status;
    struct pel_error error = PEL_ERROR_INIT;
    return convert(&arguments, &values, &error) ? EXIT_FINE : tool_report(&error);
}

const struct command command_convert = {
    .name = "convert",
    .summary = "Write a volume in another format or number type",
    .usage = "IN OUT [options]",
    .description = "The format of OUT is told by its ending: .nrrd, .nhdr, .vti, .mha, .mhd or .raw. Placement, units and name are kept "
                   "where the format can hold them; so is the number type where --type does not say otherwise.",
    .examples = "  pellucid convert scan.nii.gz scan.nrrd --compress\n"
                "  pellucid convert dicom-folder/ scan.nrrd --space RAS\n"
                "  pellucid convert speed.vti speed.nrrd --type u8 --range 0,80\n"
                "  pellucid convert volume.dat volume.vti --raw 256x256x128:u16:be --spacing 1,1,2",
    .groups = groups,
    .run = run,
};
