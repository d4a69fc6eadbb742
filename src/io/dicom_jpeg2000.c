/* SPDX-License-Identifier: MIT */
/* JPEG 2000 inside of DICOM, with OpenJPEG. */
#include <openjpeg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "dicom_decode.h"

struct memory {
    const unsigned char *bytes;
    size_t size, at;
};

static OPJ_SIZE_T take(void *out, OPJ_SIZE_T size, void *user)
{
    struct memory *m = user;
    if (m->at >= m->size)
        return (OPJ_SIZE_T)-1;
    if (size > m->size - m->at)
        size = m->size - m->at;
    memcpy(out, m->bytes + m->at, size);
    m->at += size;
    return size;
}

static OPJ_OFF_T skip(OPJ_OFF_T count, void *user)
{
    struct memory *m = user;
    if (count < 0 || (uint64_t)count > m->size - m->at)
        return -1;
    m->at += (size_t)count;
    return count;
}

static OPJ_BOOL seek(OPJ_OFF_T place, void *user)
{
    struct memory *m = user;
    if (place < 0 || (uint64_t)place > m->size)
        return OPJ_FALSE;
    m->at = (size_t)place;
    return OPJ_TRUE;
}

/* Keeps the first message. */
static void on_error(const char *text, void *user)
{
    char *why = user;
    if (!*why)
        snprintf(why, PEL_DICOM_WHY, "%.*s", (int)strcspn(text, "\n"), text);
}

static void on_other(const char *text, void *user)
{
    (void)text, (void)user;
}

/* Numbers of several components, each in its own array, to where they belong. */
static bool gather(const opj_image_t *image, const struct pel_dicom_frame_shape *shape, unsigned char *out)
{
    size_t count = (size_t)shape->columns * shape->rows;
    for (unsigned s = 0; s < shape->samples; s++) {
        const opj_image_comp_t *c = &image->comps[s];
        if (c->w != shape->columns || c->h != shape->rows || !c->data || c->prec > 8 * shape->bytes)
            return false;
        uint32_t mask =
            c->prec < 32 ? (1u << c->prec) - 1 : UINT32_MAX; /* a negative number is cut to its bits, as uncompressed ones are */
        for (size_t i = 0; i < count; i++)
            for (unsigned b = 0; b < shape->bytes; b++)
                out[(i * shape->samples + s) * shape->bytes + b] = (unsigned char)(((uint32_t)c->data[i] & mask) >> 8 * b);
    }
    return true;
}

bool pel_dicom_jpeg2000(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why)
{
    struct memory memory = { bytes, size, 0 };
    bool boxed = size >= 8 && !memcmp(bytes + 4, "jP  ", 4), ok = false;
    opj_dparameters_t parameters;
    opj_image_t *image = NULL;
    opj_codec_t *codec = opj_create_decompress(boxed ? OPJ_CODEC_JP2 : OPJ_CODEC_J2K);
    opj_stream_t *stream = opj_stream_create(size < (1 << 16) ? 1 << 10 : 1 << 16, OPJ_TRUE);
    *why = '\0';
    if (codec && stream) {
        opj_stream_set_user_data(stream, &memory, NULL);
        opj_stream_set_user_data_length(stream, size);
        opj_stream_set_read_function(stream, take);
        opj_stream_set_skip_function(stream, skip);
        opj_stream_set_seek_function(stream, seek);
        opj_set_error_handler(codec, on_error, why);
        opj_set_warning_handler(codec, on_other, NULL);
        opj_set_info_handler(codec, on_other, NULL);
        opj_set_default_decoder_parameters(&parameters);
        ok = opj_setup_decoder(codec, &parameters) && opj_read_header(stream, codec, &image) && image->numcomps == shape->samples &&
             opj_decode(codec, stream, image) && opj_end_decompress(codec, stream) && gather(image, shape, out);
    }
    if (!ok && !*why)
        snprintf(why, PEL_DICOM_WHY, "it unpacks to another size than its header says");
    opj_image_destroy(image);
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    return ok;
}
