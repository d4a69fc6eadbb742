/* SPDX-License-Identifier: MIT */
/* Layer 2 of the ray caster: what the transfer function and the isovalues make of the values. Look-up tables for one step's length, and the
 * map of what may be seen. */
#ifndef PEL_CPU_CLASSIFY_H
#define PEL_CPU_CLASSIFY_H

#include "kernel.h"
#include "minmax.h"
#include "transfer_table.h"

struct pel_classification_state {
    struct pel_transfer_table table;
    float *arrays;         /* owned; all the tables that follow, table.count entries each */
    size_t array_entries;  /* of each, as allocated */
    float *color[3], *alpha, *alpha_color[3], *tau, *sum_tau, *sum_color[3];
    uint8_t *marks;        /* owned; a byte a cell, 0 where it may be seen; rows and slices start at multiples of powers of two */
    uint8_t *distance;     /* owned; a map as large for each octant of directions, and 4 bytes more, which gathers may read */
    size_t map_bytes;      /* of one */
    size_t cell_dims[3];
    unsigned octants;      /* bit o: the map of octant o is there */
    int row_shift, slice_shift;
    size_t visible_cells;
    float *bounds;         /* owned; MIP and MinIP: raw bounds of cells, then of blocks */
    size_t bound_count;
};

/* How raw values lie on the data's: value = raw * scale + offset. */
struct pel_raw_scale {
    double scale, offset;
};

/* Does the mode leave anything out that a distance map could tell? */
bool pel_mode_has_map(enum pel_mode mode);

/* Builds the look-up tables and isovalues for the scene, and points the job at them: all that a classification needs but the cells. */
bool pel_classify_tables(struct pel_classification_state *state, const struct pel_scene *scene, struct pel_raw_scale raw,
                         struct pel_job *job, struct pel_error *error);
/* The mode and the isovalues, in rising order, alone: all that a technique needs which draws nothing but isosurfaces. */
void pel_classify_isosurfaces(const struct pel_scene *scene, struct pel_raw_scale raw, struct pel_job *job);
/* The tables, and marks or bounds of cells. */
bool pel_classify(struct pel_classification_state *state, const struct pel_scene *scene, const struct pel_minmax *minmax,
                  struct pel_raw_scale raw, int threads, struct pel_job *job, struct pel_error *error);
/* Makes sure that there is a distance map for each octant into which rays go; `wanted` has a bit for each. */
bool pel_classify_octants(struct pel_classification_state *state, unsigned wanted, int threads, struct pel_error *error);
/* Which cells of a box of the grid (the first ones, and how many along each axis) may be seen, after pel_classify_tables: a byte a cell, 0
 * where it may, x fastest, into `marks`, and how many. Where `marks` is NULL, only whether any may: 0 or 1. */
size_t pel_classify_box(struct pel_classification_state *state, const struct pel_scene *scene, const struct pel_minmax *minmax,
                        struct pel_raw_scale raw, const struct pel_job *job, const int first[3], const int count[3], int threads,
                        uint8_t *marks);
/* Memory that it holds. */
size_t pel_classify_bytes(const struct pel_classification_state *state);
void pel_classify_finish(struct pel_classification_state *state);

#endif
