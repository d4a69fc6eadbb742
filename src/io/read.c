/* SPDX-License-Identifier: MIT */
/* pel_read_volume: finds the format by content, then by name, lets it read, and makes sure of what it gave. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "alloc.h"
#include "c_locale.h"
#include "fail.h"
#include "format.h"

/* The format that the beginning of a file tells, or NULL. */
static const struct pel_format *probe_bytes(const unsigned char *bytes, size_t size, const char *path)
{
    for (size_t i = 0; pel_formats[i]; i++)
        if (pel_formats[i]->probe && pel_formats[i]->read && pel_formats[i]->probe(bytes, size, path))
            return pel_formats[i];
    return NULL;
}

/* The name without a trailing .gz, for looking at its ending. Cut where it is too long: endings that far out do not matter. */
static void without_gz(const char *path, char *out, size_t size)
{
    size_t length = strlen(path);
    const char *tail = length >= size ? path + length - size + 1 : path;
    snprintf(out, size, "%s", tail);
    length = strlen(out);
    if (length > 3 && pel_path_has_ending(out, ".gz"))
        out[length - 3] = 0;
}

static const struct pel_format *format_by_ending(const char *path)
{
    char name[512];
    without_gz(path, name, sizeof name);
    for (size_t i = 0; pel_formats[i]; i++)
        if (pel_formats[i]->read && pel_formats[i] != &pel_format_raw && pel_path_has_ending(name, pel_formats[i]->info.endings))
            return pel_formats[i];
    return NULL;
}

/* "nrrd, nifti, ..." */
static void list_formats(char *out, size_t size)
{
    size_t used = 0;
    out[0] = 0;
    for (size_t i = 0; pel_formats[i] && used < size; i++)
        if (pel_formats[i]->read && pel_formats[i] != &pel_format_raw)
            used += (size_t)snprintf(out + used, size - used, "%s%s", used ? ", " : "", pel_formats[i]->info.name);
}

static const struct pel_format *find_in_file(const char *path, struct pel_error *error)
{
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, NULL, error);
    if (!stream)
        return NULL;
    const unsigned char *bytes;
    size_t size;
    const struct pel_format *found = NULL;
    if (!pel_stream_peek(stream, PEL_PROBE_SIZE, &bytes, &size, error))
        goto done;
    if (size == 0) {
        pel_fail(error, PEL_ERROR_FORMAT, "is empty");
        goto done;
    }
    found = probe_bytes(bytes, size, path);
    if (!found)
        found = format_by_ending(path);
    if (!found) {
        char names[128];
        list_formats(names, sizeof names);
        pel_fail(error, PEL_ERROR_UNSUPPORTED,
                 "is in no format that is known (%s); for raw samples give their layout, such as --raw 256x256x256:u8", names);
    }
done:
    pel_stream_close(stream);
    return found;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

/* A folder is what most of its first files are, of the formats that read folders. */
static const struct pel_format *find_in_folder(const char *path, struct pel_error *error)
{
    enum { LOOK_AT = 32 };
    struct dirent **names = NULL;
    int count = scandir(path, &names, NULL, by_name);
    if (count < 0) {
        pel_fail_errno(error, "cannot be read");
        return NULL;
    }
    int votes[PEL_MOST_FORMATS] = { 0 }, looked = 0;
    for (int n = 0; n < count && looked < LOOK_AT; n++) {
        size_t size = strlen(path) + strlen(names[n]->d_name) + 2;
        char *file = names[n]->d_name[0] == '.' ? NULL : pel_alloc(size, 1, "file name", NULL);
        struct stat st;
        if (file)
            snprintf(file, size, "%s/%s", path, names[n]->d_name);
        struct pel_stream *stream =
            file && stat(file, &st) == 0 && S_ISREG(st.st_mode) ? pel_stream_open(file, PEL_STREAM_AUTO, NULL, NULL) : NULL;
        const unsigned char *bytes;
        size_t got;
        if (stream && pel_stream_peek(stream, PEL_PROBE_SIZE, &bytes, &got, NULL)) {
            const struct pel_format *format = probe_bytes(bytes, got, file);
            looked++;
            for (int i = 0; pel_formats[i]; i++)
                votes[i] += pel_formats[i] == format && format->folders;
        }
        pel_stream_close(stream);
        free(file);
    }
    for (int n = 0; n < count; n++)
        free(names[n]);
    free(names);
    int best = -1;
    for (int i = 0; pel_formats[i]; i++)
        if (votes[i] > (best < 0 ? 0 : votes[best]))
            best = i;
    if (best >= 0)
        return pel_formats[best];
    pel_fail(error, PEL_ERROR_FORMAT, "is a folder with no DICOM or TIFF slices in it");
    return NULL;
}

static const struct pel_format *find_format(const char *path, const struct pel_read_params *params, struct pel_error *error)
{
    if (params->raw)
        return &pel_format_raw;
    struct stat st;
    if (stat(path, &st) != 0) {
        pel_fail_errno(error, "cannot be opened");
        return NULL;
    }
    return S_ISDIR(st.st_mode) ? find_in_folder(path, error) : find_in_file(path, error);
}

/* A file with one array has it listed here; asking it for another by name is a mistake that must not pass unnoticed. */
static bool check_only_array(const struct pel_read_params *params, const struct pel_volume *volume, struct pel_file_info *facts,
                             struct pel_error *error)
{
    if (facts->array_count > 0)
        return true;
    pel_info_array(facts, volume->name, volume->type, volume->components);
    return pel_info_choose(facts, params, 0, error) >= 0;
}

bool pel_read_volume(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                     struct pel_error *error)
{
    static const struct pel_read_params defaults = PEL_READ_PARAMS_INIT;
    if (!params)
        params = &defaults;
    struct pel_file_info *facts = pel_alloc(1, sizeof *facts, "file facts", error);
    if (!facts)
        return pel_fail_in(error, "%s: ", path);
    const struct pel_c_locale locale = pel_c_locale_begin();
    const struct pel_format *format = find_format(path, params, error);
    bool ok = format && format->read(path, params, volume, facts, error) && pel_volume_check(volume, error) &&
              check_only_array(params, volume, facts, error);
    if (ok) {
        snprintf(facts->format, sizeof facts->format, "%s", format->info.name);
        pel_volume_update_range(volume);
        if (!volume->labels)
            pel_volume_detect_labels(volume);
        if (info)
            *info = *facts;
    } else {
        pel_volume_finish(volume);
        pel_fail_in(error, "%s: ", path);
    }
    pel_c_locale_end(&locale);
    free(facts);
    return ok;
}
