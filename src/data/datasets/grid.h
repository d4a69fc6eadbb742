/* SPDX-License-Identifier: MIT */
/* What every computed data set does: a cube of f32 samples of a function of the position. */
#ifndef PEL_DATA_GRID_H
#define PEL_DATA_GRID_H

#include <pellucid/dataset.h>
#include <pellucid/volume.h>

#define PEL_DATASET_SIZE_MAX 2048

/* The row that every table begins with. */
#define PEL_DATASET_SIZE_ROW(type, fallback)                                                                                               \
    { "size", "Size", "Samples along each axis", PEL_OPTION_INT, offsetof(type, size), 2, PEL_DATASET_SIZE_MAX, fallback, NULL, "samples" }

/* Computes one sample (as many floats as the volume has components) at a position. Called from several threads. */
typedef void pel_dataset_sample(const void *context, const double position[3], float *out);

/* Gives `volume` size^3 samples of f32 whose positions run from centre - half to centre + half along each axis, and computes them.
 * Positions are exactly symmetric about the centre. */
bool pel_dataset_fill(struct pel_volume *volume, int size, int components, double centre, double half, pel_dataset_sample *sample,
                      const void *context, struct pel_error *error);

/* The data sets, one file each (shapes.c has a family). */
extern const struct pel_dataset pel_dataset_hydrogen, pel_dataset_marschner_lobb, pel_dataset_sphere, pel_dataset_shell, pel_dataset_box,
    pel_dataset_torus, pel_dataset_constant, pel_dataset_gyroid, pel_dataset_shepp_logan, pel_dataset_tornado, pel_dataset_abc;

#endif
