/* SPDX-License-Identifier: MIT */
/* NRRD: finds the data, attached or in one or many files, and reads them in any encoding that Teem writes. */
#include <bzlib.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "alloc.h"
#include "fail.h"
#include "nrrd.h"

/* The samples as one run of bytes over all data files. */
struct data {
    const char *path; /* of the header */
    const struct pel_nrrd *head;
    const struct pel_read_params *params;
    int file_type;
    uint64_t bytes;             /* of all samples, decoded */
    uint64_t piece;             /* of one file */
    uint64_t left;              /* of the file that is open */
    size_t next;                /* data file that is opened next */
    struct pel_stream *header;  /* behind the header, for attached data */
    struct pel_stream *file;    /* the data file, owned; or NULL */
    struct pel_stream *inflate; /* over either, owned; or NULL */
    struct pel_text *text;      /* over either, owned; or NULL */
    unsigned char *unpacked;    /* bzip2: all of a file's bytes, owned */
    size_t unpacked_at;
};

static void close_piece(struct data *d)
{
    if (d->text)
        pel_text_finish(d->text);
    free(d->text);
    free(d->unpacked);
    pel_stream_close(d->inflate);
    pel_stream_close(d->file);
    d->text = NULL;
    d->unpacked = NULL;
    d->inflate = d->file = NULL;
}

static bool skip_lines(struct pel_stream *stream, unsigned count, struct pel_error *error)
{
    while (count > 0) {
        char c;
        if (!pel_stream_read_exact(stream, &c, 1, error))
            return pel_fail_in(error, "skipping lines: ");
        count -= c == '\n';
    }
    return true;
}

/* Bytes are skipped in the decoded data of a compressed encoding, in the file of another; -1 - n means: the samples end n bytes before the
 * end. */
static bool skip_bytes(struct data *d, struct pel_stream *stream, struct pel_error *error)
{
    long skip = d->head->nio->byteSkip;
    if (skip >= 0)
        return pel_stream_check(stream, (uint64_t)skip, "bytes to skip", error) && pel_stream_skip(stream, (uint64_t)skip, error);
    uint64_t behind = (uint64_t)(-1 - skip), bound = pel_stream_bound(stream);
    if (d->head->nio->encoding != nrrdEncodingRaw || pel_stream_is_compressed(stream) || bound == UINT64_MAX)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a negative byte skip needs raw, uncompressed data");
    if (behind > bound || d->piece > bound - behind)
        return pel_stream_check(stream, d->piece > UINT64_MAX - behind ? UINT64_MAX : d->piece + behind, "samples", error);
    return pel_stream_skip(stream, bound - behind - d->piece, error);
}

/* bzip2 can make a file of a few bytes out of gigabytes, so the memory grows as the data come and no claim is believed. */
static bool unpack_bzip2(struct data *d, struct pel_stream *stream, struct pel_error *error)
{
    enum { FIRST = 1 << 20 };
    uint64_t skip = d->head->nio->byteSkip > 0 ? (uint64_t)d->head->nio->byteSkip : 0, want = d->piece + skip;
    if (want < skip || want > PTRDIFF_MAX)
        return pel_fail(error, PEL_ERROR_FORMAT, "the product of its sizes is beyond what can be addressed");
    size_t room = want < FIRST ? (size_t)want : FIRST, done = 0;
    char in[1 << 14];
    bz_stream bz = { 0 };
    if (BZ2_bzDecompressInit(&bz, 0, 0) != BZ_OK)
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory to decompress");
    unsigned char *out = pel_alloc(room, 1, "samples", error);
    int status = BZ_OK;
    bool ok = out != NULL;
    while (ok && done < want) {
        size_t got;
        if (bz.avail_in == 0) {
            ok = pel_stream_read(stream, in, sizeof in, &got, error);
            if (ok && got == 0)
                break;
            bz.next_in = in;
            bz.avail_in = ok ? (unsigned)got : 0;
        }
        if (ok && status == BZ_STREAM_END) { /* pbzip2 and cat put several streams in a row */
            char *next = bz.next_in;
            unsigned left = bz.avail_in;
            BZ2_bzDecompressEnd(&bz);
            bz = (bz_stream){ .next_in = next, .avail_in = left };
            ok = BZ2_bzDecompressInit(&bz, 0, 0) == BZ_OK || pel_fail(error, PEL_ERROR_MEMORY, "no memory to decompress");
        }
        if (ok && done == room) {
            room = room > (size_t)want / 2 ? (size_t)want : room * 2;
            unsigned char *more = realloc(out, room);
            ok = more ? true : pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu bytes of samples", room);
            out = more ? more : out;
        }
        size_t n = room - done < 1u << 30 ? room - done : 1u << 30;
        bz.next_out = (char *)out + done;
        bz.avail_out = (unsigned)n;
        status = ok ? BZ2_bzDecompress(&bz) : BZ_OK;
        done += n - bz.avail_out;
        if (status != BZ_OK && status != BZ_STREAM_END)
            ok = pel_fail(error, PEL_ERROR_FORMAT, "the compressed data are damaged");
    }
    BZ2_bzDecompressEnd(&bz);
    if (ok && done < want)
        ok = pel_fail(error, PEL_ERROR_FORMAT, "%llu bytes of samples are missing at the end; the file is truncated",
                      (unsigned long long)(want - done));
    d->unpacked = out;
    d->unpacked_at = (size_t)skip;
    return ok;
}

/* A raw data file that is exactly as long as its samples is not looked through as gzip, whatever its first bytes happen to be. */
static enum pel_stream_coding coding_of(struct data *d, const char *path)
{
    struct stat st;
    bool raw = d->head->nio->encoding == nrrdEncodingRaw && stat(path, &st) == 0 && (uint64_t)st.st_size == d->piece;
    return raw || d->head->nio->encoding == nrrdEncodingGzip ? PEL_STREAM_PLAIN : PEL_STREAM_AUTO;
}

static bool open_file(struct data *d, const char *name, struct pel_error *error)
{
    char *path = pel_path_of_data(d->path, name, d->params, error);
    if (!path)
        return false;
    struct stat header, data;
    bool there = stat(path, &data) == 0;
    if (there && stat(d->path, &header) == 0 && header.st_dev == data.st_dev && header.st_ino == data.st_ino)
        pel_fail(error, PEL_ERROR_FORMAT, "is the header itself, named as its own data file");
    else if (there && !S_ISREG(data.st_mode)) /* a device or a pipe might keep us for ever */
        pel_fail(error, PEL_ERROR_FORMAT, "is no regular file");
    else
        d->file = pel_stream_open(path, coding_of(d, path), &d->params->progress, error);
    if (!d->file)
        pel_fail_in(error, "data file %s: ", name);
    free(path);
    return d->file != NULL;
}

/* Opens what the next piece of the samples is in and gets ready to decode it. */
static bool open_piece(struct data *d, struct pel_error *error)
{
    const NrrdEncoding *encoding = d->head->nio->encoding;
    close_piece(d);
    if (d->head->file_count > 0 && !open_file(d, d->head->files[d->next], error))
        return false;
    d->next++;
    d->left = d->piece;
    struct pel_stream *stream = d->file ? d->file : d->header;
    if (!skip_lines(stream, d->head->nio->lineSkip, error))
        return false;
    if (encoding == nrrdEncodingBzip2)
        return unpack_bzip2(d, stream, error);
    if (encoding == nrrdEncodingGzip) {
        d->inflate = pel_stream_over(stream, PEL_STREAM_ZLIB, SIZE_MAX, error);
        return d->inflate && skip_bytes(d, d->inflate, error) && pel_stream_check(d->inflate, d->piece, "samples", error);
    }
    if (!skip_bytes(d, stream, error))
        return false;
    if (encoding == nrrdEncodingRaw)
        return pel_stream_check(stream, d->piece, "samples", error);
    /* Text: at least one digit and one space a number, or two digits a byte. */
    uint64_t size = pel_type_size(pel_file_type_in_memory(d->file_type));
    uint64_t least = encoding == nrrdEncodingHex ? d->piece : d->piece / size;
    if (!pel_stream_check(stream, least > UINT64_MAX / 2 ? UINT64_MAX : 2 * least - 1, "samples", error))
        return false;
    d->text = pel_alloc(1, sizeof *d->text, "read buffer", error);
    return d->text && pel_text_init(d->text, stream, error);
}

static bool decode(struct data *d, unsigned char *bytes, size_t size, struct pel_error *error)
{
    const NrrdEncoding *encoding = d->head->nio->encoding;
    if (d->unpacked) {
        memcpy(bytes, d->unpacked + d->unpacked_at, size);
        d->unpacked_at += size;
        return true;
    }
    if (d->text && encoding == nrrdEncodingHex)
        return pel_text_hex(d->text, bytes, size, error);
    if (d->text)
        return pel_text_file_numbers(d->text, d->file_type, bytes, size / pel_type_size(pel_file_type_in_memory(d->file_type)), error);
    return pel_stream_read_exact(d->inflate ? d->inflate : d->file ? d->file : d->header, bytes, size, error);
}

static bool read_data(void *user, void *bytes, size_t size, struct pel_error *error)
{
    struct data *d = user;
    for (size_t done = 0; done < size;) {
        if (d->left == 0 && !open_piece(d, error))
            return false;
        size_t n = size - done < d->left ? size - done : (size_t)d->left;
        if (!decode(d, (unsigned char *)bytes + done, n, error))
            return d->file ? pel_fail_in(error, "data file %s: ", d->head->files[d->next - 1]) : false;
        done += n;
        d->left -= n;
    }
    return true;
}

static bool read_samples(struct data *d, const struct pel_layout *layout, struct pel_volume *volume, struct pel_error *error)
{
    const NrrdEncoding *encoding = d->head->nio->encoding;
    if (encoding != nrrdEncodingRaw && encoding != nrrdEncodingGzip && encoding != nrrdEncodingBzip2 && encoding != nrrdEncodingAscii &&
        encoding != nrrdEncodingHex)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has its samples in an encoding that cannot be read (%s)", encoding->name);
    if (!pel_layout_check(layout, &d->bytes, error))
        return false;
    uint64_t files = d->head->file_count > 0 ? d->head->file_count : 1, size = pel_type_size(pel_file_type_in_memory(layout->type));
    if (d->bytes / size % files != 0)
        return pel_fail(error, PEL_ERROR_FORMAT, "names %llu data files, among which its samples cannot be shared evenly",
                        (unsigned long long)files);
    d->piece = d->bytes / files;
    d->file_type = layout->type;
    /* The first file is opened, and its length looked at, before the volume is allocated; one of many says nothing of the others. */
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

static bool probe(const unsigned char *bytes, size_t size, const char *path)
{
    (void)path;
    return size >= 8 && memcmp(bytes, "NRRD", 4) == 0 && bytes[4] >= '0' && bytes[4] <= '9';
}

static bool read_nrrd(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                      struct pel_error *error)
{
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, &params->progress, error);
    if (!stream)
        return false;
    struct pel_nrrd head;
    struct pel_layout layout;
    bool ok = pel_nrrd_read_header(stream, &head, info, error);
    if (ok) {
        struct data data = { .path = path, .head = &head, .params = params, .header = stream };
        ok = pel_nrrd_interpret(&head, &layout, volume, info, error) && read_samples(&data, &layout, volume, error);
        close_piece(&data);
        if (ok)
            pel_nrrd_turn_vectors(&head, &layout, volume);
        pel_nrrd_finish(&head);
    }
    pel_stream_close(stream);
    return ok;
}

const struct pel_format pel_format_nrrd = {
    .info = { "nrrd", "Nearly Raw Raster Data (Teem, 3D Slicer), attached or detached", ".nrrd .nhdr", true, true },
    .probe = probe,
    .read = read_nrrd,
    .write = pel_write_nrrd,
};
