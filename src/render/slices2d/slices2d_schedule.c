/* SPDX-License-Identifier: MIT */
#include "slices2d_schedule.h"

#define SIZES 4
#define COARSEST 8

static int index_of(const struct pel_slices2d_scheduler *s, int slices_per_polygon)
{
    int i = 0;
    while (!s->no_polygons && i < SIZES - 1 && 1 << i < slices_per_polygon)
        i++;
    return i;
}

int pel_slices2d_scheduled(const struct pel_slices2d_quality *q, int voxels)
{
    return voxels > 1 ? ((voxels - 1) * q->supersampling + q->every - 1) / q->every + 1 : 1;
}

void pel_slices2d_measured(struct pel_slices2d_scheduler *s, const struct pel_slices2d_quality *q, int voxels, double ms)
{
    double *known = &s->ms_per_slice[index_of(s, q->slices_per_polygon)], cost = ms / pel_slices2d_scheduled(q, voxels);
    if (cost > 0)
        *known = *known > 0 ? 0.5 * (*known + cost) : cost; /* half of what was, so that one slow frame does not decide */
}

/* The cheapest number of slices a polygon that is known, or -1. */
static int cheapest(const struct pel_slices2d_scheduler *s)
{
    int best = -1;
    for (int i = 0; i < SIZES; i++)
        if (s->ms_per_slice[i] > 0 && (best < 0 || s->ms_per_slice[i] < s->ms_per_slice[best]))
            best = i;
    return best;
}

/* The largest that was not tried: it is most likely to cost least. */
static int untried(const struct pel_slices2d_scheduler *s)
{
    for (int i = s->no_polygons ? 0 : SIZES - 1; i > 0; i--)
        if (!(s->ms_per_slice[i] > 0))
            return i;
    return -1;
}

/* One step coarser; false where there is none. */
static bool coarsen(struct pel_slices2d_quality *q)
{
    if (q->supersampling > 1)
        q->supersampling--;
    else if (q->every < COARSEST)
        q->every++;
    else
        return false;
    return true;
}

struct pel_slices2d_quality pel_slices2d_schedule(const struct pel_slices2d_scheduler *s, bool interacting, double budget_ms,
                                                  int voxels, const struct pel_slices2d_quality *best)
{
    struct pel_slices2d_quality q = *best;
    const int known = cheapest(s), next = untried(s);
    if (known >= 0 && !s->no_polygons)
        q.slices_per_polygon = 1 << known;
    if (!interacting)
        return q;
    while (known >= 0 && pel_slices2d_scheduled(&q, voxels) * s->ms_per_slice[known] > budget_ms && coarsen(&q))
        continue;
    if (next >= 0)
        q.slices_per_polygon = 1 << next;
    return q;
}
