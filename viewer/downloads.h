/* SPDX-License-Identifier: MIT */
/* What was offered for download: files without a name, each kept for ten minutes or until eight newer ones came, or such as leave it no
 * room.
 */
#ifndef VIEWER_DOWNLOADS_H
#define VIEWER_DOWNLOADS_H

#include <stdbool.h>
#include <stdint.h>

#include <pellucid/error.h>

enum { DOWNLOADS_KEPT = 8 };
#define DOWNLOADS_MS 600000.0
/* Of all of them together; one may have half. */
#define DOWNLOADS_BYTES (UINT64_C(8) << 30)

/* Starts zeroed. */
struct downloads {
    unsigned last; /* number of the newest; they begin at 1 */
    struct download {
        unsigned number; /* 0: none */
        int fd;
        char name[128];
        const char *type;
        uint64_t bytes;
        double since_ms;
    } kept[DOWNLOADS_KEPT];
};

/* TMPDIR, or /tmp. */
const char *temporary_folder(void);

/* A file without a name, to be written; -1 on failure. */
int download_file(struct pel_error *error);
/* Writes all of it. */
bool download_write(int fd, const void *bytes, uint64_t size, struct pel_error *error);

/* Keeps a file that was written (taken over), at the time `now_ms`; gives its entry. */
const struct download *downloads_add(struct downloads *downloads, int fd, const char *name, const char *type, double now_ms);
/* NULL: it is no longer kept. */
const struct download *downloads_find(const struct downloads *downloads, unsigned number, double now_ms);
/* Closes what was kept long enough. */
void downloads_expire(struct downloads *downloads, double now_ms);
void downloads_finish(struct downloads *downloads);

#endif
