/* SPDX-License-Identifier: MIT */
#include "shear_warp.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "encode.h"
#include "fail.h"
#include "parallel.h"
#include "rays.h"
#include "shear_runs.h"
#include "timer.h"
#include "turned.h"
#include "voxels.h"

#define COUNTS_APART 4

#define BAND PEL_SHEAR_BAND

/* One principal axis' share of the picture; in most views there is one. */
struct part {
    struct pel_shear shear;
    struct pel_warp warp;
    double weight; /* blended: of its picture */
};

struct pel_shear_warp {
    int threads;
    const char *isa;
    const struct pel_kernels *kernels[PEL_KERNEL_KINDS];
    struct pel_voxels voxels;
    struct pel_classification_state state;
    struct pel_shear_runs runs[3]; /* by principal axis */
    bool has_runs[3], has_rows[3];
    bool skip; /* what the runs were made for */
    struct pel_job job;
    struct pel_shear_settings settings;
    struct part parts[PEL_SHEAR_PARTS];
    int part_count;
    bool blended; /* each part draws the whole picture, and these are mixed */
    float *layer; /* owned; the picture of a part that is to be mixed in */
    size_t layer_room;
    float *alpha; /* owned; opacity of one slice along a ray, in parallel projection */
    size_t alpha_entries;
    float alpha_length; /* what it was made for; 0: nothing */
    bool alpha_linear;
    struct pel_slice *slices; /* owned */
    size_t slice_room;
    float *image; /* owned; the intermediate image: colours, and depth behind them */
    size_t image_room;
    int *rows; /* owned; first and end of each row's pixels that hold something */
    size_t row_room;
    float *line_memory; /* owned; a scanline a thread */
    size_t line_room;
    struct pel_turned turned;
};

struct pel_shear_warp *pel_shear_warp_create(int threads, const char *isa, struct pel_error *error)
{
    struct pel_shear_warp *sw = pel_alloc(1, sizeof *sw, "shear-warp", error);
    if (!sw)
        return NULL;
    sw->threads = pel_threads(threads);
    if (!pel_kernels_find(isa, sw->kernels, &sw->isa, error)) {
        free(sw);
        return NULL;
    }
    return sw;
}

void pel_shear_warp_destroy(struct pel_shear_warp *sw)
{
    if (!sw)
        return;
    pel_voxels_finish(&sw->voxels);
    pel_classify_finish(&sw->state);
    for (int a = 0; a < 3; a++)
        pel_shear_runs_finish(&sw->runs[a]);
    free(sw->alpha);
    free(sw->slices);
    free(sw->image);
    free(sw->rows);
    free(sw->line_memory);
    free(sw->layer);
    pel_turned_finish(&sw->turned);
    free(sw);
}

const char *pel_shear_warp_isa(const struct pel_shear_warp *sw)
{
    return sw->isa;
}

bool pel_shear_warp_set_volume(struct pel_shear_warp *sw, const struct pel_volume *volume, struct pel_error *error)
{
    pel_turned_finish(&sw->turned);
    return pel_voxels_set(&sw->voxels, volume, sw->threads, &sw->job, error);
}

bool pel_shear_warp_classify(struct pel_shear_warp *sw, const struct pel_scene *scene, struct pel_error *error)
{
    memset(sw->has_runs, 0, sizeof sw->has_runs);
    memset(sw->has_rows, 0, sizeof sw->has_rows);
    sw->alpha_length = 0;
    return pel_classify(&sw->state, scene, &sw->voxels.minmax, sw->voxels.raw, sw->threads, &sw->job, error);
}

bool pel_shear_warp_set_step(struct pel_shear_warp *sw, const struct pel_scene *scene, struct pel_error *error)
{
    sw->alpha_length = 0;
    return pel_classify_tables(&sw->state, scene, sw->voxels.raw, &sw->job, error);
}

/* Gives an array room for `count` items; what it held is lost. */
static bool reserve(void **array, size_t *room, size_t count, size_t size, const char *what, struct pel_error *error)
{
    if (*room >= count)
        return true;
    free(*array);
    *room = 0;
    *array = pel_alloc_aligned(count, size, what, error);
    if (!*array)
        return false;
    *room = count;
    return true;
}

/* Exact correction of opacity for the distance between slices along the rays: alpha = 1 - exp(-tau length); or the paper's approximation,
 * opacity times length. */
static bool fill_alpha(struct pel_shear_warp *sw, float length, bool linear, struct pel_error *error)
{
    const size_t count = sw->state.table.count;
    if (sw->alpha_length == length && sw->alpha_linear == linear)
        return true;
    if (!reserve((void **)&sw->alpha, &sw->alpha_entries, count, sizeof *sw->alpha, "look-up table", error))
        return false;
    const float units = length * sw->job.step_over_unit;
    for (size_t i = 0; i < count; i++) {
        float opacity = sw->job.opacity[i];
        sw->alpha[i] = linear ? fminf(opacity * units, 1) : opacity >= 1 ? 1 : -expm1f(-sw->state.tau[i] * length);
    }
    sw->alpha_length = length;
    sw->alpha_linear = linear;
    return true;
}

bool pel_shear_warp_aim(struct pel_shear_warp *sw, const struct pel_scene *scene, const struct pel_shear_settings *settings, bool linear,
                        int width, int height, struct pel_error *error)
{
    struct pel_job *job = &sw->job;
    const bool perspective = !scene->camera.parallel;
    int which[PEL_SHEAR_PARTS];
    double weights[PEL_SHEAR_PARTS];
    bool split;
    pel_rays_setup(job, scene, 0, width, height);
    job->skip = scene->render.skip && sw->state.map_bytes > 0;
    if (job->skip != sw->skip) {
        memset(sw->has_runs, 0, sizeof sw->has_runs);
        memset(sw->has_rows, 0, sizeof sw->has_rows);
    }
    sw->skip = job->skip;
    sw->settings = *settings;
    sw->part_count = pel_shear_parts_blended(job, perspective, settings->blend, which, weights, &split);
    sw->blended = sw->part_count > 1 && !split;
    for (int i = 0; i < sw->part_count; i++) {
        struct pel_shear *s = &sw->parts[i].shear;
        if (!pel_shear_factor(job, perspective, settings, which[i], split, s, &sw->parts[i].warp, error))
            return false;
        s->linear = linear;
        sw->parts[i].weight = weights[i];
        const int c = which[i] / 2;
        if (!sw->has_runs[c] && s->slice_count && !pel_shear_runs_build(&sw->runs[c], job, s->axis, sw->threads, error))
            return false;
        sw->has_runs[c] |= s->slice_count > 0;
        s->runs = sw->runs[c].bits;
        s->run_words = sw->runs[c].words;
    }
    return true;
}

struct drawing {
    struct pel_shear_warp *sw;
    const struct part *part;
    pel_shear_kernel kernel;
    pel_warp_kernel warp;             /* NULL: the part shows nothing */
    struct pel_scanline *lines; /* one a thread */
    struct pel_counts *counts;
    const struct pel_progress *progress;
    bool first; /* of the picture's parts */
    size_t items;
    atomic_size_t done;
    atomic_bool cancelled;
    struct pel_error *error;
};

static size_t bands_of(int rows)
{
    return ((size_t)rows + BAND - 1) / BAND;
}

static void composite_band(void *context, size_t band, int thread)
{
    struct drawing *d = context;
    if (atomic_load_explicit(&d->cancelled, memory_order_relaxed))
        return;
    const int v0 = (int)band * BAND, height = d->part->shear.height;
    d->kernel(&d->sw->job, &d->part->shear, v0, v0 + BAND < height ? v0 + BAND : height, &d->lines[thread],
              &d->counts[thread * COUNTS_APART]);
    size_t done = atomic_fetch_add(&d->done, 1) + 1;
    if (thread == 0 && !pel_progress_report(d->progress, (double)done / (double)d->items, d->error))
        atomic_store(&d->cancelled, true);
}

static void clear_rows(const struct drawing *d, size_t first, size_t end)
{
    const struct pel_job *job = &d->sw->job;
    const size_t width = (size_t)job->width;
    if (d->first && !d->warp) /* else the warp clears what it does not draw */
        memset(job->rgba + first * width * 4, 0, (end - first) * width * 4 * sizeof(float));
    for (size_t i = first * width; d->first && job->depth && i < end * width; i++)
        job->depth[i] = INFINITY;
}

static void warp_rows(void *context, size_t band, int thread)
{
    (void)thread;
    struct drawing *d = context;
    const struct pel_job *job = &d->sw->job;
    const size_t height = (size_t)job->height, first = band * BAND, end = first + BAND < height ? first + BAND : height;
    clear_rows(d, first, end);
    for (size_t y = first; d->warp && y < end; y++)
        d->warp(job, &d->part->shear, &d->part->warp, (int)y);
}

/* Cuts a thread's memory into a scanline's arrays. */
static void line_init(struct pel_scanline *line, float *at, size_t padded)
{
    float **arrays[PEL_SCANLINE_ARRAYS] = { &line->color[0],  &line->color[1],  &line->color[2], &line->alpha,
                                            &line->depth,     &line->from,      &line->to,       &line->length,
                                            &line->toward[0], &line->toward[1], &line->toward[2] };
    for (int i = 0; i < PEL_SCANLINE_ARRAYS; i++, at += padded)
        *arrays[i] = at;
    line->open = (uint32_t *)at;
}

static bool prepare_lines(struct pel_shear_warp *sw, const struct pel_shear *s, struct pel_scanline *lines, struct pel_error *error)
{
    const size_t padded = ((size_t)s->width + 3 * PEL_WIDEST - 1) & ~(size_t)(PEL_WIDEST - 1), each = padded * (PEL_SCANLINE_ARRAYS + 1);
    if (!reserve((void **)&sw->line_memory, &sw->line_room, each * (size_t)sw->threads, sizeof(float), "scanlines", error))
        return false;
    for (size_t i = 0; i < (size_t)sw->threads; i++)
        line_init(&lines[i], sw->line_memory + i * each, padded);
    return true;
}

/* Voxels as rows along scanlines, and the patches of them that may be seen: made anew after a classification, when first asked for. */
static bool prepare_rows(struct pel_shear_warp *sw, struct pel_shear *s, struct pel_error *error)
{
    const struct pel_kernels *kernels = sw->kernels[sw->voxels.kind];
    const int c = s->axis[2], strides[3] = { 1, sw->job.row, sw->job.slice };
    struct pel_shear_runs *runs = &sw->runs[c];
    if (!sw->has_rows[c]) {
        if (c == 0 && !pel_turned_update(&sw->turned, &sw->job, kernels->turn, sw->threads, NULL)) {
            s->near = false; /* a volume too large to turn: its voxels are gathered */
            return true;
        }
        if (sw->job.skip && !pel_shear_runs_patches(runs, &sw->job, kernels->patches, s->axis, sw->threads, error))
            return false;
        sw->has_rows[c] = true;
    }
    s->rows = c == 0 ? sw->turned.voxels : sw->job.data;
    s->next_row = c == 0 ? sw->turned.next_row : strides[s->axis[1]];
    s->next_slice = c == 0 ? sw->turned.next_slice : strides[c];
    s->seen = sw->job.skip ? runs->seen : NULL;
    s->seen_row = (ptrdiff_t)runs->row;
    return true;
}

/* Room for a part's slices, intermediate image and scanlines. */
static bool prepare_part(struct pel_shear_warp *sw, struct part *part, struct pel_scanline *lines, struct pel_error *error)
{
    struct pel_shear *s = &part->shear;
    /* Kernels fetch vectors whole where there are voxels for them, and no voids to look out for. */
    s->near = s->unit && !sw->job.voids && !sw->job.nearest && sw->voxels.kind != PEL_KERNEL_WIDE && sw->job.dims[s->axis[0]] >= 2 * PEL_WIDEST;
    const size_t stride = (size_t)s->width + 2 + 2 * PEL_WIDEST, pixels = stride * ((size_t)s->height + 2);
    if (!reserve((void **)&sw->slices, &sw->slice_room, (size_t)s->slice_count, sizeof *sw->slices, "slices", error) ||
        !reserve((void **)&sw->image, &sw->image_room, pixels * (sw->job.depth ? 5 : 4), sizeof(float), "intermediate image", error) ||
        !reserve((void **)&sw->rows, &sw->row_room, 2 * ((size_t)s->height + 2), sizeof(int), "intermediate image", error) ||
        !prepare_lines(sw, s, lines, error) || (s->near && !prepare_rows(sw, s, error)))
        return false;
    pel_shear_slices(&sw->job, &sw->settings, s, sw->slices);
    s->slices = sw->slices;
    s->rgba = sw->image;
    s->depth = sw->job.depth ? sw->image + pixels * 4 : NULL;
    s->stride = (int)stride;
    s->row_from = sw->rows;
    s->row_to = sw->rows + s->height + 2;
    for (int row = 0; row < 2; row++) { /* the border above and below */
        size_t at = row ? (size_t)s->height + 1 : 0;
        memset(s->rgba + at * stride * 4, 0, stride * 4 * sizeof(float));
        for (size_t u = 0; s->depth && u < stride; u++)
            s->depth[at * stride + u] = -1;
        s->row_from[at] = s->row_to[at] = 0;
    }
    if (!s->perspective) {
        if (!fill_alpha(sw, s->length, s->linear, error))
            return false;
        sw->job.alpha = sw->alpha;
    }
    return true;
}

static bool draw_part(struct drawing *d, struct part *part, double stage_ms[2], struct pel_error *error)
{
    struct pel_shear_warp *sw = d->sw;
    double start = pel_now_ms();
    d->part = part;
    if (part->shear.slice_count && !prepare_part(sw, part, d->lines, error))
        return false;
    if (part->shear.slice_count)
        pel_parallel_for(sw->threads, bands_of(part->shear.height), composite_band, d);
    double middle = pel_now_ms();
    d->warp = part->shear.slice_count ? sw->kernels[0]->warp : NULL;
    if (d->warp)
        pel_warp_bound(&part->warp, &part->shear);
    if (part->warp.split && d->first) { /* parts leave each other's pixels alone */
        d->warp = NULL;
        pel_parallel_for(sw->threads, bands_of(sw->job.height), warp_rows, d);
        d->first = false;
        d->warp = part->shear.slice_count ? sw->kernels[0]->warp : NULL;
    }
    pel_parallel_for(sw->threads, bands_of(sw->job.height), warp_rows, d);
    d->first = false;
    stage_ms[0] += middle - start;
    stage_ms[1] += pel_now_ms() - middle;
    return true;
}

struct mixing {
    const struct pel_job *job;
    float *picture;
    const float *layer;
    float kept, added; /* weights */
};

static void mix_rows(void *context, size_t band, int thread)
{
    (void)thread;
    const struct mixing *m = context;
    const size_t row = (size_t)m->job->width * 4, height = (size_t)m->job->height, first = band * BAND;
    const size_t end = first + BAND < height ? first + BAND : height;
    for (size_t i = first * row; i < end * row; i++)
        m->picture[i] = m->kept * m->picture[i] + m->added * m->layer[i];
}

/* Draws the other axes' pictures each by itself and mixes them into the main one's, which is there. Depth stays the main one's. */
static bool blend_parts(struct drawing *d, struct pel_image *image, double stage_ms[2], struct pel_error *error)
{
    struct pel_shear_warp *sw = d->sw;
    struct pel_job *job = &sw->job;
    struct mixing m = { .job = job, .picture = image->rgba, .kept = (float)sw->parts[0].weight };
    if (!reserve((void **)&sw->layer, &sw->layer_room, (size_t)job->width * (size_t)job->height * 4, sizeof(float), "picture", error))
        return false;
    bool ok = true;
    job->rgba = sw->layer;
    job->depth = NULL;
    for (int i = 1; ok && i < sw->part_count; i++) {
        d->first = true;
        ok = draw_part(d, &sw->parts[i], stage_ms, error);
        m.layer = sw->layer, m.added = (float)sw->parts[i].weight;
        pel_parallel_for(sw->threads, bands_of(job->height), mix_rows, &m);
        m.kept = 1;
    }
    job->rgba = image->rgba;
    job->depth = image->depth;
    return ok;
}

static void count(const struct pel_shear_warp *sw, const struct drawing *d, struct pel_shear_counters *counters)
{
    const size_t *cells = sw->voxels.minmax.cells.dims;
    memset(counters, 0, sizeof *counters);
    for (int i = 0; i < sw->threads; i++) {
        counters->in_box += d->counts[i * COUNTS_APART].in_box;
        counters->taken += d->counts[i * COUNTS_APART].taken;
    }
    for (int i = 0; i < sw->part_count; i++) {
        counters->rays += (uint64_t)sw->parts[i].shear.width * (uint64_t)sw->parts[i].shear.height;
        counters->slices += (uint64_t)sw->parts[i].shear.slice_count;
    }
    counters->cells = cells[0] * cells[1] * cells[2];
    counters->visible_cells = sw->state.visible_cells;
    counters->bytes = pel_voxels_bytes(&sw->voxels, &sw->job) + pel_classify_bytes(&sw->state) + sw->slice_room * sizeof *sw->slices +
                      (sw->alpha_entries + sw->image_room + sw->line_room + sw->layer_room) * sizeof(float) +
                      sw->row_room * sizeof(int) + sw->turned.bytes;
    for (int a = 0; a < 3; a++)
        counters->bytes += sw->runs[a].total * sizeof *sw->runs[a].bits + sw->runs[a].seen_bytes;
}

bool pel_shear_warp_draw(struct pel_shear_warp *sw, const struct pel_scene *scene, const struct pel_progress *progress,
                         struct pel_image *image, struct pel_shear_counters *counters, double stage_ms[2], struct pel_error *error)
{
    struct pel_job *job = &sw->job;
    job->rgba = image->rgba;
    job->depth = image->depth;
    const struct pel_kernels *k = sw->kernels[sw->voxels.kind];
    struct drawing d = { .sw = sw, .kernel = job->shade ? k->shear_shaded : k->shear, .progress = progress, .first = true, .error = error };
    d.counts = pel_alloc((size_t)sw->threads * COUNTS_APART, sizeof *d.counts, "counters", error);
    d.lines = pel_alloc((size_t)sw->threads, sizeof *d.lines, "scanlines", error);
    bool ok = d.counts && d.lines;
    for (int i = 0; i < sw->part_count; i++)
        d.items += bands_of(sw->parts[i].shear.height);
    stage_ms[0] = stage_ms[1] = 0;
    for (int i = 0; ok && i < (sw->blended ? 1 : sw->part_count); i++)
        ok = draw_part(&d, &sw->parts[i], stage_ms, error);
    if (sw->blended)
        ok = ok && blend_parts(&d, image, stage_ms, error);
    if (ok && scene->linear_light)
        pel_encode_picture(job, sw->threads);
    if (ok)
        count(sw, &d, counters);
    free(d.counts);
    free(d.lines);
    return ok && !atomic_load(&d.cancelled);
}
