/* SPDX-License-Identifier: MIT */
/* What the session tells its clients beside pictures. All with the lock held. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "record.h"
#include "session_inside.h"

static void send_text(struct session *s, int client, char *text)
{
    if (text && s->params.event)
        s->params.event(s->params.user, client, text);
    free(text);
}

static void put_id(json_t *event, const struct call *call)
{
    if (call && call->has_id)
        json_object_set_new(event, "id", json_integer(call->id));
}

void session_tell(struct session *s, int client, json_t *event, const struct call *call)
{
    put_id(event, call);
    send_text(s, client, json_dumps(event, JSON_COMPACT | JSON_REAL_PRECISION(17)));
    json_decref(event);
}

bool session_is_text(const char *text)
{
    json_t *string = json_string(text);
    json_decref(string);
    return string;
}

/* Text of a refused command may be cut within a character: what is no UTF-8 becomes a question mark. */
static json_t *json_words(const char *text)
{
    char safe[sizeof((struct pel_error *)0)->message + 1] = "";
    json_t *string = json_string(text);
    for (size_t i = 0; !string && text[i] && i + 1 < sizeof safe; i++)
        safe[i] = (unsigned char)text[i] < 128 ? text[i] : '?';
    return string ? string : json_string(safe);
}

void session_tell_error(struct session *s, int client, const struct pel_error *error, const struct call *call)
{
    json_t *event = json_pack("{s:s, s:o}", "event", "error", "message", json_words(error->message));
    const char *code = call && call->nothing ? "nothing" : error->code == PEL_ERROR_CANCELLED ? "cancelled" : NULL;
    if (code)
        json_object_set_new(event, "code", json_string(code));
    if (s->params.record)
        record_error(s->params.record, session_now() - s->started_ms, client,
                     call && call->name && session_is_text(call->name) ? call->name : "");
    if (call && call->name)
        json_object_set_new(event, "do", json_words(call->name));
    session_tell(s, client, event, call);
}

void session_tell_progress(struct session *s, int client, const char *what, double done)
{
    session_tell(s, client, json_pack("{s:s, s:s, s:f}", "event", "progress", "what", what, "done", done), NULL);
}

void session_offer(struct session *s, int client, int fd, const char *name, const char *type, const struct call *call)
{
    const struct download *entry = downloads_add(&s->downloads, fd, name, type, session_now());
    char url[32];
    snprintf(url, sizeof url, "download/%u", entry->number);
    session_tell(s, client,
                 json_pack("{s:s, s:s, s:s, s:I, s:s}", "event", "download", "name", name, "url", url, "bytes", (json_int_t)entry->bytes,
                           "type", type),
                 call);
}

/* What JSON cannot say is null. */
static json_t *real(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *session_numbers(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, real(values[i]));
    return list;
}

/* ---- option rows ---- */

static const char *type_name(enum pel_option_type type)
{
    static const char *const names[] = { "bool", "int", "double", "choice", "vec2", "vec3", "vec6", "color", "size", "text" };
    return names[type];
}

/* A value as text, as JSON: numbers and switches as such. */
static json_t *typed(enum pel_option_type type, const char *text)
{
    json_t *list;
    switch (type) {
    case PEL_OPTION_BOOL:
        return json_boolean(strcmp(text, "true") == 0);
    case PEL_OPTION_INT:
        return json_integer(strtol(text, NULL, 10));
    case PEL_OPTION_DOUBLE:
        return real(strtod(text, NULL));
    case PEL_OPTION_VEC2:
    case PEL_OPTION_VEC3:
    case PEL_OPTION_VEC6:
        list = json_array();
        for (char *end; *text; text = *end == ',' ? end + 1 : end) {
            json_array_append_new(list, real(strtod(text, &end)));
            if (end == text)
                break;
        }
        return list;
    case PEL_OPTION_CHOICE:
    case PEL_OPTION_COLOR:
    case PEL_OPTION_SIZE:
    case PEL_OPTION_TEXT:
        break;
    }
    return json_string(text);
}

static json_t *row_json(const struct pel_option *row)
{
    bool ranged = row->type == PEL_OPTION_INT || row->type == PEL_OPTION_DOUBLE;
    json_t *choices = row->choices ? json_array() : json_null();
    for (int i = 0; row->choices && row->choices[i]; i++)
        json_array_append_new(choices, json_string(row->choices[i]));
    return json_pack("{s:s, s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:s?}", "name", row->name, "label", row->label, "help", row->help, "type",
                     type_name(row->type), "minimum", ranged ? real(row->minimum) : json_null(), "maximum",
                     ranged ? real(row->maximum) : json_null(), "default", row->fallback ? typed(row->type, row->fallback) : json_null(),
                     "choices", choices, "unit", row->unit);
}

static json_t *rows_json(const struct pel_option *rows)
{
    json_t *list = json_array();
    for (; rows->name; rows++)
        json_array_append_new(list, row_json(rows));
    return list;
}

json_t *session_camera_json(const struct pel_camera *camera)
{
    json_t *object = json_object();
    char text[PEL_OPTION_TEXT_SIZE];
    for (const struct pel_option *row = pel_camera_options; row->name; row++) {
        pel_option_get(row, camera, text, sizeof text);
        json_object_set_new(object, row->name, typed(row->type, text));
    }
    return object;
}

/* ---- hello ---- */

static json_t *techniques_json(void)
{
    json_t *list = json_array();
    const struct pel_technique_info *t;
    for (size_t i = 0; (t = pel_technique_at(i)); i++) {
        json_t *engines = json_array();
        if (t->engines & PEL_ENGINE_CPU)
            json_array_append_new(engines, json_string("cpu"));
        if (t->engines & PEL_ENGINE_GPU)
            json_array_append_new(engines, json_string("gpu"));
        json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:o}", "name", t->name, "summary", t->summary, "engines", engines, "options",
                                              rows_json(t->options)));
    }
    return list;
}

static json_t *colormaps_json(void)
{
    enum { COLORS = 32 };
    json_t *list = json_array();
    const char *name;
    for (size_t i = 0; (name = pel_colormap_name(i)); i++) {
        json_t *colors = json_array();
        for (int k = 0; k < COLORS; k++) {
            double rgb[3] = { 0, 0, 0 };
            char text[8];
            pel_colormap_lookup(name, (double)k / (COLORS - 1), rgb);
            snprintf(text, sizeof text, "#%02x%02x%02x", (int)lround(255 * rgb[0]) & 255, (int)lround(255 * rgb[1]) & 255,
                     (int)lround(255 * rgb[2]) & 255);
            json_array_append_new(colors, json_string(text));
        }
        json_array_append_new(list, json_pack("{s:s, s:o}", "name", name, "colors", colors));
    }
    return list;
}

void session_tell_hello(struct session *s, int client, const struct call *call)
{
    json_t *folders = json_array();
    for (int i = 0; s->paths && s->paths[i]; i++)
        json_array_append_new(folders, json_words(s->paths[i]));
    session_tell(s, client,
                 json_pack("{s:s, s:b, s:s, s:o, s:{s:o, s:o}, s:o, s:o, s:o, s:f, s:o}", "event", "hello", "empty",
                           (int)(!s->volume && !s->opening), "version", pel_version(), "techniques", techniques_json(), "options", "render",
                           rows_json(pel_render_options), "camera", rows_json(pel_camera_options), "colormaps", colormaps_json(), "device",
                           session_device_json(s), "devices", session_devices_json(s), "budget_ms", s->params.budget_ms, "folders",
                           folders),
                 call);
}

/* ---- the volume and the state ---- */

static json_t *arrays_json(const struct pel_file_info *info)
{
    json_t *list = json_array();
    for (int i = 0; i < info->array_count; i++)
        json_array_append_new(list, json_pack("{s:o, s:s, s:i}", "name", json_words(info->arrays[i].name), "type",
                                              pel_type_name(info->arrays[i].type), "components", info->arrays[i].components));
    return list;
}

void session_tell_volume(struct session *s, int client)
{
    const struct session_volume *v = s->volume;
    const struct pel_volume *volume = &v->volume;
    double matrix[4][4] = { [3] = { 0, 0, 0, 1 } }, bounds[6];
    json_t *notes = json_array();
    pel_volume_matrix(volume, matrix);
    pel_volume_bounds(volume, bounds);
    for (int i = 0; i < v->info.note_count; i++)
        json_array_append_new(notes, json_words(v->info.notes[i]));
    session_tell(s, client,
                 json_pack("{s:s, s:o, s:o, s:[I, I, I], s:o, s:o, s:s, s:o, s:o, s:o, s:s, s:b, s:O, s:o, s:o, s:o}", "event", "volume",
                           "name", json_words(volume->name), "path", json_words(s->scene.source.path), "dims", (json_int_t)volume->dims[0],
                           (json_int_t)volume->dims[1], (json_int_t)volume->dims[2], "spacing", session_numbers(volume->spacing, 3),
                           "units", json_words(volume->units), "type", pel_type_name(volume->type), "range",
                           session_numbers(volume->range, 2), "bounds", session_numbers(bounds, 6), "index_to_world",
                           session_numbers(&matrix[0][0], 16), "space", pel_space_name(volume->space), "labels", (int)volume->labels,
                           "histogram", v->histogram ? v->histogram : json_null(), "arrays", arrays_json(&v->info), "array",
                           json_words(s->scene.source.array), "notes", notes),
                 NULL);
}

void session_tell_state(struct session *s, int client)
{
    char *scene = pel_scene_to_text(&s->scene, NULL, NULL), *text = NULL;
    if (scene &&
        asprintf(&text, "{\"event\": \"state\", \"undo\": %d, \"redo\": %d, \"size\": [%d, %d], \"held\": %s, \"scene\": %s}",
                 s->history.undo.count, s->history.redo.count, s->size[0], s->size[1], session_held(s) ? "true" : "false", scene) < 0)
        text = NULL;
    free(scene);
    send_text(s, client, text);
}
