/* SPDX-License-Identifier: MIT */
#include "grid.h"

#include <math.h>
#include <unistd.h>

#include "fail.h"
#include "parallel.h"

struct fill_pass {
    struct pel_volume *volume;
    double centre, half;
    pel_dataset_sample *sample;
    const void *context;
};

static double position_of(const struct fill_pass *pass, size_t i)
{
    double last = (double)(pass->volume->dims[0] - 1);
    return pass->centre + (2 * (double)i - last) / last * pass->half;
}

static void fill_slice(void *context, size_t z, int thread)
{
    (void)thread;
    const struct fill_pass *pass = context;
    size_t n = pass->volume->dims[0], components = (size_t)pass->volume->components;
    float *out = (float *)pass->volume->data + z * n * n * components;
    for (size_t y = 0; y < n; y++)
        for (size_t x = 0; x < n; x++, out += components) {
            const double position[3] = { position_of(pass, x), position_of(pass, y), position_of(pass, z) };
            pass->sample(pass->context, position, out);
        }
}

bool pel_dataset_fill(struct pel_volume *volume, int size, int components, double centre, double half, pel_dataset_sample *sample,
                      const void *context, struct pel_error *error)
{
    if (size < 2 || size > PEL_DATASET_SIZE_MAX)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "size: %d is not a whole number from 2 to %d samples", size, PEL_DATASET_SIZE_MAX);
    if (!(half > 0) || !isfinite(half) || !isfinite(centre))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "the extent of the data set is not a positive number");
    /* Every page will be touched: what the machine cannot hold is refused now, before the system starts to end programs. */
    double bytes = (double)size * size * size * components * sizeof(float);
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    if (pages > 0 && page > 0 && bytes > (double)pages * (double)page)
        return pel_fail(error, PEL_ERROR_MEMORY, "%d^3 samples take %.1f GB, which this machine does not have; give a smaller size", size,
                        bytes * 1e-9);
    const size_t dims[3] = { (size_t)size, (size_t)size, (size_t)size };
    if (!pel_volume_allocate(volume, dims, PEL_F32, components, error))
        return false;
    for (int a = 0; a < 3; a++) {
        volume->origin[a] = centre - half;
        volume->spacing[a] = 2 * half / (size - 1);
    }
    struct fill_pass pass = { volume, centre, half, sample, context };
    pel_parallel_for(0, dims[2], fill_slice, &pass);
    return true;
}
