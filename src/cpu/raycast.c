/* SPDX-License-Identifier: MIT */
#include "raycast.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "classify.h"
#include "encode.h"
#include "fail.h"
#include "kernel.h"
#include "parallel.h"
#include "rays.h"
#include "spans.h"
#include "voxels.h"

#define TILE_SIZE 32

struct pel_raycaster {
    int threads;
    const char *isa;
    const struct pel_kernels *kernels[PEL_KERNEL_KINDS];
    struct pel_voxels voxels;
    struct pel_classification_state state;
    struct pel_spans spans;
    struct pel_job job;
};

struct pel_raycaster *pel_raycaster_create(int threads, const char *isa, struct pel_error *error)
{
    struct pel_raycaster *rc = pel_alloc(1, sizeof *rc, "ray caster", error);
    if (!rc)
        return NULL;
    rc->threads = pel_threads(threads);
    if (!pel_kernels_find(isa, rc->kernels, &rc->isa, error)) {
        free(rc);
        return NULL;
    }
    return rc;
}

void pel_raycaster_destroy(struct pel_raycaster *rc)
{
    if (!rc)
        return;
    pel_voxels_finish(&rc->voxels);
    pel_classify_finish(&rc->state);
    pel_spans_finish(&rc->spans);
    free(rc);
}

const char *pel_raycaster_isa(const struct pel_raycaster *rc)
{
    return rc->isa;
}

bool pel_raycaster_set_volume(struct pel_raycaster *rc, const struct pel_volume *volume, struct pel_error *error)
{
    return pel_voxels_set(&rc->voxels, volume, rc->threads, &rc->job, error);
}

bool pel_raycaster_classify(struct pel_raycaster *rc, const struct pel_scene *scene, struct pel_error *error)
{
    return pel_classify(&rc->state, scene, &rc->voxels.minmax, rc->voxels.raw, rc->threads, &rc->job, error);
}

bool pel_raycaster_set_step(struct pel_raycaster *rc, const struct pel_scene *scene, struct pel_error *error)
{
    return pel_classify_tables(&rc->state, scene, rc->voxels.raw, &rc->job, error);
}

static pel_kernel choose_kernel(const struct pel_raycaster *rc)
{
    const struct pel_kernels *k = rc->kernels[rc->voxels.kind];
    const struct pel_job *job = &rc->job;
    switch (job->mode) {
    case PEL_MODE_COMPOSITE:
        if (job->nearest)
            return k->composite_general;
        if (job->classification == PEL_CLASSIFICATION_PREINTEGRATED)
            return k->preintegrated;
        if (job->classification == PEL_CLASSIFICATION_PRE)
            return k->composite_general;
        return job->shade ? k->composite_shaded : k->composite;
    case PEL_MODE_ISOSURFACE:
        return job->roots == PEL_ROOTS_CUBIC ? k->isosurface : k->isosurface_steps;
    case PEL_MODE_SLICE:
        return k->slice;
    default:
        return k->projection;
    }
}

struct drawing {
    const struct pel_job *job;
    pel_kernel kernel;
    int columns;
    struct pel_counts *counts; /* one a thread, a cache line apart */
    const struct pel_progress *progress;
    size_t tiles;
    atomic_size_t done;
    atomic_bool cancelled;
    struct pel_error *error;
};

#define COUNTS_APART 4

static void draw_tile(void *context, size_t tile, int thread)
{
    struct drawing *d = context;
    if (atomic_load_explicit(&d->cancelled, memory_order_relaxed))
        return;
    int x0 = (int)(tile % (size_t)d->columns) * TILE_SIZE, y0 = (int)(tile / (size_t)d->columns) * TILE_SIZE;
    int x1 = x0 + TILE_SIZE < d->job->width ? x0 + TILE_SIZE : d->job->width,
        y1 = y0 + TILE_SIZE < d->job->height ? y0 + TILE_SIZE : d->job->height;
    d->kernel(d->job, x0, y0, x1, y1, &d->counts[thread * COUNTS_APART]);
    size_t done = atomic_fetch_add(&d->done, 1) + 1;
    if (thread == 0 && !pel_progress_report(d->progress, (double)done / (double)d->tiles, d->error))
        atomic_store(&d->cancelled, true);
}

bool pel_raycaster_aim(struct pel_raycaster *rc, const struct pel_scene *scene, int jitter, int width, int height, struct pel_error *error)
{
    struct pel_job *job = &rc->job;
    pel_rays_setup(job, scene, jitter, width, height);
    job->skip &= !pel_mode_has_map(job->mode) || rc->state.map_bytes > 0;
    job->spans = NULL;
    job->looks = false;
    if (!pel_mode_has_map(job->mode) || !job->skip)
        return true;
    bool surface = job->mode == PEL_MODE_ISOSURFACE && !job->voids;
    return pel_spans_build(&rc->spans, scene, rc->voxels.minmax.cells.dims, rc->state.visible_cells,
                           surface ? rc->kernels[rc->voxels.kind]->project_surface : NULL, rc->threads, job, error) &&
           (!job->looks || pel_classify_octants(&rc->state, pel_rays_octants(job), rc->threads, error));
}

bool pel_raycaster_draw(struct pel_raycaster *rc, const struct pel_scene *scene, const struct pel_progress *progress,
                        struct pel_image *image, struct pel_raycast_counters *counters, struct pel_error *error)
{
    struct pel_job *job = &rc->job;
    job->rgba = image->rgba;
    job->depth = image->depth;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    memset(image->rgba, 0, pixels * 4 * sizeof *image->rgba);
    for (size_t i = 0; image->depth && i < pixels; i++)
        image->depth[i] = INFINITY;

    int columns = (image->width + TILE_SIZE - 1) / TILE_SIZE, rows = (image->height + TILE_SIZE - 1) / TILE_SIZE;
    struct drawing d = { .job = job, .kernel = choose_kernel(rc), .columns = columns, .progress = progress, .error = error };
    d.tiles = (size_t)columns * (size_t)rows;
    d.counts = pel_alloc((size_t)rc->threads * COUNTS_APART, sizeof *d.counts, "counters", error);
    if (!d.counts)
        return false;
    pel_parallel_for(rc->threads, d.tiles, draw_tile, &d);
    memset(counters, 0, sizeof *counters);
    for (int i = 0; i < rc->threads; i++) {
        counters->in_box += d.counts[i * COUNTS_APART].in_box;
        counters->taken += d.counts[i * COUNTS_APART].taken;
        counters->culled += d.counts[i * COUNTS_APART].culled;
    }
    free(d.counts);
    if (scene->linear_light && job->mode != PEL_MODE_XRAY)
        pel_encode_picture(job, rc->threads);
    const size_t *cells = rc->voxels.minmax.cells.dims;
    counters->cells = cells[0] * cells[1] * cells[2];
    counters->visible_cells = rc->state.visible_cells;
    counters->bytes = pel_voxels_bytes(&rc->voxels, job) + pel_classify_bytes(&rc->state) + rc->spans.words * sizeof *rc->spans.masks +
                      rc->spans.fold_bytes;
    return !atomic_load(&d.cancelled);
}
