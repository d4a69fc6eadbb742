/* SPDX-License-Identifier: MIT */
/* Pictures: PNG and float NRRD, out and in. */
#include "support.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void make_picture(struct pel_image *image, int width, int height)
{
    pel_image_init(image);
    assert_true(pel_image_allocate(image, width, height, true, NULL));
    for (int i = 0; i < width * height; i++) {
        float alpha = (float)(i % 5) / 4;
        for (int c = 0; c < 3; c++)
            image->rgba[4 * i + c] = alpha * (float)((i * 7 + c * 31) % 256) / 255;
        image->rgba[4 * i + 3] = alpha;
        image->depth[i] = i % 3 ? (float)i / 3 : INFINITY;
    }
}

static void written_blended(void **state)
{
    (void)state;
    struct pel_image image, read;
    struct pel_image_write_params params = PEL_IMAGE_WRITE_PARAMS_INIT;
    make_picture(&image, 19, 13);
    pel_image_init(&read);
    params.background[0] = 1;
    params.background[1] = 0.5;
    assert_true(pel_write_image(scratch("b.png"), &image, &params, NULL));
    assert_true(pel_read_image(scratch("b.png"), &read, NULL));
    assert_true(read.width == 19 && read.height == 13 && !read.depth);
    const float behind[3] = { 1, 0.5f, 0 };
    for (int i = 0; i < 19 * 13; i++) {
        assert_true(read.rgba[4 * i + 3] == 1);
        for (int c = 0; c < 3; c++) {
            float is = image.rgba[4 * i + c] + behind[c] * (1 - image.rgba[4 * i + 3]);
            assert_true(fabsf(read.rgba[4 * i + c] - is) <= 0.5f / 255 + 1e-6f);
        }
    }
    pel_image_finish(&image);
    pel_image_finish(&read);
}

static void alpha_is_kept(void **state)
{
    (void)state;
    struct pel_image image, read;
    struct pel_image_write_params params = PEL_IMAGE_WRITE_PARAMS_INIT;
    make_picture(&image, 16, 16);
    pel_image_init(&read);
    params.keep_alpha = true;
    for (params.compression = 0; params.compression <= 9; params.compression += 3) {
        assert_true(pel_write_image(scratch("a.png"), &image, &params, NULL));
        assert_true(pel_read_image(scratch("a.png"), &read, NULL));
        for (int i = 0; i < 4 * 16 * 16; i++)
            assert_true(fabsf(read.rgba[i] - image.rgba[i]) <= 0.5f / 255 + 1e-6f);
    }
    /* Unassociated in the file: half transparent white is white there. */
    for (int c = 0; c < 4; c++)
        image.rgba[c] = 0.5f;
    assert_true(pel_write_image(scratch("a.png"), &image, &params, NULL) == false);
    params.compression = 3;
    assert_true(pel_write_image(scratch("a.png"), &image, &params, NULL));
    png_image png = { .version = PNG_IMAGE_VERSION };
    assert_true(png_image_begin_read_from_file(&png, scratch("a.png")));
    png.format = PNG_FORMAT_RGBA;
    unsigned char pixels[16 * 16 * 4];
    assert_true(png_image_finish_read(&png, NULL, pixels, 0, NULL));
    assert_memory_equal(pixels, ((unsigned char[]){ 255, 255, 255, 128 }), 4);
    pel_image_finish(&image);
    pel_image_finish(&read);
}

/* Values that no byte has: beyond 0 to 1, NaN, and exactly between two. */
static void odd_values(void **state)
{
    (void)state;
    struct pel_image image, read;
    pel_image_init(&image);
    pel_image_init(&read);
    assert_true(pel_image_allocate(&image, 2, 1, false, NULL));
    memcpy(image.rgba, ((float[]){ -1, 7, NAN, 1, 99.5f / 255, 99.49f / 255, 0, 1 }), 8 * sizeof(float));
    assert_true(pel_write_image(scratch("o.png"), &image, NULL, NULL));
    assert_true(pel_read_image(scratch("o.png"), &read, NULL));
    const float bytes[8] = { 0, 255, 0, 255, 100, 99, 0, 255 };
    for (int i = 0; i < 8; i++)
        assert_true(fabsf(read.rgba[i] * 255 - bytes[i]) < 1e-3f);
    pel_image_finish(&image);
    pel_image_finish(&read);
}

static void float_pictures(void **state)
{
    (void)state;
    struct pel_image image, read;
    struct pel_volume depth;
    make_picture(&image, 7, 5);
    pel_image_init(&read);
    assert_true(pel_write_image(scratch("f.nrrd"), &image, NULL, NULL));
    assert_true(pel_read_image(scratch("f.nrrd"), &read, NULL));
    assert_true(read.width == 7 && read.height == 5);
    assert_memory_equal(read.rgba, image.rgba, 7 * 5 * 4 * sizeof(float));
    assert_true(pel_write_depth(scratch("d.nrrd"), &image, NULL));
    read_ok(scratch("d.nrrd"), &depth, NULL);
    assert_memory_equal(depth.dims, ((size_t[]){ 7, 5, 1 }), sizeof depth.dims);
    assert_memory_equal(depth.data, image.depth, 7 * 5 * sizeof(float));
    pel_volume_finish(&depth);
    /* One value a pixel is gray. */
    assert_true(pel_read_image(scratch("d.nrrd"), &read, NULL));
    assert_true(read.rgba[4] == image.depth[1] && read.rgba[6] == image.depth[1] && read.rgba[7] == 1);
    struct pel_error error = PEL_ERROR_INIT;
    free(image.depth);
    image.depth = NULL;
    assert_false(pel_write_depth(scratch("d.nrrd"), &image, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_false(pel_write_image(scratch("d.jpg"), &image, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    pel_image_finish(&image);
    pel_image_finish(&read);
}

/* Kinds of PNG that other programs write. */
static void foreign_png(void **state)
{
    (void)state;
    struct pel_image read;
    pel_image_init(&read);
    static const struct {
        int color, depth, interlace;
    } kinds[] = { { PNG_COLOR_TYPE_GRAY, 1, 0 },    { PNG_COLOR_TYPE_GRAY, 16, 1 }, { PNG_COLOR_TYPE_GRAY_ALPHA, 8, 0 },
                  { PNG_COLOR_TYPE_PALETTE, 2, 1 }, { PNG_COLOR_TYPE_RGB, 16, 0 },  { PNG_COLOR_TYPE_RGBA, 16, 1 } };
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        FILE *file = fopen(scratch("k.png"), "wb");
        png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
        png_infop info = png_create_info_struct(png);
        unsigned char row[8 * 8];
        memset(row, 0xff, sizeof row);
        if (kinds[k].color == PNG_COLOR_TYPE_PALETTE)
            memset(row, 0x55, sizeof row);
        assert_false(setjmp(png_jmpbuf(png)));
        png_init_io(png, file);
        png_set_IHDR(png, info, 8, 8, kinds[k].depth, kinds[k].color, kinds[k].interlace ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_color palette[2] = { { 1, 2, 3 }, { 255, 255, 255 } };
        if (kinds[k].color == PNG_COLOR_TYPE_PALETTE)
            png_set_PLTE(png, info, palette, 2);
        png_bytep rows[8] = { row, row, row, row, row, row, row, row };
        png_set_rows(png, info, rows);
        png_write_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
        png_destroy_write_struct(&png, &info);
        fclose(file);
        struct pel_error error = PEL_ERROR_INIT;
        if (!pel_read_image(scratch("k.png"), &read, &error))
            fail_msg("%s", error.message);
        for (int i = 0; i < 4 * 8 * 8; i++)
            assert_true(read.rgba[i] == 1);
    }
    pel_image_finish(&read);
}

static void damaged_png(void **state)
{
    (void)state;
    struct pel_image image, read;
    struct pel_error error = PEL_ERROR_INIT;
    size_t size;
    make_picture(&image, 9, 9);
    pel_image_init(&read);
    assert_true(pel_write_image(scratch("d.png"), &image, NULL, NULL));
    pel_image_finish(&image);
    unsigned char *bytes = read_file(scratch("d.png"), &size);
    for (size_t cut = 0; cut < size; cut++) {
        write_file(scratch("cut.png"), bytes, cut);
        assert_false(pel_read_image(scratch("cut.png"), &read, &error));
        assert_null(strchr(error.message, '\n'));
        assert_null(read.rgba);
    }
    /* A header that asks for 30000 x 30000 pixels; its checksum is made right, so that only the size is wrong. */
    const unsigned char ihdr[] = { 'I', 'H', 'D', 'R', 0, 0, 0x75, 0x30, 0, 0, 0x75, 0x30, 8, 2, 0, 0, 0 };
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < sizeof ihdr; i++) {
        crc ^= ihdr[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    crc = ~crc;
    memcpy(bytes + 12, ihdr, sizeof ihdr);
    for (int i = 0; i < 4; i++)
        bytes[29 + i] = (unsigned char)(crc >> (24 - 8 * i));
    write_file(scratch("cut.png"), bytes, size);
    free(bytes);
    assert_false(pel_read_image(scratch("cut.png"), &read, &error));
    assert_non_null(strstr(error.message, "30000"));
    assert_false(pel_read_image(scratch("none.png"), &read, &error));
    assert_int_equal(error.code, PEL_ERROR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_blended), cmocka_unit_test(alpha_is_kept), cmocka_unit_test(odd_values),
        cmocka_unit_test(float_pictures),  cmocka_unit_test(foreign_png),   cmocka_unit_test(damaged_png),
    };
    return cmocka_run_group_tests_name("picture", tests, make_scratch, remove_scratch);
}
