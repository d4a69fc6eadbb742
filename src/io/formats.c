/* SPDX-License-Identifier: MIT */
/* The formats. To add one: a line here. Formats with a sure mark at their beginning come first; the raw format has none and is asked for by
 * name. */
#include "format.h"

const struct pel_format *const pel_formats[] = {
    &pel_format_nrrd, &pel_format_nifti, &pel_format_tiff, &pel_format_vti, &pel_format_vtk,
    &pel_format_metaimage, &pel_format_dicom, &pel_format_raw, NULL,
};
_Static_assert(sizeof pel_formats / sizeof *pel_formats - 1 <= PEL_MOST_FORMATS, "the table has outgrown what counts its formats");

const struct pel_format_info *pel_format_at(size_t index)
{
    size_t count = sizeof pel_formats / sizeof *pel_formats - 1;
    return index < count ? &pel_formats[index]->info : NULL;
}
