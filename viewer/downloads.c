/* SPDX-License-Identifier: MIT */
#include "downloads.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "session_inside.h"

const char *temporary_folder(void)
{
    const char *folder = getenv("TMPDIR");
    return folder && folder[0] ? folder : "/tmp";
}

int download_file(struct pel_error *error)
{
    const char *folder = temporary_folder();
    char path[4096];
    int fd = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd < 0 && snprintf(path, sizeof path, "%s/pellucid-XXXXXX", folder) < (int)sizeof path) {
        fd = mkostemp(path, O_CLOEXEC);
        if (fd >= 0)
            unlink(path);
    }
    if (fd < 0)
        session_fail(error, PEL_ERROR_IO, "%s: no temporary file can be made there: %s; set TMPDIR to another folder", folder,
                     strerror(errno));
    return fd;
}

bool download_write(int fd, const void *bytes, uint64_t size, struct pel_error *error)
{
    const char *at = bytes;
    while (size > 0) {
        ssize_t done = write(fd, at, size);
        if (done < 0 && errno == EINTR)
            continue;
        if (done <= 0)
            return session_fail(error, PEL_ERROR_IO, "the temporary file cannot be written: %s", strerror(done < 0 ? errno : ENOSPC));
        at += done;
        size -= (uint64_t)done;
    }
    return true;
}

static void drop(struct download *entry)
{
    if (entry->number)
        close(entry->fd);
    entry->number = 0;
}

/* The oldest goes first; the newest stays. */
static void make_room(struct downloads *downloads)
{
    uint64_t bytes = 0;
    for (unsigned age = 0; age < DOWNLOADS_KEPT && age < downloads->last; age++) {
        struct download *entry = &downloads->kept[(downloads->last - age) % DOWNLOADS_KEPT];
        bytes += entry->number ? entry->bytes : 0;
        if (bytes > DOWNLOADS_BYTES && age > 0)
            drop(entry);
    }
}

const struct download *downloads_add(struct downloads *downloads, int fd, const char *name, const char *type, double now_ms)
{
    struct stat st;
    unsigned number = ++downloads->last;
    struct download *entry = &downloads->kept[number % DOWNLOADS_KEPT];
    drop(entry);
    *entry = (struct download) { .number = number, .fd = fd, .type = type, .since_ms = now_ms };
    entry->bytes = fstat(fd, &st) == 0 ? (uint64_t)st.st_size : 0;
    snprintf(entry->name, sizeof entry->name, "%s", name);
    make_room(downloads);
    return entry;
}

void downloads_expire(struct downloads *downloads, double now_ms)
{
    for (int i = 0; i < DOWNLOADS_KEPT; i++)
        if (now_ms - downloads->kept[i].since_ms > DOWNLOADS_MS)
            drop(&downloads->kept[i]);
}

const struct download *downloads_find(const struct downloads *downloads, unsigned number, double now_ms)
{
    const struct download *entry = &downloads->kept[number % DOWNLOADS_KEPT];
    return number && entry->number == number && now_ms - entry->since_ms <= DOWNLOADS_MS ? entry : NULL;
}

void downloads_finish(struct downloads *downloads)
{
    for (int i = 0; i < DOWNLOADS_KEPT; i++)
        drop(&downloads->kept[i]);
}
