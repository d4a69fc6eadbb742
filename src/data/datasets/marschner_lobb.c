/* SPDX-License-Identifier: MIT */
/* The Marschner-Lobb signal: rings whose frequency lies just below what its 41^3 samples can carry, the field's measure of how well a
 * renderer reconstructs and shades. */
#include "fail.h"
#include "formula.h"
#include "grid.h"

struct marschner_lobb {
    int size;
    double frequency, alpha;
};

static void sample(const void *context, const double p[3], float *out)
{
    const struct marschner_lobb *s = context;
    double r = sqrt(p[0] * p[0] + p[1] * p[1]);
    double rings = pel_cos(2 * PEL_PI * s->frequency * pel_cos(PEL_PI * r / 2));
    *out = (float)((1 - pel_sin(PEL_PI * p[2] / 2) + s->alpha * (1 + rings)) / (2 * (1 + s->alpha)));
}

static bool make(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct marschner_lobb *s = params;
    if (!(s->frequency >= 0 && s->frequency <= 1000) || !(s->alpha >= 0 && s->alpha <= 1000))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "frequency and alpha must be from 0 to 1000");
    return pel_dataset_fill(volume, s->size, 1, 0, 1, sample, s, error);
}

static const struct pel_option options[] = {
    PEL_DATASET_SIZE_ROW(struct marschner_lobb, "41"),
    { "frequency", "Frequency fM", "Frequency of the rings", PEL_OPTION_DOUBLE, offsetof(struct marschner_lobb, frequency), 0, 1000, "6",
      NULL, NULL },
    { "alpha", "Alpha", "Height of the rings against the slope along z", PEL_OPTION_DOUBLE, offsetof(struct marschner_lobb, alpha), 0, 1000,
      "0.25", NULL, NULL },
    { NULL },
};

const struct pel_dataset pel_dataset_marschner_lobb = {
    "marschner-lobb", "The Marschner-Lobb test signal, values 0 to 1 over [-1,1]^3; the usual isovalue is 0.5",
    "Marschner, Lobb: An Evaluation of Reconstruction Filters for Volume Rendering, IEEE Visualization 1994", options,
    sizeof(struct marschner_lobb), make,
};
