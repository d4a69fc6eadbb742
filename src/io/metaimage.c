/* SPDX-License-Identifier: MIT */
#include "metaimage.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "alloc.h"
#include "fail.h"

enum { MAX_LINE = 1 << 14, MAX_LINES = 4096 };

struct reader {
    struct pel_text *text;
    int number; /* of the line */
    char line[MAX_LINE];
    char *key, *value; /* in `line`; value NULL where there is no = */
};

/* Takes a line and cuts it at its =. */
static bool next_line(struct reader *in, struct pel_error *error)
{
    if (!pel_text_line(in->text, in->line, sizeof in->line))
        return in->text->failed
                   ? false
                   : pel_fail(error, PEL_ERROR_FORMAT, "ends within its header (there is no ElementDataFile); it is truncated");
    in->number++;
    in->key = in->line + strspn(in->line, " \t");
    in->value = strchr(in->key, '=');
    if (in->value) {
        char *end = in->value;
        *in->value++ = 0;
        while (end > in->key && isspace((unsigned char)end[-1]))
            *--end = 0;
        in->value += strspn(in->value, " \t");
        end = in->value + strlen(in->value);
        while (end > in->value && isspace((unsigned char)end[-1]))
            *--end = 0;
    }
    return true;
}

static bool is(const struct reader *in, const char *key)
{
    return strcasecmp(in->key, key) == 0;
}

static bool bad(const struct reader *in, const char *needs, struct pel_error *error)
{
    char shown[64];
    pel_copy_text(shown, sizeof shown, in->value);
    return pel_fail(error, PEL_ERROR_FORMAT, "line %d: %.40s is \"%s\"; it needs %s", in->number, in->key, shown, needs);
}

static bool truth(const struct reader *in)
{
    return in->value[0] == 'T' || in->value[0] == 't' || in->value[0] == '1' || in->value[0] == 'Y' || in->value[0] == 'y';
}

static bool numbers(const struct reader *in, int count, double *values, struct pel_error *error)
{
    return pel_text_list(in->text, in->value, count, values) || bad(in, "a number an axis (NDims comes before it)", error);
}

static bool whole(const struct reader *in, int count, uint64_t *values, uint64_t most, struct pel_error *error)
{
    const char *at = in->value;
    for (int i = 0; i < count; i++) {
        char *end;
        at += strspn(at, " \t");
        if (!isdigit((unsigned char)*at))
            return bad(in, count > 1 ? "a whole number an axis (NDims comes before it)" : "a whole number", error);
        values[i] = strtoull(at, &end, 10);
        if (values[i] > most)
            return bad(in, "a smaller number", error);
        at = end;
    }
    return true;
}

static int element_type(const char *name)
{
    static const struct {
        const char *name;
        int type;
    } types[] = { { "MET_UCHAR", PEL_U8 },       { "MET_CHAR", PEL_I8 },      { "MET_USHORT", PEL_U16 },
                  { "MET_SHORT", PEL_I16 },      { "MET_UINT", PEL_U32 },     { "MET_INT", PEL_I32 },
                  { "MET_ULONG", PEL_U32 },      { "MET_LONG", PEL_I32 },     { "MET_ULONG_LONG", PEL_FILE_U64 },
                  { "MET_LONG_LONG", PEL_FILE_I64 }, { "MET_FLOAT", PEL_F32 }, { "MET_DOUBLE", PEL_F64 } };
    /* The _ARRAY forms are the same with ElementNumberOfChannels. */
    size_t n = strlen(name);
    if (n > 6 && strcasecmp(name + n - 6, "_ARRAY") == 0)
        n -= 6;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strlen(types[i].name) == n && strncasecmp(name, types[i].name, n) == 0)
            return types[i].type;
    return -1;
}

static bool add_file(struct pel_metaimage *head, const char *name, struct pel_error *error)
{
    if (head->file_count >= PEL_METAIMAGE_MAX_FILES)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "names more than %d data files", PEL_METAIMAGE_MAX_FILES);
    if ((head->file_count & (head->file_count - 1)) == 0) {
        char **more = realloc(head->files, (head->file_count ? head->file_count * 2 : 1) * sizeof *more);
        if (!more)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for the names of its data files");
        head->files = more;
    }
    head->files[head->file_count] = pel_strdup(name, error);
    return head->files[head->file_count] && ++head->file_count;
}

/* "slice%03d.raw 1 20 1": the only conversion is one %d or %i, and it is never given to printf. */
static bool add_pattern(struct pel_metaimage *head, const struct reader *in, struct pel_error *error)
{
    char name[512], tail[512];
    int least = 0, most = -1, step = 1, width = 0;
    const char *spec = in->value;
    size_t n = strcspn(spec, " \t"), percent = strcspn(spec, "%"), at = percent + 1;
    int given = sscanf(spec + n, "%d %d %d", &least, &most, &step);
    if (n >= sizeof name || percent >= n || given < 2 || step <= 0)
        return bad(in, "a name with %d, then least, greatest and step", error);
    bool zero = spec[at] == '0';
    while (isdigit((unsigned char)spec[at]) && width < 100)
        width = width * 10 + spec[at++] - '0';
    if ((spec[at] != 'd' && spec[at] != 'i') || width > 20 || memchr(spec + at, '%', n - at))
        return bad(in, "a % that is a %d", error);
    memcpy(name, spec, percent);
    name[percent] = 0;
    memcpy(tail, spec + at + 1, n - at - 1);
    tail[n - at - 1] = 0;
    for (long long i = least; i <= most; i += step) {
        char path[1100];
        snprintf(path, sizeof path, zero ? "%s%0*lld%s" : "%s%*lld%s", name, width, i, tail);
        if (!add_file(head, path, error))
            return false;
    }
    return head->file_count > 0 || bad(in, "a greatest number that is not below the least", error);
}

static bool take_data_file(struct reader *in, struct pel_metaimage *head, struct pel_error *error)
{
    const char *value = in->value;
    if (strcasecmp(value, "LOCAL") == 0) {
        head->local = true;
        return true;
    }
    if (strncasecmp(value, "LIST", 4) == 0 && (value[4] == 0 || isspace((unsigned char)value[4]))) {
        while (pel_text_line(in->text, in->line, sizeof in->line)) {
            size_t n = strlen(in->line);
            while (n > 0 && isspace((unsigned char)in->line[n - 1]))
                in->line[--n] = 0;
            if (n == 0)
                break;
            if (!add_file(head, in->line, error))
                return false;
        }
        return head->file_count > 0 || pel_fail(error, PEL_ERROR_FORMAT, "names no data file after \"ElementDataFile = LIST\"");
    }
    const char *space = strpbrk(value, " \t");
    if (space && strchr(value, '%') && strchr(value, '%') < space)
        return add_pattern(head, in, error);
    return value[0] ? add_file(head, value, error) : bad(in, "the name of a file, or LOCAL", error);
}

static bool take_type(const struct reader *in, struct pel_metaimage *head, struct pel_error *error)
{
    head->type = element_type(in->value);
    if (head->type >= 0)
        return true;
    return bad(in, "MET_UCHAR, MET_CHAR, MET_USHORT, MET_SHORT, MET_UINT, MET_INT, MET_FLOAT, MET_DOUBLE or another known type", error);
}

/* Keys that carry an axis' numbers come after NDims; 7 is the most that any writer gives. */
static bool take_shape(const struct reader *in, struct pel_metaimage *head, bool *taken, struct pel_error *error)
{
    uint64_t n;
    int d = head->dims;
    *taken = true;
    if (is(in, "NDims")) {
        if (!whole(in, 1, &n, 7, error))
            return false;
        head->dims = (int)n;
        return n >= 1 || bad(in, "a number of axes", error);
    }
    if (is(in, "DimSize"))
        return d > 0 ? whole(in, d, head->sizes, PTRDIFF_MAX, error) : bad(in, "NDims before it", error);
    if (is(in, "ElementSpacing"))
        return (head->has_spacing = d > 0 && numbers(in, d, head->spacing, error)) ||
               bad(in, "a number an axis (NDims comes before it)", error);
    if (is(in, "ElementSize"))
        return (head->has_element_size = d > 0 && numbers(in, d, head->element_size, error)) ||
               bad(in, "a number an axis (NDims comes before it)", error);
    if (is(in, "Offset") || is(in, "Position") || is(in, "Origin"))
        return d > 0 ? numbers(in, d, head->offset, error) : bad(in, "NDims before it", error);
    if (is(in, "TransformMatrix") || is(in, "Rotation") || is(in, "Orientation"))
        return (head->has_matrix = d > 0 && numbers(in, d * d, head->matrix, error)) ||
               bad(in, "NDims times NDims numbers (NDims comes before it)", error);
    *taken = false;
    return true;
}

static bool take_key(const struct reader *in, struct pel_metaimage *head, struct pel_error *error)
{
    bool taken;
    if (!take_shape(in, head, &taken, error))
        return false;
    if (taken)
        return true;
    if (is(in, "ElementType"))
        return take_type(in, head, error);
    if (is(in, "ElementNumberOfChannels"))
        return whole(in, 1, &head->channels, 1 << 20, error);
    if (is(in, "CompressedDataSize"))
        return whole(in, 1, &head->compressed_size, PTRDIFF_MAX, error);
    if (is(in, "HeaderSize")) {
        char *end;
        head->header_size = strtoll(in->value, &end, 10);
        return (end != in->value && head->header_size >= -1) || bad(in, "a number of bytes, or -1", error);
    }
    if (is(in, "ElementNaN") || is(in, "VoidValue"))
        head->has_void = pel_text_number(in->text, in->value, &head->void_value);
    else if (is(in, "BinaryData"))
        head->binary = truth(in);
    else if (is(in, "ElementByteOrderMSB") || is(in, "BinaryDataByteOrderMSB"))
        head->big_endian = truth(in);
    else if (is(in, "CompressedData"))
        head->compressed = truth(in);
    else if (is(in, "AnatomicalOrientation"))
        pel_copy_text(head->orientation, sizeof head->orientation, in->value);
    else if (is(in, "DistanceUnits"))
        pel_copy_text(head->units, sizeof head->units, in->value);
    else if (is(in, "Name"))
        pel_copy_text(head->name, sizeof head->name, in->value);
    return true;
}

static bool read_lines(struct reader *in, struct pel_metaimage *head, struct pel_error *error)
{
    for (;;) {
        if (!next_line(in, error))
            return false;
        if (in->number > MAX_LINES)
            return pel_fail(error, PEL_ERROR_FORMAT, "has no ElementDataFile within %d lines; it is no MetaImage", MAX_LINES);
        if (!in->value) {
            if (!in->key[0])
                continue;
            return pel_fail(error, PEL_ERROR_FORMAT, "line %d: has no \"=\"; a MetaImage header is lines of \"Key = Value\"", in->number);
        }
        if (is(in, "ElementDataFile"))
            break;
        if (!take_key(in, head, error))
            return false;
    }
    if (head->dims == 0 || head->sizes[0] == 0)
        return pel_fail(error, PEL_ERROR_FORMAT, head->dims == 0 ? "its header has no NDims" : "its header has no DimSize, or 0 in it");
    if (head->type < 0)
        return pel_fail(error, PEL_ERROR_FORMAT, "its header has no ElementType");
    return take_data_file(in, head, error);
}

bool pel_metaimage_read_header(struct pel_stream *stream, struct pel_metaimage *head, struct pel_error *error)
{
    *head = (struct pel_metaimage){ .type = -1, .channels = 1, .binary = true };
    struct reader *in = pel_alloc(1, sizeof *in, "header", error);
    struct pel_text *text = in ? pel_alloc(1, sizeof *text, "header", error) : NULL;
    bool ok = text && pel_text_init(text, stream, error);
    if (ok) {
        in->text = text;
        /* What was read beyond the header goes back: it is samples, perhaps compressed ones. */
        ok = read_lines(in, head, error) && pel_stream_unread(stream, text->bytes + text->at, text->size - text->at, error);
    }
    if (text)
        pel_text_finish(text);
    free(text);
    free(in);
    if (!ok)
        pel_metaimage_finish(head);
    return ok;
}

void pel_metaimage_finish(struct pel_metaimage *head)
{
    for (size_t i = 0; i < head->file_count; i++)
        free(head->files[i]);
    free(head->files);
    head->files = NULL;
    head->file_count = 0;
}
