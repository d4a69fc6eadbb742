/* SPDX-License-Identifier: MIT */
/* The ray-casting kernels. Compiled once for each instruction set (PEL_ISA) and kind of voxel (PEL_KIND); each compilation exports one table.
 *
 * Every loop has the same shape: at sample k, look whether the packet may jump (the cells around hold nothing that can be seen); else sample all lanes, classify, stop early where
 * nothing is visible, colour and composite. Samples in empty cells that are taken because a neighbour lane needs its own add exactly nothing, so the skipping never changes
 * a byte. */
#define PEL_KIND_U8 0
#define PEL_KIND_U16 1
#define PEL_KIND_F32 2
#define PEL_KIND_WIDE 3

#include "kernel.h"
#include "packet.h"
#include "shade.h"

/* Colour that a packet has gathered so far. */
struct gathered {
    vf color[3], alpha, depth;
};

PEL_INLINE struct gathered gathered_none(void)
{
    struct gathered g;
    g.color[0] = g.color[1] = g.color[2] = g.alpha = vf_set(0);
    g.depth = vf_set(-1);
    return g;
}

/* Puts (premultiplied) colour behind what is there: equation 1.8, front to back. */
PEL_INLINE void put_behind(struct gathered *to, const vf color[3], vf alpha, vf at)
{
    vf open = 1 - to->alpha;
    for (int c = 0; c < 3; c++)
        to->color[c] += open * color[c];
    to->alpha += open * alpha;
    to->depth = vf_select((to->depth < 0) & (to->alpha >= 0.5f), at, to->depth);
}

PEL_INLINE vi table_entry(const struct pel_job *job, vf raw)
{
    vf at = vf_max(raw * job->table_scale + job->table_offset, vf_set(0)); /* NaN gives 0 */
    return vf_to_vi(vf_min(at, vf_set((float)job->table_last)));
}

/* Opacity of `length` steps from that of one. */
PEL_INLINE vf alpha_of_length(vf alpha, vf length)
{
    vf shorter = 1 - vf_exp(length * vf_log(vf_max(1 - alpha, vf_set(1e-30f))));
    return vf_select(alpha >= 1, alpha, shorter);
}

PEL_INLINE int lanes(vi mask)
{
    return __builtin_popcount(vi_bits(mask));
}

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

struct nearest {
    vi x, y, z;
};

PEL_INLINE struct nearest nearest_voxel(const struct pel_job *job, const struct spot *s)
{
    struct nearest v = { s->x + vf_to_vi(s->fx + 0.5f), s->y + vf_to_vi(s->fy + 0.5f), s->z + vf_to_vi(s->fz + 0.5f) };
    v.x = vi_min(v.x, vi_set(job->dims[0] - 1));
    v.y = vi_min(v.y, vi_set(job->dims[1] - 1));
    v.z = vi_min(v.z, vi_set(job->dims[2] - 1));
    return v;
}

/* Pre-classification: opacity-weighted colours of the eight voxels, interpolated. Gives alpha and colour of one step, and NaN in *raw for voids. */
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
            bad |= ~(vf_abs(corner[i]) <= 3.4e38f) | (job->has_void_value ? corner[i] == job->void_raw : vi_set(0));
    }
#define MIX(v) bilerp(vf_lerp(v[0], v[1], s->fx), vf_lerp(v[2], v[3], s->fx), vf_lerp(v[4], v[5], s->fx), vf_lerp(v[6], v[7], s->fx), s->fy, s->fz)
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
        if (job->skip && k >= look) {
            int clear = packet_look(job, r, &s, r->offset, live, k, &look);
            if (clear >= k) {
                k = clear;
                continue;
            }
        }
        counts->taken += (unsigned)lanes(live);
        vf raw, alpha, color[3];
        vi entry = vi_set(0);
        struct nearest v;
        if (pre) {
            alpha = pre_classify(job, &s, color, &raw);
        } else {
            if (general && job->nearest) {
                v = nearest_voxel(job, &s);
                raw = fetch_nearest(job, v.x, v.y, v.z);
            } else {
                raw = fetch_linear(job, &s);
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
            if (general && job->nearest)
                opacity_gradient(job, v.x, v.y, v.z, g);
            else
                fetch_gradient(job, &s, g);
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

/* Values at the segments' ends, for pre-integration and isosurfaces: sample k lies at the front of segment k, sample n at the end of the last. */
PEL_INLINE vf end_at(const struct packet *r, int k)
{
    return vf_min(vf_set((float)k), vi_to_vf(r->n - 1) + r->fraction);
}

/* The integrals of extinction and of extinction times colour up to a value (docs/optics.md), in table entries: the sum at the nearest entry, and on from there with its
 * extinction, also beyond the table's ends, where the curves are constant. */
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

/* Alpha and opacity-weighted colour of `length` steps between two values: mean extinction and mean colour; at one value where the two are the same. */
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
    int end = vi_most(r->n), look = 0, span_end = job->spans ? 0 : end;
    struct integral front = integral_to(job, vf_set(0));
    bool have_front = false;
    for (int k = 0; k < end; k++) {
        if (k >= span_end) {
            int next = packet_next_span(job, r, k, &span_end);
            if (next >= end)
                break;
            have_front &= next == k;
            k = next;
        }
        vi live = alive & (r->n > k);
        struct spot s = packet_spot(job, r, end_at(r, k));
        if (job->skip && k >= look) {
            int clear = packet_look(job, r, &s, vf_set(0), live, k, &look);
            if (clear > k) {
                k = clear - 1;
                have_front = false;
                continue;
            }
        }
        counts->taken += (unsigned)lanes(live);
        if (!have_front)
            front = integral_to(job, fetch_linear(job, &s));
        struct spot e = packet_spot(job, r, end_at(r, k + 1));
        struct integral back = integral_to(job, fetch_linear(job, &e));
        vf color[3], length = vf_select(r->n == k + 1, r->fraction, vf_set(1));
        vf alpha = pre_integrate(&front, &back, length, color);
        alpha = vf_select(live & (front.value == front.value) & (back.value == back.value), alpha, vf_set(0));
        front = back;
        have_front = true;
        if (vi_any(alpha > 0)) {
            vf at = vf_min((float)k + 0.5f * length, end_at(r, k + 1)); /* lanes that have ended stay inside the volume */
            if (job->shade) {
                vf g[3];
                struct spot m = packet_spot(job, r, at);
                fetch_gradient(job, &m, g);
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
    packet_store(job, r, alpha * vf_gather(job->red, entry), alpha * vf_gather(job->green, entry), alpha * vf_gather(job->blue, entry), alpha,
                 vf_select(seen, depth, vf_set(-1)));
}

/* Steps to the end of each lane's cell of 2^shift voxels. */
PEL_INLINE vf cell_exit(const struct packet *r, const struct spot *s, int shift)
{
    vi here = vi_set(0);
    float size = (float)(1 << shift);
    return vf_min(vf_min(axis_exit(s->x >> shift, here, size, r->ox, r->dx, r->ix), axis_exit(s->y >> shift, here, size, r->oy, r->dy, r->iy)),
                  axis_exit(s->z >> shift, here, size, r->oz, r->dz, r->iz));
}

/* First sample behind such an end that some live lane has to look at. */
PEL_INLINE int after_exit(const struct packet *r, vf exit, vi live, int k)
{
    vi to = vf_to_vi(vf_max(vf_min(exit - r->offset - 1e-3f, vf_set(1e9f)), vf_set(0)));
    int clear = vi_least(vi_select(live, to, vi_set(INT32_MAX - 1)));
    return (clear > k ? clear : k) + 1;
}

PEL_INLINE vf bound_of(const float *bounds, const int32_t dims[3], const struct spot *s, int shift, float sign)
{
    return sign * vf_gather(bounds, ((s->z >> shift) * dims[1] + (s->y >> shift)) * dims[0] + (s->x >> shift));
}

/* MIP and MinIP: the greatest (sign 1) or least (sign -1) sample. A sample is held to its cell's bound, so that blocks and cells whose bound cannot beat what was found are
 * passed over without a trace of rounding. Every sample is at least the volume's own least value (unless there are voids), so cells that hold nothing else are not visited. */
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
        if (job->skip && k >= look) {
            int clear = packet_look(job, r, &s, r->offset, live, k, &look);
            if (clear >= k) {
                k = clear + 1;
                continue;
            }
        }
        if (job->skip && k >= look_block) {
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
        if (xray && job->skip && k >= look) {
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
        total = vf_select(good, add_exactly(total, value * length, &lost), total);
        lost = vf_select(good, lost, vf_set(0));
        if (!xray)
            weight = vf_select(good, add_exactly(weight, length, &lost_weight), weight);
        lost_weight = vf_select(good, lost_weight, vf_set(0));
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

/* Root of value = iso in [a, b] (steps), between f and g on different sides: regula falsi, Illinois variant, on the reconstructed signal. The bracket always holds the
 * root; on a piecewise cubic the steps below bring it to about 1e-5 of a step. */
PEL_INLINE vf find_root(const struct pel_job *job, const struct packet *r, vf iso, vf a, vf f, vf b, vf g, vi wanted)
{
    f -= iso;
    g -= iso;
    vf root = a;
    for (int i = 0; i < 6; i++) {
        vf width = f - g;
        root = a + (b - a) * (f / vf_select(width == 0, vf_set(1), width));
        root = vf_select(wanted, vf_max(vf_min(root, b), a), vf_set(0));
        struct spot s = packet_spot(job, r, root);
        vf h = fetch_linear(job, &s) - iso;
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

/* Crossings that were found and not yet computed, at most one a lane. Finding the root and the light costs more than a step, so it waits until many lanes have
 * something: at the end of the packet, or when a lane meets its next surface. */
struct pending {
    vi lanes;
    vf from, to, front, back;        /* the segment's ends, in steps, and their values */
    vf iso, color[3], alpha;
};

PEL_INLINE void settle(const struct pel_job *job, const struct packet *r, struct pending *p, struct gathered *sum, vf *first)
{
    vf root = find_root(job, r, p->iso, p->from, p->front, p->to, p->back, p->lanes), g[3], color[3];
    struct spot at = packet_spot(job, r, root);
    fetch_gradient(job, &at, g);
    vf alpha = vf_select(p->lanes, p->alpha, vf_set(0));
    for (int c = 0; c < 3; c++)
        color[c] = alpha * p->color[c];
    shade(job, r, g, alpha, color);
    for (int c = 0; c < 3; c++)
        color[c] = vf_select(p->lanes, color[c], vf_set(0));
    put_behind(sum, color, alpha, root);
    *first = vf_select(p->lanes & (*first < 0), root, *first);
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
    int end = vi_most(r->n), look = 0, span_end = job->spans ? 0 : end;
    vf front = vf_set(0), first = vf_set(-1);
    bool have_front = false;
    for (int k = 0; k < end; k++) {
        if (k >= span_end) {
            int next = packet_next_span(job, r, k, &span_end);
            if (next >= end)
                break;
            have_front &= next == k;
            k = next;
        }
        vi live = alive & (r->n > k);
        vf a = end_at(r, k);
        struct spot s;
        if (job->skip && k >= look) {
            s = packet_spot(job, r, a);
            int clear = packet_look(job, r, &s, vf_set(0), live, k, &look);
            if (clear > k) {
                k = clear - 1;
                have_front = false;
                continue;
            }
        }
        counts->taken += (unsigned)lanes(live);
        if (!have_front) {
            s = packet_spot(job, r, a);
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
            alive &= ~(crossed & (p.alpha >= 1)); /* nothing behind it is seen */
        }
        front = back;
        have_front = true;
        if (!vi_any(alive & (r->n > k + 1)))
            break;
    }
    if (vi_any(p.lanes))
        settle(job, r, &p, &sum, &first);
    packet_store(job, r, sum.color[0], sum.color[1], sum.color[2], sum.alpha, first);
}

PEL_INLINE void slice(const struct pel_job *job, const struct packet *r, struct pel_counts *counts)
{
    const double *q = job->slice_plane;
    float value[W], slope[W];
    for (int i = 0; i < W; i++) {
        value[i] = (float)(q[0] * r->ox[i] + q[1] * r->oy[i] + q[2] * r->oz[i] + q[3]);
        slope[i] = (float)(q[0] * r->dx[i] + q[1] * r->dy[i] + q[2] * r->dz[i]);
    }
    vf from, along;
    memcpy(&from, value, sizeof from);
    memcpy(&along, slope, sizeof along);
    vi across = vf_abs(along) > 1e-12f;
    vf at = -from / vf_select(across, along, vf_set(1));
    vi meets = (r->n > 0) & across & (at >= -1e-4f) & (at <= vi_to_vf(r->n - 1) + r->fraction + 1e-4f);
    vf place = vf_select(meets, vf_max(vf_min(at, vi_to_vf(r->n - 1) + r->fraction), vf_set(0)), vf_set(0));
    struct spot s = packet_spot(job, r, place);
    vf raw = project_value(job, &s);
    counts->taken += (unsigned)lanes(meets);
    store_value(job, r, raw, meets & (raw == raw), place);
}

/* A tile: its packets in rows. Where CULL holds, a packet in whose pixels nothing may be seen stays as it is: empty. */
#define TILE(NAME, DRAW, CULL)                                                                              \
    static void NAME(const struct pel_job *job, int x0, int y0, int x1, int y1, struct pel_counts *counts)  \
    {                                                                                                       \
        for (int y = y0; y < y1; y += PACKET_HEIGHT)                                                        \
            for (int x = x0; x < x1; x += PACKET_WIDTH) {                                                   \
                struct packet r;                                                                            \
                r.spans = packet_spans(job, x, y);                                                          \
                if ((CULL) && job->spans && !r.spans) {                                                     \
                    counts->culled += W;                                                                    \
                    continue;                                                                               \
                }                                                                                           \
                if (!packet_init(job, x, y, x1, y1, &r))                                                    \
                    continue;                                                                               \
                for (int i = 0; i < W; i++)                                                                 \
                    counts->in_box += (unsigned)r.n[i];                                                     \
                DRAW;                                                                                       \
            }                                                                                               \
    }

TILE(tile_composite, composite(job, &r, false, false, counts), true)
TILE(tile_composite_shaded, composite(job, &r, true, false, counts), true)
TILE(tile_composite_general, composite(job, &r, job->shade, true, counts), true)
TILE(tile_preintegrated, preintegrated(job, &r, counts), true)
TILE(tile_projection, projection(job, &r, counts), job->mode == PEL_MODE_XRAY)
TILE(tile_isosurface, isosurface(job, &r, counts), true)
TILE(tile_slice, slice(job, &r, counts), false)

extern const struct pel_kernels PEL_KERNELS;
const struct pel_kernels PEL_KERNELS = {
    tile_composite, tile_composite_shaded, tile_composite_general, tile_preintegrated, tile_projection, tile_isosurface, tile_slice,
};
