/* SPDX-License-Identifier: MIT */
/* Writing a volume's samples as they lie in memory, plain or deflated. */
#include <zlib.h>

#include "fail.h"
#include "sample_layout.h"

enum { STEP = 1 << 22 };

bool pel_write_samples(struct pel_safe_file *out, const struct pel_volume *volume, const struct pel_progress *progress,
                       struct pel_error *error)
{
    size_t bytes = pel_volume_bytes(volume);
    for (size_t done = 0; done < bytes;) {
        size_t n = bytes - done < STEP ? bytes - done : STEP;
        if (!pel_safe_file_write(out, (const char *)volume->data + done, n, error))
            return false;
        done += n;
        if (!pel_progress_report(progress, (double)done / (double)bytes, error))
            return false;
    }
    return true;
}

bool pel_write_samples_deflated(struct pel_safe_file *out, const struct pel_volume *volume, bool gzip, const struct pel_progress *progress,
                                struct pel_error *error)
{
    unsigned char buffer[1 << 16];
    size_t bytes = pel_volume_bytes(volume), done = 0;
    z_stream z = { 0 };
    if (deflateInit2(&z, 6, Z_DEFLATED, gzip ? 15 + 16 : 15, 9, Z_DEFAULT_STRATEGY) != Z_OK)
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory to compress");
    bool ok = true;
    int status = Z_OK;
    while (ok && status != Z_STREAM_END) {
        size_t n = bytes - done < STEP ? bytes - done : STEP;
        z.next_in = (unsigned char *)volume->data + done;
        z.avail_in = (uInt)n;
        done += n;
        do {
            z.next_out = buffer;
            z.avail_out = sizeof buffer;
            status = deflate(&z, done == bytes ? Z_FINISH : Z_NO_FLUSH);
            ok = pel_safe_file_write(out, buffer, sizeof buffer - z.avail_out, error);
        } while (ok && z.avail_out == 0);
        ok = ok && pel_progress_report(progress, (double)done / (double)bytes, error);
    }
    deflateEnd(&z);
    return ok;
}
