/* SPDX-License-Identifier: MIT */
/* Small text files: whole into memory, at most 16 MiB; and JSON out of them and into them. Messages name no path: callers put it in front
 * with pel_fail_in. */
#ifndef PEL_IO_JSON_FILE_H
#define PEL_IO_JSON_FILE_H

#include <stddef.h>

#include <jansson.h>

#include <pellucid/error.h>

/* The bytes of a file with a 0 behind them, to be freed; NULL on failure. */
char *pel_text_file_read(const char *path, size_t *size, struct pel_error *error);

/* A JSON object or array. Duplicate keys are refused. */
json_t *pel_json_parse(const char *text, size_t size, struct pel_error *error);

/* Writes through pel_safe_file. Numbers get as many digits as they need to be read back to the last bit and no more; arrays of numbers stay
 * on a line. */
bool pel_json_write(const char *path, const json_t *root, struct pel_error *error);

/* The same into memory, to be freed; NULL on failure. */
char *pel_json_to_text(const json_t *root, struct pel_error *error);

/* Reading of values; what is not there (NULL) is refused as well. */
bool pel_json_number(const json_t *value, double *out, struct pel_error *error);
bool pel_json_numbers(const json_t *value, size_t count, double *out, struct pel_error *error); /* an array of exactly `count` */
bool pel_json_bool(const json_t *value, bool *out, struct pel_error *error);
bool pel_json_text(const json_t *value, char *out, size_t size, struct pel_error *error); /* refuses what does not fit */

/* "an array", "a number", ...: what a value is, for messages. */
const char *pel_json_kind(const json_t *value);

#endif
