/* SPDX-License-Identifier: MIT */
/* One raster scan against the octant: d(c) = 1 + the least d of the seven neighbours towards it (the recurrence of the largest empty cube).
 * The three rows that were finished before are folded into one, which the compiler vectorises; only the step from cell to cell within the
 * row is serial. */
#include "distance_map.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"

static inline uint8_t least(uint8_t a, uint8_t b)
{
    return a < b ? a : b;
}

/* One row: `done` are the finished rows towards the octant, NULL outside the grid. `fold` has n + 2 bytes. */
static void scan_row(const uint8_t *marks, uint8_t *restrict to, const uint8_t *const done[3], size_t n, bool down, uint8_t *restrict fold)
{
    memset(fold, PEL_DISTANCE_FAR, n + 2);
    for (int i = 0; i < 3; i++)
        for (size_t x = 0; done[i] && x < n; x++)
            fold[x + 1] = least(fold[x + 1], done[i][x]);
    const uint8_t *beside = down ? fold : fold + 2; /* the neighbour along x, of the folded rows */
    for (size_t x = 0; x < n; x++)
        to[x] = marks[x] ? (uint8_t)(least(least(fold[x + 1], beside[x]), PEL_DISTANCE_FAR - 1) + 1) : 0;
    if (down) {
        for (size_t x = 1; x < n; x++)
            to[x] = least(to[x], (uint8_t)(to[x - 1] + 1));
    } else {
        for (size_t x = n - 1; x-- > 0;)
            to[x] = least(to[x], (uint8_t)(to[x + 1] + 1));
    }
}

bool pel_distance_map(const uint8_t *marks, const size_t dims[3], size_t row, size_t slice, unsigned octant, uint8_t *map,
                      struct pel_error *error)
{
    uint8_t *fold = pel_alloc(dims[0] + 2, 1, "distance map", error);
    if (!fold)
        return false;
    bool down_y = octant & 2, down_z = octant & 4;
    for (size_t k = 0; k < dims[2]; k++)
        for (size_t j = 0; j < dims[1]; j++) {
            size_t z = down_z ? k : dims[2] - 1 - k, y = down_y ? j : dims[1] - 1 - j, at = z * slice + y * row;
            const uint8_t *same_slice = j ? map + (down_y ? at - row : at + row) : NULL;
            const uint8_t *same_row = k ? map + (down_z ? at - slice : at + slice) : NULL;
            const uint8_t *both = j && k ? same_row + (same_slice - (map + at)) : NULL;
            scan_row(marks + at, map + at, (const uint8_t *const[3]){ same_slice, same_row, both }, dims[0], octant & 1, fold);
        }
    free(fold);
    return true;
}
