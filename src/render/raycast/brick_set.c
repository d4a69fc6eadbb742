/* SPDX-License-Identifier: MIT */
#include "brick_set.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"
#include "rays.h"
#include "timer.h"

void pel_brick_set_init(struct pel_brick_set *set, struct pel_device *device, struct pel_programs *programs)
{
    memset(set, 0, sizeof *set);
    set->maker.device = device;
    set->maker.programs = programs;
}

static void release_brick(struct pel_brick_set *set, struct pel_brick *brick)
{
    if (brick->texture.name)
        set->taken -= pel_bricks_bytes(&brick->box, set->format.bytes);
    pel_texture_destroy(set->maker.device, &brick->texture);
    pel_gpu_cells_finish(set->maker.device, &brick->cells);
    brick->marked = false;
}

static void release_all(struct pel_brick_set *set)
{
    for (int i = 0; i < set->count; i++)
        release_brick(set, &set->bricks[i]);
    free(set->bricks);
    set->bricks = NULL;
    set->count = 0;
}

void pel_brick_set_finish(struct pel_brick_set *set)
{
    release_all(set);
    pel_minmax_finish(&set->minmax);
    pel_gpu_cell_maker_finish(&set->maker);
}

/* Bytes that a volume may take beside the picture: what the caller allows, else most of what the driver says is free; 0: it does not say. */
static uint64_t find_budget(const struct pel_device *device, const struct pel_image *image)
{
    uint64_t free_bytes = 0, picture = 20 * (uint64_t)image->width * (uint64_t)image->height;
    if (device->params.memory_limit)
        return device->params.memory_limit;
    glFinish(); /* so that what was just deleted is free */
    if (!pel_device_free_bytes(device, &free_bytes))
        return 0;
    return free_bytes / 10 * 9 > picture ? free_bytes / 10 * 9 - picture : 1;
}

bool pel_brick_set_volume(struct pel_brick_set *set, const struct pel_frame *frame, struct pel_error *error)
{
    release_all(set);
    pel_minmax_finish(&set->minmax);
    set->maker.threads = frame->threads;
    set->format = pel_gpu_format_of(set->maker.device, frame->scene->volume, frame->threads);
    set->budget = find_budget(set->maker.device, frame->image);
    return pel_brick_set_plan(set, frame->scene, false, error);
}

bool pel_brick_set_plan(struct pel_brick_set *set, const struct pel_scene *scene, bool cut, struct pel_error *error)
{
    const struct pel_brick_limits limits = { set->maker.device->info.max_texture_3d, set->budget, set->format.bytes };
    release_all(set);
    if (!pel_bricks_plan(&set->plan, scene->volume, pel_bricks_border(scene), &limits, cut, error))
        return false;
    int count = pel_bricks_count(&set->plan);
    set->bricks = pel_alloc((size_t)count, sizeof *set->bricks, "bricks", error);
    if (!set->bricks)
        return false;
    set->count = count;
    for (int i = 0; i < count; i++)
        pel_bricks_box(&set->plan, i, &set->bricks[i].box);
    return true;
}

void pel_brick_set_unmark(struct pel_brick_set *set)
{
    for (int i = 0; i < set->count; i++)
        set->bricks[i].marked = false;
}

/* ---- empty bricks ---- */

static bool passes_over(const struct pel_job *job)
{
    return pel_mode_has_map(job->mode) && job->skip;
}

/* The CPU's grid of the whole volume, made when it is first asked for. */
static bool need_minmax(struct pel_brick_set *set, const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    if (!set->minmax.cells.least && !pel_minmax_init(&set->minmax, frame->scene->volume, frame->threads, error))
        return false;
    set->times.grid += pel_now_ms() - start;
    return true;
}

struct looking {
    struct pel_brick_set *set;
    struct pel_classification_state *tables;
    const struct pel_job *job;
    const struct pel_scene *scene;
};

static void look_into(void *context, size_t i, int thread)
{
    (void)thread;
    const struct looking *l = context;
    struct pel_brick *brick = &l->set->bricks[i];
    brick->empty = !pel_classify_box(l->tables, l->scene, &l->set->minmax, l->set->format.raw, l->job, brick->box.first_cell,
                                     brick->box.cells, 1, NULL);
}

bool pel_brick_set_find_empty(struct pel_brick_set *set, struct pel_classification_state *tables, const struct pel_job *job,
                              const struct pel_frame *frame, struct pel_error *error)
{
    struct looking looking = { set, tables, job, frame->scene };
    for (int i = 0; i < set->count; i++)
        set->bricks[i].empty = false;
    if (!passes_over(job))
        return true;
    if (!need_minmax(set, frame, error))
        return false;
    pel_parallel_for(frame->threads, (size_t)set->count, look_into, &looking);
    return true;
}

/* ---- on the device ---- */

void pel_brick_set_frame(struct pel_brick_set *set)
{
    set->last_frame = set->this_frame;
    set->this_frame = set->passes + 1;
}

/* Is the brick's turn farther off than the other's? Those that the last frame did not need come first, the longest unused before others.
 * Frames repeat their order, so of the rest the one drawn last has the longest to wait. */
static bool waits_longer(const struct pel_brick_set *set, const struct pel_brick *a, const struct pel_brick *b)
{
    bool left_a = a->empty || a->drawn < set->last_frame, left_b = b->empty || b->drawn < set->last_frame;
    if (left_a != left_b)
        return left_a;
    return left_a ? a->drawn < b->drawn : a->drawn > b->drawn;
}

bool pel_brick_set_make_room(struct pel_brick_set *set, const struct pel_brick *but)
{
    struct pel_brick *victim = NULL;
    for (int i = 0; i < set->count; i++) {
        struct pel_brick *b = &set->bricks[i];
        if (b->texture.name && b != but && (!victim || waits_longer(set, b, victim)))
            victim = b;
    }
    if (victim)
        release_brick(set, victim);
    return victim;
}

bool pel_brick_set_bring(struct pel_brick_set *set, struct pel_brick *brick, const struct pel_frame *frame, struct pel_error *error)
{
    uint64_t need = pel_bricks_bytes(&brick->box, set->format.bytes);
    double start = pel_now_ms();
    brick->drawn = ++set->passes;
    if (brick->texture.name)
        return true;
    while (set->budget && set->taken + need > set->budget && pel_brick_set_make_room(set, brick))
        continue;
    if (!pel_gpu_volume_upload(set->maker.device, &set->format, frame->scene->volume, brick->box.origin, brick->box.size, frame->threads,
                               &brick->texture, error)) {
        pel_texture_destroy(set->maker.device, &brick->texture);
        return false;
    }
    if (set->count == 1)
        glFinish(); /* the time of sending, not of asking for it */
    set->uploads++;
    set->taken += need;
    set->times.upload += pel_now_ms() - start;
    return true;
}

/* Hardware makes the grid of a whole volume and marks its cells by itself; else the CPU does. */
static bool mark(struct pel_brick_set *set, struct pel_brick *brick, struct pel_classification_state *tables, const struct pel_job *job,
                 const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    bool by_device = set->count == 1 && !set->maker.device->info.software, ok = true;
    if (by_device && !brick->cells.grid.name) {
        ok = pel_gpu_cells_build(&set->maker, &brick->cells, &brick->box, set->format.voids, error);
        set->times.grid += pel_now_ms() - start;
    } else if (!by_device) {
        ok = need_minmax(set, frame, error);
    }
    start = pel_now_ms();
    if (ok && by_device) {
        ok = pel_gpu_cells_mark(&set->maker, &brick->cells, job->mode, error);
    } else if (ok) {
        const struct pel_gpu_marking marking = { tables, frame->scene, &set->minmax, set->format.raw, job };
        ok = pel_gpu_cells_mark_by_cpu(&set->maker, &brick->cells, &brick->box, &marking, error);
    }
    set->times.classify += pel_now_ms() - start;
    return ok;
}

bool pel_brick_set_map(struct pel_brick_set *set, struct pel_brick *brick, struct pel_classification_state *tables,
                       const struct pel_job *job, const struct pel_frame *frame, struct pel_error *error)
{
    if (!passes_over(job))
        return true;
    if (!brick->marked && !mark(set, brick, tables, job, frame, error))
        return false;
    brick->marked = true;
    double start = pel_now_ms();
    bool ok = pel_gpu_cells_map(&set->maker, &brick->cells, pel_rays_octants(job), error);
    set->times.maps += pel_now_ms() - start;
    return ok;
}

double pel_brick_set_spent(const struct pel_brick_set *set)
{
    return set->times.upload + set->times.grid + set->times.classify + set->times.maps;
}

void pel_brick_set_note(struct pel_brick_set *set, const struct pel_frame *frame)
{
    const struct {
        const char *name;
        double ms;
    } stages[] = { { "upload", set->times.upload }, { "min-max grid", set->times.grid },
                   { "classify", set->times.classify }, { "distance maps", set->times.maps } };
    for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
        if (stages[i].ms > 0.001)
            pel_frame_stage(frame, stages[i].name, pel_now_ms() - stages[i].ms);
    memset(&set->times, 0, sizeof set->times);
}
