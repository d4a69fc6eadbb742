/* SPDX-License-Identifier: MIT */
/* The little vector maths that set-up code needs, in double. Kernels have their own lanes (src/cpu/simd.h). */
#ifndef PEL_BASE_VEC_H
#define PEL_BASE_VEC_H

#include <math.h>

static inline double pel_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void pel_cross(const double a[3], const double b[3], double out[3])
{
    double r[3] = { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
    out[0] = r[0], out[1] = r[1], out[2] = r[2];
}

static inline double pel_length(const double a[3])
{
    return sqrt(pel_dot(a, a));
}

/* Scales to unit length; returns the length it had. A zero vector stays zero. */
static inline double pel_normalize(double a[3])
{
    double length = pel_length(a);
    if (length > 0)
        for (int i = 0; i < 3; i++)
            a[i] /= length;
    return length;
}

static inline void pel_sub(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static inline double pel_clamp(double x, double lo, double hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

/* Turns v about a unit axis, degrees, right-handed (Rodrigues). */
static inline void pel_rotate(const double v[3], const double axis[3], double degrees, double out[3])
{
    double a = degrees * 3.14159265358979323846 / 180, c = cos(a), s = sin(a), d = pel_dot(axis, v) * (1 - c), x[3];
    pel_cross(axis, v, x);
    for (int i = 0; i < 3; i++)
        x[i] = v[i] * c + x[i] * s + axis[i] * d;
    out[0] = x[0], out[1] = x[1], out[2] = x[2];
}

/* Inverse of a 3x3 matrix (rows); returns its determinant, and leaves `out` alone where that is 0 or not finite. */
static inline double pel_invert3(const double m[3][3], double out[3][3])
{
    double c0[3], c1[3], c2[3];
    pel_cross(m[1], m[2], c0);
    pel_cross(m[2], m[0], c1);
    pel_cross(m[0], m[1], c2);
    double det = pel_dot(m[0], c0);
    if (det != 0 && isfinite(det))
        for (int i = 0; i < 3; i++)
            out[i][0] = c0[i] / det, out[i][1] = c1[i] / det, out[i][2] = c2[i] / det;
    return det;
}

#endif
