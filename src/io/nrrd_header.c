/* SPDX-License-Identifier: MIT */
/* The lines of a NRRD header: those that say where the data are we take ourselves, those that say what they are go to Teem. */
#include <ctype.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "nrrd.h"

enum { MAX_HEADER = 1 << 24, MAX_FIELDS = 1 << 17, MAX_LINE = 1 << 16 };

/* Fields that Teem is asked to parse, and those that nothing here depends on. Spaces are left out, as the format allows. */
static const char *const teem_fields[] = {
    "type",           "dimension",  "sizes",       "spacings",        "axismins",         "axismaxs", "centers", "centerings",
    "kinds",          "encoding",    "endian",          "lineskip",         "byteskip", "content", "space",
    "spacedimension", "spaceorigin", "spacedirections", "measurementframe", NULL
};
static const char *const first_fields[] = { "dimension", "space", "spacedimension", NULL };
static const char *const other_fields[] = { "number", "labels", "thicknesses", "min", "max", "oldmin", "oldmax", "sampleunits", "blocksize",
                                            NULL };

struct lines {
    struct pel_stream *stream;
    char *line; /* MAX_LINE */
    size_t total;
    int number;
    /* For Teem, MAX_FIELDS each: the lines on which others depend, and the others. Teem forgets to free what it has when they come too
     * late. */
    char *first, *text;
    size_t first_used, used;
    bool has_dimension;
    char *data_file; /* the "data file" field's value, or NULL */
};

static pthread_mutex_t teem_mutex = PTHREAD_MUTEX_INITIALIZER;

void pel_teem_lock(void)
{
    pthread_mutex_lock(&teem_mutex);
}

void pel_teem_unlock(void)
{
    pthread_mutex_unlock(&teem_mutex);
}

bool pel_fail_teem(struct pel_error *error, enum pel_error_code code, const char *what)
{
    char *said = biffGetDone(NRRD);
    const char *last = said ? said : "";
    /* Teem tells the innermost reason last: "[nrrd] function: reason". */
    for (const char *at = last; *at;) {
        size_t n = strcspn(at, "\n");
        if (n > 0)
            last = at;
        at += n + (at[n] == '\n');
    }
    const char *colon = strstr(last, ": ");
    char reason[200];
    pel_copy_text(reason, sizeof reason, colon && last[0] == '[' ? colon + 2 : last);
    reason[strcspn(reason, "\n")] = 0;
    free(said);
    return pel_fail(error, code, "%s%s%s", what, reason[0] ? ": " : "", reason);
}

/* One line without its end; *there is false at the end of the file. */
static bool read_line(struct lines *in, bool *there, struct pel_error *error)
{
    size_t n = 0, got = 0;
    char c = 0;
    for (;;) {
        if (!pel_stream_read(in->stream, &c, 1, &got, error))
            return false;
        if (got == 0 || c == '\n')
            break;
        if (n + 1 >= MAX_LINE || ++in->total > MAX_HEADER)
            return pel_fail(error, PEL_ERROR_FORMAT, "line %d: the header is too long to be one", in->number + 1);
        in->line[n++] = c ? c : ' ';
    }
    while (n > 0 && in->line[n - 1] == '\r')
        n--;
    in->line[n] = 0;
    in->number++;
    *there = got > 0 || n > 0;
    return true;
}

static bool listed(const char *name, size_t length, const char *const *fields)
{
    char key[32];
    size_t n = 0;
    for (size_t i = 0; i < length; i++)
        if (name[i] != ' ') {
            if (n + 1 >= sizeof key)
                return false;
            key[n++] = (char)tolower((unsigned char)name[i]);
        }
    key[n] = 0;
    for (size_t i = 0; fields[i]; i++)
        if (strcmp(key, fields[i]) == 0)
            return true;
    return false;
}

/* Our own key/value pairs. What does not parse is left alone: other programs may have touched it. */
static void take_key_value(struct pel_nrrd *head, const char *line)
{
    if (strncmp(line, "pellucid.void:=", 15) == 0) {
        char *end;
        head->void_value = strtod(line + 15, &end);
        head->has_void = end != line + 15;
    } else if (strncmp(line, "pellucid.placement:=", 20) == 0) {
        double *d = &head->direction[0][0];
        head->has_placement = sscanf(line + 20, "%lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &head->spacing[0], &head->spacing[1],
                                     &head->spacing[2], d, d + 1, d + 2, d + 3, d + 4, d + 5, d + 6, d + 7, d + 8) == 12;
    }
}

/* Whether a quotation mark is opened and not closed; \" within quotes is no mark. */
static bool ends_in_quotes(const char *line)
{
    bool within = false;
    for (const char *c = line; *c; c++) {
        if (within && c[0] == '\\' && c[1] == '"')
            c++;
        else if (*c == '"')
            within = !within;
    }
    return within;
}

static bool add_line(const struct lines *in, char *text, size_t *used, struct pel_error *error)
{
    int n = snprintf(text + *used, MAX_FIELDS - *used, "%s\n", in->line);
    if (n < 0 || (size_t)n >= MAX_FIELDS - *used)
        return pel_fail(error, PEL_ERROR_FORMAT, "line %d: the header is too long to be one", in->number);
    *used += (size_t)n;
    return true;
}

void pel_nrrd_quoted(const char *values, int index, char *text, size_t size)
{
    text[0] = 0;
    for (const char *open = strchr(values, '"'); open; open = strchr(open, '"'), index--) {
        size_t length = strcspn(open + 1, "\"");
        if (!open[1 + length])
            return; /* a mark too few */
        if (index == 0 && length < size) {
            memcpy(text, open + 1, length);
            text[length] = 0;
            return;
        }
        open += length + 2;
    }
}

static bool take_line(struct lines *in, struct pel_nrrd *head, struct pel_file_info *info, struct pel_error *error)
{
    static const char *const data_file[] = { "datafile", NULL }, *const dimension[] = { "dimension", NULL };
    static const char *const space_units[] = { "spaceunits", NULL }, *const units[] = { "units", NULL };
    const char *line = in->line, *colon = strstr(line, ": "), *pair = strstr(line, ":=");
    if (line[0] == '#')
        return true;
    size_t name = colon ? (size_t)(colon - line) : 0;
    if (colon && listed(line, name, data_file)) {
        if (in->data_file)
            return pel_fail(error, PEL_ERROR_FORMAT, "line %d: says where the data are for a second time", in->number);
        in->data_file = pel_strdup(colon + 2 + strspn(colon + 2, " \t"), error);
        return in->data_file != NULL;
    }
    if (colon && listed(line, name, dimension)) {
        in->has_dimension = true;
        char *end;
        long axes = strtol(colon + 2, &end, 10);
        if (end[strspn(end, " \t")] || axes < 1 || axes > NRRD_DIM_MAX) /* Teem leaks on every field that comes after a bad one */
            return pel_fail(error, PEL_ERROR_FORMAT, "line %d: the dimension is no number from 1 to %d", in->number, NRRD_DIM_MAX);
    }
    if (colon && listed(line, name, teem_fields)) {
        if (ends_in_quotes(line))
            pel_info_note(info, "line %d of the header has a quotation mark too few and is left out", in->number);
        else if (listed(line, name, first_fields))
            return add_line(in, in->first, &in->first_used, error);
        else
            return add_line(in, in->text, &in->used, error);
        return true;
    }
    /* Texts in quotation marks are not for Teem, which leaks on some that do not end. */
    if (colon && (listed(line, name, space_units) || listed(line, name, units))) {
        char *to = listed(line, name, units) ? head->units : head->space_units;
        snprintf(to, sizeof head->units, "%s", colon + 2);
        return true;
    }
    if (colon && listed(line, name, other_fields))
        return true;
    if (pair) {
        take_key_value(head, line);
        return true;
    }
    char shown[64];
    pel_copy_text(shown, sizeof shown, line);
    return pel_fail(error, PEL_ERROR_FORMAT, "line %d: \"%s\" is no field of a NRRD header", in->number, shown);
}

static bool add_file(struct pel_nrrd *head, const char *name, struct pel_error *error)
{
    if (head->file_count >= PEL_NRRD_MAX_FILES)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "names more than %d data files", PEL_NRRD_MAX_FILES);
    if ((head->file_count & (head->file_count - 1)) == 0) {
        char **more = realloc(head->files, (head->file_count ? head->file_count * 2 : 1) * sizeof *more);
        if (!more)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for the names of its data files");
        head->files = more;
    }
    head->files[head->file_count] = pel_strdup(name, error);
    return head->files[head->file_count] && ++head->file_count;
}

/* "slice%03d.raw 1 20 1 [dim]": the only conversion is one %d, with digits before the d; it is never given to printf. */
static bool add_numbered(struct pel_nrrd *head, const char *spec, struct pel_error *error)
{
    char name[1024], tail[1024];
    int least, most, step, width = 0;
    size_t n = strcspn(spec, " \t"), percent = strcspn(spec, "%");
    if (n >= sizeof name || percent >= n || sscanf(spec + n, "%d %d %d", &least, &most, &step) != 3)
        return pel_fail(error, PEL_ERROR_FORMAT, "\"data file\" needs a name with %%d, then least, greatest and step");
    memcpy(name, spec, percent);
    name[percent] = 0;
    size_t at = percent + 1;
    bool zero = spec[at] == '0';
    while (isdigit((unsigned char)spec[at]) && width < 100)
        width = width * 10 + spec[at++] - '0';
    if (spec[at] != 'd' || width > 20 || memchr(spec + at, '%', n - at))
        return pel_fail(error, PEL_ERROR_FORMAT, "\"data file\" has a %% that is no %%d");
    memcpy(tail, spec + at + 1, n - at - 1);
    tail[n - at - 1] = 0;
    if (step == 0 || (step > 0 ? least > most : least < most))
        return pel_fail(error, PEL_ERROR_FORMAT, "\"data file\" counts from %d to %d by %d: that is nothing", least, most, step);
    for (long long i = least; step > 0 ? i <= most : i >= most; i += step) {
        char path[2100];
        snprintf(path, sizeof path, zero ? "%s%0*lld%s" : "%s%*lld%s", name, width, i, tail);
        if (!add_file(head, path, error))
            return false;
    }
    return true;
}

static bool is_list(const char *spec)
{
    return strncmp(spec, "LIST", 4) == 0 && (spec[4] == 0 || isspace((unsigned char)spec[4]));
}

/* Fills head->files from the "data file" field; a LIST's names are the lines that follow it. */
static bool take_data_files(struct lines *in, struct pel_nrrd *head, struct pel_error *error)
{
    const char *spec = in->data_file;
    if (is_list(spec)) {
        for (;;) {
            bool there;
            if (!read_line(in, &there, error))
                return false;
            if (!there || !in->line[0])
                break;
            if (!add_file(head, in->line, error))
                return false;
        }
        return head->file_count > 0 || pel_fail(error, PEL_ERROR_FORMAT, "names no data file after \"data file: LIST\"");
    }
    /* A name with a % and three numbers behind it counts; a name that merely has a % in it is a name. */
    int ignored;
    const char *space = strpbrk(spec, " \t");
    if (space && strchr(spec, '%') && strchr(spec, '%') < space && sscanf(space, "%d", &ignored) == 1)
        return add_numbered(head, spec, error);
    return spec[0] ? add_file(head, spec, error) : pel_fail(error, PEL_ERROR_FORMAT, "names no data file after \"data file:\"");
}

static bool read_lines(struct lines *in, struct pel_nrrd *head, struct pel_file_info *info, struct pel_error *error)
{
    bool there;
    if (!read_line(in, &there, error))
        return false;
    if (strncmp(in->line, "NRRD", 4) != 0)
        return pel_fail(error, PEL_ERROR_FORMAT, "does not begin with NRRD");
    for (;;) {
        if (!read_line(in, &there, error))
            return false;
        if (!there || !in->line[0])
            break;
        if (!take_line(in, head, info, error))
            return false;
        /* The names of a LIST follow at once; nothing of the header comes after them. */
        if (in->data_file && is_list(in->data_file))
            break;
    }
    if (in->data_file)
        return take_data_files(in, head, error);
    return there || pel_fail(error, PEL_ERROR_FORMAT, "ends within its header, and names no data file; it is truncated");
}

/* Goes straight to Teem's parser of header lines: nrrdStringRead, which is around it, loses memory whenever it refuses something at its
 * end. */
static bool parse_fields(const char *text, struct pel_nrrd *head, struct pel_error *error)
{
    static const char magic[] = "NRRD0005";
    head->nrrd = nrrdNew();
    head->nio = nrrdIoStateNew();
    char *line = pel_alloc(sizeof magic, 1, "header", error);
    if (!head->nrrd || !head->nio || !line) {
        free(line);
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory for the header");
    }
    memcpy(line, magic, sizeof magic);
    head->nio->line = line; /* as if it had read it; freed with the state */
    head->nio->lineLen = sizeof magic;
    head->nio->headerStringRead = text;
    head->nio->format = nrrdFormatNRRD;
    head->nio->skipData = 1;
    bool ok =
        nrrdFormatNRRD->read(NULL, head->nrrd, head->nio) == 0 || pel_fail_teem(error, PEL_ERROR_FORMAT, "its header cannot be understood");
    head->nio->headerStringRead = NULL;
    return ok;
}

static bool needed_fields_are_there(const struct pel_nrrd *head, struct pel_error *error)
{
    static const struct {
        int field;
        const char *name;
    } needed[] = { { nrrdField_type, "type" }, { nrrdField_dimension, "dimension" }, { nrrdField_sizes, "sizes" },
                   { nrrdField_encoding, "encoding" } };
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++)
        if (!head->nio->seen[needed[i].field])
            return pel_fail(error, PEL_ERROR_FORMAT, "its header has no \"%s\"", needed[i].name);
    return true;
}

bool pel_nrrd_read_header(struct pel_stream *stream, struct pel_nrrd *head, struct pel_file_info *info, struct pel_error *error)
{
    *head = (struct pel_nrrd){ 0 };
    struct lines in = { .stream = stream };
    in.line = pel_alloc(MAX_LINE, 1, "header", error);
    in.first = in.line ? pel_alloc(2, MAX_FIELDS, "header", error) : NULL;
    in.text = in.first ? in.first + MAX_FIELDS : NULL;
    bool ok = in.text && read_lines(&in, head, info, error);
    if (ok && !in.has_dimension)
        ok = pel_fail(error, PEL_ERROR_FORMAT, "its header has no \"dimension\"");
    if (ok) {
        memmove(in.first + in.first_used, in.text, in.used + 1);
        pel_teem_lock();
        ok = parse_fields(in.first, head, error);
        pel_teem_unlock();
        ok = ok && needed_fields_are_there(head, error);
    }
    free(in.line);
    free(in.first);
    free(in.data_file);
    if (!ok)
        pel_nrrd_finish(head);
    return ok;
}

void pel_nrrd_finish(struct pel_nrrd *head)
{
    for (size_t i = 0; i < head->file_count; i++)
        free(head->files[i]);
    free(head->files);
    if (head->nrrd)
        nrrdNuke(head->nrrd);
    if (head->nio)
        nrrdIoStateNix(head->nio);
    *head = (struct pel_nrrd){ 0 };
}
