/* SPDX-License-Identifier: MIT */
/* Shear-warp: a scanline of the intermediate image through all slices, front to back (shear.h).
 *
 * The lanes are neighbouring pixels of the scanline. In each slice only runs of cells that may be seen are looked at, and of these only the
 * pixels that are not opaque yet; everything else would add exactly nothing, so neither changes a byte. A pixel's result depends on nothing
 * but its own ray: which lanes it shares an instruction with may change. */
#ifndef PEL_CPU_KERNEL_SHEAR_H
#define PEL_CPU_KERNEL_SHEAR_H

#include "kernel_composite.h"
#include "shear.h"

PEL_INLINE vf vf_load(const float *from)
{
    vf v;
    memcpy(&v, from, sizeof v);
    return v;
}

PEL_INLINE void vf_store(float *to, vf v)
{
    memcpy(to, &v, sizeof v);
}

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
            cuts[count++] = (struct cut){ -side * (at[a] - face), a ? 0 : -side * s->i.by0, -side * by[a], a ? 0 : -side * s->i.by1 };
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

/* Cuts W rays from pixel u on. What runs alongside a face is in or out as a whole. */
PEL_INLINE void cut_rays(const struct cut *c, vf pixel, vf *from, vf *to)
{
    vf value = (float)c->c0 + pixel * (float)c->c1, slope = (float)c->d0 + pixel * (float)c->d1;
    vi along = vf_abs(slope) < 1e-7f;
    vf at = -value / vf_select(along, vf_set(1), slope), none = vf_set(-1e9f), all = vf_set(1e9f);
    *from = vf_max(*from, vf_select(~along & (slope > 0), at, none));
    *to = vf_min(*to, vf_select(along, vf_select(value >= -1e-4f, all, none), vf_select(slope > 0, all, at)));
}

/* Perspective: each ray's direction, and its length from slice to slice. */
PEL_INLINE void line_directions(const struct pel_shear *s, int v, struct pel_scanline *line)
{
    const float *g = s->gram;
    for (int u = 0; u < s->width; u += W) {
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

/* The stretch of each ray inside the box, the clip planes and before the eye, in slices. Returns whether any ray of the scanline runs at
 * all, and between which slices. */
PEL_INLINE bool line_rays(const struct pel_job *job, const struct pel_shear *s, int v, struct pel_scanline *line, int *first, int *last,
                          struct pel_counts *counts)
{
    struct cut cuts[PEL_MAX_CLIP_PLANES + 12];
    int count = line_cuts(job, s, v, cuts);
    float least = 1e30f, most = -1e30f;
    for (int u = 0; u < s->width; u += W) {
        vf pixel = vi_to_vf(vi_lane() + u), from = vf_set((float)s->slice_from), to = vf_set(1e9f);
        for (int i = 0; i < count; i++)
            cut_rays(&cuts[i], pixel, &from, &to);
        vi runs = (to > from) & (vi_lane() + u < s->width);
        from = vf_select(runs, from, vf_set(1e9f));
        to = vf_select(runs, to, vf_set(-1e9f));
        vf_store(line->from + u, from);
        vf_store(line->to + u, to);
        for (int l = 0; l < W; l++) {
            least = from[l] < least ? from[l] : least;
            most = to[l] > most ? to[l] : most;
            counts->in_box += runs[l] ? (unsigned)(to[l] - from[l]) + 1 : 0;
        }
    }
    if (!(most > least))
        return false;
    if (s->perspective)
        line_directions(s, v, line);
    *first = (int)ceilf(fmaxf(least - 0.5f, 0));
    *last = (int)floorf(fminf(most + 0.5f, (float)(s->slice_count - 1)));
    return true;
}

/* A scanline's place in a slice. */
struct slice_row {
    float i, di;  /* i(u) = i + u di */
    int whole;    /* unit: the whole part of i; `i` is the rest */
    int j;        /* the row of voxels before it */
    float weight; /* how far it is towards the next */
    int m;
};

PEL_INLINE vi bits_to_lanes(unsigned bits)
{
    vi lane = vi_lane();
    return -((vi_set((int32_t)bits) >> lane) & 1);
}

/* The place between voxels of W pixels from u on. */
PEL_INLINE struct spot shear_spot(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, int u)
{
    const struct pel_slice *slice = &s->slices[r->m];
    vi whole;
    vf part;
    int a = s->axis[0];
    if (s->unit) {
        whole = vi_lane() + (u + r->whole);
        part = vf_set(r->i);
    } else {
        vf at = vf_max(vf_min(r->i + vi_to_vf(vi_lane() + u) * r->di, vf_set((float)(job->dims[a] - 1))), vf_set(0));
        whole = vf_to_vi(at);
        part = at - vi_to_vf(whole);
    }
    vi low = whole < 0, high = whole > job->last_cell[a]; /* cut off at the box's faces */
    part = vf_select(low, vf_set(0), vf_select(high, vf_select(whole == job->dims[a] - 1, part, vf_set(0)) + 1, part));
    part = vf_min(part, vf_set(1));
    whole = vi_min(vi_max(whole, vi_set(0)), vi_set(job->last_cell[a]));
    vi place[3];
    vf rest[3];
    place[a] = whole, rest[a] = part;
    place[s->axis[1]] = vi_set(r->j), rest[s->axis[1]] = vf_set(r->weight);
    place[s->axis[2]] = vi_set(slice->voxel), rest[s->axis[2]] = vf_set(slice->weight);
    return (struct spot){ place[0], place[1], place[2], rest[0], rest[1], rest[2] };
}

/* Opacity of the part `share` of a slice's slab, and the colour of that opacity. */
PEL_INLINE vf slab_alpha(const struct pel_job *job, const struct pel_shear *s, const struct pel_scanline *line, int u, vi entry, vf share)
{
    if (!s->perspective) {
        vf alpha = vf_gather(job->alpha, entry);
        if (vi_any(share < 1))
            alpha = s->linear ? alpha * share : vf_select(share < 1, alpha_of_length(alpha, share), alpha);
        return alpha;
    }
    vf length = vf_load(line->length + u) * share;
    if (s->linear)
        return vf_min(vf_gather(job->opacity, entry) * (length * job->step_over_unit), vf_set(1));
    return 1 - vf_exp(-vf_gather(job->tau, entry) * length);
}

PEL_INLINE void slab_color(const struct pel_job *job, vi entry, vf alpha, vf color[3])
{
    color[0] = alpha * vf_gather(job->red, entry);
    color[1] = alpha * vf_gather(job->green, entry);
    color[2] = alpha * vf_gather(job->blue, entry);
}

/* The directions that shading needs. */
PEL_INLINE struct packet shear_view(const struct pel_shear *s, const struct pel_scanline *line, int u)
{
    struct packet r;
    r.dx = s->perspective ? vf_load(line->toward[0] + u) : vf_set(s->toward[0]);
    r.dy = s->perspective ? vf_load(line->toward[1] + u) : vf_set(s->toward[1]);
    r.dz = s->perspective ? vf_load(line->toward[2] + u) : vf_set(s->toward[2]);
    return r;
}

/* W pixels of a slice from u on, of which those in `bits` are open; returns the bits of those that became opaque. */
PEL_INLINE unsigned shear_chunk(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, struct pel_scanline *line, int u,
                                unsigned bits, bool shaded)
{
    vf m = vf_set((float)r->m);
    vf share = vf_min(vf_load(line->to + u), m + 0.5f) - vf_max(vf_load(line->from + u), m - 0.5f);
    vi live = bits_to_lanes(bits) & (share > 0);
    if (!vi_any(live))
        return 0;
    share = vf_select(live, share, vf_set(1));
    struct spot at = shear_spot(job, s, r, u);
    struct rows rows = { 0 };
    struct nearest voxel;
    vf raw;
    if (job->nearest) {
        voxel = nearest_voxel(job, &at);
        raw = fetch_nearest(job, voxel.x, voxel.y, voxel.z);
    } else {
        raw = fetch_value(job, &at, &rows);
    }
    vi entry = table_entry(job, raw);
    vf alpha = slab_alpha(job, s, line, u, entry, share);
    alpha = vf_select(job->voids ? live & (raw == raw) : live, alpha, vf_set(0));
    if (!vi_any(alpha > 0))
        return 0;
    vf color[3];
    slab_color(job, entry, alpha, color);
    if (shaded) {
        vf g[3];
        struct packet view = shear_view(s, line, u);
        if (job->nearest)
            opacity_gradient(job, voxel.x, voxel.y, voxel.z, g);
        else
            fetch_gradient(job, &at, &rows, g);
        shade(job, &view, g, alpha, color);
        for (int c = 0; c < 3; c++)
            color[c] = vf_select(alpha > 0, color[c], vf_set(0));
    }
    vf sum = vf_load(line->alpha + u), rest = 1 - sum;
    for (int c = 0; c < 3; c++)
        vf_store(line->color[c] + u, vf_load(line->color[c] + u) + rest * color[c]);
    vf now = sum + rest * alpha;
    vf_store(line->alpha + u, now);
    vi passed = (sum < 0.5f) & (now >= 0.5f);
    if (vi_any(passed))
        vf_store(line->depth + u, vf_select(passed, m, vf_load(line->depth + u)));
    return vi_bits(live & (now >= job->termination));
}

/* The pixels from `u` to `end` of a slice: stretches of open ones. */
PEL_INLINE void shear_run(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, struct pel_scanline *line, int u,
                          int end, bool shaded, struct pel_counts *counts)
{
    while (u < end) {
        uint32_t rest = line->open[u >> 5] >> (u & 31);
        if (!rest) {
            u = (u | 31) + 1;
            continue;
        }
        u += __builtin_ctz(rest);
        if (u >= end)
            break;
        uint64_t pair;
        memcpy(&pair, line->open + (u >> 5), sizeof pair);
        unsigned bits = (unsigned)(pair >> (u & 31)) & ((1u << W) - 1);
        if (end - u < W)
            bits &= (1u << (end - u)) - 1;
        counts->taken += (unsigned)__builtin_popcount(bits);
        uint64_t opaque = shear_chunk(job, s, r, line, u, bits, shaded);
        if (opaque) {
            pair &= ~(opaque << (u & 31));
            memcpy(line->open + (u >> 5), &pair, sizeof pair);
        }
        u += W;
    }
}

/* The first bit from `at` on that is set (or, with all bits of `flip` set, that is not); `end` where there is none before. */
PEL_INLINE int next_bit(const uint64_t *words, int at, int end, uint64_t flip)
{
    while (at < end) {
        uint64_t rest = (words[at >> 6] ^ flip) >> (at & 63);
        if (rest) {
            at += __builtin_ctzll(rest);
            return at < end ? at : end;
        }
        at = (at | 63) + 1;
    }
    return end;
}

/* The runs of a slice: cells that may be seen, as stretches of pixels. */
PEL_INLINE void shear_slice(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, const uint64_t *runs,
                            struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]];
    const double start = (double)r->i + r->whole, inverse = 1 / (double)r->di;
    for (int from = next_bit(runs, 0, cells, 0); from < cells;) {
        int to = next_bit(runs, from, cells, ~(uint64_t)0);
        /* Samples beside the box are cut off at its faces: the outermost cells reach a voxel farther. */
        double lo = (double)from * PEL_CELL_SIZE - (from == 0) - start, hi = (double)to * PEL_CELL_SIZE + (to == cells) - start;
        int u0 = (int)fmin(fmax(lo * inverse - 1e-3, 0), s->width), u1 = (int)fmin(fmax(hi * inverse + 1 + 1e-3, 0), s->width);
        shear_run(job, s, r, line, u0, u1, shaded, counts);
        from = next_bit(runs, to, cells, 0);
    }
}

/* Clears a scanline. */
PEL_INLINE void line_clear(const struct pel_shear *s, struct pel_scanline *line)
{
    size_t padded = (size_t)s->width + W;
    for (int c = 0; c < 3; c++)
        memset(line->color[c], 0, padded * sizeof(float));
    memset(line->alpha, 0, padded * sizeof(float));
    for (size_t u = 0; u < padded; u++)
        line->depth[u] = -1;
    memset(line->open, 0xff, (padded / 32 + 2) * sizeof(uint32_t));
}

/* Puts a scanline into the intermediate image. */
PEL_INLINE void line_store(const struct pel_shear *s, int v, const struct pel_scanline *line)
{
    float *to = s->rgba + ((size_t)(v + 1) * (size_t)s->stride + 1) * 4;
    int from = s->width, end = 0;
    memset(to - 4, 0, 4 * sizeof *to); /* the border */
    memset(to + 4 * (size_t)s->width, 0, 4 * sizeof *to);
    for (int u = 0; u < s->width; u++) {
        to[4 * u] = line->color[0][u], to[4 * u + 1] = line->color[1][u], to[4 * u + 2] = line->color[2][u], to[4 * u + 3] = line->alpha[u];
        if (line->alpha[u] > 0) {
            from = u < from ? u : from;
            end = u + 1;
        }
    }
    if (s->depth) {
        float *depth = s->depth + (size_t)(v + 1) * (size_t)s->stride;
        depth[0] = depth[s->width + 1] = -1;
        memcpy(depth + 1, line->depth, (size_t)s->width * sizeof(float));
    }
    s->row_from[v + 1] = from + 1;
    s->row_to[v + 1] = end + 1;
}

PEL_INLINE void shear_line(const struct pel_job *job, const struct pel_shear *s, int v, struct pel_scanline *line, bool shaded,
                           struct pel_counts *counts)
{
    int first, last, a = s->axis[1];
    line_clear(s, line);
    bool any = line_rays(job, s, v, line, &first, &last, counts);
    for (int m = first; any && m <= last; m++) {
        const struct pel_slice *slice = &s->slices[m];
        double j = fmin(fmax(slice->j + v * slice->dj, 0), job->dims[a] - 1), i = slice->i;
        int row = (int)j;
        const uint64_t *runs = s->runs + ((size_t)slice->cell * (size_t)job->cell_dims[a] + (size_t)(row >> PEL_CELL_SHIFT)) * (size_t)s->run_words;
        struct slice_row r = { .di = (float)slice->di, .m = m };
        r.j = row < job->last_cell[a] ? row : job->last_cell[a];
        r.weight = (float)(j - r.j);
        r.whole = s->unit ? (int)floor(i) : 0;
        r.i = (float)(i - r.whole);
        shear_slice(job, s, &r, runs, line, shaded, counts);
    }
    line_store(s, v, line);
}

#endif
