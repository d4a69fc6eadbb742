/* SPDX-License-Identifier: MIT */
/* Output files that appear whole or not at all. The bytes go into a file without a name (O_TMPFILE) in the target's folder, or, where the
 * file system has no such thing, into a temporary file beside the target; commit gives it the target's name in one step. An unnamed file
 * vanishes with the process, so that even an interrupted or killed program leaves nothing; the temporary one is removed by abort, to which
 * every failing or cancelled writer comes. A target that exists and is no regular file (a pipe, /dev/null) is written directly. */
#ifndef PEL_IO_SAFE_FILE_H
#define PEL_IO_SAFE_FILE_H

#include <stdio.h>

#include <pellucid/error.h>

struct pel_safe_file {
    FILE *file;      /* write here; NULL once committed or aborted */
    char *path;      /* owned; the target, symbolic links resolved */
    char *temporary; /* owned; name of the temporary file, or NULL where the file has no name yet or is written directly */
    bool direct;     /* written directly */
};

/* Starts an output file. `out` need not be initialised. Messages of these functions name no path: callers put it in front with pel_fail_in.
 */
bool pel_safe_file_open(struct pel_safe_file *out, const char *path, struct pel_error *error);

/* The same for the data file of a detached header. A file that is there is replaced only where the header that is there names it (`name`,
 * as the header's text has it): any other is not this header's to replace, and may be what the volume was read from. */
bool pel_safe_file_open_data(struct pel_safe_file *out, const char *header, const char *path, const char *name, struct pel_error *error);

/* fwrite that reports. */
bool pel_safe_file_write(struct pel_safe_file *out, const void *bytes, size_t size, struct pel_error *error);

/* Flushes, closes and gives the file its name. After failure nothing is left (and abort may still be called). */
bool pel_safe_file_commit(struct pel_safe_file *out, struct pel_error *error);

/* Closes and removes. Does nothing after a commit or on a zeroed struct, so that it may stand at the end of every function. */
void pel_safe_file_abort(struct pel_safe_file *out);

#endif
