/* SPDX-License-Identifier: MIT */
#include "alloc.h"

#include <stdlib.h>
#include <string.h>

#include "fail.h"

void *pel_alloc(size_t count, size_t size, const char *what, struct pel_error *error)
{
    size_t bytes;
    if (!pel_mul(count, size, &bytes) || bytes > PTRDIFF_MAX) {
        pel_fail(error, PEL_ERROR_MEMORY, "%s: %zu times %zu bytes is more than can be addressed", what, count, size);
        return NULL;
    }
    void *memory = calloc(bytes ? bytes : 1, 1);
    if (!memory)
        pel_fail(error, PEL_ERROR_MEMORY, "%s: no memory for %zu bytes", what, bytes);
    return memory;
}

void *pel_alloc_aligned(size_t count, size_t size, const char *what, struct pel_error *error)
{
    size_t bytes, rounded;
    if (!pel_mul(count, size, &bytes) || !pel_add(bytes, 64, &rounded) || rounded > PTRDIFF_MAX) {
        pel_fail(error, PEL_ERROR_MEMORY, "%s: %zu times %zu bytes is more than can be addressed", what, count, size);
        return NULL;
    }
    void *memory = aligned_alloc(64, rounded & ~(size_t)63);
    if (!memory)
        pel_fail(error, PEL_ERROR_MEMORY, "%s: no memory for %zu bytes", what, bytes);
    return memory;
}

char *pel_strdup(const char *text, struct pel_error *error)
{
    size_t size = strlen(text) + 1;
    char *copy = pel_alloc(size, 1, "text", error);
    if (copy)
        memcpy(copy, text, size);
    return copy;
}
