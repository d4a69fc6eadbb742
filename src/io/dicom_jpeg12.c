/* SPDX-License-Identifier: MIT */
/* JPEG with samples of 9 to 12 bits; see dicom_jpeg.h. */
#include <stddef.h>
#include <stdio.h>

#include <gdcmjpeg/12/jpeglib.h>

#define PEL_JPEG_FUNCTION pel_dicom_jpeg12
#include "dicom_jpeg.h"
