/* SPDX-License-Identifier: MIT */
/* JPEG with samples of 8 bits; see dicom_jpeg.h. */
#include <stddef.h>
#include <stdio.h>

#include <gdcmjpeg/8/jpeglib.h>

#define PEL_JPEG_FUNCTION pel_dicom_jpeg8
#include "dicom_jpeg.h"
