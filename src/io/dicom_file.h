/* SPDX-License-Identifier: MIT */
/* One DICOM file: what its header says of pixels, place and series, and the samples of its frames as they are stored. */
#ifndef PEL_IO_DICOM_FILE_H
#define PEL_IO_DICOM_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>

/* Where a frame lies and what its numbers mean. */
struct pel_dicom_frame {
    bool has_position, has_orientation, has_spacing;
    double position[3];    /* of the first pixel's centre, LPS, mm */
    double orientation[6]; /* unit vectors along a row and along a column */
    double spacing[2];     /* between columns (x) and between rows (y), mm */
    double slope, intercept;
};

/* How numbers are stored. */
struct pel_dicom_pixels {
    uint32_t rows, columns;
    int samples; /* numbers a pixel: 1 or 3 */
    int allocated, stored, high_bit;
    bool is_signed, planes; /* planes: of each frame first all reds, then all greens, then all blues */
    bool is_float;          /* Float or Double Float Pixel Data */
    char photometric[24];
};

struct pel_dicom_file {
    char *path; /* owned */
    char series_uid[72], description[72], modality[24], syntax[72];
    int series_number, instance_number, acquisition_number;
    double thickness, between; /* slice thickness, spacing between slices; 0: not told */
    struct pel_dicom_pixels pixels;
    struct pel_dicom_frame shared;  /* of all frames, as far as it is told */
    struct pel_dicom_frame *frames; /* owned; of each frame, NULL where none tells anything of its own */
    uint64_t described, frame_count;
    bool big_endian, encapsulated, has_pixels;
    uint64_t pixel_offset, pixel_length; /* encapsulated: of the items, to the end of the file */
    uint64_t *fragments;                 /* owned; offset and length of each fragment of encapsulated data */
    uint64_t fragment_count;
    uint64_t *table; /* owned; the basic offset table: where each frame's first fragment stands from the first one on */
    uint64_t table_count;
};

/* Reads the header. Nothing in it is believed that does not fit into the file. *is_dicom tells, also on failure, whether the file looked
 * like one. */
bool pel_dicom_file_open(struct pel_dicom_file *file, const char *path, bool *is_dicom, struct pel_error *error);
void pel_dicom_file_finish(struct pel_dicom_file *file); /* accepts a zeroed one */

/* Refuses pixels that cannot be read, and more of them than the file can hold. */
bool pel_dicom_file_check(const struct pel_dicom_file *file, struct pel_error *error);

/* What is known of a frame. */
const struct pel_dicom_frame *pel_dicom_file_frame(const struct pel_dicom_file *file, uint64_t frame);

/* Bytes of one frame, as stored. */
size_t pel_dicom_frame_bytes(const struct pel_dicom_pixels *pixels);

/* One frame's samples as stored (unpacked where the file compresses them): little-endian unless the file is big-endian. */
bool pel_dicom_file_read(const struct pel_dicom_file *file, uint64_t frame, void *out, size_t size, struct pel_error *error);

/* Unpacks a frame in JPEG, JPEG-LS or JPEG 2000 (dicom_decode.c). */
bool pel_dicom_decode(const char *syntax, const struct pel_dicom_pixels *pixels, const unsigned char *bytes, size_t size, void *out,
                      size_t out_size, struct pel_error *error);

#endif
