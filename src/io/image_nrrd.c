/* SPDX-License-Identifier: MIT */
/* Float pictures as NRRD, through the volume reader and writer: a picture is a volume of one slice. */
#include <string.h>

#include "fail.h"
#include "image_io.h"
#include "nrrd.h"

bool pel_nrrd_write_pixels(struct pel_safe_file *out, const float *pixels, int width, int height, int channels, const char *name,
                           struct pel_error *error)
{
    size_t sizes[3] = { (size_t)channels, (size_t)width, (size_t)height }, first = channels == 1;
    pel_teem_lock();
    Nrrd *nrrd = nrrdNew();
    NrrdIoState *nio = nrrdIoStateNew();
    bool ok = nrrd && nio && nrrdWrap_nva(nrrd, (void *)pixels, nrrdTypeFloat, 3 - (unsigned)first, sizes + first) == 0;
    if (ok) {
        if (!first)
            nrrd->axis[0].kind = nrrdKindRGBAColor;
        nrrd->axis[!first].kind = nrrd->axis[!first + 1].kind = nrrdKindDomain;
        nrrd->content = strdup(name);
        nio->format = nrrdFormatNRRD;
        nio->encoding = nrrdEncodingRaw;
        nio->skipData = 1;
        ok = nrrdWrite(out->file, nrrd, nio) == 0;
    }
    if (!ok)
        pel_fail_teem(error, PEL_ERROR_IO, "its header cannot be written");
    if (nrrd)
        nrrdNix(nrrd);
    if (nio)
        nrrdIoStateNix(nio);
    pel_teem_unlock();
    return ok && pel_safe_file_write(out, pixels, sizes[0] * sizes[1] * sizes[2] * sizeof *pixels, error);
}

static double value_at(const struct pel_volume *volume, size_t i)
{
    return volume->type == PEL_F32 ? ((const float *)volume->data)[i] : ((const double *)volume->data)[i];
}

bool pel_nrrd_read_image(const char *path, struct pel_image *image, struct pel_error *error)
{
    static const struct pel_read_params params = PEL_READ_PARAMS_INIT;
    struct pel_volume volume;
    struct pel_file_info info = { 0 };
    pel_volume_init(&volume);
    bool ok = pel_format_nrrd.read(path, &params, &volume, &info, error);
    int n = volume.components;
    if (ok && (volume.dims[2] != 1 || n == 2 || (volume.type != PEL_F32 && volume.type != PEL_F64)))
        ok = pel_fail(error, PEL_ERROR_UNSUPPORTED, "is no picture: that is one slice of float or double, with 1, 3 or 4 values a pixel");
    if (ok && (volume.dims[0] > PEL_IMAGE_MAX || volume.dims[1] > PEL_IMAGE_MAX))
        ok = pel_fail(error, PEL_ERROR_UNSUPPORTED, "has %zu x %zu pixels; a picture has at most %d along each side", volume.dims[0],
                      volume.dims[1], PEL_IMAGE_MAX);
    ok = ok && pel_image_allocate(image, (int)volume.dims[0], (int)volume.dims[1], false, error);
    for (size_t i = 0; ok && i < volume.dims[0] * volume.dims[1]; i++) {
        float *out = image->rgba + 4 * i;
        for (int c = 0; c < 4; c++)
            out[c] = c == 3 && n < 4 ? 1 : (float)value_at(&volume, i * (size_t)n + (n == 1 ? 0 : (size_t)c));
    }
    pel_volume_finish(&volume);
    return ok;
}
