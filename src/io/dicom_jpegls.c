/* SPDX-License-Identifier: MIT */
/* JPEG-LS inside of DICOM, with CharLS. */
#include <charls/charls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dicom_decode.h"

static bool decode(charls_jpegls_decoder *decoder, const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape,
                   unsigned char *plain, size_t length, bool *planes, charls_jpegls_errc *code)
{
    charls_frame_info info;
    charls_interleave_mode mode;
    size_t told = 0;
    if ((*code = charls_jpegls_decoder_set_source_buffer(decoder, bytes, size)) != CHARLS_JPEGLS_ERRC_SUCCESS ||
        (*code = charls_jpegls_decoder_read_header(decoder)) != CHARLS_JPEGLS_ERRC_SUCCESS ||
        (*code = charls_jpegls_decoder_get_frame_info(decoder, &info)) != CHARLS_JPEGLS_ERRC_SUCCESS ||
        (*code = charls_jpegls_decoder_get_interleave_mode(decoder, &mode)) != CHARLS_JPEGLS_ERRC_SUCCESS ||
        (*code = charls_jpegls_decoder_get_destination_size(decoder, 0, &told)) != CHARLS_JPEGLS_ERRC_SUCCESS)
        return false;
    if (info.width != shape->columns || info.height != shape->rows || (unsigned)info.component_count != shape->samples || told != length)
        return false;
    *planes = mode == CHARLS_INTERLEAVE_MODE_NONE && shape->samples > 1;
    return (*code = charls_jpegls_decoder_decode_to_buffer(decoder, plain, length, 0)) == CHARLS_JPEGLS_ERRC_SUCCESS;
}

bool pel_dicom_jpegls(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why)
{
    size_t count = (size_t)shape->columns * shape->rows, length = count * shape->samples * shape->bytes;
    charls_jpegls_errc code = CHARLS_JPEGLS_ERRC_SUCCESS;
    bool planes = false, ok = false;
    charls_jpegls_decoder *decoder = charls_jpegls_decoder_create();
    unsigned char *plain = malloc(length ? length : 1);
    snprintf(why, PEL_DICOM_WHY, "no memory");
    if (decoder && plain) {
        ok = decode(decoder, bytes, size, shape, plain, length, &planes, &code);
        snprintf(why, PEL_DICOM_WHY, "%.190s",
                 code == CHARLS_JPEGLS_ERRC_SUCCESS ? "it unpacks to another size than its header says" : charls_get_error_message(code));
    }
    for (size_t i = 0; ok && i < count; i++)
        for (unsigned s = 0; s < shape->samples; s++)
            for (unsigned b = 0; b < shape->bytes; b++) {
                const unsigned char *number = plain + (planes ? s * count + i : i * shape->samples + s) * shape->bytes;
                *out++ = number[__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ ? shape->bytes - 1 - b : b];
            }
    free(plain);
    charls_jpegls_decoder_destroy(decoder);
    return ok;
}
