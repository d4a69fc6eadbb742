/* SPDX-License-Identifier: MIT */
/* A brick's voxels, and which of its cells a surface cuts. */
#include "mesh_brick.h"

#include <math.h>

#include "samples.h"

enum { SIDE = PEL_BRICK_SIDE, HALO = PEL_BRICK_HALO };

static size_t clamped(size_t first, int offset, size_t dim)
{
    if (offset < 0 && first < (size_t)-offset)
        return 0;
    size_t at = first + (size_t)offset;
    return at < dim ? at : dim - 1;
}

static void load_row(const struct pel_brick *b, size_t y, size_t z, double row[HALO])
{
    const struct pel_volume *v = b->work->volume;
    size_t x0 = clamped(b->first[0], -1, v->dims[0]), x1 = clamped(b->first[0], HALO - 2, v->dims[0]);
    double samples[HALO];
    pel_samples_load(v, (z * v->dims[1] + y) * v->dims[0] + x0, x1 - x0 + 1, samples);
    for (int x = 0; x < HALO; x++) {
        double value = samples[clamped(b->first[0], x - 1, v->dims[0]) - x0];
        row[x] = isfinite(value) ? value - b->work->isovalue : NAN;
    }
}

/* Inside is where the isovalue is reached, as for the ray caster. */
void pel_brick_load(struct pel_brick *b)
{
    const struct pel_volume *v = b->work->volume;
    for (int a = 0; a < 3; a++)
        b->voxels[a] = v->dims[a] - b->first[a] < SIDE ? (int)(v->dims[a] - b->first[a]) : SIDE;
    for (int z = 0; z < HALO; z++)
        for (int y = 0; y < HALO; y++)
            load_row(b, clamped(b->first[1], y - 1, v->dims[1]), clamped(b->first[2], z - 1, v->dims[2]), b->values[z][y]);
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++) {
            b->inside[z][y] = b->voids[z][y] = 0;
            for (int x = 0; x < SIDE; x++) {
                b->inside[z][y] |= (unsigned)(b->values[z + 1][y + 1][x + 1] >= 0) << x;
                b->voids[z][y] |= (unsigned)isnan(b->values[z + 1][y + 1][x + 1]) << x;
            }
        }
}

static bool cut_row(struct pel_brick *b, int y, int z)
{
    const unsigned rows[4] = { b->inside[z][y], b->inside[z][y + 1], b->inside[z + 1][y], b->inside[z + 1][y + 1] };
    const unsigned voids = b->voids[z][y] | b->voids[z][y + 1] | b->voids[z + 1][y] | b->voids[z + 1][y + 1];
    const unsigned all = (1u << b->voxels[0]) - 1;
    if (!((rows[0] | rows[1] | rows[2] | rows[3]) & all) || (rows[0] & rows[1] & rows[2] & rows[3] & all) == all)
        return true;
    for (int x = 0; x < b->voxels[0] - 1; x++) {
        unsigned inside = 0;
        for (int i = 0; i < 4; i++)
            inside |= (rows[i] >> x & 3) << (2 * i);
        const int cell[3] = { x, y, z };
        if (inside != 0 && inside != 255 && !(voids >> x & 3) && !pel_cell_cut(b, cell, inside))
            return false;
    }
    return true;
}

bool pel_brick_cut(struct pel_brick *b)
{
    for (int z = 0; z < b->voxels[2] - 1; z++)
        for (int y = 0; y < b->voxels[1] - 1; y++)
            if (!cut_row(b, y, z))
                return false;
    return true;
}
