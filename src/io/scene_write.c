/* SPDX-License-Identifier: MIT */
/* Scene files out: everything of a scene but the samples, under the keys that scene_read.c reads. */
#include "scene_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "c_locale.h"
#include "fail.h"
#include "json_file.h"
#include "scene_path.h"

/* jansson's "new" calls take a NULL value for a failure, give it up to and return -1: one flag at the end says whether all went well. */
struct writing {
    bool failed;
};

static void put(struct writing *w, json_t *object, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value) != 0)
        w->failed = true;
}

static void add(struct writing *w, json_t *array, json_t *value)
{
    if (json_array_append_new(array, value) != 0)
        w->failed = true;
}

/* NULL where a number is not finite: JSON has no way to say it. */
static json_t *numbers(struct writing *w, const double *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        add(w, array, json_real(values[i]));
    return array;
}

static json_t *numbers_from_text(struct writing *w, const char *text)
{
    json_t *array = json_array();
    for (const char *at = text; *at;) {
        char *end;
        add(w, array, json_real(strtod(at, &end)));
        if (end == at)
            break;
        at = *end == ',' ? end + 1 : end;
    }
    return array;
}

static json_t *option_value(struct writing *w, const struct pel_option *row, const void *object)
{
    char text[PEL_OPTION_TEXT_SIZE];
    pel_option_get(row, object, text, sizeof text);
    switch (row->type) {
    case PEL_OPTION_BOOL:
        return json_boolean(strcmp(text, "true") == 0);
    case PEL_OPTION_INT:
        return json_integer(strtol(text, NULL, 10));
    case PEL_OPTION_DOUBLE:
        return json_real(strtod(text, NULL));
    case PEL_OPTION_VEC2:
    case PEL_OPTION_VEC3:
    case PEL_OPTION_VEC6:
        return numbers_from_text(w, text);
    case PEL_OPTION_CHOICE:
    case PEL_OPTION_COLOR:
    case PEL_OPTION_SIZE:
    case PEL_OPTION_TEXT:
        break;
    }
    return json_string(text);
}

static json_t *options(struct writing *w, const struct pel_option *table, const void *object)
{
    json_t *json = json_object();
    for (const struct pel_option *row = table; row->name; row++)
        put(w, json, row->name, option_value(w, row, object));
    return json;
}

static json_t *transfer(struct writing *w, const struct pel_transfer *t)
{
    json_t *json = json_object(), *colors = json_array(), *opacities = json_array();
    for (size_t i = 0; i < t->color_count; i++) {
        const struct pel_color_point *p = &t->colors[i];
        add(w, colors, numbers(w, (double[]) { p->value, p->rgb[0], p->rgb[1], p->rgb[2] }, 4));
    }
    for (size_t i = 0; i < t->opacity_count; i++)
        add(w, opacities, numbers(w, (double[]) { t->opacities[i].value, t->opacities[i].opacity }, 2));
    if (t->colormap[0])
        put(w, json, "colormap", json_string(t->colormap));
    put(w, json, "unit-distance", json_real(t->unit_distance));
    put(w, json, "colors", colors);
    put(w, json, "opacities", opacities);
    return json;
}

static json_t *plane(struct writing *w, const struct pel_plane *p)
{
    json_t *json = json_object();
    put(w, json, "origin", numbers(w, p->origin, 3));
    put(w, json, "normal", numbers(w, p->normal, 3));
    return json;
}

static json_t *source(struct writing *w, const struct pel_source *s, const char *path, struct pel_error *error)
{
    char relative[PEL_OPTION_TEXT_SIZE];
    if (path && !pel_path_to_file(path, s->path, relative, sizeof relative, error))
        return NULL;
    json_t *json = json_object(), *text = json_string(path ? relative : s->path);
    if (!text)
        pel_fail(error, PEL_ERROR_ARGUMENT, "the volume's path is not UTF-8 text, which JSON needs");
    put(w, json, "path", text);
    if (s->array[0])
        put(w, json, "array", json_string(s->array));
    if (s->raw[0])
        put(w, json, "raw", json_string(s->raw));
    if (s->has_spacing)
        put(w, json, "spacing", numbers(w, s->spacing, 3));
    if (s->has_void)
        put(w, json, "void", json_real(s->void_value));
    return json;
}

static json_t *isosurfaces(struct writing *w, const struct pel_scene *scene)
{
    json_t *array = json_array();
    for (int i = 0; i < scene->isosurface_count; i++) {
        const struct pel_isosurface *s = &scene->isosurfaces[i];
        json_t *json = json_object();
        put(w, json, "value", json_real(s->value));
        put(w, json, "color", numbers(w, s->color, 3));
        put(w, json, "opacity", json_real(s->opacity));
        add(w, array, json);
    }
    return array;
}

static json_t *lights(struct writing *w, const struct pel_scene *scene)
{
    json_t *array = json_array();
    for (int i = 0; i < scene->light_count; i++) {
        const struct pel_light *l = &scene->lights[i];
        json_t *json = json_object();
        put(w, json, "headlight", json_boolean(l->headlight));
        if (!l->headlight)
            put(w, json, "direction", numbers(w, l->direction, 3));
        put(w, json, "color", numbers(w, l->color, 3));
        add(w, array, json);
    }
    return array;
}

/* Numbers and switches as such, everything else as text: what the option's type is is not known here. */
static json_t *value_of_text(const char *text)
{
    char *end;
    double number = strtod(text, &end);
    if (strcmp(text, "true") == 0 || strcmp(text, "false") == 0)
        return json_boolean(text[0] == 't');
    if (!text[0] || *end || !isfinite(number))
        return json_string(text);
    return number == floor(number) && fabs(number) < 1e15 ? json_integer((json_int_t)number) : json_real(number);
}

static json_t *technique(struct writing *w, const struct pel_technique_choice *t)
{
    json_t *json = json_object(), *options_of = json_object();
    put(w, json, "name", json_string(t->name));
    for (int i = 0; i < t->option_count; i++)
        put(w, options_of, t->options[i].name, value_of_text(t->options[i].value));
    put(w, json, "options", options_of);
    return json;
}

/* An object for one, as files of older versions have it. */
static json_t *slices(struct writing *w, const struct pel_scene *scene)
{
    if (scene->more_slice_count == 0)
        return plane(w, &scene->slice);
    json_t *array = json_array();
    add(w, array, plane(w, &scene->slice));
    for (int i = 0; i < scene->more_slice_count; i++)
        add(w, array, plane(w, &scene->more_slices[i]));
    return array;
}

json_t *pel_scene_to_json(const struct pel_scene *scene, const char *path, struct pel_error *error)
{
    struct writing w = { false };
    json_t *root = json_object(), *planes = json_array();
    pel_fail(error, PEL_ERROR_ARGUMENT, "a number of the scene is not finite, or a text of it is not UTF-8");
    put(&w, root, "pellucid-scene", json_integer(1));
    if (scene->source.path[0])
        put(&w, root, "volume", source(&w, &scene->source, path, error));
    put(&w, root, "transfer", transfer(&w, &scene->transfer));
    put(&w, root, "camera", options(&w, pel_camera_options, &scene->camera));
    put(&w, root, "render", options(&w, pel_render_options, &scene->render));
    if (scene->technique.name[0])
        put(&w, root, "technique", technique(&w, &scene->technique));
    if (scene->isosurface_count)
        put(&w, root, "isosurfaces", isosurfaces(&w, scene));
    const double *n = scene->slice.normal;
    if (n[0] != 0 || n[1] != 0 || n[2] != 0) /* zero: no slice was chosen */
        put(&w, root, "slice", slices(&w, scene));
    put(&w, root, "lights", lights(&w, scene));
    for (int i = 0; i < scene->clip_plane_count; i++)
        add(&w, planes, plane(&w, &scene->clip_planes[i]));
    put(&w, root, "clip-planes", planes);
    put(&w, root, "clip-box", scene->clip_box_enabled ? numbers(&w, scene->clip_box, 6) : json_null());
    put(&w, root, "background", numbers(&w, scene->background, 4));
    put(&w, root, "linear-light", json_boolean(scene->linear_light));
    if (w.failed) {
        json_decref(root);
        return NULL;
    }
    return root;
}

char *pel_scene_to_text(const struct pel_scene *scene, const char *path, struct pel_error *error)
{
    struct pel_error why = PEL_ERROR_INIT;
    json_t *root = pel_scene_to_json(scene, path, &why);
    char *text = root ? pel_json_to_text(root, &why) : NULL;
    json_decref(root);
    if (!text && error)
        *error = why;
    return text;
}

bool pel_write_scene(const char *path, const struct pel_scene *scene, struct pel_error *error)
{
    struct pel_error why = PEL_ERROR_INIT;
    const struct pel_c_locale locale = pel_c_locale_begin();
    json_t *root = pel_scene_to_json(scene, path, &why);
    bool ok = root && pel_json_write(path, root, &why);
    pel_c_locale_end(&locale);
    json_decref(root);
    if (ok)
        return true;
    if (error)
        *error = why;
    return pel_fail_in(error, "%s: ", path);
}
