/* SPDX-License-Identifier: MIT */
/* JPEG inside of DICOM. This text is compiled three times, for the three widths of a sample that libgdcmjpeg (GDCM's copy of the JPEG
 * group's library, with the lossless process that most others lack) is built for: dicom_jpeg8.c, dicom_jpeg12.c and dicom_jpeg16.c name the
 * function and include the width's headers in front of it. */
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dicom_decode.h"

struct trouble {
    struct jpeg_error_mgr base; /* first: the library hands out its address */
    jmp_buf leave;
    char *why;
};

static void on_exit_error(j_common_ptr common)
{
    struct trouble *trouble = (struct trouble *)common->err;
    char text[JMSG_LENGTH_MAX];
    trouble->base.format_message(common, text);
    snprintf(trouble->why, PEL_DICOM_WHY, "%.190s", text);
    longjmp(trouble->leave, 1);
}

/* Warnings are for damaged data that the library would patch up; a picture for doctors is none to patch up. */
static void on_message(j_common_ptr common, int level)
{
    if (level < 0)
        on_exit_error(common);
}

static void on_output(j_common_ptr common)
{
    (void)common;
}

static void no_source(j_decompress_ptr jpeg)
{
    (void)jpeg;
}

static boolean no_more_bytes(j_decompress_ptr jpeg)
{
    on_exit_error((j_common_ptr)jpeg);
    return FALSE;
}

static void skip_bytes(j_decompress_ptr jpeg, long count)
{
    if (count < 0 || (size_t)count > jpeg->src->bytes_in_buffer)
        on_exit_error((j_common_ptr)jpeg);
    jpeg->src->next_input_byte += count;
    jpeg->src->bytes_in_buffer -= (size_t)count;
}

/* Everything that may leave through the jump; what it changes, the caller does not look at any more. */
static void decode(struct jpeg_decompress_struct *jpeg, const struct pel_dicom_frame_shape *shape, JSAMPLE *row, unsigned char *out)
{
    size_t width = (size_t)shape->columns * shape->samples;
    jpeg_read_header(jpeg, TRUE);
    if (shape->luma)
        jpeg->jpeg_color_space = JCS_YCbCr;
    jpeg->out_color_space = shape->luma ? JCS_RGB : jpeg->jpeg_color_space; /* else numbers as they are stored */
    jpeg_start_decompress(jpeg);
    if (jpeg->output_width != shape->columns || jpeg->output_height != shape->rows || (unsigned)jpeg->output_components != shape->samples)
        on_exit_error((j_common_ptr)jpeg);
    while (jpeg->output_scanline < jpeg->output_height) {
        jpeg_read_scanlines(jpeg, &row, 1);
        for (size_t i = 0; i < width; i++)
            for (unsigned b = 0; b < shape->bytes; b++)
                *out++ = (unsigned char)((unsigned)row[i] >> 8 * b);
    }
}

bool PEL_JPEG_FUNCTION(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why)
{
    struct jpeg_decompress_struct jpeg;
    struct trouble trouble = { .why = why };
    struct jpeg_source_mgr source = { .next_input_byte = bytes,
                                      .bytes_in_buffer = size,
                                      .init_source = no_source,
                                      .fill_input_buffer = no_more_bytes,
                                      .skip_input_data = skip_bytes,
                                      .resync_to_restart = jpeg_resync_to_restart,
                                      .term_source = no_source };
    JSAMPLE *row = malloc((size_t)shape->columns * shape->samples * sizeof *row);
    memset(&jpeg, 0, sizeof jpeg);
    jpeg.err = jpeg_std_error(&trouble.base);
    trouble.base.error_exit = on_exit_error;
    trouble.base.emit_message = on_message;
    trouble.base.output_message = on_output;
    snprintf(why, PEL_DICOM_WHY, "no memory");
    if (!row || setjmp(trouble.leave)) {
        jpeg_destroy((j_common_ptr)&jpeg);
        free(row);
        return false;
    }
    jpeg_create_decompress(&jpeg);
    jpeg.src = &source;
    decode(&jpeg, shape, row, out);
    jpeg_destroy_decompress(&jpeg);
    free(row);
    return true;
}
