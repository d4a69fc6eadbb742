/* SPDX-License-Identifier: MIT */
/* Parallel for: the one door to threads (OpenMP). Work is cut into items whose results do not depend on who computes them or in which
 * order, so any thread count gives the same bytes. */
#ifndef PEL_BASE_PARALLEL_H
#define PEL_BASE_PARALLEL_H

#include <stddef.h>

/* Threads that `threads` asks for: itself if > 0, else what the machine or OMP_NUM_THREADS says. At least 1. */
int pel_threads(int threads);

/* Calls body(context, item, thread) for each item in 0..count-1, items handed out one by one to idle threads. `thread` is 0..threads-1 and
 * no two calls with one number run at the same time. */
void pel_parallel_for(int threads, size_t count, void (*body)(void *context, size_t item, int thread), void *context);

#endif
