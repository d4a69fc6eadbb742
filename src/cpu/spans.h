/* SPDX-License-Identifier: MIT */
/* Spans: for each block of 4x4 pixels, which of PEL_SPAN_SLABS slabs of depth hold something that may be seen. What is visible is projected
 * onto the blocks before any ray is cast, so that rays which meet nothing are never set up, and the others start, pause and end where
 * something is. This is the slab mask of multi-layer depth peeling (paper 001, section 4.2) with 64-bit words for layers' slices, made by
 * the CPU for packets instead of by the rasteriser for pixels. Cells are projected whole; of isosurfaces, unless a voxel is below a pixel,
 * the single voxel cells whose corners lie on both sides of an isovalue, and then nothing else needs to be looked at. */
#ifndef PEL_CPU_SPANS_H
#define PEL_CPU_SPANS_H

#include "kernel.h"

struct pel_spans {
    uint64_t *masks; /* owned; PEL_SPAN_WORDS words a block */
    size_t words;
    uint8_t *folds; /* owned; for each thread a row of cells to work in */
    size_t fold_bytes;
};

/* Fills the masks from the job's marks for the scene's camera, and points the job at them; sets job->spans to NULL where they cannot be
 * used (the camera is among the cells, or skipping is off). `cells` is the size of the marks. `project_surface` (nullable): the kernels'
 * function that projects single voxel cells. job->looks tells afterwards whether rays need the distance maps as well. */
bool pel_spans_build(struct pel_spans *spans, const struct pel_scene *scene, const size_t cells[3], size_t visible_cells,
                     pel_project_surface project_surface, int threads, struct pel_job *job, struct pel_error *error);
void pel_spans_finish(struct pel_spans *spans);

#endif
