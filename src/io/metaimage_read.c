/* SPDX-License-Identifier: MIT */
/* MetaImage: where its samples are and what its axes mean. ITK, whose format it is, has the world in LPS; a file that says nothing of
 * anatomy says nothing of the world either. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "alloc.h"
#include "fail.h"
#include "metaimage.h"

/* The samples as one run of bytes over all data files. */
struct data {
    const char *path;
    const struct pel_metaimage *head;
    const struct pel_read_params *params;
    uint64_t piece, left; /* bytes of one file, and what is left of the one that is open */
    size_t next;
    struct pel_stream *header;  /* behind the header, for LOCAL */
    struct pel_stream *file;    /* owned, or NULL */
    struct pel_stream *inflate; /* owned, or NULL */
    struct pel_text *text;      /* owned, or NULL */
};

static void close_piece(struct data *d)
{
    if (d->text)
        pel_text_finish(d->text);
    free(d->text);
    pel_stream_close(d->inflate);
    pel_stream_close(d->file);
    d->text = NULL;
    d->inflate = d->file = NULL;
}

static bool open_file(struct data *d, const char *name, struct pel_error *error)
{
    char *path = pel_path_of_data(d->path, name, d->params, error);
    if (!path)
        return false;
    struct stat header, data;
    bool there = stat(path, &data) == 0;
    if (there && stat(d->path, &header) == 0 && header.st_dev == data.st_dev && header.st_ino == data.st_ino) {
        pel_fail(error, PEL_ERROR_FORMAT, "is the header itself, named as its own data file");
    } else if (there && !S_ISREG(data.st_mode)) { /* a device or a pipe might keep us for ever */
        pel_fail(error, PEL_ERROR_FORMAT, "is no regular file");
    } else {
        /* gzip is looked through where the length does not say that the file is just the samples. */
        bool exact = there && (uint64_t)data.st_size == d->piece;
        d->file = pel_stream_open(path, d->head->compressed || exact ? PEL_STREAM_PLAIN : PEL_STREAM_AUTO, &d->params->progress, error);
    }
    if (!d->file)
        pel_fail_in(error, "data file %s: ", name);
    free(path);
    return d->file != NULL;
}

static bool skip_header(struct data *d, struct pel_stream *stream, struct pel_error *error)
{
    if (d->head->header_size >= 0)
        return pel_stream_check(stream, (uint64_t)d->head->header_size, "bytes to skip", error) &&
               pel_stream_skip(stream, (uint64_t)d->head->header_size, error);
    uint64_t bound = pel_stream_bound(stream), size = d->head->compressed ? d->head->compressed_size : d->piece;
    if (pel_stream_is_compressed(stream) || bound == UINT64_MAX || size == 0)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "HeaderSize = -1 needs a data file of known length");
    return pel_stream_check(stream, size, "samples", error) && pel_stream_skip(stream, bound - size, error);
}

static bool open_piece(struct data *d, struct pel_error *error)
{
    close_piece(d);
    if (!d->head->local && !open_file(d, d->head->files[d->next], error))
        return false;
    d->next++;
    d->left = d->piece;
    struct pel_stream *stream = d->file ? d->file : d->header;
    if (!skip_header(d, stream, error))
        return false;
    if (d->head->compressed) {
        size_t limit = d->head->compressed_size && d->head->local ? (size_t)d->head->compressed_size : SIZE_MAX;
        d->inflate = pel_stream_over(stream, PEL_STREAM_ZLIB, limit, error);
        return d->inflate && pel_stream_check(d->inflate, d->piece, "samples", error);
    }
    if (d->head->binary)
        return pel_stream_check(stream, d->piece, "samples", error);
    uint64_t count = d->piece / pel_type_size(pel_file_type_in_memory(d->head->type));
    if (!pel_stream_check(stream, count > UINT64_MAX / 2 ? UINT64_MAX : 2 * count - 1, "samples", error))
        return false;
    d->text = pel_alloc(1, sizeof *d->text, "read buffer", error);
    return d->text && pel_text_init(d->text, stream, error);
}

static bool read_data(void *user, void *bytes, size_t size, struct pel_error *error)
{
    struct data *d = user;
    for (size_t done = 0; done < size;) {
        if (d->left == 0 && !open_piece(d, error))
            return false;
        size_t n = size - done < d->left ? size - done : (size_t)d->left;
        unsigned char *out = (unsigned char *)bytes + done;
        bool ok = d->text
                      ? pel_text_file_numbers(d->text, d->head->type, out, n / pel_type_size(pel_file_type_in_memory(d->head->type)), error)
                      : pel_stream_read_exact(d->inflate ? d->inflate
                                              : d->file  ? d->file
                                                         : d->header,
                                              out, n, error);
        if (!ok)
            return d->file ? pel_fail_in(error, "data file %s: ", d->head->files[d->next - 1]) : false;
        done += n;
        d->left -= n;
    }
    return true;
}

static bool lay_out(const struct pel_metaimage *head, struct pel_layout *layout, struct pel_file_info *info, struct pel_error *error)
{
    *layout = (struct pel_layout){ .component_axis = -1, .axes = { -1, -1, -1 }, .type = head->type,
                                   .big_endian = head->binary ? head->big_endian : PEL_HOST_BIG_ENDIAN };
    if (head->dims < 2)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has 1 axis; a volume needs 3, an image 2");
    if (head->channels != 1) {
        layout->component_axis = 0;
        layout->sizes[layout->axis_count++] = head->channels;
    }
    for (int i = 0; i < head->dims; i++) {
        if (i < 3)
            layout->axes[i] = layout->axis_count;
        else if (head->sizes[i] > 1)
            pel_info_note(info, "axis %d has %llu volumes; the first is taken", i, (unsigned long long)head->sizes[i]);
        layout->sizes[layout->axis_count++] = head->sizes[i];
    }
    pel_layout_note(layout, info);
    return true;
}

static void place(const struct pel_metaimage *head, struct pel_volume *volume, struct pel_file_info *info)
{
    for (int a = 0; a < 3; a++) {
        double step[3] = { 0, 0, 0 }, spacing = 1;
        for (int i = 0; i < 3; i++)
            step[i] = head->has_matrix && a < head->dims && i < head->dims ? head->matrix[a * head->dims + i] : a == i;
        if (a < head->dims)
            spacing = head->has_spacing ? head->spacing[a] : head->has_element_size ? head->element_size[a] : 1;
        double unit[3] = { step[0], step[1], step[2] };
        for (int i = 0; i < 3; i++)
            step[i] *= spacing;
        pel_volume_set_axis(volume, a, step, info);
        /* A matrix row that is a unit vector, as it should be, and a good spacing are kept to the bit. */
        double length = sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2]);
        if (fabs(length - 1) < 1e-12 && spacing > 0 && isfinite(spacing)) {
            memcpy(volume->direction[a], unit, sizeof unit);
            volume->spacing[a] = spacing;
        }
        volume->origin[a] = a < head->dims && isfinite(head->offset[a]) ? head->offset[a] : 0;
    }
    pel_volume_mend_directions(volume, info);
    volume->space = head->orientation[0] && strchr(head->orientation, '?') == NULL ? PEL_SPACE_LPS : PEL_SPACE_UNKNOWN;
    memcpy(volume->units, head->units, sizeof volume->units);
    memcpy(volume->name, head->name, sizeof volume->name);
    volume->has_void = head->has_void;
    volume->void_value = head->void_value;
}

static bool read_samples(struct data *d, const struct pel_layout *layout, struct pel_volume *volume, struct pel_error *error)
{
    uint64_t bytes, files = d->head->local ? 1 : d->head->file_count;
    if (!pel_layout_check(layout, &bytes, error))
        return false;
    uint64_t numbers = bytes / pel_type_size(pel_file_type_in_memory(layout->type));
    if (numbers % files != 0)
        return pel_fail(error, PEL_ERROR_FORMAT, "names %llu data files, among which its samples cannot be shared evenly",
                        (unsigned long long)files);
    d->piece = bytes / files;
    for (size_t i = 1; i < d->head->file_count; i++) {
        char *path = pel_path_of_data(d->path, d->head->files[i], d->params, error);
        struct stat st;
        bool there = path && stat(path, &st) == 0;
        if (path && !there)
            pel_fail_errno(error, "data file %s", d->head->files[i]);
        free(path);
        if (!there)
            return false;
    }
    return open_piece(d, error) && pel_layout_read(layout, &(struct pel_sample_source){ read_data, d }, volume, error);
}

/* Keys that begin a MetaImage header, and no other format that is known here. */
static bool probe(const unsigned char *bytes, size_t size, const char *path)
{
    static const char *const keys[] = { "ObjectType", "NDims", "Comment", "ObjectSubType", "TransformType", "ID", "BinaryData", "DimSize" };
    (void)path;
    size_t at = 0;
    while (at < size && (bytes[at] == ' ' || bytes[at] == '\n' || bytes[at] == '\r' || bytes[at] == '\t'))
        at++;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        size_t n = strlen(keys[i]), end = at + n;
        if (end > size || strncasecmp((const char *)bytes + at, keys[i], n) != 0)
            continue;
        while (end < size && (bytes[end] == ' ' || bytes[end] == '\t'))
            end++;
        if (end < size && bytes[end] == '=')
            return true;
    }
    return false;
}

static bool read_metaimage(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                           struct pel_error *error)
{
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, &params->progress, error);
    if (!stream)
        return false;
    struct pel_metaimage head;
    struct pel_layout layout;
    bool ok = pel_metaimage_read_header(stream, &head, error);
    if (ok) {
        struct data data = { .path = path, .head = &head, .params = params, .header = stream };
        ok = lay_out(&head, &layout, info, error);
        if (ok) {
            place(&head, volume, info);
            ok = read_samples(&data, &layout, volume, error);
        }
        close_piece(&data);
        pel_metaimage_finish(&head);
    }
    pel_stream_close(stream);
    return ok;
}

const struct pel_format pel_format_metaimage = {
    .info = { "metaimage", "MetaImage (ITK), one file or .mhd and data", ".mha .mhd", true, true },
    .probe = probe,
    .read = read_metaimage,
    .write = pel_write_metaimage,
};
