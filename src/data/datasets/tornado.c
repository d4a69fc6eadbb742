/* SPDX-License-Identifier: MIT */
/* Crawfis' tornado: a velocity field on the unit cube, in each slice a vortex about a centre that winds upwards. With (dx, dy) from the
 * centre, d its length, z the height and t the time:
 *   centre   (0.5 + 0.1 sin(0.04 t + 10 z), 0.5 + 0.1 cos(0.03 t + 3 z))
 *   funnel   R = 0.1 + 0.4 z^2 + 0.1 z sin(8 z), wall W = 0.2 + 0.1 z
 *   damping  D = 1 where |R - d| <= W, else 0.8 - |R - d|   (the jump is the author's)
 *   lift     w = max(0, 0.1 (0.1 - d z)), q = sqrt(d^2 + w^2)
 *   swirl    S = (R + W - q) D / (q + 1e-11) / (1 + z)
 *   velocity (S dy + 0.1 dx, -S dx + 0.1 dy, S w) */
#include "fail.h"
#include "formula.h"
#include "grid.h"

struct tornado {
    int size;
    double time;
};

static void sample(const void *context, const double p[3], float *out)
{
    const struct tornado *t = context;
    double z = p[2];
    double dx = p[0] - (0.5 + 0.1 * pel_sin(0.04 * t->time + 10 * z));
    double dy = p[1] - (0.5 + 0.1 * pel_cos(0.03 * t->time + 3 * z));
    double d = sqrt(dx * dx + dy * dy);
    double funnel = 0.1 + 0.4 * z * z + 0.1 * z * pel_sin(8 * z), wall = 0.2 + 0.1 * z;
    double off = fabs(funnel - d), damping = off <= wall ? 1 : 0.8 - off;
    double lift = 0.1 * (0.1 - d * z);
    lift = lift > 0 ? lift : 0;
    double q = sqrt(d * d + lift * lift);
    double swirl = (funnel + wall - q) * damping / (q + 1e-11) / (1 + z);
    out[0] = (float)(swirl * dy + 0.1 * dx);
    out[1] = (float)(-swirl * dx + 0.1 * dy);
    out[2] = (float)(swirl * lift);
}

static bool make(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct tornado *t = params;
    if (!(fabs(t->time) <= 1e6))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "time: %g is not a number from -1e6 to 1e6", t->time);
    return pel_dataset_fill(volume, t->size, 3, 0.5, 0.5, sample, t, error);
}

static const struct pel_option options[] = {
    PEL_DATASET_SIZE_ROW(struct tornado, "64"),
    { "time", "Time", "Time at which the turning field is taken", PEL_OPTION_DOUBLE, offsetof(struct tornado, time), -1e6, 1e6, "0", NULL,
      NULL },
    { NULL },
};

const struct pel_dataset pel_dataset_tornado = {
    "tornado", "Velocity of Crawfis' tornado on the unit cube (a vector field)",
    "Crawfis, Max: Texture Splats for 3D Scalar and Vector Field Visualization, IEEE Visualization 1993", options, sizeof(struct tornado),
    make,
};
