/* SPDX-License-Identifier: MIT */
/* Isosurfaces by steps: crossings found between two samples, their roots and light settled many lanes at a time. */
#ifndef PEL_CPU_KERNEL_SURFACE_H
#define PEL_CPU_KERNEL_SURFACE_H

#include "kernel_common.h"

/* Regula falsi, Illinois variant: the root between a and b, where the signal less the isovalue is f and g, on different sides. The bracket
 * always holds it. */
struct bracket {
    vf a, b, f, g;
};

PEL_INLINE vf bracket_guess(const struct bracket *k)
{
    vf width = k->f - k->g;
    return vf_max(vf_min(k->a + (k->b - k->a) * (k->f / vf_select(width == 0, vf_set(1), width)), k->b), k->a);
}

/* With the value h at the guess. */
PEL_INLINE void bracket_narrow(struct bracket *k, vf guess, vf h)
{
    vi front = (h < 0) == (k->f < 0); /* the root lies behind */
    k->a = vf_select(front, guess, k->a);
    k->b = vf_select(front, k->b, guess);
    vf f = vf_select(front, h, k->f * 0.5f);
    k->g = vf_select(front, k->g * 0.5f, h);
    k->f = f;
}

/* The signal along the way through a cell: c0 + c1 u + c2 u^2 + c3 u^3, u from 0 to 1, held to the cell's voxels. */
struct cubic {
    vf c[4], least, most;
};

PEL_INLINE vf cubic_at(const struct cubic *q, vf u)
{
    return vf_min(vf_max(q->c[0] + u * (q->c[1] + u * (q->c[2] + u * q->c[3])), q->least), q->most);
}

/* Crossings that were found and not yet settled, at most one a lane. The root and the light cost more than a step, so they wait until many
 * lanes have something: at the end of the packet, or when a lane meets its next surface. */
struct pending {
    vi lanes;
    struct bracket bracket; /* of the root: steps, or places on the cubic's way */
    vf iso, color[3], alpha;
    bool by_cubic;
    vf from, length; /* of that way, in steps */
    struct cubic cubic;
};

PEL_INLINE struct pending pending_none(bool by_cubic)
{
    struct pending p = { .by_cubic = by_cubic };
    p.lanes = vi_set(0);
    p.iso = p.alpha = p.color[0] = p.color[1] = p.color[2] = p.from = p.length = p.cubic.least = p.cubic.most = vf_set(0);
    p.bracket.a = p.bracket.b = p.bracket.f = p.bracket.g = vf_set(0);
    for (int i = 0; i < 4; i++)
        p.cubic.c[i] = vf_set(0);
    return p;
}

PEL_INLINE void pending_bracket(struct pending *p, vi who, const struct bracket *bracket, vf iso)
{
    p->bracket.a = vf_select(who, bracket->a, p->bracket.a);
    p->bracket.b = vf_select(who, bracket->b, p->bracket.b);
    p->bracket.f = vf_select(who, bracket->f - iso, p->bracket.f);
    p->bracket.g = vf_select(who, bracket->g - iso, p->bracket.g);
    p->iso = vf_select(who, iso, p->iso);
}

/* The lanes' surfaces are number i of rising values where the signal rises, else number j. */
PEL_INLINE void pending_take(const struct pel_job *job, struct pending *p, vi who, vi rising, int i, int j)
{
    p->lanes |= who;
    p->alpha = vf_select(who, vf_select(rising, vf_set(job->iso_opacity[i]), vf_set(job->iso_opacity[j])), p->alpha);
    for (int c = 0; c < 3; c++)
        p->color[c] = vf_select(who, vf_select(rising, vf_set(job->iso_color[i][c]), vf_set(job->iso_color[j][c])), p->color[c]);
}

/* The roots, in steps along the rays. A piecewise cubic's are found to about 1e-5 of the bracket. Lanes whose search meets a void are none.
 */
PEL_INLINE vf find_roots(const struct pel_job *job, const struct packet *r, struct pending *p)
{
    struct bracket *k = &p->bracket;
    if (p->by_cubic) {
        for (int i = 0; i < 6; i++) {
            vf root = bracket_guess(k);
            bracket_narrow(k, root, cubic_at(&p->cubic, root) - p->iso);
        }
        return p->from + p->length * bracket_guess(k);
    }
    vi bad = vi_set(0);
    for (int i = 0; i < 6; i++) {
        vf root = vf_select(p->lanes, bracket_guess(k), vf_set(0));
        struct spot s = packet_spot(job, r, root);
        vf h = fetch_linear(job, &s) - p->iso;
        bad |= h != h;
        bracket_narrow(k, root, h);
    }
    p->lanes &= ~bad;
    return bracket_guess(k);
}

PEL_INLINE void settle(const struct pel_job *job, const struct packet *r, struct pending *p, struct gathered *sum, vf *first)
{
    vf root = vf_select(p->lanes, find_roots(job, r, p), vf_set(0)), g[3], color[3];
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
PEL_INLINE void isosurface_steps(const struct pel_job *job, struct packet *r, struct pel_counts *counts)
{
    struct gathered sum = gathered_none();
    struct pending p = pending_none(false);
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
            const struct bracket bracket = { a, b, front, back };
            pending_bracket(&p, crossed, &bracket, iso);
            pending_take(job, &p, crossed, rising, j, i);
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
