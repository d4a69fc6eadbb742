/* SPDX-License-Identifier: MIT */
/* Writes the composed text of a shader: compose FILE [DEFINES], where DEFINES are words with spaces between them; `compose` alone lists the
 * files. For check_shaders.py. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shader_source.h"

int main(int argc, char **argv)
{
    if (argc < 2) {
        for (size_t i = 0; i < pel_shader_file_count; i++)
            puts(pel_shader_files[i].name);
        return 0;
    }
    char defines[1024] = "";
    for (char *word = strtok(argc > 2 ? argv[2] : (char[]){ "" }, " "); word; word = strtok(NULL, " ")) {
        char *equals = strchr(word, '=');
        size_t used = strlen(defines);
        if (equals)
            *equals = ' ';
        snprintf(defines + used, sizeof defines - used, "#define %s\n", word);
    }
    struct pel_error error = PEL_ERROR_INIT;
    char *text = pel_shader_compose(argv[1], defines, &error);
    if (!text) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    fputs(text, stdout);
    free(text);
    return 0;
}
