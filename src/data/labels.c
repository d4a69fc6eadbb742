/* SPDX-License-Identifier: MIT */
/* Are the samples labels (a segmentation) or a signal? Interpolating labels shows tissues that are not there, so it is worth a look; a
 * signal taken for labels would show staircases, so the answer is yes only where several signs agree. Along sampled rows runs of equal
 * values are found, and every step from a run to the next is judged:
 *   - a signal leads from one value to another through those between them; labels jump across values that exist elsewhere;
 *   - a reconstructed edge leaves single samples of a middle value between two runs (partial volume); labels hardly do;
 *   - labels are constant inside, a signal that happens to have few values still has noise.
 * Two values alone say nothing (a mask and a thresholded signal are the same thing) and stay a signal: smooth surfaces serve both. */
#include <pellucid/volume.h>

#include <string.h>

#define MAX_LABELS 64
#define MAX_SAMPLES ((size_t)2 << 20) /* looked at, at most */

struct label_evidence {
    long long values[MAX_LABELS]; /* distinct, in rising order */
    int count;
    size_t samples;       /* looked at and not background */
    size_t steps[MAX_LABELS][MAX_LABELS]; /* steps between value i and value j, by their place at the time of the second pass */
    size_t ramps;         /* steps into a single sample that lies strictly between its neighbours */
    size_t total_steps;
};

static long long load(const struct pel_volume *volume, size_t i)
{
    switch (volume->type) {
    case PEL_U8: return ((const unsigned char *)volume->data)[i];
    case PEL_I8: return ((const signed char *)volume->data)[i];
    case PEL_U16: return ((const unsigned short *)volume->data)[i];
    case PEL_I16: return ((const short *)volume->data)[i];
    case PEL_U32: return ((const unsigned *)volume->data)[i];
    case PEL_I32: return ((const int *)volume->data)[i];
    default: return 0;
    }
}

static int place_of(const struct label_evidence *e, long long value)
{
    int lo = 0, hi = e->count;
    while (lo < hi) {
        int middle = (lo + hi) / 2;
        if (e->values[middle] < value)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

/* Gathers the distinct values of a row; false where they become too many. */
static bool gather_values(const struct pel_volume *volume, size_t row, struct label_evidence *e)
{
    size_t n = volume->dims[0];
    long long last = 0;
    for (size_t x = 0; x < n; x++) {
        long long value = load(volume, row * n + x);
        if (x && value == last)
            continue;
        last = value;
        int place = place_of(e, value);
        if (place < e->count && e->values[place] == value)
            continue;
        if (e->count == MAX_LABELS)
            return false;
        memmove(&e->values[place + 1], &e->values[place], (size_t)(e->count - place) * sizeof *e->values);
        e->values[place] = value;
        e->count++;
    }
    return true;
}

/* Counts the steps of a row. `before` is the value of the run before the current one, by place; -1: none yet. */
static void gather_steps(const struct pel_volume *volume, size_t row, struct label_evidence *e, size_t histogram[MAX_LABELS])
{
    size_t n = volume->dims[0], length = 0;
    int before = -1, current = -1;
    long long value = 0;
    for (size_t x = 0; x < n; x++) {
        long long next = load(volume, row * n + x);
        if (x && next == value) {
            histogram[current]++;
            length++;
            continue;
        }
        int place = place_of(e, next);
        if (current >= 0) {
            e->steps[current][place]++;
            e->total_steps++;
            if (length == 1 && before >= 0 && ((before < current && current < place) || (before > current && current > place)))
                e->ramps++;
        }
        before = current;
        current = place;
        value = next;
        length = 1;
        histogram[current]++;
    }
}

static bool judge(const struct label_evidence *e, const size_t histogram[MAX_LABELS])
{
    size_t jumps = 0, all = 0, background = 0;
    for (int i = 0; i < e->count; i++) {
        all += histogram[i];
        background = histogram[i] > background ? histogram[i] : background;
        for (int j = 0; j < e->count; j++)
            if (j > i + 1 || i > j + 1)
                jumps += e->steps[i][j];
    }
    size_t objects = all - background;
    return e->total_steps > 0 && jumps * 2 > e->total_steps && e->ramps * 5 < e->total_steps && e->total_steps < objects;
}

bool pel_volume_detect_labels(struct pel_volume *volume)
{
    volume->labels = false;
    if (volume->type >= PEL_F32 || volume->components != 1 || !volume->data)
        return false;
    size_t rows = volume->dims[1] * volume->dims[2], stride = pel_volume_samples(volume) / MAX_SAMPLES + 1;
    while (stride > 1 && volume->dims[1] % stride == 0) /* else the same rows of each slice would be looked at */
        stride++;
    struct label_evidence evidence = { .count = 0 };
    size_t histogram[MAX_LABELS] = { 0 };
    for (size_t row = 0; row < rows; row += stride)
        if (!gather_values(volume, row, &evidence))
            return false;
    if (evidence.count < 3)
        return false;
    for (size_t row = 0; row < rows; row += stride)
        gather_steps(volume, row, &evidence, histogram);
    volume->labels = judge(&evidence, histogram);
    return volume->labels;
}
