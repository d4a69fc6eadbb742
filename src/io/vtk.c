/* SPDX-License-Identifier: MIT */
/* VTK legacy files (.vtk) with DATASET STRUCTURED_POINTS, ASCII and BINARY (big-endian), versions 1.0 to 5.1.
 *
 * A file may hold several arrays, and which one is wanted is known only after all were seen. So the file is walked twice: once to
 * list the arrays and where their numbers begin (vtk_scan.c), once, forward only because the file may be gzip'd, to read the chosen one. */
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "sample_layout.h"
#include "vtk.h"

static bool probe_vtk(const unsigned char *bytes, size_t size, const char *path)
{
    (void)path;
    return size >= 14 && !memcmp(bytes, "# vtk DataFile", 14);
}

/* What is read where nobody chose: the first scalars, else the first vectors, else the first that can be read, of one component if there
 * is. */
static int default_array(const struct pel_vtk_header *h)
{
    int best = 0, best_rank = 0;
    for (int i = 0; i < h->array_count; i++) {
        const struct pel_vtk_array *array = &h->arrays[i];
        int rank = array->components > 4                                      ? 0
                   : array->kind == PEL_VTK_SCALARS && array->components == 1 ? 5
                   : array->kind == PEL_VTK_SCALARS                           ? 4
                   : array->kind == PEL_VTK_VECTORS                           ? 3
                   : array->components == 1                                   ? 2
                                                                              : 1;
        if (rank > best_rank) {
            best_rank = rank;
            best = i;
        }
    }
    return best;
}

static void place(const struct pel_vtk_header *h, bool cells, struct pel_volume *volume)
{
    for (int a = 0; a < 3; a++) {
        double step[3] = { 0 };
        step[a] = h->spacing[a];
        pel_volume_set_axis(volume, a, step, h->info);
        volume->origin[a] = h->origin[a] + (cells && h->dims[a] > 1 ? h->spacing[a] / 2 : 0);
    }
    if (cells)
        pel_info_note(h->info, "the file has values of cells, not of points: a sample stands at each cell's centre");
}

/* One bit a number to a byte a number; the bits stand at the start of `count` bytes. From the end: byte i is not needed any more. */
static void unpack_bits(unsigned char *bytes, size_t count)
{
    for (size_t i = count; i-- > 0;)
        bytes[i] = bytes[i / 8] >> (7 - i % 8) & 1;
}

/* Colours from 0 to 1, as the bytes that they were. */
static bool read_colours(struct pel_vtk_header *h, unsigned char *out, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float value;
        if (!pel_text_numbers(h->text, PEL_F32, 1, &value))
            return false;
        out[i] = value >= 1 ? 255 : value > 0 ? (unsigned char)(value * 255 + 0.5f) : 0;
    }
    return true;
}

/* The chosen array's numbers; the text stands at their beginning. */
static bool read_samples(struct pel_vtk_header *h, const struct pel_vtk_array *array, struct pel_volume *volume)
{
    uint64_t dims[3], stored;
    size_t bytes, shape[3];
    for (int a = 0; a < 3; a++)
        shape[a] = (size_t)(dims[a] = array->cells && h->dims[a] > 1 ? h->dims[a] - 1 : h->dims[a]);
    if (array->components > 4)
        return pel_fail(h->error, PEL_ERROR_UNSUPPORTED, "array '%s' has %d components; 1 to 4 are read", array->name, array->components);
    enum pel_type type = pel_file_type_in_memory(array->type);
    if (!pel_volume_size_check(dims, type, (uint64_t)array->components, &bytes, h->error))
        return false;
    size_t count = bytes / pel_type_size(type);
    /* The scan stepped over these numbers, so they are there, unless the file has changed since. */
    if (!pel_vtk_stored_bytes(array, count, &stored) || (h->binary ? stored : count / 2) > pel_text_left(h->text))
        return pel_fail(h->error, PEL_ERROR_FORMAT, "the file ends in array '%s'", array->name);
    if (!pel_volume_allocate(volume, shape, type, array->components, h->error))
        return false;
    if (!h->binary && array->unit)
        return read_colours(h, volume->data, count);
    if (!h->binary)
        return pel_text_numbers(h->text, type, count, volume->data);
    if (!pel_text_bytes(h->text, volume->data, (size_t)stored))
        return false;
    if (array->bits)
        unpack_bits(volume->data, count);
    else if (!PEL_HOST_BIG_ENDIAN)
        pel_swap_bytes(volume->data, count, pel_type_size(type));
    return array->type < PEL_TYPE_COUNT || pel_int64_to_f64(volume->data, count, array->type == PEL_FILE_U64, h->error);
}

/* A text over the file, from its beginning. */
static bool open_text(struct pel_vtk_header *h, const char *path, const struct pel_progress *progress)
{
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, progress, h->error);
    if (stream && pel_text_init(h->text, stream, h->error))
        return true;
    pel_stream_close(stream);
    h->text->stream = NULL;
    return false;
}

static void close_text(struct pel_vtk_header *h)
{
    struct pel_stream *stream = h->text->stream;
    pel_text_finish(h->text);
    pel_stream_close(stream);
    h->text->stream = NULL;
}

static bool read_vtk(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                     struct pel_error *error)
{
    bool ok = false;
    struct pel_vtk_header *h = pel_alloc(1, sizeof *h, "VTK header", error);
    if (!h)
        return false;
    h->error = error;
    h->info = info;
    h->spacing[0] = h->spacing[1] = h->spacing[2] = 1;
    h->text = pel_alloc(1, sizeof *h->text, "VTK text", error);
    if (!h->text || !open_text(h, path, NULL) || !pel_vtk_scan(h))
        goto done;
    for (int i = 0; i < h->array_count; i++)
        pel_info_array(info, h->arrays[i].name, pel_file_type_in_memory(h->arrays[i].type), h->arrays[i].components);
    int chosen = pel_info_choose(info, params, default_array(h), error);
    if (chosen < 0)
        goto done;
    const struct pel_vtk_array *array = &h->arrays[chosen];
    close_text(h);
    if (!open_text(h, path, &params->progress) || !pel_text_skip(h->text, array->offset) || !read_samples(h, array, volume))
        goto done;
    place(h, array->cells, volume);
    pel_copy_text(volume->name, sizeof volume->name, array->name);
    ok = true;
done:
    if (h->text)
        close_text(h);
    free(h->text);
    free(h);
    return ok;
}

const struct pel_format pel_format_vtk = {
    .info = { "vtk", "VTK legacy structured points, ASCII or binary", ".vtk", true, false },
    .probe = probe_vtk,
    .read = read_vtk,
};
