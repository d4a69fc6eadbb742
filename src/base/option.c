/* SPDX-License-Identifier: MIT */
/* Option rows to values and back. Numbers are read and written in the C locale whatever the program's is, so that "0.5" means a half
 * everywhere and a scene file saved on one machine loads on another. A value is read into a local first: the field changes only when the
 * whole text was good. */
#include <pellucid/option.h>

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "c_locale.h"
#include "fail.h"

#define MAX_NUMBERS 6
#define SHOWN 80 /* how much of a bad text an error repeats */

const struct pel_option *pel_option_find(const struct pel_option *table, const char *name)
{
    for (; table && table->name; table++)
        if (strcmp(table->name, name) == 0)
            return table;
    return NULL;
}

void pel_option_defaults(const struct pel_option *table, void *object)
{
    for (; table && table->name; table++)
        if (table->fallback)
            pel_option_set(table, object, table->fallback, NULL);
}

/* " from 0 to 1", " of at least 1", "" */
static void describe_range(const struct pel_option *row, char *text, size_t size)
{
    bool low = row->minimum > -DBL_MAX, high = row->maximum < DBL_MAX;
    const char *unit = row->unit ? row->unit : "", *gap = row->unit ? " " : "";
    if (low && high)
        snprintf(text, size, " from %.10g to %.10g%s%s", row->minimum, row->maximum, gap, unit);
    else if (low)
        snprintf(text, size, " of at least %.10g%s%s", row->minimum, gap, unit);
    else if (high)
        snprintf(text, size, " of at most %.10g%s%s", row->maximum, gap, unit);
    else
        snprintf(text, size, "%s%s%s", row->unit ? " (" : "", unit, row->unit ? ")" : "");
}

static bool refuse(const struct pel_option *row, const char *text, const char *wanted, struct pel_error *error)
{
    char range[128] = "";
    if (row->type == PEL_OPTION_INT || row->type == PEL_OPTION_DOUBLE || row->type == PEL_OPTION_VEC2 || row->type == PEL_OPTION_VEC3 ||
        row->type == PEL_OPTION_VEC6 || row->type == PEL_OPTION_SIZE)
        describe_range(row, range, sizeof range);
    bool cut = strlen(text) > SHOWN;
    return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: \"%.*s%s\" is not %s%s", row->name, SHOWN, text, cut ? "..." : "", wanted, range);
}

/* Reads one finite number and moves *text behind it and behind blanks. */
static bool read_number(const char **text, double *value)
{
    char *end;
    double v = strtod(*text, &end);
    if (end == *text || !isfinite(v))
        return false;
    *text = end + strspn(end, " ");
    *value = v;
    return true;
}

/* Reads numbers with commas between them to the end of the text. Gives how many, or 0 where it is no such list. */
static int read_list(const char *text, double values[MAX_NUMBERS])
{
    for (int n = 0; n < MAX_NUMBERS; text++) {
        if (!read_number(&text, &values[n++]))
            return 0;
        if (!*text)
            return n;
        if (*text != ',')
            return 0;
    }
    return 0;
}

static bool in_range(const struct pel_option *row, const double *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!(values[i] >= row->minimum && values[i] <= row->maximum))
            return false;
    return true;
}

static bool read_bool(const char *text, bool *value)
{
    static const char *const yes[] = { "true", "on", "yes", "1" }, *const no[] = { "false", "off", "no", "0" };
    for (int i = 0; i < 4; i++) {
        if (strcasecmp(text, yes[i]) == 0)
            return *value = true, true;
        if (strcasecmp(text, no[i]) == 0)
            return *value = false, true;
    }
    return false;
}

static bool read_int(const char *text, long *value)
{
    char *end;
    if (!*text)
        return false;
    *value = strtol(text, &end, 10); /* out of range gives LONG_MIN or LONG_MAX, which no row allows */
    return !*end;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static bool read_hex_color(const char *text, double rgba[4])
{
    size_t digits = strlen(text);
    rgba[3] = 1;
    for (size_t i = 0; i < digits && (digits == 3 || digits == 4); i++) { /* a digit stands for two of it */
        if (hex_digit(text[i]) < 0)
            return false;
        rgba[i] = hex_digit(text[i]) / 15.0;
    }
    if (digits != 6 && digits != 8)
        return digits == 3 || digits == 4;
    for (size_t i = 0; i < digits; i += 2) {
        int high = hex_digit(text[i]), low = hex_digit(text[i + 1]);
        if (high < 0 || low < 0)
            return false;
        rgba[i / 2] = (high * 16 + low) / 255.0;
    }
    return true;
}

/* The names of CSS level 1 and the commoner ones of CSS Color 3, with its values; but gray is the half that it always was here (CSS has
 * 128/255). */
static bool read_named_color(const char *text, double rgba[4])
{
    static const struct {
        const char *name;
        unsigned rgb;
    } named[] = {
        { "black", 0x000000 },     { "white", 0xffffff },     { "silver", 0xc0c0c0 },    { "maroon", 0x800000 },
        { "red", 0xff0000 },       { "purple", 0x800080 },    { "fuchsia", 0xff00ff },   { "magenta", 0xff00ff },
        { "green", 0x008000 },     { "lime", 0x00ff00 },      { "olive", 0x808000 },     { "yellow", 0xffff00 },
        { "navy", 0x000080 },      { "blue", 0x0000ff },      { "teal", 0x008080 },      { "aqua", 0x00ffff },
        { "cyan", 0x00ffff },      { "orange", 0xffa500 },    { "gold", 0xffd700 },      { "pink", 0xffc0cb },
        { "brown", 0xa52a2a },     { "tan", 0xd2b48c },       { "beige", 0xf5f5dc },     { "ivory", 0xfffff0 },
        { "salmon", 0xfa8072 },    { "coral", 0xff7f50 },     { "tomato", 0xff6347 },    { "crimson", 0xdc143c },
        { "violet", 0xee82ee },    { "indigo", 0x4b0082 },    { "turquoise", 0x40e0d0 }, { "skyblue", 0x87ceeb },
        { "steelblue", 0x4682b4 }, { "lightgray", 0xd3d3d3 }, { "lightgrey", 0xd3d3d3 }, { "darkgray", 0xa9a9a9 },
        { "darkgrey", 0xa9a9a9 },
    };
    const bool gray = !strcasecmp(text, "gray") || !strcasecmp(text, "grey"), transparent = !strcasecmp(text, "transparent");
    for (int c = 0; (gray || transparent) && c < 4; c++)
        rgba[c] = transparent ? 0 : c < 3 ? 0.5 : 1;
    for (size_t i = 0; i < sizeof named / sizeof *named; i++)
        if (strcasecmp(text, named[i].name) == 0) {
            for (int c = 0; c < 3; c++)
                rgba[c] = (named[i].rgb >> (16 - 8 * c) & 255) / 255.0;
            rgba[3] = 1;
            return true;
        }
    return gray || transparent;
}

static bool read_color(const char *text, double rgba[4])
{
    if (read_named_color(text, rgba))
        return true;
    if (text[0] == '#')
        return read_hex_color(text + 1, rgba);
    double list[MAX_NUMBERS];
    int count = read_list(text, list);
    if (count != 3 && count != 4)
        return false;
    if (count == 3)
        list[3] = 1;
    for (int i = 0; i < 4; i++)
        if (!(list[i] >= 0 && list[i] <= 1))
            return false;
    memcpy(rgba, list, 4 * sizeof *rgba);
    return true;
}

/* "1024x768", "1024,768" or "512". */
static bool read_size(const struct pel_option *row, const char *text, int size[2])
{
    char *end;
    long n[2];
    if (!*text)
        return false;
    n[0] = n[1] = strtol(text, &end, 10);
    if (end != text && (*end == 'x' || *end == 'X' || *end == ',') && !read_int(end + 1, &n[1]))
        return false;
    if (end == text || (*end && *end != 'x' && *end != 'X' && *end != ','))
        return false;
    for (int i = 0; i < 2; i++)
        if (n[i] < row->minimum || n[i] > row->maximum || n[i] < INT_MIN || n[i] > INT_MAX)
            return false;
    size[0] = (int)n[0], size[1] = (int)n[1];
    return true;
}

static bool set_numbers(const struct pel_option *row, double *field, int count, const char *wanted, const char *text,
                       struct pel_error *error)
{
    double values[MAX_NUMBERS];
    if (read_list(text, values) != count || !in_range(row, values, count))
        return refuse(row, text, wanted, error);
    memcpy(field, values, (size_t)count * sizeof *field);
    return true;
}

static bool set_choice(const struct pel_option *row, int *field, const char *text, struct pel_error *error)
{
    char known[256] = "";
    size_t used = 0;
    for (int i = 0; row->choices[i]; i++) {
        if (strcasecmp(text, row->choices[i]) == 0)
            return *field = i, true;
        if (used < sizeof known)
            used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "one of ", row->choices[i]);
    }
    return refuse(row, text, known, error);
}

static bool set_text(const struct pel_option *row, char *field, const char *text, struct pel_error *error)
{
    size_t length = strlen(text);
    if (length >= PEL_OPTION_TEXT_SIZE)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: a text of %zu bytes is too long; at most %d fit", row->name, length,
                        PEL_OPTION_TEXT_SIZE - 1);
    memcpy(field, text, length + 1);
    return true;
}

static bool set(const struct pel_option *row, void *field, const char *text, struct pel_error *error)
{
    long integer;
    double rgba[4];
    switch (row->type) {
    case PEL_OPTION_BOOL:
        return read_bool(text, field) || refuse(row, text, "true or false (on or off, yes or no, 1 or 0)", error);
    case PEL_OPTION_INT:
        if (!read_int(text, &integer) || integer < row->minimum || integer > row->maximum || integer < INT_MIN || integer > INT_MAX)
            return refuse(row, text, "a whole number", error);
        *(int *)field = (int)integer;
        return true;
    case PEL_OPTION_DOUBLE:
        return set_numbers(row, field, 1, "a number", text, error);
    case PEL_OPTION_CHOICE:
        return set_choice(row, field, text, error);
    case PEL_OPTION_VEC2:
        return set_numbers(row, field, 2, "two numbers \"a,b\", each", text, error);
    case PEL_OPTION_VEC3:
        return set_numbers(row, field, 3, "three numbers \"x,y,z\", each", text, error);
    case PEL_OPTION_VEC6:
        return set_numbers(row, field, 6, "six numbers with commas between, each", text, error);
    case PEL_OPTION_COLOR:
        if (!read_color(text, rgba))
            return refuse(row, text,
                          "a colour: \"r,g,b\" or \"r,g,b,a\" from 0 to 1, \"#rgb\", \"#rrggbb\", a name such as red, navy, orange, gray, "
                          "or transparent",
                          error);
        memcpy(field, rgba, sizeof rgba);
        return true;
    case PEL_OPTION_SIZE:
        return read_size(row, text, field) || refuse(row, text, "a size such as \"1024x768\" or \"512\", each number", error);
    case PEL_OPTION_TEXT:
        return set_text(row, field, text, error);
    }
    return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: an option of an unknown type", row->name);
}

bool pel_option_set(const struct pel_option *row, void *object, const char *text, struct pel_error *error)
{
    if (!text && row->type == PEL_OPTION_BOOL)
        text = "true";
    if (!text)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: a value is missing", row->name);
    const struct pel_c_locale locale = pel_c_locale_begin();
    bool good = set(row, (char *)object + row->offset, text, error);
    pel_c_locale_end(&locale);
    return good;
}

/* The shortest decimal text that reads back to the same double. */
static int write_number(char *text, size_t size, double value)
{
    int length = 0;
    for (int digits = 6; digits <= 17; digits++) {
        length = snprintf(text, size, "%.*g", digits, value);
        if (!isfinite(value) || strtod(text, NULL) == value)
            break;
    }
    return length;
}

static void write_list(char *text, size_t size, const double *values, int count)
{
    size_t used = 0;
    for (int i = 0; i < count; i++) {
        if (i)
            text[used++] = ',';
        used += (size_t)write_number(text + used, size - used, values[i]);
    }
}

static void get(const struct pel_option *row, const void *field, char *text, size_t size)
{
    const int *integers = field;
    const double *numbers = field;
    int known = 0;
    switch (row->type) {
    case PEL_OPTION_BOOL:
        snprintf(text, size, "%s", *(const bool *)field ? "true" : "false");
        break;
    case PEL_OPTION_INT:
        snprintf(text, size, "%d", *integers);
        break;
    case PEL_OPTION_CHOICE: /* a field that holds no choice is written as a number, which reading refuses */
        while (row->choices[known])
            known++;
        if (*integers >= 0 && *integers < known)
            snprintf(text, size, "%s", row->choices[*integers]);
        else
            snprintf(text, size, "%d", *integers);
        break;
    case PEL_OPTION_DOUBLE:
        write_list(text, size, numbers, 1);
        break;
    case PEL_OPTION_VEC2:
        write_list(text, size, numbers, 2);
        break;
    case PEL_OPTION_VEC3:
        write_list(text, size, numbers, 3);
        break;
    case PEL_OPTION_VEC6:
        write_list(text, size, numbers, 6);
        break;
    case PEL_OPTION_COLOR:
        write_list(text, size, numbers, numbers[3] == 1 ? 3 : 4);
        break;
    case PEL_OPTION_SIZE:
        snprintf(text, size, "%dx%d", integers[0], integers[1]);
        break;
    case PEL_OPTION_TEXT:
        break;
    }
}

int pel_option_get(const struct pel_option *row, const void *object, char *text, size_t size)
{
    const void *field = (const char *)object + row->offset;
    if (row->type == PEL_OPTION_TEXT)
        return snprintf(text, size, "%s", (const char *)field);
    char whole[MAX_NUMBERS * 32] = ""; /* a double takes at most 24 characters */
    const struct pel_c_locale locale = pel_c_locale_begin();
    get(row, field, whole, sizeof whole);
    pel_c_locale_end(&locale);
    return snprintf(text, size, "%s", whole);
}
