/* SPDX-License-Identifier: MIT */
/* The stored pixels of a DICOM file: what of them can be read, where each frame's bytes are, and DICOM's own run-length encoding (PS3.5,
 * annex G). JPEG and its relatives are unpacked in dicom_decode.c. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "dicom_file.h"
#include "fail.h"

#define RLE "1.2.840.10008.1.2.5"

/* Compressed pixels are taken to hold at most so many bytes a byte of the file: blank frames compress well, but a file has a header too. */
#define RATIO 4096

size_t pel_dicom_frame_bytes(const struct pel_dicom_pixels *p)
{
    return (size_t)p->rows * p->columns * (size_t)p->samples * (size_t)(p->allocated / 8); /* 2^16 * 2^16 * 4 * 8 at most */
}

static bool check_kind(const struct pel_dicom_pixels *p, bool encapsulated, struct pel_error *error)
{
    int a = p->allocated;
    if (!p->rows || !p->columns)
        return pel_fail(error, PEL_ERROR_FORMAT, "has no pixels: %u rows of %u", p->rows, p->columns);
    if (p->is_float ? a != 32 && a != 64 : a != 8 && a != 16 && a != 32)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "pixels of %d bits are not read; 8, 16 and 32 are, and floats", a);
    if (!p->is_float && (p->stored < 1 || p->stored > a || p->high_bit < p->stored - 1 || p->high_bit >= a))
        return pel_fail(error, PEL_ERROR_FORMAT, "%d bits stored up to bit %d do not fit into %d", p->stored, p->high_bit, a);
    if (p->samples != 1 && p->samples != 3)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%d numbers a pixel are not read; 1 and 3 are", p->samples);
    bool jpeg = encapsulated && !strncmp(p->photometric, "YBR_FULL", 8); /* turned into RGB where it is unpacked */
    if (p->samples == 3 && strcmp(p->photometric, "RGB") && strcmp(p->photometric, "YBR_RCT") && strcmp(p->photometric, "YBR_ICT") && !jpeg)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "colours as %s are not read; convert them to RGB", p->photometric);
    return true;
}

bool pel_dicom_file_check(const struct pel_dicom_file *file, struct pel_error *error)
{
    const struct pel_dicom_pixels *p = &file->pixels;
    if (!file->has_pixels)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has no pixels: it is no image");
    if (!check_kind(p, file->encapsulated, error))
        return false;
    size_t bytes = pel_dicom_frame_bytes(p), all, most;
    if (file->encapsulated && p->is_float)
        return pel_fail(error, PEL_ERROR_FORMAT, "compressed floats are no DICOM");
    if (!pel_mul(bytes, (size_t)file->frame_count, &all))
        return pel_fail(error, PEL_ERROR_FORMAT, "%llu frames are beyond what can be addressed", (unsigned long long)file->frame_count);
    if (!pel_mul((size_t)file->pixel_length, file->encapsulated ? RATIO : 1, &most) || all > most)
        return pel_fail(error, PEL_ERROR_FORMAT, "the file ends too soon: %zu bytes of pixels cannot be in %llu", all,
                        (unsigned long long)file->pixel_length);
    if (file->encapsulated && file->fragment_count < file->frame_count)
        return pel_fail(error, PEL_ERROR_FORMAT, "%llu fragments of compressed pixels cannot be %llu frames",
                        (unsigned long long)file->fragment_count, (unsigned long long)file->frame_count);
    return true;
}

/* Which fragments make up a frame: one frame has them all, else one a frame, else the offset table tells. */
static bool find_frame(const struct pel_dicom_file *f, uint64_t frame, uint64_t *first, uint64_t *end, struct pel_error *error)
{
    *first = 0;
    *end = f->fragment_count;
    if (f->frame_count == 1)
        return true;
    if (f->fragment_count == f->frame_count) {
        *first = frame;
        *end = frame + 1;
        return true;
    }
    if (f->table_count != f->frame_count)
        return pel_fail(error, PEL_ERROR_FORMAT, "%llu fragments for %llu frames, and no table that tells which is whose",
                        (unsigned long long)f->fragment_count, (unsigned long long)f->frame_count);
    uint64_t base = f->fragments[0] - 8;
    while (*first < f->fragment_count && f->fragments[2 * *first] - 8 - base < f->table[frame])
        ++*first;
    for (*end = *first; *end < f->fragment_count; ++*end)
        if (frame + 1 < f->frame_count && f->fragments[2 * *end] - 8 - base >= f->table[frame + 1])
            break;
    return *first < *end ||
           pel_fail(error, PEL_ERROR_FORMAT, "the offset table has no bytes for frame %llu", (unsigned long long)(frame + 1));
}

/* One run-length encoded segment into every `step`th byte of `count`. */
static bool unpack_runs(const unsigned char *in, size_t size, unsigned char *out, size_t count, size_t step)
{
    size_t at = 0, done = 0;
    while (done < count && at < size) {
        int code = (signed char)in[at++];
        size_t run = code >= 0 ? (size_t)code + 1 : code == -128 ? 0 : (size_t)(1 - code);
        if (run > count - done || (code >= 0 ? run > size - at : run && at >= size))
            return false;
        for (size_t i = 0; i < run; i++)
            out[(done + i) * step] = in[code >= 0 ? at + i : at];
        done += run;
        at += code >= 0 ? (size_t)code + 1 : code != -128;
    }
    return done == count;
}

static uint32_t little32(const unsigned char *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* A segment a byte of a pixel: of each sample, the highest byte first. */
static bool decode_rle(const struct pel_dicom_pixels *p, const unsigned char *bytes, size_t size, unsigned char *out,
                       struct pel_error *error)
{
    size_t width = (size_t)p->allocated / 8, pixel = width * (size_t)p->samples, count = (size_t)p->rows * p->columns;
    uint32_t segments = size >= 64 ? little32(bytes) : 0;
    if (segments != pixel)
        return pel_fail(error, PEL_ERROR_FORMAT, "%u run-length segments for pixels of %zu bytes", segments, pixel);
    for (uint32_t s = 0; s < segments; s++) {
        size_t begin = little32(bytes + 4 + 4 * s), end = s + 1 < segments ? little32(bytes + 8 + 4 * s) : size;
        size_t place = s / width * width + (width - 1 - s % width);
        if (begin < 64 || begin > end || end > size || !unpack_runs(bytes + begin, end - begin, out + place, count, pixel))
            return pel_fail(error, PEL_ERROR_FORMAT, "run-length segment %u is damaged", s + 1);
    }
    return true;
}

static bool read_at(FILE *stream, uint64_t offset, void *out, size_t size, struct pel_error *error)
{
    if (fseeko(stream, (off_t)offset, SEEK_SET) == 0 && fread(out, 1, size, stream) == size)
        return true;
    return pel_fail(error, PEL_ERROR_FORMAT, "the file ends inside of its pixels");
}

static bool read_encapsulated(const struct pel_dicom_file *f, FILE *stream, uint64_t frame, void *out, size_t size, struct pel_error *error)
{
    uint64_t first, end;
    size_t packed = 0, at = 0;
    if (!find_frame(f, frame, &first, &end, error))
        return false;
    for (uint64_t i = first; i < end; i++)
        packed += (size_t)f->fragments[2 * i + 1]; /* held against the file's length, all together */
    unsigned char *bytes = pel_alloc(packed, 1, "compressed pixels", error);
    bool ok = bytes != NULL;
    for (uint64_t i = first; ok && i < end; i++) {
        ok = read_at(stream, f->fragments[2 * i], bytes + at, (size_t)f->fragments[2 * i + 1], error);
        at += (size_t)f->fragments[2 * i + 1];
    }
    if (ok && size / RATIO > packed)
        ok = pel_fail(error, PEL_ERROR_FORMAT, "%zu bytes of pixels cannot be in %zu", size, packed);
    if (ok && !strcmp(f->syntax, RLE) && !strncmp(f->pixels.photometric, "YBR", 3))
        ok = pel_fail(error, PEL_ERROR_UNSUPPORTED, "colours as %s are not read; convert them to RGB", f->pixels.photometric);
    if (ok)
        ok = strcmp(f->syntax, RLE) ? pel_dicom_decode(f->syntax, &f->pixels, bytes, packed, out, size, error)
                                    : decode_rle(&f->pixels, bytes, packed, out, error);
    free(bytes);
    return ok;
}

bool pel_dicom_file_read(const struct pel_dicom_file *file, uint64_t frame, void *out, size_t size, struct pel_error *error)
{
    FILE *stream = fopen(file->path, "rbe");
    if (!stream)
        return pel_fail_errno(error, "cannot be opened");
    bool ok = file->encapsulated ? read_encapsulated(file, stream, frame, out, size, error)
                                 : read_at(stream, file->pixel_offset + frame * size, out, size, error);
    fclose(stream);
    return ok;
}
