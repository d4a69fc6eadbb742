/* SPDX-License-Identifier: MIT */
/* The surface of the trilinear signal is curved within a cell: on its faces it runs along hyperbolas. What follows puts vertices on it beside
 * those on the edges, which marching cubes stops at. */
#include <math.h>
#include <string.h>

#include "mesh_brick.h"
#include "vec.h"

void pel_curve_on_edge(const struct pel_cell_values *v, int edge, double place[3])
{
    int corners[2];
    pel_cell_edge(edge, corners);
    double low = v->corner[corners[0]], part = low / (low - v->corner[corners[1]]);
    for (int a = 0; a < 3; a++)
        place[a] = corners[0] >> a & 1;
    place[edge / 4] = part >= 0 && part <= 1 ? part : 0.5; /* values so large that their difference is not finite */
}

/* Between opposite edges: halfway, on the line across, where the bilinear signal is linear. `along`: the axis of the two edges; `lean`: how
 * far apart along it the cuts are. */
static double straight(const struct pel_cell_values *v, int face, int along, int across, double lean, double place[3])
{
    const int low = face % 2 << face / 2;
    double a = v->corner[low] + v->corner[low | 1 << across], b = v->corner[low | 1 << along] + v->corner[low | 1 << along | 1 << across];
    double part = a / (a - b), away = fabs(part - place[along]);
    if (!(part >= 0 && part <= 1))
        return 0;
    place[along] = part;
    return away / hypot(1, lean);
}

/* Around a corner, between the cuts of the two edges that meet in it: where the diagonal from the corner to the opposite corner of the
 * rectangle with sides a and b meets the hyperbola g (1 - x/a - y/b) + c x y = 0. On it x = t a, y = t b, so 1 - 2 t + q t^2 = 0 with
 * q = a b c / g, which is at most 1 where the segment goes around this corner. */
static double around(const struct pel_cell_values *v, int corner, const int axes[2], const double ends[2][3], double place[3])
{
    double g = v->corner[corner];
    double c = v->corner[corner ^ 1 << axes[0] ^ 1 << axes[1]] - v->corner[corner ^ 1 << axes[0]] - v->corner[corner ^ 1 << axes[1]] + g;
    double sides[2];
    for (int i = 0; i < 2; i++) /* the end that lies off the corner along the axis */
        sides[i] = fmax(fabs(ends[0][axes[i]] - (corner >> axes[i] & 1)), fabs(ends[1][axes[i]] - (corner >> axes[i] & 1)));
    double q = sides[0] * sides[1] * c / g;
    if (!(q <= 1)) /* a cut in the corner itself */
        return 0;
    double t = 1 / (1 + sqrt(1 - q));
    for (int i = 0; i < 2; i++)
        place[axes[i]] = corner >> axes[i] & 1 ? 1 - t * sides[i] : t * sides[i];
    double length = hypot(sides[0], sides[1]);
    return length > 0 ? fabs(2 * t - 1) * sides[0] * sides[1] / length : 0;
}

double pel_curve_on_face(const struct pel_cell_values *v, int face, const int edges[2], const double ends[2][3], double place[3])
{
    const int axes[2] = { face < 2 ? 1 : 0, face < 4 ? 2 : 1 };
    int first[2], second[2];
    for (int a = 0; a < 3; a++)
        place[a] = (ends[0][a] + ends[1][a]) / 2;
    if (edges[0] / 4 == edges[1] / 4)
        return straight(v, face, edges[0] / 4, axes[edges[0] / 4 == axes[0]], ends[0][edges[0] / 4] - ends[1][edges[0] / 4], place);
    pel_cell_edge(edges[0], first);
    pel_cell_edge(edges[1], second);
    int corner = first[0] == second[0] || first[0] == second[1] ? first[0] : first[1];
    return around(v, corner, axes, ends, place);
}

/* Value and gradient of the trilinear signal. */
static double signal(const struct pel_cell_values *v, const double p[3], double gradient[3])
{
    const double *c = v->corner;
    double x[4], dx[4];
    for (int i = 0; i < 4; i++) {
        dx[i] = c[2 * i + 1] - c[2 * i];
        x[i] = c[2 * i] + p[0] * dx[i];
    }
    double low = x[0] + p[1] * (x[1] - x[0]), high = x[2] + p[1] * (x[3] - x[2]);
    double dx_low = dx[0] + p[1] * (dx[1] - dx[0]), dx_high = dx[2] + p[1] * (dx[3] - dx[2]);
    gradient[0] = dx_low + p[2] * (dx_high - dx_low);
    gradient[1] = (x[1] - x[0]) + p[2] * ((x[3] - x[2]) - (x[1] - x[0]));
    gradient[2] = high - low;
    return low + p[2] * (high - low);
}

/* Newton's steps along the gradient; the surface is nearly flat over a cell, or the way leads out of it. A vertex amidst the cell stays off
 * its faces, where it would lie among the neighbour's triangles. */
double pel_curve_to_surface(const struct pel_cell_values *v, double place[3])
{
    const double edge = 1e-3;
    double p[3] = { place[0], place[1], place[2] }, gradient[3], first = fabs(signal(v, p, gradient)), value = first;
    for (int i = 0; i < 5 && value != 0; i++) {
        double square = pel_dot(gradient, gradient), g = signal(v, p, gradient);
        if (!(square > 0) || !isfinite(g))
            return 0;
        for (int a = 0; a < 3; a++)
            p[a] = pel_clamp(p[a] - g * gradient[a] / square, edge, 1 - edge);
        value = fabs(signal(v, p, gradient));
    }
    double way[3];
    pel_sub(p, place, way);
    if (!(value < 0.01 * first))
        return 0;
    memcpy(place, p, sizeof p);
    return pel_length(way);
}
