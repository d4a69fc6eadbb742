/* SPDX-License-Identifier: MIT */
/* Section 9: "At first the cross-section of the slicing plane with the bounding box of the volume is calculated. The resulting intersection
 * polygon is then cut into a set of polygon strips at the intersection line with the object-aligned texture slices." */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "slices2d_polygons.h"

static const int axes[3][3] = { { 1, 2, 0 }, { 0, 2, 1 }, { 0, 1, 2 } };

/* What rounding may need beyond the box: fragments there look for themselves whether their ray meets the plane inside. */
#define MARGIN 0.02
#define MOST_CORNERS 16

struct polygon {
    int count;
    double at[MOST_CORNERS][3];
};

/* Keeps what lies where at[axis] >= limit (side 1) or < limit (-1; Sutherland and Hodgman): a plane that lies on a slice is in one strip.
 */
static struct polygon cut(const struct polygon *p, int axis, double limit, int side)
{
    struct polygon kept = { 0 };
    for (int i = 0; i < p->count; i++) {
        const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
        double va = side * (a[axis] - limit), vb = side * (b[axis] - limit);
        bool in = side > 0 ? va >= 0 : va > 0, next_in = side > 0 ? vb >= 0 : vb > 0;
        if (in && kept.count < MOST_CORNERS)
            memcpy(kept.at[kept.count++], a, sizeof kept.at[0]);
        if (in != next_in && kept.count < MOST_CORNERS) {
            for (int c = 0; c < 3; c++)
                kept.at[kept.count][c] = c == axis ? limit : a[c] + va / (va - vb) * (b[c] - a[c]);
            kept.count++;
        }
    }
    return kept;
}

/* The plane as a quadrilateral that reaches beyond the box, in stack space: over the two axes that it is least steep to. */
static struct polygon cross_section(const double plane[4], const double lo[3], const double hi[3])
{
    int steep = 0;
    for (int a = 1; a < 3; a++)
        if (fabs(plane[a]) > fabs(plane[steep]))
            steep = a;
    const int x = (steep + 1) % 3, y = (steep + 2) % 3;
    struct polygon p = { .count = 4 };
    for (int i = 0; i < 4; i++) {
        double *at = p.at[i];
        at[x] = (i == 1 || i == 2 ? hi : lo)[x];
        at[y] = (i >= 2 ? hi : lo)[y];
        at[steep] = -(plane[x] * at[x] + plane[y] * at[y] + plane[3]) / plane[steep];
    }
    p = cut(&p, steep, lo[steep], 1);
    return cut(&p, steep, hi[steep], -1);
}

/* A convex polygon as a fan of triangles. */
static int put(const struct polygon *p, int slice, float (*to)[4])
{
    int count = 0;
    for (int i = 1; i + 1 < p->count; i++) {
        const int corners[3] = { 0, i, i + 1 };
        for (int j = 0; j < 3; j++, count++) {
            for (int a = 0; a < 3; a++)
                to[count][a] = (float)p->at[corners[j]][a];
            to[count][3] = (float)slice;
        }
    }
    return count;
}

int pel_slices2d_strips(const struct pel_job *job, int axis, float (**corners)[4], struct pel_error *error)
{
    const int *order = axes[axis], last = job->dims[axis] > 1 ? job->dims[axis] - 2 : 0;
    double plane[4] = { 0, 0, 0, job->slice_plane[3] }, lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        plane[a] = job->slice_plane[order[a]];
        lo[a] = job->box_lo[order[a]] - MARGIN, hi[a] = job->box_hi[order[a]] + MARGIN;
    }
    *corners = pel_alloc((size_t)(last + 1) * 3 * MOST_CORNERS, sizeof **corners, "polygon strips", error);
    if (!*corners)
        return -1;
    const struct polygon whole = cross_section(plane, lo, hi);
    int count = 0;
    for (int i = 0; i <= last; i++) { /* the outermost strips reach to the box's faces */
        struct polygon strip = cut(&whole, 2, i ? i : lo[2], 1);
        strip = cut(&strip, 2, i < last ? i + 1 : hi[2], -1);
        count += put(&strip, i, *corners + count);
    }
    return count;
}
