/* SPDX-License-Identifier: MIT */
#include "shear_factor.h"

#include <math.h>
#include <string.h>

#include "fail.h"
#include "vec.h"

/* A shear of more voxels a slice than this is left to another axis. */
#define STEEPEST 2.0
#define DEGREES (180 / 3.14159265358979323846)
#define MOST_RAYS ((double)(1 << 28))
#define MOST_SIDE 65536.0

static double direction(const struct pel_job *job, int a, double x, double y)
{
    return job->d0[a] + job->dx[a] * x + job->dy[a] * y;
}

/* The picture, or the part of it whose rays are nearest to a principal axis: a convex polygon of pixel positions. */
struct polygon {
    int count;
    double at[8][2];
};

/* Keeps what lies where c[0] + c[1] x + c[2] y >= 0 (Sutherland and Hodgman). */
static void polygon_cut(struct polygon *p, const double c[3])
{
    struct polygon kept = { 0 };
    for (int i = 0; i < p->count; i++) {
        const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
        double va = c[0] + c[1] * a[0] + c[2] * a[1], vb = c[0] + c[1] * b[0] + c[2] * b[1];
        if (va >= 0)
            memcpy(kept.at[kept.count++], a, sizeof kept.at[0]);
        if ((va >= 0) != (vb >= 0)) {
            double t = va / (va - vb);
            kept.at[kept.count][0] = a[0] + t * (b[0] - a[0]);
            kept.at[kept.count++][1] = a[1] + t * (b[1] - a[1]);
        }
    }
    *p = kept;
}

static void polygon_of_part(const struct pel_job *job, int part, bool split, struct polygon *p)
{
    const double w = job->width - 0.5, h = job->height - 0.5;
    *p = (struct polygon) { 4, { { -0.5, -0.5 }, { w, -0.5 }, { w, h }, { -0.5, h } } };
    int c = part / 2, sign = part % 2 ? -1 : 1;
    for (int a = 0; split && a < 3; a++)
        for (int side = -1; a != c && side <= 1; side += 2)
            polygon_cut(p, (const double[3]) { sign * job->d0[c] + side * job->d0[a], sign * job->dx[c] + side * job->dx[a],
                                               sign * job->dy[c] + side * job->dy[a] });
}

static int nearest_axis(const struct pel_job *job, double x, double y)
{
    int c = 0;
    for (int a = 1; a < 3; a++)
        if (fabs(direction(job, a, x, y)) > fabs(direction(job, c, x, y)))
            c = a;
    return 2 * c + (direction(job, c, x, y) < 0);
}

int pel_shear_parts(const struct pel_job *job, bool perspective, int parts[PEL_SHEAR_PARTS])
{
    const double w = job->width - 1, h = job->height - 1;
    int middle = nearest_axis(job, w / 2, h / 2), c = middle / 2, sign = middle % 2 ? -1 : 1;
    bool serves_all = true;
    for (int corner = 0; perspective && corner < 4; corner++)
        for (int a = 0; a < 3; a++)
            serves_all &= STEEPEST * sign * direction(job, c, corner & 1 ? w : 0, corner & 2 ? h : 0) >=
                          fabs(direction(job, a, corner & 1 ? w : 0, corner & 2 ? h : 0));
    parts[0] = middle;
    if (serves_all)
        return 1;
    int count = 0;
    for (int part = 0; part < PEL_SHEAR_PARTS; part++) {
        struct polygon p;
        polygon_of_part(job, part, true, &p);
        if (p.count >= 3)
            parts[count++] = part;
    }
    return count;
}

/* Where on the reference plane the ray of a pixel lies: linear in the pixel, over `over`. at[0] and at[1] along i and j. */
struct plane_map {
    double at[2][3], over[3];
};

static void map_to_plane(const struct pel_job *job, bool perspective, const int axis[3], const double eye[3], double reference,
                         struct plane_map *map)
{
    const int c = axis[2];
    for (int a = 0; a < 2; a++) {
        const int i = axis[a];
        double slope = job->d0[i] / job->d0[c], far = reference - eye[c];
        const double parallel[3] = { job->p0[i] + slope * (reference - job->p0[c]), job->px[i] - slope * job->px[c],
                                     job->py[i] - slope * job->py[c] };
        const double central[3] = { eye[i] * job->d0[c] + far * job->d0[i], eye[i] * job->dx[c] + far * job->dx[i],
                                    eye[i] * job->dy[c] + far * job->dy[i] };
        memcpy(map->at[a], perspective ? central : parallel, sizeof map->at[a]);
    }
    const double central[3] = { job->d0[c], job->dx[c], job->dy[c] }, parallel[3] = { 1, 0, 0 };
    memcpy(map->over, perspective ? central : parallel, sizeof map->over);
}

static double mapped(const struct plane_map *map, int a, double x, double y)
{
    return (map->at[a][0] + map->at[a][1] * x + map->at[a][2] * y) / (map->over[0] + map->over[1] * x + map->over[2] * y);
}

/* The part of the reference plane that the picture's rays and the box leave, in voxels. */
static void plane_bounds(const struct pel_job *job, bool perspective, const int axis[3], int sign, const double eye[3], double reference,
                         const struct plane_map *map, const struct polygon *p, double lo[2], double hi[2])
{
    const int c = axis[2];
    bool outside = !perspective || sign * ((sign > 0 ? job->box_lo[c] : job->box_hi[c]) - eye[c]) > 1e-3;
    for (int a = 0; a < 2; a++) {
        double box[2] = { 1e300, -1e300 };
        lo[a] = 1e300, hi[a] = -1e300;
        for (int i = 0; i < p->count; i++) {
            double at = mapped(map, a, p->at[i][0], p->at[i][1]);
            lo[a] = fmin(lo[a], at), hi[a] = fmax(hi[a], at);
        }
        for (int corner = 0; outside && corner < 4; corner++) {
            double k = corner & 1 ? job->box_hi[c] : job->box_lo[c], i = corner & 2 ? job->box_hi[axis[a]] : job->box_lo[axis[a]];
            double at = perspective ? eye[axis[a]] + (i - eye[axis[a]]) * (reference - eye[c]) / (k - eye[c])
                                    : i + (reference - k) * job->d0[axis[a]] / job->d0[c];
            box[0] = fmin(box[0], at), box[1] = fmax(box[1], at);
        }
        if (outside)
            lo[a] = fmax(lo[a], box[0]), hi[a] = fmin(hi[a], box[1]);
    }
}

/* Voxels from ray to ray along i or j. */
static double spacing_of_rays(const struct pel_job *job, const struct pel_shear_settings *settings, const struct plane_map *map,
                              const struct polygon *p, int a)
{
    if (settings->intermediate == PEL_INTERMEDIATE_VOXEL)
        return 1 / settings->rays;
    double x = 0, y = 0;
    for (int i = 0; i < p->count; i++)
        x += p->at[i][0] / p->count, y += p->at[i][1] / p->count;
    double along_x = mapped(map, a, x + 0.5, y) - mapped(map, a, x - 0.5, y),
           along_y = mapped(map, a, x, y + 0.5) - mapped(map, a, x, y - 0.5);
    (void)job;
    return sqrt(along_x * along_x + along_y * along_y) / settings->rays;
}

static void rays_in_slices(const struct pel_job *job, bool perspective, const double eye[3], const double start[2], const double by[2],
                           struct pel_shear *s)
{
    const int c = s->axis[2];
    struct pel_shear_axis *to[2] = { &s->i, &s->j };
    for (int a = 0; a < 2; a++) {
        double slope = job->d0[s->axis[a]] / job->d0[c], from = eye[s->axis[a]];
        double scale0 = (s->first - eye[c]) / (s->reference - eye[c]), scale1 = s->step / (s->reference - eye[c]);
        *to[a] = perspective ? (struct pel_shear_axis) { from + (start[a] - from) * scale0, (start[a] - from) * scale1, by[a] * scale0,
                                                         by[a] * scale1 }
                             : (struct pel_shear_axis) { start[a] + (s->first - s->reference) * slope, s->step * slope, by[a], 0 };
    }
    double d[3], length2 = 0, gram[3][3];
    d[s->axis[0]] = s->i.at1, d[s->axis[1]] = s->j.at1, d[c] = s->step;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            gram[i][j] = 0;
            for (int r = 0; r < 3; r++)
                gram[i][j] +=
                    (double)job->to_world[r][i] * (double)job->to_world[r][j] * (double)job->steps_a_voxel * (double)job->steps_a_voxel;
            length2 += gram[i][j] * d[i] * d[j];
        }
    s->length = (float)sqrt(length2);
    for (int a = 0; a < 3; a++)
        s->toward[a] = (float)(d[a] / sqrt(length2));
    const int *x = s->axis;
    const float g[6] = { (float)gram[x[0]][x[0]],       (float)gram[x[1]][x[1]],       (float)gram[x[2]][x[2]],
                         (float)(2 * gram[x[0]][x[1]]), (float)(2 * gram[x[0]][x[2]]), (float)(2 * gram[x[1]][x[2]]) };
    memcpy(s->gram, g, sizeof g);
}

/* The direction of the picture's middle, in voxels. */
static double middle_of(const struct pel_job *job, int axis)
{
    return job->d0[axis] + job->dx[axis] * (job->width - 1) / 2 + job->dy[axis] * (job->height - 1) / 2;
}

/* Shares of the axes by how far the view's direction is from the switches between them. */
static void weigh(const struct pel_job *job, double blend, double weights[3])
{
    double d[3], sum = 0;
    for (int a = 0; a < 3; a++)
        d[a] = fabs(middle_of(job, a));
    pel_normalize(d);
    for (int a = 0; a < 3; a++) {
        double other = fmax(d[(a + 1) % 3], d[(a + 2) % 3]);
        weights[a] = fmin(fmax(0.5 + asin((d[a] - other) / sqrt(2)) * DEGREES / blend, 0), 1);
        sum += weights[a];
    }
    for (int a = 0; a < 3; a++)
        weights[a] /= sum;
}

int pel_shear_parts_blended(const struct pel_job *job, bool perspective, double blend, int parts[PEL_SHEAR_PARTS],
                            double weights[PEL_SHEAR_PARTS], bool *split)
{
    int count = pel_shear_parts(job, perspective, parts), main_axis = parts[0] / 2;
    double shares[3];
    *split = count > 1;
    for (int i = 0; i < count; i++)
        weights[i] = 1;
    if (*split || blend <= 0)
        return count;
    weigh(job, blend, shares);
    weights[0] = shares[main_axis];
    for (int a = 0; a < 3; a++)
        if (a != main_axis && shares[a] > 0) {
            weights[count] = shares[a];
            parts[count++] = 2 * a + (middle_of(job, a) < 0);
        }
    return count;
}

bool pel_shear_factor(const struct pel_job *job, bool perspective, const struct pel_shear_settings *settings, int part, bool split,
                      struct pel_shear *s, struct pel_warp *warp, struct pel_error *error)
{
    const int c = part / 2, sign = part % 2 ? -1 : 1;
    const int axes[3][3] = { { 1, 2, 0 }, { 0, 2, 1 }, { 0, 1, 2 } }; /* scanlines run along x where they can: neighbours in memory */
    double eye[3] = { 0, 0, 0 }, start[2], by[2];
    for (int a = 0; perspective && a < 3; a++)
        eye[a] = job->p0[a] + job->s_least * job->d0[a];
    *s = (struct pel_shear) { .perspective = perspective,
                              .slice_from = -1e9,
                              .step = sign * (double)settings->every / settings->supersampling };
    *warp = (struct pel_warp) { .split = split, .axis = c, .sign = sign };
    memcpy(s->axis, axes[c], sizeof s->axis);
    s->first = sign > 0 ? 0 : job->dims[c] - 1;
    s->reference = 0.5 * (job->dims[c] - 1);
    if (perspective && sign * (s->reference - eye[c]) < 0.25 * job->dims[c]) /* the eye is among the slices, or close */
        s->reference = sign > 0 ? job->box_hi[c] : job->box_lo[c];
    if (perspective && sign * (s->reference - eye[c]) <= 1e-6) /* all slices lie behind it */
        return true;
    if (perspective)
        s->slice_from = (eye[c] - s->first) / s->step;
    struct plane_map map;
    struct polygon p;
    map_to_plane(job, perspective, s->axis, eye, s->reference, &map);
    polygon_of_part(job, part, split, &p);
    double lo[2], hi[2], size[2];
    plane_bounds(job, perspective, s->axis, sign, eye, s->reference, &map, &p, lo, hi);
    for (int a = 0; a < 2; a++) {
        if (!(lo[a] < hi[a]))
            return true; /* the picture shows nothing of the box */
        by[a] = spacing_of_rays(job, settings, &map, &p, a);
        start[a] = (floor(lo[a] / by[a]) - 1) * by[a];
        size[a] = ceil((hi[a] - start[a]) / by[a]) + 2;
    }
    if (!(size[0] <= MOST_SIDE && size[1] <= MOST_SIDE && size[0] * size[1] <= MOST_RAYS))
        return pel_fail(error, PEL_ERROR_ARGUMENT,
                        "an intermediate image of %.0f x %.0f rays is too large; ask for fewer rays, or use raycast", size[0], size[1]);
    s->width = (int)size[0], s->height = (int)size[1];
    s->unit = !perspective && by[0] == 1;
    s->slice_count = ((job->dims[c] - 1) * settings->supersampling + settings->every - 1) / settings->every + 1;
    rays_in_slices(job, perspective, eye, start, by, s);
    for (int i = 0; i < 3; i++) {
        double over = perspective ? sign * map.over[i] : map.over[i]; /* the border moves the image by a pixel */
        warp->u[i] = ((perspective ? sign : 1) * map.at[0][i] - start[0] * over) / by[0] + over;
        warp->v[i] = ((perspective ? sign : 1) * map.at[1][i] - start[1] * over) / by[1] + over;
        warp->w[i] = over;
    }
    return true;
}

void pel_shear_slices(const struct pel_job *job, const struct pel_shear_settings *settings, const struct pel_shear *s,
                      struct pel_slice *slices)
{
    const int c = s->axis[2], sign = s->step > 0 ? 1 : -1;
    for (int m = 0; m < s->slice_count; m++) {
        struct pel_slice *to = &slices[m];
        double k = s->first + sign * (double)(m * settings->every) / settings->supersampling;
        k = fmin(fmax(k, 0), job->dims[c] - 1); /* the last of fewer slices may lie beyond the voxels */
        to->voxel = (int)k < job->last_cell[c] ? (int)k : job->last_cell[c];
        to->weight = (float)(k - to->voxel);
        to->cell = (int)k >> PEL_CELL_SHIFT;
        double at = s->perspective ? fmax(m, s->slice_from + 1e-6) : m; /* a slab that begins behind the eye */
        to->i = s->i.at0 + at * s->i.at1, to->di = s->i.by0 + at * s->i.by1;
        to->j = s->j.at0 + at * s->j.at1, to->dj = s->j.by0 + at * s->j.by1;
        to->whole = s->unit ? (int)floor(to->i) : 0;
        to->part = (float)(to->i - to->whole);
        const int32_t weight = s->unit ? (int32_t)(to->part * 16384.0f + 0.5f) : 0;
        to->pair = (weight << 16) | (16384 - weight);
    }
    for (int m = s->slice_count - 1; m >= 0; m--)
        slices[m].layer_last = m + 1 < s->slice_count && slices[m + 1].cell == slices[m].cell ? slices[m + 1].layer_last : m;
}
