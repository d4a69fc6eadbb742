/* SPDX-License-Identifier: MIT */
/* Scene files in. Each part of a scene is an object or an array under its own key, and each key has a row in a table with the function that
 * reads it; a key that is in no table is refused by name, so that a misspelt one cannot pass for a default. `where` follows the reader down
 * the file and stands where something failed. The scene changes only when all of it was read. */
#include "scene_file.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "json_file.h"
#include "scene_path.h"
#include "scene_reading.h"

/* ---- single values ---- */

static bool read_number(struct pel_scene_reading *r, const json_t *value, void *out)
{
    return pel_json_number(value, out, r->error);
}

static bool read_bool(struct pel_scene_reading *r, const json_t *value, void *out)
{
    return pel_json_bool(value, out, r->error);
}

static bool read_vector(struct pel_scene_reading *r, const json_t *value, void *out)
{
    return pel_json_numbers(value, 3, out, r->error);
}

static bool check_fractions(struct pel_scene_reading *r, const double *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!(values[i] >= 0 && values[i] <= 1))
            return pel_fail(r->error, PEL_ERROR_FORMAT, "%g is outside 0..1", values[i]);
    return true;
}

static bool read_fraction(struct pel_scene_reading *r, const json_t *value, void *out)
{
    return pel_json_number(value, out, r->error) && check_fractions(r, out, 1);
}

static bool read_color(struct pel_scene_reading *r, const json_t *value, void *out)
{
    return pel_json_numbers(value, 3, out, r->error) && check_fractions(r, out, 3);
}

/* A direction: anything but zero. */
static bool read_normal(struct pel_scene_reading *r, const json_t *value, void *out)
{
    const double *v = out;
    if (!pel_json_numbers(value, 3, out, r->error))
        return false;
    return v[0] != 0 || v[1] != 0 || v[2] != 0 || pel_fail(r->error, PEL_ERROR_FORMAT, "a zero vector has no direction");
}

/* ---- transfer function ---- */

static bool read_colors(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_transfer *transfer = object;
    if (!pel_scene_check_array(r, value, SIZE_MAX))
        return false;
    size_t count = json_array_size(value);
    struct pel_color_point *points = pel_alloc(count, sizeof *points, "color curve", r->error);
    bool ok = points != NULL;
    for (size_t i = 0; ok && i < count; i++) {
        double n[4];
        size_t back = pel_scene_enter_entry(r, i);
        ok = pel_json_numbers(json_array_get(value, i), 4, n, r->error);
        if (ok) {
            points[i] = (struct pel_color_point) { n[0], { n[1], n[2], n[3] } };
            pel_scene_leave(r, back);
        }
    }
    ok = ok && pel_transfer_set_colors(transfer, points, count, r->error);
    free(points);
    r->has.transfer = r->has.colors = true;
    return ok;
}

static bool read_opacities(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_transfer *transfer = object;
    if (!pel_scene_check_array(r, value, SIZE_MAX))
        return false;
    size_t count = json_array_size(value);
    struct pel_opacity_point *points = pel_alloc(count, sizeof *points, "opacity curve", r->error);
    bool ok = points != NULL;
    for (size_t i = 0; ok && i < count; i++) {
        double n[2];
        size_t back = pel_scene_enter_entry(r, i);
        ok = pel_json_numbers(json_array_get(value, i), 2, n, r->error);
        if (ok) {
            points[i] = (struct pel_opacity_point) { n[0], n[1] };
            pel_scene_leave(r, back);
        }
    }
    ok = ok && pel_transfer_set_opacities(transfer, points, count, r->error);
    free(points);
    r->has.transfer = r->has.opacities = true;
    return ok;
}

static bool read_unit_distance(struct pel_scene_reading *r, const json_t *value, void *object)
{
    double *unit = &((struct pel_transfer *)object)->unit_distance;
    if (!pel_json_number(value, unit, r->error))
        return false;
    r->has.transfer = r->has.unit_distance = true;
    return *unit > 0 || pel_fail(r->error, PEL_ERROR_FORMAT, "%g is not above 0", *unit);
}

static bool read_nothing(struct pel_scene_reading *r, const json_t *value, void *object)
{
    (void)r, (void)value, (void)object;
    return true;
}

/* "colormap" names where "colors" came from, or with "range" stands for them. Neither says anything without the others. */
static bool read_colormap(struct pel_scene_reading *r, const json_t *object)
{
    const json_t *map = json_object_get(object, "colormap"), *range = json_object_get(object, "range");
    struct pel_transfer *transfer = &r->scene.transfer;
    char name[sizeof transfer->colormap];
    double ends[2];
    if (!map && !range)
        return true;
    size_t back = pel_scene_enter(r, map ? "colormap" : "range");
    if (!map)
        return pel_fail(r->error, PEL_ERROR_FORMAT, "a range needs a colormap to stretch over it");
    if (!pel_json_text(map, name, sizeof name, r->error))
        return false;
    if (json_object_get(object, "colors")) {
        if (range)
            return pel_fail(r->error, PEL_ERROR_FORMAT, "colors and range cannot both say where the colors lie");
        memcpy(transfer->colormap, name, sizeof name);
    } else {
        if (!range)
            return pel_fail(r->error, PEL_ERROR_FORMAT, "a colormap needs a range [lo, hi] to be stretched over");
        pel_scene_leave(r, back);
        back = pel_scene_enter(r, "range");
        if (!pel_json_numbers(range, 2, ends, r->error))
            return false;
        pel_scene_leave(r, back);
        back = pel_scene_enter(r, "colormap");
        if (!pel_transfer_set_colormap(transfer, name, ends[0], ends[1], r->error))
            return false;
        r->has.transfer = r->has.colors = true;
    }
    pel_scene_leave(r, back);
    return true;
}

static bool read_transfer(struct pel_scene_reading *r, const json_t *value, void *object)
{
    static const struct pel_scene_key keys[] = {
        { "colors", read_colors, 0 },    { "opacities", read_opacities, 0 }, { "unit-distance", read_unit_distance, 0 },
        { "colormap", read_nothing, 0 }, { "range", read_nothing, 0 },       { NULL },
    };
    return pel_scene_read_object(r, value, keys, object) && read_colormap(r, value);
}

/* ---- the other parts ---- */

static bool read_camera(struct pel_scene_reading *r, const json_t *value, void *object)
{
    r->has.camera = true;
    return pel_scene_read_options(r, value, pel_camera_options, object) && pel_camera_check(object, r->error);
}

static bool read_render(struct pel_scene_reading *r, const json_t *value, void *object)
{
    return pel_scene_read_options(r, value, pel_render_options, object);
}

static bool read_path(struct pel_scene_reading *r, const json_t *value, void *out)
{
    char text[PEL_OPTION_TEXT_SIZE];
    if (!r->path)
        return pel_json_text(value, out, PEL_OPTION_TEXT_SIZE, r->error);
    return pel_json_text(value, text, sizeof text, r->error) && pel_path_from_file(r->path, text, out, PEL_OPTION_TEXT_SIZE, r->error);
}

static bool read_short_text(struct pel_scene_reading *r, const json_t *value, void *out)
{
    return pel_json_text(value, out, sizeof((struct pel_source *)0)->array, r->error);
}

static bool read_source_spacing(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_source *source = object;
    if (!read_vector(r, value, source->spacing))
        return false;
    for (int i = 0; i < 3; i++)
        if (!(source->spacing[i] >= PEL_LEAST_SPACING && source->spacing[i] <= PEL_MOST_SPACING))
            return pel_fail(r->error, PEL_ERROR_FORMAT, "%g is outside %g..%g", source->spacing[i], PEL_LEAST_SPACING, PEL_MOST_SPACING);
    source->has_spacing = true;
    return true;
}

static bool read_source_void(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_source *source = object;
    source->has_void = true;
    return read_number(r, value, &source->void_value);
}

static bool read_source(struct pel_scene_reading *r, const json_t *value, void *object)
{
    static const struct pel_scene_key keys[] = {
        { "path", read_path, offsetof(struct pel_source, path) },
        { "array", read_short_text, offsetof(struct pel_source, array) },
        { "raw", read_short_text, offsetof(struct pel_source, raw) },
        { "spacing", read_source_spacing, 0 },
        { "void", read_source_void, 0 },
        { NULL },
    };
    *(struct pel_source *)object = (struct pel_source) { .path = "" };
    return pel_scene_read_object(r, value, keys, object);
}

static bool read_plane(struct pel_scene_reading *r, const json_t *value, void *object)
{
    static const struct pel_scene_key keys[] = {
        { "origin", read_vector, offsetof(struct pel_plane, origin) },
        { "normal", read_normal, offsetof(struct pel_plane, normal) },
        { NULL },
    };
    return pel_scene_read_object(r, value, keys, object);
}

/* One plane, or a list of planes that are in one picture. */
static bool read_slice(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_scene *scene = object;
    r->has.slice = true;
    scene->more_slice_count = 0;
    if (!json_is_array(value))
        return read_plane(r, value, &scene->slice);
    if (!pel_scene_check_array(r, value, PEL_MAX_SLICES))
        return false;
    size_t count = json_array_size(value);
    for (size_t i = 0; i < count; i++) {
        struct pel_plane *plane = i ? &scene->more_slices[i - 1] : &scene->slice;
        size_t back = pel_scene_enter_entry(r, i);
        *plane = (struct pel_plane) { { 0, 0, 0 }, { 0, 0, 1 } };
        if (!read_plane(r, json_array_get(value, i), plane))
            return false;
        pel_scene_leave(r, back);
    }
    scene->more_slice_count = count ? (int)count - 1 : 0;
    return count > 0 || pel_fail(r->error, PEL_ERROR_FORMAT, "an empty list; name a plane at least");
}

static bool read_clip_planes(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_scene *scene = object;
    if (!pel_scene_check_array(r, value, PEL_MAX_CLIP_PLANES))
        return false;
    for (size_t i = 0; i < json_array_size(value); i++) {
        size_t back = pel_scene_enter_entry(r, i);
        scene->clip_planes[i] = (struct pel_plane) { { 0, 0, 0 }, { 0, 0, 1 } };
        if (!read_plane(r, json_array_get(value, i), &scene->clip_planes[i]))
            return false;
        pel_scene_leave(r, back);
    }
    scene->clip_plane_count = (int)json_array_size(value);
    return true;
}

static bool read_clip_box(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_scene *scene = object;
    scene->clip_box_enabled = !json_is_null(value);
    return !scene->clip_box_enabled || pel_json_numbers(value, 6, scene->clip_box, r->error);
}

static bool read_isosurfaces(struct pel_scene_reading *r, const json_t *value, void *object)
{
    static const struct pel_scene_key keys[] = {
        { "value", read_number, offsetof(struct pel_isosurface, value) },
        { "color", read_color, offsetof(struct pel_isosurface, color) },
        { "opacity", read_fraction, offsetof(struct pel_isosurface, opacity) },
        { NULL },
    };
    struct pel_scene *scene = object;
    if (!pel_scene_check_array(r, value, PEL_MAX_ISOSURFACES))
        return false;
    for (size_t i = 0; i < json_array_size(value); i++) {
        const json_t *entry = json_array_get(value, i);
        size_t back = pel_scene_enter_entry(r, i);
        scene->isosurfaces[i] = (struct pel_isosurface) { 0, { 1, 1, 1 }, 1 };
        if (!pel_scene_read_object(r, entry, keys, &scene->isosurfaces[i]))
            return false;
        if (!json_object_get(entry, "value"))
            return pel_fail(r->error, PEL_ERROR_FORMAT, "an isosurface needs a value");
        pel_scene_leave(r, back);
    }
    scene->isosurface_count = (int)json_array_size(value);
    r->has.isosurfaces = scene->isosurface_count > 0;
    return true;
}

static bool read_lights(struct pel_scene_reading *r, const json_t *value, void *object)
{
    static const struct pel_scene_key keys[] = {
        { "headlight", read_bool, offsetof(struct pel_light, headlight) },
        { "direction", read_normal, offsetof(struct pel_light, direction) },
        { "color", read_color, offsetof(struct pel_light, color) },
        { NULL },
    };
    struct pel_scene *scene = object;
    if (!pel_scene_check_array(r, value, PEL_MAX_LIGHTS))
        return false;
    for (size_t i = 0; i < json_array_size(value); i++) {
        const json_t *entry = json_array_get(value, i);
        size_t back = pel_scene_enter_entry(r, i);
        scene->lights[i] = (struct pel_light) { !json_object_get(entry, "direction"), { 0, 0, 1 }, { 1, 1, 1 } };
        if (!pel_scene_read_object(r, entry, keys, &scene->lights[i]))
            return false;
        pel_scene_leave(r, back);
    }
    scene->light_count = (int)json_array_size(value);
    return true;
}

static bool read_background(struct pel_scene_reading *r, const json_t *value, void *out)
{
    double *rgba = out;
    rgba[3] = 1;
    size_t count = json_is_array(value) && json_array_size(value) == 3 ? 3 : 4;
    return pel_json_numbers(value, count, rgba, r->error) && check_fractions(r, rgba, 4);
}

/* Text that fits; which options a technique has is not known here. */
static bool read_technique_options(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_technique_choice *choice = object;
    const char *name;
    json_t *member;
    if (!json_is_object(value))
        return pel_fail(r->error, PEL_ERROR_FORMAT, "expected an object, found %s", pel_json_kind(value));
    json_object_foreach((json_t *)value, name, member)
    {
        size_t back = pel_scene_enter(r, name), i = (size_t)choice->option_count;
        char text[PEL_OPTION_TEXT_SIZE];
        if (i == PEL_MAX_TECHNIQUE_OPTIONS || strlen(name) >= sizeof choice->options[i].name)
            return pel_fail(r->error, PEL_ERROR_FORMAT, "there is no such key");
        if (!pel_scene_value_text(r, member, text, sizeof text))
            return false;
        if (strlen(text) >= sizeof choice->options[i].value)
            return pel_fail(r->error, PEL_ERROR_FORMAT, "the value is longer than %zu bytes", sizeof choice->options[i].value - 1);
        strcpy(choice->options[i].name, name);
        strcpy(choice->options[i].value, text);
        choice->option_count++;
        pel_scene_leave(r, back);
    }
    return true;
}

static bool read_technique_name(struct pel_scene_reading *r, const json_t *value, void *object)
{
    struct pel_technique_choice *choice = object;
    return pel_json_text(value, choice->name, sizeof choice->name, r->error);
}

static bool read_technique(struct pel_scene_reading *r, const json_t *value, void *object)
{
    static const struct pel_scene_key keys[] = { { "name", read_technique_name, 0 }, { "options", read_technique_options, 0 }, { NULL } };
    struct pel_technique_choice *choice = object;
    memset(choice, 0, sizeof *choice);
    if (!pel_scene_read_object(r, value, keys, choice))
        return false;
    return choice->name[0] || pel_fail(r->error, PEL_ERROR_FORMAT, "the technique's name is missing");
}

static bool read_version(struct pel_scene_reading *r, const json_t *value, void *object)
{
    (void)object;
    double version;
    if (!pel_json_number(value, &version, r->error))
        return false;
    return version == 1 || pel_fail(r->error, PEL_ERROR_UNSUPPORTED, "version %g is not known; this program reads version 1", version);
}

static const struct pel_scene_key scene_keys[] = {
    { "pellucid-scene", read_version, 0 },
    { "volume", read_source, offsetof(struct pel_scene, source) },
    { "transfer", read_transfer, offsetof(struct pel_scene, transfer) },
    { "camera", read_camera, offsetof(struct pel_scene, camera) },
    { "render", read_render, offsetof(struct pel_scene, render) },
    { "isosurfaces", read_isosurfaces, 0 },
    { "slice", read_slice, 0 },
    { "lights", read_lights, 0 },
    { "technique", read_technique, offsetof(struct pel_scene, technique) },
    { "clip-planes", read_clip_planes, 0 },
    { "clip-box", read_clip_box, 0 },
    { "background", read_background, offsetof(struct pel_scene, background) },
    { "linear-light", read_bool, offsetof(struct pel_scene, linear_light) },
    { NULL },
};

bool pel_scene_from_text(const char *text, size_t size, const char *path, struct pel_scene *scene, struct pel_scene_parts *has,
                         struct pel_error *error)
{
    json_t *root = pel_json_parse(text, size, error);
    if (!root)
        return false;
    struct pel_scene_reading *r = pel_alloc(1, sizeof *r, "scene", error);
    bool ok = false;
    if (!r)
        goto done;
    r->scene = *scene;
    r->scene.transfer = (struct pel_transfer) { 0 };
    r->path = path;
    r->error = error;
    if (!pel_transfer_copy(&r->scene.transfer, &scene->transfer, error))
        goto done;
    ok = pel_scene_read_object(r, root, scene_keys, &r->scene);
    if (ok) {
        pel_transfer_finish(&scene->transfer);
        *scene = r->scene;
        if (has)
            *has = r->has;
    } else {
        pel_transfer_finish(&r->scene.transfer);
        if (r->where[0])
            pel_fail_in(error, "%s: ", r->where);
        if (error && error->code == PEL_ERROR_ARGUMENT) /* in a file it is the file that is wrong */
            error->code = PEL_ERROR_FORMAT;
    }
done:
    free(r);
    json_decref(root);
    return ok;
}

bool pel_read_scene(const char *path, struct pel_scene *scene, struct pel_scene_parts *has, struct pel_error *error)
{
    size_t size;
    char *text = pel_text_file_read(path, &size, error);
    bool ok = text && pel_scene_from_text(text, size, path, scene, has, error);
    free(text);
    return ok || pel_fail_in(error, "%s: ", path);
}
