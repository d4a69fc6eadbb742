/* SPDX-License-Identifier: MIT */
#include "refine.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "parallel.h"

#define REFINED_STEP 0.5 /* voxels: as the picture's yardstick (docs/optics.md) */

void pel_refine_restart(struct pel_refinement *f)
{
    f->begun = false;
}

void pel_refine_finish(struct pel_refinement *f)
{
    free(f->sum);
    free(f->depth);
    *f = (struct pel_refinement){ 0 };
}

static size_t pixels_of(const struct pel_image *image)
{
    return (size_t)image->width * (size_t)image->height;
}

bool pel_refine_continues(const struct pel_refinement *f, size_t technique, const struct pel_image *image)
{
    return f->begun && f->technique == technique && (f->depth || !image->depth);
}

void pel_refine_settings(struct pel_render_settings *settings)
{
    settings->step = fmin(settings->step, REFINED_STEP);
    settings->jitter = true;
}

bool pel_refine_begin(struct pel_refinement *f, size_t technique, int wanted, const struct pel_image *image, struct pel_error *error)
{
    size_t pixels = pixels_of(image);
    if (pixels != f->pixels)
        pel_refine_finish(f);
    f->begun = false;
    f->technique = technique;
    f->wanted = wanted;
    f->frames = 0;
    f->still = f->moved = false;
    f->pixels = pixels;
    if (!image->depth) {
        free(f->depth);
        f->depth = NULL;
    } else if (!f->depth && !(f->depth = pel_alloc_aligned(pixels, sizeof *f->depth, "refined picture's depth", error))) {
        return false;
    }
    if (f->depth)
        memcpy(f->depth, image->depth, pixels * sizeof *f->depth);
    return f->begun = true;
}

bool pel_refine_reserve(struct pel_refinement *f, struct pel_error *error)
{
    return f->sum || (f->sum = pel_alloc_aligned(f->pixels, 4 * sizeof *f->sum, "refined picture", error));
}

struct rows {
    struct pel_refinement *refinement;
    struct pel_image *image;
    atomic_bool moved; /* some pixel differs from those of the first refined frames */
};

static void add_row(void *context, size_t y, int thread)
{
    (void)thread;
    struct rows *rows = context;
    const struct pel_refinement *f = rows->refinement;
    size_t values = 4 * (size_t)rows->image->width;
    float *sum = f->sum + y * values;
    const float *from = rows->image->rgba + y * values;
    if (f->frames == 0) {
        memcpy(sum, from, values * sizeof *sum);
        return;
    }
    const float frames = (float)f->frames;
    bool moved = false;
    for (size_t i = 0; i < values; i++) {
        moved |= frames <= 2 && sum[i] != frames * from[i]; /* exact for one and two */
        sum[i] += from[i];
    }
    if (moved)
        atomic_store_explicit(&rows->moved, true, memory_order_relaxed);
}

void pel_refine_add(struct pel_refinement *f, int threads, const struct pel_image *image)
{
    struct rows rows = { .refinement = f, .image = (struct pel_image *)image };
    pel_parallel_for(threads, (size_t)image->height, add_row, &rows);
    f->moved |= atomic_load(&rows.moved);
    f->frames++;
    f->still = f->frames >= 3 && !f->moved;
}

static void show_row(void *context, size_t y, int thread)
{
    (void)thread;
    const struct rows *rows = context;
    size_t values = 4 * (size_t)rows->image->width;
    const float *sum = rows->refinement->sum + y * values, count = (float)rows->refinement->frames;
    float *to = rows->image->rgba + y * values;
    for (size_t i = 0; i < values; i++)
        to[i] = sum[i] / count;
}

void pel_refine_show(struct pel_refinement *f, int threads, struct pel_image *image)
{
    struct rows rows = { .refinement = f, .image = image };
    pel_parallel_for(threads, (size_t)image->height, show_row, &rows);
    if (image->depth)
        memcpy(image->depth, f->depth, f->pixels * sizeof *f->depth);
}

int pel_refine_count(const struct pel_refinement *f)
{
    return !f->begun ? 0 : f->still ? f->wanted : f->frames;
}

bool pel_refine_done(const struct pel_refinement *f)
{
    return f->begun && pel_refine_count(f) == f->wanted;
}
