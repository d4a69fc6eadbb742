/* SPDX-License-Identifier: MIT */
/* What section 4.2 calculates per frame on the CPU: the major axis, its sign, the slices; and where cells are on the screen. */
#include <math.h>
#include <string.h>

#include "fail.h"
#include "peel.h"
#include "rays.h"
#include "vec.h"

void pel_peel_grid(const struct pel_job *job, int granularity, int grid[4])
{
    for (int a = 0; a < 3; a++)
        grid[a] = job->dims[a] > 1 ? (job->dims[a] - 2) / granularity + 1 : 1;
    grid[3] = granularity;
}

/* The axis along which rays cross the most slices: that with the largest component of the optical axis, in voxels. */
static void find_major(struct pel_peel *p)
{
    const struct pel_job *job = &p->job;
    double optical[3];
    int axis = 0;
    for (int a = 0; a < 3; a++)
        optical[a] = job->d0[a] + 0.5 * (job->width - 1) * job->dx[a] + 0.5 * (job->height - 1) * job->dy[a];
    for (int a = 1; a < 3; a++)
        if (fabs(optical[a]) > fabs(optical[axis]))
            axis = a;
    p->view.major[0] = axis;
    p->view.major[1] = optical[axis] < 0 ? -1 : 1;
    p->view.major[2] = p->view.grid[axis];
}

/* Index positions to pixels. A ray is from + w (x dx + y dy + d0) in perspective, from + x px + y py + s d0 in parallel. */
static bool find_pixels(struct pel_peel *p, bool parallel, struct pel_error *error)
{
    const struct pel_job *job = &p->job;
    struct pel_peel_block *view = &p->view;
    double columns[3][3], inverse[3][3], along = 0;
    for (int a = 0; a < 3; a++) {
        columns[a][0] = parallel ? job->px[a] : job->dx[a];
        columns[a][1] = parallel ? job->py[a] : job->dy[a];
        columns[a][2] = job->d0[a];
        view->from[a] = (float)(job->p0[a] - (parallel ? 0 : job->s_base * job->d0[a]));
    }
    if (pel_invert3((const double(*)[3])columns, inverse) == 0)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the camera's picture has no area; widen the view");
    for (int i = 0; i < 3; i++) {
        for (int a = 0; a < 3; a++)
            view->to_pixel[i][a] = parallel && i == 2 ? 0 : (float)inverse[i][a];
        view->to_pixel[i][3] = parallel && i == 2 ? 1 : 0;
        along += inverse[2][i] * inverse[2][i];
    }
    view->from[3] = parallel ? 0 : (float)(1e-4 * sqrt(along)); /* a ten-thousandth of a voxel */
    return true;
}

static void find_screen(struct pel_peel *p, bool parallel)
{
    double lo[3], hi[3];
    int rectangle[4];
    for (int a = 0; a < 3; a++) {
        lo[a] = p->job.box_lo[a] - 0.01;
        hi[a] = p->job.box_hi[a] + 0.01;
    }
    memset(p->screen, 0, sizeof p->screen);
    if (!pel_rays_rectangle(&p->job, parallel, lo, hi, rectangle))
        return;
    for (int i = 0; i < 2; i++) {
        p->screen[i] = rectangle[i] / PEL_TILE_SIDE * PEL_TILE_SIDE;
        p->screen[2 + i] = (rectangle[2 + i] + PEL_TILE_SIDE - 1) / PEL_TILE_SIDE * PEL_TILE_SIDE - p->screen[i];
    }
}

bool pel_peel_view_setup(struct pel_peel *p, bool parallel, struct pel_error *error)
{
    find_major(p);
    find_screen(p, parallel);
    return find_pixels(p, parallel, error);
}
