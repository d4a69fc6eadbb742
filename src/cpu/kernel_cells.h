/* SPDX-License-Identifier: MIT */
/* Isosurfaces, exactly: rays go from voxel cell to voxel cell, each lane at its own pace. Along a ray the trilinear signal of a cell is a
 * cubic (Marmitt et al. 2004, section 3), which rises or falls alone between the cell's faces and its extrema; so no surface is missed,
 * however little of it the ray meets.
 *
 * What a ray finds in a cell depends on the ray and the cell alone, whichever way it came there: places of faces along the ray are computed
 * from the face's number, and the value on a face from the face's four voxels, so that both cells beside it agree on its sign. Passing over
 * cells therefore cannot change a byte. */
#ifndef PEL_CPU_KERNEL_CELLS_H
#define PEL_CPU_KERNEL_CELLS_H

#include "kernel_surface.h"

/* Where the lanes are. Rays go up (side 1) or down (side 0) an axis; the cells along it number 0 to last_cell. */
struct stroll {
    vi cell[3];            /* that the ray comes into */
    vf t;                  /* where, in steps from the ray's entry */
    vf end;                /* of the ray */
    vi side[3], onward[3]; /* onward: 1 or -1 */
    vi first[3], last[3];  /* cells at the volume's faces: there is no face before and behind */
    vf o[3], d[3], inverse[3];
};

PEL_INLINE vf face_at(const struct stroll *s, int a, vi face)
{
    return (vi_to_vf(face) - s->o[a]) * s->inverse[a];
}

/* Where the ray leaves its cell along an axis, and where it came in; never, where the volume ends there. */
PEL_INLINE vf leave_at(const struct stroll *s, int a, vi cell)
{
    return vf_select(cell == s->last[a], vf_set(1e30f), face_at(s, a, cell + s->side[a]));
}

PEL_INLINE vf enter_at(const struct stroll *s, int a, vi cell)
{
    return vf_select(cell == s->first[a], vf_set(0), face_at(s, a, cell + 1 - s->side[a]));
}

/* Puts lanes into the cell that their ray is in at `at`: behind all faces that lie there or before. */
PEL_INLINE void stroll_to(const struct pel_job *job, struct stroll *s, vi who, vf at)
{
    vf t = vf_set(0);
    at = vf_max(vf_min(at, s->end), t);
    for (int a = 0; a < 3; a++) {
        vi cell = vi_max(vi_min(vf_to_vi(s->o[a] + at * s->d[a]), vi_set(job->last_cell[a])), vi_set(0));
        cell = vi_select(leave_at(s, a, cell) <= at, cell + s->onward[a], cell); /* which rounding left a cell short */
        cell = vi_select(enter_at(s, a, cell) > at, cell - s->onward[a], cell);
        t = vf_max(t, enter_at(s, a, cell));
        s->cell[a] = vi_select(who, cell, s->cell[a]);
    }
    s->t = vf_select(who, t, s->t);
}

PEL_INLINE void stroll_begin(const struct pel_job *job, const struct packet *r, struct stroll *s)
{
    const vf o[3] = { r->ox, r->oy, r->oz }, d[3] = { r->dx, r->dy, r->dz }, inverse[3] = { r->ix, r->iy, r->iz };
    for (int a = 0; a < 3; a++) {
        vi down = inverse[a] < 0, last = vi_set(job->last_cell[a]);
        s->o[a] = o[a], s->d[a] = d[a], s->inverse[a] = inverse[a];
        s->side[a] = down + 1;
        s->onward[a] = down | 1;
        s->first[a] = last & down;
        s->last[a] = last & ~down;
        s->cell[a] = vi_set(0);
    }
    s->end = vi_to_vf(r->n - 1) + r->fraction;
    s->t = vf_set(0);
    stroll_to(job, s, vi_set(-1), vf_set(0));
}

/* Where the rays leave their cells, by which faces. */
struct way_out {
    vf leave[3], at;
};

PEL_INLINE struct way_out way_out_of(const struct stroll *s)
{
    struct way_out out;
    for (int a = 0; a < 3; a++)
        out.leave[a] = leave_at(s, a, s->cell[a]);
    out.at = vf_min(vf_min(out.leave[0], out.leave[1]), out.leave[2]);
    return out;
}

/* Into the next cell. */
PEL_INLINE void stroll_on(struct stroll *s, const struct way_out *out, vi who)
{
    for (int a = 0; a < 3; a++)
        s->cell[a] += s->onward[a] & who & (out->leave[a] == out->at) & (s->cell[a] != s->last[a]);
    s->t = vf_select(who, out->at, s->t);
}

PEL_INLINE struct spot spot_of(const struct stroll *s)
{
    return (struct spot) { s->cell[0], s->cell[1], s->cell[2], vf_set(0), vf_set(0), vf_set(0) };
}

/* May a surface be in the cell, as its voxels say? */
PEL_INLINE vi cell_holds_surface(const struct pel_job *job, const struct rows *rows)
{
    vf least, most;
    rows_range(rows, &least, &most);
    vi holds = vi_set(0);
    for (int i = 0; i < job->iso_count; i++)
        holds |= (least < job->iso[i]) & (most >= job->iso[i]);
    if (__builtin_expect(job->voids, 0)) {
        vf corner[8];
        rows_corners(rows, corner);
        for (int i = 0; i < 8; i++) {
            holds &= vf_abs(corner[i]) <= FLT_MAX;
            if (job->has_void_value)
                holds &= corner[i] != job->void_raw;
        }
    }
    return holds;
}

/* The trilinear interpolant's coefficients. */
struct trilinear {
    vf one, x, y, z, xy, xz, yz, xyz;
};

PEL_INLINE struct trilinear trilinear_of(const vf v[8])
{
    struct trilinear k = { .one = v[0], .x = v[1] - v[0], .y = v[2] - v[0], .z = v[4] - v[0] };
    k.xy = v[3] - v[2] - k.x;
    k.xz = v[5] - v[4] - k.x;
    k.yz = v[6] - v[4] - k.y;
    k.xyz = v[7] - v[6] - (v[5] - v[4]) - k.xy;
    return k;
}

PEL_INLINE vf trilinear_at(const struct trilinear *k, const vf f[3])
{
    return k->one + f[2] * k->z + f[1] * (k->y + f[2] * k->yz) + f[0] * (k->x + f[2] * k->xz + f[1] * (k->xy + f[2] * k->xyz));
}

/* The squares' and the cubes' coefficients along f + u d. */
PEL_INLINE void trilinear_bends(const struct trilinear *k, const vf f[3], const vf d[3], vf *square, vf *cube)
{
    vf dxy = d[0] * d[1], mixed = f[0] * d[1] + f[1] * d[0];
    *square = k->xy * dxy + (k->xz * d[0] + k->yz * d[1]) * d[2] + k->xyz * (mixed * d[2] + dxy * f[2]);
    *cube = k->xyz * dxy * d[2];
}

/* May the rays cross a surface in the cell? Between its ends, c0 + c1 u + c2 u^2 + c3 u^3 lies off their straight line by u (1 - u) (c2 +
 * c3 (1 + u)), a quarter of the greater of c2 + c3 and c2 + 2 c3 at most. */
PEL_INLINE vi cell_may_cross(const struct pel_job *job, const struct stroll *s, const struct rows *rows, vf to)
{
    vf corner[8], f[3], g[3], d[3], square, cube;
    rows_corners(rows, corner);
    for (int a = 0; a < 3; a++) {
        vf from = s->o[a] - vi_to_vf(s->cell[a]);
        f[a] = from + s->t * s->d[a];
        g[a] = from + to * s->d[a];
        d[a] = g[a] - f[a];
    }
    struct trilinear k = trilinear_of(corner);
    trilinear_bends(&k, f, d, &square, &cube);
    vf v = trilinear_at(&k, f), w = trilinear_at(&k, g);
    vf off = 0.25f * vf_max(vf_abs(square + cube), vf_abs(square + 2 * cube)) + job->iso_margin;
    vf least = vf_min(v, w) - off, most = vf_max(v, w) + off;
    vi may = vi_set(0);
    for (int i = 0; i < job->iso_count; i++)
        may |= (least <= job->iso[i]) & (most >= job->iso[i]);
    return may;
}

/* Between a and b, never beyond them, and at the ends those themselves: so that cells agree on their faces. */
PEL_INLINE vf tight_lerp(vf a, vf b, vf t)
{
    return vf_select(t == 1, b, vf_min(vf_max(vf_lerp(a, b, t), vf_min(a, b)), vf_max(a, b)));
}

PEL_INLINE vf tight_value(const vf c[8], const vf f[3])
{
    vf low = tight_lerp(tight_lerp(c[0], c[1], f[0]), tight_lerp(c[2], c[3], f[0]), f[1]);
    vf high = tight_lerp(tight_lerp(c[4], c[5], f[0]), tight_lerp(c[6], c[7], f[0]), f[1]);
    return tight_lerp(low, high, f[2]);
}

/* The trilinear interpolant along f + u d. */
PEL_INLINE void cubic_along(const vf v[8], const vf f[3], const vf d[3], struct cubic *q)
{
    struct trilinear k = trilinear_of(v);
    q->c[0] = trilinear_at(&k, f);
    q->c[1] = d[0] * (k.x + k.xy * f[1] + k.xz * f[2] + k.xyz * f[1] * f[2]) +
              d[1] * (k.y + k.xy * f[0] + k.yz * f[2] + k.xyz * f[0] * f[2]) +
              d[2] * (k.z + k.xz * f[0] + k.yz * f[1] + k.xyz * f[0] * f[1]);
    trilinear_bends(&k, f, d, &q->c[2], &q->c[3]);
    q->least = q->most = v[0];
    for (int i = 1; i < 8; i++) {
        q->least = vf_min(q->least, v[i]);
        q->most = vf_max(q->most, v[i]);
    }
}

/* Where the cubic's slope is 0 between 0 and 1, in order; 1 where it is not. `scale` keeps squares from overflowing. */
PEL_INLINE void extrema(const struct cubic *q, float scale, vf turn[2])
{
    vf a = 3 * q->c[3] * scale, b = q->c[2] * scale, c = q->c[1] * scale, one = vf_set(1), discriminant = b * b - a * c;
    vf root = vf_sqrt(vf_max(discriminant, vf_set(0))), p = -(b + vf_select(b < 0, -root, root)), u[2];
    u[0] = p / vf_select(a == 0, one, a);
    u[1] = c / vf_select(p == 0, one, p);
    u[0] = vf_select((discriminant > 0) & (a != 0) & (u[0] > 0) & (u[0] < 1), u[0], one);
    u[1] = vf_select((discriminant > 0) & (p != 0) & (u[1] > 0) & (u[1] < 1), u[1], one);
    turn[0] = vf_min(u[0], u[1]);
    turn[1] = vf_max(u[0], u[1]);
}

/* The surfaces in the lanes' cells, in the order of the rays. Gives the lanes whose rays go on. */
PEL_INLINE vi cross_cell(const struct pel_job *job, const struct packet *r, const struct stroll *s, const struct way_out *out, vi who,
                         struct pending *p, struct gathered *sum, vf *first)
{
    struct spot spot = spot_of(s);
    struct rows rows;
    struct cubic q;
    vf corner[8], f[3], g[3], d[3], to = vf_min(out->at, s->end);
    for (int a = 0; a < 3; a++) {
        vf zero = vf_set(0), one = vf_set(1), corner_at = vi_to_vf(s->cell[a]), side = vi_to_vf(s->side[a]);
        f[a] = vf_min(vf_max(s->o[a] + s->t * s->d[a] - corner_at, zero), one);
        g[a] = vf_min(vf_max(s->o[a] + to * s->d[a] - corner_at, zero), one);
        f[a] = vf_select((s->cell[a] != s->first[a]) & (enter_at(s, a, s->cell[a]) == s->t), 1 - side, f[a]);
        g[a] = vf_select(out->leave[a] == to, side, g[a]);
        d[a] = g[a] - f[a];
    }
    fetch_rows(job, &spot, &rows);
    rows_corners(&rows, corner);
    cubic_along(corner, f, d, &q);
    vf u[4], value[4];
    u[0] = vf_set(0), u[3] = vf_set(1);
    extrema(&q, job->gradient_scale, u + 1);
    value[0] = tight_value(corner, f);
    value[3] = tight_value(corner, g);
    for (int i = 1; i < 3; i++)
        value[i] = vf_select(u[i] < 1, cubic_at(&q, u[i]), value[3]);
    for (int piece = 0; piece < 3; piece++) {
        vf v = value[piece], w = value[piece + 1];
        vi rising = w > v;
        for (int j = 0; j < job->iso_count; j++) {
            int i = job->iso_count - 1 - j;
            vf iso = vf_select(rising, vf_set(job->iso[j]), vf_set(job->iso[i]));
            vi crossed = who & ((v < iso) ^ (w < iso));
            if (!vi_any(crossed))
                continue;
            if (vi_any(crossed & p->lanes)) {
                settle(job, r, p, sum, first);
                who &= sum->alpha < job->termination;
                crossed &= who;
            }
            const struct bracket bracket = { u[piece], u[piece + 1], v, w };
            pending_bracket(p, crossed, &bracket, iso);
            p->from = vf_select(crossed, s->t, p->from);
            p->length = vf_select(crossed, to - s->t, p->length);
            for (int k = 0; k < 4; k++)
                p->cubic.c[k] = vf_select(crossed, q.c[k], p->cubic.c[k]);
            p->cubic.least = vf_select(crossed, q.least, p->cubic.least);
            p->cubic.most = vf_select(crossed, q.most, p->cubic.most);
            pending_take(job, p, crossed, rising, j, i);
            who &= ~(crossed & (p->alpha >= 1)); /* nothing behind it is seen */
        }
    }
    return who;
}

/* The distance maps: lanes whose cells of 4^3 hold nothing go to where something may be. Gives those; the others need not look again before
 * `until`. */
PEL_INLINE vi pass_over(const struct pel_job *job, const struct packet *r, struct stroll *s, vi who, vf *until)
{
    who &= s->t >= *until;
    if (!vi_any(who))
        return who;
    vi cell[3];
    for (int a = 0; a < 3; a++)
        cell[a] = s->cell[a] >> PEL_CELL_SHIFT;
    vi distance = vi_gather(job->distance, r->map + (cell[2] << job->cell_slice_shift) + (cell[1] << job->cell_row_shift) + cell[0]) & 0xff;
    vi clear = who & (distance > 0), reach = vi_max(distance - 1, vi_set(0));
    vf exit = vf_set(1e30f);
    for (int a = 0; a < 3; a++)
        exit = vf_min(exit, axis_exit(cell[a], reach, PEL_CELL_SIZE, s->o[a], s->inverse[a]));
    *until = vf_select(who, exit, *until);
    clear &= exit > s->t; /* else the ray is at the volume's last face, which no cell is behind */
    if (vi_any(clear))
        stroll_to(job, s, clear, exit);
    return clear;
}

/* Takes those who stroll to the next stretch of the rays in which something may be, ending at *stop; false where there is none. */
PEL_INLINE bool stroll_to_span(const struct pel_job *job, struct packet *r, struct stroll *s, vi who, vf *stop)
{
    int slab = next_slab(r->spans, r->slab, 0);
    r->slab = next_slab(r->spans, slab, ~(uint64_t)0);
    if (slab >= PEL_SPAN_SLABS)
        return false;
    vf from;
    span_steps(job, r, slab, r->slab, &from, stop);
    vi jump = who & (from > s->t) & (s->t < s->end);
    if (vi_any(jump))
        stroll_to(job, s, jump, from);
    return true;
}

/* Lanes go on until they come to a cell that may hold a surface, which are given back, or to the end. */
PEL_INLINE vi stroll(const struct pel_job *job, const struct packet *r, struct stroll *s, vi who, vf end, vf *until,
                     struct pel_counts *counts)
{
    vi held = vi_set(0);
    while (vi_any(who &= s->t < end)) {
        vi going = job->looks ? who & ~pass_over(job, r, s, who, until) : who;
        if (!vi_any(going))
            continue;
        counts->taken += (unsigned)lanes(going);
        struct way_out out = way_out_of(s);
        struct spot spot = spot_of(s);
        struct rows rows;
        fetch_rows(job, &spot, &rows);
        vi found = going & cell_holds_surface(job, &rows);
        if (vi_any(found))
            found &= cell_may_cross(job, s, &rows, vf_min(out.at, s->end));
        held |= found;
        who &= ~found;
        stroll_on(s, &out, going & ~found);
    }
    return held;
}

PEL_INLINE void isosurface_cells(const struct pel_job *job, struct packet *r, struct pel_counts *counts)
{
    struct gathered sum = gathered_none();
    struct pending p = pending_none(true);
    struct stroll s;
    vf first = vf_set(-1), until = vf_set(0), stop = vf_set(1e30f);
    vi alive = r->n > 0;
    stroll_begin(job, r, &s);
    while (true) {
        vi held = vi_set(0); /* these found a cell that may hold a surface: they wait, so that many are looked into at once */
        while (vi_any(alive & ~held & (s.t < s.end)) && (!r->spans || stroll_to_span(job, r, &s, ~held, &stop)))
            held |= stroll(job, r, &s, alive & ~held, vf_min(s.end, stop), &until, counts);
        if (!vi_any(held))
            break;
        struct way_out out = way_out_of(&s);
        alive &= ~held | cross_cell(job, r, &s, &out, held, &p, &sum, &first);
        stroll_on(&s, &out, held);
        if (r->spans) /* again from the hindmost of those that waited */
            r->slab = slab_before(job, r, alive & held, s.t);
    }
    if (vi_any(p.lanes))
        settle(job, r, &p, &sum, &first);
    packet_store(job, r, sum.color[0], sum.color[1], sum.color[2], sum.alpha, first);
}

#endif
