/* SPDX-License-Identifier: MIT */
/* One page of a TIFF file; see tiff_page.h. libtiff decodes; what a file claims is held against its length before it is let near memory. */
#include "tiff_page.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "alloc.h"
#include "fail.h"

/* Compressed pages are taken to hold at most so many bytes a byte of the file: more than deflate can do (1032), and than any real stack
 * has. */
#define RATIO 4096

struct pel_tiff {
    TIFF *handle;
    FILE *file;           /* the file as it is; NULL where `bytes` are */
    unsigned char *bytes; /* owned: a gzip'd file, unpacked; libtiff must seek */
    uint64_t length, at;
    char message[256]; /* the first error that libtiff told since the last step */
};

static tmsize_t client_read(thandle_t handle, void *out, tmsize_t size)
{
    struct pel_tiff *tiff = handle;
    if (size <= 0 || tiff->at >= tiff->length)
        return 0;
    if ((uint64_t)size > tiff->length - tiff->at)
        size = (tmsize_t)(tiff->length - tiff->at);
    if (tiff->bytes)
        memcpy(out, tiff->bytes + tiff->at, (size_t)size);
    else if (fseeko(tiff->file, (off_t)tiff->at, SEEK_SET) != 0 || fread(out, 1, (size_t)size, tiff->file) != (size_t)size)
        return -1;
    tiff->at += (uint64_t)size;
    return size;
}

static tmsize_t client_write(thandle_t handle, void *bytes, tmsize_t size)
{
    (void)handle, (void)bytes, (void)size;
    return -1;
}

static toff_t client_seek(thandle_t handle, toff_t offset, int whence)
{
    struct pel_tiff *tiff = handle;
    tiff->at = whence == SEEK_CUR ? tiff->at + offset : whence == SEEK_END ? tiff->length + offset : offset;
    return tiff->at;
}

static int client_close(thandle_t handle)
{
    (void)handle;
    return 0;
}

static toff_t client_size(thandle_t handle)
{
    return ((struct pel_tiff *)handle)->length;
}

/* Keeps the first message: those that follow are what comes of it. */
static int on_error(TIFF *handle, void *user, const char *module, const char *format, va_list args)
{
    struct pel_tiff *tiff = user;
    char text[sizeof tiff->message];
    (void)handle, (void)module;
    if (!*tiff->message) {
        vsnprintf(text, sizeof text, format, args);
        pel_copy_text(tiff->message, sizeof tiff->message, text);
    }
    return 1;
}

static int on_warning(TIFF *handle, void *user, const char *module, const char *format, va_list args)
{
    (void)handle, (void)user, (void)module, (void)format, (void)args;
    return 1;
}

static bool fail_with(const struct pel_tiff *tiff, struct pel_error *error, const char *what)
{
    return pel_fail(error, PEL_ERROR_FORMAT, "%s%s%s", what, *tiff->message ? ": " : "", tiff->message);
}

static bool open_bytes(struct pel_tiff *tiff, const char *path, struct pel_error *error)
{
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, NULL, error);
    bool ok = stream != NULL;
    const unsigned char *first;
    size_t size;
    if (ok && (ok = pel_stream_peek(stream, 4, &first, &size, error)) && pel_stream_is_compressed(stream)) {
        ok = pel_stream_read_all(stream, PTRDIFF_MAX, &tiff->bytes, &size, error);
        tiff->length = size;
    } else if (ok) {
        tiff->file = fopen(path, "rbe");
        ok = tiff->file != NULL && fseeko(tiff->file, 0, SEEK_END) == 0;
        if (ok)
            tiff->length = (uint64_t)ftello(tiff->file);
        else
            pel_fail_errno(error, "cannot be opened");
    }
    pel_stream_close(stream);
    return ok;
}

struct pel_tiff *pel_tiff_open(const char *path, struct pel_error *error)
{
    struct pel_tiff *tiff = pel_alloc(1, sizeof *tiff, "TIFF file", error);
    if (!tiff)
        return NULL;
    TIFFOpenOptions *options = NULL;
    if (!open_bytes(tiff, path, error))
        goto fail;
    options = TIFFOpenOptionsAlloc();
    if (!options) {
        pel_fail(error, PEL_ERROR_MEMORY, "no memory for a TIFF file");
        goto fail;
    }
    uint64_t limit = tiff->length < (1 << 8) ? 1 << 20 : tiff->length > PTRDIFF_MAX / RATIO ? PTRDIFF_MAX : tiff->length * RATIO;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, (tmsize_t)limit);
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, tiff);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, tiff);
    /* m: no memory map, which would kill the program if the file shrank meanwhile */
    tiff->handle =
        TIFFClientOpenExt("TIFF", "rm", tiff, client_read, client_write, client_seek, client_close, client_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    if (tiff->handle)
        return tiff;
    fail_with(tiff, error, "is no TIFF file that can be read");
fail:
    pel_tiff_close(tiff);
    return NULL;
}

void pel_tiff_close(struct pel_tiff *tiff)
{
    if (!tiff)
        return;
    if (tiff->handle)
        TIFFClose(tiff->handle);
    if (tiff->file)
        fclose(tiff->file);
    free(tiff->bytes);
    free(tiff);
}

uint64_t pel_tiff_length(const struct pel_tiff *tiff)
{
    return tiff->length;
}

bool pel_tiff_next(struct pel_tiff *tiff)
{
    tiff->message[0] = '\0';
    return !TIFFLastDirectory(tiff->handle) && TIFFReadDirectory(tiff->handle);
}

bool pel_tiff_failed(const struct pel_tiff *tiff, struct pel_error *error)
{
    return !TIFFLastDirectory(tiff->handle) && !fail_with(tiff, error, "cannot be read");
}

bool pel_tiff_rewind(struct pel_tiff *tiff, struct pel_error *error)
{
    tiff->message[0] = '\0';
    return TIFFSetDirectory(tiff->handle, 0) || fail_with(tiff, error, "the first page cannot be read again");
}

bool pel_tiff_is_reduced(struct pel_tiff *tiff)
{
    uint32_t kind = 0;
    TIFFGetFieldDefaulted(tiff->handle, TIFFTAG_SUBFILETYPE, &kind);
    return kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK);
}

/* Type of the numbers, from their format and bits. */
static bool find_type(struct pel_tiff_page *page, unsigned format, struct pel_error *error)
{
    page->type = PEL_TYPE_COUNT;
    if (format == SAMPLEFORMAT_IEEEFP)
        page->type = page->bits == 32 ? PEL_F32 : page->bits == 64 ? PEL_F64 : PEL_TYPE_COUNT;
    else if (format == SAMPLEFORMAT_INT)
        page->type = page->bits == 8 ? PEL_I8 : page->bits == 16 ? PEL_I16 : page->bits == 32 ? PEL_I32 : PEL_TYPE_COUNT;
    else if (format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID)
        page->type = page->bits == 8 || page->bits == 1 ? PEL_U8 : page->bits == 16 ? PEL_U16 : page->bits == 32 ? PEL_U32 : PEL_TYPE_COUNT;
    if (page->type == PEL_TYPE_COUNT)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                        "numbers of %d bits (sample format %u) are not read; 1, 8, 16 and 32 bits are, and floats of 32 and 64", page->bits,
                        format);
    return true;
}

/* How far compressed data can expand, and whether they can be decoded into plain numbers at all. */
static bool find_compression(TIFF *handle, struct pel_tiff_page *page, unsigned photometric, struct pel_error *error)
{
    uint16_t compression = COMPRESSION_NONE;
    TIFFGetFieldDefaulted(handle, TIFFTAG_COMPRESSION, &compression);
    page->ratio = compression == COMPRESSION_NONE ? (page->bits == 1 ? 8 : 1) : RATIO;
    if (!TIFFIsCODECConfigured(compression) || compression == COMPRESSION_OJPEG || compression == COMPRESSION_SGILOG ||
        compression == COMPRESSION_SGILOG24)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "compression %u is not read; write it uncompressed, or with LZW or deflate",
                        compression);
    if (photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG && !page->planes)
        TIFFSetField(handle, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    else if (photometric > PHOTOMETRIC_MASK)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "colour space %u is not read; write gray or RGB", photometric);
    return true;
}

static bool is_gray_ramp(TIFF *handle, int bits)
{
    uint16_t *r, *g, *b;
    if (bits != 8 || !TIFFGetField(handle, TIFFTAG_COLORMAP, &r, &g, &b))
        return false;
    for (int i = 0; i < 256; i++)
        if (r[i] >> 8 != i || g[i] >> 8 != i || b[i] >> 8 != i)
            return false;
    return true;
}

/* The number behind a key such as "spacing=" in a description; 0 where there is none. */
static double number_after(const char *text, const char *key, locale_t locale)
{
    const char *at = strstr(text, key);
    double value = at ? strtod_l(at + strlen(key), NULL, locale) : 0;
    return isfinite(value) && value > 0 ? value : 0;
}

static uint64_t count_after(const char *text, const char *key, locale_t locale)
{
    double value = number_after(text, key, locale);
    return value >= 1 && value < 1e9 ? (uint64_t)value : 1;
}

/* ImageJ: lines of key=value. Pixels a unit are in the resolution tags. */
static void read_imagej(const char *text, double x, double y, locale_t locale, struct pel_tiff_page *page)
{
    char unit[32] = "";
    const char *at = strstr(text, "unit=");
    if (at && sscanf(at, "unit=%31[^\n]", unit) == 1 && strcmp(unit, "pixel") && strcmp(unit, "pixels")) {
        page->spacing[0] = x > 0 ? 1 / x : 0;
        page->spacing[1] = y > 0 ? 1 / y : 0;
        bool micron = !strcmp(unit, "micron") || !strcmp(unit, "microns") || !strcmp(unit, "\\u00B5m") || !strcmp(unit, "\xb5m");
        pel_copy_text(page->units, sizeof page->units, micron ? "um" : unit);
    }
    page->spacing[2] = number_after(text, "\nspacing=", locale);
    page->channels = count_after(text, "\nchannels=", locale);
    page->frames = count_after(text, "\nframes=", locale);
    page->run = count_after(text, "\nimages=", locale);
}

/* OME-XML: attributes of Pixels. Micrometres unless it says otherwise. */
static void read_ome(const char *text, locale_t locale, struct pel_tiff_page *page)
{
    char unit[16] = "um";
    page->spacing[0] = number_after(text, " PhysicalSizeX=\"", locale);
    page->spacing[1] = number_after(text, " PhysicalSizeY=\"", locale);
    page->spacing[2] = number_after(text, " PhysicalSizeZ=\"", locale);
    const char *at = strstr(text, " PhysicalSizeXUnit=\"");
    if (at)
        sscanf(at, " PhysicalSizeXUnit=\"%15[^\"]", unit);
    if (page->spacing[0] > 0)
        pel_copy_text(page->units, sizeof page->units, strcmp(unit, "\xc2\xb5m") && strcmp(unit, "\xce\xbcm") ? unit : "um");
}

/* Distances. Without ImageJ or OME a resolution is that of a scanner or a screen (72 dots an inch), and says nothing of the distance of
 * slices: only its ratio is taken, where pixels are not square. */
static void find_spacing(TIFF *handle, struct pel_tiff_page *page)
{
    float x = 0, y = 0;
    const char *text = NULL;
    locale_t locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    page->channels = page->frames = 1;
    TIFFGetField(handle, TIFFTAG_XRESOLUTION, &x);
    TIFFGetField(handle, TIFFTAG_YRESOLUTION, &y);
    bool told = TIFFGetField(handle, TIFFTAG_IMAGEDESCRIPTION, &text) && text && locale;
    if (told && !strncmp(text, "ImageJ=", 7))
        read_imagej(text, x, y, locale, page);
    else if (told && strstr(text, "<OME") && strstr(text, " PhysicalSizeX=\""))
        read_ome(text, locale, page);
    else if (x > 0 && y > 0 && isfinite(x) && isfinite(y) && fabs(x / y - 1) > 1e-3 && x / y > 0.01 && x / y < 100)
        page->spacing[1] = (double)x / (double)y;
    if (locale)
        freelocale(locale);
}

bool pel_tiff_page_read(struct pel_tiff *tiff, struct pel_tiff_page *page, struct pel_error *error)
{
    TIFF *handle = tiff->handle;
    uint16_t bits = 1, components = 1, format = SAMPLEFORMAT_UINT, planar = PLANARCONFIG_CONTIG, photometric = PHOTOMETRIC_MINISBLACK;
    memset(page, 0, sizeof *page);
    TIFFGetField(handle, TIFFTAG_IMAGEWIDTH, &page->width);
    TIFFGetField(handle, TIFFTAG_IMAGELENGTH, &page->height);
    TIFFGetFieldDefaulted(handle, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(handle, TIFFTAG_SAMPLESPERPIXEL, &components);
    TIFFGetFieldDefaulted(handle, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(handle, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetField(handle, TIFFTAG_PHOTOMETRIC, &photometric);
    page->bits = bits;
    page->components = components;
    page->planes = planar == PLANARCONFIG_SEPARATE && components > 1;
    if (!page->width || !page->height)
        return pel_fail(error, PEL_ERROR_FORMAT, "has no pixels");
    if (components < 1 || components > 4)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "has %u numbers a pixel; 1 to 4 can be read", components);
    if (!find_type(page, format, error) || !find_compression(handle, page, photometric, error))
        return false;
    page->palette = photometric == PHOTOMETRIC_PALETTE && !is_gray_ramp(handle, bits);
    page->white_is_zero = photometric == PHOTOMETRIC_MINISWHITE;
    find_spacing(handle, page);
    page->data = TIFFGetStrileOffset(handle, 0);
    if (page->ratio != 1 || page->planes || TIFFIsTiled(handle))
        page->run = 0;
    page->slice_step = 1;
    return true;
}

bool pel_tiff_page_alike(const struct pel_tiff_page *a, const struct pel_tiff_page *b)
{
    return a->width == b->width && a->height == b->height && a->type == b->type && a->components == b->components;
}

void pel_tiff_choose_slices(struct pel_tiff_page *page, uint64_t *slices, struct pel_file_info *info)
{
    uint64_t sets;
    if (__builtin_mul_overflow(page->channels, page->frames, &sets) || sets <= 1 || *slices % sets || *slices < sets)
        return;
    pel_info_note(info, "a hyperstack of %llu channels and %llu times: the first channel at the first time is read",
                  (unsigned long long)page->channels, (unsigned long long)page->frames);
    page->slice_step = page->channels;
    *slices /= sets;
}

/* A strip or tile as libtiff decoded it: its columns and rows, and how many bytes a row of it has. */
struct chunk {
    uint32_t x, y, width, height;
    size_t pitch;
    const unsigned char *bytes;
};

/* Puts the part of a chunk that lies on the page to its place. plane -1: the chunk has all components. */
static void place_chunk(const struct chunk *chunk, const struct pel_tiff_page *page, int plane, unsigned char *out)
{
    uint32_t width = page->width - chunk->x < chunk->width ? page->width - chunk->x : chunk->width;
    uint32_t height = page->height - chunk->y < chunk->height ? page->height - chunk->y : chunk->height;
    size_t size = pel_type_size(page->type), pixel = size * (size_t)page->components;
    size_t count = (size_t)width * (size_t)(plane < 0 ? page->components : 1);
    for (uint32_t y = 0; y < height; y++) {
        const unsigned char *in = chunk->bytes + y * chunk->pitch;
        unsigned char *row = out + ((size_t)(chunk->y + y) * page->width + chunk->x) * pixel + (size_t)(plane < 0 ? 0 : plane) * size;
        size_t step = plane < 0 ? size : pixel;
        if (page->bits == 1)
            for (size_t i = 0; i < count; i++)
                row[i * step] = in[i / 8] >> (7 - i % 8) & 1;
        else if (plane < 0)
            memcpy(row, in, count * size);
        else
            for (size_t i = 0; i < count; i++)
                memcpy(row + i * step, in + i * size, size);
    }
}

/* Bytes of a row of `width` pixels of a chunk. */
static size_t row_bytes(const struct pel_tiff_page *page, uint32_t width)
{
    size_t numbers = (size_t)width * (size_t)(page->planes ? 1 : page->components);
    return page->bits == 1 ? (numbers + 7) / 8 : numbers * pel_type_size(page->type);
}

/* Reads strip or tile after strip or tile. */
static bool read_chunks(struct pel_tiff *tiff, const struct pel_tiff_page *page, const struct chunk *shape, unsigned char *buffer,
                        size_t size, unsigned char *out, struct pel_error *error)
{
    bool tiled = TIFFIsTiled(tiff->handle);
    struct chunk chunk = *shape;
    uint32_t number = 0;
    chunk.bytes = buffer;
    for (int plane = page->planes ? 0 : -1; plane < (page->planes ? page->components : 0); plane++)
        for (uint64_t y = 0; y < page->height; y += shape->height)
            for (uint64_t x = 0; x < page->width; x += shape->width, number++) {
                chunk.x = (uint32_t)x;
                chunk.y = (uint32_t)y;
                size_t rows = tiled || page->height - y > shape->height ? shape->height : page->height - (size_t)y;
                size_t wanted = rows * chunk.pitch;
                tmsize_t got = wanted > size ? -1
                               : tiled       ? TIFFReadEncodedTile(tiff->handle, number, buffer, (tmsize_t)wanted)
                                             : TIFFReadEncodedStrip(tiff->handle, number, buffer, (tmsize_t)wanted);
                if (got < 0 || (size_t)got != wanted || *tiff->message)
                    return fail_with(tiff, error, tiled ? "a tile is damaged" : "a strip is damaged");
                place_chunk(&chunk, page, plane, out);
            }
    return true;
}

bool pel_tiff_read_samples(struct pel_tiff *tiff, const struct pel_tiff_page *page, void *out, struct pel_error *error)
{
    bool tiled = TIFFIsTiled(tiff->handle);
    struct pel_tiff_page now;
    struct chunk chunk = { .width = page->width };
    tiff->message[0] = '\0';
    /* What is decoded is this page's own layout: planes and bits may differ from the first slice's. */
    if (!pel_tiff_page_read(tiff, &now, error))
        return false;
    if (!pel_tiff_page_alike(page, &now))
        return pel_fail(error, PEL_ERROR_FORMAT, "the file has changed while it was read");
    if (tiled)
        TIFFGetField(tiff->handle, TIFFTAG_TILEWIDTH, &chunk.width);
    TIFFGetFieldDefaulted(tiff->handle, tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP, &chunk.height);
    if (!tiled && chunk.height > now.height)
        chunk.height = now.height;
    if (!chunk.width || !chunk.height)
        return pel_fail(error, PEL_ERROR_FORMAT, "has empty strips or tiles");
    chunk.pitch = row_bytes(&now, chunk.width);
    size_t size;
    if (!pel_mul(chunk.pitch, chunk.height, &size) || size / (RATIO * 4) > tiff->length)
        return pel_fail(error, PEL_ERROR_FORMAT, "tiles of %u x %u cannot be in a file of this length", chunk.width, chunk.height);
    tmsize_t told = tiled ? TIFFTileSize(tiff->handle) : TIFFVStripSize(tiff->handle, chunk.height);
    if (told < 0 || (size_t)told != size)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "pixels that are packed in this way are not read; write gray or RGB");
    unsigned char *buffer = pel_alloc(size, 1, "a TIFF strip", error);
    bool ok = buffer && read_chunks(tiff, &now, &chunk, buffer, size, out, error);
    free(buffer);
    return ok;
}

bool pel_tiff_read_run(struct pel_tiff *tiff, const struct pel_tiff_page *page, uint64_t slice, void *out, size_t bytes,
                       struct pel_error *error)
{
    uint64_t offset;
    if (__builtin_mul_overflow(slice, (uint64_t)bytes, &offset) || __builtin_add_overflow(offset, page->data, &offset) ||
        offset > tiff->length || bytes > tiff->length - offset)
        return pel_fail(error, PEL_ERROR_FORMAT, "the file ends before slice %llu", (unsigned long long)(slice + 1));
    tiff->at = offset;
    if (client_read(tiff, out, (tmsize_t)bytes) != (tmsize_t)bytes)
        return pel_fail(error, PEL_ERROR_IO, "cannot be read");
    if (TIFFIsByteSwapped(tiff->handle))
        pel_swap_bytes(out, bytes / pel_type_size(page->type), pel_type_size(page->type));
    return true;
}
