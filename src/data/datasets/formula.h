/* SPDX-License-Identifier: MIT */
/* Sine, cosine and exponential from additions and multiplications alone. The C library's differ in the last bit between versions and
 * processors; a computed data set must be the same bytes on every machine, and IEEE arithmetic is (this folder is compiled with
 * -ffp-contract=off, so that no multiply-add is fused). Each is within two units in the last place of a double over the range that data
 * sets need. */
#ifndef PEL_DATA_FORMULA_H
#define PEL_DATA_FORMULA_H

#include <math.h>

#define PEL_PI 3.14159265358979323846

/* Taylor series on [-pi/4, pi/4]; the first term left out is below 1e-18. */
static inline double pel_sin_core(double x)
{
    double x2 = x * x, sum = 0;
    for (int k = 17; k >= 3; k -= 2)
        sum = (sum + 1) * -x2 / (k * (k - 1));
    return x + x * sum;
}

static inline double pel_cos_core(double x)
{
    double x2 = x * x, sum = 0;
    for (int k = 18; k >= 2; k -= 2)
        sum = (sum + 1) * -x2 / (k * (k - 1));
    return 1 + sum;
}

/* Any |x| < 1e6: the nearest multiple of pi/2 is taken off in three parts, of which the first two have so few bits that their multiples are
 * exact. */
static inline double pel_reduce(double x, int *quadrant)
{
    double n = floor(x * (2 / PEL_PI) + 0.5);
    *quadrant = (int)((long long)n & 3);
    x -= n * 1.57079632673412561417e+00;
    x -= n * 6.07710050630396597660e-11;
    return x - n * 2.02226624879595063154e-21;
}

static inline double pel_sin(double x)
{
    int q;
    x = pel_reduce(x, &q);
    double v = q & 1 ? pel_cos_core(x) : pel_sin_core(x);
    return q & 2 ? -v : v;
}

static inline double pel_cos(double x)
{
    int q;
    x = pel_reduce(x, &q);
    double v = q & 1 ? pel_sin_core(x) : pel_cos_core(x);
    return q == 1 || q == 2 ? -v : v;
}

/* e^x = 2^n e^r with |r| <= ln(2)/2. */
static inline double pel_exp(double x)
{
    if (x < -745)
        return 0;
    if (x > 709)
        return INFINITY;
    double n = floor(x * 1.44269504088896340736 + 0.5), r = x - n * 6.93147180369123816490e-01 - n * 1.90821492927058770002e-10, sum = 1;
    for (int k = 15; k >= 1; k--)
        sum = 1 + sum * r / k;
    return ldexp(sum, (int)n);
}

#endif
