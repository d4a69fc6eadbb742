/* SPDX-License-Identifier: MIT */
#include "spans.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "minmax.h"
#include "parallel.h"
#include "vec.h"

struct projection {
    const struct pel_job *job;
    _Atomic uint64_t *masks;
    const size_t *cells;
    int group;               /* cells that are projected as one, along each axis */
    int columns, rows;
    bool parallel;
    double origin[3], axis[3][3]; /* camera space (right, up, forward) of index 0, and of a voxel along each index axis */
    double reach[3];              /* half the extent of a group in camera space */
    double focal, middle[2];      /* pixels a unit of tangent (or of length), and the picture's middle */
};

/* Is any cell of the group at (x, y, z) visible? */
static bool group_visible(const struct projection *p, size_t x, size_t y, size_t z)
{
    const struct pel_job *job = p->job;
    size_t group = (size_t)p->group;
    for (size_t k = z * group; k < z * group + group && k < p->cells[2]; k++)
        for (size_t j = y * group; j < y * group + group && j < p->cells[1]; j++) {
            const uint8_t *row = job->marks + (k << job->cell_slice_shift) + (j << job->cell_row_shift);
            for (size_t i = x * group; i < x * group + group && i < p->cells[0]; i++)
                if (!row[i])
                    return true;
        }
    return false;
}

/* Pixels that [centre - reach, centre + reach] can cover at depths from `near` to `far`, as blocks; false where none is in the picture. */
static bool blocks_covered(const struct projection *p, double centre, double reach, double near, double far, int axis, int count, int *first, int *last)
{
    double lo = centre - reach, hi = centre + reach, scale = axis ? -p->focal : p->focal;
    double a = p->parallel ? lo : lo / (lo < 0 ? near : far), b = p->parallel ? hi : hi / (hi < 0 ? far : near);
    double from = (scale > 0 ? a : b) * scale + p->middle[axis], to = (scale > 0 ? b : a) * scale + p->middle[axis];
    from = floor(from - 0.01) / (1 << PEL_SPAN_SHIFT);
    to = ceil(to + 0.01) / (1 << PEL_SPAN_SHIFT);
    if (to < 0 || from >= count)
        return false;
    *first = from > 0 ? (int)from : 0;
    *last = to < count - 1 ? (int)to : count - 1;
    return true;
}

static void project_group(const struct projection *p, size_t x, size_t y, size_t z)
{
    double size = (double)(p->group * PEL_CELL_SIZE), c[3];
    double at[3] = { ((double)x + 0.5) * size, ((double)y + 0.5) * size, ((double)z + 0.5) * size };
    for (int i = 0; i < 3; i++)
        c[i] = p->origin[i] + p->axis[0][i] * at[0] + p->axis[1][i] * at[1] + p->axis[2][i] * at[2];
    double near = c[2] - p->reach[2], far = c[2] + p->reach[2];
    int x0, x1, y0, y1;
    if (!blocks_covered(p, c[0], p->reach[0], near, far, 0, p->columns, &x0, &x1) ||
        !blocks_covered(p, c[1], p->reach[1], near, far, 1, p->rows, &y0, &y1))
        return;
    const struct pel_job *job = p->job;
    int first = (int)pel_clamp((near - job->s_base - job->span_lo) * job->span_scale - 0.01, 0, 63);
    int last = (int)pel_clamp((far - job->s_base - job->span_lo) * job->span_scale + 0.01, 0, 63);
    uint64_t bits = (~(uint64_t)0 >> (63 - (last - first))) << first;
    for (int j = y0; j <= y1; j++)
        for (int i = x0; i <= x1; i++) {
            _Atomic uint64_t *mask = p->masks + (size_t)j * (size_t)p->columns + (size_t)i;
            if ((atomic_load_explicit(mask, memory_order_relaxed) & bits) != bits)
                atomic_fetch_or_explicit(mask, bits, memory_order_relaxed);
        }
}

static void project_slab(void *context, size_t z, int thread)
{
    (void)thread;
    const struct projection *p = context;
    size_t group = (size_t)p->group;
    for (size_t y = 0; y * group < p->cells[1]; y++)
        for (size_t x = 0; x * group < p->cells[0]; x++)
            if (group_visible(p, x, y, z))
                project_group(p, x, y, z);
}

/* Camera-space coordinates (right, up, forward from the camera's position) of index space. */
static void camera_space(struct projection *p, const struct pel_scene *scene)
{
    double basis[3][3], matrix[3][4];
    pel_camera_basis(&scene->camera, basis[0], basis[1], basis[2]);
    pel_volume_matrix(scene->volume, matrix);
    for (int i = 0; i < 3; i++) {
        double from[3];
        pel_sub(scene->volume->origin, scene->camera.position, from);
        p->origin[i] = pel_dot(basis[i], from);
        p->reach[i] = 0;
        for (int a = 0; a < 3; a++) {
            double axis[3] = { matrix[0][a], matrix[1][a], matrix[2][a] };
            p->axis[a][i] = pel_dot(basis[i], axis);
            p->reach[i] += fabs(p->axis[a][i]) * (p->group * PEL_CELL_SIZE * 0.5 + 0.01);
        }
    }
}

bool pel_spans_build(struct pel_spans *spans, const struct pel_scene *scene, const size_t cells[3], size_t visible_cells, int threads,
                     struct pel_job *job, struct pel_error *error)
{
    job->spans = NULL;
    struct projection p = { .job = job, .cells = cells, .parallel = scene->camera.parallel };
    p.group = visible_cells > 50000 ? 2 : 1; /* many cells: coarser, so that projecting stays a small part of a frame */
    camera_space(&p, scene);
    double least = p.origin[2], most = p.origin[2];
    for (int a = 0; a < 3; a++) {
        double extent = p.axis[a][2] * (double)(cells[a] * PEL_CELL_SIZE), margin = p.reach[2];
        least += (extent < 0 ? extent : 0) - margin;
        most += (extent > 0 ? extent : 0) + margin;
    }
    if (!job->skip || (!p.parallel && least <= 1e-3 * (most - least)))
        return true;
    const int block = 1 << PEL_SPAN_SHIFT;
    p.columns = (job->width + block - 1) / block;
    p.rows = (job->height + block - 1) / block;
    size_t count = (size_t)p.columns * (size_t)p.rows;
    if (spans->count != count) {
        free(spans->masks);
        spans->count = 0;
        spans->masks = pel_alloc_aligned(count, sizeof *spans->masks, "span masks", error);
        if (!spans->masks)
            return false;
        spans->count = count;
    }
    memset(spans->masks, 0, count * sizeof *spans->masks);
    p.masks = (_Atomic uint64_t *)spans->masks;
    double half = p.parallel ? scene->camera.parallel_scale : tan(scene->camera.view_angle / 360 * 3.14159265358979323846);
    p.focal = job->height / (2 * half);
    p.middle[0] = (job->width - 1) * 0.5;
    p.middle[1] = (job->height - 1) * 0.5;
    job->span_lo = least - job->s_base;
    job->span_scale = 64 / (most - least);
    pel_parallel_for(threads, (cells[2] + (size_t)p.group - 1) / (size_t)p.group, project_slab, &p);
    job->spans = spans->masks;
    job->span_columns = p.columns;
    return true;
}

void pel_spans_finish(struct pel_spans *spans)
{
    free(spans->masks);
    memset(spans, 0, sizeof *spans);
}
