/* SPDX-License-Identifier: MIT */
/* Sizes that cannot overflow, and allocation that says why it failed. Everything is freed with free(). */
#ifndef PEL_BASE_ALLOC_H
#define PEL_BASE_ALLOC_H

#include <stddef.h>
#include <stdint.h>

#include <pellucid/error.h>

/* a * b and a + b; false on overflow, and *result is left alone. */
static inline bool pel_mul(size_t a, size_t b, size_t *result)
{
    size_t r;
    if (__builtin_mul_overflow(a, b, &r))
        return false;
    *result = r;
    return true;
}

static inline bool pel_add(size_t a, size_t b, size_t *result)
{
    size_t r;
    if (__builtin_add_overflow(a, b, &r))
        return false;
    *result = r;
    return true;
}

/* Zeroed memory for count * size bytes (never NULL for 0 bytes); NULL and PEL_ERROR_MEMORY, naming `what`, on overflow or want. */
void *pel_alloc(size_t count, size_t size, const char *what, struct pel_error *error);

/* The same, not zeroed, aligned to 64 bytes: for large arrays that are about to be filled. */
void *pel_alloc_aligned(size_t count, size_t size, const char *what, struct pel_error *error);

/* Copy of a string. */
char *pel_strdup(const char *text, struct pel_error *error);

#endif
