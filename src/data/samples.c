/* SPDX-License-Identifier: MIT */
/* Passes over the samples of a volume: loading as doubles, the range, the magnitude of a field. One macro makes the loop for each type, so
 * that the compiler sees native loads that it can vectorise. */
#include "samples.h"

#include <math.h>
#include <string.h>

#include "parallel.h"

size_t pel_slab_count(size_t samples)
{
    size_t slabs = samples / 65536 + 1;
    return slabs < PEL_MAX_SLABS ? slabs : PEL_MAX_SLABS;
}

size_t pel_slab_first(size_t samples, size_t slabs, size_t slab)
{
    size_t each = samples / slabs, rest = samples % slabs;
    return slab * each + (slab < rest ? slab : rest);
}

#define LOAD_VALUES(T)                                                                                                                     \
    for (size_t i = 0; i < count; i++)                                                                                                     \
        out[i] = (double)((const T *)data)[i];                                                                                             \
    break

static void load_numbers(const struct pel_volume *volume, size_t first, size_t count, double *out)
{
    const void *data = (const char *)volume->data + first * pel_type_size(volume->type);
    switch (volume->type) {
    case PEL_U8: LOAD_VALUES(unsigned char);
    case PEL_I8: LOAD_VALUES(signed char);
    case PEL_U16: LOAD_VALUES(unsigned short);
    case PEL_I16: LOAD_VALUES(short);
    case PEL_U32: LOAD_VALUES(unsigned);
    case PEL_I32: LOAD_VALUES(int);
    case PEL_F32: LOAD_VALUES(float);
    case PEL_F64: LOAD_VALUES(double);
    case PEL_TYPE_COUNT: break;
    }
    if (volume->has_void) {
        double void_value = volume->type == PEL_F32 ? (double)(float)volume->void_value : volume->void_value; /* as pel_volume_is_void */
        for (size_t i = 0; i < count; i++)
            out[i] = out[i] == void_value ? NAN : out[i];
    }
}

void pel_samples_load(const struct pel_volume *volume, size_t first, size_t count, double *out)
{
    size_t components = (size_t)volume->components;
    if (components == 1) {
        load_numbers(volume, first, count, out);
        return;
    }
    double numbers[4 * 64];
    for (size_t done = 0; done < count; done += 64) {
        size_t n = count - done < 64 ? count - done : 64;
        load_numbers(volume, (first + done) * components, n * components, numbers);
        for (size_t i = 0; i < n; i++) {
            double sum = 0;
            for (size_t c = 0; c < components; c++)
                sum += numbers[i * components + c] * numbers[i * components + c];
            out[done + i] = sqrt(sum);
        }
    }
}

struct range_pass {
    const struct pel_volume *volume;
    size_t samples, slabs;
    double min[PEL_MAX_SLABS], max[PEL_MAX_SLABS]; /* +inf and -inf where a slab has no value */
};

#define RANGE_OF(T)                                                                                                                        \
    do {                                                                                                                                   \
        const T *p = (const T *)volume->data + first;                                                                                      \
        T lo = p[0], hi = p[0];                                                                                                            \
        for (size_t i = 1; i < count; i++) {                                                                                               \
            lo = p[i] < lo ? p[i] : lo;                                                                                                    \
            hi = p[i] > hi ? p[i] : hi;                                                                                                    \
        }                                                                                                                                  \
        *min = lo, *max = hi;                                                                                                              \
        return;                                                                                                                            \
    } while (0)

/* Integers of one component without a void value have nothing to leave out. */
static void range_of_integers(const struct pel_volume *volume, size_t first, size_t count, double *min, double *max)
{
    switch (volume->type) {
    case PEL_U8: RANGE_OF(unsigned char);
    case PEL_I8: RANGE_OF(signed char);
    case PEL_U16: RANGE_OF(unsigned short);
    case PEL_I16: RANGE_OF(short);
    case PEL_U32: RANGE_OF(unsigned);
    case PEL_I32: RANGE_OF(int);
    default: return;
    }
}

static void range_of_any(const struct pel_volume *volume, size_t first, size_t count, double *min, double *max)
{
    double block[1024], lo = INFINITY, hi = -INFINITY;
    for (size_t done = 0; done < count; done += 1024) {
        size_t n = count - done < 1024 ? count - done : 1024;
        pel_samples_load(volume, first + done, n, block);
        for (size_t i = 0; i < n; i++) { /* comparisons with NaN are false, so voids fall through; |v| < inf leaves the infinite out */
            bool finite = fabs(block[i]) < INFINITY;
            lo = finite && block[i] < lo ? block[i] : lo;
            hi = finite && block[i] > hi ? block[i] : hi;
        }
    }
    *min = lo, *max = hi;
}

static void range_slab(void *context, size_t slab, int thread)
{
    (void)thread;
    struct range_pass *pass = context;
    const struct pel_volume *volume = pass->volume;
    size_t first = pel_slab_first(pass->samples, pass->slabs, slab), end = pel_slab_first(pass->samples, pass->slabs, slab + 1);
    if (volume->components == 1 && !volume->has_void && volume->type < PEL_F32)
        range_of_integers(volume, first, end - first, &pass->min[slab], &pass->max[slab]);
    else
        range_of_any(volume, first, end - first, &pass->min[slab], &pass->max[slab]);
}

void pel_volume_update_range(struct pel_volume *volume)
{
    struct range_pass pass = { .volume = volume, .samples = pel_volume_samples(volume) };
    volume->range[0] = volume->range[1] = 0;
    if (!volume->data || pass.samples == 0)
        return;
    pass.slabs = pel_slab_count(pass.samples);
    pel_parallel_for(0, pass.slabs, range_slab, &pass);
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < pass.slabs; i++) {
        lo = fmin(lo, pass.min[i]);
        hi = fmax(hi, pass.max[i]);
    }
    if (lo <= hi) /* else all samples are void: 0..0, a range that no later code trips over */
        volume->range[0] = lo, volume->range[1] = hi;
}

struct magnitude_pass {
    const struct pel_volume *field;
    float *out;
    size_t samples, slabs;
};

static void magnitude_slab(void *context, size_t slab, int thread)
{
    (void)thread;
    struct magnitude_pass *pass = context;
    size_t end = pel_slab_first(pass->samples, pass->slabs, slab + 1);
    double block[1024];
    for (size_t i = pel_slab_first(pass->samples, pass->slabs, slab); i < end; i += 1024) {
        size_t n = end - i < 1024 ? end - i : 1024;
        pel_samples_load(pass->field, i, n, block);
        for (size_t k = 0; k < n; k++) /* of a scalar volume the magnitude is the absolute value */
            pass->out[i + k] = (float)fabs(block[k]);
    }
}

bool pel_volume_magnitude(const struct pel_volume *field, struct pel_volume *magnitude, struct pel_error *error)
{
    if (!pel_volume_allocate(magnitude, field->dims, PEL_F32, 1, error))
        return false;
    memcpy(magnitude->origin, field->origin, sizeof field->origin);
    memcpy(magnitude->direction, field->direction, sizeof field->direction);
    memcpy(magnitude->spacing, field->spacing, sizeof field->spacing);
    memcpy(magnitude->units, field->units, sizeof field->units);
    memcpy(magnitude->name, field->name, sizeof field->name);
    magnitude->space = field->space;
    magnitude->has_void = magnitude->labels = false; /* NaN says it */
    struct magnitude_pass pass = { field, magnitude->data, pel_volume_samples(field), 0 };
    pass.slabs = pel_slab_count(pass.samples);
    pel_parallel_for(0, pass.slabs, magnitude_slab, &pass);
    pel_volume_update_range(magnitude);
    return true;
}
