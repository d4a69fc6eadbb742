/* SPDX-License-Identifier: MIT */
/* The text of a legacy VTK file: keywords, and arrays of numbers that are stepped over. Format: "VTK File Formats" (vtk.org), and for what
 * that leaves open VTK's vtkDataReader. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "fail.h"
#include "sample_layout.h"
#include "vtk.h"

/* VTK's type names. False where the numbers cannot be read or even skipped. */
static bool find_type(const char *name, struct pel_vtk_array *array)
{
    static const struct {
        const char *name;
        int type;
    } types[] = {
        { "unsigned_char", PEL_U8 },
        { "char", PEL_I8 },
        { "signed_char", PEL_I8 },
        { "unsigned_short", PEL_U16 },
        { "short", PEL_I16 },
        { "unsigned_int", PEL_U32 },
        { "int", PEL_I32 },
        { "vtkIdType", PEL_I32 },
        { "float", PEL_F32 },
        { "double", PEL_F64 },
        { "bit", PEL_U8 },
        { "long", PEL_FILE_I64 },
        { "unsigned_long", PEL_FILE_U64 },
        { "vtktypeint64", PEL_FILE_I64 },
        { "vtktypeuint64", PEL_FILE_U64 },
    };
    array->bits = !strcasecmp(name, "bit");
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcasecmp(name, types[i].name)) {
            array->type = types[i].type;
            return true;
        }
    return false;
}

/* A word that must be there. */
static bool need_word(struct pel_vtk_header *h, char *out, size_t size, const char *what)
{
    if (pel_text_word(h->text, out, size))
        return true;
    return h->text->failed ? false : pel_fail(h->error, PEL_ERROR_FORMAT, "%s is missing", what);
}

static bool need_number(struct pel_vtk_header *h, double *value, const char *what)
{
    char word[64];
    if (!need_word(h, word, sizeof word, what))
        return false;
    return pel_text_number(h->text, word, value) || pel_fail(h->error, PEL_ERROR_FORMAT, "%s: '%.40s' is no number", what, word);
}

/* A count: a whole number from 0 on. */
static bool need_count(struct pel_vtk_header *h, uint64_t *value, const char *what)
{
    double number;
    if (!need_number(h, &number, what))
        return false;
    if (!(number >= 0 && number < 9e15) || number != (double)(uint64_t)number)
        return pel_fail(h->error, PEL_ERROR_FORMAT, "%s: %g is no count", what, number);
    *value = (uint64_t)number;
    return true;
}

/* Names are written with %20 for a space. */
static void decode_name(char *name)
{
    char *out = name;
    for (const char *in = name; *in; in++) {
        unsigned code;
        if (*in == '%' && isxdigit((unsigned char)in[1]) && isxdigit((unsigned char)in[2]) && sscanf(in + 1, "%2x", &code) == 1 && code) {
            *out++ = (char)code;
            in += 2;
        } else {
            *out++ = *in;
        }
    }
    *out = '\0';
    pel_copy_text(name, (size_t)(out - name) + 1, name);
}

bool pel_vtk_stored_bytes(const struct pel_vtk_array *array, uint64_t count, uint64_t *bytes)
{
    if (array->bits)
        return *bytes = count / 8 + (count % 8 != 0), true;
    return !__builtin_mul_overflow(count, (uint64_t)pel_type_size(pel_file_type_in_memory(array->type)), bytes);
}

static bool skip_numbers(struct pel_vtk_header *h, const struct pel_vtk_array *array, uint64_t count)
{
    uint64_t bytes;
    if (!h->binary) {
        if (count / 2 > pel_text_left(h->text))
            return pel_fail(h->error, PEL_ERROR_FORMAT, "%llu numbers cannot be in a file of this length", (unsigned long long)count);
        return pel_text_numbers(h->text, PEL_F64, (size_t)count, NULL);
    }
    if (!pel_vtk_stored_bytes(array, count, &bytes))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "%llu numbers cannot be in a file of this length", (unsigned long long)count);
    return pel_text_skip(h->text, bytes);
}

/* Steps over the numbers of `tuples` samples, and lists the array if it has one for each point or cell (`list`). */
static bool pass_array(struct pel_vtk_header *h, struct pel_vtk_array *array, uint64_t tuples, bool list)
{
    uint64_t count;
    array->offset = pel_text_tell(h->text);
    if (__builtin_mul_overflow(tuples, (uint64_t)array->components, &count))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "size overflows");
    if (!skip_numbers(h, array, count))
        return false;
    array->cells = h->section == PEL_VTK_CELLS;
    if (list && tuples == h->tuples && h->array_count < PEL_MAX_ARRAYS)
        h->arrays[h->array_count++] = *array;
    return true;
}

/* METADATA goes on to an empty line. */
static bool skip_metadata(struct pel_vtk_header *h)
{
    char line[256];
    pel_text_line(h->text, line, sizeof line);
    while (pel_text_line(h->text, line, sizeof line) && line[strspn(line, " \t")])
        ;
    return !h->text->failed;
}

/* Strings: one a line in ASCII; in binary each has a length in 1, 2, 4 or 8 bytes that its two highest bits tell. */
static bool skip_strings(struct pel_vtk_header *h, uint64_t count)
{
    char line[8];
    for (uint64_t i = 0; i < count; i++) {
        int first = h->binary ? pel_text_get(h->text) : pel_text_line(h->text, line, sizeof line) ? 0 : -1;
        if (first < 0)
            return h->text->failed ? false : pel_fail(h->error, PEL_ERROR_FORMAT, "the file ends among strings");
        if (!h->binary)
            continue;
        uint64_t length = (unsigned)first & 0x3f;
        int more = (1 << (3 - (first >> 6))) - 1;
        for (int k = 0, c; k < more; k++)
            if ((c = pel_text_get(h->text)) >= 0)
                length = length << 8 | (unsigned)c;
        if (!pel_text_skip(h->text, length))
            return false;
    }
    return true;
}

/* FIELD name count, then arrays: name components tuples type. Before the first section the field is the data set's own: no samples. */
static bool read_field(struct pel_vtk_header *h)
{
    char word[256], line[256];
    uint64_t count, components, length;
    if (!need_word(h, word, sizeof word, "name of a FIELD") || !need_count(h, &count, "number of arrays of a FIELD"))
        return false;
    for (uint64_t i = 0; i < count; i++) {
        struct pel_vtk_array array = { .kind = PEL_VTK_OTHER };
        if (!need_word(h, word, sizeof word, "name of a FIELD's array"))
            return false;
        if (!strcasecmp(word, "METADATA")) {
            if (!skip_metadata(h))
                return false;
            i--;
            continue;
        }
        if (!strcmp(word, "NULL_ARRAY"))
            continue;
        snprintf(array.name, sizeof array.name, "%.127s", word);
        decode_name(array.name);
        if (!need_count(h, &components, "components of a FIELD's array") || !need_count(h, &length, "tuples of a FIELD's array") ||
            !need_word(h, word, sizeof word, "type of a FIELD's array"))
            return false;
        pel_text_line(h->text, line, sizeof line);
        if (!strcasecmp(word, "string")) {
            if (__builtin_mul_overflow(length, components, &length) || !skip_strings(h, length))
                return pel_fail_in(h->error, "array '%s': ", array.name);
            continue;
        }
        if (!find_type(word, &array))
            return pel_fail(h->error, PEL_ERROR_UNSUPPORTED, "array '%s': type %s is not read", array.name, word);
        if (components > 1024)
            return pel_fail(h->error, PEL_ERROR_FORMAT, "array '%s': %llu components", array.name, (unsigned long long)components);
        array.components = (int)components;
        if (!pass_array(h, &array, length, h->section != PEL_VTK_NOWHERE && components))
            return pel_fail_in(h->error, "array '%s': ", array.name);
    }
    return true;
}

/* LOOKUP_TABLE name size: colours that are not for us. 4 bytes an entry, or 4 numbers. */
static bool skip_lookup_table(struct pel_vtk_header *h)
{
    char word[256], line[256];
    uint64_t size;
    struct pel_vtk_array bytes = { .type = PEL_U8, .components = 4 };
    if (!need_word(h, word, sizeof word, "name of a LOOKUP_TABLE") || !need_count(h, &size, "size of a LOOKUP_TABLE"))
        return false;
    pel_text_line(h->text, line, sizeof line);
    return pass_array(h, &bytes, size, false) || pel_fail_in(h->error, "LOOKUP_TABLE: ");
}

/* What stands on the line of an attribute behind its name: [components] [type] [components], which differs from word to word. */
static bool read_attribute_line(struct pel_vtk_header *h, const char *keyword, struct pel_vtk_array *array)
{
    char line[256], first[64] = "", second[64] = "", *type = first, *components = NULL;
    pel_text_line(h->text, line, sizeof line);
    int words = sscanf(line, "%63s %63s", first, second);
    double number = 1;
    array->kind = PEL_VTK_OTHER;
    array->components = 1;
    if (!strcasecmp(keyword, "SCALARS")) {
        array->kind = PEL_VTK_SCALARS;
        components = words > 1 ? second : NULL;
    } else if (!strcasecmp(keyword, "COLOR_SCALARS")) {
        type = NULL;
        components = first;
        array->kind = PEL_VTK_SCALARS; /* VTK writes all scalars of unsigned char so */
        array->type = PEL_U8;
        array->unit = !h->binary;
    } else if (!strcasecmp(keyword, "TEXTURE_COORDINATES")) {
        type = second;
        components = first;
    } else if (!strcasecmp(keyword, "VECTORS") || !strcasecmp(keyword, "NORMALS")) {
        array->kind = *keyword == 'V' || *keyword == 'v' ? PEL_VTK_VECTORS : PEL_VTK_OTHER;
        array->components = 3;
    } else if (!strcasecmp(keyword, "TENSORS") || !strcasecmp(keyword, "TENSORS6")) {
        array->components = keyword[7] ? 6 : 9;
    }
    if (components && (!pel_text_number(h->text, components, &number) || !(number >= 1 && number <= 1024)))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "%s %s: '%s' is no number of components", keyword, array->name, components);
    if (components)
        array->components = (int)number;
    if (type && !find_type(type, array))
        return pel_fail(h->error, PEL_ERROR_UNSUPPORTED, "%s %s: type '%s' is not read", keyword, array->name, type);
    return true;
}

/* PEL_VTK_SCALARS and its like: keyword name ... and the numbers from the next line on. */
static bool read_attribute(struct pel_vtk_header *h, const char *keyword)
{
    static const char *const known[] = { "SCALARS", "VECTORS",  "NORMALS",    "COLOR_SCALARS", "TEXTURE_COORDINATES",
                                         "TENSORS", "TENSORS6", "GLOBAL_IDS", "PEDIGREE_IDS",  "EDGE_FLAGS" };
    struct pel_vtk_array array = { .name = "" };
    char word[256];
    bool is_known = false;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        is_known |= !strcasecmp(keyword, known[i]);
    if (!is_known)
        return pel_fail(h->error, PEL_ERROR_FORMAT, "'%.40s' is no keyword of a legacy VTK file", keyword);
    if (!need_word(h, word, sizeof word, "name of an array"))
        return false;
    snprintf(array.name, sizeof array.name, "%.127s", word);
    decode_name(array.name);
    if (!read_attribute_line(h, keyword, &array))
        return false;
    /* "LOOKUP_TABLE name" follows PEL_VTK_SCALARS by the book, and is left out by some. */
    if (array.kind == PEL_VTK_SCALARS && strcasecmp(keyword, "COLOR_SCALARS") && pel_text_starts(h->text, "LOOKUP_TABLE"))
        pel_text_line(h->text, word, sizeof word);
    return pass_array(h, &array, h->tuples, true) || pel_fail_in(h->error, "%s %s: ", keyword, array.name);
}

/* The three lines before DATASET. */
static bool read_head(struct pel_vtk_header *h)
{
    char line[512], word[64];
    pel_text_line(h->text, line, sizeof line);
    if (strncmp(line, "# vtk DataFile", 14))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "line 1 is not '# vtk DataFile Version ...'");
    pel_text_line(h->text, line, sizeof line); /* a title */
    if (!need_word(h, word, sizeof word, "ASCII or BINARY"))
        return false;
    h->binary = !strcasecmp(word, "BINARY");
    if (!h->binary && strcasecmp(word, "ASCII"))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "line 3: '%.40s' where ASCII or BINARY is wanted", word);
    if (!need_word(h, word, sizeof word, "DATASET") || !need_word(h, line, sizeof line, "name of the DATASET"))
        return false;
    if (strcasecmp(word, "DATASET"))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "line 4: '%.40s' where DATASET is wanted", word);
    if (strcasecmp(line, "STRUCTURED_POINTS"))
        return pel_fail(h->error, PEL_ERROR_UNSUPPORTED, "DATASET %.60s: only STRUCTURED_POINTS is read", line);
    return true;
}

/* The words that describe the grid. *known is false where the keyword is none of them. */
static bool read_geometry(struct pel_vtk_header *h, const char *keyword, bool *known)
{
    *known = true;
    if (!strcasecmp(keyword, "DIMENSIONS")) {
        for (int a = 0; a < 3; a++)
            if (!need_count(h, &h->dims[a], "DIMENSIONS"))
                return false;
        size_t bytes;
        return pel_volume_size_check(h->dims, PEL_U8, 1, &bytes, h->error) || pel_fail_in(h->error, "DIMENSIONS: ");
    }
    double *out = !strcasecmp(keyword, "ORIGIN") ? h->origin : NULL;
    if (!strcasecmp(keyword, "SPACING") || !strcasecmp(keyword, "ASPECT_RATIO"))
        out = h->spacing;
    for (int a = 0; out && a < 3; a++)
        if (!need_number(h, &out[a], keyword))
            return false;
    *known = out != NULL;
    return true;
}

/* Samples at points or cells: the product of the dims, which read_geometry held against overflow. */
static uint64_t tuples_of(const struct pel_vtk_header *h, bool cells)
{
    uint64_t tuples = 1;
    for (int a = 0; a < 3; a++)
        tuples *= cells && h->dims[a] > 1 ? h->dims[a] - 1 : h->dims[a];
    return tuples;
}

/* POINT_DATA n or CELL_DATA n. */
static bool start_section(struct pel_vtk_header *h, const char *keyword)
{
    h->section = toupper((unsigned char)*keyword) == 'P' ? PEL_VTK_POINTS : PEL_VTK_CELLS;
    if (!need_count(h, &h->tuples, keyword))
        return false;
    if (!h->dims[0])
        return pel_fail(h->error, PEL_ERROR_FORMAT, "%s stands before DIMENSIONS", keyword);
    uint64_t wanted = tuples_of(h, h->section == PEL_VTK_CELLS);
    return h->tuples == wanted || pel_fail(h->error, PEL_ERROR_FORMAT, "%s %llu, but DIMENSIONS make %llu", keyword,
                                           (unsigned long long)h->tuples, (unsigned long long)wanted);
}

/* One keyword and what belongs to it. */
static bool read_keyword(struct pel_vtk_header *h, const char *word)
{
    bool known = false;
    if (!strcasecmp(word, "POINT_DATA") || !strcasecmp(word, "CELL_DATA"))
        return start_section(h, word);
    if (!strcasecmp(word, "METADATA"))
        return skip_metadata(h);
    if (!strcasecmp(word, "FIELD"))
        return read_field(h);
    if (h->section != PEL_VTK_NOWHERE)
        return !strcasecmp(word, "LOOKUP_TABLE") ? skip_lookup_table(h) : read_attribute(h, word);
    if (!read_geometry(h, word, &known))
        return false;
    return known || pel_fail(h->error, PEL_ERROR_FORMAT, "'%.40s' is not known before POINT_DATA", word);
}

/* Arrays of cells count only where there is none of points. */
static void drop_cells(struct pel_vtk_header *h)
{
    int points = 0;
    for (int i = 0; i < h->array_count; i++)
        if (!h->arrays[i].cells)
            h->arrays[points++] = h->arrays[i];
    if (points)
        h->array_count = points;
}

bool pel_vtk_scan(struct pel_vtk_header *h)
{
    char word[64];
    if (!read_head(h))
        return false;
    while (pel_text_word(h->text, word, sizeof word))
        if (!read_keyword(h, word))
            return false;
    if (h->text->failed)
        return false;
    if (pel_text_peek(h->text) >= 0)
        return pel_fail(h->error, PEL_ERROR_FORMAT, "something that is no keyword stands at byte %llu",
                        (unsigned long long)pel_text_tell(h->text));
    if (!h->dims[0])
        return pel_fail(h->error, PEL_ERROR_FORMAT, "DIMENSIONS is missing");
    drop_cells(h);
    return h->array_count || pel_fail(h->error, PEL_ERROR_FORMAT, "there is no array of samples in it");
}
