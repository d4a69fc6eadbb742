/* SPDX-License-Identifier: MIT */
#include "warp.h"

#include <math.h>

void pel_warp_bound(struct pel_warp *warp, const struct pel_shear *s)
{
    int u0 = s->width + 2, u1 = 0, v0 = s->height + 2, v1 = 0;
    for (int v = 1; v <= s->height; v++) {
        if (s->row_to[v] <= s->row_from[v])
            continue;
        u0 = s->row_from[v] < u0 ? s->row_from[v] : u0;
        u1 = s->row_to[v] > u1 ? s->row_to[v] : u1;
        v0 = v < v0 ? v : v0;
        v1 = v + 1;
    }
    /* A place between an empty ray and the first that holds something already shows it. */
    warp->lo[0] = u0 - 1, warp->hi[0] = u1;
    warp->lo[1] = v0 - 1, warp->hi[1] = v1;
}

bool pel_warp_belongs(const struct pel_job *job, const struct pel_warp *warp, int x, int y)
{
    int nearest = 0;
    double d[3];
    for (int a = 0; a < 3; a++) {
        d[a] = job->d0[a] + job->dx[a] * x + job->dy[a] * y;
        if (fabs(d[a]) > fabs(d[nearest])) /* ties go to the axis with the least number */
            nearest = a;
    }
    return nearest == warp->axis && (d[nearest] < 0) == (warp->sign < 0);
}

/* World distance along the pixel's ray to slice m. */
static float distance_to(const struct pel_job *job, const struct pel_shear *s, int x, int y, double m)
{
    const int c = s->axis[2];
    double p = job->p0[c] + job->px[c] * x + job->py[c] * y, d = job->d0[c] + job->dx[c] * x + job->dy[c] * y, length2 = 0;
    for (int a = 0; a < 3; a++) {
        double w = job->w0[a] + job->wx[a] * x + job->wy[a] * y;
        length2 += w * w;
    }
    return (float)(((s->first + m * s->step - p) / d + job->s_base) * sqrt(length2));
}

/* Depths are not mixed: between two surfaces there is nothing. The nearest of the four rays that has one gives it. */
float pel_warp_depth(const struct pel_job *job, const struct pel_shear *s, int32_t offset, float fu, float fv, int x, int y)
{
    const float weight[4] = { (1 - fu) * (1 - fv), fu * (1 - fv), (1 - fu) * fv, fu * fv };
    float best = -1, m = -1;
    for (int i = 0; i < 4; i++) {
        float at = s->depth[offset + (i >> 1) * s->stride + (i & 1)];
        if (at >= 0 && weight[i] > best)
            best = weight[i], m = at;
    }
    return m >= 0 ? distance_to(job, s, x, y, (double)m) : INFINITY;
}
