/* SPDX-License-Identifier: MIT */
/* The two halves of the reference below its rays: the reconstructed signal (reference_signal.c) and the transfer function's integral over
 * values (reference_integral.c). Private to src/cpu/reference*.c; docs/optics.md names every paragraph that is cited here. */
#ifndef PEL_CPU_REFERENCE_PARTS_H
#define PEL_CPU_REFERENCE_PARTS_H

#include <pellucid/scene.h>

/* Display colour to linear light and back (IEC 61966-2-1), one channel, 0..1. */
double pel_reference_decode(double display);
double pel_reference_encode(double linear);

/* The transfer function's colour at a value; in linear light if asked. */
void pel_reference_color(const struct pel_transfer *transfer, bool linear_light, double value, double rgb[3]);

/* The signal: a volume as its samples are reconstructed. */
struct pel_reference_signal {
    const struct pel_volume *volume;
    const struct pel_transfer *transfer;
    bool nearest;           /* else trilinear */
    bool linear_light;
    double to_index[3][3];  /* index = to_index * (world - origin); its transpose turns index gradients into world gradients */
    double lo[3], hi[3];    /* the volume's box in index space */
};

void pel_reference_signal_init(struct pel_reference_signal *signal, const struct pel_scene *scene);

/* "Value": the reconstructed value at an index position; false where it is void. */
bool pel_reference_value(const struct pel_reference_signal *signal, const double index[3], double *value);

/* "Classification", post and pre: opacity for one unit distance, and colour; false where void. Where the opacity is 0, black. */
bool pel_reference_classify_post(const struct pel_reference_signal *signal, const double index[3], double *opacity, double rgb[3]);
bool pel_reference_classify_pre(const struct pel_reference_signal *signal, const double index[3], double *opacity, double rgb[3]);

/* "Gradient": its unit world vector; false where there is none. */
bool pel_reference_normal(const struct pel_reference_signal *signal, const double index[3], double normal[3]);

/* "Modes", isosurface: where the cubic whose values are s at 1/8, 3/8, 5/8 and 7/8 of the way through a cell, and `ends` at 0 and 1 (NaN:
 * its own), meets the isovalue: between 0 and 1, in order. Gives the number of roots. */
int pel_reference_roots(const double s[4], const double ends[2], double isovalue, double roots[3]);

/* "Opacity": tau of an opacity a unit distance. */
double pel_reference_extinction(double opacity, double unit_distance);

/* "Classification", preintegrated: a stretch of values in which opacity and colour are straight lines, and what T and K have come to
 * where it begins. */
struct pel_reference_piece {
    double value[2];
    double opacity[2];
    double color[2][3];
    double t, k[3];
};

struct pel_reference_integral {
    const struct pel_transfer *transfer;
    bool linear_light;
    size_t count;
    struct pel_reference_piece *pieces; /* owned; they cover all values without a gap */
};

bool pel_reference_integral_init(struct pel_reference_integral *integral, const struct pel_transfer *transfer, bool linear_light,
                                 struct pel_error *error);
void pel_reference_integral_finish(struct pel_reference_integral *integral); /* accepts a zeroed one */

/* Mean extinction and colour between the values f and g. */
void pel_reference_integrate(const struct pel_reference_integral *integral, double f, double g, double *extinction, double rgb[3]);

#endif
