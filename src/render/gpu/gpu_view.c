/* SPDX-License-Identifier: MIT */
#include "gpu_view.h"

#include <string.h>

#include "vec.h"

static void put_plane(float to[4], const double normal[3], double offset)
{
    for (int a = 0; a < 3; a++)
        to[a] = (float)normal[a];
    to[3] = (float)offset;
}

/* An index position q is met by pixel (x, y) where q - eye = k (d0 + x dx + y dy), k being the view depth; in parallel, where q - p0 = x px
 * + y py + s d0 (rays.c). The inverse matrix gives k x, k y and k; or x, y and s. */
bool pel_gpu_view_setup(struct pel_gpu_view *view, const struct pel_job *job, bool parallel)
{
    double columns[3][3], rows[3][3], offset[3];
    for (int i = 0; i < 3; i++) {
        columns[i][0] = parallel ? job->px[i] : job->dx[i];
        columns[i][1] = parallel ? job->py[i] : job->dy[i];
        columns[i][2] = job->d0[i];
        view->eye[i] = job->p0[i] - (parallel ? 0 : job->s_base * job->d0[i]);
    }
    if (pel_invert3((const double(*)[3])columns, rows) == 0)
        return false;
    for (int i = 0; i < 3; i++)
        offset[i] = -pel_dot(rows[i], view->eye);
    if (parallel)
        offset[2] += job->s_base;
    memcpy(view->depth, rows[2], 3 * sizeof *view->depth);
    view->depth[3] = offset[2];
    const int size[2] = { job->width, job->height };
    for (int i = 0; i < 2; i++) {
        /* the pixel's middle is at its number and a half; clip = (2 (x + 1/2) / size - 1) w */
        double normal[3], scale = 2.0 / size[i], w = 1.0 / size[i] - 1;
        for (int a = 0; a < 3; a++)
            normal[a] = scale * rows[i][a] + (parallel ? 0 : w * rows[2][a]);
        put_plane(i ? view->clip_y : view->clip_x, normal, scale * offset[i] + (parallel ? w : w * offset[2]));
    }
    static const double none[3] = { 0, 0, 0 };
    put_plane(view->clip_w, parallel ? none : rows[2], parallel ? 1 : offset[2]);
    return true;
}
