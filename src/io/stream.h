/* SPDX-License-Identifier: MIT */
/* Bytes of a file from its start to its end, with gzip looked through (by content, not by name). It inflates straight into the caller's
 * memory, so that a volume is never held twice, and it can bound what is still to come, so that a size that a header claims can be held
 * against the file before anything is allocated. */
#ifndef PEL_IO_STREAM_H
#define PEL_IO_STREAM_H

#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>

struct pel_stream;

enum pel_stream_coding {
    PEL_STREAM_PLAIN, /* bytes as they are */
    PEL_STREAM_AUTO,  /* gzip is looked through where the bytes begin as gzip does */
    PEL_STREAM_ZLIB,  /* zlib or gzip data, and nothing else will do */
};

/* Opens a file. `progress` (nullable) must outlive the stream; it is told the fraction of the file that was read. Messages name no path:
 * callers put it in front with pel_fail_in. */
struct pel_stream *pel_stream_open(const char *path, enum pel_stream_coding coding, const struct pel_progress *progress,
                                   struct pel_error *error);

/* A stream over the rest of another one: compressed data behind a header. `below` is borrowed and must outlive it; `limit` is the number of
 * its bytes that may be taken (SIZE_MAX: all). */
struct pel_stream *pel_stream_over(struct pel_stream *below, enum pel_stream_coding coding, size_t limit, struct pel_error *error);

void pel_stream_close(struct pel_stream *stream); /* accepts NULL */

/* Reads up to `size` bytes into `*got`; fewer only at the end. False: a read error, damaged compressed data, or cancelled. */
bool pel_stream_read(struct pel_stream *stream, void *bytes, size_t size, size_t *got, struct pel_error *error);

/* Reads exactly `size` bytes; PEL_ERROR_FORMAT says how many were there and how many were wanted. */
bool pel_stream_read_exact(struct pel_stream *stream, void *bytes, size_t size, struct pel_error *error);

bool pel_stream_skip(struct pel_stream *stream, uint64_t size, struct pel_error *error);

/* Looks at up to `size` (at most 64 KiB) coming bytes without taking them; *bytes stays good until the next call on the stream. */
bool pel_stream_peek(struct pel_stream *stream, size_t size, const unsigned char **bytes, size_t *got, struct pel_error *error);

/* Gives back the last `size` bytes that were taken (at most 32 KiB): for who read ahead. */
bool pel_stream_unread(struct pel_stream *stream, const void *bytes, size_t size, struct pel_error *error);

/* Bytes taken so far. */
uint64_t pel_stream_tell(const struct pel_stream *stream);

/* True where the bytes are compressed in the file. */
bool pel_stream_is_compressed(const struct pel_stream *stream);

/* An upper bound on the bytes that are still to come: exact for a plain file; for a compressed one, deflate's greatest ratio (1032)
 * times what is left of the file. UINT64_MAX where nothing is known (a pipe). */
uint64_t pel_stream_bound(const struct pel_stream *stream);

/* PEL_ERROR_FORMAT where `size` bytes cannot be in the rest of the stream; `what` names them ("samples"). Call it before allocating. */
bool pel_stream_check(const struct pel_stream *stream, uint64_t size, const char *what, struct pel_error *error);

/* The whole rest in memory that is freed with free(), with a zero byte after the end. At most `limit` bytes, else PEL_ERROR_UNSUPPORTED.
 * For libraries that need to seek in what may be compressed. */
bool pel_stream_read_all(struct pel_stream *stream, size_t limit, unsigned char **bytes, size_t *size, struct pel_error *error);

#endif
