/* SPDX-License-Identifier: MIT */
/* Progress on a terminal, and interruption: Ctrl-C makes the running operation stop at its next report, so that it cleans up. */
#ifndef TOOL_PROGRESS_H
#define TOOL_PROGRESS_H

#include <pellucid/error.h>

struct progress {
    const char *label; /* "reading", "drawing" */
    bool enabled;      /* standard error is a terminal and nobody asked for quiet */
    bool shown;
    double started, printed; /* milliseconds */
    struct pel_progress also; /* is told, too, and may stop the work; update is NULL where nobody wants it */
    int part, parts;         /* of a work in several parts, each going from 0 to 1; parts is 1 for a whole one */
};

/* Ready for use; the struct must stay where it is while the callback is in use. */
void progress_init(struct progress *progress, bool quiet);
struct pel_progress progress_callback(struct progress *progress);

/* Begins a work. The bar appears once it has taken half a second; progress_end wipes it. */
void progress_begin(struct progress *progress, const char *label, int parts);
void progress_end(struct progress *progress);

/* Catches SIGINT, SIGTERM and SIGHUP. The first is noted, the second ends the program at once. */
void interruption_catch(void);
/* While on, the first signal ends the program too: for work that cannot report and has written nothing. */
void interruption_at_once(bool now);
/* The signal that came, or 0. */
int interruption(void);

#endif
