/* SPDX-License-Identifier: MIT */
/* pellucid bench: what a frame costs while the camera moves, after the transfer function changed, after the isovalue changed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "commands.h"
#include "scene_arguments.h"

enum { MOST_FRAMES = 1000 };

struct values {
    struct scene_arguments scene;
    int frames, warmup;
    double orbit;
    bool json, sample_limit;
};

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "frames", "Frames", "Frames to measure, of each kind", PEL_OPTION_INT, FIELD(frames), 1, MOST_FRAMES, "9", NULL, NULL },
    { "warmup", "Warm-up", "Frames drawn before, not counted", PEL_OPTION_INT, FIELD(warmup), 0, MOST_FRAMES, "2", NULL, NULL },
    { "orbit", "Orbit", "Turn of the camera from frame to frame", PEL_OPTION_DOUBLE, FIELD(orbit), -360, 360, "5", NULL, "degrees" },
    { "sample-limit", "Sample limit", "On a GPU, measure what its texture units take along the rays, too: the time of several frames without skipping",
      PEL_OPTION_BOOL, FIELD(sample_limit), 0, 0, "true", NULL, NULL },
    { "json", "JSON", "Print one JSON object", PEL_OPTION_BOOL, FIELD(json), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_extra extras[] = { { "orbit", 0, "DEGREES", NULL, false }, { NULL } };
static const struct option_group groups[] = { SCENE_OPTION_GROUPS, { "Measurement", rows, extras }, { NULL } };

/* Values of each frame, and what they come to. */
struct series {
    double all[MOST_FRAMES], sorted[MOST_FRAMES];
    int count;
};

struct bench {
    const struct values *values;
    struct loaded_scene *loaded;
    struct pel_renderer *renderer;
    struct pel_image image;
    double first_ms;
    double upload_ms, sample_limit; /* NAN: there is none */
    struct series frames, transfer, isovalue, taken, skipped, cast;
};

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void series_add(struct series *series, double value)
{
    if (series->count < MOST_FRAMES)
        series->all[series->count++] = value;
}

static void series_sort(struct series *series)
{
    memcpy(series->sorted, series->all, (size_t)series->count * sizeof(double));
    qsort(series->sorted, (size_t)series->count, sizeof(double), ascending);
}

static double series_median(const struct series *series)
{
    int n = series->count;
    return n ? 0.5 * (series->sorted[(n - 1) / 2] + series->sorted[n / 2]) : NAN;
}

static bool draw(struct bench *bench, struct pel_error *error)
{
    return pel_renderer_draw(bench->renderer, &bench->loaded->scene, bench->loaded->technique, &bench->image, error);
}

static double counter(const struct bench *bench, const char *name)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(bench->renderer);
    for (int i = 0; i < stats->counter_count; i++)
        if (strcmp(stats->counters[i].name, name) == 0)
            return (double)stats->counters[i].value;
    return 0;
}

/* Milliseconds of a stage of the last frame, on the GPU where its clock counts; NAN where there is no such stage. */
static double stage(const struct bench *bench, const char *name)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(bench->renderer);
    bool hardware = bench->loaded->device && !pel_device_describe(bench->loaded->device)->software;
    for (int i = 0; i < stats->stage_count; i++)
        if (strcmp(stats->stages[i].name, name) == 0)
            return hardware && stats->stages[i].gpu_ms >= 0 ? stats->stages[i].gpu_ms : stats->stages[i].cpu_ms;
    return NAN;
}

/* The n-th edit in steps of 1/255 of the values' range: +2, -2, +4, -4, +3, -3, +5, -5, +2, ...; never twice the same in a row. */
static double edit_offset(const struct pel_volume *volume, int n)
{
    static const double sizes[] = { 2, 4, 3, 5 };
    double range = volume->range[1] - volume->range[0];
    return sizes[n / 2 % 4] * (n % 2 ? -1 : 1) * (range > 0 ? range : 1) / 255;
}

static bool bench_orbit(struct bench *bench, struct pel_error *error)
{
    const struct values *values = bench->values;
    for (int i = 0; i < values->warmup; i++) {
        scene_move_camera(bench->loaded, &values->scene, (i - values->warmup) * values->orbit);
        if (!draw(bench, error))
            return false;
    }
    for (int i = 0; i < values->frames; i++) {
        scene_move_camera(bench->loaded, &values->scene, i * values->orbit);
        double start = tool_milliseconds();
        if (!draw(bench, error))
            return false;
        series_add(&bench->frames, tool_milliseconds() - start);
        if (stage(bench, "cast rays") > 0)
            series_add(&bench->cast, stage(bench, "cast rays"));
        series_add(&bench->taken, counter(bench, "samples taken"));
        series_add(&bench->skipped, counter(bench, "samples skipped"));
    }
    scene_move_camera(bench->loaded, &values->scene, 0);
    return draw(bench, error);
}

/* The inner points of the opacity curve move together; its ends stay, where it has inner points. */
static bool bench_transfer(struct bench *bench, struct pel_error *error)
{
    struct pel_transfer *transfer = &bench->loaded->scene.transfer;
    size_t count = transfer->opacity_count, inner = count > 2;
    struct pel_opacity_point *base = malloc(2 * count * sizeof *base), *moved = base + count;
    if (!base)
        return tool_fail(error, PEL_ERROR_MEMORY, "no memory for the transfer function");
    memcpy(base, transfer->opacities, count * sizeof *base);
    bool fine = true;
    for (int i = 0; i < bench->values->frames && fine; i++) {
        double offset = edit_offset(&bench->loaded->volume, i);
        memcpy(moved, base, count * sizeof *base);
        for (size_t p = inner; p + inner < count; p++) {
            moved[p].value += offset;
            if (inner) /* not past the ends */
                moved[p].value = fmin(fmax(moved[p].value, base[0].value), base[count - 1].value);
        }
        double start = tool_milliseconds();
        fine = pel_transfer_set_opacities(transfer, moved, count, error) && draw(bench, error);
        series_add(&bench->transfer, tool_milliseconds() - start);
    }
    fine = fine && pel_transfer_set_opacities(transfer, base, count, error);
    free(base);
    return fine;
}

static bool bench_isovalue(struct bench *bench, struct pel_error *error)
{
    struct pel_scene *scene = &bench->loaded->scene;
    struct pel_isosurface base[PEL_MAX_ISOSURFACES];
    memcpy(base, scene->isosurfaces, sizeof base);
    for (int i = 0; i < bench->values->frames; i++) {
        double offset = edit_offset(&bench->loaded->volume, i), start = tool_milliseconds();
        for (int s = 0; s < scene->isosurface_count; s++)
            scene->isosurfaces[s].value = base[s].value + offset;
        if (!draw(bench, error))
            return false;
        series_add(&bench->isovalue, tool_milliseconds() - start);
    }
    memcpy(scene->isosurfaces, base, sizeof base);
    return true;
}

static bool measure(struct bench *bench, struct progress *progress, struct pel_error *error)
{
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.threads = bench->values->scene.threads;
    params.device = bench->loaded->device;
    bench->loaded->scene.render.refine = 0; /* every frame is a new view */
    /* The callback only listens for Ctrl-C: a bar would be drawn inside what is measured. */
    progress->enabled = false;
    params.progress = progress_callback(progress);
    if (!pel_image_allocate(&bench->image, bench->values->scene.size[0], bench->values->scene.size[1], false, error))
        return false;
    double start = tool_milliseconds();
    bench->renderer = pel_renderer_create(&params, error);
    if (!bench->renderer || !pel_renderer_take_technique(bench->renderer, &bench->loaded->scene.technique, error) || !draw(bench, error))
        return false;
    bench->first_ms = tool_milliseconds() - start;
    bench->upload_ms = stage(bench, "upload");
    if (!bench_orbit(bench, error))
        return false;
    struct pel_error none = PEL_ERROR_INIT;
    if (!bench->loaded->device || !bench->values->sample_limit || !pel_renderer_sample_limit(bench->renderer, &bench->sample_limit, &none))
        bench->sample_limit = NAN;
    /* The transfer function colours no isosurface. */
    return bench->loaded->scene.render.mode == PEL_MODE_ISOSURFACE ? bench_isovalue(bench, error) : bench_transfer(bench, error);
}

static json_t *json_series(struct series *series)
{
    if (!series->count)
        return json_null();
    return json_pack("{s:o, s:o, s:o, s:o}", "median", json_number(series_median(series)), "min", json_number(series->sorted[0]), "max",
                     json_number(series->sorted[series->count - 1]), "all", json_numbers(series->all, (size_t)series->count));
}

static double volume_mb(const struct bench *bench)
{
    return (double)pel_volume_bytes(&bench->loaded->volume) / 1048576;
}

/* Of the frames, while rays were cast. */
static double samples_per_second(const struct bench *bench)
{
    return series_median(&bench->taken) / (series_median(&bench->cast) * 1e-3);
}

static double peak_memory_mb(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

/* Stages and counters of the last frame: after a change of the isovalue, or of the transfer function. */
static json_t *json_last_frame(const struct pel_frame_stats *stats)
{
    json_t *stages = json_object(), *counters = json_object();
    for (int i = 0; i < stats->stage_count; i++)
        json_object_set_new(stages, stats->stages[i].name,
                            json_number(stats->stages[i].gpu_ms >= 0 ? stats->stages[i].gpu_ms : stats->stages[i].cpu_ms));
    for (int i = 0; i < stats->counter_count; i++)
        json_object_set_new(counters, stats->counters[i].name, json_integer((json_int_t)stats->counters[i].value));
    return json_pack("{s:o, s:o}", "stages", stages, "counters", counters);
}

static bool print_json(struct bench *bench)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(bench->renderer);
    json_t *json = json_object();
    json_object_set_new(json, "frame_ms", json_series(&bench->frames));
    json_object_set_new(json, "first_frame_ms", json_number(bench->first_ms));
    json_object_set_new(json, "transfer_change_ms", json_series(&bench->transfer));
    json_object_set_new(json, "isovalue_change_ms", json_series(&bench->isovalue));
    json_object_set_new(json, "samples_taken", json_integer((json_int_t)series_median(&bench->taken)));
    json_object_set_new(json, "samples_skipped", json_integer((json_int_t)series_median(&bench->skipped)));
    json_object_set_new(json, "cast_ms", json_series(&bench->cast));
    json_object_set_new(json, "samples_per_second", json_number(samples_per_second(bench)));
    json_object_set_new(json, "texture_samples_per_second", json_number(bench->sample_limit));
    json_object_set_new(json, "upload_ms", json_number(bench->upload_ms));
    json_object_set_new(json, "upload_mb_per_second", json_number(volume_mb(bench) / (bench->upload_ms * 1e-3)));
    json_object_set_new(json, "device_bytes",
                        bench->loaded->device ? json_integer((json_int_t)counter(bench, "bytes on the device")) : json_null());
    json_object_set_new(json, "peak_memory_mb", json_number(peak_memory_mb()));
    json_object_set_new(json, "volume_mb", json_number(volume_mb(bench)));
    json_object_set_new(json, "load_ms", json_number(bench->loaded->load_ms));
    json_object_set_new(json, "threads", json_integer(stats->threads));
    json_object_set_new(json, "device", json_text(stats->device));
    json_object_set_new(json, "isa", stats->isa ? json_text(stats->isa) : json_null());
    json_object_set_new(json, "technique", json_text(stats->technique));
    json_object_set_new(json, "reason", stats->reason ? json_text(stats->reason) : json_null());
    json_object_set_new(json, "size", json_pack("[i, i]", bench->image.width, bench->image.height));
    json_object_set_new(json, "last_frame", json_last_frame(stats));
    return json_print(json, stdout);
}

static void print_series(const char *label, const struct series *series)
{
    if (series->count)
        printf("%-22s %9.2f ms   (%.2f to %.2f)\n", label, series_median(series), series->sorted[0], series->sorted[series->count - 1]);
}

static void print_text(const struct bench *bench)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(bench->renderer);
    printf("%s, %dx%d, %d thread%s, %s\n", stats->technique, bench->image.width, bench->image.height, stats->threads,
           stats->threads == 1 ? "" : "s", stats->isa ? stats->isa : stats->device);
    if (stats->reason)
        printf("%-22s %s\n", "chosen", stats->reason);
    printf("%-22s %9.2f ms\n", "load", bench->loaded->load_ms);
    printf("%-22s %9.2f ms\n", "first frame", bench->first_ms);
    print_series("frame, orbiting", &bench->frames);
    print_series("after transfer change", &bench->transfer);
    print_series("after isovalue change", &bench->isovalue);
    printf("%-22s %12.0f a frame\n", "samples taken", series_median(&bench->taken));
    printf("%-22s %12.0f a frame\n", "samples skipped", series_median(&bench->skipped));
    if (bench->cast.count)
        printf("%-22s %9.1f million a second while rays are cast\n", "samples", samples_per_second(bench) * 1e-6);
    if (bench->sample_limit > 0)
        printf("%-22s %9.1f million a second (limit)\n", "texture samples", bench->sample_limit * 1e-6);
    if (bench->loaded->device && isnan(bench->upload_ms)) /* the technique keeps no volume there */
        printf("%-22s %9.1f MB\n", "on the device", counter(bench, "bytes on the device") / 1048576);
    else if (bench->loaded->device)
        printf("%-22s %9.2f ms   (%.0f MB a second); %.1f MB on the device\n", "upload", bench->upload_ms,
               volume_mb(bench) / (bench->upload_ms * 1e-3), counter(bench, "bytes on the device") / 1048576);
    printf("%-22s %9.1f MB   (volume %.1f MB)\n", "peak memory", peak_memory_mb(), volume_mb(bench));
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    static struct loaded_scene loaded;
    static struct bench bench;
    struct arguments arguments = { .command = command };
    scene_arguments_attach(&arguments, &values.scene);
    arguments.objects[GROUP_OWN] = &values;
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 1);
    if (status >= 0)
        return status;
    struct pel_error error = PEL_ERROR_INIT;
    struct progress progress;
    progress_init(&progress, values.scene.quiet);
    if (!scene_load(&loaded, &arguments, &values.scene, arguments.operand_count ? arguments.operands[0] : NULL, &progress, &error))
        return tool_report(&error);
    bench.values = &values;
    bench.loaded = &loaded;
    pel_image_init(&bench.image);
    bool fine = measure(&bench, &progress, &error);
    struct series *all[] = { &bench.frames, &bench.transfer, &bench.isovalue, &bench.taken, &bench.skipped, &bench.cast };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        series_sort(all[i]);
    if (fine && values.json)
        fine = print_json(&bench) || tool_fail(&error, PEL_ERROR_MEMORY, "no memory for the JSON text");
    else if (fine)
        print_text(&bench);
    pel_renderer_destroy(bench.renderer);
    pel_image_finish(&bench.image);
    scene_unload(&loaded);
    return tool_finish_stdout(fine ? EXIT_FINE : tool_report(&error));
}

const struct command command_bench = {
    .name = "bench",
    .summary = "Measure what a frame costs",
    .usage = "FILE [options]",
    .description =
        "Takes the options of render (--refine has no effect). Draws frames while the camera orbits; then, with the camera of the first frame, after each of a "
        "series of changes of the transfer function (the inner points of the opacity curve moved together by 2, -2, 4, -4, ... 255ths of "
        "the values' range); in mode isosurface, in its place, after changes of the isovalue by as much. A change's time is from the edit to the "
        "picture.\n\n"
        "--json prints frame_ms, transfer_change_ms and isovalue_change_ms (each median, min, max and all, or null), first_frame_ms, "
        "samples_taken and samples_skipped (medians), cast_ms (while rays are cast), samples_per_second (in that time), "
        "texture_samples_per_second (what the GPU takes along the same rays if it does nothing else; null on the CPU and with --no-sample-limit), upload_ms, "
        "upload_mb_per_second, device_bytes (null on the CPU), peak_memory_mb and volume_mb (of 1048576 bytes), load_ms, threads, "
        "device, isa, technique, reason (why --technique auto took it, or null), size and last_frame (stages in milliseconds and counters of the last frame drawn).",
    .examples = "  pellucid bench head.nrrd --shade --json\n"
                "  pellucid bench head.nrrd --isovalue 90 --size 1024 --frames 15",
    .groups = groups,
    .draws = true,
    .run = run,
};
