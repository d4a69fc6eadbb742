/* SPDX-License-Identifier: MIT */
#include "parallel.h"

#include <omp.h>

int pel_threads(int threads)
{
    if (threads <= 0)
        threads = omp_get_max_threads();
    return threads < 1 ? 1 : threads > 1024 ? 1024 : threads;
}

void pel_parallel_for(int threads, size_t count, void (*body)(void *context, size_t item, int thread), void *context)
{
    threads = pel_threads(threads);
    if ((size_t)threads > count)
        threads = count ? (int)count : 1;
    if (threads == 1) {
        for (size_t i = 0; i < count; i++)
            body(context, i, 0);
        return;
    }
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t i = 0; i < count; i++)
        body(context, i, omp_get_thread_num());
}
