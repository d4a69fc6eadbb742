/* SPDX-License-Identifier: MIT */
#include "cell_table.h"

#include <string.h>

static int edge_between(int from, int to)
{
    for (int edge = 0;; edge++) {
        int corners[2];
        pel_cell_edge(edge, corners);
        if ((corners[0] | corners[1]) == (from | to) && (corners[0] & corners[1]) == (from & to))
            return edge;
    }
}

/* The two faces that an edge belongs to, a bit each. */
static unsigned faces_of(int edge)
{
    unsigned faces = 0;
    for (int face = 0; face < 6; face++) {
        int corners[4], found = 0, ends[2];
        pel_cell_face(face, corners);
        pel_cell_edge(edge, ends);
        for (int i = 0; i < 4; i++)
            found += corners[i] == ends[0] || corners[i] == ends[1];
        faces |= (found == 2) << face;
    }
    return faces;
}

/* Segments of a face: next[edge] is the edge to which a segment leads. On the way around the face one goes inside at some edges and outside
 * again at others; a segment leads from an edge of the first kind to one of the second. As the cell beyond the face goes around it the
 * other way, its segment leads back. Each edge that is cut is of the first kind on one of its two faces and of the second on the other, so
 * the segments of a cell make closed loops. */
static void add_segments(int face, unsigned inside, int join, int8_t next[12])
{
    int corners[4], edges[4];
    bool in[4];
    pel_cell_face(face, corners);
    for (int i = 0; i < 4; i++) {
        in[i] = inside >> corners[i] & 1;
        edges[i] = edge_between(corners[i], corners[(i + 1) % 4]);
    }
    for (int i = 0; i < 4; i++) {
        if (in[i] || !in[(i + 1) % 4])
            continue;
        int out = join ? 3 : 1; /* joined: back around the corner outside; else on around the corners inside */
        while (!(in[(i + out) % 4] && !in[(i + out + 1) % 4]))
            out += join ? -1 : 1;
        next[edges[i]] = (int8_t)edges[(i + out) % 4];
    }
}

/* The least cost of filling the loop's vertices i .. j, and at which vertex the triangle over (i, j) has its tip. A diagonal that lies in a
 * face is forbidden, as the cell beyond the face might draw the same one, and four triangles would meet in it. Short ones are best. */
enum { FORBIDDEN = 1000 };

static int diagonal_cost(int a, int b)
{
    int p[2], q[2], cost = 0;
    if (faces_of(a) & faces_of(b))
        return FORBIDDEN;
    pel_cell_edge(a, p);
    pel_cell_edge(b, q);
    for (int axis = 0; axis < 3; axis++) {
        int d = (p[0] >> axis & 1) + (p[1] >> axis & 1) - (q[0] >> axis & 1) - (q[1] >> axis & 1);
        cost += d * d;
    }
    return cost;
}

static int fill_costs(const int *loop, int n, int8_t tip[12][12])
{
    int cost[12][12] = { { 0 } };
    for (int span = 2; span < n; span++)
        for (int i = 0; i + span < n; i++) {
            int j = i + span, best = INT32_MAX;
            for (int k = i + 1; k < j; k++)
                if (cost[i][k] + cost[k][j] < best) {
                    best = cost[i][k] + cost[k][j];
                    tip[i][j] = (int8_t)k;
                }
            cost[i][j] = best + (span < n - 1 ? diagonal_cost(loop[i], loop[j]) : 0);
        }
    return cost[0][n - 1];
}

static void add_filled(struct pel_cell_entry *entry, struct pel_cell_loop *of, const int *loop, int i, int j, int8_t tip[12][12])
{
    if (j - i < 2)
        return;
    int k = tip[i][j];
    add_filled(entry, of, loop, i, k, tip);
    uint8_t *triangle = entry->triangles[of->first_triangle + of->triangles++];
    triangle[0] = (uint8_t)loop[i], triangle[1] = (uint8_t)loop[k], triangle[2] = (uint8_t)loop[j];
    add_filled(entry, of, loop, k, j, tip);
}

static void add_loop(struct pel_cell_entry *entry, const int *loop, int n)
{
    struct pel_cell_loop *to = &entry->loop[entry->loops], *before = entry->loops ? to - 1 : NULL;
    int8_t tip[12][12];
    entry->loops++;
    to->first = before ? before->first + before->count : 0;
    to->count = (uint8_t)n;
    to->first_triangle = before ? before->first_triangle + before->triangles : 0;
    for (int i = 0; i < n; i++) {
        entry->edges[to->first + i] = (uint8_t)loop[i];
        entry->faces[to->first + i] = (uint8_t)__builtin_ctz(faces_of(loop[i]) & faces_of(loop[(i + 1) % n]));
    }
    if (fill_costs(loop, n, tip) < FORBIDDEN)
        add_filled(entry, to, loop, 0, n - 1, tip);
}

static void make_entry(struct pel_cell_entry *entry, unsigned inside, unsigned joins)
{
    int8_t next[12];
    memset(next, -1, sizeof next);
    for (int face = 0; face < 6; face++)
        add_segments(face, inside, (int)(joins >> face & 1), next);
    for (int start = 0; start < 12; start++) {
        int loop[12], n = 0;
        for (int at = start; next[at] >= 0; n++) {
            int after = next[at];
            loop[n] = at;
            next[at] = -1;
            at = after;
        }
        if (n)
            add_loop(entry, loop, n);
    }
}

static bool is_ambiguous(int face, unsigned inside)
{
    int corners[4];
    pel_cell_face(face, corners);
    unsigned a = inside >> corners[0] & 1, b = inside >> corners[1] & 1, c = inside >> corners[2] & 1, d = inside >> corners[3] & 1;
    return a == c && b == d && a != b;
}

void pel_cell_table_init(struct pel_cell_table *table)
{
    memset(table, 0, sizeof *table);
    for (unsigned inside = 0; inside < 256; inside++) {
        int faces[6], ways = 0;
        for (int face = 0; face < 6; face++)
            if (is_ambiguous(face, inside)) {
                table->ambiguous[inside] |= (uint8_t)(1u << face);
                faces[ways++] = face;
            }
        table->first[inside] = (uint16_t)table->count;
        for (unsigned way = 0; way < 1u << ways; way++) {
            unsigned joins = 0;
            for (int i = 0; i < ways; i++)
                joins |= (way >> i & 1) << faces[i];
            make_entry(&table->entries[table->count++], inside, joins);
        }
    }
}
