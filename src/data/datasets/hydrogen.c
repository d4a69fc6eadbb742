/* SPDX-License-Identifier: MIT */
/* The hydrogen atom: the probability density |psi(n,l,m)|^2 of the electron, in atomic units (lengths in Bohr radii). The complex orbitals
 * (eigenfunctions of L_z) are meant, so the density is symmetric about z:
 *   |psi|^2 = R_nl(r)^2 N_lm^2 P_lm(cos theta)^2
 * The factorials of the textbook formulas overflow soon; both parts are built by three-term recurrences of functions that are already
 * normalised, which stay near 1 for any n, l and m. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"
#include "formula.h"
#include "grid.h"

#define MAX_N 64

struct hydrogen {
    int size, n, l, m;
    double extent; /* half the cube's edge; 0 (not given): chosen */
};

/* Coefficients of the recurrences; they depend on n, l and m alone. */
struct orbital {
    int n, l, m;
    double scale;                              /* of R^2: (2/n)^3 / (2n) */
    double start;                              /* normalised P_mm(0), to be multiplied by sin(theta)^m */
    double pa[MAX_N + 1], pb[MAX_N + 1];       /* P_k = pa[k] cos(theta) P_(k-1) - pb[k] P_(k-2) */
    double lc[MAX_N + 1], la[MAX_N + 1], lb[MAX_N + 1]; /* L_(k+1) = ((lc[k] - rho) L_k - lb[k] L_(k-1)) la[k] */
};

static void prepare(struct orbital *o, int n, int l, int m)
{
    *o = (struct orbital){ .n = n, .l = l, .m = abs(m) };
    o->scale = 8.0 / n / n / n / (2.0 * n);
    /* Fully normalised associated Legendre functions: the integral of their square over the sphere is 1. */
    double square = 1 / (4 * PEL_PI);
    for (int k = 1; k <= o->m; k++)
        square *= (2 * k + 1) / (2.0 * k);
    o->start = sqrt(square);
    for (int k = o->m + 1; k <= l; k++) {
        double k2 = (double)k * k, m2 = (double)o->m * o->m, j2 = (k - 1.0) * (k - 1.0);
        o->pa[k] = sqrt((4 * k2 - 1) / (k2 - m2));
        o->pb[k] = k - 1 > o->m ? o->pa[k] * sqrt((j2 - m2) / (4 * j2 - 1)) : 0;
    }
    /* Laguerre functions with alpha = 2l + 1, normalised by sqrt(k! / (k + alpha)!). */
    double alpha = 2 * l + 1;
    for (int k = 0; k < n - l - 1; k++) {
        o->lc[k] = 2 * k + 1 + alpha;
        o->la[k] = 1 / sqrt((k + 1) * (k + 1 + alpha));
        o->lb[k] = sqrt(k * (k + alpha));
    }
}

static double angular(const struct orbital *o, double c, double s)
{
    double value = o->start, before = 0;
    for (int k = 0; k < o->m; k++)
        value *= s;
    for (int k = o->m + 1; k <= o->l; k++) {
        double next = o->pa[k] * c * value - o->pb[k] * before;
        before = value;
        value = next;
    }
    return value;
}

/* rho^l e^(-rho/2) L(rho), normalised but for the square root of `scale`. */
static double radial(const struct orbital *o, double r)
{
    double rho = 2 * r / o->n, value = pel_exp(-rho / 2), before = 0;
    for (int i = 1; i <= o->l; i++) /* rho^l / sqrt((2l + 1)!), factor by factor */
        value *= rho / sqrt(2.0 * i * (2 * i + 1));
    for (int k = 0; k < o->n - o->l - 1; k++) {
        double next = ((o->lc[k] - rho) * value - o->lb[k] * before) * o->la[k];
        before = value;
        value = next;
    }
    return value;
}

static void sample(const void *context, const double p[3], float *out)
{
    const struct orbital *o = context;
    double side = sqrt(p[0] * p[0] + p[1] * p[1]), r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    double c = r > 0 ? p[2] / r : 1, s = r > 0 ? side / r : 0;
    double a = angular(o, c, s), b = radial(o, r);
    float density = (float)(a * a * b * b * o->scale);
    *out = density < FLT_MIN ? 0 : density; /* subnormal numbers say nothing here and slow every reader down */
}

/* Beyond the outer turning point of the classical motion the density falls as e^(-2r/n); this much further little is left. */
static double choose_extent(int n, int l)
{
    double turning = n * n * (1 + sqrt(1 - l * (l + 1) / ((double)n * n)));
    return turning + 2.5 * n + 0.5;
}

static bool make(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct hydrogen *p = params;
    if (p->n < 1 || p->n > MAX_N)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "n: %d is not from 1 to %d", p->n, MAX_N);
    if (p->l < 0 || p->l >= p->n)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "l: %d is impossible for n = %d; it must be from 0 to %d", p->l, p->n, p->n - 1);
    if (abs(p->m) > p->l)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "m: %d is impossible for l = %d; it must be from %d to %d", p->m, p->l, -p->l, p->l);
    struct orbital orbital;
    prepare(&orbital, p->n, p->l, p->m);
    double extent = p->extent > 0 ? p->extent : choose_extent(p->n, p->l);
    if (!pel_dataset_fill(volume, p->size, 1, 0, extent, sample, &orbital, error))
        return false;
    strcpy(volume->units, "bohr");
    return true;
}

static const struct pel_option options[] = {
    PEL_DATASET_SIZE_ROW(struct hydrogen, "64"),
    { "n", "Principal number n", "Principal quantum number: the shell", PEL_OPTION_INT, offsetof(struct hydrogen, n), 1, MAX_N, "4", NULL,
      NULL },
    { "l", "Angular number l", "Angular quantum number, from 0 to n - 1", PEL_OPTION_INT, offsetof(struct hydrogen, l), 0, MAX_N - 1, "2",
      NULL, NULL },
    { "m", "Magnetic number m", "Magnetic quantum number, from -l to l", PEL_OPTION_INT, offsetof(struct hydrogen, m), -(MAX_N - 1),
      MAX_N - 1, "0", NULL, NULL },
    { "extent", "Extent", "Half the edge of the cube; chosen from n and l unless given", PEL_OPTION_DOUBLE,
      offsetof(struct hydrogen, extent), 0.01, 1e6, NULL, NULL, "Bohr radii" },
    { NULL },
};

const struct pel_dataset pel_dataset_hydrogen = {
    "hydrogen", "Probability density of the electron of a hydrogen atom, |psi(n,l,m)|^2, per cubic Bohr radius",
    "Schroedinger, Quantisierung als Eigenwertproblem, Annalen der Physik 79, 1926", options, sizeof(struct hydrogen), make,
};
