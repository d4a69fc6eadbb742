/* SPDX-License-Identifier: MIT */
/* The volume's shape, types and placement. Passes over its samples are in samples.c and labels.c. */
#include <pellucid/volume.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "alloc.h"
#include "fail.h"
#include "vec.h"

void pel_volume_init(struct pel_volume *volume)
{
    memset(volume, 0, sizeof *volume);
    volume->components = 1;
    for (int a = 0; a < 3; a++) {
        volume->direction[a][a] = 1;
        volume->spacing[a] = 1;
    }
}

bool pel_volume_allocate(struct pel_volume *volume, const size_t dims[3], enum pel_type type, int components, struct pel_error *error)
{
    if (components < 1 || components > 4)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a volume of %d components; 1 to 4 are possible", components);
    if ((unsigned)type >= PEL_TYPE_COUNT)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a volume of an unknown sample type");
    if (!dims[0] || !dims[1] || !dims[2])
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a volume of %zu x %zu x %zu samples; each must be at least 1", dims[0], dims[1],
                        dims[2]);
    size_t count;
    if (!pel_mul(dims[0], dims[1], &count) || !pel_mul(count, dims[2], &count) || !pel_mul(count, (size_t)components, &count))
        return pel_fail(error, PEL_ERROR_MEMORY, "a volume of %zu x %zu x %zu samples is more than can be addressed", dims[0], dims[1],
                        dims[2]);
    void *data = pel_alloc(count, pel_type_size(type), "volume samples", error);
    if (!data)
        return false;
    free(volume->data);
    volume->data = data;
    memcpy(volume->dims, dims, sizeof volume->dims);
    volume->type = type;
    volume->components = components;
    volume->range[0] = volume->range[1] = 0;
    return true;
}

void pel_volume_finish(struct pel_volume *volume)
{
    free(volume->data);
    pel_volume_init(volume);
}

size_t pel_volume_samples(const struct pel_volume *volume)
{
    return volume->dims[0] * volume->dims[1] * volume->dims[2];
}

size_t pel_volume_bytes(const struct pel_volume *volume)
{
    return pel_volume_samples(volume) * (size_t)volume->components * pel_type_size(volume->type);
}

size_t pel_type_size(enum pel_type type)
{
    static const size_t sizes[PEL_TYPE_COUNT] = { 1, 1, 2, 2, 4, 4, 4, 8 };
    return (unsigned)type < PEL_TYPE_COUNT ? sizes[type] : 0;
}

const char *pel_type_name(enum pel_type type)
{
    static const char *const names[PEL_TYPE_COUNT] = { "u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64" };
    return (unsigned)type < PEL_TYPE_COUNT ? names[type] : "unknown";
}

enum pel_type pel_type_from_name(const char *name)
{
    /* Of each type: ours, the stdint name, then those of C, NRRD and VTK. VTK's XML capitals (UInt8, Float32) come through the caseless
     * comparison. `long` is left out: files disagree on its size. */
    static const char *const names[PEL_TYPE_COUNT][9] = {
        { "u8", "uint8", "uint8_t", "unsigned char", "uchar", "unsigned_char" },
        { "i8", "int8", "int8_t", "signed char", "char", "schar" },
        { "u16", "uint16", "uint16_t", "unsigned short", "ushort", "unsigned short int", "unsigned_short" },
        { "i16", "int16", "int16_t", "signed short", "short", "short int", "signed short int" },
        { "u32", "uint32", "uint32_t", "unsigned int", "uint", "unsigned", "unsigned_int" },
        { "i32", "int32", "int32_t", "signed int", "int" },
        { "f32", "float32", "float" },
        { "f64", "float64", "double" },
    };
    for (int type = 0; type < PEL_TYPE_COUNT; type++)
        for (int i = 0; i < 9 && names[type][i]; i++)
            if (strcasecmp(name, names[type][i]) == 0)
                return (enum pel_type)type;
    return PEL_TYPE_COUNT;
}

const char *pel_space_name(enum pel_space space)
{
    return space == PEL_SPACE_RAS ? "RAS" : space == PEL_SPACE_LPS ? "LPS" : "unknown";
}

double pel_volume_get(const struct pel_volume *volume, size_t x, size_t y, size_t z, int component)
{
    size_t i = ((z * volume->dims[1] + y) * volume->dims[0] + x) * (size_t)volume->components + (size_t)component;
    switch (volume->type) {
    case PEL_U8: return ((const unsigned char *)volume->data)[i];
    case PEL_I8: return ((const signed char *)volume->data)[i];
    case PEL_U16: return ((const unsigned short *)volume->data)[i];
    case PEL_I16: return ((const short *)volume->data)[i];
    case PEL_U32: return ((const unsigned *)volume->data)[i];
    case PEL_I32: return ((const int *)volume->data)[i];
    case PEL_F32: return (double)((const float *)volume->data)[i];
    case PEL_F64: return ((const double *)volume->data)[i];
    case PEL_TYPE_COUNT: break;
    }
    return NAN;
}

bool pel_volume_is_void(const struct pel_volume *volume, double value)
{
    /* A file's -9999.9 is not the float nearest to it: compared as what the samples can be. */
    double void_value = volume->type == PEL_F32 ? (double)(float)volume->void_value : volume->void_value;
    return isnan(value) || (volume->has_void && value == void_value);
}

void pel_volume_matrix(const struct pel_volume *volume, double matrix[3][4])
{
    for (int row = 0; row < 3; row++) {
        for (int axis = 0; axis < 3; axis++)
            matrix[row][axis] = volume->direction[axis][row] * volume->spacing[axis];
        matrix[row][3] = volume->origin[row];
    }
}

void pel_volume_index_to_world(const struct pel_volume *volume, const double index[3], double world[3])
{
    double m[3][4], w[3];
    pel_volume_matrix(volume, m);
    for (int row = 0; row < 3; row++)
        w[row] = m[row][0] * index[0] + m[row][1] * index[1] + m[row][2] * index[2] + m[row][3];
    memcpy(world, w, sizeof w);
}

void pel_volume_world_to_index(const struct pel_volume *volume, const double world[3], double index[3])
{
    double columns[3][3], inverse[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, offset[3];
    for (int row = 0; row < 3; row++)
        for (int axis = 0; axis < 3; axis++)
            columns[row][axis] = volume->direction[axis][row]; /* inverted without the spacing, which may be of any magnitude */
    pel_invert3(columns, inverse);
    pel_sub(world, volume->origin, offset);
    for (int axis = 0; axis < 3; axis++)
        index[axis] = pel_dot(inverse[axis], offset) / volume->spacing[axis];
}

void pel_volume_bounds(const struct pel_volume *volume, double bounds[6])
{
    for (int i = 0; i < 3; i++)
        bounds[2 * i] = INFINITY, bounds[2 * i + 1] = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        double index[3], world[3];
        for (int a = 0; a < 3; a++) {
            bool high = corner >> a & 1;
            if (volume->dims[a] <= 1)
                index[a] = high ? 0.5 : -0.5;
            else
                index[a] = high ? (double)(volume->dims[a] - 1) : 0;
        }
        pel_volume_index_to_world(volume, index, world);
        for (int i = 0; i < 3; i++) {
            bounds[2 * i] = fmin(bounds[2 * i], world[i]);
            bounds[2 * i + 1] = fmax(bounds[2 * i + 1], world[i]);
        }
    }
}

double pel_volume_mean_spacing(const struct pel_volume *volume)
{
    return (volume->spacing[0] + volume->spacing[1] + volume->spacing[2]) / 3;
}

double pel_volume_least_spacing(const struct pel_volume *volume)
{
    return fmin(volume->spacing[0], fmin(volume->spacing[1], volume->spacing[2]));
}

static bool check_placement(const struct pel_volume *volume, struct pel_error *error)
{
    for (int a = 0; a < 3; a++) {
        if (!isfinite(volume->origin[a]))
            return pel_fail(error, PEL_ERROR_FORMAT, "the origin is not finite");
        if (!(volume->spacing[a] > 0) || !isfinite(volume->spacing[a]))
            return pel_fail(error, PEL_ERROR_FORMAT, "the spacing of axis %d is %g; it must be positive and finite", a, volume->spacing[a]);
        double length = pel_length(volume->direction[a]);
        if (!(fabs(length - 1) < 1e-4))
            return pel_fail(error, PEL_ERROR_FORMAT, "the direction of axis %d has the length %g; it must be 1", a, length);
    }
    double cross[3];
    pel_cross(volume->direction[1], volume->direction[2], cross);
    double det = pel_dot(volume->direction[0], cross);
    if (!(fabs(det) > 1e-6))
        return pel_fail(error, PEL_ERROR_FORMAT, "the axes lie in one plane (determinant of the directions %g)", det);
    /* The far corner and lengths along the view must stay numbers too. */
    for (int a = 0; a < 3; a++)
        if (!((double)volume->dims[a] * volume->spacing[a] < 1e100 && fabs(volume->origin[a]) < 1e100 && volume->spacing[a] > 1e-100))
            return pel_fail(error, PEL_ERROR_FORMAT, "the placement along axis %d (spacing %g) is beyond what can be computed with", a,
                            volume->spacing[a]);
    return true;
}

bool pel_volume_check(const struct pel_volume *volume, struct pel_error *error)
{
    size_t bytes;
    if (!volume->data)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the volume holds no samples");
    if (!volume->dims[0] || !volume->dims[1] || !volume->dims[2])
        return pel_fail(error, PEL_ERROR_FORMAT, "a volume of %zu x %zu x %zu samples; each must be at least 1", volume->dims[0],
                        volume->dims[1], volume->dims[2]);
    if (volume->components < 1 || volume->components > 4)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a volume of %d components; 1 to 4 are possible", volume->components);
    if ((unsigned)volume->type >= PEL_TYPE_COUNT)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a volume of an unknown sample type");
    if (!pel_mul(volume->dims[0], volume->dims[1], &bytes) || !pel_mul(bytes, volume->dims[2], &bytes) ||
        !pel_mul(bytes, (size_t)volume->components * pel_type_size(volume->type), &bytes))
        return pel_fail(error, PEL_ERROR_MEMORY, "a volume of %zu x %zu x %zu samples is more than can be addressed", volume->dims[0],
                        volume->dims[1], volume->dims[2]);
    return check_placement(volume, error);
}

void pel_volume_to_space(struct pel_volume *volume, enum pel_space space)
{
    bool turn = volume->space != space && volume->space != PEL_SPACE_UNKNOWN && space != PEL_SPACE_UNKNOWN;
    for (int i = 0; turn && i < 2; i++) { /* world x and y; 0 - v keeps a zero positive */
        volume->origin[i] = 0 - volume->origin[i];
        for (int a = 0; a < 3; a++)
            volume->direction[a][i] = 0 - volume->direction[a][i];
    }
    volume->space = space;
}
