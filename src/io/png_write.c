/* SPDX-License-Identifier: MIT */
/* PNG out: 8 bits, sRGB, rounded to the nearest. libpng reports errors by longjmp, so what must survive one lives in a struct of the
 * caller's. */
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <zlib.h>

#include "alloc.h"
#include "fail.h"
#include "image_io.h"

static void on_error(png_structp png, png_const_charp message)
{
    pel_fail(png_get_error_ptr(png), PEL_ERROR_IO, "writing failed: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static unsigned char to_byte(float v)
{
    /* NaN compares false and becomes 0. */
    return v > 0 ? v < 1 ? (unsigned char)(v * 255 + 0.5f) : 255 : 0;
}

static void opaque_row(const float *in, int width, const float behind[3], unsigned char *out)
{
    for (int x = 0; x < width; x++, in += 4, out += 3) {
        float clear = 1 - in[3];
        clear = clear > 0 ? clear : 0;
        for (int c = 0; c < 3; c++)
            out[c] = to_byte(in[c] + behind[c] * clear);
    }
}

/* PNG's alpha is unassociated: colours are divided by it. */
static void alpha_row(const float *in, int width, unsigned char *out)
{
    for (int x = 0; x < width; x++, in += 4, out += 4) {
        float scale = in[3] > 0 ? 1 / in[3] : 0;
        for (int c = 0; c < 3; c++)
            out[c] = to_byte(in[c] * scale);
        out[3] = to_byte(in[3]);
    }
}

struct writer {
    FILE *file;
    const struct pel_image *image;
    const struct pel_image_write_params *params;
    png_structp png;
    png_infop info;
    unsigned char *row;
};

static bool write_all(struct writer *w)
{
    int width = w->image->width, height = w->image->height;
    const double *b = w->params->background;
    float behind[3] = { (float)(b[0] * b[3]), (float)(b[1] * b[3]), (float)(b[2] * b[3]) };
    if (setjmp(png_jmpbuf(w->png)))
        return false;
    png_init_io(w->png, w->file);
    png_set_IHDR(w->png, w->info, (png_uint_32)width, (png_uint_32)height, 8,
                 w->params->keep_alpha ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(w->png, w->params->compression);
    /* Up to the default level only runs are looked for: after the filter a rendered picture has little else, and it takes half the time. */
    png_set_compression_strategy(w->png, w->params->compression <= 3 ? Z_RLE : Z_FILTERED);
    png_set_compression_buffer_size(w->png, 1 << 16);
    /* One filter for all rows: choosing among five for each row takes longer than it saves. */
    png_set_filter(w->png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_write_info(w->png, w->info);
    for (int y = 0; y < height; y++) {
        const float *in = w->image->rgba + (size_t)y * (size_t)width * 4;
        if (w->params->keep_alpha)
            alpha_row(in, width, w->row);
        else
            opaque_row(in, width, behind, w->row);
        png_write_row(w->png, w->row);
    }
    png_write_end(w->png, NULL);
    return true;
}

bool pel_png_write(FILE *file, const struct pel_image *image, const struct pel_image_write_params *params, struct pel_error *error)
{
    if (image->width > PEL_IMAGE_MAX || image->height > PEL_IMAGE_MAX)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a picture of %d x %d pixels is too large", image->width, image->height);
    struct writer w = { .file = file, .image = image, .params = params };
    struct pel_error ignored = PEL_ERROR_INIT;
    w.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, error ? error : &ignored, on_error, on_warning);
    w.info = w.png ? png_create_info_struct(w.png) : NULL;
    w.row = pel_alloc((size_t)image->width, 4, "picture row", error);
    bool ok = w.info && w.row ? write_all(&w) : pel_fail(error, PEL_ERROR_MEMORY, "no memory to write a picture");
    png_destroy_write_struct(&w.png, &w.info);
    free(w.row);
    return ok;
}
