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

struct group {
    struct slice_row rows[GROUP];
    int from[GROUP], end[GROUP]; /* pixels of a run */
    int count;
};

/* W pixels from u on, of which those in `bits` are open, in the group's slices; returns the bits of those that became opaque. */
PEL_INLINE unsigned near_chunk(const struct pel_job *job, const struct pel_shear *s, const struct group *g, struct pel_scanline *line,
                               int u, unsigned bits, bool shaded, struct pel_counts *counts)
{
    vi entry[GROUP];
    vf alpha[GROUP], share[GROUP], from = vf_load(line->from + u), to = vf_load(line->to + u);
    vi live = bits_to_lanes(bits), seen = vi_set(0);
    const float front = (float)g->rows[0].m - 0.5f, back = (float)g->rows[g->count - 1].m + 0.5f;
    const bool whole = !vi_any(live & ((from > front) | (to < back)));
    for (int i = 0; i < g->count; i++) {
        const struct slice_row *r = &g->rows[i];
        unsigned some = bits & lane_range(g->from[i] - u, g->end[i] - u);
        counts->taken += (unsigned)__builtin_popcount(some);
        if (!r->turned)
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
    vf color[GROUP][3];
    for (int i = 0; shaded && i < g->count; i++) { /* light in all slices first: they do not wait for each other */
        if (!vi_any(alpha[i] > 0))
            continue;
        vf gradient[3];
        struct packet view = shear_view(s, line, u);
        slab_color(job, entry[i], alpha[i], color[i]);
        near_gradient(job, s, &g->rows[i], u, gradient);
        shade(job, &view, gradient, alpha[i], color[i]);
    }
    struct gathered sum = line_load(line, u);
    for (int i = 0; i < g->count; i++) {
        vi shown = (sum.alpha < job->termination) & (alpha[i] > 0);
        if (!vi_any(shown))
            continue;
        if (!shaded)
            slab_color(job, entry[i], alpha[i], color[i]);
        for (int c = 0; c < 3; c++)
            color[i][c] = vf_select(shown, color[i][c], vf_set(0));
        put_behind(&sum, color[i], vf_select(shown, alpha[i], vf_set(0)), vf_set((float)g->rows[i].m));
    }
    line_put(line, u, &sum);
    return vi_bits(live & (sum.alpha >= job->termination));
}

/* The runs of a group of slices. Within W voxels of the box's faces, each slice goes the general way. */
PEL_INLINE void near_slices(const struct pel_job *job, const struct pel_shear *s, struct group *g, const uint64_t *runs, int from,
                            struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]], voxels = job->dims[s->axis[0]];
    int inner = 0, outer = s->width; /* pixels from inner up to outer have neighbours all around, in each slice */
    for (int i = 0; i < g->count; i++) {
        inner = 1 - g->rows[i].whole > inner ? 1 - g->rows[i].whole : inner;
        outer = voxels - 2 - g->rows[i].whole < outer ? voxels - 2 - g->rows[i].whole : outer;
    }
    while (from < cells) {
        int to = next_bit(runs, from, cells, ~(uint64_t)0), first = s->width, end = 0;
        for (int i = 0; i < g->count; i++) {
            int lo = from * PEL_CELL_SIZE - (from == 0) - 1 - g->rows[i].whole,
                hi = to * PEL_CELL_SIZE + (to == cells) + 1 - g->rows[i].whole;
            g->from[i] = lo > 0 ? lo < s->width ? lo : s->width : 0;
            g->end[i] = hi > 0 ? hi < s->width ? hi : s->width : 0;
            first = g->from[i] < first ? g->from[i] : first;
            end = g->end[i] > end ? g->end[i] : end;
        }
        for (int i = 0; i < g->count && (first < inner || end > outer); i++) {
            int left = g->end[i] < inner ? g->end[i] : inner, right = g->from[i] > outer ? g->from[i] : outer;
            shear_run(job, s, &g->rows[i], line, g->from[i], left, shaded, counts);
            shear_run(job, s, &g->rows[i], line, right > left ? right : left, g->end[i], shaded, counts);
        }
        first = first > inner ? first : inner;
        end = end < outer ? end : outer;
        unsigned bits;
        for (int u = next_open(line, first, end, &bits); u < end; u = next_open(line, u + W, end, &bits)) {
            unsigned opaque = near_chunk(job, s, g, line, u, bits, shaded, counts);
            if (opaque)
                close_pixels(line, u, opaque);
        }
        from = next_bit(runs, to, cells, 0);
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

PEL_INLINE struct slice_row row_place(const struct pel_job *job, const struct pel_shear *s, const struct pel_turn *turn, int m, double j)
{
    const struct pel_slice *slice = &s->slices[m];
    const int a = s->axis[1], c = s->axis[2], row = (int)j;
    struct slice_row r = { .di = (float)slice->di, .m = m };
    r.j = row < job->last_cell[a] ? row : job->last_cell[a];
    r.weight = (float)(j - r.j);
    r.whole = s->unit ? (int)floor(slice->i) : 0;
    r.i = (float)(slice->i - r.whole);
    r.near = s->near && slice->weight == 0 && slice->voxel >= 1 && slice->voxel <= job->dims[c] - 2 && r.j >= 1 && r.j <= job->dims[a] - 3;
    r.turned = c == 0;
    r.rows = r.turned ? turn->rows : job->data;
    r.next_row = r.turned ? turn->next_row : a == 1 ? job->row : job->slice;
    r.next_slice = r.turned ? turn->next_slice : c == 1 ? job->row : job->slice;
    int from_slice = r.turned ? turn->x0 : 0, from_row = r.turned ? turn->z0 : 0;
    int32_t weight = s->unit ? (int32_t)(r.i * 16384.0f + 0.5f) : 0;
    r.pair = (weight << 16) | (16384 - weight);
    r.offset = (slice->voxel - from_slice) * r.next_slice + (r.j - from_row) * r.next_row + r.whole;
    return r;
}

/* Slice m, where its row's runs begin at cell `begin`, and those behind it that can go with it. Returns the last of them. */
PEL_INLINE int near_group(const struct pel_job *job, const struct pel_shear *s, const struct pel_turn *turn, int v, int m, int last,
                          double j, const uint64_t *runs, int begin, struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    struct slice_row r = row_place(job, s, turn, m, j);
#if PEL_KIND != PEL_KIND_WIDE
    if (r.near) {
        struct group g;
        g.rows[0] = r;
        g.count = 1;
        while (g.count < GROUP && m < last && row_runs(job, s, v, m + 1, &j) == runs) {
            g.rows[g.count] = row_place(job, s, turn, m + 1, j);
            if (!g.rows[g.count].near)
                break;
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

/* Slices `first` to `last` of a scanline. */
PEL_INLINE void line_slices(const struct pel_job *job, const struct pel_shear *s, const struct pel_turn *turn, int v, int first, int last,
                            struct pel_scanline *line, bool shaded, struct pel_counts *counts)
{
    const int cells = job->cell_dims[s->axis[0]];
    for (int m = first; m <= last; m++) {
        double j;
        const uint64_t *runs = row_runs(job, s, v, m, &j);
        int begin = next_bit(runs, 0, cells, 0);
        if (begin < cells) {
            m = near_group(job, s, turn, v, m, last, j, runs, begin, line, shaded, counts);
        } else if (row_runs(job, s, v, s->slices[m].layer_last, &j) == runs) {
            m = s->slices[m].layer_last; /* rows change steadily from slice to slice: all between are the same */
        }
    }
}

/* Scanlines whose slices have x as principal axis, some slices at a time: first what they read is turned. */
PEL_INLINE void turned_lines(const struct pel_job *job, const struct pel_shear *s, int v0, int v1, struct pel_gathering *g, bool shaded,
                             struct pel_counts *counts)
{
    struct pel_turn *turn = &g->turn;
    int first = s->slice_count, last = -1;
    for (int v = v0; v < v1; v++) {
        first = g->lines[v - v0].first < first ? g->lines[v - v0].first : first;
        last = g->lines[v - v0].last > last ? g->lines[v - v0].last : last;
    }
    for (int m = first; m <= last; m += PEL_TURN_SLICES) {
        const int end = m + PEL_TURN_SLICES - 1 < last ? m + PEL_TURN_SLICES - 1 : last;
        const struct pel_slice *a = &s->slices[m], *b = &s->slices[end];
        int x0 = a->voxel < b->voxel ? a->voxel : b->voxel, x1 = a->voxel < b->voxel ? b->voxel : a->voxel;
        double z0 = fmin(a->j, b->j) + v0, z1 = fmax(a->j, b->j) + v1 - 1;
        turn->x0 = (x0 > 0 ? x0 - 1 : 0) & ~3;
        turn->x1 = x1 + 1 < job->dims[0] ? x1 + 1 : job->dims[0] - 1;
        turn->z0 = z0 > 1 ? (int)z0 - 1 : 0;
        turn->z1 = z1 + 2 < job->dims[2] ? (int)(z1 + 2) : job->dims[2] - 1;
        turn_block(job, s, turn, shaded);
        for (int v = v0; v < v1; v++) {
            struct pel_scanline *line = &g->lines[v - v0];
            line_slices(job, s, turn, v, line->first > m ? line->first : m, line->last < end ? line->last : end, line, shaded, counts);
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

/* Scanlines v0 up to v1, at most PEL_SHEAR_BAND. */
PEL_INLINE void shear_band(const struct pel_job *job, const struct pel_shear *s, int v0, int v1, struct pel_gathering *g, bool shaded,
                           struct pel_counts *counts)
{
    const bool turned = s->near && s->axis[2] == 0;
    for (int i = 0; i < (turned ? v1 - v0 : 1); i++) {
        line_clear(&g->lines[i], 0, s->width);
        g->lines[i].low = s->width;
        g->lines[i].high = 0;
    }
    for (int v = v0; v < v1; v++) {
        struct pel_scanline *line = &g->lines[turned ? v - v0 : 0];
        line_begin(job, s, v, line, counts);
        if (turned)
            continue;
        line_slices(job, s, &g->turn, v, line->first, line->last, line, shaded, counts);
        line_store(s, v, line);
    }
    if (!turned)
        return;
    turned_lines(job, s, v0, v1, g, shaded, counts);
    for (int v = v0; v < v1; v++)
        line_store(s, v, &g->lines[v - v0]);
}

#endif
