/* SPDX-License-Identifier: MIT */
/* Errors, notes, time and JSON: what every command uses. See tool.h. */
#include "tool.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

bool tool_fail(struct pel_error *error, enum pel_error_code code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(error->message, sizeof error->message, format, args);
    va_end(args);
    error->code = code;
    return false;
}

bool tool_fail_in(struct pel_error *error, const char *prefix)
{
    size_t length = strlen(prefix);
    if (strncmp(error->message, prefix, length) == 0 && error->message[length] == ':')
        return false;
    char old[sizeof error->message];
    memcpy(old, error->message, sizeof old);
    /* A long path keeps its end, so that there is room for what is wrong. */
    if (length > 200)
        snprintf(error->message, sizeof error->message, "...%s: %.300s", prefix + length - 197, old);
    else
        snprintf(error->message, sizeof error->message, "%s: %.300s", prefix, old);
    return false;
}

/* File names and file contents may hold anything: control characters must neither break the line nor reach the terminal. */
static void print_line(const char *head, const char *text)
{
    fputs(head, stderr);
    for (const char *c = text; *c; c++)
        fputc((unsigned char)*c < 32 || *c == 127 ? '?' : *c, stderr);
    fputc('\n', stderr);
}

int tool_report(const struct pel_error *error)
{
    print_line("pellucid: ", error->message[0] ? error->message : "failed");
    switch (error->code) {
    case PEL_ERROR_ARGUMENT:
        return EXIT_USAGE;
    case PEL_ERROR_CANCELLED:
        return EXIT_INTERRUPTED;
    default:
        return EXIT_FAILED;
    }
}

void tool_note(const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    print_line("pellucid: note: ", text);
}

int tool_finish_stdout(int status)
{
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout))
        return status;
    if (status != EXIT_FINE) /* one error is told, the first */
        return status;
    struct pel_error error = PEL_ERROR_INIT;
    tool_fail(&error, PEL_ERROR_IO, "standard output: %s", errno ? strerror(errno) : "cannot write");
    return tool_report(&error);
}

double tool_milliseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* Edit distance (Levenshtein, with a swap of neighbours counting once) of words up to 63 letters. */
static int edit_distance(const char *a, const char *b)
{
    enum { MOST = 64 };
    size_t n = strlen(a), m = strlen(b);
    if (n >= MOST || m >= MOST)
        return MOST;
    int rows[MOST][MOST];
    for (size_t i = 0; i <= n; i++)
        for (size_t j = 0; j <= m; j++) {
            if (i == 0 || j == 0) {
                rows[i][j] = (int)(i + j);
                continue;
            }
            int best = rows[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            if (rows[i - 1][j] + 1 < best)
                best = rows[i - 1][j] + 1;
            if (rows[i][j - 1] + 1 < best)
                best = rows[i][j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && rows[i - 2][j - 2] + 1 < best)
                best = rows[i - 2][j - 2] + 1;
            rows[i][j] = best;
        }
    return rows[n][m];
}

const char *tool_nearest(const char *word, const char *(*next)(const void *user, size_t index), const void *user)
{
    const char *nearest = NULL, *known;
    int limit = 1 + (int)(strlen(word) / 4), least = limit + 1;
    for (size_t i = 0; (known = next(user, i)); i++) {
        int distance = edit_distance(word, known);
        if (distance < least) {
            least = distance;
            nearest = known;
        }
    }
    return nearest;
}

json_t *json_number(double value)
{
    if (isnan(value))
        return json_null();
    if (isinf(value))
        return json_real(value > 0 ? DBL_MAX : -DBL_MAX);
    return json_real(value);
}

json_t *json_numbers(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_number(values[i]));
    return list;
}

json_t *json_text(const char *text)
{
    json_t *json = json_string(text);
    if (json)
        return json;
    char *wide = malloc(2 * strlen(text) + 1), *to = wide;
    if (!wide)
        return NULL;
    for (const unsigned char *from = (const unsigned char *)text; *from; from++) {
        if (*from >= 0x80)
            *to++ = (char)(0xc0 | *from >> 6);
        *to++ = (char)(*from >= 0x80 ? 0x80 | (*from & 0x3f) : *from);
    }
    *to = 0;
    json = json_string(wide);
    free(wide);
    return json;
}

bool json_print(json_t *json, FILE *stream)
{
    /* Encoding first: a failure must not leave half an object behind. */
    char *text = json ? json_dumps(json, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(json);
    if (!text)
        return false;
    fputs(text, stream);
    fputc('\n', stream);
    free(text);
    return true;
}
