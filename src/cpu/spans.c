/* SPDX-License-Identifier: MIT */
#include "spans.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "minmax.h"
#include "parallel.h"
#include "vec.h"

struct work {
    const struct pel_job *job;
    const size_t *cells;
    size_t group;                        /* cells that are projected as one, along each axis */
    pel_project_surface project_surface; /* or NULL: groups of cells are projected whole */
    double size;                         /* voxels of a projected cube */
    uint8_t *folds;                      /* a row of cells a thread */
    struct pel_projection projection;
};

/* Blocks that [centre - reach, centre + reach] can cover, at inverse depths from `near` to `far` (parallel: both 1); false where none is in
 * the picture. */
static bool blocks_covered(const struct pel_projection *p, float centre, float near, float far, int axis, int *first, int *last)
{
    float lo = centre - p->reach[axis], hi = centre + p->reach[axis];
    float a = lo * (lo < 0 ? near : far) * p->focal[axis] + p->middle[axis],
          b = hi * (hi < 0 ? far : near) * p->focal[axis] + p->middle[axis];
    float from = fminf(a, b) - 0.01f, to = fmaxf(a, b) + 0.01f;
    const int end = p->blocks[axis] << PEL_SPAN_SHIFT;
    if (to < 0 || from >= (float)end)
        return false;
    *first = from > 0 ? (int)from >> PEL_SPAN_SHIFT : 0;
    *last = (to < (float)end ? (int)to : end - 1) >> PEL_SPAN_SHIFT;
    return true;
}

/* Marks what the group of cells from voxel (x, y, z) on covers. */
static void project_group(const struct pel_projection *p, float x, float y, float z)
{
    float c[3];
    for (int i = 0; i < 3; i++)
        c[i] = p->origin[i] + x * p->axis[0][i] + y * p->axis[1][i] + z * p->axis[2][i];
    float near = c[2] - p->reach[2], far = c[2] + p->reach[2], inverse_near = p->parallel ? 1 : 1 / near,
          inverse_far = p->parallel ? 1 : 1 / far;
    int x0, x1, y0, y1;
    if (!blocks_covered(p, c[0], inverse_near, inverse_far, 0, &x0, &x1) ||
        !blocks_covered(p, c[1], inverse_near, inverse_far, 1, &y0, &y1))
        return;
    float first = (near - p->slab_start) * p->slabs, last = (far - p->slab_start) * p->slabs;
    pel_mark_span(p, x0, x1, y0, y1, first > 0 ? (int)first : 0, last < PEL_SPAN_SLABS - 1 ? (int)last : PEL_SPAN_SLABS - 1);
}

/* Marks of a row of groups of cells, as a row of cells: 0 where the cell, or one beside it in the group's other rows, may be seen. */
static const uint8_t *fold_rows(const struct work *w, size_t y, size_t z, uint8_t *fold)
{
    const struct pel_job *job = w->job;
    const uint8_t *first = job->marks + (z * w->group << job->cell_slice_shift) + (y * w->group << job->cell_row_shift);
    if (w->group == 1)
        return first;
    memset(fold, 1, w->cells[0]);
    for (size_t k = 0; k < w->group && z * w->group + k < w->cells[2]; k++)
        for (size_t j = 0; j < w->group && y * w->group + j < w->cells[1]; j++) {
            const uint8_t *row = first + (k << job->cell_slice_shift) + (j << job->cell_row_shift);
            for (size_t x = 0; x < w->cells[0]; x++)
                fold[x] &= row[x];
        }
    return fold;
}

static void project_slab(void *context, size_t z, int thread)
{
    const struct work *w = context;
    const size_t size = w->group * PEL_CELL_SIZE;
    for (size_t y = 0; y * w->group < w->cells[1]; y++) {
        const uint8_t *row = fold_rows(w, y, z, w->folds + (size_t)thread * w->cells[0]), *end = row + w->cells[0];
        for (const uint8_t *cell = row; cell < end && (cell = memchr(cell, 0, (size_t)(end - cell)));) {
            size_t x = (size_t)(cell - row) / w->group;
            if (w->project_surface)
                w->project_surface(w->job, &w->projection, (int)(x * size), (int)(y * size), (int)(z * size));
            else
                project_group(&w->projection, (float)(x * size), (float)(y * size), (float)(z * size));
            cell = row + (x + 1) * w->group;
        }
    }
}

/* How index space lies in camera space (from the camera's position), for cubes of w->size voxels. */
static void camera_space(struct work *w, const struct pel_scene *scene)
{
    struct pel_projection *p = &w->projection;
    double basis[3][3], matrix[3][4], from[3], far = 0;
    pel_camera_basis(&scene->camera, basis[0], basis[1], basis[2]);
    pel_volume_matrix(scene->volume, matrix);
    pel_sub(scene->volume->origin, scene->camera.position, from);
    for (int i = 0; i < 3; i++) {
        double origin = pel_dot(basis[i], from), reach = 0;
        far = fmax(far, fabs(origin));
        for (int a = 0; a < 3; a++) {
            double column[3] = { matrix[0][a], matrix[1][a], matrix[2][a] }, axis = pel_dot(basis[i], column);
            p->axis[a][i] = (float)axis;
            reach += fabs(axis) * (w->size * 0.5 + 0.01);
            origin += axis * w->size * 0.5;
            far = fmax(far, fabs(axis) * (double)scene->volume->dims[a]);
        }
        p->origin[i] = (float)origin;
        p->reach[i] = (float)reach;
    }
    for (int i = 0; i < 3; i++)
        p->reach[i] += (float)(far * 1e-6); /* what float loses */
    double half = p->parallel ? scene->camera.parallel_scale : tan(scene->camera.view_angle / 360 * 3.14159265358979323846);
    p->focal[0] = (float)(w->job->height / (2 * half));
    p->focal[1] = -p->focal[0];
    p->middle[0] = (float)(w->job->width - 1) * 0.5f;
    p->middle[1] = (float)(w->job->height - 1) * 0.5f;
}

/* Least and greatest depth of what is visible; along a row of cells only the first and the last count. Where nothing is, a range all the
 * same, before the camera. */
static void depth_range(const struct work *w, float *least, float *most)
{
    const struct pel_job *job = w->job;
    const struct pel_projection *p = &w->projection;
    const float cube = (float)(w->group * PEL_CELL_SIZE), reach = p->reach[2] * cube / (float)w->size;
    float origin = p->origin[2];
    for (int a = 0; a < 3; a++)
        origin += p->axis[a][2] * (cube - (float)w->size) * 0.5f;
    *least = INFINITY;
    *most = -INFINITY;
    for (size_t z = 0; z < w->cells[2]; z++)
        for (size_t y = 0; y < w->cells[1]; y++) {
            const uint8_t *row = job->marks + (z << job->cell_slice_shift) + (y << job->cell_row_shift),
                          *first = memchr(row, 0, w->cells[0]);
            if (!first)
                continue;
            const uint8_t *last = row + w->cells[0] - 1;
            while (*last)
                last--;
            for (int i = 0; i < 2; i++) {
                size_t x = (size_t)((i ? last : first) - row);
                float depth = origin + cube * ((float)(x / w->group) * p->axis[0][2] + (float)(y / w->group) * p->axis[1][2] +
                                               (float)(z / w->group) * p->axis[2][2]);
                *least = fminf(*least, depth - reach);
                *most = fmaxf(*most, depth + reach);
            }
        }
    if (*least > *most)
        *least = 1, *most = 2;
}

/* Pixels a voxel, at the volume's middle. */
static double voxel_pixels(const struct work *w, const struct pel_scene *scene)
{
    double bounds[6], middle[3], right[3], up[3], forward[3];
    pel_volume_bounds(scene->volume, bounds);
    pel_camera_basis(&scene->camera, right, up, forward);
    for (int i = 0; i < 3; i++)
        middle[i] = (bounds[2 * i] + bounds[2 * i + 1]) / 2 - scene->camera.position[i];
    double depth = w->projection.parallel ? 1 : pel_dot(middle, forward);
    return w->projection.focal[0] / depth * pel_volume_least_spacing(scene->volume);
}

static bool reserve(struct pel_spans *spans, size_t words, size_t fold_bytes, struct pel_error *error)
{
    if (spans->fold_bytes != fold_bytes) {
        free(spans->folds);
        spans->fold_bytes = 0;
        spans->folds = pel_alloc(fold_bytes, 1, "span masks", error);
        if (!spans->folds)
            return false;
        spans->fold_bytes = fold_bytes;
    }
    if (spans->words != words) {
        free(spans->masks);
        spans->words = 0;
        spans->masks = pel_alloc_aligned(words, sizeof *spans->masks, "span masks", error);
        if (!spans->masks)
            return false;
        spans->words = words;
    }
    memset(spans->masks, 0, words * sizeof *spans->masks);
    return true;
}

bool pel_spans_build(struct pel_spans *spans, const struct pel_scene *scene, const size_t cells[3], size_t visible_cells,
                     pel_project_surface project_surface, int threads, struct pel_job *job, struct pel_error *error)
{
    job->spans = NULL;
    job->looks = job->skip;
    struct work w = { .job = job, .cells = cells, .group = 1, .project_surface = project_surface, .size = 1 };
    struct pel_projection *p = &w.projection;
    p->parallel = scene->camera.parallel;
    camera_space(&w, scene);
    if (!project_surface || voxel_pixels(&w, scene) < 1) { /* a voxel below a pixel: too many to project singly */
        w.project_surface = NULL;
        w.group = visible_cells > 50000 ? 2 : 1; /* many cells: coarser, so that projecting stays a small part of a frame */
        w.size = (double)(w.group * PEL_CELL_SIZE);
        camera_space(&w, scene);
    }
    float least, most;
    depth_range(&w, &least, &most);
    if (!p->parallel && least <= 1e-3f * (most - least))
        return true;
    const int block = 1 << PEL_SPAN_SHIFT;
    p->blocks[0] = (job->width + block - 1) / block;
    p->blocks[1] = (job->height + block - 1) / block;
    if (!reserve(spans, (size_t)p->blocks[0] * (size_t)p->blocks[1] * PEL_SPAN_WORDS, (size_t)threads * cells[0], error))
        return false;
    w.folds = spans->folds;
    p->masks = (_Atomic uint64_t *)spans->masks;
    p->slab_start = least;
    p->slabs = PEL_SPAN_SLABS / (most - least);
    job->span_lo = least - job->s_base;
    job->span_scale = p->slabs;
    pel_parallel_for(threads, (cells[2] + w.group - 1) / w.group, project_slab, &w);
    job->spans = spans->masks;
    job->span_columns = p->blocks[0];
    job->looks = !w.project_surface;
    return true;
}

void pel_spans_finish(struct pel_spans *spans)
{
    free(spans->masks);
    free(spans->folds);
    memset(spans, 0, sizeof *spans);
}
