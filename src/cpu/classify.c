/* SPDX-License-Identifier: MIT */
#include "classify.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "distance_map.h"
#include "fail.h"
#include "parallel.h"

#define ARRAYS 12

static bool reserve_arrays(struct pel_classification_state *s, struct pel_error *error)
{
    size_t n = s->table.count;
    if (s->array_entries != n) {
        free(s->arrays);
        s->array_entries = 0;
        s->arrays = pel_alloc_aligned(n * ARRAYS, sizeof(float), "look-up tables", error);
        if (!s->arrays)
            return false;
        s->array_entries = n;
    }
    float *at = s->arrays;
    float **fields[ARRAYS] = { &s->color[0],       &s->color[1],       &s->color[2], &s->alpha,   &s->alpha_color[0], &s->alpha_color[1],
                               &s->alpha_color[2], &s->tau,            &s->sum_tau,  &s->sum_color[0], &s->sum_color[1], &s->sum_color[2] };
    for (int i = 0; i < ARRAYS; i++, at += n)
        *fields[i] = at;
    return true;
}

/* The sRGB curve's inverse (IEC 61966-2-1). */
static double to_linear(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

/* Tables for a step of `length` unit distances. */
static void fill_arrays(struct pel_classification_state *s, double length, bool linear_light)
{
    const float *from[3] = { s->table.red, s->table.green, s->table.blue };
    double sum = 0, sum_color[3] = { 0, 0, 0 }, tau_before = 0, color_before[3] = { 0, 0, 0 };
    for (size_t i = 0; i < s->table.count; i++) {
        double opacity = s->table.opacity[i], depth = -log1p(-fmin(opacity, 1 - 0x1p-24)) * length;
        s->alpha[i] = opacity >= 1 ? 1 : (float)-expm1(-depth);
        s->tau[i] = (float)depth;
        sum += i ? (tau_before + depth) / 2 : 0;
        s->sum_tau[i] = (float)sum;
        for (int c = 0; c < 3; c++) {
            double color = linear_light ? to_linear(from[c][i]) : from[c][i];
            s->color[c][i] = (float)color;
            s->alpha_color[c][i] = s->alpha[i] * (float)color;
            sum_color[c] += i ? (color_before[c] + depth * color) / 2 : 0;
            s->sum_color[c][i] = (float)sum_color[c];
            color_before[c] = depth * color;
        }
        tau_before = depth;
    }
}

struct marking {
    struct pel_classification_state *state;
    const struct pel_minmax *minmax;
    const struct pel_job *job;
    struct pel_raw_scale raw;
    float least, most; /* of the whole volume */
    size_t *visible;   /* one a slab */
};

/* May anything with values in [least, most] be seen? Inclusive, with a margin for the rounding of reconstruction. */
static bool may_be_seen(const struct marking *m, float least, float most)
{
    if (least > most)
        return false; /* voids only */
    const struct pel_job *job = m->job;
    if (job->mode == PEL_MODE_MIP || job->mode == PEL_MODE_MINIP) /* can it beat the volume's worst value? */
        return m->minmax->has_voids || (job->mode == PEL_MODE_MIP ? most > m->least : least < m->most);
    if (job->mode != PEL_MODE_ISOSURFACE)
        return pel_transfer_table_visible(&m->state->table, least, most);
    double a = ((double)least - m->raw.offset) / m->raw.scale, b = ((double)most - m->raw.offset) / m->raw.scale;
    double margin = 1e-6 * (fabs(a) + fabs(b));
    for (int i = 0; i < job->iso_count; i++)
        if (a - margin <= job->iso[i] && job->iso[i] <= b + margin)
            return true;
    return false;
}

/* Cells first .. first + count - 1 of a row; gives how many may be seen, without marks 1 at the first. */
static size_t mark_row(const struct marking *m, size_t first, size_t count, size_t y, size_t z, uint8_t *to)
{
    const struct pel_minmax_level *cells = &m->minmax->cells, *blocks = &m->minmax->blocks;
    size_t row = (z * cells->dims[1] + y) * cells->dims[0], block_row = ((z / 4) * blocks->dims[1] + y / 4) * blocks->dims[0];
    size_t end = first + count, visible = 0;
    for (size_t x = first, next; x < end; x = next) {
        next = (x / 4 + 1) * 4 < end ? (x / 4 + 1) * 4 : end;
        bool any = may_be_seen(m, blocks->least[block_row + x / 4], blocks->most[block_row + x / 4]);
        if (!any && to)
            memset(to + (x - first), 1, next - x);
        for (; any && x < next; x++) {
            bool seen = may_be_seen(m, cells->least[row + x], cells->most[row + x]);
            visible += seen;
            if (to)
                to[x - first] = !seen;
            else if (seen)
                return visible;
        }
    }
    return visible;
}

static void mark_slab(void *context, size_t z, int thread)
{
    (void)thread;
    const struct marking *m = context;
    const struct pel_classification_state *s = m->state;
    size_t visible = 0;
    for (size_t y = 0; y < s->cell_dims[1]; y++)
        visible += mark_row(m, 0, s->cell_dims[0], y, z, s->marks + (z << s->slice_shift) + (y << s->row_shift));
    m->visible[z] = visible;
}

/* Least b with count <= 2^b. */
static int bits_for(size_t count)
{
    int bits = 0;
    while ((size_t)1 << bits < count)
        bits++;
    return bits;
}

static bool mark_cells(struct pel_classification_state *s, const struct pel_minmax *minmax, struct pel_raw_scale raw, int threads,
                           struct pel_job *job, struct pel_error *error)
{
    float least = INFINITY, most = -INFINITY;
    const struct pel_minmax_level *blocks = &minmax->blocks;
    for (size_t i = 0; i < blocks->dims[0] * blocks->dims[1] * blocks->dims[2]; i++) {
        least = fminf(least, blocks->least[i]);
        most = fmaxf(most, blocks->most[i]);
    }
    job->least_raw = (float)((least - raw.offset) / raw.scale);
    job->most_raw = (float)((most - raw.offset) / raw.scale);
    const size_t *dims = minmax->cells.dims;
    s->row_shift = bits_for(dims[0]);
    s->slice_shift = s->row_shift + bits_for(dims[1]);
    size_t bytes = dims[2] << s->slice_shift;
    if (s->map_bytes != bytes) {
        free(s->marks);
        free(s->distance);
        s->marks = s->distance = NULL;
        s->map_bytes = 0;
        if (bytes > INT32_MAX / 8) /* a very long thin volume: lanes could not address eight maps, and nothing is skipped */
            return true;
        s->marks = pel_alloc_aligned(bytes, 1, "visible cells", error);
        s->distance = pel_alloc_aligned(bytes * 8 + 4, 1, "distance maps", error);
        if (!s->marks || !s->distance)
            return false;
        s->map_bytes = bytes;
    }
    memcpy(s->cell_dims, dims, sizeof s->cell_dims);
    s->octants = 0;
    size_t *visible = pel_alloc(dims[2], sizeof *visible, "counts of visible cells", error);
    if (!visible)
        return false;
    struct marking m = { s, minmax, job, raw, least, most, visible };
    pel_parallel_for(threads, dims[2], mark_slab, &m);
    s->visible_cells = 0;
    for (size_t z = 0; z < dims[2]; z++)
        s->visible_cells += visible[z];
    free(visible);
    return true;
}

/* MIP and MinIP: each cell's most (least) in raw units, the comparison's own. */
static bool build_bounds(struct pel_classification_state *s, const struct pel_minmax *minmax, struct pel_raw_scale raw, bool most,
                         struct pel_error *error)
{
    const struct pel_minmax_level *levels[2] = { &minmax->cells, &minmax->blocks };
    size_t counts[2];
    for (int l = 0; l < 2; l++)
        counts[l] = levels[l]->dims[0] * levels[l]->dims[1] * levels[l]->dims[2];
    free(s->bounds);
    s->bounds = pel_alloc_aligned(counts[0] + counts[1], sizeof(float), "cell bounds", error);
    s->bound_count = s->bounds ? counts[0] + counts[1] : 0;
    if (!s->bounds)
        return false;
    float *to = s->bounds;
    for (int l = 0; l < 2; l++) {
        const float *from = most ? levels[l]->most : levels[l]->least;
        for (size_t i = 0; i < counts[l]; i++)
            *to++ = (float)((from[i] - raw.offset) / raw.scale);
    }
    return true;
}

void pel_classify_isosurfaces(const struct pel_scene *scene, struct pel_raw_scale raw, struct pel_job *job)
{
    const double *range = scene->volume->range;
    job->mode = scene->render.mode;
    job->iso_margin = (float)(2e-6 * fmax(fabs(range[0] - raw.offset), fabs(range[1] - raw.offset)) / raw.scale);
    job->iso_count = 0;
    for (int i = 0; i < scene->isosurface_count; i++) {
        const struct pel_isosurface *from = &scene->isosurfaces[i];
        float value = (float)((from->value - raw.offset) / raw.scale);
        int at = job->iso_count++;
        for (; at > 0 && job->iso[at - 1] > value; at--) {
            job->iso[at] = job->iso[at - 1];
            job->iso_opacity[at] = job->iso_opacity[at - 1];
            memcpy(job->iso_color[at], job->iso_color[at - 1], sizeof job->iso_color[at]);
        }
        job->iso[at] = value;
        job->iso_opacity[at] = (float)from->opacity;
        for (int c = 0; c < 3; c++)
            job->iso_color[at][c] = (float)(scene->linear_light ? to_linear(from->color[c]) : from->color[c]);
    }
}

bool pel_mode_has_map(enum pel_mode mode)
{
    return mode != PEL_MODE_AVERAGE && mode != PEL_MODE_SLICE;
}

bool pel_classify_tables(struct pel_classification_state *state, const struct pel_scene *scene, struct pel_raw_scale raw,
                         struct pel_job *job, struct pel_error *error)
{
    const struct pel_volume *v = scene->volume;
    double length = scene->render.step * pel_volume_least_spacing(v) / scene->transfer.unit_distance;
    if (!pel_transfer_table_build(&state->table, &scene->transfer, v->range[0], v->range[1], error) || !reserve_arrays(state, error))
        return false;
    fill_arrays(state, length, scene->linear_light);
    const struct pel_transfer_table *t = &state->table;
    double per_value = (double)(t->count - 1) / (t->hi - t->lo);
    job->table_last = (int32_t)(t->count - 1);
    per_value = fmin(per_value, 1e30 / raw.scale); /* finite in float, however narrow the curves' interval */
    job->table_scale = (float)(per_value * raw.scale);
    job->table_offset = (float)((raw.offset - t->lo) * per_value + 0.5);
    job->table_slack = (float)t->slack;
    job->next_visible = t->next_visible;
    job->opacity = t->opacity;
    job->red = state->color[0], job->green = state->color[1], job->blue = state->color[2];
    job->alpha = state->alpha;
    job->alpha_red = state->alpha_color[0], job->alpha_green = state->alpha_color[1], job->alpha_blue = state->alpha_color[2];
    job->tau = state->tau;
    job->sum_tau = state->sum_tau;
    job->sum_red = state->sum_color[0], job->sum_green = state->sum_color[1], job->sum_blue = state->sum_color[2];
    job->step_over_unit = (float)length;
    pel_classify_isosurfaces(scene, raw, job);
    return true;
}

bool pel_classify(struct pel_classification_state *state, const struct pel_scene *scene, const struct pel_minmax *minmax,
                  struct pel_raw_scale raw, int threads, struct pel_job *job, struct pel_error *error)
{
    if (!pel_classify_tables(state, scene, raw, job, error))
        return false;
    bool extreme = job->mode == PEL_MODE_MIP || job->mode == PEL_MODE_MINIP;
    bool maps = pel_mode_has_map(job->mode);
    state->visible_cells = 0;
    if (extreme && !build_bounds(state, minmax, raw, job->mode == PEL_MODE_MIP, error))
        return false;
    if (maps && !mark_cells(state, minmax, raw, threads, job, error))
        return false;
    for (int a = 0; a < 3; a++) {
        job->cell_dims[a] = (int32_t)minmax->cells.dims[a];
        job->block_dims[a] = (int32_t)minmax->blocks.dims[a];
    }
    job->marks = state->marks;
    job->distance = state->distance;
    job->map_bytes = (int32_t)state->map_bytes;
    job->cell_row_shift = state->row_shift;
    job->cell_slice_shift = state->slice_shift;
    job->cell_bound = state->bounds;
    job->block_bound = extreme ? state->bounds + minmax->cells.dims[0] * minmax->cells.dims[1] * minmax->cells.dims[2] : NULL;
    return true;
}

struct box {
    struct marking marking;
    const int *first, *count;
    uint8_t *marks;          /* or NULL */
    atomic_size_t visible;
};

static void mark_box_slab(void *context, size_t z, int thread)
{
    (void)thread;
    struct box *b = context;
    size_t visible = 0;
    for (int y = 0; y < b->count[1]; y++) {
        if (!b->marks && atomic_load_explicit(&b->visible, memory_order_relaxed) > 0)
            return;
        uint8_t *to = b->marks ? b->marks + (z * (size_t)b->count[1] + (size_t)y) * (size_t)b->count[0] : NULL;
        visible += mark_row(&b->marking, (size_t)b->first[0], (size_t)b->count[0], (size_t)(b->first[1] + y), (size_t)b->first[2] + z, to);
        if (!b->marks && visible)
            break;
    }
    atomic_fetch_add_explicit(&b->visible, visible, memory_order_relaxed);
}

size_t pel_classify_box(struct pel_classification_state *state, const struct pel_scene *scene, const struct pel_minmax *minmax,
                        struct pel_raw_scale raw, const struct pel_job *job, const int first[3], const int count[3], int threads,
                        uint8_t *marks)
{
    const double *range = scene->volume->range;
    struct marking m = { state, minmax, job, raw, nextafterf((float)range[0], -INFINITY), nextafterf((float)range[1], INFINITY), NULL };
    struct box b = { m, first, count, marks, 0 };
    pel_parallel_for(threads, (size_t)count[2], mark_box_slab, &b);
    size_t visible = atomic_load(&b.visible);
    return marks ? visible : visible > 0;
}

struct mapping {
    struct pel_classification_state *state;
    unsigned octant[8];
    bool failed[8];
};

static void map_octant(void *context, size_t i, int thread)
{
    (void)thread;
    struct mapping *m = context;
    struct pel_classification_state *s = m->state;
    m->failed[i] = !pel_distance_map(s->marks, s->cell_dims, (size_t)1 << s->row_shift, (size_t)1 << s->slice_shift, m->octant[i],
                                     s->distance + m->octant[i] * s->map_bytes, NULL);
}

bool pel_classify_octants(struct pel_classification_state *state, unsigned wanted, int threads, struct pel_error *error)
{
    struct mapping m = { .state = state };
    size_t count = 0;
    for (unsigned o = 0; o < 8; o++)
        if (wanted & ~state->octants & 1u << o)
            m.octant[count++] = o;
    pel_parallel_for(threads, count, map_octant, &m);
    for (size_t i = 0; i < count; i++)
        if (m.failed[i])
            return pel_fail(error, PEL_ERROR_MEMORY, "distance map: no memory");
    state->octants |= wanted;
    return true;
}

size_t pel_classify_bytes(const struct pel_classification_state *state)
{
    const struct pel_transfer_table *t = &state->table;
    return state->map_bytes * (size_t)(1 + __builtin_popcount(state->octants)) + state->array_entries * ARRAYS * sizeof(float) +
           state->bound_count * sizeof(float) + t->count * 4 * sizeof(float) +
           t->range.count * (size_t)t->range.levels * 2 * sizeof(float);
}

void pel_classify_finish(struct pel_classification_state *state)
{
    pel_transfer_table_finish(&state->table);
    free(state->arrays);
    free(state->marks);
    free(state->distance);
    free(state->bounds);
    memset(state, 0, sizeof *state);
}
