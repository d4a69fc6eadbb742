/* SPDX-License-Identifier: MIT */
/* Shader files, embedded at build time, and how a program's text is composed of them. Needs no GPU. */
#ifndef PEL_SHADERS_SHADER_SOURCE_H
#define PEL_SHADERS_SHADER_SOURCE_H

#include <stddef.h>

#include <pellucid/error.h>

/* The embedded files, a generated list (embed.py); a file's place in it is its number in #line and so in compilers' messages. */
struct pel_shader_file {
    const char *name, *text;
};
extern const struct pel_shader_file pel_shader_files[];
extern const size_t pel_shader_file_count;

/* The whole text of a program whose root is the file `name`: "#version", the lines of `defines` ("#define SHADE\n", may be empty), then the
 * file with each
 * `#include "other.glsl"` replaced by that file, each file once. Where the environment names a folder in PELLUCID_SHADERS, files that are
 * there replace the embedded ones. NULL and an error that names file and line where a file is missing. The text is the caller's to free. */
char *pel_shader_compose(const char *name, const char *defines, struct pel_error *error);

/* A compiler's message with file names in place of the numbers that #line gave: "composite.glsl:12" for "3:12" and "3(12)". Writes at most
 * `size` bytes, terminated. */
void pel_shader_name_lines(const char *message, char *to, size_t size);

#endif
