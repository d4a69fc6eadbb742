/* SPDX-License-Identifier: MIT */
#include "scene_reading.h"

#include <stdio.h>
#include <string.h>

#include "fail.h"
#include "json_file.h"

size_t pel_scene_enter(struct pel_scene_reading *r, const char *key)
{
    size_t length = strlen(r->where);
    snprintf(r->where + length, sizeof r->where - length, "%s%.60s", length ? "." : "", key);
    return length;
}

size_t pel_scene_enter_entry(struct pel_scene_reading *r, size_t index)
{
    size_t length = strlen(r->where);
    snprintf(r->where + length, sizeof r->where - length, "[%zu]", index);
    return length;
}

void pel_scene_leave(struct pel_scene_reading *r, size_t length)
{
    r->where[length] = 0;
}

bool pel_scene_read_object(struct pel_scene_reading *r, const json_t *value, const struct pel_scene_key *keys, void *object)
{
    const char *name;
    json_t *member;
    if (!json_is_object(value))
        return pel_fail(r->error, PEL_ERROR_FORMAT, "expected an object, found %s", pel_json_kind(value));
    json_object_foreach((json_t *)value, name, member)
    {
        const struct pel_scene_key *key = keys;
        while (key->name && strcmp(key->name, name) != 0)
            key++;
        size_t back = pel_scene_enter(r, name);
        if (!key->name)
            return pel_fail(r->error, PEL_ERROR_FORMAT, "there is no such key");
        if (!key->read(r, member, (char *)object + key->offset))
            return false;
        pel_scene_leave(r, back);
    }
    return true;
}

bool pel_scene_check_array(struct pel_scene_reading *r, const json_t *value, size_t most)
{
    if (!json_is_array(value))
        return pel_fail(r->error, PEL_ERROR_FORMAT, "expected an array, found %s", pel_json_kind(value));
    if (json_array_size(value) > most)
        return pel_fail(r->error, PEL_ERROR_FORMAT, "%zu entries; at most %zu are allowed", json_array_size(value), most);
    return true;
}

bool pel_scene_value_text(struct pel_scene_reading *r, const json_t *value, char *text, size_t size)
{
    size_t used = 0;
    text[0] = 0;
    switch (json_typeof(value)) {
    case JSON_STRING:
        return pel_json_text(value, text, size, r->error);
    case JSON_TRUE:
    case JSON_FALSE:
        snprintf(text, size, json_is_true(value) ? "true" : "false");
        return true;
    case JSON_INTEGER:
        snprintf(text, size, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
        return true;
    case JSON_REAL:
        snprintf(text, size, "%.17g", json_real_value(value));
        return true;
    case JSON_ARRAY:
        for (size_t i = 0; i < json_array_size(value); i++) {
            double number;
            if (i >= 16)
                return pel_fail(r->error, PEL_ERROR_FORMAT, "%zu entries are too many", json_array_size(value));
            if (!pel_json_number(json_array_get(value, i), &number, r->error))
                return false;
            used += (size_t)snprintf(text + used, size - used, "%s%.17g", i ? "," : "", number);
        }
        return true;
    case JSON_OBJECT:
    case JSON_NULL:
        break;
    }
    return pel_fail(r->error, PEL_ERROR_FORMAT, "expected a value, found %s", pel_json_kind(value));
}

static bool read_option(struct pel_scene_reading *r, const json_t *value, const struct pel_option *row, void *object)
{
    char text[PEL_OPTION_TEXT_SIZE];
    return pel_scene_value_text(r, value, text, sizeof text) && pel_option_set(row, object, text, r->error);
}

bool pel_scene_read_options(struct pel_scene_reading *r, const json_t *value, const struct pel_option *table, void *object)
{
    const char *name;
    json_t *member;
    if (!json_is_object(value))
        return pel_fail(r->error, PEL_ERROR_FORMAT, "expected an object, found %s", pel_json_kind(value));
    json_object_foreach((json_t *)value, name, member)
    {
        const struct pel_option *row = pel_option_find(table, name);
        size_t back = pel_scene_enter(r, name);
        if (!row)
            return pel_fail(r->error, PEL_ERROR_FORMAT, "there is no such key");
        if (!read_option(r, member, row, object))
            return false;
        pel_scene_leave(r, back);
    }
    return true;
}
