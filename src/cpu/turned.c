/* SPDX-License-Identifier: MIT */
#include "turned.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "parallel.h"
#include "shear.h"

static bool reserve(struct pel_turned *t, const struct pel_job *job, struct pel_error *error)
{
    if (t->voxels)
        return true;
    const size_t row = ((size_t)job->dims[1] + PEL_WIDEST - 1) & ~(size_t)(PEL_WIDEST - 1), slices = (size_t)(job->dims[2] < 2 ? 2 : job->dims[2]);
    const size_t voxels = slices * (size_t)job->row * row + 4 * PEL_WIDEST, cells = (size_t)job->cell_dims[0] * (size_t)job->cell_dims[1];
    t->voxels = pel_alloc(voxels, pel_type_size(job->type), "turned voxels", error);
    t->done = t->voxels ? pel_alloc(cells, (size_t)job->cell_dims[2], "turned cells", error) : NULL;
    if (!t->done) {
        pel_turned_finish(t);
        return false;
    }
    t->bytes = voxels * pel_type_size(job->type) + cells * (size_t)job->cell_dims[2];
    t->next_slice = (ptrdiff_t)row;
    t->next_row = (ptrdiff_t)row * job->row;
    return true;
}

struct work {
    struct pel_turned *turned;
    const struct pel_job *job;
    pel_turn_kernel kernel;
    uint8_t *wanted; /* a slab of cells for each thread */
};

/* Cells of a row that may be seen, or that lie beside one: 0 in `to`. */
static void row_beside(const struct pel_job *job, int y, int z, uint8_t *restrict to)
{
    const int n = job->cell_dims[0];
    memset(to, 1, (size_t)n);
    for (int k = z > 0 ? z - 1 : 0; k <= z + 1 && k < job->cell_dims[2]; k++)
        for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < job->cell_dims[1]; j++) {
            const uint8_t *marks = job->marks + ((size_t)k << job->cell_slice_shift) + ((size_t)j << job->cell_row_shift);
            for (int x = 0; x < n; x++)
                to[x] &= marks[x];
        }
    for (int x = 0, before = 1; x < n; x++) {
        const int here = to[x], after = x + 1 < n ? to[x + 1] : 1;
        to[x] = (uint8_t)(before & here & after);
        before = here;
    }
}

static void turn_slab(void *context, size_t slab, int thread)
{
    const struct work *w = context;
    const size_t n = (size_t)w->job->cell_dims[0], rows = (size_t)w->job->cell_dims[1];
    uint8_t *wanted = w->wanted + (size_t)thread * n * rows, *done = w->turned->done + slab * n * rows;
    memset(wanted, 0, n * rows);
    for (size_t y = 0; w->job->skip && y < rows; y++)
        row_beside(w->job, (int)y, (int)slab, wanted + y * n);
    bool any = false;
    for (size_t i = 0; i < n * rows; i++) {
        wanted[i] = !wanted[i] && !done[i];
        done[i] |= wanted[i];
        any |= wanted[i];
    }
    if (any)
        w->kernel(w->job, (int)slab, wanted, w->turned);
}

bool pel_turned_update(struct pel_turned *turned, const struct pel_job *job, pel_turn_kernel kernel, int threads, struct pel_error *error)
{
    const size_t slab = (size_t)job->cell_dims[0] * (size_t)job->cell_dims[1];
    struct work w = { turned, job, kernel, NULL };
    if (!reserve(turned, job, error))
        return false;
    w.wanted = pel_alloc_aligned(slab, (size_t)threads, "cells to turn", error);
    if (!w.wanted)
        return false;
    pel_parallel_for(threads, (size_t)job->cell_dims[2], turn_slab, &w);
    free(w.wanted);
    return true;
}

void pel_turned_finish(struct pel_turned *turned)
{
    free(turned->voxels);
    free(turned->done);
    *turned = (struct pel_turned) { 0 };
}
