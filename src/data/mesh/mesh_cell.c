/* SPDX-License-Identifier: MIT */
/* The surface in one cell: its loops, their vertices, their triangles. Marching cubes ends with vertices on edges. Where a tolerance is
 * asked for, a segment over a face that bends more than it gets one or three vertices on its way, which both cells beside the face find as
 * they look at its four values alone; and a loop that bulges more than it is filled around a vertex in its middle, with a ring about it if
 * need be. */
#include <math.h>
#include <string.h>

#include "mesh_brick.h"
#include "vec.h"

/* A corner of a loop. */
struct point {
    double place[3]; /* in the cell, 0 to 1 */
    uint32_t vertex;
};

struct cell {
    struct pel_brick *brick;
    const int *at;
    struct pel_cell_values values;
    const struct pel_cell_entry *entry;
    struct point cuts[12]; /* by edge */
};

/* ---- vertices ---- */

/* Central difference at a voxel along an axis. Voxels beyond the volume are the last one, as for the ray caster; voids count as the voxel
 * itself, where the ray caster has no gradient: a surface in a file has no other light to fall back on. */
static double slope(const double *value, int axis)
{
    static const int strides[3] = { 1, PEL_BRICK_HALO, PEL_BRICK_HALO * PEL_BRICK_HALO };
    double low = value[-strides[axis]], high = value[strides[axis]];
    return ((isnan(high) ? *value : high) - (isnan(low) ? *value : low)) / 2;
}

/* The ray caster's gradient: differences at the corners, interpolated. Those corners alone count that the place is not all the way from: on
 * an edge two. */
static void gradient_at(const struct cell *c, const double place[3], double g[3])
{
    int base = 0, free = 0; /* bits an axis: where the place is at the upper end, and where it is between the ends */
    for (int a = 0; a < 3; a++) {
        base |= (place[a] == 1) << a;
        free |= (place[a] > 0 && place[a] < 1) << a;
    }
    g[0] = g[1] = g[2] = 0;
    for (int part = free;; part = (part - 1) & free) { /* all subsets of the free axes */
        const double *value = pel_brick_corner(c->brick, c->at, base | part);
        double weight = 1;
        for (int a = 0; a < 3; a++)
            weight *= free >> a & 1 ? part >> a & 1 ? place[a] : 1 - place[a] : 1;
        for (int a = 0; a < 3; a++)
            g[a] += weight * slope(value, a);
        if (!part)
            break;
    }
}

/* Where the differences cancel: towards where the cell's values rise, for a vertex on an edge along that alone (each cell beside it says
 * the same). */
static void rise_of(const struct cell *c, const double place[3], int edge_axis, double g[3])
{
    for (int a = 0; a < 3; a++)
        g[a] = 0;
    for (int corner = 0; corner < 8; corner++)
        for (int a = 0; a < 3; a++) {
            bool off = false; /* the corner is no end of the edge */
            for (int b = 0; b < 3 && edge_axis >= 0; b++)
                off |= b != edge_axis && (place[b] > 0.5) != (corner >> b & 1);
            if (edge_axis < 0 || (a == edge_axis && !off))
                g[a] += (corner >> a & 1 ? 1 : -1) * (c->values.corner[corner] >= 0 ? 1 : -1);
        }
    if (g[0] == 0 && g[1] == 0 && g[2] == 0)
        g[2] = 1;
}

/* `edge_axis`: negative where the vertex lies on no edge. */
static bool make_vertex(const struct cell *c, const double place[3], int edge_axis, uint32_t *number)
{
    const struct pel_mesh_work *w = c->brick->work;
    double index[3], g[3], n[3];
    float position[3], normal[3];
    for (int a = 0; a < 3; a++)
        index[a] = (double)(c->brick->first[a] + (size_t)c->at[a]) + place[a];
    gradient_at(c, place, g);
    double most = fmax(fmax(fabs(g[0]), fabs(g[1])), fabs(g[2]));
    if (!(most > 0 && most <= 1e300)) {
        rise_of(c, place, edge_axis, g);
        most = 1;
    }
    for (int i = 0; i < 3; i++)
        n[i] = -pel_dot(w->normal[i], g) / most;
    pel_normalize(n);
    for (int i = 0; i < 3; i++) {
        position[i] = (float)pel_dot(w->to_world[i], index);
        normal[i] = (float)n[i];
    }
    return pel_mesh_add_vertices(c->brick->slab, (const float(*)[3])&position, (const float(*)[3])&normal, 1, number, c->brick->error);
}

/* The vertex of a kind at one of the cell's corners, made where it is not there yet. */
static bool share_vertex(const struct cell *c, int kind, int corner, struct point *point)
{
    uint32_t *slot = &c->brick->numbers->at[kind][c->at[2] + (corner >> 2)][c->at[1] + (corner >> 1 & 1)][c->at[0] + (corner & 1)];
    if (*slot == PEL_NO_VERTEX && !make_vertex(c, point->place, kind < 3 ? kind : -1, slot))
        return false;
    point->vertex = *slot;
    return true;
}

/* ---- loops ---- */

/* Of the two segments that a face may have, the second is that without the face's lowest edge. */
static int face_kind(int face, const int edges[2])
{
    const int lowest = 4 * (face < 2 ? 1 : 0) + (face < 4 ? face % 2 : face % 2 * 2);
    return 3 + (2 * (face / 2) + (edges[0] != lowest && edges[1] != lowest)) * PEL_BRICK_BENDS;
}

/* The vertices on the way of a segment, appended in the order of the loop; -1 on failure, else how many. At halves, and where that is not
 * enough, at quarters. */
static int bend(struct cell *c, int face, const int edges[2], struct point *points)
{
    const double tolerance = c->brick->work->tolerance;
    const double(*ends)[3] =
        (const double[2][3]) { { c->cuts[edges[0]].place[0], c->cuts[edges[0]].place[1], c->cuts[edges[0]].place[2] },
                               { c->cuts[edges[1]].place[0], c->cuts[edges[1]].place[1], c->cuts[edges[1]].place[2] } };
    struct pel_curve curve;
    double places[PEL_BRICK_BENDS][3];
    int count = 0;
    pel_curve_start(&curve, &c->values, face, edges, ends);
    for (int i = 0; i < PEL_BRICK_BENDS; i++)
        pel_curve_at(&curve, &c->values, (i + 1) / 4.0, places[i]);
    if (pel_curve_off(places[1], curve.ends[0], curve.ends[1]) <= tolerance)
        return 0;
    const bool there[3] = { pel_curve_off(places[0], curve.ends[0], places[1]) > tolerance, true,
                            pel_curve_off(places[2], places[1], curve.ends[1]) > tolerance };
    for (int i = 0; i < PEL_BRICK_BENDS; i++) {
        const int at = curve.turned ? PEL_BRICK_BENDS - 1 - i : i;
        if (!there[at])
            continue;
        memcpy(points[count].place, places[at], sizeof places[at]);
        if (!share_vertex(c, face_kind(face, edges) + at, face % 2 << face / 2, &points[count]))
            return -1;
        count++;
    }
    return count;
}

enum { MOST_POINTS = 12 * (1 + PEL_BRICK_BENDS) };

/* The corners of a loop: where edges are cut, and with a tolerance where segments bend. Returns how many, or 0 on failure. */
static int trace(struct cell *c, const struct pel_cell_loop *loop, struct point points[MOST_POINTS])
{
    int count = 0;
    for (int i = 0; i < loop->count; i++) {
        const int at = loop->first + i, after = loop->first + (i + 1) % loop->count;
        const int edges[2] = { c->entry->edges[at], c->entry->edges[after] };
        points[count++] = c->cuts[edges[0]];
        int bends = c->brick->work->tolerance > 0 ? bend(c, c->entry->faces[at], edges, points + count) : 0;
        if (bends < 0)
            return 0;
        count += bends;
    }
    return count;
}

static bool add_triangle(const struct cell *c, uint32_t p, uint32_t q, uint32_t r)
{
    bool mirrored = c->brick->work->mirrored;
    return pel_mesh_add_triangle(c->brick->slab, p, mirrored ? r : q, mirrored ? q : r, c->brick->error);
}

/* A ring of vertices halfway to the middle, where straight lines to the middle would leave the surface. Its triangles, and the ring in the
 * place of the points. False on failure. */
static bool add_ring(const struct cell *c, struct point *points, int count, const double middle[3])
{
    struct point ring[MOST_POINTS];
    double farthest = 0;
    for (int i = 0; i < count; i++) {
        for (int a = 0; a < 3; a++)
            ring[i].place[a] = (points[i].place[a] + middle[a]) / 2;
        farthest = fmax(farthest, pel_curve_to_surface(&c->values, ring[i].place));
    }
    if (!(farthest > c->brick->work->tolerance))
        return true;
    for (int i = 0; i < count; i++)
        if (!make_vertex(c, ring[i].place, -1, &ring[i].vertex))
            return false;
    for (int i = 0; i < count; i++) {
        const int next = (i + 1) % count;
        if (!add_triangle(c, points[i].vertex, points[next].vertex, ring[next].vertex) ||
            !add_triangle(c, points[i].vertex, ring[next].vertex, ring[i].vertex))
            return false;
    }
    memcpy(points, ring, (size_t)count * sizeof *points);
    return true;
}

static bool fill_around(const struct cell *c, struct point *points, int count, const double middle[3])
{
    uint32_t centre;
    if ((c->brick->work->tolerance > 0 && !add_ring(c, points, count, middle)) || !make_vertex(c, middle, -1, &centre))
        return false;
    for (int i = 0; i < count; i++)
        if (!add_triangle(c, points[i].vertex, points[(i + 1) % count].vertex, centre))
            return false;
    return true;
}

static bool fill(struct cell *c, const struct pel_cell_loop *loop)
{
    const double tolerance = c->brick->work->tolerance;
    struct point points[MOST_POINTS];
    double middle[3] = { 0, 0, 0 };
    int count = trace(c, loop, points);
    for (int i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            middle[a] += points[i].place[a] / count;
    double bulge = tolerance > 0 ? pel_curve_to_surface(&c->values, middle) : 0;
    if (!count)
        return false;
    if (!loop->triangles || count > loop->count || bulge > tolerance)
        return fill_around(c, points, count, middle);
    for (int i = loop->first_triangle; i < loop->first_triangle + loop->triangles; i++) {
        const uint8_t *edges = c->entry->triangles[i];
        if (!add_triangle(c, c->cuts[edges[0]].vertex, c->cuts[edges[1]].vertex, c->cuts[edges[2]].vertex))
            return false;
    }
    return true;
}

/* ---- cells ---- */

/* Where insides join on an ambiguous face: the saddle of the bilinear signal is inside where the product of the values inside is at least
 * that of the values outside (Nielson and Hamann 1991, equation 4, without the division). Both cells beside the face multiply the same. */
static const struct pel_cell_entry *entry_of(const struct pel_cell_table *table, const struct pel_cell_values *values, unsigned inside)
{
    unsigned way = 0, ways = 0;
    for (int face = 0; table->ambiguous[inside] >> face; face++) {
        int corners[4];
        if (!(table->ambiguous[inside] >> face & 1))
            continue;
        pel_cell_face(face, corners);
        const double *v = values->corner;
        double even = v[corners[0]] * v[corners[2]], odd = v[corners[1]] * v[corners[3]];
        bool even_inside = inside >> corners[0] & 1;
        way |= (unsigned)(even_inside ? even >= odd : odd >= even) << ways++;
    }
    return &table->entries[table->first[inside] + way];
}

static void cell_values(const struct pel_brick *brick, const int at[3], struct pel_cell_values *values)
{
    for (int corner = 0; corner < 8; corner++)
        values->corner[corner] = *pel_brick_corner(brick, at, corner);
}

const struct pel_cell_entry *pel_cell_entry_of(const struct pel_brick *brick, const int at[3], unsigned inside)
{
    struct pel_cell_values values;
    cell_values(brick, at, &values);
    return entry_of(brick->work->table, &values, inside);
}

bool pel_cell_cut(struct pel_brick *brick, const int at[3], unsigned inside)
{
    struct cell c;
    c.brick = brick;
    c.at = at;
    cell_values(brick, at, &c.values);
    c.entry = entry_of(brick->work->table, &c.values, inside);
    for (int l = 0; l < c.entry->loops; l++)
        for (int i = 0; i < c.entry->loop[l].count; i++) {
            int edge = c.entry->edges[c.entry->loop[l].first + i], corners[2];
            pel_cell_edge(edge, corners);
            pel_curve_on_edge(&c.values, edge, c.cuts[edge].place);
            if (!share_vertex(&c, edge / 4, corners[0], &c.cuts[edge]))
                return false;
        }
    for (int l = 0; l < c.entry->loops; l++)
        if (!fill(&c, &c.entry->loop[l]))
            return false;
    return true;
}
