/* SPDX-License-Identifier: MIT */
/* The option tables of the shared options, and the lists that repeated flags make. */
#include "scene_arguments.h"

#include <float.h>
#include <string.h>

#define FIELD(name) offsetof(struct scene_arguments, name)
#define ANY -DBL_MAX, DBL_MAX
#define NO_LIMITS 0, 0

const struct pel_option input_rows[] = {
    { "scene", "Scene file", "Load a scene file first; flags override what it says", PEL_OPTION_TEXT, FIELD(scene), NO_LIMITS, NULL, NULL,
      NULL },
    { "array", "Array", "Which array of a file that holds several", PEL_OPTION_TEXT, FIELD(array), NO_LIMITS, NULL, NULL, NULL },
    { "raw", "Raw layout", "Read raw samples of this layout: 256x256x256:u8, 64x64x64:f32:be+1024 (skips 1024 bytes)", PEL_OPTION_TEXT,
      FIELD(raw), NO_LIMITS, NULL, NULL, NULL },
    { "spacing", "Spacing", "Distance between samples along each axis, in place of the file's", PEL_OPTION_VEC3, FIELD(spacing),
      PEL_LEAST_SPACING, PEL_MOST_SPACING, NULL, NULL, "world" },
    { "void", "Void value", "Samples with this value stand for no data", PEL_OPTION_DOUBLE, FIELD(void_value), ANY, NULL, NULL,
      "data value" },
    { "labels", "Labels", "The values name things: do not interpolate between them (by default found out from the data)", PEL_OPTION_BOOL,
      FIELD(labels), NO_LIMITS, NULL, NULL, NULL },
    { NULL },
};
const struct option_extra input_extras[] = { { "scene", 0, "FILE.json", NULL, false }, { "array", 0, "NAME", NULL, false },
                                             { "raw", 0, "LAYOUT", NULL, false },      { "void", 0, "VALUE", NULL, false },
                                             { NULL } };

const struct pel_option transfer_rows[] = {
    { "colormap", "Colour map",
      "Name of a colour map (`pellucid formats` lists them), or a ParaView file: FILE.json, FILE.xml, FILE.json#PRESET", PEL_OPTION_TEXT,
      FIELD(colormap), NO_LIMITS, NULL, NULL, NULL },
    { "range", "Range",
      "Data values over which the colour map and the automatic opacity stretch; by default a named colour map covers all values",
      PEL_OPTION_VEC2, FIELD(range), ANY, NULL, NULL, "data values" },
    { "opacity", "Opacity", "Opacity curve, value:opacity pairs as in 40:0,80:0.2,255:0.9, or one number for all", PEL_OPTION_TEXT,
      FIELD(opacity), NO_LIMITS, NULL, NULL, NULL },
    { "unit-distance", "Unit distance", "Length of material that has the opacity of the curve; by default the mean spacing",
      PEL_OPTION_DOUBLE, FIELD(unit_distance), 1e-30, 1e30, NULL, NULL, "world" },
    { NULL },
};
const struct option_extra transfer_extras[] = { { "colormap", 0, "NAME|FILE", NULL, false }, { "range", 0, "LO,HI", NULL, false },
                                                { "opacity", 0, "CURVE", NULL, false }, { NULL } };

const struct pel_option surface_rows[] = {
    { "isovalue", "Isovalue", "Value of an isosurface, or several with commas; implies --mode isosurface", PEL_OPTION_TEXT, FIELD(isovalue),
      NO_LIMITS, NULL, NULL, "data value" },
    { "iso-color", "Isosurface colour",
      "Colour of the isosurfaces in the order of their values, or one for all; by default bone for one surface, the transfer function's "
      "for several",
      PEL_OPTION_TEXT, FIELD(iso_color), NO_LIMITS, NULL, NULL, NULL },
    { "iso-opacity", "Isosurface opacity",
      "Opacity of the isosurfaces in the order of their values, with commas, or one for all; by default 1", PEL_OPTION_TEXT,
      FIELD(iso_opacity), NO_LIMITS, NULL, NULL, "0 to 1" },
    { "slice", "Slice",
      "Cut along the plane through X,Y,Z with normal NX,NY,NZ; implies --mode slice. Up to 8 in one picture, the nearer in front",
      PEL_OPTION_VEC6, FIELD(slice), ANY, NULL, NULL, "world" },
    { "clip-plane", "Clip plane", "Keep what lies on the side of the plane through X,Y,Z to which the normal NX,NY,NZ points; up to 6",
      PEL_OPTION_VEC6, FIELD(clip_plane), ANY, NULL, NULL, "world" },
    { "clip-box", "Clip box", "Keep what lies inside this box", PEL_OPTION_VEC6, FIELD(clip_box), ANY, NULL, NULL, "world" },
    { NULL },
};
const struct option_extra surface_extras[] = {
    { "isovalue", 0, "V[,V...]", NULL, true },
    { "iso-color", 0, "COLOR", NULL, true },
    { "iso-opacity", 0, "A[,A...]", NULL, true },
    { "slice", 0, "X,Y,Z,NX,NY,NZ", NULL, true },
    { "clip-plane", 0, "X,Y,Z,NX,NY,NZ", NULL, true },
    { "clip-box", 0, "X0,X1,Y0,Y1,Z0,Z1", NULL, false },
    { NULL },
};

const struct pel_option light_rows[] = {
    { "light", "Light", "Direction towards a light, in place of the headlight; up to 4", PEL_OPTION_VEC3, FIELD(light), ANY, NULL,
      NULL, "world" },
    { "light-color", "Light colour", "Colour of the lights in their order, or one for all, the headlight, too; by default white",
      PEL_OPTION_COLOR, FIELD(light_color), 0, 1, NULL, NULL, NULL },
    { "background", "Background", "Colour behind the volume; by default black, white for --mode xray", PEL_OPTION_COLOR, FIELD(background),
      0, 1, NULL, NULL, NULL },
    { "linear-light", "Linear light", "Composite in linear light instead of display values", PEL_OPTION_BOOL, FIELD(linear_light),
      NO_LIMITS, "false", NULL, NULL },
    { NULL },
};
const struct option_extra light_extras[] = { { "light", 0, NULL, NULL, true }, { "light-color", 0, NULL, NULL, true }, { NULL } };

const struct pel_option move_rows[] = {
    { "azimuth", "Azimuth", "Turn the camera about the view-up", PEL_OPTION_DOUBLE, FIELD(azimuth), -1e6, 1e6, "0", NULL, "degrees" },
    { "elevation", "Elevation", "Raise the camera over the object", PEL_OPTION_DOUBLE, FIELD(elevation), -1e6, 1e6, "0", NULL, "degrees" },
    { "roll", "Roll", "Turn the camera about the view direction", PEL_OPTION_DOUBLE, FIELD(roll), -1e6, 1e6, "0", NULL, "degrees" },
    { "zoom", "Zoom", "Enlarge the object", PEL_OPTION_DOUBLE, FIELD(zoom), 1e-3, 1e3, "1", NULL, NULL },
    { NULL },
};
const struct option_extra move_extras[] = { { "azimuth", 0, "DEGREES", NULL, false }, { "elevation", 0, "DEGREES", NULL, false },
                                            { "roll", 0, "DEGREES", NULL, false }, { "zoom", 0, "FACTOR", NULL, false }, { NULL } };

const struct pel_option engine_rows[] = {
    { "size", "Size", "Width and height of the picture", PEL_OPTION_SIZE, FIELD(size), 1, PEL_IMAGE_MAX, "512x512", NULL, "pixels" },
    { "technique", "Technique",
      "How the picture is made; `pellucid techniques` lists them; auto measures raycast against peel where both can draw", PEL_OPTION_TEXT,
      FIELD(technique), NO_LIMITS, "raycast", NULL, NULL },
    { "device", "Device", "What draws: auto (a hardware GPU if there is one, else the CPU), cpu, gpu, gpu:N; `pellucid devices` lists them",
      PEL_OPTION_TEXT, FIELD(device), NO_LIMITS, "auto", NULL, NULL },
    { "gpu-memory", "GPU memory",
      "Of the GPU, for the volume and what is made of it; a larger one is drawn in bricks that come and go. 0 is what is free",
      PEL_OPTION_DOUBLE, FIELD(gpu_memory), 0, 1e9, "0", NULL, "MB" },
    { "threads", "Threads", "Threads of the CPU engine; 0 is as many as the machine has", PEL_OPTION_INT, FIELD(threads), 0, 1024, "0",
      NULL, NULL },
    { "quiet", "Quiet", "No notes and no progress bar", PEL_OPTION_BOOL, FIELD(quiet), NO_LIMITS, "false", NULL, NULL },
    { NULL },
};
const struct option_extra engine_extras[] = {
    { "quiet", 'q', NULL, NULL, false }, { "technique", 0, "NAME", NULL, false }, { "device", 0, "DEVICE", NULL, false },
    { "gpu-memory", 0, "MB", NULL, false }, { NULL }
};

/* Appends numbers separated by commas. */
bool append_numbers(double *items, int *count, double lo, double hi, const char *flag, const char *text, struct pel_error *error)
{
    struct {
        double value;
    } one;
    const struct pel_option row = { flag, "", "", PEL_OPTION_DOUBLE, 0, lo, hi, NULL, NULL, NULL };
    char part[64];
    for (const char *start = text;; start++) {
        size_t length = strcspn(start, ",");
        if (length >= sizeof part)
            return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: no number: %.40s...", flag, start);
        memcpy(part, start, length);
        part[length] = 0;
        if (!pel_option_set(&row, &one, part, error))
            return false;
        if (*count == PEL_MAX_ISOSURFACES)
            return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: at most %d values", flag, PEL_MAX_ISOSURFACES);
        items[(*count)++] = one.value;
        start += length;
        if (!*start)
            return true;
    }
}

bool append_isovalues(double *items, int *count, const char *text, struct pel_error *error)
{
    if (!append_numbers(items, count, ANY, "--isovalue", text, error))
        return false;
    for (int i = 0; i < *count; i++)
        for (int k = 0; k < i; k++)
            if (items[k] == items[i])
                return tool_fail(error, PEL_ERROR_ARGUMENT,
                                 "--isovalue: %.9g is given twice, and its surface would be there twice; give it once", items[i]);
    return true;
}

static bool append_color(struct scene_arguments *values, struct pel_error *error)
{
    const struct pel_option row = { "--iso-color", "", "", PEL_OPTION_COLOR, 0, 0, 1, NULL, NULL, NULL };
    if (values->iso_color_count == PEL_MAX_ISOSURFACES)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--iso-color: at most %d colours", PEL_MAX_ISOSURFACES);
    return pel_option_set(&row, values->iso_colors[values->iso_color_count++], values->iso_color, error);
}

static bool append_light_color(struct scene_arguments *values, struct pel_error *error)
{
    if (values->light_color_count == PEL_MAX_LIGHTS)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--light-color: at most %d colours", PEL_MAX_LIGHTS);
    memcpy(values->light_colors[values->light_color_count++], values->light_color, sizeof values->light_color);
    return true;
}

static bool append_vector(double *list, int size, int *count, int most, const double *vector, const double *direction, const char *flag,
                          struct pel_error *error)
{
    if (*count == most)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--%s: at most %d of them", flag, most);
    if (direction[0] == 0 && direction[1] == 0 && direction[2] == 0)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--%s: the direction 0,0,0 points nowhere", flag);
    memcpy(list + size * (*count)++, vector, (size_t)size * sizeof *vector);
    return true;
}

/* What a flag that may be repeated, or one with a condition of its own, means once its text was read. */
static bool assigned(void *user, const struct pel_option *row, struct pel_error *error)
{
    struct scene_arguments *v = user;
    if (strcmp(row->name, "isovalue") == 0)
        return append_isovalues(v->isovalues.items, &v->isovalues.count, v->isovalue, error);
    if (strcmp(row->name, "iso-opacity") == 0)
        return append_numbers(v->iso_opacities.items, &v->iso_opacities.count, 0, 1, "--iso-opacity", v->iso_opacity, error);
    if (strcmp(row->name, "iso-color") == 0)
        return append_color(v, error);
    if (strcmp(row->name, "clip-plane") == 0)
        return append_vector(v->clip_planes[0], 6, &v->clip_plane_count, PEL_MAX_CLIP_PLANES, v->clip_plane, v->clip_plane + 3,
                             "clip-plane", error);
    if (strcmp(row->name, "light-color") == 0)
        return append_light_color(v, error);
    if (strcmp(row->name, "light") == 0)
        return append_vector(v->lights[0], 3, &v->light_count, PEL_MAX_LIGHTS, v->light, v->light, "light", error);
    if (strcmp(row->name, "slice") == 0)
        return append_vector(v->slices[0], 6, &v->slice_count, PEL_MAX_SLICES, v->slice, v->slice + 3, "slice", error);
    if (strcmp(row->name, "range") == 0 && v->range[0] == v->range[1])
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--range: %g,%g is no range", v->range[0], v->range[1]);
    if (strcmp(row->name, "clip-box") == 0)
        for (int a = 0; a < 3; a++)
            if (v->clip_box[2 * a] >= v->clip_box[2 * a + 1])
                return tool_fail(error, PEL_ERROR_ARGUMENT, "--clip-box: %c goes from %g to %g; give the lower end first", "xyz"[a],
                                 v -> clip_box[2 * a], v -> clip_box[2 * a + 1]);
    return true;
}

void scene_arguments_attach(struct arguments *arguments, struct scene_arguments *values)
{
    for (int g = 0; g < GROUP_OWN; g++)
        arguments->objects[g] = values;
    arguments->objects[GROUP_OPTICS] = &values->render;
    arguments->objects[GROUP_CAMERA] = &values->camera;
    for (int g = GROUP_OWN + 1; g < MAX_GROUPS; g++)
        arguments->objects[g] = values->techniques[g - GROUP_OWN];
    arguments->assigned = assigned;
    arguments->user = values;
}

/* The group of a technique's options, or -1 where it has none. */
static int group_of(const struct pel_technique_info *technique)
{
    const struct pel_technique_info *other;
    int group = GROUP_OWN + 1;
    for (size_t i = 0; (other = pel_technique_at(i)) && other != technique; i++)
        group += other->options[0].name != NULL;
    return technique->options[0].name ? group : -1;
}

/* Whether an option is one of this group or of those from `first` to before it. */
static bool has_option(const struct option_group *groups, int first, int end, const char *name)
{
    for (int g = first; g < end; g++)
        if (pel_option_find(groups[g].rows, name))
            return true;
    return false;
}

/* "peel and mesh": the techniques that have an option. */
static void owners_of(const char *name, char *text, size_t size)
{
    const struct pel_technique_info *technique;
    text[0] = 0;
    for (size_t i = 0; (technique = pel_technique_at(i)); i++)
        if (pel_option_find(technique->options, name))
            snprintf(text + strlen(text), size - strlen(text), "%s%s", text[0] ? " and " : "", technique->name);
}

void scene_tell_idle(const struct arguments *arguments, const struct scene_arguments *values, const struct pel_technique_info *technique,
                     enum pel_mode mode)
{
    const struct option_group *groups = option_groups(arguments->command);
    char owners[256];
    for (int g = GROUP_OWN + 1; groups[g].title; g++)
        for (int r = 0; groups[g].rows[r].name; r++) {
            const char *name = groups[g].rows[r].name;
            if (!arguments->text[g][r] || pel_option_find(technique->options, name) || has_option(groups, 0, GROUP_OWN + 1, name) ||
                has_option(groups, GROUP_OWN + 1, g, name))
                continue;
            owners_of(name, owners, sizeof owners);
            tool_note("--%s has no effect with the technique %s; it is an option of %s", name, technique->name, owners);
        }
    if (mode == PEL_MODE_ISOSURFACE)
        return;
    if (values->iso_color_count > 0)
        tool_note("--iso-color has no effect but with --isovalue or --mode isosurface");
    if (values->iso_opacities.count > 0)
        tool_note("--iso-opacity has no effect but with --isovalue or --mode isosurface");
}

bool scene_merge_technique(const struct pel_technique_info *technique, const struct arguments *arguments,
                           struct pel_technique_choice *choice, struct pel_error *error)
{
    int group = group_of(technique);
    void *options = group < 0 ? NULL : arguments->objects[group];
    for (int i = 0; options && strcmp(choice->name, technique->name) == 0 && i < choice->option_count; i++) {
        const struct pel_option *row = pel_option_find(technique->options, choice->options[i].name);
        if (row && !arguments->text[group][row - technique->options] && !pel_option_set(row, options, choice->options[i].value, error))
            return false;
    }
    pel_technique_tell(technique, options, choice);
    return true;
}
