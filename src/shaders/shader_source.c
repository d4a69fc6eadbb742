/* SPDX-License-Identifier: MIT */
#include "shader_source.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "alloc.h"
#include "fail.h"

#define MAX_SHADER_FILES 128
#define LONGEST_SHADER ((size_t)1 << 20)

struct composing {
    char *text;
    size_t length, room;
    bool taken[MAX_SHADER_FILES];
    const char *folder; /* PELLUCID_SHADERS or NULL */
    struct pel_error *error;
};

static bool append(struct composing *c, const char *text, size_t length)
{
    if (c->length + length + 1 > c->room) {
        size_t room = (c->length + length + 1) * 2;
        char *grown = realloc(c->text, room);
        if (!grown)
            return pel_fail(c->error, PEL_ERROR_MEMORY, "shader: no memory for %zu bytes", room);
        c->text = grown;
        c->room = room;
    }
    memcpy(c->text + c->length, text, length);
    c->length += length;
    c->text[c->length] = 0;
    return true;
}

static size_t file_index(const char *name)
{
    size_t i = 0;
    while (i < pel_shader_file_count && strcmp(pel_shader_files[i].name, name) != 0)
        i++;
    return i;
}

/* The file's text from the folder that overrides, to be freed; NULL where it is not there. */
static char *read_override(const struct composing *c, const char *name)
{
    char path[1024];
    if (!c->folder || snprintf(path, sizeof path, "%s/%s", c->folder, name) >= (int)sizeof path)
        return NULL;
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    char *text = malloc(LONGEST_SHADER);
    size_t length = text ? fread(text, 1, LONGEST_SHADER - 1, file) : 0;
    fclose(file);
    if (text)
        text[length] = 0;
    return text;
}

static bool add_file(struct composing *c, const char *name, int depth);

/* A line `#include "name"`: its name, or false. */
static bool included(const char *line, size_t length, char name[64])
{
    char format[8], text[128];
    snprintf(text, sizeof text, "%.*s", (int)(length < sizeof text ? length : sizeof text - 1), line);
    return sscanf(text, " #%7s \"%63[^\"]\"", format, name) == 2 && !strcmp(format, "include");
}

static bool add_lines(struct composing *c, const char *name, size_t index, const char *text, int depth)
{
    int number = 1;
    char mark[64], other[64];
    snprintf(mark, sizeof mark, "#line 1 %zu\n", index + 1); /* 0 is what a driver says where it does not know */
    if (!append(c, mark, strlen(mark)))
        return false;
    while (*text) {
        const char *end = strchr(text, '\n');
        size_t length = end ? (size_t)(end - text) : strlen(text);
        if (included(text, length, other)) {
            if (!add_file(c, other, depth + 1))
                return pel_fail_in(c->error, "%s:%d: ", name, number);
            snprintf(mark, sizeof mark, "#line %d %zu\n", number + 1, index + 1);
            if (!append(c, mark, strlen(mark)))
                return false;
        } else if (!append(c, text, length) || !append(c, "\n", 1)) {
            return false;
        }
        text += length + (end != NULL);
        number++;
    }
    return true;
}

static bool add_file(struct composing *c, const char *name, int depth)
{
    size_t index = file_index(name);
    if (index >= pel_shader_file_count || index >= MAX_SHADER_FILES)
        return pel_fail(c->error, PEL_ERROR_UNSUPPORTED, "there is no shader file %.60s", name);
    if (depth > 16)
        return pel_fail(c->error, PEL_ERROR_UNSUPPORTED, "shader files include each other without end");
    if (c->taken[index])
        return true;
    c->taken[index] = true;
    char *other = read_override(c, name);
    bool ok = add_lines(c, name, index, other ? other : pel_shader_files[index].text, depth);
    free(other);
    return ok;
}

char *pel_shader_compose(const char *name, const char *defines, struct pel_error *error)
{
    struct composing c = { .folder = getenv("PELLUCID_SHADERS"), .error = error };
    struct stat about;
    if (c.folder && (stat(c.folder, &about) != 0 || !S_ISDIR(about.st_mode))) {
        pel_fail(error, PEL_ERROR_ARGUMENT, "PELLUCID_SHADERS: there is no folder %.200s", c.folder);
        return NULL;
    }
    static const char version[] = "#version 450 core\n";
    if (append(&c, version, strlen(version)) && append(&c, defines, strlen(defines)) && add_file(&c, name, 0))
        return c.text;
    free(c.text);
    return NULL;
}

void pel_shader_name_lines(const char *message, char *to, size_t size)
{
    size_t used = 0;
    bool start = true; /* of a line, or after a word: where a number may be a file's */
    while (*message && used + 1 < size) {
        char *end;
        unsigned long number = start && isdigit((unsigned char)*message) ? strtoul(message, &end, 10) : 0;
        if (number > 0 && number <= pel_shader_file_count && (*end == ':' || *end == '(') && isdigit((unsigned char)end[1])) {
            int written = snprintf(to + used, size - used, "%s:", pel_shader_files[number - 1].name);
            used = written > 0 && (size_t)written < size - used ? used + (size_t)written : size - 1;
            message = end + 1;
            start = false;
            continue;
        }
        start = *message == '\n' || *message == ' ';
        to[used++] = *message++;
    }
    if (size)
        to[used] = 0;
}
