/* SPDX-License-Identifier: MIT */
/* Span masks of isosurfaces: the voxel cells that a surface passes through, found and projected many lanes at a time (spans.h). */
#ifndef PEL_CPU_KERNEL_SPANS_H
#define PEL_CPU_KERNEL_SPANS_H

#include "kernel_common.h"

#define CELL_VOXELS (PEL_CELL_SIZE * PEL_CELL_SIZE)

/* Which voxel cells of the 4^3 from voxel (x, y, z) on an isosurface may pass through: bit j + 4 k of to[i] stands for the voxel cell (x +
 * i, y + j, z + k). Lanes are the 5 x 5 rows of voxels along x. */
PEL_INLINE void surface_cells(const struct pel_job *job, int x, int y, int z, unsigned to[PEL_CELL_SIZE])
{
    vf value[PEL_CELL_SIZE + 1][32 / W];
    for (int part = 0; part < 32 / W; part++) {
        vi row = vi_lane() + part * W, k = (row * 13) >> 6, j = row - k * 5; /* row / 5, for row < 32 */
        vi py = vi_min(j + y, vi_set(job->dims[1] - 1)), pz = vi_min(k + z, vi_set(job->dims[2] - 1));
        for (int i = 0; i <= PEL_CELL_SIZE; i++)
            value[i][part] = fetch_voxel(job, vi_min(vi_set(x + i), vi_set(job->dims[0] - 1)), py, pz);
    }
    memset(to, 0, PEL_CELL_SIZE * sizeof *to);
    for (int s = 0; s < job->iso_count; s++) {
        float least = job->iso[s] - job->iso_margin, most = job->iso[s] + job->iso_margin;
        unsigned low[PEL_CELL_SIZE + 1] = { 0 },
                                     high[PEL_CELL_SIZE + 1] = { 0 }; /* bit j + 5 k: the voxel is at most, at least the isovalue */
        for (int i = 0; i <= PEL_CELL_SIZE; i++)
            for (int part = 0; part < 32 / W; part++) {
                low[i] |= vi_bits(value[i][part] <= most) << (part * W);
                high[i] |= vi_bits(value[i][part] >= least) << (part * W);
            }
        for (int i = 0; i < PEL_CELL_SIZE; i++) {
            unsigned a = low[i] | low[i + 1], b = high[i] | high[i + 1];
            a |= a >> 1, b |= b >> 1;
            a |= a >> 5, b |= b >> 5;
            unsigned both = a & b;
            to[i] |= (both & 0xf) | (both >> 1 & 0xf0) | (both >> 2 & 0xf00) | (both >> 3 & 0xf000);
        }
    }
}

/* Blocks of pixels, or slabs. */
struct covered {
    int32_t first[CELL_VOXELS], last[CELL_VOXELS];
};

/* Held to the picture before they become whole numbers; what is no number covers all. */
PEL_INLINE void cover(struct covered *c, int part, vf first, vf last, int count, int shift)
{
    vf end = vf_set((float)(count << shift));
    vi a = vf_to_vi(vf_min(vf_max(first, vf_set(0)), end)) >> shift, b = vf_to_vi(vf_max(vf_min(last, end - 1), vf_set(0))) >> shift;
    b = vi_select(last < 0, vi_set(-1), b); /* before the picture */
    memcpy(c->first + part * W, &a, sizeof a);
    memcpy(c->last + part * W, &b, sizeof b);
}

/* Marks the slabs of the voxel cells of the cell at voxel (x, y, z) that an isosurface may pass through in the blocks of pixels that they
 * cover. */
static void project_surface(const struct pel_job *job, const struct pel_projection *p, int x, int y, int z)
{
    unsigned cells[PEL_CELL_SIZE];
    surface_cells(job, x, y, z, cells);
    for (int i = 0; i < PEL_CELL_SIZE; i++) {
        if (!cells[i])
            continue;
        struct covered across[2], deep;
        for (int part = 0; part < CELL_VOXELS / W; part++) {
            vi lane = vi_lane() + part * W;
            vf vy = vi_to_vf((lane & 3) + y), vz = vi_to_vf((lane >> 2) + z), c[3];
            for (int a = 0; a < 3; a++)
                c[a] = (p->origin[a] + (float)(x + i) * p->axis[0][a]) + vy * p->axis[1][a] + vz * p->axis[2][a];
            vf near = c[2] - p->reach[2], far = c[2] + p->reach[2];
            vf scale_near = p->parallel ? vf_set(1) : 1 / near, scale_far = p->parallel ? vf_set(1) : 1 / far;
            for (int a = 0; a < 2; a++) {
                vf lo = c[a] - p->reach[a], hi = c[a] + p->reach[a];
                lo = lo * vf_select(lo < 0, scale_near, scale_far) * p->focal[a] + p->middle[a];
                hi = hi * vf_select(hi < 0, scale_far, scale_near) * p->focal[a] + p->middle[a];
                cover(&across[a], part, vf_min(lo, hi) - 0.01f, vf_max(lo, hi) + 0.01f, p->blocks[a], PEL_SPAN_SHIFT);
            }
            cover(&deep, part, (near - p->slab_start) * p->slabs, (far - p->slab_start) * p->slabs, PEL_SPAN_SLABS, 0);
        }
        for (unsigned rest = cells[i]; rest; rest &= rest - 1) {
            int l = __builtin_ctz(rest);
            pel_mark_span(p, across[0].first[l], across[0].last[l], across[1].first[l], across[1].last[l], deep.first[l], deep.last[l]);
        }
    }
}

#endif
