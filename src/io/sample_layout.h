/* SPDX-License-Identifier: MIT */
/* Reading samples in the encodings that several formats share, into memory that is as large as they are and no larger. */
#ifndef PEL_IO_SAMPLE_LAYOUT_H
#define PEL_IO_SAMPLE_LAYOUT_H

#include "format.h"
#include "text.h"

/* What a number in a file may be: the library's types, and the two that are made into f64 where nothing is lost by it. */
enum pel_file_type { PEL_FILE_I64 = PEL_TYPE_COUNT, PEL_FILE_U64 };

/* The type in memory of a type in a file. */
enum pel_type pel_file_type_in_memory(int file_type);

/* Where samples lie in a file: up to 8 axes, fastest first. Which of them are x, y, z and the components; the others are taken at index 0.
 */
struct pel_layout {
    int axis_count;
    uint64_t sizes[8];
    int component_axis; /* -1: none */
    int axes[3];        /* file axis of x, y, z; -1: one sample */
    int type;           /* enum pel_type or pel_file_type */
    bool big_endian;
    bool scaled;        /* the volume gets value * slope + intercept, as f32, or as f64 where f32 would lose of the file's type */
    double slope, intercept;
};

/* Gives the bytes of the numbers in the file's order. A reader with several files hands them out one after the other; one whose numbers are
 * text makes host-order numbers of them and says so in the layout. */
struct pel_sample_source {
    bool (*read)(void *user, void *bytes, size_t size, struct pel_error *error); /* exactly size bytes */
    void *user;
};

/* Bytes that the layout needs from its source; fails on overflow and on shapes that no volume has. */
bool pel_layout_check(const struct pel_layout *layout, uint64_t *bytes, struct pel_error *error);

/* Tells the user where the samples become another type in memory. */
void pel_layout_note(const struct pel_layout *layout, struct pel_file_info *info);

/* Allocates the volume's samples and fills them. The caller has held pel_layout_check's bytes against the file. */
bool pel_layout_read(const struct pel_layout *layout, const struct pel_sample_source *source, struct pel_volume *volume,
                     struct pel_error *error);

/* `count` numbers written as text, into host-order numbers of the file type; and `size` bytes written as pairs of hexadecimal digits. */
bool pel_text_file_numbers(struct pel_text *text, int file_type, void *numbers, size_t count, struct pel_error *error);
bool pel_text_hex(struct pel_text *text, unsigned char *bytes, size_t size, struct pel_error *error);

/* Makes 64-bit integers f64 in place; fails where a value would change. */
bool pel_int64_to_f64(void *numbers, size_t count, bool is_unsigned, struct pel_error *error);

/* Writes the samples as they lie in memory (this machine's byte order), or the same as one gzip or zlib stream. */
bool pel_write_samples(struct pel_safe_file *out, const struct pel_volume *volume, const struct pel_progress *progress,
                       struct pel_error *error);
bool pel_write_samples_deflated(struct pel_safe_file *out, const struct pel_volume *volume, bool gzip, const struct pel_progress *progress,
                                struct pel_error *error);

#endif
