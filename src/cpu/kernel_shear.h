/* SPDX-License-Identifier: MIT */
/* Shear-warp: a scanline of the intermediate image through all slices, front to back (shear.h).
 *
 * The lanes are neighbouring pixels of the scanline. In each slice only runs of cells that may be seen are looked at, and of these only the
 * pixels that are not opaque yet; everything else would add exactly nothing, so neither changes a byte. A pixel's result depends on nothing
 * but its own ray: which lanes it shares an instruction with may change. */
#ifndef PEL_CPU_KERNEL_SHEAR_H
#define PEL_CPU_KERNEL_SHEAR_H

#include "kernel_composite.h"
#include "kernel_shear_line.h"
#include "kernel_shear_rays.h"

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
    vi low = whole<0, high = whole> job->last_cell[a]; /* cut off at the box's faces */
    part = vf_select(low, vf_set(0), vf_select(high, vf_select(whole == job->dims[a] - 1, part, vf_set(0)) + 1, part));
    part = vf_min(part, vf_set(1));
    whole = vi_min(vi_max(whole, vi_set(0)), vi_set(job->last_cell[a]));
    vi place[3];
    vf rest[3];
    place[a] = whole, rest[a] = part;
    place[s->axis[1]] = vi_set(r->j), rest[s->axis[1]] = vf_set(r->weight);
    place[s->axis[2]] = vi_set(slice->voxel), rest[s->axis[2]] = vf_set(slice->weight);
    return (struct spot) { place[0], place[1], place[2], rest[0], rest[1], rest[2] };
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
PEL_INLINE unsigned shear_chunk(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, struct pel_scanline *line,
                                int u, unsigned bits, bool shaded)
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
    struct gathered sum = line_load(line, u);
    put_behind(&sum, color, alpha, m);
    line_put(line, u, &sum);
    return vi_bits(live & (sum.alpha >= job->termination));
}

/* The pixels from `u` to `end` of a slice: stretches of open ones. */
PEL_INLINE void shear_run(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, struct pel_scanline *line, int u,
                          int end, bool shaded, struct pel_counts *counts)
{
    unsigned bits;
    for (u = next_open(line, u, end, &bits); u < end; u = next_open(line, u + W, end, &bits)) {
        counts->taken += (unsigned)__builtin_popcount(bits);
        unsigned opaque = shear_chunk(job, s, r, line, u, bits, shaded);
        if (opaque)
            close_pixels(line, u, opaque);
    }
}

PEL_INLINE int clamped(double at, int most)
{
    return at > 0 ? at < most ? (int)at : most : 0;
}

/* The runs of a slice: cells that may be seen, as stretches of pixels. */
PEL_INLINE void shear_slice(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, const uint64_t *runs, int from,
                            struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]];
    const double start = (double)r->i + r->whole, inverse = 1 / (double)r->di;
    while (from < cells) {
        int to = next_bit(runs, from, cells, ~(uint64_t)0);
        /* Samples beside the box are cut off at its faces: the outermost cells reach a voxel farther. */
        double lo = (double)from * PEL_CELL_SIZE - (from == 0) - start, hi = (double)to * PEL_CELL_SIZE + (to == cells) - start;
        shear_run(job, s, r, line, clamped(lo * inverse - 1e-3, s->width), clamped(hi * inverse + 1 + 1e-3, s->width), shaded, counts);
        from = next_bit(runs, to, cells, 0);
    }
}

#if PEL_KIND != PEL_KIND_WIDE

/* Slices of one layer and row of cells, which have the same runs. They are composited together: their values are fetched and looked up side
 * by side, and what the pixels gathered is loaded and stored once. */
#define GROUP PEL_CELL_SIZE
#define LOOK 32 /* pixels that are looked over at once */
#define ONES(n) (((uint64_t)1 << (n)) - 1)

struct group {
    struct slice_row rows[GROUP];
    const uint8_t *seen[GROUP]; /* the row of patches, or NULL */
    int count;
};

/* Up to 57 pixels from u on: a bit each that a sample there may be seen. */
PEL_INLINE uint64_t group_seen(const struct group *g, int i, int u)
{
    uint64_t bits;
    const int at = u + g->rows[i].whole;
    if (!g->seen[i])
        return ~(uint64_t)0;
    memcpy(&bits, g->seen[i] + (at >> 3), sizeof bits);
    return bits >> (at & 7);
}

/* May any sample of pixels from u up to end be seen? Yes if they are many. */
PEL_INLINE bool group_any(const struct group *g, int i, int u, int end)
{
    const int most = 57;
    return u + g->rows[i].whole < 0 || end - u > most || (end > u && group_seen(g, i, u) & ONES(end - u));
}

/* W pixels from u on, of which those in `open` are, in the group's slices; returns the bits of those that became opaque. */
PEL_INLINE unsigned near_chunk(const struct pel_job *job, const struct pel_shear *s, const struct group *g, struct pel_scanline *line,
                               int u, unsigned open, bool shaded, struct pel_counts *counts)
{
    vi entry[GROUP];
    vf alpha[GROUP], share[GROUP], from = vf_load(line->from + u), to = vf_load(line->to + u);
    vi live = bits_to_lanes(open), seen = vi_set(0);
    const float front = (float)g->rows[0].m - 0.5f, back = (float)g->rows[g->count - 1].m + 0.5f;
    const bool whole = !vi_any(live & ((from > front) | (to < back)));
    for (int i = 0; i < g->count; i++) {
        const struct slice_row *r = &g->rows[i];
        const unsigned some = open & (unsigned)group_seen(g, i, u);
        if (!some) {
            alpha[i] = vf_set(0);
            continue;
        }
        counts->taken += (unsigned)__builtin_popcount(some);
        near_prefetch(r, u, shaded ? 3 : 2);
        entry[i] = table_entry(job, near_value(job, r, u));
        vi lanes = bits_to_lanes(some);
        share[i] = vf_set(1);
        if (!whole) {
            vf m = vf_set((float)r->m), part = vf_min(to, m + 0.5f) - vf_max(from, m - 0.5f);
            lanes &= part > 0;
            share[i] = vf_select(lanes, part, share[i]);
        }
        alpha[i] = vf_select(lanes, slab_alpha(job, s, line, u, entry[i], share[i]), vf_set(0));
        seen |= alpha[i] > 0;
    }
    if (!vi_any(seen))
        return 0;
    struct gathered sum = line_load(line, u);
    vf gathering = sum.alpha, color[GROUP][3];
    bool any[GROUP];
    for (int i = 0; i < g->count; i++) { /* what is hidden by slices before it is not coloured */
        const vi shown = (gathering < job->termination) & (alpha[i] > 0);
        any[i] = vi_any(shown);
        alpha[i] = vf_select(shown, alpha[i], vf_set(0));
        gathering += (1 - gathering) * alpha[i];
    }
    for (int i = 0; shaded && i < g->count; i++) { /* light in all slices first: they do not wait for each other */
        if (!any[i])
            continue;
        vf gradient[3];
        struct packet view = shear_view(s, line, u);
        slab_color(job, entry[i], alpha[i], color[i]);
        near_gradient(job, s, &g->rows[i], u, gradient);
        shade(job, &view, gradient, alpha[i], color[i]);
    }
    for (int i = 0; i < g->count; i++) {
        if (!any[i])
            continue;
        if (!shaded)
            slab_color(job, entry[i], alpha[i], color[i]);
        for (int c = 0; c < 3; c++)
            color[i][c] = vf_select(alpha[i] > 0, color[i][c], vf_set(0));
        put_behind(&sum, color[i], alpha[i], vf_set((float)g->rows[i].m));
    }
    line_put(line, u, &sum);
    return vi_bits(live & (sum.alpha >= job->termination));
}

/* The runs of a group's slices that lie before pixel `inner` and from pixel `outer` on: there each slice goes the general way. */
PEL_INLINE void near_ends(const struct pel_job *job, const struct pel_shear *s, struct group *g, const uint64_t *runs, int from, int inner,
                          int outer, struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]], last = job->dims[s->axis[0]] - 1;
    while (from < cells) {
        const int to = next_bit(runs, from, cells, ~(uint64_t)0);
        for (int i = 0; i < g->count; i++) {
            const int whole = g->rows[i].whole, lo = from * PEL_CELL_SIZE - (from == 0) - 1 - whole,
                      hi = to * PEL_CELL_SIZE + (to == cells) + 1 - whole, start = lo > 0 ? lo : 0, end = hi < s->width ? hi : s->width;
            if (start < inner && group_any(g, i, -whole, inner))
                shear_run(job, s, &g->rows[i], line, start, end < inner ? end : inner, shaded, counts);
            if (end > outer && group_any(g, i, outer, last + 1 - whole))
                shear_run(job, s, &g->rows[i], line, start > outer ? start : outer, end, shaded, counts);
        }
        from = next_bit(runs, to, cells, 0);
    }
}

/* A group of slices: stretches of pixels that are open and where something may be seen in one of them. */
PEL_INLINE void near_slices(const struct pel_job *job, const struct pel_shear *s, struct group *g, const uint64_t *runs, int from,
                            struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]], voxels = job->dims[s->axis[0]], stop = last_bit(runs, s->run_words) + 1;
    int inner = 0, outer = s->width; /* pixels from inner up to outer have neighbours all around, in each slice */
    int first = s->width, end = 0;
    for (int i = 0; i < g->count; i++) {
        const int whole = g->rows[i].whole, lo = from * PEL_CELL_SIZE - (from == 0) - whole, hi = stop * PEL_CELL_SIZE + (stop == cells) - whole;
        inner = 1 - whole > inner ? 1 - whole : inner;
        outer = voxels - 2 - whole < outer ? voxels - 2 - whole : outer;
        first = lo < first ? lo : first;
        end = hi > end ? hi : end;
    }
    if (first < inner || end > outer)
        near_ends(job, s, g, runs, from, inner, outer, line, shaded, counts);
    first = first > inner ? first : inner;
    end = end < outer ? end : outer;
    for (int u = first; u < end;) {
        uint64_t seen = 0, open = open_pixels(line, u);
        for (int i = 0; i < g->count; i++)
            seen |= group_seen(g, i, u);
        seen &= open & ONES(LOOK);
        if (!seen) {
            u += LOOK;
            continue;
        }
        u += __builtin_ctzll(seen);
        const unsigned opaque = near_chunk(job, s, g, line, u, (unsigned)open_pixels(line, u) & lane_range(0, end - u), shaded, counts);
        if (opaque)
            close_pixels(line, u, opaque);
        u += W;
    }
}

#endif

/* Where the scanline runs in slice m, and the runs of that row of cells. */
PEL_INLINE const uint64_t *row_runs(const struct pel_job *job, const struct pel_shear *s, int v, int m, double *j)
{
    const struct pel_slice *slice = &s->slices[m];
    const int a = s->axis[1];
    double at = slice->j + v * slice->dj, most = job->dims[a] - 1;
    at = at > 0 ? at : 0;
    at = at < most ? at : most;
    *j = at;
    size_t row = (size_t)slice->cell * (size_t)job->cell_dims[a] + (size_t)((int)at >> PEL_CELL_SHIFT);
    return s->runs + row * (size_t)s->run_words;
}

PEL_INLINE struct slice_row row_place(const struct pel_job *job, const struct pel_shear *s, int m, double j)
{
    const struct pel_slice *slice = &s->slices[m];
    const int a = s->axis[1], c = s->axis[2], row = (int)j;
    struct slice_row r = { .di = (float)slice->di, .m = m };
    r.j = row < job->last_cell[a] ? row : job->last_cell[a];
    r.weight = (float)(j - r.j);
    r.whole = slice->whole;
    r.i = slice->part;
    /* Vectors reach beyond the end of a row, so not where the volume's last row is read: its end may be that of the memory. */
    r.near = s->near && slice->weight == 0 && (r.j < job->last_cell[a] || slice->voxel < job->last_cell[c]);
    r.row_before = r.j > 0 ? -1 : 0; /* at the volume's ends the last voxel again */
    r.row_after = r.j + 2 < job->dims[a] ? 2 : 1;
    r.slice_before = slice->voxel > 0 ? -1 : 0;
    r.turned = s->axis[2] == 0;
    r.rows = s->rows;
    r.next_row = s->next_row;
    r.next_slice = s->next_slice;
    r.pair = slice->pair;
    r.offset = slice->voxel * r.next_slice + r.j * r.next_row + r.whole;
    return r;
}

#if PEL_KIND != PEL_KIND_WIDE
PEL_INLINE const uint8_t *row_seen(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r)
{
    return s->seen ? s->seen + ((ptrdiff_t)s->slices[r->m].voxel * job->dims[s->axis[1]] + r->j) * s->seen_row : NULL;
}
#endif

/* Slice m, where its row's runs begin at cell `begin`, and those behind it that can go with it. Returns the last of them. */
PEL_INLINE int near_group(const struct pel_job *job, const struct pel_shear *s, int v, int m, int last,
                          double j, const uint64_t *runs, int begin, struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    struct slice_row r = row_place(job, s, m, j);
#if PEL_KIND != PEL_KIND_WIDE
    if (r.near) {
        struct group g;
        g.rows[0] = r;
        g.seen[0] = row_seen(job, s, &r);
        g.count = 1;
        while (g.count < GROUP && m < last && row_runs(job, s, v, m + 1, &j) == runs) {
            g.rows[g.count] = row_place(job, s, m + 1, j);
            if (!g.rows[g.count].near)
                break;
            g.seen[g.count] = row_seen(job, s, &g.rows[g.count]);
            g.count++;
            m++;
        }
        near_slices(job, s, &g, runs, begin, line, shaded, counts);
        return m;
    }
#endif
    (void)v, (void)last;
    shear_slice(job, s, &r, runs, begin, line, shaded, counts);
    return m;
}

PEL_INLINE void line_slices(const struct pel_job *job, const struct pel_shear *s, int v, struct pel_scanline *line, bool shaded,
                            struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]], last = line->last;
    for (int m = line->first; m <= last; m++) {
        double j;
        const uint64_t *runs = row_runs(job, s, v, m, &j);
        int begin = next_bit(runs, 0, cells, 0);
        if (begin < cells) {
            m = near_group(job, s, v, m, last, j, runs, begin, line, shaded, counts);
        } else if (row_runs(job, s, v, s->slices[m].layer_last, &j) == runs) {
            m = s->slices[m].layer_last; /* rows change steadily from slice to slice: all between are the same */
        }
    }
}

PEL_INLINE void line_begin(const struct pel_job *job, const struct pel_shear *s, int v, struct pel_scanline *line,
                           struct pel_counts *counts)
{
    memset(line->open, 0xff, ((size_t)s->width / 32 + 3) * sizeof *line->open);
    line->first = 0;
    line->last = -1;
    line_rays(job, s, v, line, counts);
}

/* Scanlines v0 up to v1. */
PEL_INLINE void shear_band(const struct pel_job *job, const struct pel_shear *s, int v0, int v1, struct pel_scanline *line, bool shaded,
                           struct pel_counts *counts)
{
    line_clear(line, 0, s->width);
    line->low = s->width;
    line->high = 0;
    for (int v = v0; v < v1; v++) {
        line_begin(job, s, v, line, counts);
        line_slices(job, s, v, line, shaded, counts);
        line_store(s, v, line);
    }
}

#endif
