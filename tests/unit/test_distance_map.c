/* SPDX-License-Identifier: MIT */
/* The distance maps of all octants against the definition, cell by cell. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "distance_map.h"

enum { NX = 11, NY = 7, NZ = 9, ROW = 16, SLICE = 128 };

static bool marked(const uint8_t *marks, int x, int y, int z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < NX && y < NY && z < NZ && !marks[z * SLICE + y * ROW + x];
}

/* Edge of the largest unmarked cube from (x, y, z) into the octant, by trying. */
static int by_trying(const uint8_t *marks, int x, int y, int z, unsigned octant)
{
    for (int d = 0; d <= NX; d++) /* farther there are no cells */
        for (int k = 0; k <= d; k++)
            for (int j = 0; j <= d; j++)
                for (int i = 0; i <= d; i++)
                    if ((i == d || j == d || k == d) &&
                        marked(marks, octant & 1 ? x - i : x + i, octant & 2 ? y - j : y + j, octant & 4 ? z - k : z + k))
                        return d;
    return PEL_DISTANCE_FAR;
}

static void test_octants(void **state)
{
    (void)state;
    const size_t dims[3] = { NX, NY, NZ };
    uint8_t marks[NZ * SLICE], map[NZ * SLICE];
    for (int density = 0; density < 3; density++) {
        uint32_t random = 12345;
        for (size_t i = 0; i < sizeof marks; i++) {
            random = random * 1664525u + 1013904223u;
            marks[i] = (random >> 16) % 100 >= (density == 0 ? 30u : density == 1 ? 3u : 1u);
        }
        for (unsigned octant = 0; octant < 8; octant++) {
            memset(map, 77, sizeof map);
            assert_true(pel_distance_map(marks, dims, ROW, SLICE, octant, map, NULL));
            for (int z = 0; z < NZ; z++)
                for (int y = 0; y < NY; y++)
                    for (int x = 0; x < NX; x++) {
                        assert_int_equal(map[z * SLICE + y * ROW + x], by_trying(marks, x, y, z, octant));
                    }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_octants) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
