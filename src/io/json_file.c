/* SPDX-License-Identifier: MIT */
#include "json_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "safe_file.h"

enum { MOST_BYTES = 16 << 20, MOST_DEPTH = 32 };

char *pel_text_file_read(const char *path, size_t *size, struct pel_error *error)
{
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    size_t used = 0, room = 0, got;
    if (!file) {
        pel_fail_errno(error, "cannot be opened");
        return NULL;
    }
    do { /* a pipe has no length to ask for */
        if (used + 1 >= room) {
            room = room ? room * 2 : 65536;
            char *larger = realloc(text, room);
            if (!larger) {
                pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu bytes", room);
                goto failed;
            }
            text = larger;
        }
        got = fread(text + used, 1, room - used - 1, file);
        used += got;
        if (used > MOST_BYTES) {
            pel_fail(error, PEL_ERROR_FORMAT, "is longer than %d MiB", MOST_BYTES >> 20);
            goto failed;
        }
    } while (got > 0);
    if (ferror(file)) {
        pel_fail_errno(error, "cannot be read");
        goto failed;
    }
    fclose(file);
    text[used] = 0;
    *size = used;
    return text;

failed:
    free(text);
    fclose(file);
    return NULL;
}

json_t *pel_json_parse(const char *text, size_t size, struct pel_error *error)
{
    json_error_t e;
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &e);
    if (!root)
        pel_fail(error, PEL_ERROR_FORMAT, "line %d, column %d: %s", e.line, e.column, e.text);
    return root;
}

const char *pel_json_kind(const json_t *value)
{
    if (!value)
        return "nothing";
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "an array";
    case JSON_STRING:
        return "a string";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
    case JSON_FALSE:
        return "true or false";
    case JSON_NULL:
        return "null";
    }
    return "something else";
}

static bool fail_kind(const json_t *value, const char *wanted, struct pel_error *error)
{
    return pel_fail(error, PEL_ERROR_FORMAT, "expected %s, found %s", wanted, pel_json_kind(value));
}

bool pel_json_number(const json_t *value, double *out, struct pel_error *error)
{
    if (!json_is_number(value))
        return fail_kind(value, "a number", error);
    *out = json_number_value(value);
    return true;
}

bool pel_json_numbers(const json_t *value, size_t count, double *out, struct pel_error *error)
{
    if (!json_is_array(value))
        return pel_fail(error, PEL_ERROR_FORMAT, "expected an array of %zu numbers, found %s", count, pel_json_kind(value));
    if (json_array_size(value) != count)
        return pel_fail(error, PEL_ERROR_FORMAT, "expected %zu numbers, found %zu", count, json_array_size(value));
    for (size_t i = 0; i < count; i++)
        if (!json_is_number(json_array_get(value, i)))
            return pel_fail(error, PEL_ERROR_FORMAT, "entry %zu: expected a number, found %s", i + 1,
                            pel_json_kind(json_array_get(value, i)));
    for (size_t i = 0; i < count; i++)
        out[i] = json_number_value(json_array_get(value, i));
    return true;
}

bool pel_json_bool(const json_t *value, bool *out, struct pel_error *error)
{
    if (!json_is_boolean(value))
        return fail_kind(value, "true or false", error);
    *out = json_is_true(value);
    return true;
}

bool pel_json_text(const json_t *value, char *out, size_t size, struct pel_error *error)
{
    if (!json_is_string(value))
        return fail_kind(value, "a string", error);
    size_t length = json_string_length(value);
    if (length >= size)
        return pel_fail(error, PEL_ERROR_FORMAT, "%zu characters are too long; at most %zu fit", length, size - 1);
    if (memchr(json_string_value(value), 0, length))
        return pel_fail(error, PEL_ERROR_FORMAT, "a character with the code 0 is not allowed");
    memcpy(out, json_string_value(value), length + 1);
    return true;
}

/* ---- writing ---- */

static void put_number(FILE *file, double x)
{
    char text[40];
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, x);
        if (strtod(text, NULL) == x)
            break;
    }
    for (char *p = text; *p; p++) /* a program that uses the library may have set a locale */
        if (*p == ',')
            *p = '.';
    fputs(text, file);
}

static bool put_string(FILE *file, const char *string)
{
    json_t *value = json_string(string);
    char *text = value ? json_dumps(value, JSON_ENCODE_ANY) : NULL;
    json_decref(value);
    if (!text)
        return false;
    fputs(text, file);
    free(text);
    return true;
}

static bool is_line(const json_t *array)
{
    for (size_t i = 0; i < json_array_size(array); i++)
        if (!json_is_number(json_array_get(array, i)))
            return false;
    return true;
}

static bool put_value(FILE *file, const json_t *value, int depth);

static bool put_array(FILE *file, const json_t *array, int depth)
{
    bool line = is_line(array);
    fputc('[', file);
    for (size_t i = 0; i < json_array_size(array); i++) {
        if (line)
            fputs(i ? ", " : "", file);
        else
            fprintf(file, "%s\n%*s", i ? "," : "", 2 * depth + 2, "");
        if (!put_value(file, json_array_get(array, i), depth + 1))
            return false;
    }
    if (!line)
        fprintf(file, "\n%*s", 2 * depth, "");
    fputc(']', file);
    return true;
}

static bool put_object(FILE *file, const json_t *object, int depth)
{
    const char *key, *comma = "";
    json_t *value;
    fputc('{', file);
    json_object_foreach((json_t *)object, key, value)
    {
        fprintf(file, "%s\n%*s", comma, 2 * depth + 2, "");
        comma = ",";
        if (!put_string(file, key))
            return false;
        fputs(": ", file);
        if (!put_value(file, value, depth + 1))
            return false;
    }
    fprintf(file, "\n%*s}", 2 * depth, "");
    return true;
}

static bool put_value(FILE *file, const json_t *value, int depth)
{
    if (depth > MOST_DEPTH)
        return false;
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return put_object(file, value, depth);
    case JSON_ARRAY:
        return put_array(file, value, depth);
    case JSON_STRING:
        return put_string(file, json_string_value(value));
    case JSON_INTEGER:
        return fprintf(file, "%" JSON_INTEGER_FORMAT, json_integer_value(value)) > 0;
    case JSON_REAL:
        put_number(file, json_real_value(value));
        return true;
    case JSON_TRUE:
        return fputs("true", file) >= 0;
    case JSON_FALSE:
        return fputs("false", file) >= 0;
    case JSON_NULL:
        return fputs("null", file) >= 0;
    }
    return false;
}

bool pel_json_write(const char *path, const json_t *root, struct pel_error *error)
{
    struct pel_safe_file out = { 0 };
    if (!pel_safe_file_open(&out, path, error))
        return false;
    bool ok = put_value(out.file, root, 0) && fputc('\n', out.file) != EOF;
    if (!ok)
        pel_fail_errno(error, "cannot be written");
    ok = ok && pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok;
}

char *pel_json_to_text(const json_t *root, struct pel_error *error)
{
    char *text = NULL;
    size_t size;
    FILE *file = open_memstream(&text, &size);
    bool ok = file && put_value(file, root, 0);
    ok = (!file || fclose(file) == 0) && ok;
    if (ok)
        return text;
    free(text);
    pel_fail(error, PEL_ERROR_MEMORY, "no memory for the text");
    return NULL;
}
