/* SPDX-License-Identifier: MIT */
/* Transfer function: colour and opacity as piecewise linear curves over data values.
 *
 * Opacity is what one `unit_distance` of material absorbs: a stretch of length dt has
 * alpha = 1 - (1 - opacity)^(dt / unit_distance), and the extinction coefficient of equation 1.2 of the dissertation (paper 002) is
 * tau = -ln(1 - opacity) / unit_distance. Colours are sRGB display values, 0 to 1. Outside its points a curve keeps the value of
 * its first or last point. Two points at the same value make a jump; at the value itself the second one holds. */
#ifndef PELLUCID_TRANSFER_H
#define PELLUCID_TRANSFER_H

#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct pel_color_point {
    double value;
    double rgb[3];
};

struct pel_opacity_point {
    double value;
    double opacity; /* 0 to 1 */
};

struct pel_transfer {
    struct pel_color_point *colors; /* owned; values never decrease */
    size_t color_count;             /* >= 1 after any successful setter */
    struct pel_opacity_point *opacities;
    size_t opacity_count;
    double unit_distance; /* world length, > 0 */
    char colormap[64];    /* name of the colour map the colours came from, or "" */
};

/* A gray ramp over 0..1 with opacity equal to the value, unit distance 1. Fails only for want of memory. */
bool pel_transfer_init(struct pel_transfer *transfer, struct pel_error *error);
void pel_transfer_finish(struct pel_transfer *transfer);

/* Makes `to` (initialised) equal to `from`. */
bool pel_transfer_copy(struct pel_transfer *to, const struct pel_transfer *from, struct pel_error *error);
bool pel_transfer_equal(const struct pel_transfer *a, const struct pel_transfer *b);

/* Replaces a curve. Points are sorted by value (stable); NaN, infinite values, opacities or colours outside 0..1 and an empty list are
 * refused with PEL_ERROR_ARGUMENT and leave the transfer function as it was. */
bool pel_transfer_set_colors(struct pel_transfer *transfer, const struct pel_color_point *points, size_t count, struct pel_error *error);
bool pel_transfer_set_opacities(struct pel_transfer *transfer, const struct pel_opacity_point *points, size_t count,
                                struct pel_error *error);

/* Stretches a named colour map over [lo, hi] (lo > hi reverses it). Unknown names list the nearest known ones in the error. */
bool pel_transfer_set_colormap(struct pel_transfer *transfer, const char *name, double lo, double hi, struct pel_error *error);

/* Opacity from text: "40:0,80:0.2,255:0.9" gives points value:opacity; a lone number ("0.3") a constant opacity. */
bool pel_transfer_parse_opacity(struct pel_transfer *transfer, const char *text, struct pel_error *error);

/* The curves at a value. NaN gives opacity 0 and black. */
double pel_transfer_opacity(const struct pel_transfer *transfer, double value);
void pel_transfer_color(const struct pel_transfer *transfer, double value, double rgb[3]);

/* Moves the values of all points so that from_lo lands on to_lo and from_hi on to_hi, and all others in proportion; a range that runs the
 * other way reverses the curves. Where from_lo == from_hi there is no width to go by: the values only move, by to_lo - from_lo. */
void pel_transfer_rescale(struct pel_transfer *transfer, double from_lo, double from_hi, double to_lo, double to_hi);

/* A transfer function that shows the object in the volume, chosen from its histogram and gradients: air and noise transparent,
 * materials told apart by colour, boundaries seen. Labels get a colour each. Unit distance is set to the mean spacing. */
enum pel_transfer_purpose {
    PEL_TRANSFER_COMPOSITE,  /* emission and absorption, isosurface colours */
    PEL_TRANSFER_PROJECTION, /* MIP: gray window, opacity ramp */
    PEL_TRANSFER_OPAQUE,     /* MinIP and slices: gray window, opacity 1 */
    PEL_TRANSFER_XRAY,       /* absorption proportional to value, an object's middle neither black nor white */
    PEL_TRANSFER_AVERAGE,    /* average: gray window over the means of rays, which are far below the greatest values */
};
bool pel_transfer_automatic(struct pel_transfer *transfer, const struct pel_volume *volume, enum pel_transfer_purpose purpose,
                            struct pel_error *error);

/* The isovalue that shows the object's outer boundary (from the same histogram and gradients). */
double pel_isovalue_automatic(const struct pel_volume *volume);

/* Named colour maps, in the order in which they are listed to people. `pel_colormap_name` gives NULL at the end. */
const char *pel_colormap_name(size_t index);
/* Colour of a named map at t in 0..1; false where there is no such map. */
bool pel_colormap_lookup(const char *name, double t, double rgb[3]);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
