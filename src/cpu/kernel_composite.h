/* SPDX-License-Identifier: MIT */
/* Emission and absorption: the composite loop, plain, general and pre-integrated. */
#ifndef PEL_CPU_KERNEL_COMPOSITE_H
#define PEL_CPU_KERNEL_COMPOSITE_H

#include "kernel_common.h"

/* Gradient with nearest reconstruction: of the neighbours' opacities, since labels have no slope. */
PEL_INLINE void opacity_gradient(const struct pel_job *job, vi x, vi y, vi z, vf g[3])
{
    vi at[3] = { x, y, z };
    for (int a = 0; a < 3; a++) {
        vf side[2];
        for (int i = 0; i < 2; i++) {
            vi p[3] = { x, y, z };
            p[a] = vi_max(vi_min(at[a] + (i ? 1 : -1), vi_set(job->dims[a] - 1)), vi_set(0));
            vf raw = fetch_nearest(job, p[0], p[1], p[2]);
            side[i] = vf_select(raw == raw, vf_gather(job->opacity, table_entry(job, raw)), vf_set(NAN));
        }
        g[a] = (side[1] - side[0]) * 0.5f;
    }
}

/* Pre-classification: opacity-weighted colours of the eight voxels, interpolated. Gives alpha and colour of one step, and NaN in *raw for
 * voids. */
PEL_INLINE vf pre_classify(const struct pel_job *job, const struct spot *s, vf color[3], vf *raw)
{
    vf corner[8], o[8], part[3][8];
    fetch_corners(job, s, corner);
    vi bad = vi_set(0);
    for (int i = 0; i < 8; i++) {
        vi entry = table_entry(job, corner[i]);
        o[i] = vf_gather(job->opacity, entry);
        part[0][i] = o[i] * vf_gather(job->red, entry);
        part[1][i] = o[i] * vf_gather(job->green, entry);
        part[2][i] = o[i] * vf_gather(job->blue, entry);
        if (job->voids)
            bad |= ~(vf_abs(corner[i]) <= FLT_MAX) | (job->has_void_value ? corner[i] == job->void_raw : vi_set(0));
    }
#define MIX(v)                                                                                                                             \
    bilerp(vf_lerp(v[0], v[1], s->fx), vf_lerp(v[2], v[3], s->fx), vf_lerp(v[4], v[5], s->fx), vf_lerp(v[6], v[7], s->fx), s->fy, s->fz)
    vf opacity = MIX(o);
    vf alpha = alpha_of_length(vf_min(opacity, vf_set(1)), vf_set(job->step_over_unit));
    vf scale = alpha / vf_select(opacity > 0, opacity, vf_set(1));
    for (int c = 0; c < 3; c++)
        color[c] = MIX(part[c]) * scale;
#undef MIX
    *raw = vf_select(bad, vf_set(NAN), vf_set(0));
    return vf_select(opacity > 0, alpha, vf_set(0));
}

/* Emission and absorption. `general` covers nearest reconstruction and pre-classification; without it, trilinear post-classification. */
PEL_INLINE void composite(const struct pel_job *job, struct packet *r, bool shaded, bool general, struct pel_counts *counts)
{
    struct gathered sum = gathered_none();
    vi alive = r->n > 0;
    int end = vi_most(r->n), look = 0, span_end = job->spans ? 0 : end, partial = vi_least(vi_select(alive, r->n, vi_set(INT32_MAX))) - 1;
    bool pre = general && job->classification == PEL_CLASSIFICATION_PRE && !job->nearest;
    for (int k = 0; k < end; k++) {
        if (k >= span_end) {
            k = packet_next_span(job, r, k, &span_end);
            if (k >= end)
                break;
        }
        vi live = alive & (r->n > k);
        vf at = packet_at(r, k);
        struct spot s = packet_spot(job, r, at);
        if (job->looks && k >= look) {
            int clear = packet_look(job, r, &s, r->offset, live, k, &look);
            if (clear >= k) {
                k = clear;
                continue;
            }
        }
        counts->taken += (unsigned)lanes(live);
        vf raw, alpha, color[3] = { 0 };
        vi entry = vi_set(0);
        struct nearest v;
        struct rows rows = { 0 };
        if (pre) {
            alpha = pre_classify(job, &s, color, &raw);
        } else {
            if (general && job->nearest) {
                v = nearest_voxel(job, &s);
                raw = fetch_nearest(job, v.x, v.y, v.z);
            } else {
                raw = fetch_value(job, &s, &rows);
            }
            entry = table_entry(job, raw);
            alpha = vf_gather(job->alpha, entry);
        }
        alpha = vf_select(job->voids ? live & (raw == raw) : live, alpha, vf_set(0));
        if (!vi_any(alpha > 0))
            goto next;
        if (!pre) {
            color[0] = vf_gather(job->alpha_red, entry);
            color[1] = vf_gather(job->alpha_green, entry);
            color[2] = vf_gather(job->alpha_blue, entry);
        }
        vf full = alpha;
        if (k >= partial) {
            alpha = vf_select(r->n == k + 1, alpha_of_length(alpha, r->fraction), alpha);
            vf scale = alpha / vf_select(full > 0, full, vf_set(1));
            for (int c = 0; c < 3; c++)
                color[c] *= scale;
        }
        if (shaded) {
            vf g[3];
            if (pre)
                fetch_rows(job, &s, &rows);
            if (general && job->nearest)
                opacity_gradient(job, v.x, v.y, v.z, g);
            else
                fetch_gradient(job, &s, &rows, g);
            shade(job, r, g, alpha, color);
        }
        for (int c = 0; c < 3; c++)
            color[c] = vf_select(alpha > 0, color[c], vf_set(0));
        put_behind(&sum, color, alpha, at);
        alive &= sum.alpha < job->termination;
    next:
        if (!vi_any(alive & (r->n > k + 1)))
            break;
    }
    packet_store(job, r, sum.color[0], sum.color[1], sum.color[2], sum.alpha, sum.depth);
}

/* The integrals of extinction and of extinction times colour up to a value (docs/optics.md), in table entries: the sum at the nearest
 * entry, and on from there with its extinction, also beyond the table's ends, where the curves are constant. */
struct integral {
    vf value; /* NaN for a void */
    vf entry, tau, sum, color[3], color_sum[3];
};

PEL_INLINE struct integral integral_to(const struct pel_job *job, vf raw)
{
    struct integral t;
    vi i = table_entry(job, raw);
    t.value = raw;
    t.entry = raw * job->table_scale + (job->table_offset - 0.5f);
    t.tau = vf_gather(job->tau, i);
    vf beyond = (t.entry - vi_to_vf(i)) * t.tau;
    t.sum = vf_gather(job->sum_tau, i) + beyond;
    const float *sums[3] = { job->sum_red, job->sum_green, job->sum_blue }, *points[3] = { job->red, job->green, job->blue };
    for (int c = 0; c < 3; c++) {
        t.color[c] = vf_gather(points[c], i);
        t.color_sum[c] = vf_gather(sums[c], i) + beyond * t.color[c];
    }
    return t;
}

/* Alpha and opacity-weighted colour of `length` steps between two values: mean extinction and mean colour; at one value where the two are
 * the same. */
PEL_INLINE vf pre_integrate(const struct integral *front, const struct integral *back, vf length, vf color[3])
{
    vf span = back->entry - front->entry;
    vi same = vf_abs(span) < 0.25f;
    vf mean = (back->sum - front->sum) / vf_select(same, vf_set(1), span);
    vf tau = vf_max(vf_select(same, front->tau, mean), vf_set(0));
    vf alpha = 1 - vf_exp(-tau * length);
    vf scale = alpha / vf_select(tau > 0, tau * span, vf_set(1));
    for (int c = 0; c < 3; c++) {
        vf mixed = (back->color_sum[c] - front->color_sum[c]) * scale;
        color[c] = vf_max(vf_min(vf_select(same, alpha * front->color[c], mixed), alpha), vf_set(0));
    }
    return alpha;
}

PEL_INLINE void preintegrated(const struct pel_job *job, struct packet *r, struct pel_counts *counts)
{
    struct gathered sum = gathered_none();
    vi alive = r->n > 0;
    struct walk walk = walk_from_entry(job, r);
    struct integral front = integral_to(job, vf_set(0));
    for (int k = 0; (k = walk_on(job, r, &walk, alive, k)) < walk.end; k++) {
        vi live = alive & (r->n > k);
        counts->taken += (unsigned)lanes(live);
        if (!walk.have_front) {
            struct spot s = packet_spot(job, r, end_at(r, k));
            front = integral_to(job, fetch_linear(job, &s));
        }
        struct spot e = packet_spot(job, r, end_at(r, k + 1));
        struct integral back = integral_to(job, fetch_linear(job, &e));
        vf color[3], length = vf_select(r->n == k + 1, r->fraction, vf_set(1));
        vf alpha = pre_integrate(&front, &back, length, color);
        alpha = vf_select(live & (front.value == front.value) & (back.value == back.value), alpha, vf_set(0));
        front = back;
        walk.have_front = true;
        if (vi_any(alpha > 0)) {
            vf at = vf_min((float)k + 0.5f * length, end_at(r, k + 1)); /* lanes that have ended stay inside the volume */
            if (job->shade) {
                vf g[3];
                struct spot m = packet_spot(job, r, at);
                struct rows rows;
                fetch_rows(job, &m, &rows);
                fetch_gradient(job, &m, &rows, g);
                shade(job, r, g, alpha, color);
            }
            for (int c = 0; c < 3; c++)
                color[c] = vf_select(alpha > 0, color[c], vf_set(0));
            put_behind(&sum, color, alpha, at);
            alive &= sum.alpha < job->termination;
        }
        if (!vi_any(alive & (r->n > k + 1)))
            break;
    }
    packet_store(job, r, sum.color[0], sum.color[1], sum.color[2], sum.alpha, sum.depth);
}

#endif
