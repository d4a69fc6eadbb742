/* SPDX-License-Identifier: MIT */
/* The cells of a box of the volume on the device: their min-max grid, which of them may be seen, and the distance maps by which rays pass
 * over the others (minmax.h, classify.h, distance_map.h).
 *
 * A whole volume on hardware has all three made by shaders. For bricks, and on software devices, the CPU keeps the grid of the whole volume
 * and marks cells; on software devices it makes the distance maps as well, ten to twenty times as fast. */
#ifndef PEL_RENDER_GPU_CELLS_H
#define PEL_RENDER_GPU_CELLS_H

#include "gpu_job.h"

struct pel_gpu_cells {
    int count[3];
    struct pel_texture grid, marks, distances;
    uint8_t *host_marks; /* owned; marks in place of the texture, where the CPU makes the maps */
    unsigned octants;    /* whose distance maps are there */
    uint32_t visible;    /* cells that may be seen, once `counted` */
    bool counted;
};

/* What making them needs beside them: shared by all boxes. */
struct pel_gpu_cell_maker {
    struct pel_device *device;
    struct pel_programs *programs;
    struct pel_texture scratch[2];
    struct pel_buffer seen;
    int threads;
};

/* What the CPU marks cells by, after pel_classify_tables. */
struct pel_gpu_marking {
    struct pel_classification_state *tables;
    const struct pel_scene *scene;
    const struct pel_minmax *minmax; /* of the whole volume */
    struct pel_raw_scale raw;
    const struct pel_job *job;
};

/* Bytes on the device for so many cells. */
uint64_t pel_gpu_cells_bytes(const int count[3]);

/* The shaders expect the box's uniform block, its volume texture and the range table to be bound. */

/* The min-max grid, of a box that is the whole volume. */
bool pel_gpu_cells_build(const struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, const struct pel_gpu_box *box, bool voids,
                         struct pel_error *error);
/* Marks what may be seen and forgets the distance maps: from the grid on the device, or by the CPU. */
bool pel_gpu_cells_mark(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, enum pel_mode mode, struct pel_error *error);
bool pel_gpu_cells_mark_by_cpu(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, const struct pel_gpu_box *box,
                               const struct pel_gpu_marking *marking, struct pel_error *error);
/* Sees to it that there are maps for all octants into which rays go; `octants` has a bit for each. */
bool pel_gpu_cells_map(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, unsigned octants, struct pel_error *error);

/* How many cells may be seen, of the cells that were marked last: waits for the device where it counts them. */
uint32_t pel_gpu_cells_visible(const struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells);

void pel_gpu_cells_finish(struct pel_device *device, struct pel_gpu_cells *cells); /* accepts zeroed ones */
void pel_gpu_cell_maker_finish(struct pel_gpu_cell_maker *maker);

#endif
