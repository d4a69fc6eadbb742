/* SPDX-License-Identifier: MIT */
/* Exact roots of isosurfaces (docs/optics.md, "Modes"): along a ray the trilinear signal of a cell is a cubic. */
#include <math.h>

#include "reference_parts.h"

/* Newton's form of the cubic through s[0] to s[3] at k = 0 to 3. */
struct cubic {
    double start, first, second, third;
};

static double value_at(const struct cubic *c, double k)
{
    return c->start + k * (c->first + (k - 1) * (c->second / 2 + (k - 2) * c->third / 6));
}

/* Where the slope, a k^2 + b k + c, is 0 between lo and hi, in order; gives their number. */
static int turns(const struct cubic *cubic, double lo, double hi, double at[2])
{
    double a = cubic->third / 2, b = cubic->second - cubic->third, c = cubic->first - cubic->second / 2 + cubic->third / 3;
    double discriminant = b * b - 4 * a * c, q = -(b + copysign(sqrt(fmax(discriminant, 0)), b)) / 2;
    double both[2] = { fmin(q / a, c / q), fmax(q / a, c / q) }; /* not finite where there is but one */
    int count = 0;
    for (int i = 0; i < 2 && discriminant > 0; i++)
        if (both[i] > lo && both[i] < hi && (!count || both[i] > at[0]))
            at[count++] = both[i];
    return count;
}

int pel_reference_roots(const double s[4], const double ends[2], double isovalue, double roots[3])
{
    const struct cubic cubic = { s[0], s[1] - s[0], s[2] - 2 * s[1] + s[0], s[3] - 3 * s[2] + 3 * s[1] - s[0] };
    double at[4] = { -0.5 }, value[4] = { isnan(ends[0]) ? value_at(&cubic, -0.5) : ends[0] };
    int pieces = 1 + turns(&cubic, -0.5, 3.5, at + 1), count = 0;
    for (int i = 1; i < pieces; i++)
        value[i] = value_at(&cubic, at[i]);
    at[pieces] = 3.5;
    value[pieces] = isnan(ends[1]) ? value_at(&cubic, 3.5) : ends[1];
    for (int i = 0; i < pieces; i++) {
        double lo = at[i], hi = at[i + 1];
        if ((value[i] < isovalue) == (value[i + 1] < isovalue))
            continue;
        for (int halving = 0; halving < 46; halving++) {
            double middle = lo + 0.5 * (hi - lo);
            if ((value_at(&cubic, middle) < isovalue) == (value[i] < isovalue))
                lo = middle;
            else
                hi = middle;
        }
        roots[count++] = (lo + 0.5 * (hi - lo) + 0.5) / 4;
    }
    return count;
}
