/* SPDX-License-Identifier: MIT */
/* Why these two kinds: docs/decisions/0010-the-viewer.md. */
#include "movie.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <minizip/zip.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include "downloads.h"
#include "session_inside.h"

enum { FRAME_MS = 40, WEBP_QUALITY = 90 };

struct movie {
    const struct movie_format *format;
    int size[2], frames;
    int fd;
    WebPAnimEncoder *webp;
    zipFile zip;
};

/* ---- an animated WebP: kept in memory until it is whole ---- */

static bool webp_fail(struct pel_error *error)
{
    return session_fail(error, PEL_ERROR_UNSUPPORTED, "movie: libwebp is of another version than its headers");
}

static bool begin_webp(struct movie *movie, struct pel_error *error)
{
    WebPAnimEncoderOptions options;
    if (!WebPAnimEncoderOptionsInit(&options))
        return webp_fail(error);
    options.kmin = 9;
    options.kmax = 17;
    movie->webp = WebPAnimEncoderNew(movie->size[0], movie->size[1], &options);
    return movie->webp || session_fail(error, PEL_ERROR_MEMORY, "movie: no memory for it");
}

static bool add_webp(struct movie *movie, struct encoder *encoder, const struct pel_image *image, const double *background,
                     struct pel_error *error)
{
    const unsigned char *pixels = encoder_pixels(encoder, image, background, error);
    WebPConfig config;
    WebPPicture picture;
    if (!pixels)
        return false;
    if (!WebPConfigInit(&config) || !WebPPictureInit(&picture))
        return webp_fail(error);
    config.quality = WEBP_QUALITY;
    config.method = 2;
    picture.use_argb = 1;
    picture.width = movie->size[0];
    picture.height = movie->size[1];
    bool fine = WebPPictureImportRGBX(&picture, pixels, 4 * movie->size[0]) &&
                WebPAnimEncoderAdd(movie->webp, &picture, movie->frames * FRAME_MS, &config);
    WebPPictureFree(&picture);
    return fine || session_fail(error, PEL_ERROR_MEMORY, "movie: %.200s", WebPAnimEncoderGetError(movie->webp));
}

static bool end_webp(struct movie *movie, struct pel_error *error)
{
    WebPData data;
    WebPDataInit(&data);
    bool fine = WebPAnimEncoderAdd(movie->webp, NULL, movie->frames * FRAME_MS, NULL) && WebPAnimEncoderAssemble(movie->webp, &data);
    if (!fine)
        session_fail(error, PEL_ERROR_MEMORY, "movie: %.200s", WebPAnimEncoderGetError(movie->webp));
    fine = fine && download_write(movie->fd, data.bytes, data.size, error);
    WebPDataClear(&data);
    return fine;
}

/* ---- PNGs in a ZIP archive, stored as they are: written as they come ---- */

static bool zip_fail(struct pel_error *error)
{
    return session_fail(error, PEL_ERROR_IO, "movie: the temporary file cannot be written; is the disk full? TMPDIR names another folder");
}

static bool begin_zip(struct movie *movie, struct pel_error *error)
{
    char path[32]; /* the file has no name of its own */
    snprintf(path, sizeof path, "/dev/fd/%d", movie->fd);
    movie->zip = zipOpen64(path, APPEND_STATUS_CREATE);
    return movie->zip || zip_fail(error);
}

static bool add_zip(struct movie *movie, struct encoder *encoder, const struct pel_image *image, const double *background,
                    struct pel_error *error)
{
    const void *bytes;
    size_t size;
    char name[32];
    time_t now = time(NULL);
    struct tm t;
    zip_fileinfo info = { 0 };
    if (!encode_png(encoder, image, background, false, NULL, &bytes, &size, error))
        return false;
    snprintf(name, sizeof name, "turn_%04d.png", movie->frames);
    localtime_r(&now, &t);
    info.tmz_date.tm_sec = t.tm_sec;
    info.tmz_date.tm_min = t.tm_min;
    info.tmz_date.tm_hour = t.tm_hour;
    info.tmz_date.tm_mday = t.tm_mday;
    info.tmz_date.tm_mon = t.tm_mon;
    info.tmz_date.tm_year = t.tm_year + 1900;
    return (zipOpenNewFileInZip64(movie->zip, name, &info, NULL, 0, NULL, 0, NULL, 0, 0, 0) == ZIP_OK &&
            zipWriteInFileInZip(movie->zip, bytes, (unsigned)size) == ZIP_OK && zipCloseFileInZip(movie->zip) == ZIP_OK) ||
           zip_fail(error);
}

static bool end_zip(struct movie *movie, struct pel_error *error)
{
    zipFile zip = movie->zip;
    movie->zip = NULL;
    return zipClose(zip, NULL) == ZIP_OK || zip_fail(error);
}

/* ---- both ---- */

static const struct movie_format formats[] = {
    { "webp", "turn.webp", "image/webp", false, begin_webp, add_webp, end_webp },
    { "png", "turn.zip", "application/zip", true, begin_zip, add_zip, end_zip },
};

const struct movie_format *movie_format(const char *word)
{
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        if (strcmp(formats[i].word, word) == 0)
            return &formats[i];
    return NULL;
}

struct movie *movie_begin(const struct movie_format *format, const int size[2], struct pel_error *error)
{
    struct movie *movie = calloc(1, sizeof *movie);
    if (!movie) {
        session_fail(error, PEL_ERROR_MEMORY, "movie: no memory for it");
        return NULL;
    }
    movie->format = format;
    memcpy(movie->size, size, sizeof movie->size);
    movie->fd = download_file(error);
    if (movie->fd >= 0 && format->begin(movie, error))
        return movie;
    movie_destroy(movie);
    return NULL;
}

bool movie_add(struct movie *movie, struct encoder *encoder, const struct pel_image *image, const double *background,
               struct pel_error *error)
{
    const uint64_t most = DOWNLOADS_BYTES / 2;
    struct stat st;
    if (!movie->format->add(movie, encoder, image, background, error))
        return false;
    movie->frames++;
    return (fstat(movie->fd, &st) == 0 && (uint64_t)st.st_size <= most) ||
           session_fail(error, PEL_ERROR_IO,
                        "movie: its file is larger than %.1f GB after %d frames; ask for fewer or smaller ones, or for webp",
                        (double)most / 1e9, movie->frames);
}

int movie_end(struct movie *movie, struct pel_error *error)
{
    int fd = movie->fd;
    if (!movie->format->end(movie, error))
        return -1;
    movie->fd = -1;
    return fd;
}

void movie_destroy(struct movie *movie)
{
    if (!movie)
        return;
    WebPAnimEncoderDelete(movie->webp);
    if (movie->zip)
        zipClose(movie->zip, NULL);
    if (movie->fd >= 0)
        close(movie->fd);
    free(movie);
}
