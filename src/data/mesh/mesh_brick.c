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

/* Rows and samples that the brick and its halo read. */
struct reads {
    size_t at[3][HALO]; /* voxels along each axis */
};

#define LOAD_NUMBERS(T)                                                                                                                    \
    for (int z = 0; z < HALO; z++)                                                                                                         \
        for (int y = 0; y < HALO; y++) {                                                                                                   \
            const T *row = (const T *)v->data + (r->at[2][z] * v->dims[1] + r->at[1][y]) * v->dims[0];                                     \
            for (int x = 0; x < HALO; x++)                                                                                                 \
                b->values[z][y][x] = (double)row[r->at[0][x]] - b->work->isovalue;                                                         \
        }                                                                                                                                  \
    break

static void load_numbers(struct pel_brick *b, const struct reads *r)
{
    const struct pel_volume *v = b->work->volume;
    switch (v->type) {
    case PEL_U8:
        LOAD_NUMBERS(unsigned char);
    case PEL_I8:
        LOAD_NUMBERS(signed char);
    case PEL_U16:
        LOAD_NUMBERS(unsigned short);
    case PEL_I16:
        LOAD_NUMBERS(short);
    case PEL_U32:
        LOAD_NUMBERS(unsigned);
    case PEL_I32:
        LOAD_NUMBERS(int);
    case PEL_F32:
        LOAD_NUMBERS(float);
    case PEL_F64:
        LOAD_NUMBERS(double);
    case PEL_TYPE_COUNT:
        break;
    }
}

/* Where there may be voids. */
static void load_samples(struct pel_brick *b, const struct reads *r)
{
    const struct pel_volume *v = b->work->volume;
    const size_t first = r->at[0][0], count = r->at[0][HALO - 1] - first + 1;
    double samples[HALO];
    for (int z = 0; z < HALO; z++)
        for (int y = 0; y < HALO; y++) {
            pel_samples_load(v, (r->at[2][z] * v->dims[1] + r->at[1][y]) * v->dims[0] + first, count, samples);
            for (int x = 0; x < HALO; x++) {
                double value = samples[r->at[0][x] - first];
                b->values[z][y][x] = isfinite(value) ? value - b->work->isovalue : NAN;
            }
        }
}

/* Inside is where the isovalue is reached, as for the ray caster. */
void pel_brick_load(struct pel_brick *b)
{
    const struct pel_volume *v = b->work->volume;
    for (int a = 0; a < 3; a++)
        b->voxels[a] = v->dims[a] - b->first[a] < SIDE ? (int)(v->dims[a] - b->first[a]) : SIDE;
    struct reads reads;
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < HALO; i++)
            reads.at[a][i] = clamped(b->first[a], i - 1, v->dims[a]);
    if (b->work->minmax->has_voids)
        load_samples(b, &reads);
    else
        load_numbers(b, &reads);
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++) {
            const double *row = &b->values[z + 1][y + 1][1];
            unsigned inside = 0, voids = 0;
            for (int x = 0; x < SIDE; x++) {
                inside |= (unsigned)(row[x] >= 0) << x;
                voids |= (unsigned)isnan(row[x]) << x;
            }
            b->inside[z][y] = inside;
            b->voids[z][y] = voids;
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
