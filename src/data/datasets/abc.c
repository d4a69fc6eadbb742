/* SPDX-License-Identifier: MIT */
/* The Arnold-Beltrami-Childress flow: a steady solution of Euler's equations with chaotic streamlines, free of divergence, its own curl.
 * One period, 0 to 2 pi. */
#include "fail.h"
#include "formula.h"
#include "grid.h"

struct abc {
    int size;
    double a, b, c;
};

static void sample(const void *context, const double p[3], float *out)
{
    const struct abc *f = context;
    out[0] = (float)(f->a * pel_sin(p[2]) + f->c * pel_cos(p[1]));
    out[1] = (float)(f->b * pel_sin(p[0]) + f->a * pel_cos(p[2]));
    out[2] = (float)(f->c * pel_sin(p[1]) + f->b * pel_cos(p[0]));
}

static bool make(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct abc *f = params;
    if (!(fabs(f->a) <= 1e6 && fabs(f->b) <= 1e6 && fabs(f->c) <= 1e6))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a, b and c must be from -1e6 to 1e6");
    return pel_dataset_fill(volume, f->size, 3, PEL_PI, PEL_PI, sample, f, error);
}

static const struct pel_option options[] = {
    PEL_DATASET_SIZE_ROW(struct abc, "64"),
    { "a", "A", "Amplitude of the wave along z", PEL_OPTION_DOUBLE, offsetof(struct abc, a), -1e6, 1e6, "1.7320508075688772", NULL, NULL },
    { "b", "B", "Amplitude of the wave along x", PEL_OPTION_DOUBLE, offsetof(struct abc, b), -1e6, 1e6, "1.4142135623730951", NULL, NULL },
    { "c", "C", "Amplitude of the wave along y", PEL_OPTION_DOUBLE, offsetof(struct abc, c), -1e6, 1e6, "1", NULL, NULL },
    { NULL },
};

const struct pel_dataset pel_dataset_abc = {
    "abc", "The ABC flow (A sin z + C cos y, B sin x + A cos z, C sin y + B cos x) over one period (a vector field)",
    "Dombre et al., Chaotic streamlines in the ABC flows, Journal of Fluid Mechanics 167, 1986", options, sizeof(struct abc), make,
};
