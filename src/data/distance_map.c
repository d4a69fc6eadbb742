/* SPDX-License-Identifier: MIT */
/* Two raster scans (Borgefors' chamfer method with all weights 1, which is exact for this distance). The rows before a row are folded into one, which the
 * compiler vectorises; only the step from cell to cell within the row is serial. */
#include "distance_map.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"

static inline uint8_t least(uint8_t a, uint8_t b)
{
    return a < b ? a : b;
}

/* row = min(row, 1 + the least of the 3-wide windows of up to four neighbouring rows). `fold` has n + 2 bytes. */
static void relax(uint8_t *restrict row, const uint8_t *const neighbours[4], size_t n, uint8_t *restrict fold)
{
    memset(fold, PEL_DISTANCE_FAR, n + 2);
    for (int i = 0; i < 4; i++)
        if (neighbours[i]) {
            const uint8_t *restrict from = neighbours[i];
            for (size_t x = 0; x < n; x++)
                fold[x + 1] = least(fold[x + 1], from[x]);
        }
    for (size_t x = 0; x < n; x++) {
        uint8_t m = least(least(fold[x], fold[x + 1]), fold[x + 2]);
        row[x] = least(row[x], (uint8_t)(least(m, PEL_DISTANCE_FAR - 1) + 1));
    }
}

bool pel_distance_map(uint8_t *map, const size_t dims[3], size_t row, size_t slice, struct pel_error *error)
{
    size_t nx = dims[0], ny = dims[1], nz = dims[2];
    uint8_t *fold = pel_alloc(nx + 2, 1, "distance map", error);
    if (!fold)
        return false;
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++) {
            uint8_t *to = map + z * slice + y * row;
            for (size_t x = 0; x < nx; x++)
                to[x] = to[x] ? PEL_DISTANCE_FAR : 0;
            const uint8_t *before[4] = { y ? to - row : NULL, z && y ? to - slice - row : NULL, z ? to - slice : NULL,
                                         z && y + 1 < ny ? to - slice + row : NULL };
            relax(to, before, nx, fold);
            for (size_t x = 1; x < nx; x++)
                to[x] = least(to[x], (uint8_t)(to[x - 1] + 1));
        }
    for (size_t z = nz; z-- > 0;)
        for (size_t y = ny; y-- > 0;) {
            uint8_t *to = map + z * slice + y * row;
            const uint8_t *behind[4] = { y + 1 < ny ? to + row : NULL, z + 1 < nz && y + 1 < ny ? to + slice + row : NULL,
                                         z + 1 < nz ? to + slice : NULL, z + 1 < nz && y ? to + slice - row : NULL };
            relax(to, behind, nx, fold);
            for (size_t x = nx - 1; x-- > 0;)
                to[x] = least(to[x], (uint8_t)(to[x + 1] + 1));
        }
    free(fold);
    return true;
}
