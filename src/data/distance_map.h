/* SPDX-License-Identifier: MIT */
/* Directional Chebyshev distance on a grid of cells: how far a cube of unmarked cells reaches from a cell towards one octant of directions.
 * A ray that moves into the octant may pass over the whole cube. Compared with one distance for all directions, the cubes do not shrink
 * while a ray leaves what it has just passed. */
#ifndef PEL_DATA_DISTANCE_MAP_H
#define PEL_DATA_DISTANCE_MAP_H

#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>

#define PEL_DISTANCE_FAR 250 /* the most that is told */

/* `marks` has a byte a cell, 0 for a marked one, x fastest, `row` bytes from one row and `slice` bytes from one slice to the next; `map` is
 * laid out likewise. On return map[c] is 0 for a marked cell, else the greatest d <= PEL_DISTANCE_FAR for which the d^3 cells from c on,
 * towards lower indices along the axes whose bit is set in `octant` (1: x, 2: y, 4: z) and towards higher ones along the others, are
 * unmarked; cells outside the grid count as unmarked. Fails only for want of memory for a row. */
bool pel_distance_map(const uint8_t *marks, const size_t dims[3], size_t row, size_t slice, unsigned octant, uint8_t *map,
                      struct pel_error *error);

#endif
