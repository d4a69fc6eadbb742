/* SPDX-License-Identifier: MIT */
/* The ray-casting kernels. Compiled once for each instruction set (PEL_ISA) and kind of voxel (PEL_KIND); each compilation exports one
 * table.
 *
 * Every loop but that from cell to cell (kernel_cells.h) has the same shape: at sample k, look whether the packet may jump (the cells around
 * hold nothing that can be seen); else sample all lanes, classify, stop early where nothing is visible, colour and composite. Samples in
 * empty cells that are taken because a neighbour lane needs its own add exactly nothing, so the skipping never changes a byte. */
#define PEL_KIND_U8 0
#define PEL_KIND_U16 1
#define PEL_KIND_F32 2
#define PEL_KIND_WIDE 3

#include "kernel_cells.h"
#include "kernel_composite.h"
#include "kernel_patches.h"
#include "kernel_projection.h"
#include "kernel_shear.h"
#include "kernel_spans.h"
#include "kernel_surface.h"
#include "kernel_turn.h"
#include "kernel_warp.h"

/* A tile: its packets in rows. Where CULL holds, a packet in whose pixels nothing may be seen stays as it is: empty. */
#define TILE(NAME, DRAW, CULL)                                                                              \
    static void NAME(const struct pel_job *job, int x0, int y0, int x1, int y1, struct pel_counts *counts)  \
    {                                                                                                       \
        for (int y = y0; y < y1; y += PACKET_HEIGHT)                                                        \
            for (int x = x0; x < x1; x += PACKET_WIDTH) {                                                   \
                struct packet r;                                                                            \
                if (!packet_spans(job, x, y, &r) && (CULL)) {                                               \
                    counts->culled += W;                                                                    \
                    continue;                                                                               \
                }                                                                                           \
                if (!packet_init(job, x, y, x1, y1, &r))                                                    \
                    continue;                                                                               \
                for (int i = 0; i < W; i++)                                                                 \
                    counts->in_box += (unsigned)r.n[i];                                                     \
                DRAW;                                                                                       \
            }                                                                                               \
    }

TILE(tile_composite, composite(job, &r, false, false, counts), true)
TILE(tile_composite_shaded, composite(job, &r, true, false, counts), true)
TILE(tile_composite_general, composite(job, &r, job->shade, true, counts), true)
TILE(tile_preintegrated, preintegrated(job, &r, counts), true)
TILE(tile_projection, projection(job, &r, counts), job->mode == PEL_MODE_XRAY)
TILE(tile_isosurface, isosurface_cells(job, &r, counts), true)
TILE(tile_isosurface_steps, isosurface_steps(job, &r, counts), true)
TILE(tile_slice, slice(job, &r, counts), false)

#define SHEAR_BAND(NAME, SHADED)                                                                                                          \
    static void NAME(const struct pel_job *job, const struct pel_shear *shear, int v0, int v1, struct pel_scanline *line,                 \
                     struct pel_counts *counts)                                                                                           \
    {                                                                                                                                     \
        unsigned before = flush_tiny();                                                                                                   \
        shear_band(job, shear, v0, v1, line, SHADED, counts);                                                                             \
        flush_restore(before);                                                                        \
    }

SHEAR_BAND(band_composite, false)
SHEAR_BAND(band_shaded, true)

extern const struct pel_kernels PEL_KERNELS;
const struct pel_kernels PEL_KERNELS = {
    project_surface,    tile_composite,  tile_composite_shaded, tile_composite_general,
    tile_preintegrated, tile_projection, tile_isosurface,       tile_isosurface_steps,
    tile_slice,
    band_composite,     band_shaded,     patch_slab,            turn_cells,
    warp_row,
};
