/* SPDX-License-Identifier: MIT */
/* Lab as the CIE defines it with the sRGB primaries and the D65 white; Msh as in K. Moreland, "Diverging Color Maps for Scientific
 * Visualization", 2009: the magnitude of the Lab vector, its angle from the L axis (saturation) and its hue. */
#include "color_space.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
static const double white[3] = { 0.9505, 1, 1.089 }; /* of the matrix below: the sum of each row */

static double decode(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static double encode(double c)
{
    c = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
    return c > 0 ? c < 1 ? c : 1 : 0;
}

static double lab_curve(double t)
{
    return t > 216.0 / 24389 ? cbrt(t) : (t * 24389 / 27 + 16) / 116;
}

static double lab_curve_inverse(double f)
{
    return f > 6.0 / 29 ? f * f * f : (116 * f - 16) * 27 / 24389;
}

static void rgb_to_lab(const double rgb[3], double lab[3])
{
    double r = decode(rgb[0]), g = decode(rgb[1]), b = decode(rgb[2]);
    double x = lab_curve((0.4124 * r + 0.3576 * g + 0.1805 * b) / white[0]);
    double y = lab_curve((0.2126 * r + 0.7152 * g + 0.0722 * b) / white[1]);
    double z = lab_curve((0.0193 * r + 0.1192 * g + 0.9505 * b) / white[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 500 * (x - y);
    lab[2] = 200 * (y - z);
}

static void lab_to_rgb(const double lab[3], double rgb[3])
{
    double fy = (lab[0] + 16) / 116, x = white[0] * lab_curve_inverse(fy + lab[1] / 500), y = lab_curve_inverse(fy),
           z = white[2] * lab_curve_inverse(fy - lab[2] / 200);
    rgb[0] = encode(3.2406255 * x - 1.5372080 * y - 0.4986286 * z);
    rgb[1] = encode(-0.9689307 * x + 1.8757561 * y + 0.0415175 * z);
    rgb[2] = encode(0.0557101 * x - 0.2040211 * y + 1.0569959 * z);
}

static void rgb_to_msh(const double rgb[3], double msh[3])
{
    double lab[3];
    rgb_to_lab(rgb, lab);
    msh[0] = sqrt(lab[0] * lab[0] + lab[1] * lab[1] + lab[2] * lab[2]);
    msh[1] = msh[0] > 0.001 ? acos(fmin(fmax(lab[0] / msh[0], -1), 1)) : 0;
    msh[2] = msh[1] > 0.001 ? atan2(lab[2], lab[1]) : 0;
}

static void msh_to_rgb(const double msh[3], double rgb[3])
{
    double lab[3] = { msh[0] * cos(msh[1]), msh[0] * sin(msh[1]) * cos(msh[2]), msh[0] * sin(msh[1]) * sin(msh[2]) };
    lab_to_rgb(lab, rgb);
}

/* The hue to give to a colour without one, so that the way from a saturated colour to it looks even. */
static double adjusted_hue(const double msh[3], double unsaturated_m)
{
    if (msh[0] >= unsaturated_m - 0.1)
        return msh[2];
    double spin = msh[1] * sqrt(unsaturated_m * unsaturated_m - msh[0] * msh[0]) / (msh[0] * sin(msh[1]));
    return msh[2] > -0.3 * PI ? msh[2] + spin : msh[2] - spin;
}

static void between_msh(const double a[3], const double b[3], double t, double rgb[3])
{
    double p[3], q[3];
    rgb_to_msh(a, p);
    rgb_to_msh(b, q);
    double turn = fabs(p[2] - q[2]);
    turn = turn > PI ? 2 * PI - turn : turn;
    if (p[1] > 0.05 && q[1] > 0.05 && turn > 0.33 * PI) { /* far hues: by way of white */
        double middle = fmax(fmax(p[0], q[0]), 88);
        double *end = t < 0.5 ? q : p;
        end[0] = middle;
        end[1] = end[2] = 0;
        t = t < 0.5 ? 2 * t : 2 * t - 1;
    }
    if (p[1] < 0.05 && q[1] > 0.05)
        p[2] = adjusted_hue(q, p[0]);
    else if (q[1] < 0.05 && p[1] > 0.05)
        q[2] = adjusted_hue(p, q[0]);
    double msh[3];
    for (int c = 0; c < 3; c++)
        msh[c] = p[c] * (1 - t) + q[c] * t;
    msh_to_rgb(msh, rgb);
}

static void rgb_to_hsv(const double rgb[3], double hsv[3])
{
    double most = fmax(fmax(rgb[0], rgb[1]), rgb[2]), least = fmin(fmin(rgb[0], rgb[1]), rgb[2]), d = most - least, h = 0;
    if (d > 0)
        h = most == rgb[0] ? (rgb[1] - rgb[2]) / d : most == rgb[1] ? 2 + (rgb[2] - rgb[0]) / d : 4 + (rgb[0] - rgb[1]) / d;
    hsv[0] = h < 0 ? h / 6 + 1 : h / 6;
    hsv[1] = most > 0 ? d / most : 0;
    hsv[2] = most;
}

static void between_hsv(bool wrap, const double a[3], const double b[3], double t, double rgb[3])
{
    double p[3], q[3], hsv[3];
    rgb_to_hsv(a, p);
    rgb_to_hsv(b, q);
    if (wrap && fabs(p[0] - q[0]) > 0.5)
        *(p[0] > q[0] ? &p[0] : &q[0]) -= 1;
    for (int c = 0; c < 3; c++)
        hsv[c] = p[c] * (1 - t) + q[c] * t;
    hsv[0] -= floor(hsv[0]);
    for (int c = 0; c < 3; c++) {
        double k = fmod(5 - 2 * c + hsv[0] * 6, 6), m = fmin(fmin(k, 4 - k), 1);
        rgb[c] = hsv[2] - hsv[2] * hsv[1] * (m > 0 ? m : 0);
    }
}

void pel_color_between(enum pel_color_space space, bool wrap, const double a[3], const double b[3], double t, double rgb[3])
{
    double p[3], q[3], lab[3];
    switch (space) {
    case PEL_COLOR_SPACE_HSV:
        between_hsv(wrap, a, b, t, rgb);
        return;
    case PEL_COLOR_SPACE_DIVERGING:
        between_msh(a, b, t, rgb);
        return;
    case PEL_COLOR_SPACE_LAB:
        rgb_to_lab(a, p);
        rgb_to_lab(b, q);
        for (int c = 0; c < 3; c++)
            lab[c] = p[c] * (1 - t) + q[c] * t;
        lab_to_rgb(lab, rgb);
        return;
    case PEL_COLOR_SPACE_RGB:
    case PEL_COLOR_SPACE_STEP:
        break;
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = space == PEL_COLOR_SPACE_STEP && t < 1 ? a[c] : a[c] * (1 - t) + b[c] * t;
}
