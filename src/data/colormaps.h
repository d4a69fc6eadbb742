/* SPDX-License-Identifier: MIT */
/* The named colour maps: each a list of points with straight lines between them. */
#ifndef PEL_DATA_COLORMAPS_H
#define PEL_DATA_COLORMAPS_H

#include <stddef.h>

#include <pellucid/error.h>

struct pel_colormap_point {
    double t; /* 0 to 1, increasing; the first is 0, the last 1 */
    double rgb[3];
};

struct pel_colormap {
    const char *name;
    size_t count;
    const struct pel_colormap_point *points;
};

/* The map of that name (upper or lower case), or NULL. */
const struct pel_colormap *pel_colormap_find(const char *name);

/* Fails with PEL_ERROR_ARGUMENT and the known names that are nearest to `name`. */
bool pel_colormap_fail_unknown(const char *name, struct pel_error *error);

#endif
