/* SPDX-License-Identifier: MIT */
/* PNG at zlib level 1 with runs only (Z_RLE) and one filter: of a rendered picture it is sooner made than WebP's lossless form, whose
 * fastest method takes nearly twice as long (docs/decisions/0010-the-viewer.md). */
#include "encode.h"

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <png.h>
#include <turbojpeg.h>
#include <zlib.h>

#include "session_inside.h"

enum { QUALITY = 85, HIGH_QUALITY = 95 };

struct encoder {
    tjhandle jpeg;
    unsigned char *pixels; /* RGBX or RGBA */
    size_t pixel_room;
    unsigned char *bytes; /* from tjAlloc for JPEG; from malloc for PNG */
    unsigned long jpeg_room;
    unsigned char *png;
    size_t png_size, png_room;
};

struct encoder *encoder_create(struct pel_error *error)
{
    struct encoder *e = calloc(1, sizeof *e);
    if (e && (e->jpeg = tjInitCompress()))
        return e;
    free(e);
    session_fail(error, PEL_ERROR_MEMORY, "no memory to encode pictures");
    return NULL;
}

void encoder_destroy(struct encoder *e)
{
    if (!e)
        return;
    tjDestroy(e->jpeg);
    tjFree(e->bytes);
    free(e->pixels);
    free(e->png);
    free(e);
}

static unsigned char to_byte(float v)
{
    v = v > 0 ? v : 0; /* NaN, too */
    v = v < 1 ? v : 1;
    return (unsigned char)(v * 255 + 0.5f);
}

static void opaque_row(const float *in, int width, const float behind[3], unsigned char *out)
{
    for (int x = 0; x < width; x++) {
        float clear = 1 - in[4 * x + 3];
        clear = clear > 0 ? clear : 0;
        out[4 * x] = to_byte(in[4 * x] + behind[0] * clear);
        out[4 * x + 1] = to_byte(in[4 * x + 1] + behind[1] * clear);
        out[4 * x + 2] = to_byte(in[4 * x + 2] + behind[2] * clear);
        out[4 * x + 3] = 255;
    }
}

static void alpha_row(const float *in, int width, unsigned char *out)
{
    for (int x = 0; x < width; x++) {
        float scale = in[4 * x + 3] > 0 ? 1 / in[4 * x + 3] : 0;
        for (int c = 0; c < 3; c++)
            out[4 * x + c] = to_byte(in[4 * x + c] * scale);
        out[4 * x + 3] = to_byte(in[4 * x + 3]);
    }
}

const unsigned char *encoder_pixels(struct encoder *e, const struct pel_image *image, const double *background, struct pel_error *error)
{
    size_t room = 4 * (size_t)image->width * (size_t)image->height;
    if (room > e->pixel_room) {
        unsigned char *larger = realloc(e->pixels, room);
        if (!larger) {
            session_fail(error, PEL_ERROR_MEMORY, "no memory for a picture of %d x %d pixels", image->width, image->height);
            return NULL;
        }
        e->pixels = larger;
        e->pixel_room = room;
    }
    float behind[3] = { 0, 0, 0 };
    for (int c = 0; background && c < 3; c++)
        behind[c] = (float)(background[c] * background[3]);
#pragma omp parallel for schedule(static) num_threads(2)
    for (int y = 0; y < image->height; y++) {
        size_t at = 4 * (size_t)y * (size_t)image->width;
        if (background)
            opaque_row(image->rgba + at, image->width, behind, e->pixels + at);
        else
            alpha_row(image->rgba + at, image->width, e->pixels + at);
    }
    return e->pixels;
}

bool encode_jpeg(struct encoder *e, const struct pel_image *image, const double background[4], bool high, const void **bytes, size_t *size,
                 struct pel_error *error)
{
    enum TJSAMP sampling = high ? TJSAMP_444 : TJSAMP_420;
    if (!encoder_pixels(e, image, background, error))
        return false;
    unsigned long room = tjBufSize(image->width, image->height, sampling);
    if (room > e->jpeg_room) {
        tjFree(e->bytes);
        e->bytes = tjAlloc((int)room);
        e->jpeg_room = e->bytes ? room : 0;
        if (!e->bytes)
            return session_fail(error, PEL_ERROR_MEMORY, "no memory for a JPEG picture");
    }
    unsigned long made = e->jpeg_room;
    if (tjCompress2(e->jpeg, e->pixels, image->width, 0, image->height, TJPF_RGBX, &e->bytes, &made, sampling,
                    high ? HIGH_QUALITY : QUALITY, TJFLAG_NOREALLOC | (high ? 0 : TJFLAG_FASTDCT)) != 0)
        return session_fail(error, PEL_ERROR_UNSUPPORTED, "JPEG: %s", tjGetErrorStr2(e->jpeg));
    *bytes = e->bytes;
    *size = made;
    return true;
}

/* ---- PNG ---- */

static void on_error(png_structp png, png_const_charp message)
{
    session_fail(png_get_error_ptr(png), PEL_ERROR_MEMORY, "PNG: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png, (void)message;
}

static void on_write(png_structp png, png_bytep data, size_t size)
{
    struct encoder *e = png_get_io_ptr(png);
    if (size > e->png_room - e->png_size) {
        size_t room = 2 * e->png_room + size;
        unsigned char *larger = realloc(e->png, room);
        if (!larger)
            png_error(png, "no memory");
        e->png = larger;
        e->png_room = room;
    }
    memcpy(e->png + e->png_size, data, size);
    e->png_size += size;
}

static void on_flush(png_structp png)
{
    (void)png;
}

static bool write_png(struct encoder *e, png_structp png, png_infop info, const struct pel_image *image, bool alpha, bool small,
                      const struct pel_progress *progress)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_set_write_fn(png, e, on_write, on_flush);
    png_set_IHDR(png, info, (png_uint_32)image->width, (png_uint_32)image->height, 8, alpha ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, small ? 5 : 1);
    png_set_compression_strategy(png, small ? Z_FILTERED : Z_RLE);
    png_set_compression_buffer_size(png, 1 << 16);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_write_info(png, info);
    if (!alpha)
        png_set_filler(png, 0, PNG_FILLER_AFTER);
    for (int y = 0; y < image->height; y++) {
        if (progress && !progress->update(progress->user, (double)y / image->height))
            return session_fail(png_get_error_ptr(png), PEL_ERROR_CANCELLED, "cancelled");
        png_write_row(png, e->pixels + 4 * (size_t)y * (size_t)image->width);
    }
    png_write_end(png, NULL);
    return true;
}

bool encode_png(struct encoder *e, const struct pel_image *image, const double *background, bool small, const struct pel_progress *progress,
                const void **bytes, size_t *size, struct pel_error *error)
{
    struct pel_error ignored = PEL_ERROR_INIT;
    if (!encoder_pixels(e, image, background, error))
        return false;
    e->png_size = 0;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, error ? error : &ignored, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool ok = info ? write_png(e, png, info, image, !background, small, progress)
                   : session_fail(error, PEL_ERROR_MEMORY, "no memory to write a PNG");
    png_destroy_write_struct(&png, &info);
    *bytes = e->png;
    *size = e->png_size;
    return ok;
}
