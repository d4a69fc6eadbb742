/* SPDX-License-Identifier: MIT */
/* Blinn-Phong shading from a gradient, two-sided (docs/optics.md). With headlights only, the light, the view and the half vector are one,
 * and all that is needed is the angle between gradient and ray: no vector leaves index space. */
#ifndef PEL_CPU_SHADE_H
#define PEL_CPU_SHADE_H

#include "packet.h"

/* What the light makes of a colour c: c * (ambient + lit) + alpha * specular, for each channel. */
struct light {
    vf lit[3], specular[3];
};

/* Headlights share one angle, so their colours are summed beforehand. */
PEL_INLINE struct light shade_headlights(const struct pel_job *job, const struct packet *r, const vf g[3])
{
    const float *m = job->metric;
    vf length2 = m[0] * g[0] * g[0] + m[1] * g[1] * g[1] + m[2] * g[2] * g[2];
    if (!job->orthogonal)
        length2 += m[3] * g[0] * g[1] + m[4] * g[0] * g[2] + m[5] * g[1] * g[2];
    vi steep = (length2 > 1e-30f) & (length2 <= FLT_MAX);
    vf along = vf_abs(g[0] * r->dx + g[1] * r->dy + g[2] * r->dz) * job->steps_a_voxel;
    vf cosine = vf_min(along * vf_rsqrt(vf_select(steep, length2, vf_set(1))), vf_set(1));
    vf shine = job->specular > 0 ? vf_select(steep, vf_power(cosine, job->power), vf_set(0)) : vf_set(0);
    cosine = vf_select(steep, cosine, vf_set(1));
    struct light out;
    for (int c = 0; c < 3; c++) {
        out.lit[c] = job->all_diffuse[c] * cosine;
        out.specular[c] = job->all_specular[c] * shine;
    }
    return out;
}

PEL_INLINE struct light shade_any_lights(const struct pel_job *job, const struct packet *r, const vf g[3])
{
    vf n[3], v[3];
    for (int a = 0; a < 3; a++) {
        n[a] = job->normal[a][0] * g[0] + job->normal[a][1] * g[1] + job->normal[a][2] * g[2];
        v[a] = (job->to_world[a][0] * r->dx + job->to_world[a][1] * r->dy + job->to_world[a][2] * r->dz) * -job->steps_a_voxel;
    }
    vf length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    vi steep = (length2 > 1e-30f) & (length2 <= FLT_MAX);
    vf facing = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    vf scale = vf_rsqrt(vf_select(steep, length2, vf_set(1)));
    scale = vf_select(facing < 0, -scale, scale);
    struct light out;
    for (int c = 0; c < 3; c++)
        out.lit[c] = out.specular[c] = vf_set(0);
    for (int l = 0; l < job->light_count; l++) {
        vf to[3], h[3];
        for (int a = 0; a < 3; a++) {
            to[a] = job->lights[l].headlight ? v[a] : vf_set(job->lights[l].direction[a]);
            h[a] = to[a] + v[a];
        }
        vf cosine = vf_max((n[0] * to[0] + n[1] * to[1] + n[2] * to[2]) * scale, vf_set(0));
        vf h2 = vf_max(h[0] * h[0] + h[1] * h[1] + h[2] * h[2], vf_set(1e-12f));
        vf half = vf_max((n[0] * h[0] + n[1] * h[1] + n[2] * h[2]) * scale * vf_rsqrt(h2), vf_set(0));
        vf shine = job->specular > 0 ? vf_power(vf_min(half, vf_set(1)), job->power) : vf_set(0);
        for (int c = 0; c < 3; c++) {
            out.lit[c] += job->diffuse * job->lights[l].color[c] * cosine;
            out.specular[c] += job->specular * job->lights[l].color[c] * shine;
        }
    }
    for (int c = 0; c < 3; c++) {
        out.lit[c] = vf_select(steep, out.lit[c], vf_set(job->all_diffuse[c]));
        out.specular[c] = vf_select(steep, out.specular[c], vf_set(0));
    }
    return out;
}

/* Lights an opacity-weighted colour. Where there is no gradient (or a void beside): fully lit, no highlight. */
PEL_INLINE void shade(const struct pel_job *job, const struct packet *r, const vf g[3], vf alpha, vf color[3])
{
    struct light light = job->headlight_only ? shade_headlights(job, r, g) : shade_any_lights(job, r, g);
    for (int c = 0; c < 3; c++)
        color[c] = vf_min(color[c] * (job->ambient + light.lit[c]) + alpha * light.specular[c], alpha);
}

#endif
