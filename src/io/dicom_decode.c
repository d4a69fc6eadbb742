/* SPDX-License-Identifier: MIT */
/* Compressed DICOM pixels: which codec they need. The codecs believe the sizes in the compressed bytes and allocate by them, so those are
 * looked up here first, and held against the header, which was held against the file.
 *
 * The codecs are called one by one, and not through GDCM's classes, which would do it too: those cost every start of the program 30 ms for
 * their dictionaries. */
#include <stdio.h>
#include <string.h>

#include "dicom_decode.h"
#include "dicom_file.h"
#include "fail.h"

enum kind { UNKNOWN, JPEG, JPEG_LS, JPEG_2000 };

/* What compressed bytes say of themselves. */
struct told {
    unsigned long columns, rows;
    int bits, samples;
};

static enum kind find_kind(const char *syntax)
{
    static const struct {
        const char *ending;
        enum kind kind;
    } kinds[] = {
        { "50", JPEG },    { "51", JPEG },    { "57", JPEG },      { "70", JPEG },
        { "80", JPEG_LS }, { "81", JPEG_LS }, { "90", JPEG_2000 }, { "91", JPEG_2000 },
    };
    static const char begin[] = "1.2.840.10008.1.2.4.";
    for (size_t i = 0; !strncmp(syntax, begin, sizeof begin - 1) && i < sizeof kinds / sizeof *kinds; i++)
        if (!strcmp(syntax + sizeof begin - 1, kinds[i].ending))
            return kinds[i].kind;
    return UNKNOWN;
}

static unsigned number16(const unsigned char *p)
{
    return (unsigned)p[0] << 8 | p[1];
}

static unsigned long number32(const unsigned char *p)
{
    return (unsigned long)number16(p) << 16 | number16(p + 2);
}

/* JPEG and JPEG-LS: the frame header (marker SOF), which stands before the first scan. */
static bool read_jpeg(const unsigned char *bytes, size_t size, struct told *told)
{
    if (size < 4 || bytes[0] != 0xff || bytes[1] != 0xd8)
        return false;
    for (size_t at = 2; at + 4 <= size;) {
        unsigned marker = bytes[at + 1], length = number16(bytes + at + 2);
        if (bytes[at] != 0xff)
            return false;
        if (marker == 0xff) {
            at++;
            continue;
        }
        if (((marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) || marker == 0xf7) &&
            at + 10 <= size) {
            *told = (struct told) { number16(bytes + at + 7), number16(bytes + at + 5), bytes[at + 4], bytes[at + 9] };
            return true;
        }
        if (marker == 0xda || length < 2)
            return false;
        at += 2 + length;
    }
    return false;
}

/* JPEG 2000: the marker SIZ, at the beginning, or some way into a JP2 file. Each tile of an image costs kilobytes when it is unpacked, and
 * 14 bytes at least of the file. */
static bool read_jpeg2000(const unsigned char *bytes, size_t size, struct told *told)
{
    for (size_t at = 0; at + 43 <= size && at < 4096; at++) {
        const unsigned char *p = bytes + at + 8;
        if (memcmp(bytes + at, "\xff\x4f\xff\x51", 4))
            continue;
        unsigned long tile_columns = number32(p + 16), tile_rows = number32(p + 20);
        *told = (struct told) { number32(p), number32(p + 4), (p[34] & 0x7f) + 1, (int)number16(p + 32) };
        if (number32(p + 8) || number32(p + 12) || number32(p + 24) || number32(p + 28) || !tile_columns || !tile_rows)
            return false;
        return (told->columns / tile_columns + 1) * (told->rows / tile_rows + 1) <= size / 14 + 4;
    }
    return false;
}

static bool unpack_jpeg(const unsigned char *bytes, size_t size, int bits, const struct pel_dicom_frame_shape *shape, void *out, char *why)
{
    if (bits <= 8)
        return pel_dicom_jpeg8(bytes, size, shape, out, why);
    if (bits <= 12 && pel_dicom_jpeg12(bytes, size, shape, out, why))
        return true;
    return pel_dicom_jpeg16(bytes, size, shape, out, why);
}

bool pel_dicom_decode(const char *syntax, const struct pel_dicom_pixels *pixels, const unsigned char *bytes, size_t size, void *out,
                      size_t out_size, struct pel_error *error)
{
    enum kind kind = find_kind(syntax);
    struct told told;
    char why[PEL_DICOM_WHY] = "";
    struct pel_dicom_frame_shape shape = { pixels->columns, pixels->rows, (unsigned)pixels->samples, (unsigned)pixels->allocated / 8,
                                           pixels->samples == 3 && !strncmp(pixels->photometric, "YBR_FULL", 8) };
    if (kind == UNKNOWN)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "transfer syntax %s is not read; convert it, for example with gdcmconv --raw",
                        syntax);
    if (shape.luma && kind != JPEG)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "colours as %s are not read; convert them to RGB", pixels->photometric);
    if (!(kind == JPEG_2000 ? read_jpeg2000 : read_jpeg)(bytes, size, &told))
        return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels do not begin as they should");
    if (told.columns != shape.columns || told.rows != shape.rows || told.samples != pixels->samples || shape.bytes > 2 ||
        (unsigned)(told.bits + 7) / 8 != shape.bytes || out_size != pel_dicom_frame_bytes(pixels))
        return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels are %lu x %lu of %d x %d bits, the header says %u x %u of %d x %d",
                        told.columns, told.rows, told.samples, told.bits, shape.columns, shape.rows, pixels->samples, pixels->allocated);
    bool ok = kind == JPEG      ? unpack_jpeg(bytes, size, told.bits, &shape, out, why)
              : kind == JPEG_LS ? pel_dicom_jpegls(bytes, size, &shape, out, why)
                                : pel_dicom_jpeg2000(bytes, size, &shape, out, why);
    return ok || pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels are damaged: %s", why);
}
