/* SPDX-License-Identifier: MIT */
/* Which places of a slice may be seen, to the voxel: a bit a patch, the square between 2 x 2 voxels of one slice (shear_runs.h). A sample in a
 * slice of voxels is a mean of its patch's four, so what it looks up lies between the least and the greatest of them. Only cells that may be
 * seen are looked into: of their patches many hold nothing where what is seen is thin. */
#ifndef PEL_CPU_KERNEL_PATCHES_H
#define PEL_CPU_KERNEL_PATCHES_H

#include "kernel_common.h"
#include "kernel_shear_line.h"

#if PEL_KIND != PEL_KIND_WIDE

/* The lanes whose cells may be seen, of W voxels from x0 on in the row of cells `marks`. */
PEL_INLINE unsigned patch_lanes(const struct pel_job *job, const uint8_t *marks, int x0)
{
    unsigned lanes = 0;
    for (int c = 0; c < W / PEL_CELL_SIZE; c++) {
        const int cell = (x0 >> PEL_CELL_SHIFT) + c;
        if (cell < job->cell_dims[0] && !marks[cell])
            lanes |= ((1u << PEL_CELL_SIZE) - 1) << (c * PEL_CELL_SIZE);
    }
    return lanes;
}

/* Lanes whose patches may be seen, at W voxels from `at` on; `side` leads along a patch's two sides. */
PEL_INLINE vi patch_seen(const struct pel_job *job, ptrdiff_t at, const ptrdiff_t side[2])
{
    const struct slice_row r = { .rows = job->data, .offset = at, .next_row = side[0], .next_slice = side[1] };
    row_voxels a = row_load(job, &r, 0, 0, 0, 0), b = row_load(job, &r, 0, 0, 1, 0), c = row_load(job, &r, 0, 0, 0, 1),
               d = row_load(job, &r, 0, 0, 1, 1);
    vf least = row_float(row_least(row_least(a, b), row_least(c, d))), most = row_float(row_most(row_most(a, b), row_most(c, d)));
    const vf last = vf_set((float)job->table_last), none = vf_set(0);
    vi from = vf_to_vi(vf_min(vf_max(least * job->table_scale + (job->table_offset - job->table_slack), none), last));
    vi to = vf_to_vi(vf_min(vf_max(most * job->table_scale + (job->table_offset + job->table_slack), none), last));
    return (vi)vf_gather((const float *)job->next_visible, from) <= to;
}

struct patch_block {
    const int *axis;
    uint8_t *seen;
    ptrdiff_t row;   /* bytes */
    int x0, y0;
    unsigned lanes;  /* whose cells may be seen */
    int back;        /* at the end of a row whole vectors are loaded from so many voxels before x0; W: not at all, and all is taken for seen */
};

/* The patches of W voxels along x and up to four along y. */
PEL_INLINE void patch_rows(const struct pel_job *job, const struct patch_block *b, int z)
{
    const ptrdiff_t strides[3] = { 1, job->row, job->slice };
    const int end = b->y0 + PEL_CELL_SIZE < job->dims[1] ? b->y0 + PEL_CELL_SIZE : job->dims[1];
    vi along_y = vi_set(0);
    for (int y = b->y0; y < end; y++) {
        const int place[3] = { b->x0, y, z };
        ptrdiff_t side[2];
        for (int i = 0; i < 2; i++) /* at the volume's end the last voxel again */
            side[i] = place[b->axis[i]] + 1 < job->dims[b->axis[i]] ? strides[b->axis[i]] : 0;
        unsigned bits = ~0u;
        if (b->back < W)
            bits = vi_bits(patch_seen(job, b->x0 - b->back + y * strides[1] + z * strides[2], side)) >> b->back;
        if (b->axis[0] == 0 && b->back) /* the last patch is the last voxel alone, which is the one's before it, too */
            bits |= (bits << 1) & (1u << (job->dims[0] - 1 - b->x0));
        bits &= b->lanes;
        if (b->axis[0] == 1) {
            along_y |= (bits_to_lanes(bits) & 1) << (y - b->y0);
            continue;
        }
        const ptrdiff_t row = (ptrdiff_t)place[b->axis[2]] * job->dims[b->axis[1]] + place[b->axis[1]];
        uint8_t *to = b->seen + row * b->row + (b->x0 >> 3);
        to[0] |= (uint8_t)(bits << (b->x0 & 7));
        if (W > 8)
            to[1] |= (uint8_t)(bits >> 8);
    }
    for (int l = 0; b->axis[0] == 1 && l < W && b->x0 + l < job->dims[0]; l++)
        b->seen[((ptrdiff_t)(b->x0 + l) * job->dims[2] + z) * b->row + (b->y0 >> 3)] |= (uint8_t)(along_y[l] << (b->y0 & 7));
}

static void patch_slab(const struct pel_job *job, const int axis[3], int slab, uint8_t *seen, ptrdiff_t row)
{
    const int beyond = axis[0] == 0 ? 1 : 0; /* a patch reads a voxel beyond its own */
    const int z0 = slab * PEL_CELL_SIZE, z1 = z0 + PEL_CELL_SIZE < job->dims[2] ? z0 + PEL_CELL_SIZE : job->dims[2];
    for (int cy = 0; cy < job->cell_dims[1]; cy++) {
        const uint8_t *marks = job->marks + ((size_t)slab << job->cell_slice_shift) + ((size_t)cy << job->cell_row_shift);
        for (int x0 = 0; x0 < job->dims[0]; x0 += W) {
            const int over = x0 + W + beyond - job->dims[0], back = over <= 0 ? 0 : job->dims[0] >= W + beyond ? over : W;
            const struct patch_block b = { axis, seen, row, x0, cy * PEL_CELL_SIZE, patch_lanes(job, marks, x0), back };
            for (int z = z0; b.lanes && z < z1; z++)
                patch_rows(job, &b, z);
        }
    }
}

#else

static void patch_slab(const struct pel_job *job, const int axis[3], int slab, uint8_t *seen, ptrdiff_t row)
{
    (void)job, (void)axis, (void)slab, (void)seen, (void)row; /* never asked for */
}

#endif

#endif
