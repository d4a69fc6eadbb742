/* SPDX-License-Identifier: MIT */
/* The rays of a scanline of shear-warp's intermediate image: where each runs inside the box, the clip planes and before the eye. */
#ifndef PEL_CPU_KERNEL_SHEAR_RAYS_H
#define PEL_CPU_KERNEL_SHEAR_RAYS_H

#include "kernel_shear_fetch.h"

/* A half space to which rays are cut, along a scanline: at slice m pixel u is inside where c0 + u c1 + m (d0 + u d1) >= 0. */
struct cut {
    double c0, c1, d0, d1;
};

/* Faces of the box and clip planes as cuts of scanline v, in voxels or steps. */
PEL_INLINE int line_cuts(const struct pel_job *job, const struct pel_shear *s, int v, struct cut cuts[PEL_MAX_CLIP_PLANES + 12])
{
    const double at[3] = { s->i.at0, s->j.at0 + v * s->j.by0, s->first }, by[3] = { s->i.at1, s->j.at1 + v * s->j.by1, s->step };
    int count = 0;
    for (int a = 0; a < 3; a++)
        for (int side = -1; side <= 1; side += 2) {
            double face = side < 0 ? job->box_lo[s->axis[a]] : job->box_hi[s->axis[a]];
            cuts[count++] = (struct cut) { -side * (at[a] - face), a ? 0 : -side * s->i.by0, -side * by[a], a ? 0 : -side * s->i.by1 };
        }
    for (int i = 0; i < job->plane_count; i++) {
        struct cut c = { job->planes[i][3] / job->step, 0, 0, 0 };
        for (int a = 0; a < 3; a++) {
            double q = job->planes[i][s->axis[a]] / job->step;
            c.c0 += q * at[a], c.d0 += q * by[a];
            c.c1 += a ? 0 : q * s->i.by0, c.d1 += a ? 0 : q * s->i.by1;
        }
        cuts[count++] = c;
    }
    return count;
}

/* What is cut off a ray: a cut's share, as [from, to]. What runs alongside a face is in or out as a whole. */
struct stretch {
    vf from, to;
};

PEL_INLINE struct stretch cut_rays(const struct cut *c, vf pixel)
{
    vf value = (float)c->c0 + pixel * (float)c->c1, slope = (float)c->d0 + pixel * (float)c->d1, none = vf_set(-1e9f), all = vf_set(1e9f);
    vi along = vf_abs(slope) < 1e-7f;
    vf at = -value / vf_select(along, vf_set(1), slope);
    return (struct stretch) { vf_select(~along & (slope > 0), at, none),
                              vf_select(along, vf_select(value >= -1e-4f, all, none), vf_select(slope > 0, all, at)) };
}

/* Keeps of the cuts those that differ from pixel to pixel, and puts what the others leave into *all. */
PEL_INLINE int cut_whole_line(struct cut *cuts, int count, struct stretch *all)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        if (cuts[i].c1 != 0 || cuts[i].d1 != 0) {
            cuts[kept++] = cuts[i];
            continue;
        }
        struct stretch s = cut_rays(&cuts[i], vf_set(0));
        all->from = vf_max(all->from, s.from);
        all->to = vf_min(all->to, s.to);
    }
    return kept;
}

/* Perspective: each ray's direction, and its length from slice to slice. */
PEL_INLINE void line_directions(const struct pel_shear *s, int v, struct pel_scanline *line)
{
    const float *g = s->gram;
    for (int u = 0; u < s->width + W; u += W) { /* vectors that begin within the line end beyond it */
        vf d0 = (float)s->i.at1 + vi_to_vf(vi_lane() + u) * (float)s->i.by1;
        vf d1 = vf_set((float)(s->j.at1 + v * s->j.by1)), d2 = vf_set((float)s->step);
        vf length2 = g[0] * d0 * d0 + g[1] * d1 * d1 + g[2] * d2 * d2 + g[3] * d0 * d1 + g[4] * d0 * d2 + g[5] * d1 * d2;
        vf scale = vf_rsqrt(length2);
        vf_store(line->length + u, length2 * scale);
        vf_store(line->toward[s->axis[0]] + u, d0 * scale);
        vf_store(line->toward[s->axis[1]] + u, d1 * scale);
        vf_store(line->toward[s->axis[2]] + u, d2 * scale);
    }
}

/* The stretch of each ray inside the box, the clip planes and before the eye, in slices, and the slices between which any of them
 * runs. */
PEL_INLINE void line_rays(const struct pel_job *job, const struct pel_shear *s, int v, struct pel_scanline *line, struct pel_counts *counts)
{
    struct cut cuts[PEL_MAX_CLIP_PLANES + 12];
    struct stretch all = { vf_set((float)s->slice_from), vf_set(1e9f) };
    int count = cut_whole_line(cuts, line_cuts(job, s, v, cuts), &all);
    vf least = vf_set(1e9f), most = vf_set(-1e9f), inside = vf_set(0);
    for (int u = 0; u < s->width + W; u += W) {
        vf pixel = vi_to_vf(vi_lane() + u);
        struct stretch r = all;
        for (int i = 0; i < count; i++) {
            struct stretch cut = cut_rays(&cuts[i], pixel);
            r.from = vf_max(r.from, cut.from);
            r.to = vf_min(r.to, cut.to);
        }
        vi runs = (r.to > r.from) & (vi_lane() + u < s->width);
        r.from = vf_select(runs, r.from, vf_set(1e9f));
        r.to = vf_select(runs, r.to, vf_set(-1e9f));
        vf_store(line->from + u, r.from);
        vf_store(line->to + u, r.to);
        least = vf_min(least, r.from);
        most = vf_max(most, r.to);
        inside += vf_select(runs, r.to - r.from, vf_set(0));
    }
    float from = 1e9f, to = -1e9f;
    for (int l = 0; l < W; l++) {
        from = least[l] < from ? least[l] : from;
        to = most[l] > to ? most[l] : to;
        counts->in_box += (uint64_t)inside[l];
    }
    if (!(to > from))
        return;
    if (s->perspective)
        line_directions(s, v, line);
    line->first = from > 0.5f ? (int)ceilf(from - 0.5f) : 0;
    line->last = to + 0.5f < (float)(s->slice_count - 1) ? (int)floorf(to + 0.5f) : s->slice_count - 1;
}

#endif
