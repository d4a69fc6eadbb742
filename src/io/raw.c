/* SPDX-License-Identifier: MIT */
/* Raw samples: no header, so the user says the layout, "256x256x256:u8:be+1024". */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "fail.h"
#include "sample_layout.h"

struct raw_layout {
    struct pel_layout layout;
    uint64_t skip;
};

static bool bad(const char *text, const char *what, struct pel_error *error)
{
    return pel_fail(error, PEL_ERROR_ARGUMENT,
                    "raw layout \"%.100s\": %s; write it as 256x256x256:u8, with :be for big-endian and +1024 for bytes to skip", text,
                    what);
}

/* A number that begins with a digit (strtoull would take a sign). */
static bool number(const char **at, uint64_t *value)
{
    char *end;
    if (!isdigit((unsigned char)**at))
        return false;
    *value = strtoull(*at, &end, 10);
    *at = end;
    return true;
}

static bool parse(const char *text, struct raw_layout *raw, struct pel_error *error)
{
    const char *at = text;
    uint64_t sizes[4];
    int count = 0;
    do {
        if (count == 4 || !number(&at, &sizes[count++]))
            return bad(text, "needs 2 to 4 sizes", error);
    } while (*at == 'x' && at++);
    if (count < 2 || *at != ':')
        return bad(text, count < 2 ? "needs 2 to 4 sizes" : "needs a colon and a type after the sizes", error);
    at++;
    char type[24];
    size_t n = strcspn(at, ":+");
    if (n >= sizeof type)
        return bad(text, "has a type that is not known (u8 i8 u16 i16 u32 i32 f32 f64)", error);
    memcpy(type, at, n);
    type[n] = 0;
    at += n;
    *raw =
        (struct raw_layout) { .layout = { .axis_count = count, .component_axis = count == 4 ? 0 : -1, .type = pel_type_from_name(type) } };
    if (raw->layout.type == PEL_TYPE_COUNT)
        return bad(text, "has a type that is not known (u8 i8 u16 i16 u32 i32 f32 f64)", error);
    if (*at == ':') {
        raw->layout.big_endian = strncmp(at, ":be", 3) == 0;
        if (!raw->layout.big_endian && strncmp(at, ":le", 3) != 0)
            return bad(text, "has a byte order that is neither le nor be", error);
        at += 3;
    }
    if (*at == '+') {
        at++;
        if (!number(&at, &raw->skip))
            return bad(text, "needs a number of bytes after +", error);
    }
    if (*at)
        return bad(text, "has something behind its end", error);
    for (int i = 0; i < count; i++)
        raw->layout.sizes[i] = sizes[i];
    for (int i = 0; i < 3; i++) {
        int axis = i + (count == 4);
        raw->layout.axes[i] = axis < count ? axis : -1;
    }
    return true;
}

static bool from_stream(void *user, void *bytes, size_t size, struct pel_error *error)
{
    return pel_stream_read_exact(user, bytes, size, error);
}

/* A file that is exactly as long as the layout says is not looked through as gzip, whatever its first bytes happen to be. */
static enum pel_stream_coding coding_for(const char *path, uint64_t length)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISREG(st.st_mode) && (uint64_t)st.st_size == length ? PEL_STREAM_PLAIN : PEL_STREAM_AUTO;
}

static bool read_raw(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                     struct pel_error *error)
{
    struct raw_layout raw;
    uint64_t bytes;
    if (!parse(params->raw, &raw, error))
        return false;
    if (!pel_layout_check(&raw.layout, &bytes, error)) {
        if (error)
            error->code = PEL_ERROR_ARGUMENT; /* the sizes are the user's, not the file's */
        return false;
    }
    struct pel_stream *stream = pel_stream_open(path, coding_for(path, raw.skip + bytes), &params->progress, error);
    if (!stream)
        return false;
    bool ok = pel_stream_check(stream, raw.skip, "bytes to skip", error) && pel_stream_skip(stream, raw.skip, error) &&
              pel_stream_check(stream, bytes, "samples", error);
    if (ok) {
        uint64_t left = pel_stream_bound(stream);
        if (!pel_stream_is_compressed(stream) && left > bytes && left != UINT64_MAX)
            pel_info_note(info, "%llu bytes behind the samples were not read", (unsigned long long)(left - bytes));
        ok = pel_layout_read(&raw.layout, &(struct pel_sample_source){ from_stream, stream }, volume, error);
    }
    pel_stream_close(stream);
    return ok;
}

static bool write_raw(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error)
{
    struct pel_safe_file out;
    if (!pel_safe_file_open(&out, path, error))
        return false;
    bool ok = pel_write_samples(&out, volume, &params->progress, error) && pel_safe_file_commit(&out, error);
    pel_safe_file_abort(&out);
    return ok;
}

const struct pel_format pel_format_raw = {
    .info = { "raw", "Samples without a header; the layout is said by --raw", ".raw", true, true },
    .read = read_raw,
    .write = write_raw,
};
