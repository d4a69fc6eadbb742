/* SPDX-License-Identifier: MIT */
/* From a job's rays to slices: the clip coordinates of index positions, the slices' depths, and which cube faces can turn to the eye. */
#include <math.h>
#include <string.h>

#include "fail.h"
#include "gpu_view.h"
#include "slices3d.h"

/* Directions (cubes.h) in which faces may show their back or their front to the eye. */
static void find_faces(struct pel_slice_view *view, const struct pel_job *job, bool parallel, const double eye[3])
{
    view->faces[0] = view->faces[1] = 0;
    for (int a = 0; a < 3; a++) {
        bool above = parallel ? job->d0[a] < 0 : eye[a] > job->box_hi[a], below = parallel ? job->d0[a] > 0 : eye[a] < job->box_lo[a];
        unsigned lower = 1u << (2 * a), upper = 2u << (2 * a);
        if (!above)
            view->faces[1] |= lower, view->faces[0] |= upper;
        if (!below)
            view->faces[1] |= upper, view->faces[0] |= lower;
    }
}

/* 1/2, 1/4, 3/4, 1/8, ...: the number's bits behind the point, in reverse (van der Corput). */
static double part_of_slice(int jitter)
{
    double part = 0, bit = 0.5;
    for (unsigned n = (unsigned)jitter; n; n >>= 1, bit /= 2)
        part += (n & 1) * bit;
    return part;
}

bool pel_slice_view_setup(struct pel_slice_view *view, const struct pel_job *job, bool parallel, int jitter, struct pel_error *error)
{
    struct pel_slice_block *b = &view->block;
    double least = INFINITY, most = -INFINITY;
    struct pel_gpu_view projection;
    memset(b, 0, sizeof *b);
    if (!pel_gpu_view_setup(&projection, job, parallel))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices3d: the camera sees no picture plane");
    const double *eye = projection.eye, *depth = projection.depth;
    memcpy(b->clip_x, projection.clip_x, sizeof b->clip_x);
    memcpy(b->clip_y, projection.clip_y, sizeof b->clip_y);
    memcpy(b->clip_w, projection.clip_w, sizeof b->clip_w);
    for (int a = 0; a < 4; a++)
        b->depth[a] = (float)depth[a];
    for (int corner = 0; corner < 8; corner++) {
        double at = depth[3];
        for (int a = 0; a < 3; a++)
            at += depth[a] * (corner >> a & 1 ? job->box_hi[a] : job->box_lo[a]);
        least = fmin(least, at);
        most = fmax(most, at);
    }
    view->eye_inside = !parallel && least <= 0;
    if (view->eye_inside)
        least = 0; /* slices begin at the eye */
    least -= part_of_slice(jitter) * job->step;
    double count = ceil((most - least) / job->step - 1e-3);
    if (count > 1e6)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%.0f slices are more than slices3d draws; take a longer step", count);
    view->count = count > 0 ? (int)count : 0;
    b->range[0] = (float)least, b->range[1] = (float)job->step;
    b->range[2] = (float)view->count, b->range[3] = view->count ? 1 / (float)view->count : 1;
    double farthest = parallel ? 1 : fmax(most, 0);
    for (int a = 0; a < 3; a++) {
        double pixel = fmax(fabs(parallel ? job->px[a] : job->dx[a]), fabs(parallel ? job->py[a] : job->dy[a])) * farthest;
        b->eye[a] = (float)(parallel ? job->d0[a] : eye[a]);
        /* Rasterisers move vertices by up to 1/256 of a pixel; a cube that is larger by more than that covers all of its own pixels. */
        b->inflate[a] = (float)(0.01 + pixel / 64);
        b->lo[a] = (float)job->box_lo[a] - b->inflate[a], b->hi[a] = (float)job->box_hi[a] + b->inflate[a];
    }
    b->eye[3] = !parallel;
    find_faces(view, job, parallel, eye);
    return true;
}
