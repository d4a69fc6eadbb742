/* SPDX-License-Identifier: MIT */
/* The codecs that compressed DICOM pixels need, a file each. All put out numbers of `bytes` bytes (1 or 2), little-endian, component
 * fastest; where they fail, `why` says in a few words what was wrong. The sizes were held against the compressed bytes before. */
#ifndef PEL_IO_DICOM_DECODE_H
#define PEL_IO_DICOM_DECODE_H

#include <stdbool.h>
#include <stddef.h>

#define PEL_DICOM_WHY 200

/* What is to come out. */
struct pel_dicom_frame_shape {
    unsigned columns, rows, samples, bytes;
    bool luma; /* colours are stored as brightness and two differences, and are to come out as RGB (JPEG only) */
};

/* JPEG of every kind that DICOM has: baseline and extended (8 and 12 bits) and lossless (2 to 16 bits). libgdcmjpeg comes compiled for
 * three widths. */
bool pel_dicom_jpeg8(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why);
bool pel_dicom_jpeg12(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why);
bool pel_dicom_jpeg16(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why);

/* JPEG-LS, with CharLS. */
bool pel_dicom_jpegls(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why);

/* JPEG 2000, with OpenJPEG. */
bool pel_dicom_jpeg2000(const unsigned char *bytes, size_t size, const struct pel_dicom_frame_shape *shape, unsigned char *out, char *why);

#endif
