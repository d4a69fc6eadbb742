/* SPDX-License-Identifier: MIT */
/* TIFF through libtiff: a file with a page a slice, or a folder with a file a slice. What is on a page is in tiff_page.c.
 *
 * All slices must agree in size and type. TIFF knows no third dimension: the distance of slices is told only by ImageJ and OME, in the
 * description; elsewhere it is taken as that of pixels, with a note. */
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "alloc.h"
#include "fail.h"
#include "tiff_page.h"

static bool probe_tiff(const unsigned char *bytes, size_t size, const char *path)
{
    (void)path;
    return size >= 8 &&
           (!memcmp(bytes, "II*\0", 4) || !memcmp(bytes, "MM\0*", 4) || !memcmp(bytes, "II+\0", 4) || !memcmp(bytes, "MM\0+", 4));
}

/* Numbers in names count as numbers: slice2 comes before slice10. */
static int compare_names(const char *a, const char *b)
{
    while (*a && *b) {
        if (*a >= '0' && *a <= '9' && *b >= '0' && *b <= '9') {
            size_t za = strspn(a, "0"), zb = strspn(b, "0"), na = strspn(a + za, "0123456789"), nb = strspn(b + zb, "0123456789");
            int order = na != nb ? (na > nb ? 1 : -1) : memcmp(a + za, b + zb, na);
            if (order)
                return order;
            a += za + na;
            b += zb + nb;
        } else if (*a != *b) {
            return (unsigned char)*a > (unsigned char)*b ? 1 : -1;
        } else {
            a++;
            b++;
        }
    }
    return *a ? 1 : *b ? -1 : 0;
}

static int by_number(const struct dirent **a, const struct dirent **b)
{
    int order = compare_names((*a)->d_name, (*b)->d_name);
    return order ? order : strcmp((*a)->d_name, (*b)->d_name);
}

static int is_slice(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && pel_path_has_ending(entry->d_name, ".tif .tiff");
}

/* What the file says about distances, beside its pages. */
static void place(const struct pel_tiff_page *page, bool one_slice, struct pel_volume *volume, struct pel_file_info *info)
{
    for (int a = 0; a < 3; a++)
        if (page->spacing[a] > 0 && isfinite(page->spacing[a]))
            volume->spacing[a] = page->spacing[a];
    pel_copy_text(volume->units, sizeof volume->units, page->units);
    if (!(page->spacing[2] > 0) && !one_slice)
        pel_info_note(info, "TIFF does not tell the distance of slices: taken as %g unless --spacing says it", volume->spacing[2]);
    if (page->palette)
        pel_info_note(info, "the colours of a palette are left out: the values are its indices");
    if (page->white_is_zero)
        pel_info_note(info, "the file says that 0 is white; the values are as stored");
}

static bool allocate(const struct pel_tiff_page *page, uint64_t slices, uint64_t length, struct pel_volume *volume, struct pel_error *error)
{
    uint64_t dims[3] = { page->width, page->height, slices };
    size_t bytes, shape[3] = { page->width, page->height, (size_t)slices };
    if (!pel_volume_size_check(dims, page->type, page->components, &bytes, error))
        return false;
    if (bytes / page->ratio > length)
        return pel_fail(error, PEL_ERROR_FORMAT, "%zu bytes of samples in %llu slices cannot be in %llu bytes of TIFF; something is truncated", bytes,
                        (unsigned long long)slices, (unsigned long long)length);
    return pel_volume_allocate(volume, shape, page->type, page->components, error);
}

static bool refuse_different(const struct pel_tiff_page *first, const struct pel_tiff_page *page, struct pel_error *error)
{
    return pel_fail(error, PEL_ERROR_FORMAT, "has %u x %u pixels of %d x %s, the first slice has %u x %u of %d x %s; all must agree",
                    page->width, page->height, page->components, pel_type_name(page->type), first->width, first->height, first->components,
                    pel_type_name(first->type));
}

/* Counts the pages of an open file that are slices and holds them against the first, which the file is left at. */
static bool count_pages(struct pel_tiff *tiff, struct pel_tiff_page *first, uint64_t *count, uint64_t *left_out, struct pel_error *error)
{
    *count = *left_out = 0;
    do {
        struct pel_tiff_page page;
        if (pel_tiff_is_reduced(tiff)) {
            (*left_out)++;
            continue;
        }
        if (!pel_tiff_page_read(tiff, &page, error))
            return pel_fail_in(error, "page %llu: ", (unsigned long long)(*count + 1));
        if (*count == 0)
            *first = page;
        else if (!pel_tiff_page_alike(first, &page) && !refuse_different(first, &page, error))
            return pel_fail_in(error, "page %llu ", (unsigned long long)(*count + 1));
        (*count)++;
    } while (pel_tiff_next(tiff));
    if (pel_tiff_failed(tiff, error))
        return pel_fail_in(error, "page %llu: ", (unsigned long long)(*count + 1));
    if (*count == 0)
        return pel_fail(error, PEL_ERROR_FORMAT, "has no page that is a slice");
    return pel_tiff_rewind(tiff, error);
}

/* The pages of an open file, or, where ImageJ wrote only the first one's tags, the slices that lie behind one another in it. */
static bool read_pages(struct pel_tiff *tiff, const struct pel_tiff_page *first, uint64_t count, const struct pel_read_params *params,
                       struct pel_volume *volume, struct pel_error *error)
{
    size_t bytes = pel_volume_bytes(volume) / volume->dims[2];
    bool run = count == 1 && volume->dims[2] > 1;
    char *out = volume->data;
    for (uint64_t done = 0; done < volume->dims[2];) {
        if (!run && pel_tiff_is_reduced(tiff)) {
            if (!pel_tiff_next(tiff))
                return pel_fail(error, PEL_ERROR_FORMAT, "the file has changed while it was read");
            continue;
        }
        if (!pel_progress_report(&params->progress, (double)done / (double)volume->dims[2], error))
            return false;
        uint64_t slice = done * first->slice_step;
        if (!(run ? pel_tiff_read_run(tiff, first, slice, out, bytes, error) : pel_tiff_read_samples(tiff, first, out, error)))
            return pel_fail_in(error, "page %llu: ", (unsigned long long)(done + 1));
        out += bytes;
        done++;
        for (uint64_t step = 0; !run && done < volume->dims[2] && step < first->slice_step; step++)
            if (!pel_tiff_next(tiff))
                return pel_fail(error, PEL_ERROR_FORMAT, "the file has changed while it was read");
    }
    return true;
}

static bool read_file(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                      struct pel_error *error)
{
    struct pel_tiff_page first;
    uint64_t pages, left_out;
    struct pel_tiff *tiff = pel_tiff_open(path, error);
    if (!tiff)
        return false;
    bool ok = count_pages(tiff, &first, &pages, &left_out, error);
    if (ok) {
        uint64_t slices = pages == 1 && first.run > 1 ? first.run : pages;
        pel_tiff_choose_slices(&first, &slices, info);
        ok = allocate(&first, slices, pel_tiff_length(tiff), volume, error) && read_pages(tiff, &first, pages, params, volume, error);
    }
    if (ok && left_out)
        pel_info_note(info, "%llu pages of lower resolution are left out", (unsigned long long)left_out);
    if (ok)
        place(&first, volume->dims[2] == 1, volume, info);
    pel_tiff_close(tiff);
    return ok;
}

/* One file of a folder into slice z. The first file shapes the volume. */
static bool read_slice(const char *path, size_t z, size_t count, uint64_t length, struct pel_tiff_page *first, struct pel_volume *volume,
                       struct pel_error *error)
{
    struct pel_tiff_page page;
    struct pel_tiff *tiff = pel_tiff_open(path, error);
    uint64_t pages, left_out;
    bool ok = tiff && count_pages(tiff, &page, &pages, &left_out, error);
    if (ok && (pages > 1 || page.run > 1))
        ok = pel_fail(error, PEL_ERROR_UNSUPPORTED, "has several pages; in a folder of slices each file has one");
    if (ok && z > 0 && !pel_tiff_page_alike(first, &page))
        ok = refuse_different(first, &page, error);
    if (ok && z == 0) {
        *first = page;
        ok = allocate(first, count, length, volume, error);
    }
    while (ok && pel_tiff_is_reduced(tiff) && pel_tiff_next(tiff))
        ;
    if (ok)
        ok = pel_tiff_read_samples(tiff, first, (char *)volume->data + z * (pel_volume_bytes(volume) / volume->dims[2]), error);
    pel_tiff_close(tiff);
    return ok;
}

static bool read_slices(const char *folder, struct dirent **names, size_t count, const struct pel_read_params *params,
                        struct pel_volume *volume, struct pel_file_info *info, struct pel_error *error)
{
    struct pel_tiff_page first = { 0 };
    uint64_t length = 0;
    char **paths = pel_alloc(count, sizeof *paths, "file names", error);
    bool ok = paths != NULL;
    for (size_t i = 0; ok && i < count; i++) {
        size_t size = strlen(folder) + strlen(names[i]->d_name) + 2;
        struct stat st;
        ok = (paths[i] = pel_alloc(size, 1, "file name", error)) != NULL;
        if (ok)
            snprintf(paths[i], size, "%s/%s", folder, names[i]->d_name);
        if (ok && stat(paths[i], &st) == 0 && st.st_size > 0)
            length += (uint64_t)st.st_size;
    }
    for (size_t i = 0; ok && i < count; i++) {
        ok = pel_progress_report(&params->progress, (double)i / (double)count, error);
        ok = ok && read_slice(paths[i], i, count, length, &first, volume, error);
        bool all_together = i == 0 && first.width && !volume->data; /* that they are too short is no fault of the first */
        if (!ok && !all_together)
            pel_fail_in(error, "%s: ", names[i]->d_name);
    }
    if (ok)
        place(&first, count == 1, volume, info);
    for (size_t i = 0; paths && i < count; i++)
        free(paths[i]);
    free(paths);
    return ok;
}

static bool read_folder(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                        struct pel_error *error)
{
    struct dirent **names = NULL;
    int count = scandir(path, &names, is_slice, by_number);
    if (count < 0)
        return pel_fail_errno(error, "cannot be read");
    bool ok = count > 0 ? read_slices(path, names, (size_t)count, params, volume, info, error)
                        : pel_fail(error, PEL_ERROR_FORMAT, "has no .tif or .tiff files in it");
    for (int i = 0; i < count; i++)
        free(names[i]);
    free(names);
    return ok;
}

static bool read_tiff(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                      struct pel_error *error)
{
    struct stat st;
    if (pel_info_choose(info, params, 0, error) < 0)
        return false;
    return stat(path, &st) == 0 && S_ISDIR(st.st_mode) ? read_folder(path, params, volume, info, error)
                                                       : read_file(path, params, volume, info, error);
}

const struct pel_format pel_format_tiff = {
    .info = { "tiff", "TIFF: many pages, or a folder of slices", ".tif .tiff", true, false },
    .folders = true,
    .probe = probe_tiff,
    .read = read_tiff,
};
