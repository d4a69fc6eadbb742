/* SPDX-License-Identifier: MIT */
#include "shear_runs.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "parallel.h"

struct work {
    const struct pel_shear_runs *runs;
    const struct pel_job *job;
    const int *axis;
};

static void fill_layer(void *context, size_t c, int thread)
{
    (void)thread;
    const struct work *w = context;
    const struct pel_job *job = w->job;
    const size_t strides[3] = { 1, (size_t)1 << job->cell_row_shift, (size_t)1 << job->cell_slice_shift };
    const int cells = job->cell_dims[w->axis[0]], rows = job->cell_dims[w->axis[1]];
    const size_t along = strides[w->axis[0]], across = strides[w->axis[1]];
    const uint8_t *layer = job->marks + c * strides[w->axis[2]];
    uint64_t *to = w->runs->bits + c * (size_t)rows * (size_t)w->runs->words;
    for (int j = 0; j < rows; j++, to += w->runs->words)
        for (int word = 0; word < w->runs->words; word++) {
            const int first = word * 64, last = first + 64 < cells ? first + 64 : cells;
            const uint8_t *from = layer + (size_t)j * across + (size_t)first * along;
            uint64_t bits = 0;
            for (int i = 0; i < last - first; i++)
                bits |= (uint64_t)(from[(size_t)i * along] == 0) << i;
            to[word] = bits;
        }
}

bool pel_shear_runs_build(struct pel_shear_runs *runs, const struct pel_job *job, const int axis[3], int threads, struct pel_error *error)
{
    const size_t layers = (size_t)job->cell_dims[axis[2]];
    runs->words = (job->cell_dims[axis[0]] + 63) / 64;
    size_t total = layers * (size_t)job->cell_dims[axis[1]] * (size_t)runs->words;
    if (runs->total != total) {
        free(runs->bits);
        runs->total = 0;
        runs->bits = pel_alloc_aligned(total, sizeof *runs->bits, "runs of visible cells", error);
        if (!runs->bits)
            return false;
        runs->total = total;
    }
    if (!job->skip) {
        memset(runs->bits, 0xff, total * sizeof *runs->bits);
        return true;
    }
    struct work w = { runs, job, axis };
    pel_parallel_for(threads, layers, fill_layer, &w);
    return true;
}

struct patch_work {
    struct pel_shear_runs *runs;
    const struct pel_job *job;
    const int *axis;
    pel_patch_kernel kernel;
};

static void fill_patches(void *context, size_t slab, int thread)
{
    (void)thread;
    const struct patch_work *w = context;
    w->kernel(w->job, w->axis, (int)slab, w->runs->seen, (ptrdiff_t)w->runs->row);
}

bool pel_shear_runs_patches(struct pel_shear_runs *runs, const struct pel_job *job, pel_patch_kernel kernel, const int axis[3], int threads,
                            struct pel_error *error)
{
    const size_t rows = (size_t)job->dims[axis[1]] * (size_t)job->dims[axis[2]];
    runs->row = ((size_t)job->dims[axis[0]] + 63) / 64 * 8;
    const size_t bytes = rows * runs->row + sizeof(uint64_t);
    if (runs->seen_bytes != bytes) {
        free(runs->seen);
        runs->seen_bytes = 0;
        runs->seen = pel_alloc_aligned(bytes, 1, "runs of visible voxels", error);
        if (!runs->seen)
            return false;
        runs->seen_bytes = bytes;
    }
    memset(runs->seen, 0, bytes);
    struct patch_work w = { runs, job, axis, kernel };
    pel_parallel_for(threads, (size_t)job->cell_dims[2], fill_patches, &w);
    return true;
}

void pel_shear_runs_finish(struct pel_shear_runs *runs)
{
    free(runs->seen);
    free(runs->bits);
    memset(runs, 0, sizeof *runs);
}
