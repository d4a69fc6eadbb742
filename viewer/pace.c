/* SPDX-License-Identifier: MIT */
#include "pace.h"

#include <math.h>
#include <string.h>

enum { LEAST_SIDE = 16 };
/* A larger picture is taken up again only where it fits with some room, or sizes would change with every frame. */
#define ROOM 0.8

static double area(int level)
{
    return pow(2, -0.5 * level);
}

void pace_init(struct pace *pace, double budget_ms)
{
    memset(pace, 0, sizeof *pace);
    pace->budget_ms = budget_ms;
}

/* What a level should cost, by the nearest one that was drawn. 0: nothing is known. */
static double expected(const double ms[PACE_LEVELS], int level)
{
    for (int away = 0; away < PACE_LEVELS; away++)
        for (int side = -1; side <= 1; side += 2) {
            int other = level + side * away;
            if (other >= 0 && other < PACE_LEVELS && ms[other] > 0)
                return ms[other] * area(level) / area(other);
        }
    return 0;
}

/* The largest picture that fits; where none does, the largest of those that are hardly dearer than the cheapest. */
static int best(const struct pace *pace, enum pace_kind kind)
{
    double cheapest = INFINITY;
    const double *ms = pace->ms[kind];
    for (int level = 0; level < PACE_LEVELS; level++) {
        double cost = expected(ms, level), budget = level < pace->level[kind] ? ROOM * pace->budget_ms : pace->budget_ms;
        if (cost <= budget)
            return level;
        cheapest = fmin(cheapest, cost);
    }
    for (int level = 0; level < PACE_LEVELS; level++)
        if (expected(ms, level) <= 1.2 * cheapest)
            return level;
    return PACE_LEVELS - 1;
}

int pace_choose(struct pace *pace, enum pace_kind kind, const int whole[2], int size[2])
{
    double pixels = (double)whole[0] * whole[1];
    if (pace->pixels > 0 && pixels != pace->pixels)
        for (int k = 0; k < PACE_KINDS; k++)
            for (int level = 0; level < PACE_LEVELS; level++)
                pace->ms[k][level] *= pixels / pace->pixels;
    pace->pixels = pixels;
    enum pace_kind known = kind;
    if (expected(pace->ms[kind], 0) == 0)
        known = PACE_KINDS - 1 - kind; /* the other's is better than nothing */
    pace->level[kind] = best(pace, known);
    double side = sqrt(area(pace->level[kind]));
    for (int i = 0; i < 2; i++) {
        size[i] = (int)lround(whole[i] * side);
        if (size[i] < LEAST_SIDE)
            size[i] = whole[i] < LEAST_SIDE ? whole[i] : LEAST_SIDE;
    }
    return pace->level[kind];
}

void pace_measured(struct pace *pace, enum pace_kind kind, int level, double ms)
{
    double before = pace->ms[kind][level];
    if (before > 0) {
        double now = before + (ms - before) * (ms > before ? 0.7 : 0.3), ratio = now / before;
        for (int i = 0; i < PACE_LEVELS; i++)
            pace->ms[kind][i] *= ratio;
    } else {
        pace->ms[kind][level] = ms;
    }
}

double pace_step(int level, double step)
{
    return level == 0 ? step : fmin(2 * step, step + 2);
}
