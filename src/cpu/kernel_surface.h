/* SPDX-License-Identifier: MIT */
/* Isosurfaces: crossings found in steps, their roots and light settled many lanes at a time. */
#ifndef PEL_CPU_KERNEL_SURFACE_H
#define PEL_CPU_KERNEL_SURFACE_H

#include "kernel_common.h"

/* Root of value = iso in [a, b] (steps), between f and g on different sides: regula falsi, Illinois variant, on the reconstructed signal.
 * The bracket always holds the root; on a piecewise cubic the steps below bring it to about 1e-5 of a step. `*bad`: the search met a void.
 */
PEL_INLINE vf find_root(const struct pel_job *job, const struct packet *r, vf iso, vf a, vf f, vf b, vf g, vi wanted, vi *bad)
{
    *bad = vi_set(0);
    f -= iso;
    g -= iso;
    vf root = a;
    for (int i = 0; i < 6; i++) {
        vf width = f - g;
        root = a + (b - a) * (f / vf_select(width == 0, vf_set(1), width));
        root = vf_select(wanted, vf_max(vf_min(root, b), a), vf_set(0));
        struct spot s = packet_spot(job, r, root);
        vf h = fetch_linear(job, &s) - iso;
        *bad |= h != h;
        vi front = (h < 0) == (f < 0); /* the root lies behind */
        vf f_half = vf_select(front, h, f * 0.5f), g_half = vf_select(front, g * 0.5f, h);
        a = vf_select(front, root, a);
        b = vf_select(front, b, root);
        f = f_half;
        g = g_half;
    }
    vf width = f - g;
    vf last = a + (b - a) * (f / vf_select(width == 0, vf_set(1), width));
    return vf_select((last >= a) & (last <= b), last, root);
}

/* Crossings that were found and not yet computed, at most one a lane. Finding the root and the light costs more than a step, so it waits
 * until many lanes have something: at the end of the packet, or when a lane meets its next surface. */
struct pending {
    vi lanes;
    vf from, to, front, back;        /* the segment's ends, in steps, and their values */
    vf iso, color[3], alpha;
};

PEL_INLINE void settle(const struct pel_job *job, const struct packet *r, struct pending *p, struct gathered *sum, vf *first)
{
    vi bad;
    vf root = find_root(job, r, p->iso, p->from, p->front, p->to, p->back, p->lanes, &bad), g[3], color[3];
    p->lanes &= ~bad;
    struct spot at = packet_spot(job, r, root);
    struct rows rows;
    fetch_rows(job, &at, &rows);
    fetch_gradient(job, &at, &rows, g);
    vf alpha = vf_select(p->lanes, p->alpha, vf_set(0));
    for (int c = 0; c < 3; c++)
        color[c] = alpha * p->color[c];
    shade(job, r, g, alpha, color);
    for (int c = 0; c < 3; c++)
        color[c] = vf_select(p->lanes, color[c], vf_set(0));
    put_behind(sum, color, alpha, root);
    *first = vf_select(p->lanes & (*first < 0), root, *first);
    p->alpha = alpha;
    p->lanes = vi_set(0);
}

/* Surfaces crossed between two samples, in the order of the ray. */
PEL_INLINE void isosurface(const struct pel_job *job, struct packet *r, struct pel_counts *counts)
{
    struct gathered sum = gathered_none();
    struct pending p;
    p.lanes = vi_set(0);
    p.from = p.to = p.front = p.back = p.iso = p.alpha = p.color[0] = p.color[1] = p.color[2] = vf_set(0);
    vi alive = r->n > 0;
    struct walk walk = walk_from_entry(job, r);
    vf front = vf_set(0), first = vf_set(-1);
    for (int k = 0; (k = walk_on(job, r, &walk, alive, k)) < walk.end; k++) {
        vi live = alive & (r->n > k);
        vf a = end_at(r, k);
        counts->taken += (unsigned)lanes(live);
        if (!walk.have_front) {
            struct spot s = packet_spot(job, r, a);
            front = fetch_linear(job, &s);
        }
        vf b = end_at(r, k + 1);
        struct spot e = packet_spot(job, r, b);
        vf back = fetch_linear(job, &e);
        vi good = job->voids ? live & (front == front) & (back == back) : live, rising = back > front;
        for (int j = 0; j < job->iso_count; j++) {
            int i = job->iso_count - 1 - j;
            vf iso = vf_select(rising, vf_set(job->iso[j]), vf_set(job->iso[i]));
            vi crossed = good & alive & ((front < iso) ^ (back < iso));
            if (!vi_any(crossed))
                continue;
            if (vi_any(crossed & p.lanes)) {
                settle(job, r, &p, &sum, &first);
                alive &= sum.alpha < job->termination;
                crossed &= alive;
            }
            p.lanes |= crossed;
            p.from = vf_select(crossed, a, p.from);
            p.to = vf_select(crossed, b, p.to);
            p.front = vf_select(crossed, front, p.front);
            p.back = vf_select(crossed, back, p.back);
            p.iso = vf_select(crossed, iso, p.iso);
            p.alpha = vf_select(crossed, vf_select(rising, vf_set(job->iso_opacity[j]), vf_set(job->iso_opacity[i])), p.alpha);
            for (int c = 0; c < 3; c++)
                p.color[c] = vf_select(crossed, vf_select(rising, vf_set(job->iso_color[j][c]), vf_set(job->iso_color[i][c])), p.color[c]);
            if (job->voids) /* whether the crossing holds shows only now, and so whether something behind it is seen */
                settle(job, r, &p, &sum, &first);
            alive &= ~(crossed & (p.alpha >= 1)); /* nothing behind it is seen */
        }
        front = back;
        walk.have_front = true;
        if (!vi_any(alive & (r->n > k + 1)))
            break;
    }
    if (vi_any(p.lanes))
        settle(job, r, &p, &sum, &first);
    packet_store(job, r, sum.color[0], sum.color[1], sum.color[2], sum.alpha, first);
}

#endif
