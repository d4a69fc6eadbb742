/* SPDX-License-Identifier: MIT */
/* A scene from a scene file, a volume file and flags, in this order: later ones override. What none of them says is chosen from the data.
 */
#include "scene_arguments.h"

#include <limits.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

bool volume_load(const char *path, const char *array, const char *raw, bool scalar, struct progress *progress, bool quiet,
                 struct pel_volume *volume, struct pel_file_info *info, struct pel_error *error)
{
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    params.array = array && array[0] ? array : NULL;
    params.raw = raw && raw[0] ? raw : NULL;
    params.progress = progress_callback(progress);
    pel_volume_init(volume);
    memset(info, 0, sizeof *info);
    progress_begin(progress, "reading", 1);
    bool fine = pel_read_volume(path, &params, volume, info, error);
    progress_end(progress);
    if (!fine)
        return tool_fail_in(error, path);
    for (int i = 0; i < info->note_count && !quiet; i++)
        tool_note("%s: %s", path, info->notes[i]);
    if (!scalar || volume->components == 1)
        return true;
    if (!quiet)
        tool_note("%s: %d numbers a sample; their magnitude is taken", path, volume->components);
    struct pel_volume magnitude;
    pel_volume_init(&magnitude);
    fine = pel_volume_magnitude(volume, &magnitude, error);
    pel_volume_finish(volume);
    if (!fine)
        return tool_fail_in(error, path);
    *volume = magnitude;
    return true;
}

/* Their range is 0 to 0, as is that of a volume of zeros. */
bool volume_is_void(const struct pel_volume *volume)
{
    if (volume->range[0] != 0 || volume->range[1] != 0)
        return false;
    for (size_t z = 0; z < volume->dims[2]; z++)
        for (size_t y = 0; y < volume->dims[1]; y++)
            for (size_t x = 0; x < volume->dims[0]; x++)
                if (!pel_volume_is_void(volume, pel_volume_get(volume, x, y, z, 0)))
                    return false;
    return true;
}

/* What the library cannot refuse because it does not know that it is asked for by name, or what this machine cannot do. */
static bool check_arguments(const struct arguments *arguments, const struct scene_arguments *values, struct pel_error *error)
{
    bool iso = values->isovalues.count > 0, slice = arguments_given(arguments, "slice") != NULL,
         mode = arguments_given(arguments, "mode") != NULL;
    if (iso && slice)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--isovalue and --slice ask for different pictures; give one of them");
    if (iso && mode && values->render.mode != PEL_MODE_ISOSURFACE)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--isovalue needs --mode isosurface");
    if (slice && mode && values->render.mode != PEL_MODE_SLICE)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--slice needs --mode slice");
    for (int i = 0; i < 2; i++)
        if (values->size[i] < 1 || values->size[i] > PEL_IMAGE_MAX)
            return tool_fail(error, PEL_ERROR_ARGUMENT, "--size: %dx%d is beyond 1x1 to %dx%d", values->size[0], values->size[1],
                             PEL_IMAGE_MAX, PEL_IMAGE_MAX);
    /* A picture beyond the machine's memory would be given by the operating system and end the program halfway. */
    double bytes = (double)values->size[0] * values->size[1] * 5 * sizeof(float);
    double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (memory > 0 && bytes > 0.75 * memory)
        return tool_fail(error, PEL_ERROR_MEMORY, "--size: a picture of %dx%d needs %.1f GB; this machine has %.1f GB", values->size[0],
                         values->size[1], bytes / 1e9, memory / 1e9);
    return true;
}

static const char *technique_name(const void *user, size_t index)
{
    (void)user;
    const struct pel_technique_info *technique = pel_technique_at(index);
    return technique ? technique->name : NULL;
}

/* The flag's, or the scene's with the options that it names where no flag does. */
static bool choose_technique(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                             struct pel_error *error)
{
    struct pel_technique_choice *choice = &loaded->scene.technique;
    bool from_scene = choice->name[0] && !arguments_given(arguments, "technique");
    const struct pel_technique_info *technique = pel_technique_find(from_scene ? choice->name : values->technique);
    if (technique) {
        loaded->technique = technique->name;
        return scene_merge_technique(technique, arguments, choice, error);
    }
    char known[256] = "";
    for (size_t i = 0; technique_name(NULL, i); i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "", technique_name(NULL, i));
    return tool_fail(error, PEL_ERROR_ARGUMENT, "--technique: there is no %.60s; there are: %s", values->technique, known);
}

/* What the scene and the flags say about the volume itself. */
static void adjust_volume(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values)
{
    struct pel_volume *volume = &loaded->volume;
    pel_source_apply(&loaded->scene.source, volume);
    if (arguments_given(arguments, "labels")) {
        volume->labels = values->labels;
        /* Said in the scene too, so that it survives in a scene file. */
        if (!arguments_given(arguments, "reconstruction"))
            loaded->scene.render.reconstruction = values->labels ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
    }
}

static bool set_light(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values, bool from_file,
                      struct pel_error *error)
{
    struct pel_scene *scene = &loaded->scene;
    if (values->light_count > 0)
        scene->light_count = values->light_count;
    for (int i = 0; i < values->light_count; i++) {
        scene->lights[i] = (struct pel_light) { .headlight = false, .color = { 1, 1, 1 } };
        memcpy(scene->lights[i].direction, values->lights[i], sizeof values->lights[i]);
    }
    if (values->light_color_count > 1 && values->light_color_count != scene->light_count)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--light-color: %d colours for %d lights", values->light_color_count,
                         scene->light_count);
    for (int i = 0; values->light_color_count > 0 && i < scene->light_count; i++)
        memcpy(scene->lights[i].color, values->light_colors[values->light_color_count > 1 ? i : 0], sizeof scene->lights[i].color);
    if (arguments_given(arguments, "linear-light"))
        scene->linear_light = values->linear_light;
    if (arguments_given(arguments, "background")) {
        memcpy(scene->background, values->background, sizeof scene->background);
    } else if (!from_file) {
        double shade = scene->render.mode == PEL_MODE_XRAY && !scene->render.invert;
        memcpy(scene->background, (double[4]) { shade, shade, shade, 1 }, sizeof scene->background);
    }
    return true;
}

static bool set_optics(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                       struct pel_error *error)
{
    struct pel_scene *scene = &loaded->scene;
    if (!arguments_overlay(arguments, GROUP_OPTICS, &scene->render, error))
        return false;
    if (values->isovalues.count > 0)
        scene->render.mode = PEL_MODE_ISOSURFACE;
    if (arguments_given(arguments, "slice"))
        scene->render.mode = PEL_MODE_SLICE;
    return true;
}

static bool find_source(struct pel_source *source, const struct arguments *arguments, const struct scene_arguments *values,
                        const char *path, struct pel_error *error)
{
    if (path) {
        if (strlen(path) >= sizeof source->path)
            return tool_fail(error, PEL_ERROR_ARGUMENT, "the file's path is longer than %zu bytes", sizeof source->path - 1);
        /* Another file than the scene's: what the scene says of it does not apply. */
        if (strcmp(source->path, path) != 0 && !tool_same_file(source->path, path))
            *source = (struct pel_source) { .has_void = false };
        strcpy(source->path, path);
    }
    if (!source->path[0])
        return tool_fail(error, PEL_ERROR_ARGUMENT, "%s: a file name is missing; usage: pellucid %s %s", arguments->command->name,
                         arguments->command->name, arguments->command->usage);
    if (strlen(values->array) >= sizeof source->array || strlen(values->raw) >= sizeof source->raw)
        return tool_fail(error, PEL_ERROR_ARGUMENT, "--array and --raw take at most %zu bytes", sizeof source->array - 1);
    if (arguments_given(arguments, "array"))
        strcpy(source->array, values->array);
    if (arguments_given(arguments, "raw"))
        strcpy(source->raw, values->raw);
    if (arguments_given(arguments, "spacing")) {
        source->has_spacing = true;
        memcpy(source->spacing, values->spacing, sizeof source->spacing);
    }
    if (arguments_given(arguments, "void")) {
        source->has_void = true;
        source->void_value = values->void_value;
    }
    return true;
}

/* Of a scene file: what is wrong is the file. */
static bool check_technique(const struct pel_scene *scene, struct pel_error *error)
{
    if (pel_renderer_take_technique(NULL, &scene->technique, error))
        return true;
    if (error->code == PEL_ERROR_ARGUMENT)
        error->code = PEL_ERROR_FORMAT;
    return false;
}

static bool load(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values, const char *path,
                 struct progress *progress, struct pel_error *error)
{
    struct pel_scene_parts has = { 0 };
    struct pel_scene *scene = &loaded->scene;
    bool from_file = values->scene[0] != 0;
    if (!check_arguments(arguments, values, error))
        return false;
    if (from_file && (!pel_read_scene(values->scene, scene, &has, error) || !check_technique(scene, error)))
        return tool_fail_in(error, values->scene);
    if (!choose_technique(loaded, arguments, values, error) || !scene_check_device(loaded, values, error))
        return false;
    if (!find_source(&scene->source, arguments, values, path, error) || !set_optics(loaded, arguments, values, error))
        return false;
    if (!values->quiet)
        scene_tell_idle(arguments, values, pel_technique_find(loaded->technique), scene->render.mode);
    double start = tool_milliseconds();
    if (!volume_load(scene->source.path, scene->source.array, scene->source.raw, true, progress, values->quiet, &loaded->volume,
                     &loaded->info, error))
        return false;
    loaded->load_ms = tool_milliseconds() - start;
    scene->volume = &loaded->volume;
    adjust_volume(loaded, arguments, values);
    if (!set_light(loaded, arguments, values, from_file, error) || !scene_set_transfer(loaded, arguments, values, &has, error) ||
        !scene_set_surfaces(loaded, arguments, values, &has, error) || !scene_set_camera(loaded, arguments, values, &has, error) ||
        !pel_scene_check(scene, error))
        return false;
    return scene_open_device(loaded, values, error);
}

bool scene_load(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values, const char *path,
                struct progress *progress, struct pel_error *error)
{
    memset(loaded, 0, sizeof *loaded);
    pel_volume_init(&loaded->volume);
    if (!pel_scene_init(&loaded->scene, error))
        return false;
    if (load(loaded, arguments, values, path, progress, error))
        return true;
    scene_unload(loaded);
    return false;
}

void scene_unload(struct loaded_scene *loaded)
{
    pel_device_destroy(loaded->device);
    pel_scene_finish(&loaded->scene);
    pel_volume_finish(&loaded->volume);
}
