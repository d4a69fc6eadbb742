/* SPDX-License-Identifier: MIT */
#include "fail.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* Messages quote names out of files, which may hold anything. A message stays one line that a terminal can show. */
static void one_line(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < 0x20 || *text == 0x7f)
            *text = '?';
}

bool pel_fail(struct pel_error *error, enum pel_error_code code, const char *format, ...)
{
    if (!error)
        return false;
    va_list args;
    va_start(args, format);
    vsnprintf(error->message, sizeof error->message, format, args);
    va_end(args);
    one_line(error->message);
    error->code = code;
    return false;
}

bool pel_fail_in(struct pel_error *error, const char *format, ...)
{
    if (!error)
        return false;
    char old[sizeof error->message];
    memcpy(old, error->message, sizeof old);
    va_list args;
    va_start(args, format);
    int used = vsnprintf(error->message, sizeof error->message, format, args);
    va_end(args);
    if (used >= 0 && (size_t)used < sizeof error->message)
        snprintf(error->message + used, sizeof error->message - (size_t)used, "%s", old);
    one_line(error->message);
    return false;
}

bool pel_fail_errno(struct pel_error *error, const char *format, ...)
{
    int saved = errno;
    if (!error)
        return false;
    va_list args;
    va_start(args, format);
    int used = vsnprintf(error->message, sizeof error->message, format, args);
    va_end(args);
    if (used >= 0 && (size_t)used < sizeof error->message)
        snprintf(error->message + used, sizeof error->message - (size_t)used, ": %s", strerror(saved));
    one_line(error->message);
    error->code = saved == ENOMEM ? PEL_ERROR_MEMORY : PEL_ERROR_IO;
    return false;
}

bool pel_progress_report(const struct pel_progress *progress, double fraction, struct pel_error *error)
{
    if (!progress || !progress->update || progress->update(progress->user, fraction))
        return true;
    return pel_fail(error, PEL_ERROR_CANCELLED, "cancelled");
}
