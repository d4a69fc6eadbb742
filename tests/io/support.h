/* SPDX-License-Identifier: MIT */
/* What the tests of formats share: real data, scratch files, volumes to write, and what every damaged file must meet with. */
#ifndef PEL_TESTS_IO_SUPPORT_H
#define PEL_TESTS_IO_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <pellucid/io.h>
#include <pellucid/statistics.h>

/* Path of a file of the real data; skips the test, loudly, where the folder is missing. Good until the next call. */
const char *data_path(const char *name);

/* Group set-up and tear-down: a scratch folder. scratch() is a path in it, good until the fourth call after it. */
int make_scratch(void **state);
int remove_scratch(void **state);
const char *scratch(const char *name);

void write_file(const char *path, const void *bytes, size_t size);
void write_text(const char *path, const char *text);
void write_gzip(const char *path, const void *bytes, size_t size);
unsigned char *read_file(const char *path, size_t *size); /* free it */

/* All that is known of a volume and its placement, in lines: the golden text of a file. */
void describe(const struct pel_volume *volume, const struct pel_file_info *info, char *text, size_t size);

/* Reads with everything at its default; fails the test with the reader's message. */
void read_ok(const char *path, struct pel_volume *volume, struct pel_file_info *info);
void expect_description(const char *path, const char *golden);

/* Reading must fail, with one line that begins with the path, an empty volume, and without memory for what the header claims. Returns the
 * message, good until the next call. */
const char *read_bad(const char *path, const char *raw);
void expect_bad(const char *path, const char *part_of_message);

/* Cuts a file at many lengths; every cut below `whole` bytes must fail as read_bad says. */
void expect_truncations_fail(const char *path, const char *cut_path, size_t whole);

/* A small volume of a type with every byte of it telling, in a sheared, unequal placement. */
void fill_volume(struct pel_volume *volume, enum pel_type type, int components);
void expect_same(const struct pel_volume *a, const struct pel_volume *b);

/* Writes every type with 1 and 3 components to scratch(name), plain and compressed, and reads the same back to the last bit. */
void expect_round_trips(const char *name, enum pel_space space);

#endif
