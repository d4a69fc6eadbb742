/* SPDX-License-Identifier: MIT */
/* pellucid mesh: isosurfaces as triangles, for other programs. */
#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "commands.h"
#include "scene_arguments.h"

enum stats_form { STATS_NONE, STATS_TEXT, STATS_JSON };

struct values {
    char output[PEL_OPTION_TEXT_SIZE], array[PEL_OPTION_TEXT_SIZE], raw[PEL_OPTION_TEXT_SIZE], isovalue[PEL_OPTION_TEXT_SIZE];
    double isovalues[PEL_MAX_ISOSURFACES], tolerance, spacing[3], void_value;
    int isovalue_count, threads;
    int stats; /* enum stats_form */
    bool quiet;
};

static const char *const stats_names[] = { "none", "text", "json", NULL };

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "isovalue", "Isovalue", "Value of the surface, or several with commas; by default the one that shows the object's outer boundary",
      PEL_OPTION_TEXT, FIELD(isovalue), 0, 0, NULL, NULL, "data value" },
    { "output", "Output", "File to write: NAME.ply or NAME.stl (binary), NAME.obj (text) or NAME.vtp (VTK XML, binary)", PEL_OPTION_TEXT,
      FIELD(output), 0, 0, NULL, NULL, NULL },
    { "tolerance", "Tolerance",
      "How far triangles may lie from the surface of the interpolated values, which is curved within a voxel, before vertices are added; 0 "
      "adds "
      "none: the triangles of marching cubes",
      PEL_OPTION_DOUBLE, FIELD(tolerance), 0, 1, "0", NULL, "voxels" },
    { "array", "Array", "Which array of a file that holds several", PEL_OPTION_TEXT, FIELD(array), 0, 0, NULL, NULL, NULL },
    { "raw", "Raw layout", "Read raw samples of this layout: 256x256x256:u8, 64x64x64:f32:be+1024 (skips 1024 bytes)", PEL_OPTION_TEXT,
      FIELD(raw), 0, 0, NULL, NULL, NULL },
    { "spacing", "Spacing", "Distance between samples along each axis, in place of the file's", PEL_OPTION_VEC3, FIELD(spacing),
      PEL_LEAST_SPACING, PEL_MOST_SPACING, NULL, NULL, "world" },
    { "void", "Void value", "Samples with this value stand for no data", PEL_OPTION_DOUBLE, FIELD(void_value), -DBL_MAX, DBL_MAX, NULL,
      NULL, "data value" },
    { "threads", "Threads", "Threads to work with; 0: as many as the machine has", PEL_OPTION_INT, FIELD(threads), 0, 1024, "0", NULL,
      NULL },
    { "stats", "Statistics", "Tell sizes, bounds and times: text on standard error, json on standard output", PEL_OPTION_CHOICE,
      FIELD(stats), 0, 0, "none", stats_names, NULL },
    { "quiet", "Quiet", "No notes and no progress bar", PEL_OPTION_BOOL, FIELD(quiet), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_extra extras[] = {
    { "isovalue", 0, "V[,V...]", NULL, true }, { "output", 'o', "FILE", NULL, false },
    { "array", 0, "NAME", NULL, false },       { "raw", 0, "LAYOUT", NULL, false },
    { "void", 0, "VALUE", NULL, false },       { "stats", 0, "text|json", "text", false },
    { "quiet", 'q', NULL, NULL, false },       { NULL },
};
static const struct option_group groups[] = { { "Options", rows, extras }, { NULL } };

static bool assigned(void *user, const struct pel_option *row, struct pel_error *error)
{
    struct values *v = user;
    return strcmp(row->name, "isovalue") != 0 || append_isovalues(v->isovalues, &v->isovalue_count, v->isovalue, error);
}

/* What can be refused before the work is done. */
static bool check_output(const char *input, const char *output, struct pel_error *error)
{
    char folder[PEL_OPTION_TEXT_SIZE];
    if (!output[0])
        return tool_fail(error, PEL_ERROR_ARGUMENT, "mesh: nowhere to put the surface; give -o NAME.ply");
    if (!pel_check_mesh_path(output, error))
        return false;
    if (tool_reads_from(input, output))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%.300s: the input is read from this file; choose another name for the output", output);
    snprintf(folder, sizeof folder, "%s", output);
    char *slash = strrchr(folder, '/');
    if (!slash)
        return true;
    slash[slash == folder] = 0;
    return access(folder, F_OK) == 0 ||
           tool_fail(error, PEL_ERROR_IO, "%.300s: there is no folder %.120s: %s", output, folder, strerror(errno));
}

/* Volumes that have no surface, whatever the isovalue. */
static bool check_values(const char *path, const struct pel_volume *volume, struct pel_error *error)
{
    if (volume_is_void(volume))
        return tool_fail(error, PEL_ERROR_UNSUPPORTED, "%s: there is no surface: every sample is void", path);
    if (volume->range[0] == volume->range[1])
        return tool_fail(error, PEL_ERROR_UNSUPPORTED, "%s: there is no surface: every sample is %.9g", path, volume->range[0]);
    return true;
}

/* Why there is no surface of an isovalue. */
static void why_empty(const struct pel_volume *volume, double isovalue, char *text, size_t size)
{
    const double lo = volume->range[0], hi = volume->range[1];
    if (isovalue > hi)
        snprintf(text, size, "no value reaches the isovalue %.9g; the values go from %.9g to %.9g", isovalue, lo, hi);
    else if (isovalue <= lo)
        snprintf(text, size, "no value is below the isovalue %.9g; the values go from %.9g to %.9g; take one above the least", isovalue, lo,
                 hi);
    else
        snprintf(text, size, "no cell without voids has values on both sides of the isovalue %.9g", isovalue);
}

/* A file without a surface is not what was asked for; of several surfaces one may be missing. */
static bool check_mesh(const char *path, const struct pel_mesh *mesh, const struct pel_volume *volume, bool quiet, struct pel_error *error)
{
    char why[256];
    if (mesh->triangle_count) {
        for (int i = 0; i < mesh->part_count && !quiet; i++)
            if (!mesh->parts[i].triangle_count) {
                why_empty(volume, mesh->parts[i].isovalue, why, sizeof why);
                tool_note("%s: %s", path, why);
            }
        return true;
    }
    why_empty(volume, mesh->parts[0].isovalue, why, sizeof why);
    return tool_fail(error, PEL_ERROR_UNSUPPORTED, "%s: there is no surface: %s", path, why);
}

struct facts {
    double load, extract, collapse, write; /* milliseconds */
    size_t flat;                           /* triangles without area */
    int64_t open;                          /* edges of one triangle */
};

/* What somebody who takes the file for a solid should know. */
static void tell(const struct values *values, const char *path, const struct pel_mesh *mesh, const struct facts *facts)
{
    if (facts->open > 0)
        tool_note("%s: the surface is open: %" PRId64 " edges have one triangle, where it leaves the volume or meets voids", path,
                  facts->open);
    if (facts->flat > 0)
        tool_note("%s: %zu of %zu triangles have no area, as voxels are exactly the isovalue and the surface touches itself there; an "
                  "isovalue between the values has none",
                  path, facts->flat, mesh->triangle_count);
    const char *dot = strrchr(values->output, '.');
    if (dot && strcasecmp(dot, ".stl") == 0 && pel_mesh_is_far(mesh))
        tool_note("%s: STL has floats alone, which are coarse so far from the world's zero; PLY and VTP keep every place", values->output);
}

static void print_stats_text(const struct pel_mesh *mesh, const struct facts *facts)
{
    double bounds[6];
    fprintf(stderr, "%-28s %12.3f ms\n%-28s %12.3f ms\n%-28s %12.3f ms\n%-28s %12.3f ms\n", "load", facts->load, "extract", facts->extract,
            "collapse", facts->collapse, "write", facts->write);
    for (int i = 0; i < mesh->part_count; i++)
        fprintf(stderr, "isovalue %-19.9g %12zu vertices, %zu triangles\n", mesh->parts[i].isovalue, mesh->parts[i].vertex_count,
                mesh->parts[i].triangle_count);
    fprintf(stderr, "%-28s %12" PRId64 "\n", "open edges", facts->open);
    fprintf(stderr, "%-28s %12zu\n", "triangles without area", facts->flat);
    if (pel_mesh_bounds(mesh, bounds))
        fprintf(stderr, "bounds      %.9g to %.9g, %.9g to %.9g, %.9g to %.9g%s%s\n", bounds[0], bounds[1], bounds[2], bounds[3], bounds[4],
                bounds[5], mesh->units[0] ? " " : "", mesh->units);
}

static bool print_stats_json(const struct pel_mesh *mesh, const struct facts *facts)
{
    double bounds[6];
    bool any = pel_mesh_bounds(mesh, bounds);
    json_t *surfaces = json_array();
    for (int i = 0; i < mesh->part_count; i++)
        json_array_append_new(surfaces,
                              json_pack("{s:o, s:I, s:I}", "isovalue", json_number(mesh->parts[i].isovalue), "vertices",
                                        (json_int_t)mesh->parts[i].vertex_count, "triangles", (json_int_t)mesh->parts[i].triangle_count));
    return json_print(json_pack("{s:f, s:f, s:f, s:f, s:I, s:I, s:I, s:I, s:o, s:o}", "load_ms", facts->load, "extract_ms", facts->extract,
                                "collapse_ms", facts->collapse, "write_ms", facts->write, "vertices", (json_int_t)mesh->vertex_count,
                                "triangles", (json_int_t)mesh->triangle_count, "flat_triangles", (json_int_t)facts->flat, "open_edges",
                                (json_int_t)facts->open, "bounds", any ? json_numbers(bounds, 6) : json_null(), "surfaces", surfaces),
                      stdout);
}

static struct pel_mesh *extract(const struct values *values, const struct pel_volume *volume, const char *path, struct progress *progress,
                                struct pel_error *error)
{
    struct pel_mesh_params params = PEL_MESH_PARAMS_INIT;
    memcpy(params.isovalues, values->isovalues, sizeof params.isovalues);
    params.isovalue_count = values->isovalue_count;
    params.tolerance = values->tolerance;
    params.threads = values->threads;
    params.progress = progress_callback(progress);
    if (!params.isovalue_count) {
        params.isovalues[params.isovalue_count++] = pel_isovalue_automatic(volume);
        if (!values->quiet)
            tool_note("%s: the isovalue %g was chosen from the data", path, params.isovalues[0]);
    }
    progress_begin(progress, "extracting", 1);
    struct pel_mesh *mesh = pel_mesh_extract(volume, &params, error);
    progress_end(progress);
    if (!mesh)
        tool_fail_in(error, path);
    return mesh;
}

static bool write_out(const struct values *values, const struct pel_mesh *mesh, struct progress *progress, struct pel_error *error)
{
    const struct pel_progress callback = progress_callback(progress);
    progress_begin(progress, "writing", 1);
    bool fine = !interruption() || tool_fail(error, PEL_ERROR_CANCELLED, "interrupted");
    fine = fine && (pel_write_mesh(values->output, mesh, &callback, error) || tool_fail_in(error, values->output));
    progress_end(progress);
    return fine;
}

/* The surfaces as they go into the file. */
static struct pel_mesh *make(const struct values *values, const struct pel_volume *volume, const char *path, struct progress *progress,
                             struct facts *facts, struct pel_error *error)
{
    if (!check_values(path, volume, error))
        return NULL;
    facts->extract -= tool_milliseconds();
    struct pel_mesh *mesh = extract(values, volume, path, progress, error);
    facts->extract += tool_milliseconds();
    facts->collapse -= tool_milliseconds();
    bool fine = mesh && (pel_mesh_collapse(mesh, &facts->flat, error) || tool_fail_in(error, path)) &&
                check_mesh(path, mesh, volume, values->quiet, error);
    facts->collapse += tool_milliseconds();
    if (fine && (!values->quiet || values->stats != STATS_NONE))
        facts->open = pel_mesh_open_edges(mesh);
    if (fine)
        return mesh;
    pel_mesh_destroy(mesh);
    return NULL;
}

static bool run_on(const char *path, const struct arguments *arguments, const struct values *values, struct pel_error *error)
{
    struct pel_volume volume;
    struct pel_file_info info;
    struct progress progress;
    struct facts facts = { .load = -tool_milliseconds() };
    if (!check_output(path, values->output, error))
        return false;
    progress_init(&progress, values->quiet);
    if (!volume_load(path, values->array, values->raw, true, &progress, values->quiet, &volume, &info, error))
        return false;
    if (arguments_given(arguments, "spacing"))
        memcpy(volume.spacing, values->spacing, sizeof volume.spacing);
    if (arguments_given(arguments, "void")) {
        volume.has_void = true;
        volume.void_value = values->void_value;
        pel_volume_update_range(&volume);
    }
    if (volume.labels && !values->quiet)
        tool_note("%s: the values seem to be labels; a surface between two of them passes where their numbers say, not their places", path);
    facts.load += tool_milliseconds();
    struct pel_mesh *mesh = make(values, &volume, path, &progress, &facts, error);
    facts.write -= tool_milliseconds();
    bool fine = mesh && write_out(values, mesh, &progress, error);
    facts.write += tool_milliseconds();
    if (fine && !values->quiet)
        tell(values, path, mesh, &facts);
    if (fine && values->stats == STATS_TEXT)
        print_stats_text(mesh, &facts);
    if (fine && values->stats == STATS_JSON)
        fine = print_stats_json(mesh, &facts) || tool_fail(error, PEL_ERROR_MEMORY, "no memory for the statistics");
    pel_mesh_destroy(mesh);
    pel_volume_finish(&volume);
    return fine;
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    struct arguments arguments = { .command = command, .objects = { &values }, .assigned = assigned, .user = &values };
    int status = arguments_parse_operands(&arguments, argc, argv, 1, 1);
    if (status >= 0)
        return status;
    struct pel_error error = PEL_ERROR_INIT;
    return tool_finish_stdout(run_on(arguments.operands[0], &arguments, &values, &error) ? EXIT_FINE : tool_report(&error));
}

const struct command command_mesh = {
    .name = "mesh",
    .summary = "Write isosurfaces as triangles",
    .usage = "FILE -o SURFACE [options]",
    .description =
        "Extracts the surfaces on which a volume has one value, without cracks, in world coordinates, with normals; they and the "
        "triangles look towards the lesser values. Of a vector field the magnitude is taken. Where a surface leaves the volume or meets "
        "voids it is open: a note tells how many edges are. Where voxels are exactly the isovalue, vertices that would share a place are "
        "made one; a note tells how many triangles keep no area, as the surface touches itself there.\n\n"
        "An isovalue that no surface has is an error, and no file is written; of several, those that have none are noted.\n\n"
        "Of several surfaces in one file PLY and VTP tell the isovalue of each vertex, OBJ has a group each, STL only the triangles.\n\n"
        "--stats json prints one object with the keys load_ms, extract_ms, collapse_ms, write_ms, vertices, triangles, flat_triangles "
        "(without area), open_edges, bounds and surfaces (isovalue, vertices and triangles of each).",
    .examples = "  pellucid mesh head.nrrd --isovalue 140 -o skull.ply\n"
                "  pellucid mesh head.nrrd --isovalue 40,140 -o head.vtp --stats\n"
                "  pellucid mesh scan.nii.gz -o scan.stl",
    .groups = groups,
    .run = run,
};
