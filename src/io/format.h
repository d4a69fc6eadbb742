/* SPDX-License-Identifier: MIT */
/* What a file format is to this library: one descriptor, found in the table of formats.c. To add a format: one file with its functions and
 * its descriptor, one line in the table. Also the few things that all readers share. */
#ifndef PEL_IO_FORMAT_H
#define PEL_IO_FORMAT_H

#include <stddef.h>
#include <stdint.h>

#include <pellucid/io.h>
#include <pellucid/volume.h>

#include "safe_file.h"
#include "stream.h"

/* How much of a file's beginning a probe is shown at most; gzip is looked through. */
#define PEL_PROBE_SIZE 4096

struct pel_format {
    struct pel_format_info info;
    bool folders; /* `read` also takes a folder of such files (a series, a stack of slices) */

    /* Whether a file that begins with these bytes is of the format. `path` helps where bytes cannot tell (lower-case endings are in
     * info.endings; pel_path_has_ending). Must not open anything. NULL: never found by content. */
    bool (*probe)(const unsigned char *bytes, size_t size, const char *path);

    /* Reads into an initialised, empty volume; fills info's arrays and notes (info is never NULL here). The dispatcher adds the path in
     * front of messages, format to info, and calls pel_volume_check, pel_volume_update_range and pel_volume_detect_labels afterwards, and
     * finishes the volume on failure. The file may be gzip'd as a whole: open it with pel_stream_open(path, PEL_STREAM_AUTO, ...). NULL:
     * cannot read. */
    bool (*read)(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                 struct pel_error *error);

    /* Writes, through pel_safe_file. The dispatcher adds the path in front of messages. NULL: cannot write. */
    bool (*write)(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error);
};

extern const struct pel_format pel_format_nrrd, pel_format_nifti, pel_format_metaimage, pel_format_raw;
extern const struct pel_format pel_format_tiff, pel_format_vtk, pel_format_vti, pel_format_dicom;

/* NULL-terminated, in the order in which probes are asked. At most PEL_MOST_FORMATS, which their definition makes sure of. */
enum { PEL_MOST_FORMATS = 32 };
extern const struct pel_format *const pel_formats[];

/* Case-insensitive: does `path` end in one of the words of `endings` (".nrrd .nhdr")? */
bool pel_path_has_ending(const char *path, const char *endings);

/* `name` relative to the folder of `path` (unless absolute). Owned by the caller; NULL: out of memory. */
char *pel_path_beside(const char *path, const char *name, struct pel_error *error);

/* The path of a data file that the header at `path` names: pel_path_beside, where params->may_open allows it. */
char *pel_path_of_data(const char *path, const char *name, const struct pel_read_params *params, struct pel_error *error);

/* Adds a note for the user; silently dropped beyond PEL_MAX_NOTES. */
void pel_info_note(struct pel_file_info *info, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Lists an array; silently dropped beyond PEL_MAX_ARRAYS. */
void pel_info_array(struct pel_file_info *info, const char *name, enum pel_type type, int components);

/* Which of info's arrays params->array asks for: its index; where it is NULL, `fallback`. -1 and PEL_ERROR_ARGUMENT, with the names that
 * there are, where it has none of that name. */
int pel_info_choose(const struct pel_file_info *info, const struct pel_read_params *params, int fallback, struct pel_error *error);

/* Number of bytes of dims[0]*dims[1]*dims[2]*components numbers; refuses zero dims, 0 or more than 4 components and overflow. */
bool pel_volume_size_check(const uint64_t dims[3], enum pel_type type, uint64_t components, size_t *bytes, struct pel_error *error);

/* Sets spacing and direction of one index axis from the world vector between neighbouring samples. A vector that is zero or not finite
 * becomes the unit vector along world axis `axis`, spacing 1, with a note. */
void pel_volume_set_axis(struct pel_volume *volume, int axis, const double step[3], struct pel_file_info *info);

/* Makes direction invertible where the file's is not (a plane of vectors): falls back to the identity, with a note. Called after the axes
 * are set. */
void pel_volume_mend_directions(struct pel_volume *volume, struct pel_file_info *info);

/* Reverses the bytes of each of `count` numbers of `size` bytes in place. */
void pel_swap_bytes(void *numbers, size_t count, size_t size);

/* Copies text into a fixed buffer, cut where too long, control characters replaced by spaces. */
void pel_copy_text(char *out, size_t size, const char *text);

/* Byte order of this machine. */
#define PEL_HOST_BIG_ENDIAN (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)

#endif
