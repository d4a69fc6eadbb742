/* SPDX-License-Identifier: MIT */
/* Frames in one file to be downloaded: an animated WebP, which every browser plays, or numbered PNGs in a ZIP archive, without loss, for
 * any program that makes films of pictures. */
#ifndef VIEWER_MOVIE_H
#define VIEWER_MOVIE_H

#include "encode.h"

struct movie;

/* A kind of file. */
struct movie_format {
    const char *word, *name, *type; /* name: of the file; type: of its content, as HTTP says it */
    bool alpha;                     /* frames can keep it */
    bool (*begin)(struct movie *movie, struct pel_error *error);
    bool (*add)(struct movie *movie, struct encoder *encoder, const struct pel_image *image, const double *background,
                struct pel_error *error);
    bool (*end)(struct movie *movie, struct pel_error *error);
};

/* "webp" or "png"; NULL for another word. */
const struct movie_format *movie_format(const char *word);

struct movie *movie_begin(const struct movie_format *format, const int size[2], struct pel_error *error);
/* The next frame, before `background` (NULL: its alpha is kept). Fails where the file gets too large to be kept. */
bool movie_add(struct movie *movie, struct encoder *encoder, const struct pel_image *image, const double *background,
               struct pel_error *error);
/* Its file, the caller's; -1 on failure. Nothing but movie_destroy may follow. */
int movie_end(struct movie *movie, struct pel_error *error);
void movie_destroy(struct movie *movie); /* accepts NULL */

#endif
