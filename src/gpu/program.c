/* SPDX-License-Identifier: MIT */
/* Programs, compiled or taken from the cache. The cache is a folder of files, each named by a hash of driver and text, with a checksum
 * before the binary; a file is written under another name and renamed, so that runs side by side see whole files or none. Whatever is wrong
 * with it, the program is compiled. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "alloc.h"
#include "fail.h"
#include "objects.h"
#include "shader_source.h"

struct cached {
    char magic[8];
    uint32_t format, length;
    uint64_t checksum; /* of the bytes that follow */
};
static const char cache_magic[8] = "PELPROG1";

static uint64_t hash(uint64_t h, const void *data, size_t size)
{
    const unsigned char *bytes = data; /* FNV-1a */
    for (size_t i = 0; i < size; i++)
        h = (h ^ bytes[i]) * 0x100000001b3u;
    return h;
}

#define HASH_START 0xcbf29ce484222325u

/* Path of the program's file in the cache, its folders made; false where there is no place for a cache. */
static bool cache_path(const char *text, char path[1024])
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int length;
    if (cache && cache[0] == '/')
        length = snprintf(path, 900, "%s/pellucid", cache);
    else if (home && home[0] == '/')
        length = snprintf(path, 900, "%s/.cache/pellucid", home);
    else
        return false;
    if (length >= 900)
        return false;
    for (char *slash = path; (slash = strchr(slash + 1, '/'));) {
        *slash = 0;
        mkdir(path, 0777);
        *slash = '/';
    }
    if (mkdir(path, 0777) && access(path, W_OK | X_OK))
        return false;
    static const GLenum names[] = { GL_VENDOR, GL_RENDERER, GL_VERSION };
    uint64_t h = hash(HASH_START, text, strlen(text) + 1);
    for (int i = 0; i < 3; i++) {
        const char *word = (const char *)glGetString(names[i]);
        h = hash(h, word ? word : "", word ? strlen(word) + 1 : 1);
    }
    snprintf(path + length, 64, "/%016llx.bin", (unsigned long long)h);
    return true;
}

static bool linked(GLuint program)
{
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    return ok;
}

static bool load_cached(GLuint program, const char *path)
{
    struct cached head;
    /* Whatever lies there, a pipe, say, must not make us wait. */
    struct stat about;
    int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    FILE *file = descriptor >= 0 && fstat(descriptor, &about) == 0 && S_ISREG(about.st_mode) ? fdopen(descriptor, "rb") : NULL;
    if (!file) {
        if (descriptor >= 0)
            close(descriptor);
        return false;
    }
    char *binary = NULL;
    bool ok = fread(&head, sizeof head, 1, file) == 1 && !memcmp(head.magic, cache_magic, sizeof head.magic) && head.length > 0 &&
              head.length <= (uint32_t)64 << 20;
    if (ok) {
        binary = malloc(head.length);
        ok = binary && fread(binary, 1, head.length, file) == head.length && fgetc(file) == EOF &&
             hash(HASH_START, binary, head.length) == head.checksum;
    }
    fclose(file);
    if (ok) {
        glProgramBinary(program, head.format, binary, (GLsizei)head.length);
        ok = glGetError() == GL_NO_ERROR && linked(program);
    }
    free(binary);
    return ok;
}

static void save_cached(GLuint program, const char *path)
{
    GLint length = 0, formats = 0;
    glGetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &formats);
    glGetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &length);
    char *binary = formats > 0 && length > 0 ? malloc((size_t)length) : NULL;
    if (!binary)
        return;
    GLenum format = 0;
    GLsizei got = 0;
    glGetProgramBinary(program, length, &got, &format, binary);
    char other[1100];
    snprintf(other, sizeof other, "%s.%ld", path, (long)getpid());
    FILE *file = got > 0 ? fopen(other, "wb") : NULL;
    if (file) {
        struct cached head = { .format = format, .length = (uint32_t)got, .checksum = hash(HASH_START, binary, (size_t)got) };
        memcpy(head.magic, cache_magic, sizeof head.magic);
        bool ok = fwrite(&head, sizeof head, 1, file) == 1 && fwrite(binary, 1, (size_t)got, file) == (size_t)got;
        ok &= fclose(file) == 0;
        if (!ok || rename(other, path))
            unlink(other);
    }
    free(binary);
}

/* The compiler's or linker's words, one line, file names in place of numbers. */
static void fail_with_log(GLuint object, bool is_program, const char *file, struct pel_error *error)
{
    char log[1024] = "", named[400];
    if (is_program)
        glGetProgramInfoLog(object, sizeof log, NULL, log);
    else
        glGetShaderInfoLog(object, sizeof log, NULL, log);
    pel_shader_name_lines(log, named, sizeof named);
    for (char *c = named; *c; c++)
        if (*c == '\n')
            *c = c[1] ? ' ' : 0;
    pel_fail(error, PEL_ERROR_UNSUPPORTED, "%s: the driver refuses the shader: %s", file, named);
}

/* A program's stages: one that computes, or one to three that draw. */
struct stages {
    int count;
    GLenum kinds[3];
    const char *files[3];
    char *texts[3]; /* owned */
};

static bool compose(struct stages *s, const char *defines, struct pel_error *error)
{
    for (int i = 0; i < s->count; i++)
        if (!(s->texts[i] = pel_shader_compose(s->files[i], defines, error)))
            return false;
    return true;
}

static GLuint compile(const struct stages *s, int i, struct pel_error *error)
{
    GLuint shader = glCreateShader(s->kinds[i]);
    GLint ok = 0;
    glShaderSource(shader, 1, (const char *const *)&s->texts[i], NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok)
        return shader;
    fail_with_log(shader, false, s->files[i], error);
    glDeleteShader(shader);
    return 0;
}

static bool build(GLuint program, const struct stages *s, struct pel_error *error)
{
    GLuint shaders[3] = { 0, 0, 0 };
    bool ok = true;
    glProgramParameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
    for (int i = 0; i < s->count && ok; i++) {
        shaders[i] = compile(s, i, error);
        ok = shaders[i] != 0;
        if (ok)
            glAttachShader(program, shaders[i]);
    }
    if (ok) {
        glLinkProgram(program);
        ok = linked(program);
        if (!ok)
            fail_with_log(program, true, s->files[s->count - 1], error);
    }
    for (int i = 0; i < s->count; i++) {
        if (shaders[i])
            glDetachShader(program, shaders[i]);
        glDeleteShader(shaders[i]);
    }
    return ok;
}

/* The cache knows a program by the texts of all its stages. */
static bool cached_path(const struct stages *s, char path[1024])
{
    size_t room = 1;
    for (int i = 0; i < s->count; i++)
        room += strlen(s->texts[i]);
    char *all = malloc(room);
    if (!all)
        return false;
    all[0] = 0;
    for (int i = 0, used = 0; i < s->count; i++)
        used += snprintf(all + used, room - (size_t)used, "%s", s->texts[i]);
    bool ok = cache_path(all, path);
    free(all);
    return ok;
}

static GLuint create(struct pel_device *device, struct stages *s, const char *defines, struct pel_error *error)
{
    char path[1024];
    GLuint program = 0;
    bool ok = compose(s, defines, error);
    if (ok) {
        program = glCreateProgram();
        bool cache = cached_path(s, path);
        ok = cache && load_cached(program, path);
        if (!ok) {
            ok = build(program, s, error);
            if (ok && cache)
                save_cached(program, path);
        }
    }
    for (int i = 0; i < s->count; i++)
        free(s->texts[i]);
    if (ok && pel_device_check(device, s->files[s->count - 1], error)) {
        device->objects++;
        return program;
    }
    glDeleteProgram(program);
    return 0;
}

GLuint pel_program_create(struct pel_device *device, const char *file, const char *defines, struct pel_error *error)
{
    struct stages s = { 1, { GL_COMPUTE_SHADER }, { file }, { NULL } };
    return create(device, &s, defines, error);
}

/* `geometry` and `fragment` may be NULL. */
static GLuint create_drawing(struct pel_device *device, const char *vertex, const char *geometry, const char *fragment, const char *defines,
                             struct pel_error *error)
{
    struct stages s = { 1, { GL_VERTEX_SHADER }, { vertex }, { NULL } };
    if (geometry) {
        s.kinds[s.count] = GL_GEOMETRY_SHADER;
        s.files[s.count++] = geometry;
    }
    if (fragment) {
        s.kinds[s.count] = GL_FRAGMENT_SHADER;
        s.files[s.count++] = fragment;
    }
    return create(device, &s, defines, error);
}

GLuint pel_program_create_drawing(struct pel_device *device, const char *vertex, const char *fragment, const char *defines,
                                  struct pel_error *error)
{
    return create_drawing(device, vertex, NULL, fragment, defines, error);
}

void pel_program_destroy(struct pel_device *device, GLuint program)
{
    if (!program)
        return;
    if (pel_device_is_current(device))
        glDeleteProgram(program);
    device->objects--;
}

static void forget(struct pel_device *device, struct pel_named_program *program)
{
    pel_program_destroy(device, program->name);
    free(program->key);
}

/* `vertex` NULL: one that computes, of the file `fragment`. */
static GLuint find(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *geometry, const char *fragment,
                   const char *defines, struct pel_error *error)
{
    char key[1024];
    if (snprintf(key, sizeof key, "%s\n%s\n%s\n%s", vertex ? vertex : "", geometry ? geometry : "", fragment ? fragment : "", defines) >=
        (int)sizeof key) {
        pel_fail(error, PEL_ERROR_ARGUMENT, "%s: too many defines", fragment ? fragment : vertex);
        return 0;
    }
    for (int i = 0; i < programs->count; i++)
        if (strcmp(programs->list[i].key, key) == 0)
            return programs->list[i].name;
    struct pel_named_program made = { pel_alloc(strlen(key) + 1, 1, "a program's name", error), 0 };
    if (made.key)
        made.name = vertex ? create_drawing(device, vertex, geometry, fragment, defines, error) :
                             pel_program_create(device, fragment, defines, error);
    if (!made.name) {
        free(made.key);
        return 0;
    }
    strcpy(made.key, key);
    if (programs->count == PEL_MAX_PROGRAMS) {
        forget(device, &programs->list[0]);
        memmove(programs->list, programs->list + 1, sizeof *programs->list * (size_t)--programs->count);
    }
    programs->list[programs->count++] = made;
    return made.name;
}

GLuint pel_programs_find(struct pel_device *device, struct pel_programs *programs, const char *file, const char *defines,
                         struct pel_error *error)
{
    return find(device, programs, NULL, NULL, file, defines, error);
}

GLuint pel_programs_find_drawing(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *fragment,
                                 const char *defines, struct pel_error *error)
{
    return find(device, programs, vertex, NULL, fragment, defines, error);
}

GLuint pel_programs_find_layered(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *geometry,
                                 const char *fragment, const char *defines, struct pel_error *error)
{
    return find(device, programs, vertex, geometry, fragment, defines, error);
}

void pel_programs_finish(struct pel_device *device, struct pel_programs *programs)
{
    for (int i = 0; i < programs->count; i++)
        forget(device, &programs->list[i]);
    programs->count = 0;
}
