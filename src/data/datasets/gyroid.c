/* SPDX-License-Identifier: MIT */
/* The gyroid: a surface of constant genus per period that parts space into two equal labyrinths; here as the level set 0 of its usual
 * trigonometric approximation. Smooth, periodic, and full of silhouettes. */
#include "fail.h"
#include "formula.h"
#include "grid.h"

struct gyroid {
    int size;
    double periods;
};

static void sample(const void *context, const double p[3], float *out)
{
    (void)context;
    *out = (float)(pel_sin(p[0]) * pel_cos(p[1]) + pel_sin(p[1]) * pel_cos(p[2]) + pel_sin(p[2]) * pel_cos(p[0]));
}

static bool make(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct gyroid *g = params;
    if (!(g->periods > 0 && g->periods <= 1000))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "periods: %g is not a number from 0.01 to 1000", g->periods);
    return pel_dataset_fill(volume, g->size, 1, 0, PEL_PI * g->periods, sample, NULL, error);
}

static const struct pel_option options[] = {
    PEL_DATASET_SIZE_ROW(struct gyroid, "64"),
    { "periods", "Periods", "Periods along each edge of the cube; a period is 2 pi long", PEL_OPTION_DOUBLE,
      offsetof(struct gyroid, periods), 0.01, 1000, "2", NULL, NULL },
    { NULL },
};

const struct pel_dataset pel_dataset_gyroid = {
    "gyroid", "sin x cos y + sin y cos z + sin z cos x; the gyroid is its isosurface at 0",
    "Schoen, Infinite periodic minimal surfaces without self-intersections, NASA TN D-5541, 1970", options, sizeof(struct gyroid), make,
};
