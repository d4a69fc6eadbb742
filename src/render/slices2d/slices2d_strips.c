/* SPDX-License-Identifier: MIT */
/* Section 9: "At first the cross-section of the slicing plane with the bounding box of the volume is calculated. The resulting intersection
 * polygon is then cut into a set of polygon strips at the intersection line with the object-aligned texture slices."
 *
 * Several planes may be in a picture. They pass through one another, so that no order of whole planes is right: each is cut at the others
 * where need be, and the pieces come from the nearest on, as a binary space partition tells (Fuchs, Kedem and Naylor 1980). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "slices2d_polygons.h"

static const int axes[3][3] = { { 1, 2, 0 }, { 0, 2, 1 }, { 0, 1, 2 } };

/* What rounding may need beyond the box: fragments there look for themselves whether their ray meets the plane inside. */
#define MARGIN 0.02
#define MOST_CORNERS 16 /* 4, 2 more by the box, PEL_MAX_SLICES - 1 by the other planes, 2 by a strip */
#define MOST_PIECES 512  /* 8, and all that putting them in order can make: for n planes c(n) = 2 (n - 1) + 2 c(n - 1) */

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

/* ---- the order of planes that cross ---- */

struct piece {
    struct polygon polygon;
    int plane;
};

struct ordering {
    const double (*planes)[4]; /* stack space */
    bool near_side[PEL_MAX_SLICES]; /* of each plane, that the view comes from: is it that of its normal? */
    struct piece pieces[MOST_PIECES];
    int count;
    int order[MOST_PIECES], ordered; /* the result: pieces, the nearest first */
};

static double height(const double plane[4], const double at[3])
{
    return plane[0] * at[0] + plane[1] * at[1] + plane[2] * at[2] + plane[3];
}

/* What of a polygon lies on one side of a plane. */
static struct polygon side_of(const struct polygon *p, const double plane[4], bool above)
{
    struct polygon kept = { 0 };
    for (int i = 0; i < p->count; i++) {
        const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
        double va = height(plane, a), vb = height(plane, b);
        bool in = above ? va >= 0 : va < 0, next_in = above ? vb >= 0 : vb < 0;
        if (in && kept.count < MOST_CORNERS)
            memcpy(kept.at[kept.count++], a, sizeof kept.at[0]);
        if (in != next_in && kept.count < MOST_CORNERS) {
            for (int c = 0; c < 3; c++)
                kept.at[kept.count][c] = a[c] + va / (va - vb) * (b[c] - a[c]);
            kept.count++;
        }
    }
    return kept;
}

/* Adds the pieces in `list`, at most one of each plane, to the order: those on the near side of the first one's plane, the first, those on the
 * far side. Pieces that the plane cuts become two. */
static void put_in_order(struct ordering *o, const int *list, int count)
{
    if (count == 0)
        return;
    const int plane = o->pieces[list[0]].plane;
    int sides[2][PEL_MAX_SLICES], counts[2] = { 0 };
    for (int i = 1; i < count; i++)
        for (int far = 0; far < 2; far++) {
            const struct piece *whole = &o->pieces[list[i]];
            struct piece part = { side_of(&whole->polygon, o->planes[plane], o->near_side[plane] != far), whole->plane };
            if (part.polygon.count < 3)
                continue;
            sides[far][counts[far]++] = o->count;
            o->pieces[o->count++] = part;
        }
    put_in_order(o, sides[0], counts[0]);
    o->order[o->ordered++] = list[0];
    put_in_order(o, sides[1], counts[1]);
}

/* The cross-sections of the job's planes, cut and ordered, in the stack space of an axis. */
static void order_planes(const struct pel_job *job, bool perspective, int axis, double planes[][4], struct ordering *o)
{
    const int *order = axes[axis];
    double lo[3], hi[3], eye[3];
    int list[PEL_MAX_SLICES], count = 0;
    for (int a = 0; a < 3; a++) {
        lo[a] = job->box_lo[order[a]] - MARGIN, hi[a] = job->box_hi[order[a]] + MARGIN;
        eye[a] = perspective ? job->p0[order[a]] + job->s_least * job->d0[order[a]] : -job->d0[order[a]];
    }
    o->planes = (const double (*)[4])planes;
    for (int i = 0; i < job->slice_count; i++) {
        for (int a = 0; a < 3; a++)
            planes[i][a] = job->slice_planes[i][order[a]];
        planes[i][3] = job->slice_planes[i][3];
        o->near_side[i] = height(planes[i], eye) - (perspective ? 0 : planes[i][3]) >= 0;
        o->pieces[o->count] = (struct piece){ cross_section(planes[i], lo, hi), i };
        if (o->pieces[o->count].polygon.count >= 3)
            list[count++] = o->count++;
    }
    put_in_order(o, list, count);
}

/* ---- strips ---- */

/* A convex polygon as a fan of triangles. */
static int put(const struct polygon *p, int slice, int plane, float (*to)[4])
{
    int count = 0;
    for (int i = 1; i + 1 < p->count; i++) {
        const int corners[3] = { 0, i, i + 1 };
        for (int j = 0; j < 3; j++, count++) {
            for (int a = 0; a < 3; a++)
                to[count][a] = (float)p->at[corners[j]][a];
            to[count][3] = (float)(slice * PEL_MAX_SLICES + plane);
        }
    }
    return count;
}

/* The slices of voxels before the first and the last strip of a polygon. */
static void strips_of(const struct polygon *p, int last, int range[2])
{
    double lo = p->at[0][2], hi = lo;
    for (int i = 1; i < p->count; i++)
        lo = fmin(lo, p->at[i][2]), hi = fmax(hi, p->at[i][2]);
    range[0] = (int)fmin(fmax(floor(lo), 0), last);
    range[1] = (int)fmin(fmax(floor(hi), 0), last);
}

static int put_strips(const struct piece *piece, int last, double least, double most, float (*to)[4])
{
    int count = 0, range[2];
    strips_of(&piece->polygon, last, range);
    for (int i = range[0]; i <= range[1]; i++) { /* the outermost strips reach to the box's faces */
        struct polygon strip = cut(&piece->polygon, 2, i ? i : least, 1);
        strip = cut(&strip, 2, i < last ? i + 1 : most, -1);
        count += put(&strip, i, piece->plane, to + count);
    }
    return count;
}

bool pel_slices2d_strips(const struct pel_job *job, bool perspective, int axis, struct pel_slices2d_strips *strips,
                         struct pel_error *error)
{
    const int last = job->dims[axis] > 1 ? job->dims[axis] - 2 : 0;
    double planes[PEL_MAX_SLICES][4];
    size_t room = 1;
    *strips = (struct pel_slices2d_strips){ 0 };
    struct ordering *o = pel_alloc(1, sizeof *o, "slice planes", error);
    if (!o)
        return false;
    order_planes(job, perspective, axis, planes, o);
    for (int i = 0; i < o->ordered; i++) { /* a cut adds a corner, a fan has two triangles fewer than corners */
        const struct polygon *p = &o->pieces[o->order[i]].polygon;
        int range[2];
        strips_of(p, last, range);
        room += (size_t)(range[1] - range[0] + 1) * 3 * (size_t)p->count;
    }
    strips->corners = pel_alloc(room, sizeof *strips->corners, "polygon strips", error);
    strips->ends = pel_alloc((size_t)o->ordered + 1, sizeof *strips->ends, "polygon strips", error);
    bool ok = strips->corners && strips->ends;
    for (int i = 0; ok && i < o->ordered; i++) {
        strips->count += put_strips(&o->pieces[o->order[i]], last, job->box_lo[axis] - MARGIN, job->box_hi[axis] + MARGIN,
                                    strips->corners + strips->count);
        strips->ends[strips->pieces++] = strips->count;
    }
    free(o);
    if (!ok)
        pel_slices2d_strips_finish(strips);
    return ok;
}

void pel_slices2d_strips_finish(struct pel_slices2d_strips *strips)
{
    free(strips->corners);
    free(strips->ends);
    *strips = (struct pel_slices2d_strips){ 0 };
}
