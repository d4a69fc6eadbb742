/* SPDX-License-Identifier: MIT */
/* Filling in a struct pel_error. Each returns false, so that a failing function can end with `return pel_fail(...)`. */
#ifndef PEL_BASE_FAIL_H
#define PEL_BASE_FAIL_H

#include <stdarg.h>

#include <pellucid/error.h>

/* Sets code and message. `error` may be NULL. */
bool pel_fail(struct pel_error *error, enum pel_error_code code, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Puts context in front of a message that is already there: "scan.nrrd: " + message. The code stays. */
bool pel_fail_in(struct pel_error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Sets code, and message + ": " + strerror(errno). */
bool pel_fail_errno(struct pel_error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Calls a progress callback; false (and PEL_ERROR_CANCELLED) where it asks to stop. */
bool pel_progress_report(const struct pel_progress *progress, double fraction, struct pel_error *error);

#endif
