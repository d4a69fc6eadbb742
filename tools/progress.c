/* SPDX-License-Identifier: MIT */
/* A bar on standard error where that is a terminal and the work takes more than half a second; see progress.h. */
#include "progress.h"

#include <signal.h>
#include <stdio.h>
#include <unistd.h>

#include "tool.h"

enum { BAR = 40, QUIET_MS = 500, REPAINT_MS = 100 };

static volatile sig_atomic_t caught, at_once;

static void on_signal(int number)
{
    static const char line[] = "pellucid: interrupted\n";
    caught = number;
    if (at_once)
        _exit(write(STDERR_FILENO, line, sizeof line - 1) ? EXIT_INTERRUPTED : EXIT_FAILED);
}

void interruption_at_once(bool now)
{
    at_once = now;
}

void interruption_catch(void)
{
    static const int numbers[] = { SIGINT, SIGTERM, SIGHUP };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        struct sigaction action = { 0 }, old;
        /* What the parent ignores (nohup, a background job) stays ignored. */
        if (sigaction(numbers[i], NULL, &old) == 0 && old.sa_handler == SIG_IGN)
            continue;
        action.sa_handler = on_signal;
        action.sa_flags = SA_RESETHAND; /* and no restart: what waits for a pipe or a far disk ends */
        sigaction(numbers[i], &action, NULL);
    }
}

int interruption(void)
{
    return caught;
}

void progress_init(struct progress *progress, bool quiet)
{
    *progress = (struct progress) { .label = "", .enabled = !quiet && isatty(STDERR_FILENO), .parts = 1 };
}

void progress_begin(struct progress *progress, const char *label, int parts)
{
    progress->label = label;
    progress->started = tool_milliseconds();
    progress->printed = 0;
    progress->shown = false;
    progress->part = 0;
    progress->parts = parts > 0 ? parts : 1;
}

void progress_end(struct progress *progress)
{
    if (progress->shown)
        fputs("\r\033[K", stderr);
    progress->shown = false;
}

static bool update(void *user, double fraction)
{
    struct progress *progress = user;
    if (caught || (progress->also.update && !progress->also.update(progress->also.user, fraction)))
        return false;
    if (!progress->enabled)
        return true;
    double now = tool_milliseconds();
    if (now - progress->started < QUIET_MS || now - progress->printed < REPAINT_MS)
        return true;
    double whole = (progress->part + fraction) / progress->parts;
    whole = whole > 0 ? whole < 1 ? whole : 1 : 0;
    char bar[BAR + 1];
    for (int i = 0; i < BAR; i++)
        bar[i] = i < whole * BAR ? '#' : '.';
    bar[BAR] = 0;
    fprintf(stderr, "\r%s [%s] %3.0f%%\033[K", progress->label, bar, 100 * whole);
    fflush(stderr);
    progress->shown = true;
    progress->printed = now;
    return true;
}

struct pel_progress progress_callback(struct progress *progress)
{
    return (struct pel_progress) { update, progress };
}
