/* SPDX-License-Identifier: MIT */
/* Chebyshev distance on a grid of cells: how many cells away, counted along diagonals too, the nearest marked cell is. A ray in a cell at distance d may pass over the
 * whole cube of cells nearer than d. */
#ifndef PEL_DATA_DISTANCE_MAP_H
#define PEL_DATA_DISTANCE_MAP_H

#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>

#define PEL_DISTANCE_FAR 250 /* the most that is told */

/* In place: on entry 0 marks a cell and anything else means unmarked; on return each cell holds its distance, at most PEL_DISTANCE_FAR. `map` has a byte a cell,
 * x fastest, `row` bytes from one row and `slice` bytes from one slice to the next. Fails only for want of memory for a few rows. */
bool pel_distance_map(uint8_t *map, const size_t dims[3], size_t row, size_t slice, struct pel_error *error);

#endif
