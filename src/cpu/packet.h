/* SPDX-License-Identifier: MIT */
/* A packet of W rays, one a lane, through a block of neighbouring pixels: where each enters and leaves, and how to pass over what cannot be
 * seen.
 *
 * The rays of a packet go in step (but from cell to cell, kernel_cells.h): sample k of every lane is taken together. Neighbouring pixels meet the same cells at nearly the same k,
 * so few lanes idle, and every gather falls into few cache lines. A lane's samples depend on nothing but its own pixel. */
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
    vi map;            /* offset of the distance map of the ray's octant */
    vi n;              /* segments; 0: misses, or outside the picture */
    vf fraction;       /* length of the last segment, in steps */
    vf offset, last;   /* sample k lies at min(k + offset, last) steps from the entry */
    double t_entry[W]; /* world distance of the entry */
    vf s_entry, s_step; /* depth parameter of the entry, and of a step */
    const uint64_t *spans; /* PEL_SPAN_WORDS words of depth slabs, or NULL */
    int slab;              /* the first that is still ahead */
};

/* Narrows [*lo, *hi] to where value + s * slope >= 0; `close` is a world length below which a ray alongside counts as on the plane. */
PEL_INLINE void clip(vd value, vd slope, double close, vd *lo, vd *hi)
{
    vl along = (slope < 1e-12) & (slope > -1e-12); /* in parallel with the plane, whose normal is a unit in the world: all or nothing */
    vd cut = -value / vd_select(along, vd_set(1), slope), none = vd_set(-1e300), all = vd_set(1e300);
    *lo = vd_max(*lo, vd_select(~along & (slope > 0), cut, none));
    *hi = vd_min(*hi, vd_select(along, vd_select(value >= -close, all, none), vd_select(slope > 0, all, cut)));
}

/* A half packet's rays, in double. */
struct half {
    vd p[3], d[3], lo, hi, length;
};

PEL_INLINE void half_init(const struct pel_job *job, vd x, double y0, vd row, struct half *h)
{
    vd y = y0 + row, length2 = vd_set(0);
    h->lo = vd_set(job->s_least);
    h->hi = vd_set(1e300);
    for (int a = 0; a < 3; a++) {
        vd p = h->p[a] = job->p0[a] + job->px[a] * x + job->py[a] * y;
        vd d = h->d[a] = job->d0[a] + job->dx[a] * x + job->dy[a] * y;
        vd w = job->w0[a] + job->wx[a] * x + job->wy[a] * y;
        length2 += w * w;
        vl along = (d < job->along) & (d > -job->along); /* in parallel with two faces: between them or not */
        vl between = (p >= job->box_lo[a] - 1e-9) & (p <= job->box_hi[a] + 1e-9);
        vd inverse = 1 / vd_select(along, vd_set(1), d), none = vd_set(-1e300), all = vd_set(1e300);
        vd t0 = (job->box_lo[a] - p) * inverse, t1 = (job->box_hi[a] - p) * inverse;
        h->lo = vd_max(h->lo, vd_select(along, none, vd_min(t0, t1)));
        h->hi = vd_min(h->hi, vd_select(along, vd_select(between, all, none), vd_max(t0, t1)));
    }
    for (int i = 0; i < job->plane_count; i++) {
        const double *q = job->planes[i];
        clip(q[0] * h->p[0] + q[1] * h->p[1] + q[2] * h->p[2] + q[3], q[0] * h->d[0] + q[1] * h->d[1] + q[2] * h->d[2], 1e-9 * job->step,
             &h->lo, &h->hi);
    }
    h->length = vd_sqrt(length2);
}

/* Puts lanes 0 .. HALF-1 or HALF .. W-1 of a float vector in place. */
PEL_INLINE void put_half(vf *to, int half, vd from)
{
    float lanes[HALF];
    for (int i = 0; i < HALF; i++)
        lanes[i] = (float)from[i];
    memcpy((float *)to + half * HALF, lanes, sizeof lanes);
}

/* Sets up the rays of the packet at (x, y); false where none meets the volume. `tile_x1`, `tile_y1`: the picture's part that may be drawn.
 */
__attribute__((noinline, unused)) static bool packet_init(const struct pel_job *job, int x, int y, int tile_x1, int tile_y1,
                                                          struct packet *r)
{
    struct half h[2];
    float fraction[W];
    int32_t n[W];
    bool any = false;
    for (int i = 0; i < 2; i++) {
        vd column, row, zero = vd_set(0);
        for (int l = 0; l < HALF; l++) {
            column[l] = (i * HALF + l) % PACKET_WIDTH;
            row[l] = (i * HALF + l) / PACKET_WIDTH;
        }
        half_init(job, x + column, y, row, &h[i]);
        vd stretch = h[i].hi - h[i].lo;
        vl hit = (stretch > 0) & (x + column < (double)tile_x1) & (y + row < (double)tile_y1);
        h[i].lo = vd_select(hit, h[i].lo, zero);
        stretch = vd_select(hit, vd_min(stretch * h[i].length / job->step, vd_set(1e9)), zero);
        for (int l = 0; l < HALF; l++) { /* a last thousandth belongs to the segment before */
            int32_t whole = (int32_t)(stretch[l] + 0.999);
            n[i * HALF + l] = stretch[l] > 0 ? (whole > 1 ? whole : 1) : 0;
            fraction[i * HALF + l] = (float)(stretch[l] - (n[i * HALF + l] - 1));
            any |= stretch[l] > 0;
        }
    }
    if (!any)
        return false;
    for (int i = 0; i < 2; i++) {
        vd ds = job->step / h[i].length, t = (h[i].lo + job->s_base) * h[i].length;
        vf *o[3] = { &r->ox, &r->oy, &r->oz }, *step[3] = { &r->dx, &r->dy, &r->dz };
        for (int a = 0; a < 3; a++) {
            put_half(o[a], i, vd_min(vd_max(h[i].p[a] + h[i].lo * h[i].d[a], vd_set(job->box_lo[a])), vd_set(job->box_hi[a])));
            put_half(step[a], i, ds * h[i].d[a]);
        }
        memcpy(r->t_entry + i * HALF, &t, sizeof t);
        put_half(&r->s_entry, i, h[i].lo);
        put_half(&r->s_step, i, ds);
    }
    vf tiny = vf_set(1e-12f);
    r->ix = 1 / vf_select(vf_abs(r->dx) < tiny, tiny, r->dx);
    r->iy = 1 / vf_select(vf_abs(r->dy) < tiny, tiny, r->dy);
    r->iz = 1 / vf_select(vf_abs(r->dz) < tiny, tiny, r->dz);
    r->map = ((r->dx < 0) & job->map_bytes) + ((r->dy < 0) & (2 * job->map_bytes)) + ((r->dz < 0) & (4 * job->map_bytes));
    r->x = x, r->y = y;
    memcpy(&r->n, n, sizeof n);
    memcpy(&r->fraction, fraction, sizeof fraction);
    r->offset = vf_set(0.5f);
    for (int i = 0; job->jitter && i < W; i++)
        r->offset[i] = pel_jitter(x + i % PACKET_WIDTH, y + i / PACKET_WIDTH, job->jitter - 1);
    r->last = vf_max(vi_to_vf(r->n - 1) + r->offset * r->fraction, vf_set(0)); /* lanes that miss stay at their entry */
    return true;
}

/* Finds the depth slabs of the packet at (x, y); false where none holds anything that may be seen. */
PEL_INLINE bool packet_spans(const struct pel_job *job, int x, int y, struct packet *r)
{
    r->spans = NULL;
    r->slab = 0;
    if (!job->spans)
        return true;
    r->spans = job->spans + ((size_t)(y >> PEL_SPAN_SHIFT) * (size_t)job->span_columns + (size_t)(x >> PEL_SPAN_SHIFT)) * PEL_SPAN_WORDS;
    uint64_t any = 0;
    for (int i = 0; i < PEL_SPAN_WORDS; i++)
        any |= r->spans[i];
    return any != 0;
}

/* The first slab from `slab` on that is marked (or, with all bits of `flip` set, that is not); PEL_SPAN_SLABS where there is none. */
PEL_INLINE int next_slab(const uint64_t *spans, int slab, uint64_t flip)
{
    while (slab < PEL_SPAN_SLABS) {
        uint64_t rest = (spans[slab >> 6] ^ flip) >> (slab & 63);
        if (rest)
            return slab + __builtin_ctzll(rest);
        slab = (slab | 63) + 1;
    }
    return PEL_SPAN_SLABS;
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
PEL_INLINE vf axis_exit(vi cell, vi reach, float size, vf o, vf inverse)
{
    vi side = vi_select(inverse < 0, -reach, reach + 1);
    return (vi_to_vf(cell + side) * size - o) * inverse;
}

/* The last sample (at its number + offset steps) that surely lies before an exit: the margin keeps what rounding could bring across a
 * border. */
PEL_INLINE vi samples_before(vf exit, vf offset)
{
    return vf_to_vi(vf_max(vf_min(exit * (1 - 4e-7f) - offset - 1e-3f, vf_set(1e9f)), vf_set(0)));
}

/* Looks at the cells around sample k (at k + offset steps). Where no live lane's cell may be seen, returns the last sample that all of them
 * may pass over. Else returns k - 1, and sets *look to the sample at which to look again: until then some lane is in a cell that may be
 * seen. */
PEL_INLINE int packet_look(const struct pel_job *job, const struct packet *r, const struct spot *s, vf offset, vi live, int k, int *look)
{
    vi cx = s->x >> PEL_CELL_SHIFT, cy = s->y >> PEL_CELL_SHIFT, cz = s->z >> PEL_CELL_SHIFT;
    vi distance = vi_gather(job->distance, r->map + (cz << job->cell_slice_shift) + (cy << job->cell_row_shift) + cx) & 0xff;
    vi seen = live & (distance == 0), reach = vi_max(distance - 1, vi_set(0));
    vf exit = vf_min(vf_min(axis_exit(cx, reach, PEL_CELL_SIZE, r->ox, r->ix), axis_exit(cy, reach, PEL_CELL_SIZE, r->oy, r->iy)),
                     axis_exit(cz, reach, PEL_CELL_SIZE, r->oz, r->iz));
    vi to = vi_max(samples_before(exit, offset), vi_set(k));
    if (!vi_any(seen))
        return vi_least(vi_select(live, to, vi_set(INT32_MAX - 1)));
    *look = vi_most(vi_select(seen, to, vi_set(k))) + 1;
    return k - 1;
}

/* Where the slabs from `first` up to `last` are, in steps from the entry. */
PEL_INLINE void span_steps(const struct pel_job *job, const struct packet *r, int first, int last, vf *from, vf *to)
{
    vf inverse = 1 / vf_select(r->n > 0, r->s_step, vf_set(1));
    *from = ((float)(job->span_lo + first / job->span_scale) - r->s_entry) * inverse;
    *to = ((float)(job->span_lo + last / job->span_scale) - r->s_entry) * inverse;
    *from = vf_max(vf_min(*from - 0.05f, vf_set(1e9f)), vf_set(0)); /* a margin for rounding, in steps */
    *to = vf_max(vf_min(*to + 0.05f, vf_set(1e9f)), vf_set(0));
}

/* A slab that the rays reach before any of these places, in steps from the entry. */
PEL_INLINE int slab_before(const struct pel_job *job, const struct packet *r, vi who, vf at)
{
    vf slab = (r->s_entry + (at - 0.1f) * r->s_step - (float)job->span_lo) * (float)job->span_scale - 1;
    slab = vf_max(vf_min(slab, vf_set(PEL_SPAN_SLABS)), vf_set(0));
    return vi_least(vi_select(who, vf_to_vi(slab), vi_set(PEL_SPAN_SLABS)));
}

/* The next stretch of samples in which something may be seen, from k on: gives its first sample and sets *end behind its last, or INT32_MAX
 * where there is none. */
PEL_INLINE int packet_next_span(const struct pel_job *job, struct packet *r, int k, int *end)
{
    int first = next_slab(r->spans, r->slab, 0), last = next_slab(r->spans, first, ~(uint64_t)0);
    r->slab = last;
    if (first >= PEL_SPAN_SLABS)
        return INT32_MAX;
    vf from, to;
    vi hit = r->n > 0;
    span_steps(job, r, first, last, &from, &to);
    *end = vi_most(vi_select(hit, vf_to_vi(to), vi_set(0))) + 1;
    int start = vi_least(vi_select(hit, vf_to_vi(from), vi_set(INT32_MAX)));
    return start > k ? start : k;
}

/* Writes the lanes' premultiplied colours, opacity and depth (steps from the entry; negative: none). */
__attribute__((noinline, unused)) static void packet_store(const struct pel_job *job, const struct packet *r, vf red, vf green, vf blue,
                                                           vf alpha, vf depth)
{
    for (int i = 0; i < W; i++) {
        int x = r->x + i % PACKET_WIDTH, y = r->y + i / PACKET_WIDTH;
        if (r->n[i] <= 0)
            continue;
        size_t at = (size_t)y * job->width + x;
        float *to = job->rgba + at * 4;
        to[0] = red[i], to[1] = green[i], to[2] = blue[i], to[3] = alpha[i];
        if (job->depth && depth[i] >= 0 && alpha[i] > 0)
            job->depth[at] = (float)(r->t_entry[i] + (double)depth[i] * job->step);
    }
}

#endif
