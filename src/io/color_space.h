/* SPDX-License-Identifier: MIT */
/* Colours between two sRGB colours, along the ways that ParaView's colour maps take. */
#ifndef PEL_IO_COLOR_SPACE_H
#define PEL_IO_COLOR_SPACE_H

#include <stdbool.h>

enum pel_color_space {
    PEL_COLOR_SPACE_RGB,
    PEL_COLOR_SPACE_HSV,
    PEL_COLOR_SPACE_LAB,       /* CIE L*a*b*, D65 */
    PEL_COLOR_SPACE_DIVERGING, /* Msh: polar Lab, through white where the hues are far apart (Moreland 2009) */
    PEL_COLOR_SPACE_STEP,      /* the first colour all the way */
};

/* The colour at `t`, 0 to 1, between `a` and `b`. `wrap`: HSV takes the shorter way around the hues. */
void pel_color_between(enum pel_color_space space, bool wrap, const double a[3], const double b[3], double t, double rgb[3]);

#endif
