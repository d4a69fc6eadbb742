/* SPDX-License-Identifier: MIT */
#include "slices3d.h"

bool pel_slices_note_cost(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    (void)s, (void)frame, (void)error;
    return true;
}
