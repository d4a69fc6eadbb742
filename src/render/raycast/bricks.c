/* SPDX-License-Identifier: MIT */
#include "bricks.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "gpu_cells.h"

#define LARGEST_EDGE 512 /* more bricks than needed, so that empty ones need not travel; fewer, so that each is worth a pass */
#define LEAST_EDGE 8

int pel_bricks_border(const struct pel_scene *scene)
{
    double longest = 0, step = scene->render.step * pel_volume_least_spacing(scene->volume);
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, step / scene->volume->spacing[a]);
    return longest < 1e6 ? (int)fmax(ceil(longest) + 2, PEL_CELL_SIZE) : 1000000;
}

static int cells_along(int voxels)
{
    return (voxels - 1) / PEL_CELL_SIZE + 1;
}

uint64_t pel_bricks_bytes(const struct pel_gpu_box *box, int voxel_bytes)
{
    uint64_t voxels = (uint64_t)box->size[0] * (uint64_t)box->size[1] * (uint64_t)box->size[2];
    return voxels * (uint64_t)voxel_bytes + pel_gpu_cells_bytes(box->cells);
}

static bool fits(const struct pel_gpu_box *box, const struct pel_brick_limits *limits, int times)
{
    for (int a = 0; a < 3; a++)
        if (box->size[a] > limits->side) /* the cells' eight distance maps take half as much along an axis */
            return false;
    return !limits->bytes || pel_bricks_bytes(box, limits->voxel_bytes) <= limits->bytes / (uint64_t)times;
}

/* The box of the plan's greatest brick. */
static void greatest_box(const struct pel_brick_plan *plan, struct pel_gpu_box *box)
{
    for (int a = 0; a < 3; a++) {
        int size = plan->edge + 2 * plan->border, cells = plan->edge / PEL_CELL_SIZE + 2, all = cells_along(plan->dims[a]);
        box->size[a] = size < plan->dims[a] ? size : plan->dims[a];
        box->cells[a] = cells < all ? cells : all;
    }
}

bool pel_bricks_plan(struct pel_brick_plan *plan, const struct pel_volume *volume, int border, const struct pel_brick_limits *limits,
                     bool cut, struct pel_error *error)
{
    int longest = 0;
    for (int a = 0; a < 3; a++) {
        if (volume->dims[a] > INT_MAX / 4)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%zu voxels along one axis are more than the GPU engine draws", volume->dims[a]);
        plan->dims[a] = (int)volume->dims[a];
        longest = plan->dims[a] > longest ? plan->dims[a] : longest;
    }
    struct pel_gpu_box box;
    plan->border = border;
    plan->edge = cells_along(longest) * PEL_CELL_SIZE;
    greatest_box(plan, &box);
    if (cut || !fits(&box, limits, 1)) {
        plan->edge = LARGEST_EDGE;
        while (cut && plan->edge > LEAST_EDGE && plan->edge * 2 > longest)
            plan->edge /= 2;
        for (greatest_box(plan, &box); plan->edge >= LEAST_EDGE && !fits(&box, limits, 4); greatest_box(plan, &box))
            plan->edge /= 2;
        if (plan->edge < LEAST_EDGE)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                            "%zu x %zu x %zu voxels: not even bricks of them fit this device (its memory may be taken, or the step is long); "
                            "use --device cpu",
                            volume->dims[0], volume->dims[1], volume->dims[2]);
    }
    for (int a = 0; a < 3; a++)
        plan->count[a] = plan->dims[a] > 1 ? (plan->dims[a] - 2) / plan->edge + 1 : 1;
    return true;
}

int pel_bricks_count(const struct pel_brick_plan *plan)
{
    return plan->count[0] * plan->count[1] * plan->count[2];
}

static void brick_place(const struct pel_brick_plan *plan, int index, int place[3])
{
    place[0] = index % plan->count[0];
    place[1] = index / plan->count[0] % plan->count[1];
    place[2] = index / plan->count[0] / plan->count[1];
}

void pel_bricks_box(const struct pel_brick_plan *plan, int index, struct pel_gpu_box *box)
{
    const int far = 1 << 28;
    int place[3];
    brick_place(plan, index, place);
    for (int a = 0; a < 3; a++) {
        int first = place[a] * plan->edge, last = first + plan->edge, end = plan->dims[a];
        int from = first - plan->border, to = last + plan->border + 1;
        box->origin[a] = from > 0 ? from : 0;
        box->size[a] = (to < end ? to : end) - box->origin[a];
        int cell = first / PEL_CELL_SIZE - 1, cell_end = last / PEL_CELL_SIZE + 1, cells = cells_along(end);
        box->first_cell[a] = cell > 0 ? cell : 0;
        box->cells[a] = (cell_end < cells ? cell_end : cells) - box->first_cell[a];
        box->first[a] = place[a] > 0 ? first : -far;
        box->last[a] = place[a] < plan->count[a] - 1 ? last : far;
    }
}

struct ranked {
    int index;
    int rank;
};

static int by_rank(const void *a, const void *b)
{
    const struct ranked *x = a, *y = b;
    return x->rank != y->rank ? (x->rank > y->rank) - (x->rank < y->rank) : (x->index > y->index) - (x->index < y->index);
}

/* A ray only moves away from the eye's slab of bricks along each axis, so the number of slabs between, summed, rises along it. */
bool pel_bricks_sort(const struct pel_brick_plan *plan, const struct pel_job *job, bool parallel, int *order, struct pel_error *error)
{
    int count = pel_bricks_count(plan);
    struct ranked *bricks = pel_alloc((size_t)count, sizeof *bricks, "the order of bricks", error);
    if (!bricks)
        return false;
    for (int i = 0; i < count; i++) {
        int place[3];
        brick_place(plan, i, place);
        bricks[i] = (struct ranked){ i, 0 };
        for (int a = 0; a < 3; a++) {
            double eye = (job->p0[a] - job->s_base * job->d0[a]) / plan->edge;
            int slab = parallel ? (job->d0[a] < 0 ? plan->count[a] : -1) : (int)floor(fmin(fmax(eye, -1), plan->count[a]));
            bricks[i].rank += abs(place[a] - slab);
        }
    }
    qsort(bricks, (size_t)count, sizeof *bricks, by_rank);
    for (int i = 0; i < count; i++)
        order[i] = bricks[i].index;
    free(bricks);
    return true;
}
