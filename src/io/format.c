/* SPDX-License-Identifier: MIT */
/* The things that all readers and writers share: names, notes, sizes, and placement that can be relied on. */
#include "format.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "alloc.h"
#include "fail.h"
#include "vec.h"

bool pel_path_has_ending(const char *path, const char *endings)
{
    size_t length = strlen(path);
    for (const char *word = endings; *word;) {
        size_t n = strcspn(word, " ");
        if (n > 0 && length > n && strncasecmp(path + length - n, word, n) == 0)
            return true;
        word += n + strspn(word + n, " ");
    }
    return false;
}

char *pel_path_beside(const char *path, const char *name, struct pel_error *error)
{
    const char *slash = strrchr(path, '/');
    size_t folder = name[0] == '/' || !slash ? 0 : (size_t)(slash + 1 - path), size = folder + strlen(name) + 1;
    char *joined = pel_alloc(size, 1, "file name", error);
    if (joined)
        snprintf(joined, size, "%.*s%s", (int)folder, path, name);
    return joined;
}

char *pel_path_of_data(const char *path, const char *name, const struct pel_read_params *params, struct pel_error *error)
{
    char *joined = pel_path_beside(path, name, error);
    if (!joined || !params->may_open || params->may_open(params->may_open_user, joined))
        return joined;
    free(joined);
    pel_fail(error, PEL_ERROR_ARGUMENT, "data file %.300s: it is not among the files that may be opened", name);
    return NULL;
}

void pel_info_note(struct pel_file_info *info, const char *format, ...)
{
    if (!info || info->note_count >= PEL_MAX_NOTES)
        return;
    va_list args;
    va_start(args, format);
    vsnprintf(info->notes[info->note_count++], sizeof info->notes[0], format, args);
    va_end(args);
}

void pel_info_array(struct pel_file_info *info, const char *name, enum pel_type type, int components)
{
    if (info->array_count >= PEL_MAX_ARRAYS)
        return;
    pel_copy_text(info->arrays[info->array_count].name, sizeof info->arrays[0].name, name);
    info->arrays[info->array_count].type = type;
    info->arrays[info->array_count].components = components;
    info->array_count++;
}

int pel_info_choose(const struct pel_file_info *info, const struct pel_read_params *params, int fallback, struct pel_error *error)
{
    if (!params->array)
        return fallback;
    char names[300] = "";
    for (int i = 0; i < info->array_count; i++) {
        if (strcmp(info->arrays[i].name, params->array) == 0)
            return i;
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", info->arrays[i].name);
    }
    pel_fail(error, PEL_ERROR_ARGUMENT, "has no array \"%.80s\"; it has: %s", params->array, names[0] ? names : "one without a name");
    return -1;
}

bool pel_volume_size_check(const uint64_t dims[3], enum pel_type type, uint64_t components, size_t *bytes, struct pel_error *error)
{
    if (components < 1 || components > 4)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has %llu numbers a sample; 1 to 4 can be read", (unsigned long long)components);
    size_t size = pel_type_size(type) * (size_t)components;
    for (int i = 0; i < 3; i++) {
        if (dims[i] == 0)
            return pel_fail(error, PEL_ERROR_FORMAT, "has no samples along axis %d", i);
        if (dims[i] > PTRDIFF_MAX || !pel_mul(size, (size_t)dims[i], &size) || size > PTRDIFF_MAX)
            return pel_fail(error, PEL_ERROR_FORMAT, "a size of %llu x %llu x %llu samples cannot be: it is beyond what can be addressed",
                            (unsigned long long)dims[0], (unsigned long long)dims[1], (unsigned long long)dims[2]);
    }
    *bytes = size;
    return true;
}

void pel_volume_set_axis(struct pel_volume *volume, int axis, const double step[3], struct pel_file_info *info)
{
    double unit[3] = { step[0], step[1], step[2] }, *direction = volume->direction[axis];
    double largest = fmax(fabs(step[0]), fmax(fabs(step[1]), fabs(step[2])));
    bool good = isfinite(step[0]) && isfinite(step[1]) && isfinite(step[2]) && largest > 0;
    double length = largest;
    /* An axis along a world axis keeps its spacing to the bit; others are scaled first, so that nothing overflows on the way. */
    if (good && fabs(step[0]) + fabs(step[1]) + fabs(step[2]) > largest) {
        for (int i = 0; i < 3; i++)
            unit[i] /= largest;
        length = pel_length(unit) * largest;
        pel_normalize(unit);
    } else if (good) {
        for (int i = 0; i < 3; i++)
            unit[i] = step[i] > 0 ? 1 : step[i] < 0 ? -1 : 0;
    }
    if (!good || !isfinite(length)) {
        pel_info_note(info, "the spacing of axis %d is %s; taken as 1", axis, largest == 0 ? "0" : "no finite number");
        length = 1;
        for (int i = 0; i < 3; i++)
            unit[i] = i == axis;
    }
    memcpy(direction, unit, sizeof unit);
    volume->spacing[axis] = length;
}

void pel_volume_mend_directions(struct pel_volume *volume, struct pel_file_info *info)
{
    double inverse[3][3];
    double det = pel_invert3((const double(*)[3])volume->direction, inverse);
    if (fabs(det) > 1e-6 && isfinite(det))
        return;
    pel_info_note(info, "the axis directions lie in a plane; taken as the axes x, y and z");
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            volume->direction[a][i] = a == i;
}

void pel_swap_bytes(void *numbers, size_t count, size_t size)
{
    if (size == 2) {
        uint16_t *p = numbers;
        for (size_t i = 0; i < count; i++)
            p[i] = __builtin_bswap16(p[i]);
    } else if (size == 4) {
        uint32_t *p = numbers;
        for (size_t i = 0; i < count; i++)
            p[i] = __builtin_bswap32(p[i]);
    } else if (size == 8) {
        uint64_t *p = numbers;
        for (size_t i = 0; i < count; i++)
            p[i] = __builtin_bswap64(p[i]);
    }
}

void pel_copy_text(char *out, size_t size, const char *text)
{
    size_t n = 0;
    for (; text && text[n] && n + 1 < size; n++)
        out[n] = iscntrl((unsigned char)text[n]) ? ' ' : text[n];
    while (n > 0 && out[n - 1] == ' ')
        n--;
    out[n] = 0;
}
