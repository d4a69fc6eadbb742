/* SPDX-License-Identifier: MIT */
/* From a job's rays to slices: the clip coordinates of index positions, the slices' depths, and which cube faces can turn to the eye. */
#include <math.h>
#include <string.h>

#include "fail.h"
#include "slices3d.h"
#include "vec.h"

static void put_plane(float to[4], const double normal[3], double offset, double scale)
{
    for (int a = 0; a < 3; a++)
        to[a] = (float)(normal[a] * scale);
    to[3] = (float)(offset * scale);
}

/* An index position q is met by pixel (x, y) where q - eye = k (d0 + x dx + y dy), k being the view depth; in parallel, where q - p0 = x px
 * + y py + s d0 (rays.c). The inverse matrix gives k x, k y and k; or x, y and s. */
static bool project(struct pel_slice_block *b, const struct pel_job *job, bool parallel, double eye[3], double depth[4])
{
    double columns[3][3], rows[3][3], offset[3];
    for (int i = 0; i < 3; i++) {
        columns[i][0] = parallel ? job->px[i] : job->dx[i];
        columns[i][1] = parallel ? job->py[i] : job->dy[i];
        columns[i][2] = job->d0[i];
        eye[i] = job->p0[i] - (parallel ? 0 : job->s_base * job->d0[i]);
    }
    if (pel_invert3((const double(*)[3])columns, rows) == 0)
        return false;
    for (int i = 0; i < 3; i++)
        offset[i] = -pel_dot(rows[i], eye);
    if (parallel)
        offset[2] += job->s_base;
    memcpy(depth, rows[2], 3 * sizeof *depth);
    depth[3] = offset[2];
    put_plane(b->depth, rows[2], offset[2], 1);
    const int size[2] = { job->width, job->height };
    for (int i = 0; i < 2; i++) {
        /* the pixel's middle is at its number and a half; clip = (2 (x + 1/2) / size - 1) w */
        double normal[3], scale = 2.0 / size[i], w = 1.0 / size[i] - 1;
        for (int a = 0; a < 3; a++)
            normal[a] = scale * rows[i][a] + (parallel ? 0 : w * rows[2][a]);
        put_plane(i ? b->clip_y : b->clip_x, normal, scale * offset[i] + (parallel ? w : w * offset[2]), 1);
    }
    if (parallel)
        b->clip_w[3] = 1;
    else
        memcpy(b->clip_w, b->depth, sizeof b->clip_w);
    return true;
}

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
    double eye[3], depth[4], least = INFINITY, most = -INFINITY;
    memset(b, 0, sizeof *b);
    if (!project(b, job, parallel, eye, depth))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "slices3d: the camera sees no picture plane");
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
