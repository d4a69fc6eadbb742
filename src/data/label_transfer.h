/* SPDX-License-Identifier: MIT */
/* Transfer function of a segmentation: a colour for each label. */
#ifndef PEL_DATA_LABEL_TRANSFER_H
#define PEL_DATA_LABEL_TRANSFER_H

#include <pellucid/transfer.h>

/* `opaque`: every label, the background too, has opacity 1. Else the background is clear and large labels are translucent. */
bool pel_label_transfer(struct pel_transfer *transfer, const struct pel_volume *volume, bool opaque, struct pel_error *error);

#endif
