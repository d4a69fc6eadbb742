/* SPDX-License-Identifier: MIT */
/* Whether the files that a command writes are ones that it reads, or one another: refused before anything is written. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "tool.h"

/* The folder that a path lies in, without links; false where there is none. */
static bool real_folder(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    size_t length = slash ? slash == path ? 1 : (size_t)(slash - path) : 1;
    char text[PATH_MAX];
    if (length >= sizeof text)
        return false;
    memcpy(text, slash ? path : ".", length);
    text[length] = 0;
    return realpath(text, folder);
}

bool tool_same_file(const char *a, const char *b)
{
    struct stat first, second;
    bool is_a = stat(a, &first) == 0, is_b = stat(b, &second) == 0;
    if (is_a && is_b) /* a pipe or /dev/null may be written twice */
        return S_ISREG(first.st_mode) && first.st_dev == second.st_dev && first.st_ino == second.st_ino;
    char folder_a[PATH_MAX], folder_b[PATH_MAX];
    if (is_a || is_b || !real_folder(a, folder_a) || !real_folder(b, folder_b) || strcmp(folder_a, folder_b) != 0)
        return false;
    const char *name_a = strrchr(a, '/'), *name_b = strrchr(b, '/');
    return strcmp(name_a ? name_a + 1 : a, name_b ? name_b + 1 : b) == 0;
}

/* Whether `name`, as it stands in a header, leads from there to the file. */
static bool leads_to(const char *header, const char *name, const char *path)
{
    const char *slash = name[0] == '/' ? NULL : strrchr(header, '/');
    char text[PATH_MAX];
    int length = snprintf(text, sizeof text, "%.*s%s", slash ? (int)(slash + 1 - header) : 0, header, name);
    return name[0] && length < (int)sizeof text && tool_same_file(text, path);
}

bool tool_reads_from(const char *input, const char *path)
{
    struct stat st;
    if (!input || !path[0] || strcmp(path, "-") == 0)
        return false;
    if (tool_same_file(input, path))
        return true;
    if (stat(path, &st) != 0) /* a file that is not there is not read */
        return false;
    /* Headers of detached data are text: "data file: NAME", "ElementDataFile = NAME", or a list with a name on each line. */
    FILE *file = stat(input, &st) == 0 && S_ISREG(st.st_mode) ? fopen(input, "rb") : NULL;
    char line[PATH_MAX];
    bool found = false;
    for (int lines = 0; file && !found && lines < 2000 && fgets(line, sizeof line, file); lines++) {
        line[strcspn(line, "\r\n")] = 0;
        if (lines == 0 && strncmp(line, "NRRD", 4) != 0 && !strchr(line, '='))
            break;
        char *value = strpbrk(line, ":=");
        value = value ? value + 1 + strspn(value + 1, " \t") : line;
        found = leads_to(input, value, path);
    }
    if (file)
        fclose(file);
    return found;
}
