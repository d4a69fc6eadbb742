/* SPDX-License-Identifier: MIT */
/* The cells of a box of the volume on the device: their min-max grid, which of them may be seen, and the distance maps by which rays pass
 * over the others (minmax.h, classify.h, distance_map.h). Hardware makes all three by shaders; for software devices the CPU makes grid and
 * maps, which it does ten to twenty times as fast. */
#ifndef PEL_RENDER_GPU_CELLS_H
#define PEL_RENDER_GPU_CELLS_H

#include "gpu_job.h"

struct pel_gpu_cells {
    int count[3];
    struct pel_texture grid, marks, distances;
    unsigned octants; /* whose distance maps are there */
    uint32_t visible; /* cells that may be seen */
};

/* What making them needs beside them: shared by all boxes. */
struct pel_gpu_cell_maker {
    struct pel_device *device;
    struct pel_programs *programs;
    struct pel_texture scratch[2];
    struct pel_buffer seen;
    int threads;
};

/* Bytes on the device for so many cells. */
uint64_t pel_gpu_cells_bytes(const int count[3]);

/* The min-max grid of the box's cells, out of that of the whole volume. */
bool pel_gpu_cells_send(const struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, const struct pel_minmax *minmax,
                        const struct pel_gpu_box *box, struct pel_raw_scale raw, struct pel_error *error);

/* The others expect the box's uniform block, its volume texture and the range table to be bound. */

/* The same by a shader, for a box that is the whole volume. */
bool pel_gpu_cells_build(const struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, const struct pel_gpu_box *box, bool voids,
                         struct pel_error *error);
/* Marks what may be seen, and forgets the distance maps. */
bool pel_gpu_cells_mark(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, enum pel_mode mode, struct pel_error *error);
/* Sees to it that there are maps for all octants into which rays go; `octants` has a bit for each. */
bool pel_gpu_cells_map(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, unsigned octants, struct pel_error *error);

void pel_gpu_cells_finish(struct pel_device *device, struct pel_gpu_cells *cells); /* accepts zeroed ones */
void pel_gpu_cell_maker_finish(struct pel_gpu_cell_maker *maker);

#endif
