/* SPDX-License-Identifier: MIT */
#include "raycast.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "classify.h"
#include "fail.h"
#include "kernel.h"
#include "minmax.h"
#include "parallel.h"
#include "rays.h"
#include "spans.h"

#define TILE_SIZE 32

struct pel_raycaster {
    int threads;
    const char *isa;
    const struct pel_kernels *kernels[PEL_KERNEL_KINDS];
    const struct pel_volume *volume; /* borrowed */
    void *padded;                    /* owned copy of a volume too thin to fetch from, or NULL */
    struct pel_minmax minmax;
    struct pel_classification_state state;
    struct pel_spans spans;
    struct pel_raw_scale raw;
    enum pel_kernel_kind kind;
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

static void forget_volume(struct pel_raycaster *rc)
{
    pel_minmax_finish(&rc->minmax);
    free(rc->padded);
    rc->padded = NULL;
    rc->volume = NULL;
}

void pel_raycaster_destroy(struct pel_raycaster *rc)
{
    if (!rc)
        return;
    forget_volume(rc);
    pel_classify_finish(&rc->state);
    pel_spans_finish(&rc->spans);
    free(rc);
}

const char *pel_raycaster_isa(const struct pel_raycaster *rc)
{
    return rc->isa;
}

/* A trilinear cell needs two voxels along each axis, and a 32-bit fetch of bytes four along x: thinner volumes get their last voxel again.
 */
static bool pad(struct pel_raycaster *rc, struct pel_error *error)
{
    const struct pel_volume *v = rc->volume;
    size_t least[3] = { 4, 2, 2 }, dims[3], size = pel_type_size(v->type);
    for (int a = 0; a < 3; a++)
        dims[a] = v->dims[a] < least[a] ? least[a] : v->dims[a];
    rc->job.row = (int32_t)dims[0];
    rc->job.slice = (int32_t)(dims[0] * dims[1]);
    rc->job.data = v->data;
    if (!memcmp(dims, v->dims, sizeof dims))
        return true;
    rc->padded = pel_alloc(dims[0] * dims[1] * dims[2], size, "thin volume", error);
    if (!rc->padded)
        return false;
    char *to = rc->padded;
    for (size_t z = 0; z < dims[2]; z++)
        for (size_t y = 0; y < dims[1]; y++)
            for (size_t x = 0; x < dims[0]; x++, to += size) {
                size_t from[3] = { x < v->dims[0] ? x : v->dims[0] - 1, y < v->dims[1] ? y : v->dims[1] - 1,
                                   z < v->dims[2] ? z : v->dims[2] - 1 };
                memcpy(to, (const char *)v->data + ((from[2] * v->dims[1] + from[1]) * v->dims[0] + from[0]) * size, size);
            }
    rc->job.data = rc->padded;
    return true;
}

/* Which kernel fetches this type, and how its raw values lie on the data's (kernel.h). */
static void describe_voxels(struct pel_raycaster *rc)
{
    const struct pel_volume *v = rc->volume;
    struct pel_job *job = &rc->job;
    double lo = v->range[0], hi = v->range[1], half = hi / 2 - lo / 2; /* hi - lo could overflow */
    static const enum pel_kernel_kind kinds[PEL_TYPE_COUNT] = {
        [PEL_U8] = PEL_KERNEL_U8,     [PEL_I8] = PEL_KERNEL_U8,     [PEL_U16] = PEL_KERNEL_U16,   [PEL_I16] = PEL_KERNEL_U16,
        [PEL_U32] = PEL_KERNEL_WIDE,  [PEL_I32] = PEL_KERNEL_WIDE,  [PEL_F32] = PEL_KERNEL_F32,   [PEL_F64] = PEL_KERNEL_WIDE,
    };
    rc->kind = kinds[v->type];
    job->type = v->type;
    job->flip = v->type == PEL_I8 ? (int32_t)0x80808080 : v->type == PEL_U16 ? (int32_t)0x80008000 : 0;
    rc->raw = (struct pel_raw_scale){ 1.0 / 16384, v->type == PEL_I8 ? -128 : v->type == PEL_U16 ? 32768 : 0 };
    if (rc->kind == PEL_KERNEL_F32)
        rc->raw = (struct pel_raw_scale){ 1, 0 };
    if (rc->kind == PEL_KERNEL_WIDE) {
        bool flat = !(half > 0) || !isfinite(half);
        rc->raw = (struct pel_raw_scale){ flat ? 1 : 2 * half, isfinite(lo) ? lo : 0 };
        if (isinf(rc->raw.scale))
            rc->raw.scale = 1.7e308;
        job->wide_offset = rc->raw.offset;
        job->wide_scale = 1 / rc->raw.scale;
    }
    double range = (hi - lo) / rc->raw.scale;
    job->gradient_scale = range > 0 && isfinite(range) ? (float)fmin(1 / range, 1e30) : 1;
    job->voids = rc->minmax.has_voids;
    bool by_value = rc->minmax.has_voids && v->has_void && !isnan(v->void_value);
    job->wide_void = by_value && rc->kind == PEL_KERNEL_WIDE;
    job->has_void_value = by_value && rc->kind != PEL_KERNEL_WIDE;
    job->void_value = v->void_value;
    job->void_raw = (float)((v->void_value - rc->raw.offset) / rc->raw.scale);
    for (int a = 0; a < 3; a++) {
        job->dims[a] = (int32_t)v->dims[a];
        job->last_cell[a] = v->dims[a] > 2 ? (int32_t)v->dims[a] - 2 : 0;
    }
}

bool pel_raycaster_set_volume(struct pel_raycaster *rc, const struct pel_volume *volume, struct pel_error *error)
{
    forget_volume(rc);
    size_t padded = 1;
    for (int a = 0; a < 3; a++)
        if (!pel_mul(padded, volume->dims[a] < 4 ? 4 : volume->dims[a], &padded) || padded > INT32_MAX)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                            "%zu x %zu x %zu voxels: the ray caster takes up to 2^31 - 1; crop or downsample the volume", volume->dims[0],
                            volume->dims[1], volume->dims[2]);
    rc->volume = volume;
    if (!pel_minmax_init(&rc->minmax, volume, rc->threads, error) || !pad(rc, error)) {
        forget_volume(rc);
        return false;
    }
    describe_voxels(rc);
    return true;
}

bool pel_raycaster_classify(struct pel_raycaster *rc, const struct pel_scene *scene, struct pel_error *error)
{
    return pel_classify(&rc->state, scene, &rc->minmax, rc->raw, rc->threads, &rc->job, error);
}

bool pel_raycaster_set_step(struct pel_raycaster *rc, const struct pel_scene *scene, struct pel_error *error)
{
    return pel_classify_tables(&rc->state, scene, rc->raw, &rc->job, error);
}

static pel_kernel choose_kernel(const struct pel_raycaster *rc)
{
    const struct pel_kernels *k = rc->kernels[rc->kind];
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
        return k->isosurface;
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

static float to_display(float c)
{
    return c <= 0.0031308f ? c * 12.92f : 1.055f * powf(c, 1 / 2.4f) - 0.055f;
}

/* Linear light back to display values: the colour without its opacity is encoded. */
static void encode_row(void *context, size_t y, int thread)
{
    (void)thread;
    const struct pel_job *job = context;
    for (int x = 0; x < job->width; x++) {
        float *p = job->rgba + (y * (size_t)job->width + (size_t)x) * 4;
        for (int c = 0; c < 3 && p[3] > 0; c++)
            p[c] = to_display(p[c] / p[3]) * p[3];
    }
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
    return pel_spans_build(&rc->spans, scene, rc->minmax.cells.dims, rc->state.visible_cells,
                           surface ? rc->kernels[rc->kind]->project_surface : NULL, rc->threads, job, error) &&
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
        pel_parallel_for(rc->threads, (size_t)image->height, encode_row, job);
    size_t blocks = rc->minmax.blocks.dims[0] * rc->minmax.blocks.dims[1] * rc->minmax.blocks.dims[2];
    size_t cells = rc->minmax.cells.dims[0] * rc->minmax.cells.dims[1] * rc->minmax.cells.dims[2];
    counters->cells = cells;
    counters->visible_cells = rc->state.visible_cells;
    counters->bytes = (cells + blocks) * 2 * sizeof(float) + rc->state.map_bytes * (size_t)(1 + __builtin_popcount(rc->state.octants)) +
                      rc->state.array_entries * 12 * sizeof(float) + (rc->state.bounds ? (cells + blocks) * sizeof(float) : 0) +
                      rc->spans.words * sizeof *rc->spans.masks + rc->spans.fold_bytes + rc->state.table.count * 4 * sizeof(float) +
                      rc->state.table.range.count * (size_t)rc->state.table.range.levels * 2 * sizeof(float) +
                      (rc->padded ? (size_t)job->slice * (size_t)(job->dims[2] < 2 ? 2 : job->dims[2]) * pel_type_size(job->type) : 0);
    return !atomic_load(&d.cancelled);
}
