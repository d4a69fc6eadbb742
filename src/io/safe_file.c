/* SPDX-License-Identifier: MIT */
#include "safe_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "alloc.h"
#include "fail.h"

/* The folder of a path, "." where it names none. Owned by the caller. */
static char *folder_of(const char *path, struct pel_error *error)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return pel_strdup(".", error);
    char *folder = pel_strdup(path, error);
    if (folder)
        folder[slash == path ? 1 : slash - path] = 0;
    return folder;
}

/* A name beside `path` that no file has yet is found by trying; this makes the attempt-th one. */
static char *beside(const char *path, unsigned attempt, struct pel_error *error)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    size_t size = strlen(path) + 48;
    char *temporary = pel_alloc(size, 1, "file name", error);
    if (temporary)
        snprintf(temporary, size, "%.*s.%.100s.%ld-%u.part", (int)(name - path), path, name, (long)getpid(), attempt);
    return temporary;
}

/* A file without a name in the target's folder; -1 where the file system, or a missing /proc (through which it gets its name), has none. */
static int open_unnamed(const char *path)
{
#ifdef O_TMPFILE
    if (access("/proc/self/fd", X_OK) != 0)
        return -1;
    char *folder = folder_of(path, NULL);
    int fd = folder ? open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666) : -1;
    free(folder);
    return fd;
#else
    (void)path;
    return -1;
#endif
}

static int open_named(struct pel_safe_file *out, struct pel_error *error)
{
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        out->temporary = beside(out->path, attempt, error);
        if (!out->temporary)
            return -1;
        int fd = open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd >= 0)
            return fd;
        int why = errno;
        free(out->temporary);
        out->temporary = NULL;
        errno = why;
        if (why != EEXIST)
            break;
    }
    pel_fail_errno(error, "cannot be written");
    return -1;
}

static bool open_descriptor(struct pel_safe_file *out, const char *path, int *fd, struct pel_error *error)
{
    struct stat old;
    bool exists = stat(path, &old) == 0;
    if (exists && S_ISDIR(old.st_mode))
        return pel_fail(error, PEL_ERROR_IO, "is a folder; name a file");
    /* Through a symbolic link, the file that it leads to is replaced and the link stays. */
    char *real = exists ? realpath(path, NULL) : NULL;
    out->path = pel_strdup(real ? real : path, error);
    free(real);
    if (!out->path)
        return false;
    if (exists && !S_ISREG(old.st_mode)) {
        out->direct = true;
        *fd = open(out->path, O_WRONLY | O_CLOEXEC);
        return *fd >= 0 || pel_fail_errno(error, "cannot be written");
    }
    if (exists && access(path, W_OK) != 0)
        return pel_fail_errno(error, "cannot be written");
    *fd = open_unnamed(out->path);
    if (*fd < 0)
        *fd = open_named(out, error);
    if (*fd >= 0 && exists && fchmod(*fd, old.st_mode & 07777) != 0)
        errno = 0; /* it keeps the mode that a new file has */
    return *fd >= 0;
}

bool pel_safe_file_open(struct pel_safe_file *out, const char *path, struct pel_error *error)
{
    *out = (struct pel_safe_file){ 0 };
    int fd = -1;
    if (open_descriptor(out, path, &fd, error)) {
        out->file = fdopen(fd, "wb");
        if (out->file)
            return true;
        pel_fail_errno(error, "cannot be written");
        close(fd);
    }
    pel_safe_file_abort(out);
    return false;
}

/* Whether a line of a text header ends with ": name" or "= name", as "data file: name" does. */
static bool header_names(const char *header, const char *name)
{
    struct stat st;
    FILE *file = stat(header, &st) == 0 && S_ISREG(st.st_mode) ? fopen(header, "rb") : NULL;
    char line[4096];
    bool found = false;
    for (int lines = 0; file && !found && lines < 1000 && fgets(line, sizeof line, file); lines++) {
        line[strcspn(line, "\r\n")] = 0;
        char *value = strpbrk(line, ":=");
        found = value && strcmp(value + 1 + strspn(value + 1, " \t"), name) == 0;
    }
    if (file)
        fclose(file);
    return found;
}

bool pel_safe_file_open_data(struct pel_safe_file *out, const char *header, const char *path, const char *name, struct pel_error *error)
{
    struct stat st;
    *out = (struct pel_safe_file){ 0 };
    if (lstat(path, &st) == 0 && !header_names(header, name))
        return pel_fail(error, PEL_ERROR_IO,
                        "its data would replace %.200s, which exists; choose another name or an attached format (.mha, .nrrd)", name);
    return pel_safe_file_open(out, path, error);
}

bool pel_safe_file_write(struct pel_safe_file *out, const void *bytes, size_t size, struct pel_error *error)
{
    if (size == 0 || fwrite(bytes, 1, size, out->file) == size)
        return true;
    return pel_fail_errno(error, "writing failed");
}

/* Gives an unnamed file a temporary name; link never replaces a file that is there, so the last step is a rename in any case. */
static bool name_it(struct pel_safe_file *out, struct pel_error *error)
{
    char source[64];
    snprintf(source, sizeof source, "/proc/self/fd/%d", fileno(out->file));
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        char *name = beside(out->path, attempt, error);
        if (!name)
            return false;
        if (linkat(AT_FDCWD, source, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0) {
            out->temporary = name;
            return true;
        }
        int why = errno;
        free(name);
        errno = why;
        if (why != EEXIST)
            break;
    }
    return pel_fail_errno(error, "cannot be written");
}

bool pel_safe_file_commit(struct pel_safe_file *out, struct pel_error *error)
{
    bool ok = true;
    if (fflush(out->file) != 0 || ferror(out->file))
        ok = pel_fail_errno(error, "writing failed");
    if (ok && !out->direct && !out->temporary)
        ok = name_it(out, error);
    if (fclose(out->file) != 0 && ok)
        ok = pel_fail_errno(error, "writing failed");
    out->file = NULL;
    if (ok && out->temporary) {
        if (rename(out->temporary, out->path) == 0) {
            free(out->temporary);
            out->temporary = NULL;
        } else {
            ok = pel_fail_errno(error, "cannot be written");
        }
    }
    pel_safe_file_abort(out);
    return ok;
}

void pel_safe_file_abort(struct pel_safe_file *out)
{
    if (out->file)
        fclose(out->file);
    if (out->temporary)
        unlink(out->temporary);
    free(out->temporary);
    free(out->path);
    *out = (struct pel_safe_file){ 0 };
}
