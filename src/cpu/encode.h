/* SPDX-License-Identifier: MIT */
/* Linear light back to display values. */
#ifndef PEL_CPU_ENCODE_H
#define PEL_CPU_ENCODE_H

#include "kernel.h"

/* Encodes the job's picture by the sRGB curve (IEC 61966-2-1): the colours without their opacity. */
void pel_encode_picture(const struct pel_job *job, int threads);

#endif
