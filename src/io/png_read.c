/* SPDX-License-Identifier: MIT */
/* PNG in: any of its kinds becomes 8- or 16-bit RGBA in libpng, then premultiplied floats. Colours are taken as sRGB display values, as
 * they stand; a gamma chunk is not applied. */
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>

#include "alloc.h"
#include "fail.h"
#include "image_io.h"
#include "stream.h"

struct reader {
    struct pel_stream *stream;
    struct pel_error *error; /* never NULL */
    struct pel_image *image;
    png_structp png;
    png_infop info;
    unsigned char *pixels;
    png_bytep *rows;
};

static void on_error(png_structp png, png_const_charp message)
{
    struct reader *r = png_get_error_ptr(png);
    if (r->error->code == PEL_ERROR_NONE)
        pel_fail(r->error, PEL_ERROR_FORMAT, "is a damaged PNG: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static void on_read(png_structp png, png_bytep bytes, size_t size)
{
    struct reader *r = png_get_io_ptr(png);
    if (!pel_stream_read_exact(r->stream, bytes, size, r->error))
        png_error(png, "read");
}

static void to_floats(const struct reader *r, int width, int height, bool wide)
{
    for (int y = 0; y < height; y++) {
        const unsigned char *in = r->rows[y];
        float *out = r->image->rgba + (size_t)y * (size_t)width * 4;
        for (int x = 0; x < width; x++, out += 4) {
            for (int c = 0; c < 4; c++, in += wide ? 2 : 1)
                out[c] = wide ? (float)(in[0] * 256 + in[1]) / 65535 : (float)in[0] / 255;
            for (int c = 0; c < 3; c++)
                out[c] *= out[3];
        }
    }
}

static bool read_all(struct reader *r)
{
    if (setjmp(png_jmpbuf(r->png)))
        return false;
    png_set_read_fn(r->png, r, on_read);
    png_set_user_limits(r->png, PEL_IMAGE_MAX, PEL_IMAGE_MAX);
    png_set_chunk_malloc_max(r->png, 1 << 22);
    png_read_info(r->png, r->info);
    int width = (int)png_get_image_width(r->png, r->info), height = (int)png_get_image_height(r->png, r->info);
    /* The compressed pixels cannot be more than deflate's greatest ratio times what is left of the file. */
    uint64_t packed = (uint64_t)png_get_rowbytes(r->png, r->info) * (uint64_t)height, left = pel_stream_bound(r->stream);
    if (packed / 1032 > left)
        return pel_fail(r->error, PEL_ERROR_FORMAT, "the header asks for %d x %d pixels, more than its %llu bytes can hold", width, height,
                        (unsigned long long)left);
    png_set_expand(r->png);
    png_set_gray_to_rgb(r->png);
    png_set_add_alpha(r->png, 0xffff, PNG_FILLER_AFTER);
    png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
    size_t row = png_get_rowbytes(r->png, r->info);
    bool wide = png_get_bit_depth(r->png, r->info) == 16;
    r->pixels = pel_alloc((size_t)height, row, "picture", r->error);
    r->rows = r->pixels ? pel_alloc((size_t)height, sizeof *r->rows, "picture", r->error) : NULL;
    if (!r->rows)
        return false;
    for (int y = 0; y < height; y++)
        r->rows[y] = r->pixels + (size_t)y * row;
    png_read_image(r->png, r->rows);
    png_read_end(r->png, NULL);
    if (!pel_image_allocate(r->image, width, height, false, r->error))
        return false;
    to_floats(r, width, height, wide);
    return true;
}

bool pel_png_read(const char *path, struct pel_image *image, struct pel_error *error)
{
    struct pel_error ignored = PEL_ERROR_INIT;
    struct reader r = { .error = error ? error : &ignored, .image = image };
    r.error->code = PEL_ERROR_NONE;
    r.stream = pel_stream_open(path, PEL_STREAM_AUTO, NULL, r.error);
    if (!r.stream)
        return false;
    r.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, on_error, on_warning);
    r.info = r.png ? png_create_info_struct(r.png) : NULL;
    bool ok = r.info ? read_all(&r) : pel_fail(r.error, PEL_ERROR_MEMORY, "no memory to read a picture");
    png_destroy_read_struct(&r.png, &r.info, NULL);
    pel_stream_close(r.stream);
    free(r.rows);
    free(r.pixels);
    return ok;
}
