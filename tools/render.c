/* SPDX-License-Identifier: MIT */
/* pellucid render: a picture of a volume, or a turn around it. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "commands.h"
#include "scene_arguments.h"

enum stats_form { STATS_NONE, STATS_TEXT, STATS_JSON };

struct values {
    struct scene_arguments scene;
    char output[PEL_OPTION_TEXT_SIZE], depth[PEL_OPTION_TEXT_SIZE], save_scene[PEL_OPTION_TEXT_SIZE];
    bool alpha;
    int compression, turntable;
    int stats; /* enum stats_form */
};

static const char *const stats_names[] = { "none", "text", "json", NULL };

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "output", "Output",
      "Picture to write: NAME.png (8 bits, sRGB), NAME.nrrd (float RGBA, premultiplied), or - for a PNG on standard output",
      PEL_OPTION_TEXT, FIELD(output), 0, 0, NULL, NULL, NULL },
    { "alpha", "Alpha", "Keep the transparency in a PNG instead of painting the background", PEL_OPTION_BOOL, FIELD(alpha), 0, 0, "false",
      NULL, NULL },
    { "compression", "Compression", "Effort of the PNG compression", PEL_OPTION_INT, FIELD(compression), 0, 9, "3", NULL, NULL },
    { "depth", "Depth", "Write the distance along each ray as float NRRD", PEL_OPTION_TEXT, FIELD(depth), 0, 0, NULL, NULL, NULL },
    { "turntable", "Turntable", "Draw this many pictures in one turn about the view-up: NAME_0000.png, NAME_0001.png, ...", PEL_OPTION_INT,
      FIELD(turntable), 1, 9999, NULL, NULL, "pictures" },
    { "save-scene", "Save scene", "Write all that decides the picture as a scene file, for --scene", PEL_OPTION_TEXT, FIELD(save_scene), 0,
      0, NULL, NULL, NULL },
    { "stats", "Statistics",
      "Tell the time of each stage and what was skipped, in the last frame drawn: text on standard error, json on standard output (on standard error with -o -)",
      PEL_OPTION_CHOICE, FIELD(stats), 0, 0, "none", stats_names, NULL },
    { NULL },
};
static const struct option_extra extras[] = {
    { "output", 'o', "FILE", NULL, false },     { "depth", 0, "FILE.nrrd", NULL, false }, { "save-scene", 0, "FILE.json", NULL, false },
    { "stats", 0, "text|json", "text", false }, { "turntable", 0, "N", NULL, false },     { NULL },
};
static const struct option_group groups[] = { SCENE_OPTION_GROUPS, { "Output", rows, extras }, { NULL } };

static bool has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && strcmp(path + length - tail, ending) == 0;
}

/* What can be refused before the work is done. */
static bool check_output(const struct values *values, const struct arguments *arguments, struct pel_error *error)
{
    const char *output = values->output;
    bool turntable = arguments_given(arguments, "turntable");
    if (!output[0] && !values->depth[0] && !values->save_scene[0])
        return tool_fail(error, PEL_ERROR_ARGUMENT, "render: nowhere to put the picture; give -o NAME.png");
    if (output[0] && strcmp(output, "-") != 0 && !has_ending(output, ".png") && !has_ending(output, ".nrrd"))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%.300s: pictures are written as .png or .nrrd; give one of these endings", output);
    if (values->depth[0] && !has_ending(values->depth, ".nrrd"))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%.300s: depth is written as .nrrd; give this ending", values->depth);
    if (turntable && (!output[0] || strcmp(output, "-") == 0))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--turntable writes numbered files; give -o NAME.png");
    if (strcmp(output, "-") == 0 && isatty(STDOUT_FILENO))
        return tool_fail(error, PEL_ERROR_ARGUMENT, "standard output is a terminal; a picture belongs into a file or a pipe");
    const char *const paths[] = { output, values->depth, values->save_scene };
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        char folder[PEL_OPTION_TEXT_SIZE];
        snprintf(folder, sizeof folder, "%s", paths[i]);
        char *slash = strrchr(folder, '/');
        if (!slash || strcmp(paths[i], "-") == 0)
            continue;
        slash[slash == folder] = 0;
        if (access(folder, F_OK) != 0)
            return tool_fail(error, PEL_ERROR_IO, "%.300s: there is no folder %.120s: %s", paths[i], folder, strerror(errno));
    }
    return true;
}

/* NAME.png -> NAME_0007.png */
static bool numbered(const char *path, int number, char *text, size_t size, struct pel_error *error)
{
    const char *dot = strrchr(path, '.');
    int length = snprintf(text, size, "%.*s_%04d%s", (int)(dot - path), path, number, dot);
    return length < (int)size || tool_fail(error, PEL_ERROR_ARGUMENT, "the output's path is too long");
}

static bool check_apart(const char *input, const char *const *paths, struct pel_error *error)
{
    static const char *const flags[] = { "-o", "--depth", "--save-scene" };
    for (int i = 0; i < 3; i++) {
        if (tool_reads_from(input, paths[i]))
            return tool_fail(error, PEL_ERROR_ARGUMENT, "%s %.300s: the input is read from this file; choose another name", flags[i],
                             paths[i]);
        for (int k = 0; k < i; k++)
            if (paths[i][0] && paths[k][0] && tool_same_file(paths[i], paths[k]))
                return tool_fail(error, PEL_ERROR_ARGUMENT, "%s and %s name the same file, %.300s; choose another name for one", flags[k],
                                 flags[i], paths[i]);
    }
    return true;
}

/* No output may be a file that is read, or another output. */
static bool check_names(const struct values *values, const struct arguments *arguments, const char *input, struct pel_error *error)
{
    int frames = arguments_given(arguments, "turntable") ? values->turntable : 0;
    char picture[PEL_OPTION_TEXT_SIZE], depth[PEL_OPTION_TEXT_SIZE];
    const char *paths[] = { values->output, values->depth, values->save_scene };
    if (frames == 0)
        return check_apart(input, paths, error);
    paths[0] = picture;
    paths[1] = depth;
    for (int i = 0; i < frames; i++) {
        picture[0] = depth[0] = 0;
        if ((values->output[0] && !numbered(values->output, i, picture, sizeof picture, error)) ||
            (values->depth[0] && !numbered(values->depth, i, depth, sizeof depth, error)) || !check_apart(input, paths, error))
            return false;
    }
    return true;
}

/* Where a run fails it takes back what it wrote, but never a file that had been there before. */
static bool is_new(const char *path)
{
    struct stat st;
    return lstat(path, &st) != 0;
}

/* The picture, and the depth before it: where one cannot be written an older picture is left alone. */
static bool write_pictures(const struct values *values, const struct loaded_scene *loaded, const struct pel_image *image, int number,
                           struct pel_error *error)
{
    struct pel_image_write_params params = PEL_IMAGE_WRITE_PARAMS_INIT;
    char picture[PEL_OPTION_TEXT_SIZE], depth[PEL_OPTION_TEXT_SIZE];
    bool turntable = number >= 0, new_depth = false;
    params.keep_alpha = values->alpha;
    params.compression = values->compression;
    memcpy(params.background, loaded->scene.background, sizeof params.background);
    snprintf(picture, sizeof picture, "%s", values->output);
    snprintf(depth, sizeof depth, "%s", values->depth);
    if (turntable && ((picture[0] && !numbered(values->output, number, picture, sizeof picture, error)) ||
                      (depth[0] && !numbered(values->depth, number, depth, sizeof depth, error))))
        return false;
    if (depth[0]) {
        new_depth = is_new(depth);
        if (!pel_write_depth(depth, image, error))
            return tool_fail_in(error, depth);
    }
    if (picture[0] && !pel_write_image(picture, image, &params, error)) {
        if (new_depth) /* both or none */
            unlink(depth);
        return tool_fail_in(error, strcmp(picture, "-") == 0 ? "standard output" : picture);
    }
    return true;
}

static void print_stats_text(const struct pel_frame_stats *stats, const struct loaded_scene *loaded)
{
    fprintf(stderr, "technique   %s on %s%s%s, %d thread%s%s%s%s\n", stats->technique, stats->device, stats->isa ? " " : "",
            stats->isa ? stats->isa : "", stats->threads, stats->threads == 1 ? "" : "s", loaded->device_note[0] ? " (" : "",
            loaded->device_note, loaded->device_note[0] ? ")" : "");
    if (stats->reason)
        fprintf(stderr, "%-11s %s\n", "chosen", stats->reason);
    fprintf(stderr, "%-28s %12.3f ms\n", "load", loaded->load_ms);
    for (int i = 0; i < stats->stage_count; i++) {
        fprintf(stderr, "%-28s %12.3f ms", stats->stages[i].name, stats->stages[i].cpu_ms);
        fprintf(stderr, stats->stages[i].gpu_ms >= 0 ? " %12.3f ms on the GPU\n" : "\n", stats->stages[i].gpu_ms);
    }
    for (int i = 0; i < stats->counter_count; i++)
        fprintf(stderr, "%-28s %12" PRIu64 "\n", stats->counters[i].name, stats->counters[i].value);
}

/* {"technique", "reason" (why --technique auto took it), "device", "device_note" (why --device auto took the CPU), "isa", "threads", "load_ms", "stages": [{"name", "cpu_ms", "gpu_ms"}], "counters": {name: value}} */
static bool print_stats_json(const struct pel_frame_stats *stats, const struct loaded_scene *loaded, FILE *stream)
{
    json_t *stages = json_array(), *counters = json_object();
    for (int i = 0; i < stats->stage_count; i++)
        json_array_append_new(stages,
                              json_pack("{s:s, s:f, s:o}", "name", stats->stages[i].name, "cpu_ms", stats->stages[i].cpu_ms, "gpu_ms",
                                        stats->stages[i].gpu_ms >= 0 ? json_number(stats->stages[i].gpu_ms) : json_null()));
    for (int i = 0; i < stats->counter_count; i++)
        json_object_set_new(counters, stats->counters[i].name, json_integer((json_int_t)stats->counters[i].value));
    return json_print(json_pack("{s:s, s:s?, s:s, s:s?, s:s?, s:i, s:f, s:o, s:o}", "technique", stats->technique, "reason", stats->reason, "device", stats->device,
                                "device_note", loaded->device_note[0] ? loaded->device_note : NULL, "isa", stats->isa, "threads", stats->threads, "load_ms", loaded->load_ms, "stages", stages, "counters", counters),
                      stream);
}

static bool print_stats(const struct values *values, const struct pel_renderer *renderer, const struct loaded_scene *loaded,
                        struct pel_error *error)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    if (values->stats == STATS_TEXT)
        print_stats_text(stats, loaded);
    if (values->stats == STATS_JSON && !print_stats_json(stats, loaded, strcmp(values->output, "-") == 0 ? stderr : stdout))
        return tool_fail(error, PEL_ERROR_MEMORY, "no memory for the statistics");
    return true;
}

static bool save_scene(const struct values *values, const struct loaded_scene *loaded, struct pel_error *error)
{
    if (!values->save_scene[0])
        return true;
    return pel_write_scene(values->save_scene, &loaded->scene, error) || tool_fail_in(error, values->save_scene);
}

/* Has any pixel one of the channels from `first` to `last` above the limit? Most pictures say so after some rows. */
static bool any_above(const struct pel_image *image, size_t first, size_t last, float limit)
{
    size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < count; i++)
        for (size_t c = first; c <= last; c++)
            if (image->rgba[4 * i + c] > limit)
                return true;
    return false;
}

/* A picture of nothing is no error, but seldom what was meant; nor is a black MinIP, where the air wins. */
static void tell_if_empty(const struct values *values, const struct loaded_scene *loaded, const struct pel_image *image)
{
    if (values->scene.quiet)
        return;
    if (any_above(image, 3, 3, 0)) {
        if (loaded->scene.render.mode == PEL_MODE_MINIP && !any_above(image, 0, 2, 0.01f))
            tool_note("the least samples are those of the surroundings: clip them away, or name their value with --void");
    } else if (volume_is_void(&loaded->volume)) {
        tool_note("there is nothing to be seen: every sample is void");
    } else {
        tool_note("there is nothing to be seen in the picture; look at the opacities, isovalues, clipping, voids or the camera");
    }
}

/* Draws; where a GPU that was chosen automatically refuses, on the CPU after all. */
static bool draw_frame(const struct values *values, struct loaded_scene *loaded, struct pel_renderer_params *params,
                       struct pel_renderer **renderer, struct pel_image *image, struct pel_error *error)
{
    if (pel_renderer_draw(*renderer, &loaded->scene, loaded->technique, image, error))
        return true;
    if (error->code != PEL_ERROR_UNSUPPORTED || !scene_leave_device(loaded, &values->scene, error->message))
        return false;
    pel_renderer_destroy(*renderer);
    pel_device_destroy(params->device);
    params->device = NULL;
    *error = (struct pel_error)PEL_ERROR_INIT;
    *renderer = pel_renderer_create(params, error);
    return *renderer && pel_renderer_take_technique(*renderer, &loaded->scene.technique, error) &&
           pel_renderer_draw(*renderer, &loaded->scene, loaded->technique, image, error);
}

static bool draw(const struct values *values, const struct arguments *arguments, struct loaded_scene *loaded, struct progress *progress,
                 struct pel_error *error)
{
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    struct pel_image image;
    bool fine = false, turntable = arguments_given(arguments, "turntable");
    int frames = turntable ? values->turntable : 1;
    params.threads = values->scene.threads;
    params.device = loaded->device;
    params.progress = progress_callback(progress);
    pel_image_init(&image);
    struct pel_renderer *renderer = pel_renderer_create(&params, error);
    if (!renderer || !pel_renderer_take_technique(renderer, &loaded->scene.technique, error) ||
        !pel_image_allocate(&image, values->scene.size[0], values->scene.size[1], values->depth[0], error))
        goto cleanup;
    const int draws = 1 + loaded->scene.render.refine; /* of a picture */
    progress_begin(progress, "drawing", frames * draws);
    for (int i = 0; i < frames; i++) {
        progress->part = i * draws;
        if (turntable)
            scene_move_camera(loaded, &values->scene, 360.0 * i / frames);
        do {
            if (!draw_frame(values, loaded, &params, &renderer, &image, error))
                goto cleanup;
            progress->part++;
        } while (!pel_renderer_finished(renderer));
        if (interruption()) {
            tool_fail(error, PEL_ERROR_CANCELLED, "interrupted");
            goto cleanup;
        }
        if (!write_pictures(values, loaded, &image, turntable ? i : -1, error))
            goto cleanup;
    }
    progress_end(progress);
    tell_if_empty(values, loaded, &image);
    fine = print_stats(values, renderer, loaded, error);
cleanup:
    progress_end(progress);
    pel_renderer_destroy(renderer);
    pel_image_finish(&image);
    return fine;
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    static struct loaded_scene loaded;
    struct arguments arguments = { .command = command };
    scene_arguments_attach(&arguments, &values.scene);
    arguments.objects[GROUP_OWN] = &values;
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 1);
    if (status >= 0)
        return status;
    struct pel_error error = PEL_ERROR_INIT;
    struct progress progress;
    progress_init(&progress, values.scene.quiet);
    const char *input = arguments.operand_count ? arguments.operands[0] : NULL;
    if (!check_output(&values, &arguments, &error) || !check_names(&values, &arguments, input, &error) ||
        !scene_load(&loaded, &arguments, &values.scene, input, &progress, &error))
        return tool_report(&error);
    if (!input && !check_names(&values, &arguments, loaded.scene.source.path, &error)) { /* the file that the scene names */
        scene_unload(&loaded);
        return tool_report(&error);
    }
    /* The scene last: where a picture fails, no scene file is left behind either. The turntable's scene is its first picture's. */
    bool fine = (!values.output[0] && !values.depth[0]) || draw(&values, &arguments, &loaded, &progress, &error);
    if (fine) {
        scene_move_camera(&loaded, &values.scene, 0);
        fine = save_scene(&values, &loaded, &error);
    }
    scene_unload(&loaded);
    return tool_finish_stdout(fine ? EXIT_FINE : tool_report(&error));
}

const struct command command_render = {
    .name = "render",
    .summary = "Draw a picture of a volume",
    .usage = "FILE -o PICTURE [options]",
    .description = "FILE is a volume or field, or a folder with a DICOM series or TIFF slices. What is not said is chosen from the data: "
                   "transfer function, camera, isovalue, slice. Of a vector field the magnitude is drawn.\n\n"
                   "FILE may be left out where --scene names one. A picture is written once it is whole: a failed or interrupted run "
                   "leaves none behind (of a turntable, the whole ones).",
    .examples = "  pellucid render scan.nii.gz -o scan.png\n"
                "  pellucid render head.nrrd -o head.png --opacity 40:0,80:0.1,255:0.9 --colormap bone --shade\n"
                "  pellucid render head.nrrd -o skin.png --isovalue 40,90 --iso-opacity 0.3,1 --azimuth 30 --size 1024x768\n"
                "  pellucid render vessels.nrrd -o mip.png --mode mip --parallel\n"
                "  pellucid render head.nrrd -o slice.png --slice 128,128,60,0,0,1\n"
                "  pellucid render scan.nii.gz -o turn.png --turntable 90\n"
                "  pellucid render scan.nii.gz -o - --stats json > scan.png",
    .groups = groups,
    .draws = true,
    .run = run,
};
