/* SPDX-License-Identifier: MIT */
/* A DICOM series: which of a folder's slices belong together, and in which order they lie in space. */
#ifndef PEL_IO_DICOM_SERIES_H
#define PEL_IO_DICOM_SERIES_H

#include "dicom_file.h"
#include "format.h"

/* One slice: a frame of a file. */
struct pel_dicom_slice {
    const struct pel_dicom_file *file;
    uint64_t frame;
    double position; /* along the normal of the slices */
    int group;
};

/* Of `files`, takes the slices that make one volume: those of the series that is asked for, or else of the largest one, in its largest
 * group of equal shape and orientation, sorted along their normal, one at each position. `slices` has room for all frames; *count becomes
 * the number that is taken. Notes tell what is left out. Sets the placement of `volume`. Fails where slices are missing, for then the rest
 * would stand at wrong places. */
bool pel_dicom_series_choose(struct pel_dicom_file *const *files, size_t file_count, const char *wanted, struct pel_dicom_slice *slices,
                             size_t *count, struct pel_volume *volume, struct pel_file_info *info, struct pel_error *error);

/* The last part of a file's path. */
const char *pel_dicom_file_name(const struct pel_dicom_file *file);

#endif
