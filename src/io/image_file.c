/* SPDX-License-Identifier: MIT */
/* Pictures in and out, by the name's ending; reading goes by content. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fail.h"
#include "format.h"
#include "image_io.h"

static bool check(const struct pel_image *image, struct pel_error *error)
{
    if (image && image->rgba && image->width >= 1 && image->height >= 1)
        return true;
    return pel_fail(error, PEL_ERROR_ARGUMENT, "there is no picture to write");
}

static bool write_to(struct pel_safe_file *out, const char *path, const struct pel_image *image,
                     const struct pel_image_write_params *params, struct pel_error *error)
{
    if (pel_path_has_ending(path, ".nrrd"))
        return pel_nrrd_write_pixels(out, image->rgba, image->width, image->height, 4, "RGBA, premultiplied", error);
    return pel_png_write(out->file, image, params, error);
}

bool pel_write_image(const char *path, const struct pel_image *image, const struct pel_image_write_params *params, struct pel_error *error)
{
    static const struct pel_image_write_params defaults = PEL_IMAGE_WRITE_PARAMS_INIT;
    if (!params)
        params = &defaults;
    if (!check(image, error))
        return pel_fail_in(error, "%s: ", path);
    if (params->compression < 0 || params->compression > 9)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: a compression of %d cannot be; it goes from 0 to 9", path, params->compression);
    if (strcmp(path, "-") == 0) {
        bool ok = pel_png_write(stdout, image, params, error);
        if (ok && fflush(stdout) != 0)
            ok = pel_fail_errno(error, "writing failed");
        return ok || pel_fail_in(error, "standard output: ");
    }
    if (!pel_path_has_ending(path, ".png .nrrd"))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: the name's ending says no picture format; use .png or .nrrd", path);
    struct pel_safe_file out = { 0 };
    bool ok = pel_safe_file_open(&out, path, error) && write_to(&out, path, image, params, error) && pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok || pel_fail_in(error, "%s: ", path);
}

bool pel_write_depth(const char *path, const struct pel_image *image, struct pel_error *error)
{
    if (!check(image, error))
        return pel_fail_in(error, "%s: ", path);
    if (!image->depth)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: the picture has no depth to write", path);
    if (!pel_path_has_ending(path, ".nrrd"))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: depth is written as .nrrd", path);
    struct pel_safe_file out = { 0 };
    bool ok = pel_safe_file_open(&out, path, error) &&
              pel_nrrd_write_pixels(&out, image->depth, image->width, image->height, 1, "depth", error) &&
              pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok || pel_fail_in(error, "%s: ", path);
}

bool pel_read_image(const char *path, struct pel_image *image, struct pel_error *error)
{
    static const unsigned char png[8] = { 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n' };
    struct pel_stream *stream = pel_stream_open(path, PEL_STREAM_AUTO, NULL, error);
    const unsigned char *bytes;
    size_t size;
    bool is_png = false, is_nrrd = false, ok = stream && pel_stream_peek(stream, 8, &bytes, &size, error);
    if (ok) {
        is_png = size == 8 && memcmp(bytes, png, 8) == 0;
        is_nrrd = size == 8 && memcmp(bytes, "NRRD", 4) == 0;
    }
    pel_stream_close(stream);
    if (is_png)
        ok = pel_png_read(path, image, error);
    else if (is_nrrd)
        ok = pel_nrrd_read_image(path, image, error);
    else if (ok)
        ok = pel_fail(error, PEL_ERROR_UNSUPPORTED, "is no picture that can be read; PNG and float NRRD can");
    return ok || pel_fail_in(error, "%s: ", path);
}
