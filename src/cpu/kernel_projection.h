/* SPDX-License-Identifier: MIT */
/* One value a pixel: MIP, MinIP, average, X-ray; and oblique slices. */
#ifndef PEL_CPU_KERNEL_PROJECTION_H
#define PEL_CPU_KERNEL_PROJECTION_H

#include "kernel_common.h"

/* a + b with the part that rounding lost kept in *lost (Kahan): sums of thousands of samples stay exact to the last places. */
PEL_INLINE vf add_exactly(vf a, vf b, vf *lost)
{
    vf y = b - *lost, t = a + y;
    *lost = (t - a) - y;
    return t;
}

PEL_INLINE vf project_value(const struct pel_job *job, const struct spot *s)
{
    if (!job->nearest)
        return fetch_linear(job, s);
    struct nearest v = nearest_voxel(job, s);
    return fetch_nearest(job, v.x, v.y, v.z);
}

/* Colour and opacity of a value, for the modes that show one value a pixel. */
PEL_INLINE void store_value(const struct pel_job *job, const struct packet *r, vf raw, vi seen, vf depth)
{
    vi entry = table_entry(job, raw);
    vf alpha = vf_select(seen, vf_gather(job->opacity, entry), vf_set(0));
    packet_store(job, r, alpha * vf_gather(job->red, entry), alpha * vf_gather(job->green, entry), alpha * vf_gather(job->blue, entry),
                 alpha, vf_select(seen, depth, vf_set(-1)));
}

/* Steps to the end of each lane's cell of 2^shift voxels. */
PEL_INLINE vf cell_exit(const struct packet *r, const struct spot *s, int shift)
{
    vi here = vi_set(0);
    float size = (float)(1 << shift);
    return vf_min(vf_min(axis_exit(s->x >> shift, here, size, r->ox, r->ix), axis_exit(s->y >> shift, here, size, r->oy, r->iy)),
                  axis_exit(s->z >> shift, here, size, r->oz, r->iz));
}

/* First sample behind such an end that some live lane has to look at. */
PEL_INLINE int after_exit(const struct packet *r, vf exit, vi live, int k)
{
    int clear = vi_least(vi_select(live, samples_before(exit, r->offset), vi_set(INT32_MAX - 1)));
    return (clear > k ? clear : k) + 1;
}

PEL_INLINE vf bound_of(const float *bounds, const int32_t dims[3], const struct spot *s, int shift, float sign)
{
    return sign * vf_gather(bounds, ((s->z >> shift) * dims[1] + (s->y >> shift)) * dims[0] + (s->x >> shift));
}

/* MIP and MinIP: the greatest (sign 1) or least (sign -1) sample. A sample is held to its cell's bound, so that blocks and cells whose
 * bound cannot beat what was found are passed over without a trace of rounding. Every sample is at least the volume's own least value
 * (unless there are voids), so cells that hold nothing else are not visited. */
PEL_INLINE void extreme(const struct pel_job *job, struct packet *r, float sign, struct pel_counts *counts)
{
    float worst = sign > 0 ? job->least_raw : -job->most_raw, ideal = sign > 0 ? job->most_raw : -job->least_raw;
    vf best = vf_set(job->voids ? -INFINITY : worst), depth = job->voids ? vf_set(-1) : packet_at(r, 0);
    vi alive = r->n > 0;
    int end = vi_most(r->n), look = 0, look_block = 0, span_end = job->spans ? 0 : end;
    for (int k = 0; k < end;) {
        if (k >= span_end) {
            k = packet_next_span(job, r, k, &span_end);
            if (k >= end)
                break;
        }
        vi live = alive & (r->n > k);
        if (!vi_any(live))
            break;
        vf at = packet_at(r, k);
        struct spot s = packet_spot(job, r, at);
        if (job->looks && k >= look) {
            int clear = packet_look(job, r, &s, r->offset, live, k, &look);
            if (clear >= k) {
                k = clear + 1;
                continue;
            }
        }
        if (job->looks && k >= look_block) {
            if (!vi_any(live & (bound_of(job->block_bound, job->block_dims, &s, PEL_BLOCK_SHIFT, sign) > best))) {
                k = after_exit(r, cell_exit(r, &s, PEL_BLOCK_SHIFT), live, k);
                continue;
            }
            look_block = look;
        }
        vf bound = bound_of(job->cell_bound, job->cell_dims, &s, PEL_CELL_SHIFT, sign);
        if (job->skip && !vi_any(live & (bound > best))) {
            k = after_exit(r, cell_exit(r, &s, PEL_CELL_SHIFT), live, k);
            continue;
        }
        counts->taken += (unsigned)lanes(live);
        vf value = sign * project_value(job, &s);
        value = vf_select(value > bound, bound, value);
        vi better = live & (value > best);
        best = vf_select(better, value, best);
        depth = vf_select(better, at, depth);
        alive &= best < ideal;
        k++;
    }
    store_value(job, r, sign * best, (r->n > 0) & (best > -INFINITY), depth);
}

/* Average and X-ray: sums over the whole stretch (equation 1.3 for the X-ray's tau). */
PEL_INLINE void sum_up(const struct pel_job *job, struct packet *r, bool xray, struct pel_counts *counts)
{
    vf total = vf_set(0), weight = vf_set(0), lost = vf_set(0), lost_weight = vf_set(0);
    int end = vi_most(r->n), look = 0, span_end = job->spans ? 0 : end;
    for (int k = 0; k < end; k++) {
        if (k >= span_end) {
            k = packet_next_span(job, r, k, &span_end);
            if (k >= end)
                break;
        }
        vi live = r->n > k;
        struct spot s = packet_spot(job, r, packet_at(r, k));
        if (xray && job->looks && k >= look) {
            int clear = packet_look(job, r, &s, r->offset, live, k, &look);
            if (clear >= k) {
                k = clear;
                continue;
            }
        }
        counts->taken += (unsigned)lanes(live);
        vf raw = project_value(job, &s), length = vf_select(r->n == k + 1, r->fraction, vf_set(1));
        vi good = live & (raw == raw);
        vf value = xray ? vf_gather(job->tau, table_entry(job, raw)) : raw;
        if (xray)
            good &= value > 0; /* nothing is added where nothing absorbs, so that leaving it out changes no bit */
        vf still_lost = lost, still_lost_weight = lost_weight;
        total = vf_select(good, add_exactly(total, value * length, &still_lost), total);
        lost = vf_select(good, still_lost, lost);
        if (!xray)
            weight = vf_select(good, add_exactly(weight, length, &still_lost_weight), weight);
        lost_weight = vf_select(good, still_lost_weight, lost_weight);
    }
    if (xray) {
        vf alpha = 1 - vf_exp(-total), bright = job->invert ? alpha : vf_set(0);
        packet_store(job, r, bright, bright, bright, alpha, vf_set(-1));
    } else {
        store_value(job, r, total / vf_select(weight > 0, weight, vf_set(1)), weight > 0, vf_set(-1));
    }
}

PEL_INLINE void projection(const struct pel_job *job, struct packet *r, struct pel_counts *counts)
{
    if (job->mode == PEL_MODE_MIP || job->mode == PEL_MODE_MINIP)
        extreme(job, r, job->mode == PEL_MODE_MIP ? 1 : -1, counts);
    else
        sum_up(job, r, job->mode == PEL_MODE_XRAY, counts);
}

/* Where the rays meet a plane; +infinity where they do not inside their stretches. */
PEL_INLINE vf slice_place(const struct pel_job *job, const struct packet *r, const double q[4])
{
    float value[W], slope[W];
    for (int i = 0; i < W; i++) {
        value[i] = (float)(q[0] * r->ox[i] + q[1] * r->oy[i] + q[2] * r->oz[i] + q[3]);
        slope[i] = (float)(q[0] * r->dx[i] + q[1] * r->dy[i] + q[2] * r->dz[i]);
    }
    vf from, along;
    memcpy(&from, value, sizeof from);
    memcpy(&along, slope, sizeof along);
    vi across = vf_abs(along) > (float)(1e-9 * job->step); /* world lengths a step */
    vf at = -from / vf_select(across, along, vf_set(1)), end = vi_to_vf(r->n - 1) + r->fraction;
    vi meets = (r->n > 0) & across & (at >= -1e-4f) & (at <= end + 1e-4f);
    return vf_select(meets, vf_max(vf_min(at, end), vf_set(0)), vf_set(INFINITY));
}

/* Takes each lane's least place out of the list. */
PEL_INLINE vf take_nearest(vf *at, int count)
{
    vf nearest = vf_set(INFINITY);
    vi which = vi_set(-1);
    for (int i = 0; i < count; i++) {
        vi less = at[i] < nearest;
        nearest = vf_select(less, at[i], nearest);
        which = vi_select(less, vi_set(i), which);
    }
    for (int i = 0; i < count; i++)
        at[i] = vf_select(which == vi_set(i), vf_set(INFINITY), at[i]);
    return nearest;
}

/* Each plane gives its value's opacity and colour, composited from the nearest on. */
PEL_INLINE void slice(const struct pel_job *job, const struct packet *r, struct pel_counts *counts)
{
    vf at[PEL_MAX_SLICES], red = vf_set(0), green = vf_set(0), blue = vf_set(0), alpha = vf_set(0), depth = vf_set(-1);
    const int count = job->slice_count;
    for (int i = 0; i < count; i++)
        at[i] = slice_place(job, r, job->slice_planes[i]);
    for (int i = 0; i < count; i++) {
        vf nearest = take_nearest(at, count);
        vi meets = nearest < INFINITY;
        if (!lanes(meets))
            break;
        vf place = vf_select(meets, nearest, vf_set(0));
        struct spot s = packet_spot(job, r, place);
        vf raw = project_value(job, &s);
        vi entry = table_entry(job, raw);
        vf opacity = vf_select(meets & (raw == raw), vf_gather(job->opacity, entry), vf_set(0)), share = (1 - alpha) * opacity;
        counts->taken += (unsigned)lanes(meets);
        depth = vf_select((depth < 0) & (opacity > 0), place, depth);
        red += share * vf_gather(job->red, entry);
        green += share * vf_gather(job->green, entry);
        blue += share * vf_gather(job->blue, entry);
        alpha += share;
    }
    packet_store(job, r, red, green, blue, alpha, depth);
}

#endif
