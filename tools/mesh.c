/* SPDX-License-Identifier: MIT */
/* pellucid mesh: isosurfaces as triangles, for other programs. */
#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <string.h>
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
    return strcmp(row->name, "isovalue") != 0 ||
           append_numbers(v->isovalues, &v->isovalue_count, -DBL_MAX, DBL_MAX, "--isovalue", v->isovalue, error);
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

/* An empty surface is no error, but seldom what was meant. */
static void tell_if_empty(const char *path, const struct pel_mesh *mesh, const struct pel_volume *volume)
{
    for (int i = 0; i < mesh->part_count; i++)
        if (!mesh->parts[i].triangle_count && volume->range[0] <= volume->range[1])
            tool_note("%s: nothing has the isovalue %g; the values go from %g to %g", path, mesh->parts[i].isovalue, volume->range[0],
                      volume->range[1]);
        else if (!mesh->parts[i].triangle_count)
            tool_note("%s: there is no surface, as every sample is void", path);
}

struct times {
    double load, extract, write; /* milliseconds */
};

static void print_stats_text(const struct pel_mesh *mesh, const struct times *times)
{
    double bounds[6];
    fprintf(stderr, "%-28s %12.3f ms\n%-28s %12.3f ms\n%-28s %12.3f ms\n", "load", times->load, "extract", times->extract, "write",
            times->write);
    for (int i = 0; i < mesh->part_count; i++)
        fprintf(stderr, "isovalue %-19.9g %12zu vertices, %zu triangles\n", mesh->parts[i].isovalue, mesh->parts[i].vertex_count,
                mesh->parts[i].triangle_count);
    fprintf(stderr, "%-28s %12" PRId64 "\n", "open edges", pel_mesh_open_edges(mesh));
    if (pel_mesh_bounds(mesh, bounds))
        fprintf(stderr, "bounds      %.9g to %.9g, %.9g to %.9g, %.9g to %.9g%s%s\n", bounds[0], bounds[1], bounds[2], bounds[3], bounds[4],
                bounds[5], mesh->units[0] ? " " : "", mesh->units);
}

static bool print_stats_json(const struct pel_mesh *mesh, const struct times *times)
{
    double bounds[6];
    bool any = pel_mesh_bounds(mesh, bounds);
    json_t *surfaces = json_array();
    for (int i = 0; i < mesh->part_count; i++)
        json_array_append_new(surfaces,
                              json_pack("{s:o, s:I, s:I}", "isovalue", json_number(mesh->parts[i].isovalue), "vertices",
                                        (json_int_t)mesh->parts[i].vertex_count, "triangles", (json_int_t)mesh->parts[i].triangle_count));
    return json_print(json_pack("{s:f, s:f, s:f, s:I, s:I, s:I, s:o, s:o}", "load_ms", times->load, "extract_ms", times->extract,
                                "write_ms", times->write, "vertices", (json_int_t)mesh->vertex_count, "triangles",
                                (json_int_t)mesh->triangle_count, "open_edges", (json_int_t)pel_mesh_open_edges(mesh), "bounds",
                                any ? json_numbers(bounds, 6) : json_null(), "surfaces", surfaces),
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

static bool run_on(const char *path, const struct arguments *arguments, const struct values *values, struct pel_error *error)
{
    struct pel_volume volume;
    struct pel_file_info info;
    struct progress progress;
    struct times times = { -tool_milliseconds(), 0, 0 };
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
    times.load += tool_milliseconds();
    times.extract -= tool_milliseconds();
    struct pel_mesh *mesh = extract(values, &volume, path, &progress, error);
    times.extract += tool_milliseconds();
    times.write -= tool_milliseconds();
    bool fine = mesh && write_out(values, mesh, &progress, error);
    times.write += tool_milliseconds();
    if (fine && !values->quiet)
        tell_if_empty(path, mesh, &volume);
    if (fine && values->stats == STATS_TEXT)
        print_stats_text(mesh, &times);
    if (fine && values->stats == STATS_JSON)
        fine = print_stats_json(mesh, &times) || tool_fail(error, PEL_ERROR_MEMORY, "no memory for the statistics");
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
        "voids "
        "it is open: --stats tells how many edges are.\n\n"
        "Of several surfaces in one file PLY and VTP tell the isovalue of each vertex, OBJ has a group each, STL only the triangles.\n\n"
        "--stats json prints one object with the keys load_ms, extract_ms, write_ms, vertices, triangles, open_edges, bounds (null where "
        "there is no surface) and surfaces (isovalue, vertices and triangles of each).",
    .examples = "  pellucid mesh head.nrrd --isovalue 140 -o skull.ply\n"
                "  pellucid mesh head.nrrd --isovalue 40,140 -o head.vtp --stats\n"
                "  pellucid mesh scan.nii.gz -o scan.stl",
    .groups = groups,
    .run = run,
};
