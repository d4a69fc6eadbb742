/* SPDX-License-Identifier: MIT */
/* What the current GL context says of itself. Only src/gpu sees this. */
#ifndef PEL_GPU_DESCRIBE_H
#define PEL_GPU_DESCRIBE_H

#include "device_gl.h"

/* Fills in names, limits, memory and whether it is usable, with a note where it is not. False: no context is current. */
bool pel_gl_describe(struct pel_device_info *info);

/* Writes each note and marks the one that is taken where no number is given. */
void pel_devices_compare(struct pel_device_info *infos, int count);

#endif
