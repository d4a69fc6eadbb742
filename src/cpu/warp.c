/* SPDX-License-Identifier: MIT */
#include "warp.h"

#include <math.h>
#include <string.h>

typedef float v4 __attribute__((vector_size(16)));

static v4 texel(const float *at)
{
    v4 t;
    memcpy(&t, at, sizeof t);
    return t;
}

/* Is the ray of the pixel nearest to the part's principal axis? Ties go to the axis with the least number. */
static bool belongs(const struct pel_job *job, const struct pel_warp *warp, int x, int y)
{
    int nearest = 0;
    double d[3];
    for (int a = 0; a < 3; a++) {
        d[a] = job->d0[a] + job->dx[a] * x + job->dy[a] * y;
        if (fabs(d[a]) > fabs(d[nearest]))
            nearest = a;
    }
    return nearest == warp->axis && (d[nearest] < 0) == (warp->sign < 0);
}

/* World distance along the pixel's ray to a slice. */
static float distance_of(const struct pel_job *job, const struct pel_shear *s, int x, int y, double m)
{
    const int c = s->axis[2];
    double p = job->p0[c] + job->px[c] * x + job->py[c] * y, d = job->d0[c] + job->dx[c] * x + job->dy[c] * y, length2 = 0;
    for (int a = 0; a < 3; a++) {
        double w = job->w0[a] + job->wx[a] * x + job->wy[a] * y;
        length2 += w * w;
    }
    return (float)(((s->first + m * s->step - p) / d + job->s_base) * sqrt(length2));
}

/* The slice in which opacity passes one half: that of the nearest of the four rays that has one. */
static float depth_of(const struct pel_shear *s, const float *depth, float fu, float fv)
{
    const float weight[4] = { (1 - fu) * (1 - fv), fu * (1 - fv), (1 - fu) * fv, fu * fv };
    float best = -1, m = -1;
    for (int i = 0; i < 4; i++) {
        float at = depth[(i >> 1) * s->stride + (i & 1)];
        if (at >= 0 && weight[i] > best)
            best = weight[i], m = at;
    }
    return m;
}

void pel_warp_row(const struct pel_job *job, const struct pel_shear *s, const struct pel_warp *warp, int y)
{
    float *to = job->rgba + (size_t)y * (size_t)job->width * 4;
    double u0 = warp->u[0] + warp->u[2] * y, v0 = warp->v[0] + warp->v[2] * y, w0 = warp->w[0] + warp->w[2] * y;
    for (int x = 0; x < job->width; x++) {
        if (warp->split && !belongs(job, warp, x, y))
            continue;
        double inverse = 1 / (w0 + warp->w[1] * x);
        double u = (u0 + warp->u[1] * x) * inverse + 1, v = (v0 + warp->v[1] * x) * inverse + 1; /* the border */
        if (!(u >= 0 && v >= 0 && u < s->width + 1 && v < s->height + 1))
            continue;
        int iu = (int)u, iv = (int)v;
        float fu = (float)(u - iu), fv = (float)(v - iv);
        size_t at = (size_t)iv * (size_t)s->stride + (size_t)iu;
        const float *upper = s->rgba + at * 4, *lower = upper + (size_t)s->stride * 4;
        v4 a = texel(upper) + fu * (texel(upper + 4) - texel(upper)), b = texel(lower) + fu * (texel(lower + 4) - texel(lower));
        v4 color = a + fv * (b - a);
        memcpy(to + 4 * x, &color, sizeof color);
        if (job->depth && color[3] >= 0.5f) {
            float m = depth_of(s, s->depth + at, fu, fv);
            job->depth[(size_t)y * (size_t)job->width + (size_t)x] = m >= 0 ? distance_of(job, s, x, y, (double)m) : INFINITY;
        }
    }
}
