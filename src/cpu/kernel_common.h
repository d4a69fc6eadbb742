/* SPDX-License-Identifier: MIT */
/* What the kernels' loops share: the table look-up, the compositing of equation 1.8, the nearest voxel. */
#ifndef PEL_CPU_KERNEL_COMMON_H
#define PEL_CPU_KERNEL_COMMON_H

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

/* Values at the segments' ends, for pre-integration and isosurfaces: sample k lies at the front of segment k, sample n at the end of the
 * last. */
PEL_INLINE vf end_at(const struct packet *r, int k)
{
    return vf_min(vf_set((float)k), vi_to_vf(r->n - 1) + r->fraction);
}

/* A walk along a packet's segments. */
struct walk {
    int end, look, span_end;
    bool have_front; /* the last segment's back is this one's front */
};

PEL_INLINE struct walk walk_from_entry(const struct pel_job *job, const struct packet *r)
{
    int end = vi_most(r->n);
    return (struct walk) { .end = end, .span_end = job->spans ? 0 : end };
}

/* The first segment from k on that must be looked at; not below `end` where there is none. */
PEL_INLINE int walk_on(const struct pel_job *job, struct packet *r, struct walk *w, vi alive, int k)
{
    for (; k < w->end; w->have_front = false) {
        if (k >= w->span_end) {
            int next = packet_next_span(job, r, k, &w->span_end);
            if (next >= w->end)
                return next;
            w->have_front &= next == k;
            k = next;
        }
        if (!job->looks || k < w->look)
            return k;
        struct spot s = packet_spot(job, r, end_at(r, k));
        int clear = packet_look(job, r, &s, vf_set(0), alive & (r->n > k), k, &w->look);
        if (clear <= k)
            return k;
        k = clear; /* the segment that ends beyond it must be looked at */
    }
    return k;
}

#endif
