/* SPDX-License-Identifier: MIT */
/* Errors: how every fallible function of the library tells what went wrong.
 *
 * A function that can fail returns bool (true: it worked) or a pointer (NULL: it failed) and takes a
 * `struct pel_error *` as its last argument. The pointer may be NULL when the caller does not care why.
 * On success the error is left untouched; on failure it holds a code and one line of text that names the
 * file, the place, what is wrong and, where known, what would mend it. The library never prints or exits. */
#ifndef PELLUCID_ERROR_H
#define PELLUCID_ERROR_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

enum pel_error_code {
    PEL_ERROR_NONE = 0,
    PEL_ERROR_ARGUMENT,    /* the caller asked for something that makes no sense (bad usage) */
    PEL_ERROR_IO,          /* the operating system refused: missing file, no permission, disk full */
    PEL_ERROR_FORMAT,      /* a file is damaged, truncated, or contradicts itself */
    PEL_ERROR_UNSUPPORTED, /* well-formed, but something this program does not do */
    PEL_ERROR_MEMORY,      /* not enough memory, or a size beyond what can be addressed */
    PEL_ERROR_CANCELLED,   /* a progress callback asked to stop */
};

struct pel_error {
    enum pel_error_code code;
    char message[512]; /* one line, no newline at the end, always terminated */
};

#define PEL_ERROR_INIT { PEL_ERROR_NONE, "" }

/* Progress of a long operation. `update` is called from the calling thread with the fraction done, 0 to 1, now and
 * then; returning false asks the operation to stop, which then fails with PEL_ERROR_CANCELLED and leaves no output. */
struct pel_progress {
    bool (*update)(void *user, double fraction);
    void *user;
};

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
