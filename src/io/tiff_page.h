/* SPDX-License-Identifier: MIT */
/* One page of a TIFF file, and the file that it is in, with libtiff kept behind it. */
#ifndef PEL_IO_TIFF_PAGE_H
#define PEL_IO_TIFF_PAGE_H

#include "format.h"

struct pel_tiff;

/* What a page holds. */
struct pel_tiff_page {
    uint32_t width, height;
    enum pel_type type;
    int components;
    int bits;     /* stored bits a number: 8 and more as the type's, or 1, which becomes a u8 */
    bool planes;  /* components lie in planes of their own */
    bool palette; /* colours of a palette that is no gray ramp */
    bool white_is_zero;
    uint64_t ratio;    /* at most so many bytes of samples can come out of a byte of the file */
    double spacing[3]; /* 0: not told */
    char units[16];
    uint64_t run;              /* ImageJ: slices that lie behind one another though only the first has a page; else 0 */
    uint64_t data;             /* where they begin in the file */
    uint64_t channels, frames; /* ImageJ: how the slices are made up; 1 where nothing is told */
    uint64_t slice_step;       /* each so many-th slice makes the volume; see pel_tiff_choose_slices */
};

/* Opens a file, gzip'd or not. Its messages and warnings go nowhere but into the errors of these functions. */
struct pel_tiff *pel_tiff_open(const char *path, struct pel_error *error);
void pel_tiff_close(struct pel_tiff *tiff); /* accepts NULL */
uint64_t pel_tiff_length(const struct pel_tiff *tiff);

/* Steps to the next page; false where there is none, or on an error: pel_tiff_failed then fills in `error` and returns true. */
bool pel_tiff_next(struct pel_tiff *tiff);
bool pel_tiff_failed(const struct pel_tiff *tiff, struct pel_error *error);
bool pel_tiff_rewind(struct pel_tiff *tiff, struct pel_error *error);

/* Whether the page is a smaller copy or a mask of another one. */
bool pel_tiff_is_reduced(struct pel_tiff *tiff);

/* What the page holds; refuses what cannot be read. */
bool pel_tiff_page_read(struct pel_tiff *tiff, struct pel_tiff_page *page, struct pel_error *error);
bool pel_tiff_page_alike(const struct pel_tiff_page *a, const struct pel_tiff_page *b);

/* Of an ImageJ hyperstack of several channels or times, takes the first channel at the first time, with a note. */
void pel_tiff_choose_slices(struct pel_tiff_page *page, uint64_t *slices, struct pel_file_info *info);

/* The current page's samples, component fastest; `page` is what pel_tiff_page_read told of it. */
bool pel_tiff_read_samples(struct pel_tiff *tiff, const struct pel_tiff_page *page, void *out, struct pel_error *error);

/* Slice `slice` of a run (see struct pel_tiff_page). */
bool pel_tiff_read_run(struct pel_tiff *tiff, const struct pel_tiff_page *page, uint64_t slice, void *out, size_t bytes,
                       struct pel_error *error);

#endif
