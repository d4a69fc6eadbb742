/* SPDX-License-Identifier: MIT */
/* JPEG with samples of 13 to 16 bits; see dicom_jpeg.h. */
#include <stddef.h>
#include <stdio.h>

#include <gdcmjpeg/16/jpeglib.h>

#define PEL_JPEG_FUNCTION pel_dicom_jpeg16
#include "dicom_jpeg.h"
