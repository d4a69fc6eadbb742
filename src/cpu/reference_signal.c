/* SPDX-License-Identifier: MIT */
/* The signal that the reference integrates: reconstruction, classification at a point, gradient. Paragraphs in quotes are those of
 * docs/optics.md. Voxels are fetched one by one and curves are searched anew at every sample: slow, but nothing here can go stale. */
#include <math.h>
#include <string.h>

#include "reference_parts.h"
#include "vec.h"

double pel_reference_decode(double display)
{
    return display <= 0.04045 ? display / 12.92 : pow((display + 0.055) / 1.055, 2.4);
}

double pel_reference_encode(double linear)
{
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

void pel_reference_color(const struct pel_transfer *transfer, bool linear_light, double value, double rgb[3])
{
    pel_transfer_color(transfer, value, rgb);
    if (linear_light)
        for (int c = 0; c < 3; c++)
            rgb[c] = pel_reference_decode(rgb[c]);
}

double pel_reference_extinction(double opacity, double unit_distance)
{
    return -log(1 - fmin(opacity, 1 - 0x1p-24)) / unit_distance;
}

void pel_reference_signal_init(struct pel_reference_signal *signal, const struct pel_scene *scene)
{
    const struct pel_volume *volume = scene->volume;
    enum pel_reconstruction how = scene->render.reconstruction;
    memset(signal, 0, sizeof *signal);
    signal->volume = volume;
    signal->transfer = &scene->transfer;
    signal->linear_light = scene->linear_light;
    signal->nearest = how == PEL_RECONSTRUCTION_NEAREST || (how == PEL_RECONSTRUCTION_AUTO && volume->labels);
    if (scene->render.mode == PEL_MODE_ISOSURFACE)
        signal->nearest = false;
    double to_world[3][3];
    for (int row = 0; row < 3; row++)
        for (int axis = 0; axis < 3; axis++)
            to_world[row][axis] = volume->direction[axis][row] * volume->spacing[axis];
    pel_invert3((const double(*)[3])to_world, signal->to_index);
    for (int axis = 0; axis < 3; axis++) {
        /* An axis with one sample has the thickness of a voxel. */
        signal->lo[axis] = volume->dims[axis] > 1 ? 0 : -0.5;
        signal->hi[axis] = volume->dims[axis] > 1 ? (double)(volume->dims[axis] - 1) : 0.5;
    }
}

/* The voxels that a sample reads: eight of a trilinear cell, x fastest, and where in the cell it lies; or the nearest one. */
struct support {
    int count;
    double value[8], fraction[3];
};

/* Interpolates what the voxels of a support stand for. As a + t (b - a) along one axis after the other, and not as a sum of eight weights
 * that only nearly make 1: where all are equal so is the result, and its gradient is 0 instead of rounding's. */
static double interpolate(const struct support *support, const double of[8])
{
    double v[8];
    memcpy(v, of, (size_t)support->count * sizeof *v);
    for (int axis = 0, count = support->count / 2; count > 0; axis++, count /= 2)
        for (int i = 0; i < count; i++)
            v[i] = v[2 * i] + support->fraction[axis] * (v[2 * i + 1] - v[2 * i]);
    return v[0];
}

/* False where one of the voxels is void, wherever in the cell the sample lies. */
static bool gather(const struct pel_reference_signal *signal, const double index[3], struct support *support)
{
    const struct pel_volume *volume = signal->volume;
    size_t low[3];
    for (int axis = 0; axis < 3; axis++) {
        size_t last = volume->dims[axis] - 1;
        double p = pel_clamp(index[axis], 0, (double)last);
        double floored = signal->nearest ? floor(p + 0.5) : floor(p);
        low[axis] = (size_t)floored;
        if (!signal->nearest && low[axis] == last && last > 0)
            low[axis]--; /* the last plane belongs to the last cell */
        support->fraction[axis] = p - (double)low[axis];
    }
    support->count = signal->nearest ? 1 : 8;
    for (int corner = 0; corner < support->count; corner++) {
        size_t at[3];
        for (int axis = 0; axis < 3; axis++)
            at[axis] = low[axis] + (size_t)((corner >> axis & 1) && volume->dims[axis] > 1);
        double value = pel_volume_get(volume, at[0], at[1], at[2], 0);
        if (!isfinite(value) || pel_volume_is_void(volume, value))
            return false;
        support->value[corner] = value;
    }
    return true;
}

bool pel_reference_value(const struct pel_reference_signal *signal, const double index[3], double *value)
{
    struct support support;
    if (!gather(signal, index, &support))
        return false;
    *value = interpolate(&support, support.value);
    return true;
}

bool pel_reference_classify_post(const struct pel_reference_signal *signal, const double index[3], double *opacity, double rgb[3])
{
    double value;
    if (!pel_reference_value(signal, index, &value))
        return false;
    *opacity = pel_transfer_opacity(signal->transfer, value);
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (*opacity > 0)
        pel_reference_color(signal->transfer, signal->linear_light, value, rgb);
    return true;
}

bool pel_reference_classify_pre(const struct pel_reference_signal *signal, const double index[3], double *opacity, double rgb[3])
{
    struct support support;
    if (!gather(signal, index, &support))
        return false;
    double o[8], weighted[3][8];
    for (int i = 0; i < support.count; i++) {
        double color[3];
        o[i] = pel_transfer_opacity(signal->transfer, support.value[i]);
        pel_reference_color(signal->transfer, signal->linear_light, support.value[i], color);
        for (int c = 0; c < 3; c++)
            weighted[c][i] = o[i] * color[c];
    }
    *opacity = interpolate(&support, o);
    for (int c = 0; c < 3; c++)
        rgb[c] = *opacity > 0 ? interpolate(&support, weighted[c]) / *opacity : 0;
    return true;
}

bool pel_reference_normal(const struct pel_reference_signal *signal, const double index[3], double normal[3])
{
    double slope[3];
    for (int axis = 0; axis < 3; axis++) {
        double side[2];
        for (int s = 0; s < 2; s++) {
            double p[3] = { index[0], index[1], index[2] };
            p[axis] += s ? 1 : -1;
            if (!pel_reference_value(signal, p, &side[s]))
                return false;
            if (signal->nearest) /* labels have no slope; what is seen of them has */
                side[s] = pel_transfer_opacity(signal->transfer, side[s]);
        }
        slope[axis] = (side[1] - side[0]) / 2;
    }
    for (int i = 0; i < 3; i++) /* the transpose of the inverse of index-to-world */
        normal[i] = signal->to_index[0][i] * slope[0] + signal->to_index[1][i] * slope[1] + signal->to_index[2][i] * slope[2];
    return pel_normalize(normal) > 0;
}
