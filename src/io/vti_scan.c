/* SPDX-License-Identifier: MIT */
/* The XML part of a VTK ImageData file (.vti), with expat. Only elements and where they stand are taken in here: samples may be gigabytes,
 * and appended raw ones are no XML at all, so parsing ends at the tag AppendedData, and text inside of arrays is stepped over. */
#include <expat.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "sample_layout.h"
#include "text.h"
#include "vti.h"

#define CHUNK (1 << 16)
#define LONGEST_TAG (1 << 20) /* bytes; a longer tag is no VTK file's, and expat would hold all of it in memory */

enum place { OUTSIDE, FILE_TAG, IMAGE, PIECE, POINTS, CELLS, FIELD };

struct scan {
    XML_Parser parser;
    struct pel_vti_header *header;
    struct pel_file_info *info;
    struct pel_error *error;
    struct pel_text *numbers; /* only for reading numbers in attributes */
    bool failed, done;
    enum place place;
    int skipped; /* depth inside of an element that means nothing to us */
    int pieces;
    long long whole[6];
    struct pel_vti_array *current;         /* the array whose element is open, or NULL */
    bool awaits_text;                      /* its numbers, which stand in it, have not begun */
    char scalars[2][128], vectors[2][128]; /* active arrays of points and of cells */
    char field[64];                        /* name of the open FieldData array that is ours, or "" */
    char content[256];                     /* its text */
};

static void stop(struct scan *scan)
{
    XML_StopParser(scan->parser, XML_FALSE);
}

/* An attribute may hold any character, and messages quote it: they stay one line. */
static void keep_line(struct pel_error *error)
{
    for (char *at = error ? error->message : NULL; at && *at; at++)
        if ((unsigned char)*at < ' ')
            *at = ' ';
}

#define refuse(scan, ...) ((scan)->failed = true, pel_fail((scan)->error, __VA_ARGS__), keep_line((scan)->error), stop(scan))

static const char *attribute(const char **attributes, const char *name)
{
    for (; *attributes; attributes += 2)
        if (!strcmp(attributes[0], name))
            return attributes[1];
    return NULL;
}

static bool numbers(struct scan *scan, const char **attributes, const char *name, int count, double *values)
{
    const char *text = attribute(attributes, name);
    if (!text || pel_text_list(scan->numbers, text, count, values))
        return true;
    refuse(scan, PEL_ERROR_FORMAT, "%s=\"%.60s\" is not %d numbers", name, text, count);
    return false;
}

static bool extent(struct scan *scan, const char **attributes, const char *name, long long out[6])
{
    double values[6] = { 0 };
    if (!attribute(attributes, name)) {
        refuse(scan, PEL_ERROR_FORMAT, "attribute %s is missing", name);
        return false;
    }
    if (!numbers(scan, attributes, name, 6, values))
        return false;
    for (int i = 0; i < 6; i++) {
        if (!(fabs(values[i]) <= 2147483647.0) || values[i] != floor(values[i])) {
            refuse(scan, PEL_ERROR_FORMAT, "%s: %g is no index", name, values[i]);
            return false;
        }
        out[i] = (long long)values[i];
    }
    for (int a = 0; a < 3; a++)
        if (out[2 * a + 1] < out[2 * a]) {
            refuse(scan, PEL_ERROR_FORMAT, "%s: from %lld to %lld along axis %d is empty", name, out[2 * a], out[2 * a + 1], a);
            return false;
        }
    return true;
}

static void start_file(struct scan *scan, const char **attributes)
{
    const char *type = attribute(attributes, "type"), *order = attribute(attributes, "byte_order");
    const char *word = attribute(attributes, "header_type"), *compressor = attribute(attributes, "compressor");
    struct pel_vti_header *h = scan->header;
    scan->place = FILE_TAG;
    if (!type || strcmp(type, "ImageData"))
        refuse(scan, PEL_ERROR_UNSUPPORTED, "VTK XML of type %.40s: only ImageData is read", type ? type : "(none)");
    else if (order && strcmp(order, "BigEndian") && strcmp(order, "LittleEndian"))
        refuse(scan, PEL_ERROR_FORMAT, "byte_order=\"%.40s\" is neither LittleEndian nor BigEndian", order);
    else if (word && strcmp(word, "UInt32") && strcmp(word, "UInt64"))
        refuse(scan, PEL_ERROR_FORMAT, "header_type=\"%.40s\" is neither UInt32 nor UInt64", word);
    else if (compressor && *compressor && strcmp(compressor, "vtkZLibDataCompressor"))
        refuse(scan, PEL_ERROR_UNSUPPORTED,
               "compressor %.40s is not read; only vtkZLibDataCompressor (zlib) is: write the file with that one", compressor);
    h->big_endian = order && !strcmp(order, "BigEndian");
    h->word = word && !strcmp(word, "UInt64") ? 8 : 4;
    h->compressed = compressor && *compressor;
}

static void start_image(struct scan *scan, const char **attributes)
{
    struct pel_vti_header *h = scan->header;
    scan->place = IMAGE;
    for (int a = 0; a < 3; a++) {
        h->spacing[a] = 1;
        h->direction[4 * a] = 1;
    }
    if (extent(scan, attributes, "WholeExtent", scan->whole) && numbers(scan, attributes, "Origin", 3, h->origin) &&
        numbers(scan, attributes, "Spacing", 3, h->spacing))
        numbers(scan, attributes, "Direction", 9, h->direction);
}

static void start_piece(struct scan *scan, const char **attributes)
{
    scan->place = PIECE;
    if (++scan->pieces > 1) {
        refuse(scan, PEL_ERROR_UNSUPPORTED, "the image is in several pieces; only one is read: write it as a whole");
        return;
    }
    if (!extent(scan, attributes, "Extent", scan->header->extent))
        return;
    if (memcmp(scan->whole, scan->header->extent, sizeof scan->whole))
        pel_info_note(scan->info, "the file holds only a piece of its whole extent");
}

static void start_attributes(struct scan *scan, const char **attributes, bool cells)
{
    const char *scalars = attribute(attributes, "Scalars"), *vectors = attribute(attributes, "Vectors");
    scan->place = cells ? CELLS : POINTS;
    snprintf(scan->scalars[cells], sizeof scan->scalars[cells], "%s", scalars ? scalars : "");
    snprintf(scan->vectors[cells], sizeof scan->vectors[cells], "%s", vectors ? vectors : "");
}

/* enum pel_type or pel_file_type of VTK's name; -1: unknown. */
static int find_type(const char *name)
{
    static const struct {
        const char *name;
        int type;
    } types[] = {
        { "Int8", PEL_I8 },    { "UInt8", PEL_U8 },       { "Int16", PEL_I16 },       { "UInt16", PEL_U16 },  { "Int32", PEL_I32 },
        { "UInt32", PEL_U32 }, { "Int64", PEL_FILE_I64 }, { "UInt64", PEL_FILE_U64 }, { "Float32", PEL_F32 }, { "Float64", PEL_F64 },
    };
    for (size_t i = 0; name && i < sizeof types / sizeof *types; i++)
        if (!strcmp(name, types[i].name))
            return types[i].type;
    return -1;
}

/* How good an array is as the one that is read where nobody chose. */
static int rank_of(const struct scan *scan, const struct pel_vti_array *array)
{
    bool helper = !strncmp(array->name, "vtkGhost", 8) || !strncmp(array->name, "vtkValid", 8);
    if (array->components > 4 || helper)
        return 0;
    if (!strcmp(array->name, scan->scalars[array->cells]))
        return 5;
    if (!*scan->scalars[array->cells] && array->components == 1)
        return 4;
    return !strcmp(array->name, scan->vectors[array->cells]) ? 3 : array->components == 1 ? 2 : 1;
}

/* Where what follows the tag that is being parsed stands in the file. */
static uint64_t behind_tag(const struct scan *scan)
{
    return (uint64_t)XML_GetCurrentByteIndex(scan->parser) + (uint64_t)XML_GetCurrentByteCount(scan->parser);
}

static void start_array(struct scan *scan, const char **attributes)
{
    struct pel_vti_array array = { .cells = scan->place == CELLS, .components = 1, .format = PEL_VTI_ASCII };
    const char *name = attribute(attributes, "Name"), *type = attribute(attributes, "type"), *format = attribute(attributes, "format");
    double components = 1, offset = 0;
    pel_copy_text(array.name, sizeof array.name, name ? name : "");
    array.type = find_type(type);
    if (!numbers(scan, attributes, "NumberOfComponents", 1, &components) || !numbers(scan, attributes, "offset", 1, &offset))
        return;
    if (format && !strcmp(format, "binary"))
        array.format = PEL_VTI_BINARY;
    else if (format && !strcmp(format, "appended"))
        array.format = PEL_VTI_APPENDED;
    else if (format && strcmp(format, "ascii"))
        refuse(scan, PEL_ERROR_FORMAT, "array '%s': format=\"%.40s\" is none of ascii, binary, appended", array.name, format);
    if (array.type < 0)
        refuse(scan, PEL_ERROR_UNSUPPORTED, "array '%s': type %.40s is not read", array.name, type ? type : "(none)");
    else if (!(components >= 1 && components <= 1024))
        refuse(scan, PEL_ERROR_FORMAT, "array '%s': %g components", array.name, components);
    else if (!(offset >= 0 && offset < 9e15))
        refuse(scan, PEL_ERROR_FORMAT, "array '%s': offset %g", array.name, offset);
    if (scan->failed || scan->header->array_count >= PEL_MAX_ARRAYS)
        return;
    array.components = (int)components;
    array.offset = array.format == PEL_VTI_APPENDED ? (uint64_t)offset : behind_tag(scan);
    scan->current = &scan->header->arrays[scan->header->array_count++];
    *scan->current = array;
    scan->awaits_text = array.format != PEL_VTI_APPENDED;
}

/* An array of FieldData: only those that we wrote ourselves mean something. */
static void start_field_array(struct scan *scan, const char **attributes)
{
    const char *name = attribute(attributes, "Name"), *format = attribute(attributes, "format");
    if (name && !strncmp(name, "pellucid_", 9) && format && !strcmp(format, "ascii"))
        snprintf(scan->field, sizeof scan->field, "%s", name);
    scan->content[0] = '\0';
}

static void XMLCALL start_element(void *user, const char *name, const char **attributes)
{
    struct scan *scan = user;
    bool is_array = !strcmp(name, "DataArray") || !strcmp(name, "Array");
    if (scan->failed)
        return;
    if (scan->skipped || scan->current) {
        scan->skipped++; /* InformationKey inside of an array, and whatever is to come */
    } else if (scan->place == OUTSIDE) {
        if (strcmp(name, "VTKFile"))
            refuse(scan, PEL_ERROR_FORMAT, "the outermost element is %.40s, not VTKFile", name);
        else
            start_file(scan, attributes);
    } else if (scan->place == FILE_TAG && !strcmp(name, "ImageData")) {
        start_image(scan, attributes);
    } else if (scan->place == FILE_TAG && !strcmp(name, "AppendedData")) {
        const char *encoding = attribute(attributes, "encoding");
        scan->header->base64 = !encoding || strcmp(encoding, "raw");
        scan->header->appended = behind_tag(scan);
        scan->done = true;
        stop(scan);
    } else if (scan->place == IMAGE && !strcmp(name, "Piece")) {
        start_piece(scan, attributes);
    } else if (scan->place == PIECE && (!strcmp(name, "PointData") || !strcmp(name, "CellData"))) {
        start_attributes(scan, attributes, *name == 'C');
    } else if (scan->place == IMAGE && !strcmp(name, "FieldData")) {
        scan->place = FIELD;
    } else if ((scan->place == POINTS || scan->place == CELLS) && !strcmp(name, "DataArray")) {
        start_array(scan, attributes);
        if (!scan->current)
            scan->skipped++;
    } else {
        if (scan->place == FIELD && is_array)
            start_field_array(scan, attributes);
        scan->skipped++;
    }
}

/* The text of an array of ours: a string is written as the codes of its bytes. */
static void take_field(struct scan *scan)
{
    struct pel_vti_header *h = scan->header;
    char text[16] = "", *at = scan->content, *end;
    for (size_t n = 0; n + 1 < sizeof text; at = end) {
        long code = strtol(at, &end, 10);
        if (end == at || code <= 0 || code > 255)
            break;
        text[n++] = (char)code;
    }
    if (!strcmp(scan->field, PEL_VTI_UNITS))
        pel_copy_text(h->units, sizeof h->units, text);
    else if (!strcmp(scan->field, PEL_VTI_SPACE))
        pel_copy_text(h->space, sizeof h->space, text);
    else if (!strcmp(scan->field, PEL_VTI_VOID))
        h->has_void = pel_text_list(scan->numbers, scan->content, 1, &h->void_value);
    else if (!strcmp(scan->field, PEL_VTI_LABELS))
        h->labels = atoi(scan->content) == 1;
    scan->field[0] = '\0';
}

static void XMLCALL end_element(void *user, const char *name)
{
    struct scan *scan = user;
    (void)name;
    if (scan->failed)
        return;
    if (scan->skipped) {
        scan->skipped--;
        if (*scan->field && !scan->skipped)
            take_field(scan);
    } else if (scan->current) {
        scan->current = NULL;
    } else {
        scan->place = scan->place == POINTS || scan->place == CELLS  ? PIECE
                      : scan->place == PIECE || scan->place == FIELD ? IMAGE
                      : scan->place == IMAGE                         ? FILE_TAG
                                                                     : OUTSIDE;
    }
}

static void XMLCALL text_piece(void *user, const char *text, int length)
{
    struct scan *scan = user;
    size_t used = strlen(scan->content);
    /* The numbers of an array stand before or behind elements inside of it (InformationKey): they begin with the first text that is no
     * space. */
    if (scan->awaits_text && !scan->skipped && scan->current) {
        int space = 0;
        while (space < length && (text[space] == ' ' || (text[space] >= '\t' && text[space] <= '\r')))
            space++;
        if (space == length)
            return;
        scan->current->offset = (uint64_t)XML_GetCurrentByteIndex(scan->parser);
        scan->awaits_text = false;
    }
    if (*scan->field && (size_t)length < sizeof scan->content - used) {
        memcpy(scan->content + used, text, (size_t)length);
        scan->content[used + (size_t)length] = '\0';
    }
}

static void XMLCALL start_doctype(void *user, const char *name, const char *system, const char *public, int internal)
{
    (void)name, (void)system, (void)public, (void)internal;
    refuse((struct scan *)user, PEL_ERROR_FORMAT, "a DOCTYPE has no place in a VTK file");
}

/* Feeds the file to the parser until it has seen enough. */
static bool feed(struct scan *scan, struct pel_stream *stream)
{
    uint64_t fed = 0;
    size_t got = 1;
    while (got && !scan->done && !scan->failed) {
        void *buffer = XML_GetBuffer(scan->parser, CHUNK);
        if (!buffer)
            return pel_fail(scan->error, PEL_ERROR_MEMORY, "no memory for parsing XML");
        if (!pel_stream_read(stream, buffer, CHUNK, &got, scan->error))
            return false;
        fed += got;
        if (XML_ParseBuffer(scan->parser, (int)got, got == 0) != XML_STATUS_OK && !scan->done && !scan->failed)
            return pel_fail(scan->error, PEL_ERROR_FORMAT, "line %llu: %s", (unsigned long long)XML_GetCurrentLineNumber(scan->parser),
                            XML_ErrorString(XML_GetErrorCode(scan->parser)));
        XML_Index at = XML_GetCurrentByteIndex(scan->parser);
        if (!scan->done && !scan->failed && at >= 0 && fed - (uint64_t)at > LONGEST_TAG)
            return pel_fail(scan->error, PEL_ERROR_FORMAT, "a tag longer than %d bytes is no VTK file's", LONGEST_TAG);
    }
    return !scan->failed;
}

uint64_t pel_vti_dim(const struct pel_vti_header *header, bool cells, int axis)
{
    uint64_t points = (uint64_t)(header->extent[2 * axis + 1] - header->extent[2 * axis]) + 1;
    return cells && points > 1 ? points - 1 : points;
}

/* Ranks the arrays, and drops those of cells where there are any of points. */
static bool settle(struct scan *scan)
{
    struct pel_vti_header *h = scan->header;
    int points = 0;
    if (!scan->pieces)
        return pel_fail(scan->error, PEL_ERROR_FORMAT, "there is no Piece in it");
    for (int i = 0; i < h->array_count; i++) {
        h->arrays[i].rank = rank_of(scan, &h->arrays[i]);
        points += !h->arrays[i].cells;
    }
    for (int i = 0, kept = 0; points && i < h->array_count; i++)
        if (!h->arrays[i].cells)
            h->arrays[kept++] = h->arrays[i];
    if (points)
        h->array_count = points;
    return h->array_count || pel_fail(scan->error, PEL_ERROR_FORMAT, "there is no array of samples in it");
}

bool pel_vti_scan(const char *path, struct pel_vti_header *header, struct pel_file_info *info, struct pel_error *error)
{
    struct scan scan = { .header = header, .info = info, .error = error };
    bool ok = false;
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, NULL, error);
    scan.numbers = pel_alloc(1, sizeof *scan.numbers, "VTK text", error);
    scan.parser = XML_ParserCreate("UTF-8"); /* whatever the file says: its words are ASCII, and places are counted in bytes */
    if (!scan.parser)
        pel_fail(error, PEL_ERROR_MEMORY, "no memory for parsing XML");
    if (stream && scan.numbers && scan.parser && pel_text_init(scan.numbers, stream, error)) {
        XML_SetUserData(scan.parser, &scan);
        XML_SetElementHandler(scan.parser, start_element, end_element);
        XML_SetCharacterDataHandler(scan.parser, text_piece);
        XML_SetStartDoctypeDeclHandler(scan.parser, start_doctype);
        ok = feed(&scan, stream) && settle(&scan);
    }
    if (scan.parser)
        XML_ParserFree(scan.parser);
    if (scan.numbers)
        pel_text_finish(scan.numbers);
    free(scan.numbers);
    pel_stream_close(stream);
    return ok;
}
