/* SPDX-License-Identifier: MIT */
/* A packet of W rays, one a lane, through a block of neighbouring pixels: where each enters and leaves, and how to pass over what cannot be seen.
 *
 * The rays of a packet go in step: sample k of every lane is taken together. Neighbouring pixels meet the same cells at nearly the same k, so few lanes idle,
 * and every gather falls into few cache lines. A lane's samples depend on nothing but its own pixel. */
#ifndef PEL_CPU_PACKET_H
#define PEL_CPU_PACKET_H

#include "fetch.h"
#include "jitter.h"

#define PACKET_WIDTH (W >= 8 ? 4 : 2)
#define PACKET_HEIGHT (W / PACKET_WIDTH)

struct packet {
    int x, y;          /* first pixel */
    vf ox, oy, oz;     /* index-space entry */
    vf dx, dy, dz;     /* index-space step: one dt */
    vf ix, iy, iz;     /* 1 / d, finite */
    vi n;              /* segments; 0: misses, or outside the picture */
    vf fraction;       /* length of the last segment, in steps */
    vf offset, last;   /* sample k lies at min(k + offset, last) steps from the entry */
    vd t_entry;        /* world distance of the entry */
};

PEL_INLINE vd vd_select(vd mask_ge_zero, vd a, vd b)
{
    typedef int64_t vl __attribute__((vector_size(W * 8)));
    vl m = mask_ge_zero >= 0;
    return (vd)((m & (vl)a) | (~m & (vl)b));
}

PEL_INLINE vd vd_least(vd a, vd b)
{
    return vd_select(b - a, a, b);
}

PEL_INLINE vd vd_most(vd a, vd b)
{
    return vd_select(a - b, a, b);
}

/* Narrows [*lo, *hi] to where value + s * slope >= 0. */
PEL_INLINE void clip(vd value, vd slope, vd *lo, vd *hi)
{
    vd parallel = 1e-300 - vd_select(slope, slope, -slope); /* >= 0: no crossing */
    vd cut = -value / vd_select(parallel, vd_set(1), slope);
    vd none = vd_select(value, vd_set(-1e300), vd_set(1e300)); /* parallel: all or nothing */
    vd enter = vd_select(parallel, none, vd_select(slope, cut, vd_set(-1e300)));
    vd leave = vd_select(parallel, vd_set(1e300), vd_select(-slope, cut, vd_set(1e300)));
    *lo = vd_most(*lo, enter);
    *hi = vd_least(*hi, leave);
}

PEL_INLINE vf reciprocal(vf d)
{
    vf tiny = vf_select(d < 0, vf_set(-1e-12f), vf_set(1e-12f));
    return 1 / vf_select(vf_abs(d) < 1e-12f, tiny, d);
}

/* Sets up the rays of the packet at (x, y); false where none meets the volume. `tile_x1`, `tile_y1`: the picture's part that may be drawn. */
__attribute__((noinline, unused)) static bool packet_init(const struct pel_job *job, int x, int y, int tile_x1, int tile_y1, struct packet *r)
{
    vd fx, fy;
    vi inside;
    vf jitter = vf_set(0.5f);
    for (int i = 0; i < W; i++) {
        int lx = x + i % PACKET_WIDTH, ly = y + i / PACKET_WIDTH;
        fx[i] = lx, fy[i] = ly;
        inside[i] = lx < tile_x1 && ly < tile_y1 ? -1 : 0;
        if (job->jitter)
            jitter[i] = pel_jitter(lx, ly);
    }
    vd p[3], d[3], lo = vd_set(job->s_least), hi = vd_set(1e300), length2 = vd_set(0);
    for (int a = 0; a < 3; a++) {
        p[a] = job->p0[a] + job->px[a] * fx + job->py[a] * fy;
        d[a] = job->d0[a] + job->dx[a] * fx + job->dy[a] * fy;
        vd w = job->w0[a] + job->wx[a] * fx + job->wy[a] * fy;
        length2 += w * w;
        clip(p[a] - job->box_lo[a], d[a], &lo, &hi);
        clip(job->box_hi[a] - p[a], -d[a], &lo, &hi);
    }
    for (int i = 0; i < job->plane_count; i++) {
        const double *q = job->planes[i];
        clip(q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3], q[0] * d[0] + q[1] * d[1] + q[2] * d[2], &lo, &hi);
    }
    vd stretch = hi - lo;
    vi hit = __builtin_convertvector(stretch > 0, vi) & inside;
    if (!vi_any(hit))
        return false;
    vd length;
    for (int i = 0; i < W; i++)
        length[i] = __builtin_sqrt(length2[i]);
    vd ds = job->step / length, steps = vd_least(stretch / ds, vd_set(1e9));
    steps = vd_select(stretch, steps, vd_set(0));
    vi n = __builtin_convertvector(steps + 0.999, vi); /* a last thousandth belongs to the segment before */
    n = vi_select(hit, vi_max(n, vi_set(1)), vi_set(0));
    vd whole = __builtin_convertvector(n, vd) - 1;
    vd entry = vd_select(__builtin_convertvector(n, vd) - 1, lo, vd_set(0));
    ds = vd_select(__builtin_convertvector(n, vd) - 1, ds, vd_set(0));
    r->x = x, r->y = y;
    r->n = n;
    r->fraction = __builtin_convertvector(steps - whole, vf);
    r->offset = jitter;
    r->last = vi_to_vf(n - 1) + jitter * r->fraction;
    vf *o[3] = { &r->ox, &r->oy, &r->oz }, *step[3] = { &r->dx, &r->dy, &r->dz }, *inverse[3] = { &r->ix, &r->iy, &r->iz };
    for (int a = 0; a < 3; a++) {
        vd at = p[a] + entry * d[a];
        at = vd_most(vd_least(at, vd_set(job->box_hi[a])), vd_set(job->box_lo[a]));
        *o[a] = __builtin_convertvector(at, vf);
        *step[a] = __builtin_convertvector(ds * d[a], vf);
        *inverse[a] = reciprocal(*step[a]);
    }
    r->t_entry = (entry + job->s_base) * length;
    return true;
}

/* The place of a ray parameter, in steps from the entry. */
PEL_INLINE struct spot packet_spot(const struct pel_job *job, const struct packet *r, vf at)
{
    return spot_at(job, r->ox + at * r->dx, r->oy + at * r->dy, r->oz + at * r->dz);
}

PEL_INLINE vf packet_at(const struct packet *r, int k)
{
    return vf_min((float)k + r->offset, r->last);
}

/* Steps to where the ray leaves the cube of cells from `cell - reach` to `cell + reach`, `size` voxels each. */
PEL_INLINE vf axis_exit(vi cell, vi reach, float size, vf o, vf d, vf inverse)
{
    vi side = vi_select(d < 0, -reach, reach + 1);
    return (vi_to_vf(cell + side) * size - o) * inverse;
}

/* Sample that each lane may go on to: k itself where its cell may be seen, else the last one that still lies in empty cells. The margin keeps what rounding
 * could bring across a border. */
PEL_INLINE vi packet_skip(const struct pel_job *job, const struct packet *r, const struct spot *s, vf offset, int k)
{
    vi cx = s->x >> 2, cy = s->y >> 2, cz = s->z >> 2;
    vi at = (cz * job->cell_dims[1] + cy) * job->cell_dims[0] + cx;
    vi distance = vi_gather(job->distance, at) & 0xff;
    vi reach = distance - 1;
    vf exit = vf_min(vf_min(axis_exit(cx, reach, 4, r->ox, r->dx, r->ix), axis_exit(cy, reach, 4, r->oy, r->dy, r->iy)),
                     axis_exit(cz, reach, 4, r->oz, r->dz, r->iz));
    vi to = vf_to_vi(vf_max(vf_min(exit - offset - 1e-3f, vf_set(1e9f)), vf_set(0)));
    return vi_select(distance == 0, vi_set(k), vi_max(to, vi_set(k)));
}

/* Writes the lanes' premultiplied colours, opacity and depth (steps from the entry; negative: none). */
__attribute__((noinline, unused)) static void packet_store(const struct pel_job *job, const struct packet *r, vf red, vf green, vf blue, vf alpha, vf depth)
{
    for (int i = 0; i < W; i++) {
        int x = r->x + i % PACKET_WIDTH, y = r->y + i / PACKET_WIDTH;
        if (r->n[i] <= 0)
            continue;
        size_t at = (size_t)y * job->width + x;
        float *to = job->rgba + at * 4;
        to[0] = red[i], to[1] = green[i], to[2] = blue[i], to[3] = alpha[i];
        if (job->depth && depth[i] >= 0)
            job->depth[at] = (float)(r->t_entry[i] + (double)depth[i] * job->step);
    }
}

#endif
