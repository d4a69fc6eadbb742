/* SPDX-License-Identifier: MIT */
/* The parts of the NRRD reader. Teem parses the header's fields; which file holds the data, and reading them, are ours: Teem would print a
 * file name through a format string that the file gives, allocate what the header asks for before looking at the file, and tell no
 * progress. */
#ifndef PEL_IO_NRRD_H
#define PEL_IO_NRRD_H

#include <teem/nrrd.h>

#include "sample_layout.h"

#define PEL_NRRD_MAX_FILES 65536

struct pel_nrrd {
    Nrrd *nrrd;             /* what Teem understood; no data */
    NrrdIoState *nio;       /* encoding, endian, skips */
    char **files;           /* owned; paths of detached data files in order, as the header says them */
    size_t file_count;      /* 0: data are attached */
    char units[512], space_units[512]; /* the values of these fields: texts in quotation marks */
    bool has_void;
    double void_value;
    bool has_placement;     /* this library's own note of the exact placement, see nrrd_write.c */
    double spacing[3], direction[3][3];
};

/* Reads the header from the beginning of a stream up to its end (the byte behind the empty line). */
bool pel_nrrd_read_header(struct pel_stream *stream, struct pel_nrrd *head, struct pel_file_info *info, struct pel_error *error);
void pel_nrrd_finish(struct pel_nrrd *head); /* accepts a zeroed one */

/* The text in the (index + 1)th quotation marks of such values; "" where there is none. */
void pel_nrrd_quoted(const char *values, int index, char *text, size_t size);

/* What the axes mean: the layout of the samples, and placement, space, units and name of the volume. */
bool pel_nrrd_interpret(const struct pel_nrrd *head, struct pel_layout *layout, struct pel_volume *volume, struct pel_file_info *info,
                        struct pel_error *error);

/* Where pel_nrrd_interpret negated a world axis, negates that component of every vector too. Call it once, after the samples are read. */
void pel_nrrd_turn_vectors(const struct pel_nrrd *head, const struct pel_layout *layout, struct pel_volume *volume);

/* Teem keeps its errors in a list of the whole program (biff), so that only one thread may be in it. What parses or writes headers holds
 * this lock, the only thing in this library that outlives a call; samples are read and written outside of it. */
void pel_teem_lock(void);
void pel_teem_unlock(void);

/* Makes one line of what Teem said and clears it: "parsed 2 values, but dimension is 3". */
bool pel_fail_teem(struct pel_error *error, enum pel_error_code code, const char *what);

/* Writes a NRRD header through Teem; `vector_kind` is the nrrdKind of the component axis. `data_file` NULL: attached, the data follow. */
bool pel_nrrd_write_header(struct pel_safe_file *out, const struct pel_volume *volume, int vector_kind, bool gzip, const char *data_file,
                           struct pel_error *error);
bool pel_write_nrrd(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error);

#endif
