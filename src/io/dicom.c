/* SPDX-License-Identifier: MIT */
/* DICOM: a file, or a folder with a series of slices. dicom_file.c reads headers, dicom_series.c puts slices in order, dicom_pixels.c and
 * dicom_decode.c unpack pixels; here slices become a volume.
 *
 * Numbers are those that the scanner means, slope and intercept applied. Whole numbers stay whole (CT: stored - 1024 is still an integer);
 * with a slope they become floats. */
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "alloc.h"
#include "dicom_series.h"
#include "fail.h"

#define PIECE 4096 /* numbers converted at a time */

static bool probe_dicom(const unsigned char *bytes, size_t size, const char *path)
{
    (void)path;
    return size >= 132 && !memcmp(bytes + 128, "DICM", 4);
}

/* The files that are images. */
struct files {
    struct pel_dicom_file **all; /* owned, each one too */
    size_t count, room;
    size_t left_out; /* files that are no DICOM images */
};

static void finish_files(struct files *files)
{
    for (size_t i = 0; i < files->count; i++) {
        pel_dicom_file_finish(files->all[i]);
        free(files->all[i]);
    }
    free(files->all);
}

/* Adds a file. In a folder what is no DICOM image is passed over; a damaged one is not, for its slice would be missing. */
static bool add_file(struct files *files, const char *path, bool in_folder, struct pel_error *error)
{
    bool is_dicom;
    if (files->count == files->room) {
        size_t room = files->room ? 2 * files->room : 16;
        struct pel_dicom_file **grown = realloc(files->all, room * sizeof *grown);
        if (!grown)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu files", room);
        files->all = grown;
        files->room = room;
    }
    struct pel_dicom_file *file = pel_alloc(1, sizeof *file, "DICOM file", error);
    if (!file)
        return false;
    bool ok = pel_dicom_file_open(file, path, &is_dicom, error), is_image = ok && file->has_pixels;
    if (is_image || (ok && !in_folder))
        ok = pel_dicom_file_check(file, error);
    if (ok && is_image) {
        files->all[files->count++] = file;
        return true;
    }
    pel_dicom_file_finish(file);
    free(file);
    files->left_out++;
    return in_folder && (ok || !is_dicom);
}

static int is_candidate(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

static bool add_folder(struct files *files, const char *path, const struct pel_progress *progress, struct pel_error *error)
{
    struct dirent **names = NULL;
    int count = scandir(path, &names, is_candidate, alphasort);
    if (count < 0)
        return pel_fail_errno(error, "cannot be read");
    bool ok = true;
    for (int i = 0; i < count; i++) {
        size_t size = strlen(path) + strlen(names[i]->d_name) + 2;
        char *file = ok ? pel_alloc(size, 1, "file name", error) : NULL;
        struct stat st;
        ok = ok && file && pel_progress_report(progress, 0.5 * i / count, error);
        if (ok) {
            snprintf(file, size, "%s/%s", path, names[i]->d_name);
            if (stat(file, &st) == 0 && S_ISREG(st.st_mode) && !(ok = add_file(files, file, true, error)))
                pel_fail_in(error, "%s: ", names[i]->d_name);
        }
        free(file);
        free(names[i]);
    }
    free(names);
    if (ok && !files->count)
        ok = pel_fail(error, PEL_ERROR_FORMAT, "has no DICOM images in it");
    return ok;
}

/* `count` stored numbers as doubles. Bits above the stored ones may hold overlays, and are cut off. */
static void widen(const struct pel_dicom_file *file, const unsigned char *in, size_t count, double *out)
{
    const struct pel_dicom_pixels *p = &file->pixels;
    size_t size = (size_t)p->allocated / 8;
    int shift = p->high_bit + 1 - p->stored;
    uint64_t mask = p->stored < 64 ? ((uint64_t)1 << p->stored) - 1 : UINT64_MAX, sign = p->is_signed ? (uint64_t)1 << (p->stored - 1) : 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits = 0;
        for (size_t b = 0; b < size; b++)
            bits |= (uint64_t)in[i * size + b] << 8 * (file->big_endian ? size - 1 - b : b);
        if (p->is_float && size == 4) {
            uint32_t half = (uint32_t)bits;
            float value;
            memcpy(&value, &half, sizeof value);
            out[i] = (double)value;
        } else if (p->is_float) {
            memcpy(&out[i], &bits, sizeof bits);
        } else {
            bits = bits >> shift & mask;
            out[i] = (double)(int64_t)((bits ^ sign) - sign);
        }
    }
}

/* Stores numbers as the volume's type, from number `at` on; false where one does not fit. */
static bool store(struct pel_volume *volume, size_t at, const double *values, size_t count)
{
#define STORE(TYPE, LEAST, GREATEST)                                                                                                       \
    for (size_t i = 0; i < count; i++) {                                                                                                   \
        if (!(values[i] >= (LEAST) && values[i] <= (GREATEST)))                                                                            \
            return false;                                                                                                                  \
        ((TYPE *)volume->data)[at + i] = (TYPE)values[i];                                                                                  \
    }                                                                                                                                      \
    return true
    switch (volume->type) {
    case PEL_U8:
        STORE(uint8_t, 0, 255);
    case PEL_I8:
        STORE(int8_t, -128, 127);
    case PEL_U16:
        STORE(uint16_t, 0, 65535);
    case PEL_I16:
        STORE(int16_t, -32768, 32767);
    case PEL_U32:
        STORE(uint32_t, 0, 4294967295.0);
    case PEL_I32:
        STORE(int32_t, -2147483648.0, 2147483647.0);
    case PEL_F32:
        for (size_t i = 0; i < count; i++)
            ((float *)volume->data)[at + i] = (float)values[i];
        return true;
    default:
        memcpy((double *)volume->data + at, values, count * sizeof *values);
        return true;
    }
#undef STORE
}

/* What a series' numbers are made into. */
struct scaling {
    bool scaled;                   /* there is a slope, or an intercept that is no whole number */
    double slope[2], intercept[2]; /* least and greatest */
    double stored[2];              /* least and greatest stored number, once read */
};

static void find_scaling(const struct pel_dicom_slice *slices, size_t count, struct scaling *s)
{
    for (size_t i = 0; i < count; i++) {
        const struct pel_dicom_frame *frame = pel_dicom_file_frame(slices[i].file, slices[i].frame);
        s->slope[0] = i ? fmin(s->slope[0], frame->slope) : frame->slope;
        s->slope[1] = i ? fmax(s->slope[1], frame->slope) : frame->slope;
        s->intercept[0] = i ? fmin(s->intercept[0], frame->intercept) : frame->intercept;
        s->intercept[1] = i ? fmax(s->intercept[1], frame->intercept) : frame->intercept;
        s->scaled = s->scaled || frame->slope != 1 || frame->intercept != floor(frame->intercept);
    }
    s->stored[0] = INFINITY;
    s->stored[1] = -INFINITY;
}

/* The types to try, one after the other, PEL_TYPE_COUNT at the end: the first one that holds all numbers is taken. */
static void find_types(const struct pel_dicom_pixels *p, const struct scaling *s, enum pel_type types[5])
{
    static const enum pel_type whole[3][5] = {
        { PEL_U8, PEL_I8, PEL_I16, PEL_I32, PEL_F64 },
        { PEL_U16, PEL_I16, PEL_I32, PEL_F64, PEL_TYPE_COUNT },
        { PEL_U32, PEL_I32, PEL_F64, PEL_TYPE_COUNT, PEL_TYPE_COUNT },
    };
    memcpy(types, whole[p->allocated == 8 ? 0 : p->allocated == 16 ? 1 : 2], sizeof whole[0]);
    if (p->is_signed) {
        types[0] = whole[p->allocated == 8 ? 0 : p->allocated == 16 ? 1 : 2][1];
        types[1] = whole[p->allocated == 8 ? 0 : p->allocated == 16 ? 1 : 2][0];
    }
    if (s->scaled || p->is_float) {
        types[0] = p->allocated <= (p->is_float ? 32 : 16) ? PEL_F32 : PEL_F64;
        types[1] = PEL_TYPE_COUNT;
    }
}

/* One slice's stored numbers, scaled, to their place. *fits: the volume's type holds them. */
static bool convert(const struct pel_dicom_slice *slice, const unsigned char *bytes, struct scaling *s, struct pel_volume *volume, size_t z)
{
    const struct pel_dicom_pixels *p = &slice->file->pixels;
    const struct pel_dicom_frame *frame = pel_dicom_file_frame(slice->file, slice->frame);
    double values[PIECE];
    size_t plane = (size_t)p->rows * p->columns, count = plane * (size_t)p->samples, size = (size_t)p->allocated / 8;
    unsigned char mixed[PIECE * 8];
    for (size_t at = 0, piece; at < count; at += piece) {
        piece = count - at < PIECE ? count - at : PIECE;
        const unsigned char *in = bytes + at * size;
        if (p->planes && p->samples > 1 && !slice->file->encapsulated) {
            for (size_t i = 0; i < piece; i++)
                memcpy(mixed + i * size, bytes + ((at + i) % 3 * plane + (at + i) / 3) * size, size);
            in = mixed;
        }
        widen(slice->file, in, piece, values);
        for (size_t i = 0; i < piece; i++) {
            s->stored[0] = values[i] < s->stored[0] ? values[i] : s->stored[0];
            s->stored[1] = values[i] > s->stored[1] ? values[i] : s->stored[1];
            values[i] = values[i] * frame->slope + frame->intercept;
        }
        if (!store(volume, z * count + at, values, piece))
            return false;
    }
    return true;
}

/* All slices as one type. *fits false: the type does not hold the numbers, and another one is to be tried. */
static bool read_as(const struct pel_dicom_slice *slices, size_t count, enum pel_type type, struct scaling *s, struct pel_volume *volume,
                    const struct pel_progress *progress, bool *fits, struct pel_error *error)
{
    const struct pel_dicom_pixels *p = &slices[0].file->pixels;
    uint64_t dims[3] = { p->columns, p->rows, count };
    size_t shape[3] = { p->columns, p->rows, count }, bytes, frame = pel_dicom_frame_bytes(p);
    if (!pel_volume_size_check(dims, type, (uint64_t)p->samples, &bytes, error) ||
        !pel_volume_allocate(volume, shape, type, p->samples, error))
        return false;
    unsigned char *stored = pel_alloc(frame, 1, "DICOM pixels", error);
    bool ok = stored != NULL;
    *fits = true;
    for (size_t z = 0; ok && *fits && z < count; z++) {
        ok = pel_progress_report(progress, 0.5 + 0.5 * (double)z / (double)count, error);
        if (ok && !(ok = pel_dicom_file_read(slices[z].file, slices[z].frame, stored, frame, error)))
            pel_fail_in(error, "%s: ", pel_dicom_file_name(slices[z].file));
        *fits = ok && convert(&slices[z], stored, s, volume, z);
    }
    free(stored);
    return ok;
}

static void note_scaling(const struct scaling *s, const struct pel_dicom_file *file, struct pel_file_info *info)
{
    if (s->scaled && s->slope[0] == s->slope[1])
        pel_info_note(info, "stored numbers %g to %g are scaled by the file's slope %g and intercept %g", s->stored[0], s->stored[1],
                      s->slope[0], s->intercept[0]);
    else if (s->scaled)
        pel_info_note(info, "stored numbers %g to %g are scaled by the files' slopes, %g to %g from slice to slice", s->stored[0],
                      s->stored[1], s->slope[0], s->slope[1]);
    if (!strcmp(file->pixels.photometric, "MONOCHROME1"))
        pel_info_note(info, "MONOCHROME1: the file wants small values shown bright; the values are as they are");
    else if (!strncmp(file->pixels.photometric, "PALETTE", 7))
        pel_info_note(info, "the colours of a palette are left out: the values are its indices");
}

static bool read_series(const struct files *files, const struct pel_read_params *params, struct pel_volume *volume,
                        struct pel_file_info *info, struct pel_error *error)
{
    uint64_t frames = 0;
    size_t count = 0;
    bool ok = false, fits = false;
    struct scaling scaling = { 0 };
    enum pel_type types[5];
    for (size_t i = 0; i < files->count; i++)
        frames += files->all[i]->frame_count; /* each has pixels in a file */
    struct pel_dicom_slice *slices = pel_alloc((size_t)frames, sizeof *slices, "DICOM slices", error);
    if (!slices || !pel_dicom_series_choose(files->all, files->count, params->array, slices, &count, volume, info, error))
        goto done;
    find_scaling(slices, count, &scaling);
    find_types(&slices[0].file->pixels, &scaling, types);
    ok = true;
    for (int i = 0; ok && !fits && i < 5 && types[i] != PEL_TYPE_COUNT; i++)
        ok = read_as(slices, count, types[i], &scaling, volume, &params->progress, &fits, error);
    if (ok && !fits)
        ok = pel_fail(error, PEL_ERROR_FORMAT, "its numbers fit no type");
    if (ok)
        note_scaling(&scaling, slices[0].file, info);
done:
    free(slices);
    return ok;
}

static bool read_dicom(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                       struct pel_error *error)
{
    struct files files = { 0 };
    struct stat st;
    bool folder = stat(path, &st) == 0 && S_ISDIR(st.st_mode);
    bool ok = folder ? add_folder(&files, path, &params->progress, error) : add_file(&files, path, false, error);
    ok = ok && read_series(&files, params, volume, info, error);
    if (ok && folder && files.left_out)
        pel_info_note(info, "%zu files of the folder are no DICOM images", files.left_out);
    if (ok && !folder && volume->dims[2] == 1)
        pel_info_note(info, "one slice; give the folder to read the series that it may be of");
    finish_files(&files);
    return ok;
}

const struct pel_format pel_format_dicom = {
    .info = { "dicom", "DICOM: a file, or a folder with a series", ".dcm", true, false },
    .folders = true,
    .probe = probe_dicom,
    .read = read_dicom,
};
