/* SPDX-License-Identifier: MIT */
/* The reasoning, in order:
 *   1. an interval that a few outliers cannot spoil: the quantiles of a sparse sample, then those of a fine histogram without its mode;
 *   2. a histogram over it, with the mean gradient at each value;
 *   3. the background is the mode, if enough of the volume is near it. If nothing is, the values fill the box;
 *   4. the first peak above the background is the outermost material. Between the two the mean gradient is greatest in the middle
 *      of their boundary (Kindlmann and Durkin's observation): that is the isovalue. With no such peak it encloses a share of the total. */
#include "survey.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <pellucid/statistics.h>

#include "samples.h"

enum {
    SPARSE_SAMPLES = 32768, /* for the quantiles of step 1 */
    FINE_BINS = 4096,
    SLAB_SAMPLES = 8 << 20, /* looked at for a histogram, about */
    SLABS = 8,              /* few: each costs a pass; thick, so that few gradients are cut at their faces */
};

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Least and greatest value but for 1 in 2000 at each end, from samples all over the volume; false where there are no finite ones. */
static bool sparse_quantiles(const struct pel_volume *volume, double *lo, double *hi)
{
    size_t samples = pel_volume_samples(volume), stride = samples / SPARSE_SAMPLES + 1, n = 0;
    double *values = malloc((samples / stride + 1) * sizeof *values);
    if (!values)
        return false;
    for (size_t k = 0; k < samples / stride; k++) {
        size_t i = k * stride + k * 7919 % stride; /* a regular stride would keep to few columns */
        double value;
        pel_samples_load(volume, i, 1, &value);
        if (isfinite(value))
            values[n++] = value;
    }
    qsort(values, n, sizeof *values, by_value);
    if (n > 0) {
        *lo = values[n / 2000];
        *hi = values[n - 1 - n / 2000];
    }
    free(values);
    return n > 0;
}

/* Adds the histogram of slabs that stand for the whole volume. */
static bool add_slabs(const struct pel_volume *volume, double lo, double hi, size_t bins, double *count, double *gradient)
{
    size_t slice = volume->dims[0] * volume->dims[1], nz = volume->dims[2], thick = SLAB_SAMPLES / SLABS / slice + 2;
    size_t step = nz > thick * SLABS ? nz / SLABS : nz, bytes = slice * pel_type_size(volume->type) * (size_t)volume->components;
    for (size_t z = step < nz ? (nz - step * (SLABS - 1) - thick) / 2 : 0, k = 0; k < (step < nz ? SLABS : 1); z += step, k++) {
        struct pel_volume slab = *volume;
        slab.data = (char *)volume->data + z * bytes;
        slab.dims[2] = step < nz ? thick : nz;
        struct pel_histogram h;
        if (!pel_histogram_init(&h, &slab, lo, hi, bins, gradient != NULL, NULL))
            return false;
        for (size_t i = 0; i < bins; i++) {
            count[i] += (double)h.bins[i];
            if (gradient)
                gradient[i] += h.gradient_sum[i];
        }
        pel_histogram_finish(&h);
    }
    return true;
}

static bool is_integer(const struct pel_volume *volume)
{
    return volume->type < PEL_F32 && volume->components == 1;
}

/* Bins of equal numbers of integers, or PEL_SURVEY_BINS; widens lo and hi by half a step for integers. */
static int choose_bins(const struct pel_volume *volume, double *lo, double *hi)
{
    if (!is_integer(volume))
        return PEL_SURVEY_BINS;
    double values = floor(*hi) - ceil(*lo) + 1, width = ceil(values / PEL_SURVEY_BINS);
    int bins = (int)ceil(values / width);
    *lo = ceil(*lo) - 0.5;
    *hi = *lo + bins * width;
    return bins < 1 ? 1 : bins;
}

/* The fine bins between which all but `part` of the counts lie at each end; the bin `skip` is left out. */
static void fine_quantiles(const double *count, int skip, double part, int *first, int *last)
{
    double total = 0, below = 0;
    for (int i = 0; i < FINE_BINS; i++)
        total += i == skip ? 0 : count[i];
    *first = *last = skip;
    for (int i = 0; i < FINE_BINS; i++) {
        double here = i == skip ? 0 : count[i];
        if (below <= total * part && below + here > total * part)
            *first = i;
        if (below < total * (1 - part) && below + here >= total * (1 - part))
            *last = i;
        below += here;
    }
}

/* Narrows the interval: leaves out a few values at the ends if that makes much of a difference, and a fill value far from all others. */
static bool narrow(const struct pel_volume *volume, double *lo, double *hi)
{
    double *count = calloc(FINE_BINS, sizeof *count);
    if (!count || !add_slabs(volume, *lo, *hi, FINE_BINS, count, NULL)) {
        free(count);
        return false;
    }
    int mode = 0, first, last, near_first, near_last;
    for (int i = 0; i < FINE_BINS; i++)
        mode = count[i] > count[mode] ? i : mode;
    fine_quantiles(count, mode, 0.0001, &first, &last);
    fine_quantiles(count, mode, 0.004, &near_first, &near_last);
    free(count);
    if ((near_last - near_first + 1) * 5 < (last - first + 1) * 2) {
        first = near_first;
        last = near_last;
    }
    bool fill_value = (last - first + 1) * 20 < abs((first + last) / 2 - mode);
    if (!fill_value) {
        first = mode < first ? mode : first;
        last = mode > last ? mode : last;
    }
    double width = (*hi - *lo) / FINE_BINS, start = *lo;
    *lo = start + width * first;
    *hi = last + 1 < FINE_BINS ? start + width * (last + 1) : *hi;
    return true;
}

static void smooth(const double *in, double *out, int n, double sigma)
{
    int radius = (int)ceil(3 * sigma);
    for (int i = 0; i < n; i++) {
        double sum = 0, weights = 0;
        for (int j = i - radius < 0 ? 0 : i - radius; j <= i + radius && j < n; j++) {
            double w = exp(-(j - i) * (j - i) / (2 * sigma * sigma));
            sum += w * in[j];
            weights += w;
        }
        out[i] = sum / weights;
    }
}

static bool fill_bins(const struct pel_volume *volume, struct pel_survey *s)
{
    double gradient[PEL_SURVEY_BINS] = { 0 }, total = 0, most = 0;
    if (!add_slabs(volume, s->lo, s->hi, (size_t)s->bins, s->count, gradient))
        return false;
    for (int i = 0; i < s->bins; i++)
        total += s->count[i];
    if (!(total > 0))
        return false;
    for (int i = 0; i < s->bins; i++) {
        s->count[i] /= total;
        gradient[i] /= total;
    }
    double sigma = s->bins / 160.0;
    smooth(s->count, s->smooth, s->bins, sigma);
    smooth(gradient, s->gradient, s->bins, sigma);
    for (int i = 0; i < s->bins; i++) {
        /* Hardly any samples: their mean gradient says nothing, and must not set the scale. */
        s->gradient[i] = s->smooth[i] > 0 ? s->gradient[i] / s->smooth[i] : 0;
        if (s->smooth[i] > 2e-6)
            most = fmax(most, s->gradient[i]);
    }
    for (int i = 0; i < s->bins; i++)
        s->gradient[i] = most > 0 ? fmin(s->gradient[i] / most, 1) : 0;
    return true;
}

static double share(const struct pel_survey *s, int first, int last)
{
    double sum = 0;
    for (int i = first < 0 ? 0 : first; i <= last && i < s->bins; i++)
        sum += s->count[i];
    return sum;
}

/* The bin below which `part` of the share above `first` lies. */
static int quantile(const struct pel_survey *s, int first, double part)
{
    double target = part * share(s, first, s->bins), sum = 0;
    for (int i = first; i < s->bins; i++) {
        sum += s->count[i];
        if (sum >= target && sum > 0)
            return i;
    }
    return s->bins - 1;
}

/* Otsu: the split of least variance within. Returns the last bin of the lower class. */
static int otsu(const struct pel_survey *s)
{
    double total = 0, below = 0, mass = 0, best = -1;
    int split = 0;
    for (int i = 0; i < s->bins; i++)
        total += i * s->count[i];
    for (int i = 0; i + 1 < s->bins; i++) {
        mass += s->count[i];
        below += i * s->count[i];
        if (mass <= 0 || mass >= 1)
            continue;
        double d = below / mass - (total - below) / (1 - mass), between = mass * (1 - mass) * d * d;
        if (between > best) {
            best = between;
            split = i;
        }
    }
    return split;
}

/* The background's bin, or -1 where no value stands out. */
static int find_background(const struct pel_survey *s, int window)
{
    int mode = 0;
    double mean = 0;
    for (int i = 0; i < s->bins; i++) {
        mode = s->smooth[i] > s->smooth[mode] ? i : mode;
        mean += i * s->count[i];
    }
    if (share(s, mode - window, mode + window) < 0.3)
        return -1;
    if (mode <= mean + window || share(s, 0, mode - window - 1) < 0.02)
        return mode;
    /* Most of the volume is material, brighter than the mean: what is dark is the background. */
    int split = otsu(s), peak = 0;
    for (int i = 0; i <= split; i++)
        peak = s->smooth[i] > s->smooth[peak] ? i : peak;
    return peak;
}

/* The middle of the background's peak at half its height (0 where the range begins with the mode), and the bin where its upper
 * flank has come down: to a tenth, or to where it rises again. */
static int background_peak(const struct pel_survey *s, int mode, int *flank)
{
    int left = mode, right = mode;
    while (left > 0 && s->smooth[left - 1] >= 0.5 * s->smooth[mode])
        left--;
    while (right + 1 < s->bins && s->smooth[right + 1] >= 0.5 * s->smooth[mode])
        right++;
    int least = right;
    for (int i = right; i < s->bins && s->smooth[least] >= 0.1 * s->smooth[mode] && s->smooth[i] < 1.2 * s->smooth[least]; i++)
        least = s->smooth[i] < s->smooth[least] ? i : least;
    *flank = least;
    return mode == 0 ? 0 : (left + right) / 2;
}

/* What a peak has above the height of the valley before it, up to where it has come down half of the way. */
static double excess(const struct pel_survey *s, int valley, int peak)
{
    double sum = 0, half = (s->smooth[valley] + s->smooth[peak]) / 2;
    for (int i = valley + 1; i < s->bins && (i <= peak || s->smooth[i] >= half); i++)
        sum += s->smooth[i] - s->smooth[valley];
    return sum;
}

/* First peak above the background that is worth the name; -1 where values only fall off. */
static int find_material(const struct pel_survey *s, int flank)
{
    double object = share(s, flank + 1, s->bins);
    int valley = flank, last = s->bins - 1 - s->bins / 64; /* the last bins hold what is saturated: no peak */
    for (int i = valley + 1; i < last; i++) {
        if (s->smooth[i] < s->smooth[valley])
            valley = i;
        else if (s->smooth[i] > s->smooth[i + 1] && s->smooth[i] > 1.4 * s->smooth[valley] && excess(s, valley, i) > 0.03 * object)
            return i;
    }
    return -1;
}

/* Where the boundary between background and material shows: the steepest value, or a little before, where thin parts hold on. */
static int find_boundary(const struct pel_survey *s, int background, int flank, int material)
{
    double most = 1e-9; /* no gradients are known where squares of values overflow */
    for (int i = flank; i <= material; i++)
        most = fmax(most, s->gradient[i]);
    int middle = background + (material - background + 1) / 2;
    for (int i = flank + 1; i < middle; i++)
        if (s->gradient[i] >= 0.9 * most)
            return (i + middle) / 2;
    return middle;
}

/* Noise changes little from voxel to voxel in comparison with a boundary: it ends where the gradient is a good part of the boundary's. */
static int find_noise_end(const struct pel_survey *s, int background, int flank, int boundary)
{
    int bin = background + 1 + (boundary - background) / 8, last = background + (boundary - background) / 2;
    while (bin < last && s->gradient[bin] < 0.3 * s->gradient[boundary])
        bin++;
    return bin > flank ? bin : flank;
}

/* The bin above which `part` of the total of (value - background) lies. */
static int enclose(const struct pel_survey *s, int background, double part)
{
    double total = 0, sum = 0;
    for (int i = background; i < s->bins; i++)
        total += s->count[i] * (i - background);
    for (int i = s->bins - 1; i > background; i--) {
        sum += s->count[i] * (i - background);
        if (sum >= part * total)
            return i;
    }
    return background + 1;
}

/* Background known: what kind of object stands out of it, and where it begins. Gives its boundary's bin. */
static int judge_object(struct pel_survey *s, int background, int flank)
{
    double below = share(s, 0, 2 * background - flank - 1), above = share(s, flank + 1, s->bins);
    if (background * 4 > s->bins && background * 4 < 3 * s->bins && below > 0.25 * above && above > 0.25 * below) {
        s->kind = PEL_SURVEY_SIGNED;
        return enclose(s, background, 0.7);
    }
    int material = find_material(s, flank);
    if (material >= 0) {
        s->kind = PEL_SURVEY_MATERIALS;
        return find_boundary(s, background, flank, material);
    }
    /* Where much of the object is saturated (vessels full of contrast) its share would leave nothing but the thickest parts. */
    s->kind = PEL_SURVEY_FIELD;
    int most = background + (int)ceil(0.3 * (quantile(s, background + 1, 0.99) - background));
    int isovalue = enclose(s, background, 0.7);
    return isovalue < most ? isovalue : most;
}

static void judge_background(struct pel_survey *s, int mode, int window)
{
    int flank, background = background_peak(s, mode, &flank);
    flank = flank > background + window ? flank : background + window;
    flank = flank < s->bins - 1 ? flank : s->bins - 1;
    int isovalue = judge_object(s, background, flank);
    isovalue = isovalue > flank ? isovalue : flank;
    /* Half a bin lower: of two values, 0 and 1, the boundary is at 0.5. */
    s->background = pel_survey_value(s, background);
    s->isovalue = pel_survey_value(s, isovalue - 0.5);
    if (s->kind == PEL_SURVEY_MATERIALS)
        s->threshold = pel_survey_value(s, find_noise_end(s, background, flank, isovalue) - 0.5);
    else
        s->threshold = s->background + (s->isovalue - s->background) * 0.35;
    /* Never at the isovalue: opacity rises from one to the other. */
    s->threshold = fmin(s->threshold, s->background + (s->isovalue - s->background) * 0.6);
}

static void judge(struct pel_survey *s)
{
    int window = s->bins / 40 > 1 ? s->bins / 40 : 1, mode = find_background(s, window);
    if (mode >= 0) {
        judge_background(s, mode, window);
    } else {
        s->kind = PEL_SURVEY_FULL;
        s->background = s->lo;
        s->threshold = pel_survey_value(s, quantile(s, 0, 0.3));
        s->isovalue = pel_survey_value(s, quantile(s, 0, 0.9));
    }
    int first = pel_survey_bin(s, s->threshold);
    s->fill = share(s, first + 1, s->bins);
    first += first + 1 < s->bins;
    int near = quantile(s, first, 0.99), far = quantile(s, first, 0.999); /* a long thin tail would take most of the colours */
    s->top = fmax(pel_survey_value(s, (near - first) * 2 < far - first ? near : far), s->isovalue);
    double middle = pel_survey_value(s, quantile(s, first, 0.5)), rare = pel_survey_value(s, quantile(s, first, 0.97));
    if (s->kind == PEL_SURVEY_MATERIALS && s->fill > 0.65 && rare - middle > 0.3 * (middle - s->background))
        s->isovalue = rare; /* one material fills the box: the object is what stands out of that (vessels in flesh) */
    s->common = fmax(pel_survey_value(s, quantile(s, first, 0.96)), s->isovalue);
}

void pel_survey_volume(const struct pel_volume *volume, struct pel_survey *s)
{
    double lo = volume->range[0], hi = volume->range[1], q_lo, q_hi;
    *s = (struct pel_survey) { .kind = PEL_SURVEY_EMPTY, .extent = 1 };
    s->lo = s->background = s->threshold = s->isovalue = isfinite(lo) ? lo : 0;
    s->hi = s->top = s->common = s->lo + 1;
    if (!volume->data || !isfinite(lo) || !isfinite(hi) || !(lo < hi))
        return;
    /* The histogram divides by hi - lo. */
    lo = fmax(lo, -1e307);
    hi = fmin(hi, 1e307);
    if (sparse_quantiles(volume, &q_lo, &q_hi) && q_lo < q_hi && q_hi - q_lo < 1e-3 * (hi - lo)) {
        lo = q_lo;
        hi = q_hi;
    }
    bool small = is_integer(volume) && hi - lo < PEL_SURVEY_BINS;
    if (!small && !narrow(volume, &lo, &hi))
        return;
    s->bins = choose_bins(volume, &lo, &hi);
    if (!(hi > lo) || s->bins < 1)
        return;
    s->lo = lo;
    s->hi = hi;
    if (!fill_bins(volume, s))
        return;
    judge(s);
    s->extent = fmax(1, cbrt(s->fill * (double)pel_volume_samples(volume)));
}
