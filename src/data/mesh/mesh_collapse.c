/* SPDX-License-Identifier: MIT */
/* Vertices at one place, made one. Where a voxel is exactly the isovalue, each edge that is cut there has its vertex at the voxel, and
 * triangles between them have no area. An edge between two vertices at one place is contracted where that leaves the surface what it was:
 * where the vertices that both ends are joined to are those of the triangles on the edge and no others (the link condition: Dey,
 * Edelsbrunner, Guha and Nekhayev, Topology preserving edge contraction, 1999). Then V - E + F stays, and every edge still has two
 * triangles. Elsewhere, as on a sheet of such voxels, edges would come to have four triangles, and the vertices stay apart. */
#include <pellucid/mesh.h>

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"

enum { MOST_NEIGHBOURS = 60 };
#define NONE UINT32_MAX

/* A corner that a triangle has at a doubled vertex, in the list of that vertex. */
struct corner {
    size_t triangle, next; /* in `corners`; 0: the last */
};

/* A vertex that shares its place with one that it is joined to. */
struct doubled {
    uint32_t vertex, into; /* into: itself, or that with which it was made one, or NONE where it is gone with all around it */
    size_t first, last;    /* in `corners`, from 1 on */
};

struct collapse {
    struct pel_mesh *mesh;
    uint32_t *of;            /* of each vertex: its number in `doubled` from 1 on, or 0 */
    struct doubled *doubled; /* from 1 on */
    struct corner *corners;  /* from 1 on */
    size_t doubled_count, corner_count;
    bool *gone;   /* triangles */
    size_t *flat; /* triangles without area */
    size_t flat_count, flat_room;
};

/* What lies around a vertex: what it is joined to, and by how many triangles. */
struct ring {
    int count, triangles;
    uint32_t vertex[MOST_NEIGHBOURS];
    int times[MOST_NEIGHBOURS];
    bool open, strange; /* an edge has one triangle; has three, or there is no room here */
};

static bool same_place(const struct pel_mesh *mesh, uint32_t a, uint32_t b)
{
    const float *p = mesh->positions[a], *q = mesh->positions[b];
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

/* ---- finding them ---- */

static bool is_flat(const struct pel_mesh *mesh, size_t triangle)
{
    const uint32_t *t = mesh->triangles[triangle];
    return same_place(mesh, t[0], t[1]) || same_place(mesh, t[1], t[2]) || same_place(mesh, t[2], t[0]);
}

static bool note_flat(struct collapse *c, size_t triangle, struct pel_error *error)
{
    if (c->flat_count == c->flat_room) {
        size_t room = c->flat_room ? 2 * c->flat_room : 1024;
        size_t *more = room <= SIZE_MAX / sizeof *more ? realloc(c->flat, room * sizeof *more) : NULL;
        if (!more)
            return pel_fail(error, PEL_ERROR_MEMORY, "no memory for %zu triangles without area", room);
        c->flat = more;
        c->flat_room = room;
    }
    c->flat[c->flat_count++] = triangle;
    return true;
}

/* Numbers the doubled vertices; triangles without area are those that have them. */
static bool find_doubled(struct collapse *c, struct pel_error *error)
{
    const struct pel_mesh *mesh = c->mesh;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (!is_flat(mesh, t))
            continue;
        if (!note_flat(c, t, error))
            return false;
        for (int i = 0; i < 3; i++) {
            uint32_t a = mesh->triangles[t][i], b = mesh->triangles[t][(i + 1) % 3];
            if (same_place(mesh, a, b)) {
                c->of[a] = c->of[a] ? c->of[a] : (uint32_t)++c->doubled_count;
                c->of[b] = c->of[b] ? c->of[b] : (uint32_t)++c->doubled_count;
            }
        }
    }
    return true;
}

static bool list_corners(struct collapse *c, struct pel_error *error)
{
    const struct pel_mesh *mesh = c->mesh;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 0; i < 3; i++)
            c->corner_count += c->of[mesh->triangles[t][i]] != 0;
    c->doubled = pel_alloc(c->doubled_count + 1, sizeof *c->doubled, "doubled vertices", error);
    c->corners = pel_alloc(c->corner_count + 1, sizeof *c->corners, "corners of doubled vertices", error);
    c->gone = pel_alloc(mesh->triangle_count, sizeof *c->gone, "marks of triangles", error);
    if (!c->doubled || !c->corners || !c->gone)
        return false;
    size_t at = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 0; i < 3; i++) {
            uint32_t v = mesh->triangles[t][i];
            struct doubled *d = &c->doubled[c->of[v]];
            if (!c->of[v])
                continue;
            c->corners[++at] = (struct corner) { t, 0 };
            if (d->last)
                c->corners[d->last].next = at;
            else
                *d = (struct doubled) { v, v, at, at };
            d->last = at;
        }
    return true;
}

/* ---- contracting edges ---- */

static struct doubled *doubled_of(const struct collapse *c, uint32_t vertex)
{
    return &c->doubled[c->of[vertex]];
}

static void add_neighbour(struct ring *ring, uint32_t vertex)
{
    int i = 0;
    while (i < ring->count && ring->vertex[i] != vertex)
        i++;
    if (i == MOST_NEIGHBOURS) {
        ring->strange = true;
        return;
    }
    if (i == ring->count) {
        ring->vertex[ring->count] = vertex;
        ring->times[ring->count++] = 0;
    }
    ring->times[i]++;
}

static void look_around(const struct collapse *c, uint32_t vertex, struct ring *ring)
{
    ring->count = ring->triangles = 0;
    ring->open = ring->strange = false;
    for (size_t at = doubled_of(c, vertex)->first; at; at = c->corners[at].next) {
        const size_t t = c->corners[at].triangle;
        if (c->gone[t])
            continue;
        ring->triangles++;
        for (int i = 0; i < 3; i++)
            if (c->mesh->triangles[t][i] != vertex)
                add_neighbour(ring, c->mesh->triangles[t][i]);
    }
    for (int i = 0; i < ring->count; i++) {
        ring->open |= ring->times[i] == 1;
        ring->strange |= ring->times[i] > 2;
    }
}

static int times_of(const struct ring *ring, uint32_t vertex)
{
    for (int i = 0; i < ring->count; i++)
        if (ring->vertex[i] == vertex)
            return ring->times[i];
    return 0;
}

/* All of a surface that is two triangles of `a` about the edge and one more of each end: a tetrahedron, or a lone triangle. */
static bool is_least(const struct ring *a, const struct ring *b, int on_edge)
{
    return on_edge == 2 ? a->triangles == 3 && b->triangles == 3 && !a->open && !b->open : a->triangles == 1 && b->triangles == 1;
}

/* The last of a surface that is a point, and no surface at all: takes it away where it is one. */
static void remove_point(struct collapse *c, uint32_t vertex, const struct ring *ring)
{
    for (int i = 0; i < ring->count; i++)
        if (!same_place(c->mesh, vertex, ring->vertex[i]) || !c->of[ring->vertex[i]])
            return;
    for (int i = 0; i <= ring->count; i++) {
        struct doubled *d = doubled_of(c, i < ring->count ? ring->vertex[i] : vertex);
        d->into = NONE;
        for (size_t at = d->first; at; at = c->corners[at].next)
            c->gone[c->corners[at].triangle] = true;
    }
}

static void merge(struct collapse *c, uint32_t kept, uint32_t other)
{
    struct doubled *to = doubled_of(c, kept), *from = doubled_of(c, other);
    for (size_t at = from->first; at; at = c->corners[at].next) {
        uint32_t *t = c->mesh->triangles[c->corners[at].triangle];
        if (t[0] == kept || t[1] == kept || t[2] == kept)
            c->gone[c->corners[at].triangle] = true;
        for (int i = 0; i < 3 && !c->gone[c->corners[at].triangle]; i++)
            t[i] = t[i] == other ? kept : t[i];
    }
    c->corners[to->last].next = from->first;
    to->last = from->last;
    from->into = kept;
}

/* Whether something was done. */
static bool contract(struct collapse *c, uint32_t a, uint32_t b)
{
    struct ring around[2];
    int common = 0;
    look_around(c, a, &around[0]);
    look_around(c, b, &around[1]);
    const int on_edge = times_of(&around[0], b);
    if (around[0].strange || around[1].strange || (on_edge == 2 && around[0].open && around[1].open))
        return false;
    for (int i = 0; i < around[0].count; i++)
        common += times_of(&around[1], around[0].vertex[i]) > 0;
    if (common != on_edge)
        return false;
    if (is_least(&around[0], &around[1], on_edge)) {
        remove_point(c, a, &around[0]);
        return doubled_of(c, a)->into == NONE;
    }
    merge(c, a < b ? a : b, a < b ? b : a);
    return true;
}

/* Every edge between two vertices at one place, and again where others gave way. */
static void contract_all(struct collapse *c)
{
    for (bool any = true; any;) {
        size_t left = 0;
        any = false;
        for (size_t k = 0; k < c->flat_count; k++) {
            const size_t triangle = c->flat[k];
            const uint32_t *t = c->mesh->triangles[triangle];
            for (int i = 0; i < 3 && !c->gone[triangle]; i++)
                if (same_place(c->mesh, t[i], t[(i + 1) % 3]))
                    any |= contract(c, t[i], t[(i + 1) % 3]);
            if (!c->gone[triangle])
                c->flat[left++] = triangle;
        }
        c->flat_count = left;
    }
}

/* ---- closing the gaps ---- */

/* Vertices move down to where those that are gone were; `of` becomes each one's new number. */
static void close_vertices(struct collapse *c)
{
    struct pel_mesh *mesh = c->mesh;
    size_t to = 0;
    for (int p = 0; p < mesh->part_count; p++) {
        struct pel_mesh_part *part = &mesh->parts[p];
        const size_t end = part->first_vertex + part->vertex_count, first = to;
        for (size_t v = part->first_vertex; v < end; v++) {
            if (c->of[v] && doubled_of(c, (uint32_t)v)->into != v)
                continue;
            memmove(mesh->positions[to], mesh->positions[v], sizeof *mesh->positions);
            memmove(mesh->normals[to], mesh->normals[v], sizeof *mesh->normals);
            c->of[v] = (uint32_t)to++;
        }
        part->first_vertex = first;
        part->vertex_count = to - first;
    }
    mesh->vertex_count = to;
}

static void close_triangles(struct collapse *c)
{
    struct pel_mesh *mesh = c->mesh;
    size_t to = 0;
    for (int p = 0; p < mesh->part_count; p++) {
        struct pel_mesh_part *part = &mesh->parts[p];
        const size_t end = part->first_triangle + part->triangle_count, first = to;
        for (size_t t = part->first_triangle; t < end; t++) {
            if (c->gone[t])
                continue;
            for (int i = 0; i < 3; i++)
                mesh->triangles[to][i] = c->of[mesh->triangles[t][i]];
            to++;
        }
        part->first_triangle = first;
        part->triangle_count = to - first;
    }
    mesh->triangle_count = to;
}

bool pel_mesh_collapse(struct pel_mesh *mesh, size_t *flat_left, struct pel_error *error)
{
    struct collapse c = { .mesh = mesh };
    c.of = pel_alloc(mesh->vertex_count, sizeof *c.of, "marks of vertices", error);
    bool ok = c.of && find_doubled(&c, error) && (!c.flat_count || list_corners(&c, error));
    if (ok && c.flat_count) {
        contract_all(&c);
        close_vertices(&c);
        close_triangles(&c);
    }
    if (ok && flat_left)
        *flat_left = c.flat_count;
    free(c.of);
    free(c.doubled);
    free(c.corners);
    free(c.gone);
    free(c.flat);
    return ok;
}
