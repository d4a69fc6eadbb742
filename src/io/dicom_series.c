/* SPDX-License-Identifier: MIT */
/* From a heap of DICOM slices to one volume; see dicom_series.h. A folder may hold several series, localizers beside the stack, the same
 * stack at several times, copies, and gaps; names and the order of files mean nothing. */
#include "dicom_series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "vec.h"

/* Of a step between slices: closer are at the same place, further off than the second is worth a note, than the third a wrong picture. */
#define SAME 0.01
#define UNEVEN 0.01
#define WRONG 0.25

const char *pel_dicom_file_name(const struct pel_dicom_file *file)
{
    const char *slash = strrchr(file->path, '/');
    return slash ? slash + 1 : file->path;
}

static const struct pel_dicom_frame *frame_of(const struct pel_dicom_slice *slice)
{
    return pel_dicom_file_frame(slice->file, slice->frame);
}

/* "4: Thorax": what a series is called in lists and notes. */
static void series_name(const struct pel_dicom_file *file, char *out, size_t size)
{
    snprintf(out, size, "%d%s%s", file->series_number, *file->description ? ": " : "", file->description);
}

static bool is_wanted(const struct pel_dicom_file *file, const char *wanted)
{
    char name[128], number[16];
    series_name(file, name, sizeof name);
    snprintf(number, sizeof number, "%d", file->series_number);
    return !strcmp(wanted, file->series_uid) || !strcmp(wanted, name) || !strcmp(wanted, number);
}

/* A series among the files: its first file and how many slices it has. */
struct series {
    const struct pel_dicom_file *first;
    uint64_t slices;
};

/* Lists the series and picks one. */
static const struct pel_dicom_file *choose_series(struct pel_dicom_file *const *files, size_t file_count, const char *wanted,
                                                  struct pel_file_info *info, struct pel_error *error)
{
    size_t count = 0, best = 0;
    const struct pel_dicom_file *found = NULL;
    struct series *all = pel_alloc(file_count, sizeof *all, "DICOM series", error);
    if (!all)
        return NULL;
    for (size_t i = 0; i < file_count; i++) {
        size_t s = 0;
        while (s < count && strcmp(all[s].first->series_uid, files[i]->series_uid))
            s++;
        if (s == count)
            all[count++].first = files[i];
        all[s].slices += files[i]->frame_count;
    }
    char names[300] = "", name[128];
    for (size_t s = 0; s < count; s++) {
        const struct pel_dicom_pixels *p = &all[s].first->pixels;
        size_t used = strlen(names);
        series_name(all[s].first, name, sizeof name);
        pel_info_array(info, name,
                       p->is_float          ? (p->allocated == 64 ? PEL_F64 : PEL_F32)
                       : p->allocated == 8  ? (p->is_signed ? PEL_I8 : PEL_U8)
                       : p->allocated == 16 ? (p->is_signed ? PEL_I16 : PEL_U16)
                       : p->is_signed       ? PEL_I32
                                            : PEL_U32,
                       p->samples);
        snprintf(names + used, sizeof names - used, "%s\"%s\" (%llu)", used ? ", " : "", name, (unsigned long long)all[s].slices);
        if (wanted && !found && is_wanted(all[s].first, wanted))
            found = all[s].first;
        if (all[s].slices > all[best].slices)
            best = s;
    }
    if (!wanted) {
        found = all[best].first;
        if (count > 1)
            pel_info_note(info, "%zu series in the folder, with slices: %.150s; the largest is read", count, names);
    } else if (!found) {
        pel_fail(error, PEL_ERROR_ARGUMENT, "has no series \"%.80s\"; it has: %s", wanted, names);
    }
    free(all);
    return found;
}

/* Whether two slices can lie in one stack. */
static bool alike(const struct pel_dicom_slice *a, const struct pel_dicom_slice *b)
{
    const struct pel_dicom_pixels *p = &a->file->pixels, *q = &b->file->pixels;
    const struct pel_dicom_frame *f = frame_of(a), *g = frame_of(b);
    if (p->rows != q->rows || p->columns != q->columns || p->samples != q->samples || p->allocated != q->allocated ||
        p->is_signed != q->is_signed || p->is_float != q->is_float)
        return false;
    if (f->has_position != g->has_position || f->has_orientation != g->has_orientation || f->has_spacing != g->has_spacing)
        return false;
    for (int i = 0; i < 6; i++)
        if (f->has_orientation && !(fabs(f->orientation[i] - g->orientation[i]) < 1e-3))
            return false;
    for (int i = 0; i < 2; i++)
        if (f->has_spacing && !(fabs(f->spacing[i] - g->spacing[i]) < 1e-3 * f->spacing[i]))
            return false;
    return true;
}

/* Keeps the largest group of slices that are alike. */
static void keep_alike(struct pel_dicom_slice *slices, size_t *count, struct pel_file_info *info)
{
    int groups = 0, best = 0;
    size_t best_size = 0, kept = 0;
    for (size_t i = 0; i < *count; i++)
        slices[i].group = -1;
    /* A group a round, and a round looks at what is left: quick where there are few groups, and beyond 64 the rest is left out. */
    for (size_t i = 0; i < *count && groups < 64; i++) {
        size_t size = 0;
        if (slices[i].group >= 0)
            continue;
        for (size_t k = i; k < *count; k++)
            if (slices[k].group < 0 && alike(&slices[i], &slices[k])) {
                slices[k].group = groups;
                size++;
            }
        if (size > best_size) {
            best_size = size;
            best = groups;
        }
        groups++;
    }
    for (size_t i = 0; i < *count; i++)
        if (slices[i].group == best)
            slices[kept++] = slices[i];
    if (kept < *count)
        pel_info_note(info, "%zu slices of another size or orientation are left out (localizers?)", *count - kept);
    *count = kept;
}

static int compare(const void *left, const void *right)
{
    const struct pel_dicom_slice *a = left, *b = right;
    if (a->position != b->position)
        return a->position > b->position ? 1 : -1;
    if (a->file->acquisition_number != b->file->acquisition_number)
        return a->file->acquisition_number > b->file->acquisition_number ? 1 : -1;
    if (a->file->instance_number != b->file->instance_number)
        return a->file->instance_number > b->file->instance_number ? 1 : -1;
    if (a->frame != b->frame)
        return a->frame > b->frame ? 1 : -1;
    return strcmp(a->file->path, b->file->path);
}

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x > y ? 1 : x < y ? -1 : 0;
}

/* The step that most neighbours are apart, among those that are apart at all: their median. 0: none is. */
static bool median_step(const struct pel_dicom_slice *slices, size_t count, double *median, struct pel_error *error)
{
    size_t n = 0;
    double *steps = pel_alloc(count, sizeof *steps, "slice distances", error), range = slices[count - 1].position - slices[0].position;
    if (!steps)
        return false;
    for (size_t i = 1; i < count; i++)
        if (slices[i].position - slices[i - 1].position > 1e-6 * range)
            steps[n++] = slices[i].position - slices[i - 1].position;
    qsort(steps, n, sizeof *steps, compare_numbers);
    *median = n ? steps[n / 2] : 0;
    free(steps);
    return true;
}

/* Keeps one slice at each position. The same number at each is a stack at several times, of which the first is taken. */
static void keep_single(struct pel_dicom_slice *slices, size_t *count, double step, struct pel_file_info *info)
{
    size_t kept = 0, run = 0, times = 0;
    bool even = true;
    for (size_t i = 0; i < *count; i++) {
        if (kept && slices[i].position - slices[kept - 1].position <= SAME * step) {
            run++;
            continue;
        }
        even = even && (kept < 2 || run == times);
        times = kept ? run : 0;
        slices[kept++] = slices[i];
        run = 1;
    }
    even = even && (kept < 2 || run == times);
    if (kept < *count && even && kept > 1)
        pel_info_note(info, "%zu stacks at the same place (times, echoes): the first is read", run);
    else if (kept < *count)
        pel_info_note(info, "%zu slices at a place that another one has are left out", *count - kept);
    *count = kept;
}

/* Holds the positions against even steps. */
static bool check_steps(const struct pel_dicom_slice *slices, size_t count, double step, struct pel_file_info *info,
                        struct pel_error *error)
{
    double first = slices[0].position, mean = (slices[count - 1].position - first) / (double)(count - 1), worst = 0;
    for (size_t i = 1; i < count; i++) {
        double gap = slices[i].position - slices[i - 1].position;
        if (gap > 1.5 * step)
            return pel_fail(error, PEL_ERROR_FORMAT,
                            "slices are missing: %.5g mm lie between %.60s and %.60s, elsewhere %.5g: find the %.0f missing", gap,
                            pel_dicom_file_name(slices[i - 1].file), pel_dicom_file_name(slices[i].file), step, round(gap / step) - 1);
        worst = fmax(worst, fabs(slices[i].position - first - mean * (double)i) / mean);
    }
    if (worst > WRONG)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the slices are unevenly spaced: up to %.2g of a step (%.5g mm) off an even grid",
                        worst, mean);
    if (worst > UNEVEN)
        pel_info_note(info, "the slices are unevenly spaced, by up to %.2g of a step: even steps of %.5g mm are taken", worst, mean);
    return true;
}

/* Axes of the volume, from slices that are sorted by position, if they have positions that differ (`placed`). */
static void place(const struct pel_dicom_slice *slices, size_t count, bool placed, const double normal[3], struct pel_volume *volume,
                  struct pel_file_info *info)
{
    const struct pel_dicom_frame *first = frame_of(&slices[0]), *last = frame_of(&slices[count - 1]);
    const struct pel_dicom_file *file = slices[0].file;
    double spacing[3] = { 1, 1, file->between > 0 ? file->between : file->thickness > 0 ? file->thickness : 1 }, step[3];
    if (first->has_spacing)
        memcpy(spacing, first->spacing, sizeof first->spacing);
    else
        pel_info_note(info, "the files do not tell the distance of pixels: taken as 1 mm");
    if (!placed && count > 1)
        pel_info_note(info, "the files do not tell where slices lie: sorted by instance number, %g mm apart", spacing[2]);
    for (int a = 0; a < 2; a++) {
        double unit[3] = { a == 0, a == 1, 0 };
        if (first->has_orientation)
            memcpy(unit, first->orientation + (ptrdiff_t)(3 * a), sizeof unit);
        pel_normalize(unit);
        for (int i = 0; i < 3; i++)
            step[i] = unit[i] * spacing[a];
        pel_volume_set_axis(volume, a, step, info);
    }
    double between = placed ? (slices[count - 1].position - slices[0].position) / (double)(count - 1) : spacing[2];
    for (int i = 0; i < 3; i++)
        step[i] = normal[i] * between;
    if (placed) {
        /* A tilted gantry moves slices sideways too: the grid is sheared then. */
        double whole[3], aside = 0;
        pel_sub(last->position, first->position, whole);
        for (int i = 0; i < 3; i++)
            aside = fmax(aside, fabs(whole[i] - step[i] * (double)(count - 1)));
        for (int i = 0; i < 3 && aside > 1e-3 * between * (double)(count - 1); i++)
            step[i] = whole[i] / (double)(count - 1);
    }
    pel_volume_set_axis(volume, 2, step, info);
    pel_volume_mend_directions(volume, info);
    if (first->has_position)
        memcpy(volume->origin, first->position, sizeof volume->origin);
    volume->space = first->has_orientation ? PEL_SPACE_LPS : PEL_SPACE_UNKNOWN;
    pel_copy_text(volume->units, sizeof volume->units, first->has_spacing ? "mm" : "");
    pel_copy_text(volume->name, sizeof volume->name, *file->description ? file->description : file->modality);
}

/* Makes the orientation two unit vectors at right angles, or says that there is none. */
static bool find_normal(const struct pel_dicom_slice *slice, double normal[3])
{
    const struct pel_dicom_frame *frame = frame_of(slice);
    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (!frame->has_orientation)
        return true;
    pel_cross(frame->orientation, frame->orientation + 3, normal);
    double length = pel_normalize(normal);
    return length > 0.9 && length < 1.1;
}

bool pel_dicom_series_choose(struct pel_dicom_file *const *files, size_t file_count, const char *wanted, struct pel_dicom_slice *slices,
                             size_t *count, struct pel_volume *volume, struct pel_file_info *info, struct pel_error *error)
{
    const struct pel_dicom_file *series = choose_series(files, file_count, wanted, info, error);
    double normal[3], step;
    if (!series)
        return false;
    *count = 0;
    for (size_t i = 0; i < file_count; i++)
        for (uint64_t frame = 0; !strcmp(files[i]->series_uid, series->series_uid) && frame < files[i]->frame_count; frame++)
            slices[(*count)++] = (struct pel_dicom_slice) { .file = files[i], .frame = frame };
    keep_alike(slices, count, info);
    if (!find_normal(&slices[0], normal))
        return pel_fail(error, PEL_ERROR_FORMAT, "%s: rows and columns do not lie at right angles (ImageOrientationPatient)",
                        pel_dicom_file_name(slices[0].file));
    bool placed = frame_of(&slices[0])->has_position;
    for (size_t i = 0; i < *count; i++)
        slices[i].position = placed ? pel_dot(frame_of(&slices[i])->position, normal) : 0;
    qsort(slices, *count, sizeof *slices, compare);
    if (placed && *count > 1) {
        if (!median_step(slices, *count, &step, error))
            return false;
        placed = step > 0; /* else all lie at one place, as the frames of a film do */
        if (placed)
            keep_single(slices, count, step, info);
        if (placed && !check_steps(slices, *count, step, info, error))
            return false;
    }
    place(slices, *count, placed && *count > 1, normal, volume, info);
    return true;
}
