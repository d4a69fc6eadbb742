/* SPDX-License-Identifier: MIT */
/* The page's files, as embed.py made them. */
#ifndef VIEWER_WEB_FILES_H
#define VIEWER_WEB_FILES_H

#include <stddef.h>

struct web_file {
    const char *name; /* NULL at the end */
    const unsigned char *bytes;
    size_t size;
};
extern const struct web_file web_files[];

#endif
