/* SPDX-License-Identifier: MIT */
#include "stream.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "alloc.h"
#include "fail.h"

enum { RAW_SIZE = 1 << 16, AHEAD_SIZE = 1 << 16, STEP = 1 << 22, DEFLATE_RATIO = 1032, GZIP_MARK = 4 };

struct pel_stream {
    int fd;                   /* -1 over another stream */
    struct pel_stream *below; /* borrowed */
    uint64_t below_left;      /* bytes that may still be taken from it */
    uint64_t file_size;       /* UINT64_MAX: not known */
    uint64_t file_taken;      /* bytes read from fd */
    const struct pel_progress *progress;

    unsigned char *raw; /* bytes as the source gave them, not yet used: raw[raw_start .. raw_end) */
    size_t raw_start, raw_end;
    bool raw_ended; /* nothing comes behind them */

    bool inflating, z_ended;
    z_stream z;

    unsigned char *ahead; /* decoded bytes that were peeked at: ahead[ahead_start .. ahead_end) */
    size_t ahead_start, ahead_end;
    uint64_t taken;
};

/* Reads from the file or the stream below into `bytes`; *got is 0 only at the end. */
static bool pull(struct pel_stream *s, void *bytes, size_t size, size_t *got, struct pel_error *error)
{
    *got = 0;
    if (s->below) {
        if (size > s->below_left)
            size = (size_t)s->below_left;
        if (!pel_stream_read(s->below, bytes, size, got, error))
            return false;
        s->below_left -= *got;
        return true;
    }
    ssize_t n;
    do {
        n = read(s->fd, bytes, size);
    } while (n < 0 && errno == EINTR);
    if (n < 0)
        return pel_fail_errno(error, "cannot be read");
    *got = (size_t)n;
    s->file_taken += *got;
    double fraction = s->file_size != UINT64_MAX && s->file_size > 0 ? (double)s->file_taken / (double)s->file_size : 0;
    return pel_progress_report(s->progress, fraction < 1 ? fraction : 1, error);
}

/* Makes sure that raw has something, unless the source is at its end. */
static bool fill_raw(struct pel_stream *s, struct pel_error *error)
{
    if (s->raw_start < s->raw_end || s->raw_ended)
        return true;
    s->raw_start = 0;
    if (!pull(s, s->raw, RAW_SIZE, &s->raw_end, error)) {
        s->raw_end = 0;
        return false;
    }
    s->raw_ended = s->raw_end == 0;
    return true;
}

/* *follows: a gzip header is at the start of raw: magic, deflate, no reserved flag. The buffer may end within it and a pipe may give less
 * than was asked for, so reads on until it can be told. */
static bool gzip_follows(struct pel_stream *s, bool *follows, struct pel_error *error)
{
    *follows = false;
    if (s->raw_end - s->raw_start < GZIP_MARK && s->raw_start > 0) {
        memmove(s->raw, s->raw + s->raw_start, s->raw_end - s->raw_start);
        s->raw_end -= s->raw_start;
        s->raw_start = 0;
    }
    while (s->raw_end - s->raw_start < GZIP_MARK && !s->raw_ended) {
        size_t got;
        if (!pull(s, s->raw + s->raw_end, RAW_SIZE - s->raw_end, &got, error))
            return false;
        s->raw_end += got;
        s->raw_ended = got == 0;
    }
    const unsigned char *b = s->raw + s->raw_start;
    *follows = s->raw_end - s->raw_start >= GZIP_MARK && b[0] == 0x1f && b[1] == 0x8b && b[2] == 8 && (b[3] & 0xe0) == 0;
    return true;
}

/* Decodes some bytes; *got is 0 only at the end. */
static bool inflate_some(struct pel_stream *s, void *bytes, size_t size, size_t *got, struct pel_error *error)
{
    *got = 0;
    while (*got == 0 && !s->z_ended) {
        if (!fill_raw(s, error))
            return false;
        if (s->raw_start == s->raw_end)
            return pel_fail(error, PEL_ERROR_FORMAT, "the compressed data end too early; the file is truncated");
        s->z.next_in = s->raw + s->raw_start;
        s->z.avail_in = (uInt)(s->raw_end - s->raw_start);
        s->z.next_out = bytes;
        s->z.avail_out = (uInt)size;
        int status = inflate(&s->z, Z_NO_FLUSH);
        s->raw_start = s->raw_end - s->z.avail_in;
        *got = size - s->z.avail_out;
        if (status == Z_STREAM_END) {
            /* gzip files may be several members in a row; anything else behind the end is none of ours. */
            bool more;
            if (!gzip_follows(s, &more, error))
                return false;
            if (more)
                inflateReset(&s->z);
            s->z_ended = !more;
        } else if (status == Z_MEM_ERROR) {
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory to decompress");
        } else if (status != Z_OK && status != Z_BUF_ERROR) {
            return pel_fail(error, PEL_ERROR_FORMAT, "the compressed data are damaged (%s)", s->z.msg ? s->z.msg : "unknown reason");
        }
    }
    return true;
}

static bool decode(struct pel_stream *s, unsigned char *bytes, size_t size, size_t *got, struct pel_error *error)
{
    if (size > STEP)
        size = STEP; /* so that progress is told, and avail_out cannot overflow */
    if (s->inflating)
        return inflate_some(s, bytes, size, got, error);
    if (s->raw_start == s->raw_end && size >= RAW_SIZE && !s->raw_ended)
        return pull(s, bytes, size, got, error);
    if (!fill_raw(s, error))
        return false;
    size_t have = s->raw_end - s->raw_start;
    *got = size < have ? size : have;
    memcpy(bytes, s->raw + s->raw_start, *got);
    s->raw_start += *got;
    return true;
}

static struct pel_stream *create(enum pel_stream_coding coding, struct pel_stream *s, struct pel_error *error)
{
    s->raw = pel_alloc(RAW_SIZE, 1, "read buffer", error);
    bool gzip;
    if (!s->raw || !gzip_follows(s, &gzip, error))
        goto fail;
    if (coding == PEL_STREAM_ZLIB || (coding == PEL_STREAM_AUTO && gzip)) {
        if (inflateInit2(&s->z, 15 + 32) != Z_OK) {
            pel_fail(error, PEL_ERROR_MEMORY, "no memory to decompress");
            goto fail;
        }
        s->inflating = true;
    }
    return s;
fail:
    pel_stream_close(s);
    return NULL;
}

struct pel_stream *pel_stream_open(const char *path, enum pel_stream_coding coding, const struct pel_progress *progress,
                                   struct pel_error *error)
{
    struct pel_stream *s = pel_alloc(1, sizeof *s, "read buffer", error);
    if (!s)
        return NULL;
    s->progress = progress;
    s->file_size = UINT64_MAX;
    s->fd = open(path, O_RDONLY | O_CLOEXEC);
    struct stat st;
    if (s->fd < 0 || fstat(s->fd, &st) != 0) {
        pel_fail_errno(error, "cannot be opened");
        pel_stream_close(s);
        return NULL;
    }
    if (S_ISDIR(st.st_mode)) {
        pel_fail(error, PEL_ERROR_IO, "is a folder where a file is needed");
        pel_stream_close(s);
        return NULL;
    }
    if (S_ISREG(st.st_mode))
        s->file_size = (uint64_t)st.st_size;
    return create(coding, s, error);
}

struct pel_stream *pel_stream_over(struct pel_stream *below, enum pel_stream_coding coding, size_t limit, struct pel_error *error)
{
    struct pel_stream *s = pel_alloc(1, sizeof *s, "read buffer", error);
    if (!s)
        return NULL;
    s->fd = -1;
    s->below = below;
    s->below_left = limit;
    return create(coding, s, error);
}

void pel_stream_close(struct pel_stream *s)
{
    if (!s)
        return;
    if (s->inflating)
        inflateEnd(&s->z);
    if (s->fd >= 0)
        close(s->fd);
    free(s->raw);
    free(s->ahead);
    free(s);
}

bool pel_stream_read(struct pel_stream *s, void *bytes, size_t size, size_t *got, struct pel_error *error)
{
    unsigned char *out = bytes;
    size_t done = s->ahead_end - s->ahead_start;
    if (done > size)
        done = size;
    if (done > 0) {
        memcpy(out, s->ahead + s->ahead_start, done);
        s->ahead_start += done;
    }
    while (done < size) {
        size_t n;
        if (!decode(s, out + done, size - done, &n, error))
            return false;
        if (n == 0)
            break;
        done += n;
    }
    s->taken += done;
    *got = done;
    return true;
}

bool pel_stream_read_exact(struct pel_stream *s, void *bytes, size_t size, struct pel_error *error)
{
    size_t got;
    if (!pel_stream_read(s, bytes, size, &got, error))
        return false;
    if (got < size)
        return pel_fail(error, PEL_ERROR_FORMAT, "%zu bytes are missing at the end (%zu of %zu are there); the file is truncated",
                        size - got, got, size);
    return true;
}

bool pel_stream_skip(struct pel_stream *s, uint64_t size, struct pel_error *error)
{
    unsigned char waste[8192];
    while (size > 0) {
        size_t n = size < sizeof waste ? (size_t)size : sizeof waste;
        if (!pel_stream_read_exact(s, waste, n, error))
            return false;
        size -= n;
    }
    return true;
}

/* Room for bytes that are decoded and not taken. */
static bool need_ahead(struct pel_stream *s, struct pel_error *error)
{
    if (!s->ahead)
        s->ahead = pel_alloc(AHEAD_SIZE, 1, "read buffer", error);
    return s->ahead != NULL;
}

bool pel_stream_unread(struct pel_stream *s, const void *bytes, size_t size, struct pel_error *error)
{
    if (!need_ahead(s, error))
        return false;
    size_t have = s->ahead_end - s->ahead_start;
    if (size > AHEAD_SIZE - have || size > s->taken)
        return pel_fail(error, PEL_ERROR_FORMAT, "cannot go back %zu bytes", size);
    memmove(s->ahead + size, s->ahead + s->ahead_start, have);
    memcpy(s->ahead, bytes, size);
    s->ahead_start = 0;
    s->ahead_end = size + have;
    s->taken -= size;
    return true;
}

bool pel_stream_peek(struct pel_stream *s, size_t size, const unsigned char **bytes, size_t *got, struct pel_error *error)
{
    if (!need_ahead(s, error))
        return false;
    size_t have = s->ahead_end - s->ahead_start;
    memmove(s->ahead, s->ahead + s->ahead_start, have);
    s->ahead_start = 0;
    s->ahead_end = have;
    if (size > AHEAD_SIZE)
        size = AHEAD_SIZE;
    while (s->ahead_end < size) {
        size_t n;
        if (!decode(s, s->ahead + s->ahead_end, size - s->ahead_end, &n, error))
            return false;
        if (n == 0)
            break;
        s->ahead_end += n;
    }
    *bytes = s->ahead;
    *got = s->ahead_end < size ? s->ahead_end : size;
    return true;
}

uint64_t pel_stream_tell(const struct pel_stream *s)
{
    return s->taken;
}

bool pel_stream_is_compressed(const struct pel_stream *s)
{
    return s->inflating;
}

static uint64_t add(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

uint64_t pel_stream_bound(const struct pel_stream *s)
{
    uint64_t left;
    if (s->below) {
        left = pel_stream_bound(s->below);
        if (left > s->below_left)
            left = s->below_left;
    } else if (s->file_size == UINT64_MAX) {
        return UINT64_MAX;
    } else {
        left = s->file_size > s->file_taken ? s->file_size - s->file_taken : 0;
    }
    left = add(left, s->raw_end - s->raw_start);
    if (s->inflating) /* what zlib may hold back in its window is counted too */
        left = left > UINT64_MAX / DEFLATE_RATIO ? UINT64_MAX : add(left * DEFLATE_RATIO, 1 << 16);
    return add(left, s->ahead_end - s->ahead_start);
}

bool pel_stream_check(const struct pel_stream *s, uint64_t size, const char *what, struct pel_error *error)
{
    uint64_t bound = pel_stream_bound(s);
    if (size <= bound)
        return true;
    return pel_fail(error, PEL_ERROR_FORMAT,
                    "the header (or --raw) asks for %llu bytes of %s, but the file has %s%llu left; it is truncated or the header is wrong",
                    (unsigned long long)size, what, s->inflating ? "at most " : "", (unsigned long long)bound);
}

bool pel_stream_read_all(struct pel_stream *s, size_t limit, unsigned char **bytes, size_t *size, struct pel_error *error)
{
    uint64_t bound = pel_stream_bound(s);
    size_t room = s->inflating || bound > limit ? 1 << 16 : (size_t)bound, done = 0;
    unsigned char *all = NULL;
    for (;;) {
        unsigned char *more = realloc(all, room + 1);
        if (!more) {
            pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu bytes", room + 1);
            break;
        }
        all = more;
        size_t got;
        if (!pel_stream_read(s, all + done, room + 1 - done, &got, error))
            break;
        done += got;
        if (done > limit) {
            pel_fail(error, PEL_ERROR_UNSUPPORTED, "has more than %zu bytes, the most that can be held for this format", limit);
            break;
        }
        if (done <= room) {
            all[done] = 0;
            *bytes = all;
            *size = done;
            return true;
        }
        room = room > limit / 2 ? limit : room * 2;
    }
    free(all);
    return false;
}
