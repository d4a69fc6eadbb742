/* SPDX-License-Identifier: MIT */
/* The surface of the trilinear signal is curved within a cell: on its faces it runs along hyperbolas. What follows puts vertices on it
 * beside those on the edges, which marching cubes stops at. */
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

/* From side to side it is met by lines across the face, on which the bilinear signal is linear. Around a corner, where the cut edges have
 * the lengths a and b, it is the hyperbola g (1 - x/a - y/b) + c x y = 0, met by rays from the corner: with x = t a (1 - s), y = t b s and
 * q = a b c / g it is 1 - t + q s (1 - s) t^2 = 0. Where the segment goes around this corner q is at most 1. */
void pel_curve_start(struct pel_curve *curve, const struct pel_cell_values *v, int face, const int edges[2], const double ends[2][3])
{
    const int axes[2] = { face < 2 ? 1 : 0, face < 4 ? 2 : 1 };
    int along[2] = { edges[0] / 4, edges[1] / 4 }, first[2], second[2];
    *curve = (struct pel_curve) { .corner = along[0] != along[1], .axes = { axes[0], axes[1] }, .low = face % 2 << face / 2 };
    if (curve->corner) {
        pel_cell_edge(edges[0], first);
        pel_cell_edge(edges[1], second);
        curve->low = first[0] == second[0] || first[0] == second[1] ? first[0] : first[1];
        curve->turned = along[0] != axes[0];
    } else {
        curve->axes[0] = along[0];
        curve->axes[1] = axes[along[0] == axes[0]];
        curve->turned = ends[0][curve->axes[1]] > 0.5;
    }
    memcpy(curve->ends[0], ends[curve->turned], sizeof curve->ends[0]);
    memcpy(curve->ends[1], ends[!curve->turned], sizeof curve->ends[1]);
    if (!curve->corner)
        return;
    int low = curve->low, x = 1 << axes[0], y = 1 << axes[1];
    double g = v->corner[low], c = v->corner[low ^ x ^ y] - v->corner[low ^ x] - v->corner[low ^ y] + g;
    for (int i = 0; i < 2; i++)
        curve->sides[i] = fabs(curve->ends[i][axes[i]] - (low >> axes[i] & 1));
    curve->q = curve->sides[0] * curve->sides[1] * c / g;
    if (!(curve->q <= 1)) /* a cut in the corner itself, or rounding */
        curve->q = 0;
}

void pel_curve_at(const struct pel_curve *curve, const struct pel_cell_values *v, double part, double place[3])
{
    const int *axes = curve->axes, low = curve->low;
    for (int a = 0; a < 3; a++)
        place[a] = curve->ends[0][a] + part * (curve->ends[1][a] - curve->ends[0][a]);
    if (curve->corner) {
        const double ends[2] = { (1 - part) * curve->sides[0], part * curve->sides[1] };
        double t = 2 / (1 + sqrt(1 - 4 * curve->q * part * (1 - part)));
        for (int i = 0; i < 2; i++)
            place[axes[i]] = low >> axes[i] & 1 ? 1 - t * ends[i] : t * ends[i];
        return;
    }
    double a = (1 - part) * v->corner[low] + part * v->corner[low | 1 << axes[1]];
    double b = (1 - part) * v->corner[low | 1 << axes[0]] + part * v->corner[low | 1 << axes[0] | 1 << axes[1]];
    double cut = a / (a - b);
    if (cut >= 0 && cut <= 1)
        place[axes[0]] = cut;
}

double pel_curve_off(const double place[3], const double from[3], const double to[3])
{
    double line[3], way[3], across[3];
    pel_sub(to, from, line);
    pel_sub(place, from, way);
    pel_cross(line, way, across);
    double length = pel_length(line);
    return length > 0 ? pel_length(across) / length : 0;
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
