/* SPDX-License-Identifier: MIT */
/* Histogram of values, with the mean gradient at each value where it is asked for. Rows are shared out in slabs, each with bins of its own,
 * merged in order. 8- and 16-bit integers find their bin in a table; gradients of one-component volumes without a void value are
 * differences of native rows, which the compiler vectorises. */
#include <pellucid/statistics.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"
#include "samples.h"

#define MAX_SLABS 16         /* each needs bins of its own */
#define NO_BIN UINT32_MAX

struct slab_bins {
    uint64_t *bins;       /* two sets of count entries, for even and odd x: equal neighbours, the rule, then do not wait for each other */
    double *gradient_sum; /* count entries or NULL */
};

struct histogram_pass {
    const struct pel_volume *volume;
    struct pel_histogram *histogram;
    size_t rows, slabs;
    uint32_t *bin_of; /* by stored value (as unsigned bits), or NULL where the type has too many */
    struct slab_bins slab[MAX_SLABS];
    double *scratch;  /* of each slab: row_scratch() doubles */
};

static uint32_t find_bin(const struct pel_histogram *h, double value)
{
    if (!(value >= h->lo && value <= h->hi))
        return NO_BIN;
    double width = h->hi - h->lo;
    size_t bin = width > 0 ? (size_t)((value - h->lo) / width * (double)h->count) : 0;
    return (uint32_t)(bin < h->count ? bin : h->count - 1);
}

/* ---- gradient magnitude of one row, in value per voxel, clamped at the faces ---- */

#define GRADIENT_ROW(T, A)                                                                                                                 \
    do {                                                                                                                                   \
        const T *p = (const T *)volume->data, *c = p + at, *y0 = p + at_y0, *y1 = p + at_y1, *z0 = p + at_z0, *z1 = p + at_z1;             \
        for (size_t x = 0; x < n; x++) {                                                                                                   \
            A gy = (A)y1[x] - (A)y0[x], gz = (A)z1[x] - (A)z0[x];                                                                          \
            out[x] = (float)(gy * gy + gz * gz);                                                                                           \
        }                                                                                                                                  \
        for (size_t x = 1; x + 1 < n; x++) {                                                                                               \
            A gx = (A)c[x + 1] - (A)c[x - 1];                                                                                              \
            out[x] += (float)(gx * gx);                                                                                                    \
        }                                                                                                                                  \
        if (n > 1) {                                                                                                                       \
            A left = (A)c[1] - (A)c[0], right = (A)c[n - 1] - (A)c[n - 2];                                                                 \
            out[0] += (float)(left * left);                                                                                                \
            out[n - 1] += (float)(right * right);                                                                                          \
        }                                                                                                                                  \
        return;                                                                                                                            \
    } while (0)

/* Squares of the doubled gradient; the root and the half come when it is added to its bin. */
static void gradient_row_native(const struct pel_volume *volume, size_t at, size_t at_y0, size_t at_y1, size_t at_z0, size_t at_z1,
                                float *out)
{
    size_t n = volume->dims[0];
    switch (volume->type) {
    case PEL_U8: GRADIENT_ROW(uint8_t, int32_t);
    case PEL_I8: GRADIENT_ROW(int8_t, int32_t);
    case PEL_U16: GRADIENT_ROW(uint16_t, float);
    case PEL_I16: GRADIENT_ROW(int16_t, float);
    case PEL_U32: GRADIENT_ROW(uint32_t, double);
    case PEL_I32: GRADIENT_ROW(int32_t, double);
    case PEL_F32: GRADIENT_ROW(float, float);
    case PEL_F64: GRADIENT_ROW(double, double);
    case PEL_TYPE_COUNT: return;
    }
}

/* The same through doubles: several components or a void value. NaN beside a void, which adds nothing. */
static void gradient_row_any(const struct pel_volume *volume, size_t at, size_t at_y0, size_t at_y1, size_t at_z0, size_t at_z1,
                             double *rows, float *out)
{
    size_t n = volume->dims[0];
    double *c = rows, *low = rows + n, *high = rows + 2 * n;
    pel_samples_load(volume, at, n, c);
    for (size_t x = 0; x < n; x++) {
        double g = c[x + 1 < n ? x + 1 : x] - c[x ? x - 1 : 0];
        out[x] = (float)(g * g);
    }
    const size_t sides[2][2] = { { at_y0, at_y1 }, { at_z0, at_z1 } };
    for (int side = 0; side < 2; side++) {
        pel_samples_load(volume, sides[side][0], n, low);
        pel_samples_load(volume, sides[side][1], n, high);
        for (size_t x = 0; x < n; x++)
            out[x] += (float)((high[x] - low[x]) * (high[x] - low[x]));
    }
}

/* ---- one row into a slab's bins ---- */

/* Bytes are counted as stored, by place modulo 4, and put into bins at the end of the slab: the common case, and nothing is quicker. */
typedef uint64_t byte_counts[4][256];

static void count_bytes(const uint8_t *p, size_t n, byte_counts counts)
{
    size_t x = 0;
    for (; x + 4 <= n; x += 4) {
        counts[0][p[x]]++;
        counts[1][p[x + 1]]++;
        counts[2][p[x + 2]]++;
        counts[3][p[x + 3]]++;
    }
    for (; x < n; x++)
        counts[0][p[x]]++;
}

static void bin_byte_counts(const struct histogram_pass *pass, byte_counts counts, struct slab_bins *slab)
{
    for (int value = 0; value < 256; value++)
        if (pass->bin_of[value] != NO_BIN)
            slab->bins[pass->bin_of[value]] += counts[0][value] + counts[1][value] + counts[2][value] + counts[3][value];
}

static void find_row_bins(const struct histogram_pass *pass, size_t first, double *values, uint32_t *bins)
{
    const struct pel_volume *volume = pass->volume;
    size_t n = volume->dims[0];
    if (pass->bin_of) {
        const uint16_t *p = (const uint16_t *)volume->data + first;
        for (size_t x = 0; x < n; x++)
            bins[x] = pass->bin_of[p[x]];
    } else {
        pel_samples_load(volume, first, n, values);
        for (size_t x = 0; x < n; x++)
            bins[x] = find_bin(pass->histogram, values[x]);
    }
}

/* The gradients of row y of slice z, squared and doubled, into `out`; false where the whole row is flat. */
static bool find_row_gradients(const struct histogram_pass *pass, size_t y, size_t z, double *scratch, float *out)
{
    const struct pel_volume *volume = pass->volume;
    size_t n = volume->dims[0], ny = volume->dims[1], nz = volume->dims[2], at = (z * ny + y) * n;
    size_t y0 = y ? at - n : at, y1 = y + 1 < ny ? at + n : at, z0 = z ? at - n * ny : at, z1 = z + 1 < nz ? at + n * ny : at;
    if (volume->components == 1 && !volume->has_void)
        gradient_row_native(volume, at, y0, y1, z0, z1, out);
    else
        gradient_row_any(volume, at, y0, y1, z0, z1, scratch, out);
    bool flat = true;
    for (size_t x = 0; x < n; x++)
        flat &= out[x] == 0;
    return !flat;
}

/* Flat, beside a void (NaN) or beside an infinite sample: there is nothing to add. */
static void add_gradient(struct slab_bins *slab, uint32_t bin, float squared)
{
    if (squared < INFINITY && bin != NO_BIN)
        slab->gradient_sum[bin] += 0.5 * sqrt((double)squared);
}

static void add_row_of_bytes(const struct histogram_pass *pass, size_t y, size_t z, double *scratch, byte_counts counts,
                             struct slab_bins *slab)
{
    size_t n = pass->volume->dims[0];
    const uint8_t *p = (const uint8_t *)pass->volume->data + (z * pass->volume->dims[1] + y) * n;
    float *gradient = (float *)(scratch + 3 * n);
    count_bytes(p, n, counts);
    if (slab->gradient_sum && find_row_gradients(pass, y, z, scratch, gradient))
        for (size_t x = 0; x < n; x++)
            if (gradient[x] > 0)
                add_gradient(slab, pass->bin_of[p[x]], gradient[x]);
}

/* Scratch: three rows of doubles, one of bins, one of gradients. */
static void add_row(const struct histogram_pass *pass, size_t y, size_t z, double *scratch, struct slab_bins *slab)
{
    size_t n = pass->volume->dims[0], at = (z * pass->volume->dims[1] + y) * n, count = pass->histogram->count;
    uint32_t *bins = (uint32_t *)(scratch + 3 * n);
    float *gradient = (float *)(bins + n);
    bool sloping = slab->gradient_sum && find_row_gradients(pass, y, z, scratch, gradient);
    find_row_bins(pass, at, scratch, bins);
    for (size_t x = 0; x < n; x++)
        if (bins[x] != NO_BIN)
            slab->bins[bins[x] + (x & 1 ? count : 0)]++;
    for (size_t x = 0; sloping && x < n; x++)
        if (gradient[x] > 0)
            add_gradient(slab, bins[x], gradient[x]);
}

static size_t row_scratch(const struct pel_volume *volume)
{
    return 4 * volume->dims[0];
}

static void histogram_slab(void *context, size_t slab, int thread)
{
    (void)thread;
    struct histogram_pass *pass = context;
    size_t ny = pass->volume->dims[1], end = pel_slab_first(pass->rows, pass->slabs, slab + 1);
    double *scratch = pass->scratch + slab * row_scratch(pass->volume);
    byte_counts counts = { { 0 } };
    bool bytes = pass->bin_of && pel_type_size(pass->volume->type) == 1;
    for (size_t row = pel_slab_first(pass->rows, pass->slabs, slab); row < end; row++)
        if (bytes)
            add_row_of_bytes(pass, row % ny, row / ny, scratch, counts, &pass->slab[slab]);
        else
            add_row(pass, row % ny, row / ny, scratch, &pass->slab[slab]);
    if (bytes)
        bin_byte_counts(pass, counts, &pass->slab[slab]);
}

/* The bin of each stored value of an 8- or 16-bit type. */
static bool make_bin_table(struct histogram_pass *pass, struct pel_error *error)
{
    const struct pel_volume *volume = pass->volume;
    if (volume->type > PEL_I16 || volume->components != 1)
        return true;
    size_t count = pel_type_size(volume->type) == 1 ? 256 : 65536;
    pass->bin_of = pel_alloc(count, sizeof *pass->bin_of, "histogram", error);
    for (size_t i = 0; pass->bin_of && i < count; i++) {
        double value = volume->type == PEL_I8 ? (double)(int8_t)i : volume->type == PEL_I16 ? (double)(int16_t)i : (double)i;
        pass->bin_of[i] = pel_volume_is_void(volume, value) ? NO_BIN : find_bin(pass->histogram, value);
    }
    return pass->bin_of != NULL;
}

static void merge(const struct histogram_pass *pass)
{
    struct pel_histogram *h = pass->histogram;
    for (size_t s = 0; s < pass->slabs; s++)
        for (size_t i = 0; i < h->count; i++) {
            h->bins[i] += pass->slab[s].bins[i] + pass->slab[s].bins[h->count + i];
            if (h->gradient_sum)
                h->gradient_sum[i] += pass->slab[s].gradient_sum[i];
        }
}

static bool fill(struct histogram_pass *pass, struct pel_error *error)
{
    size_t count = pass->histogram->count, each = 2 * count + (pass->histogram->gradient_sum ? count : 0);
    uint64_t *memory = pel_alloc(pass->slabs, each * sizeof *memory, "histogram", error);
    pass->scratch = pel_alloc(pass->slabs, row_scratch(pass->volume) * sizeof *pass->scratch, "histogram", error);
    bool good = memory && pass->scratch && make_bin_table(pass, error);
    if (good) {
        for (size_t s = 0; s < pass->slabs; s++) {
            pass->slab[s].bins = memory + s * each;
            pass->slab[s].gradient_sum = pass->histogram->gradient_sum ? (double *)(memory + s * each + 2 * count) : NULL;
        }
        pel_parallel_for(0, pass->slabs, histogram_slab, pass);
        merge(pass);
    }
    free(pass->bin_of);
    free(pass->scratch);
    free(memory);
    return good;
}

bool pel_histogram_init(struct pel_histogram *histogram, const struct pel_volume *volume, double lo, double hi, size_t count,
                        bool with_gradient, struct pel_error *error)
{
    *histogram = (struct pel_histogram){ .lo = lo, .hi = hi, .count = count };
    if (count < 1 || count > (size_t)1 << 24 || !isfinite(lo) || !isfinite(hi) || !(lo <= hi))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a histogram of %zu bins over %g to %g makes no sense", count, lo, hi);
    if (!volume->data)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "a histogram of a volume that holds no samples");
    histogram->bins = pel_alloc(count, sizeof *histogram->bins, "histogram", error);
    if (with_gradient)
        histogram->gradient_sum = pel_alloc(count, sizeof *histogram->gradient_sum, "histogram", error);
    struct histogram_pass pass = { .volume = volume, .histogram = histogram, .rows = volume->dims[1] * volume->dims[2] };
    pass.slabs = pass.rows < MAX_SLABS ? pass.rows : MAX_SLABS;
    if (histogram->bins && (!with_gradient || histogram->gradient_sum) && fill(&pass, error))
        return true;
    pel_histogram_finish(histogram);
    return false;
}

void pel_histogram_finish(struct pel_histogram *histogram)
{
    free(histogram->bins);
    free(histogram->gradient_sum);
    *histogram = (struct pel_histogram){ .count = 0 };
}
