/* SPDX-License-Identifier: MIT */
#include "pace.h"

#include <math.h>
#include <string.h>

enum { LEVELS = 10, LEAST_SIDE = 16 };
/* A larger picture is taken up again only where it fits with some room, or sizes would change with every frame. */
#define ROOM 0.8
/* What older pictures count for when a new one comes. */
#define MEMORY 0.8
/* Where nothing fits: a smaller picture must save so much, or the larger is drawn. */
#define WORTH 1.25

void pace_init(struct pace *pace, double budget_ms)
{
    memset(pace, 0, sizeof *pace);
    pace->budget_ms = budget_ms;
}

/* Constant and slope. Pictures of one size tell only their sum: then half of it is taken for each. */
static void fit(const struct pace_sums *s, double *constant, double *slope)
{
    double x = s->x / s->n, y = s->y / s->n, spread = s->xx / s->n - x * x;
    if (spread > 0.01 * x * x) {
        *slope = fmin(fmax((s->xy / s->n - x * y) / spread, 0), y / x);
        *constant = y - *slope * x;
    } else {
        *slope = 0.5 * y / x;
        *constant = 0.5 * y;
    }
}

static double area(int level)
{
    return pow(2, -0.5 * level);
}

static int best(const struct pace *pace, const struct pace_sums *sums, int before, double megapixels)
{
    double constant, slope;
    fit(sums, &constant, &slope);
    double least = constant + slope * megapixels * area(LEVELS - 1);
    for (int level = 0; level < LEVELS; level++) {
        double ms = constant + slope * megapixels * area(level);
        if (ms <= fmax(pace->budget_ms * (level < before ? ROOM : 1), WORTH * least))
            return level;
    }
    return LEVELS - 1;
}

void pace_choose(struct pace *pace, enum pace_kind kind, const int whole[2], int size[2])
{
    const struct pace_sums *sums = &pace->sums[kind];
    if (sums->n == 0)
        sums = &pace->sums[PACE_KINDS - 1 - kind]; /* the other's is better than nothing */
    pace->level[kind] = sums->n > 0 ? best(pace, sums, pace->level[kind], 1e-6 * whole[0] * whole[1]) : 0;
    double side = sqrt(area(pace->level[kind]));
    for (int i = 0; i < 2; i++) {
        size[i] = (int)lround(whole[i] * side);
        if (size[i] < LEAST_SIDE)
            size[i] = whole[i] < LEAST_SIDE ? whole[i] : LEAST_SIDE;
    }
}

void pace_measured(struct pace *pace, enum pace_kind kind, const int size[2], double ms)
{
    struct pace_sums *s = &pace->sums[kind];
    double x = 1e-6 * size[0] * size[1];
    s->n = MEMORY * s->n + 1;
    s->x = MEMORY * s->x + x;
    s->y = MEMORY * s->y + ms;
    s->xx = MEMORY * s->xx + x * x;
    s->xy = MEMORY * s->xy + x * ms;
}
