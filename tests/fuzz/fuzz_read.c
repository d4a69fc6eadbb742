/* SPDX-License-Identifier: MIT */
/* libFuzzer target for every volume reader; built once a format with PEL_FUZZ_FORMAT naming its descriptor. The input is a file in memory,
 * so detached data that it names are looked for in /proc/self/fd, where there are none but the input itself. Where PEL_FUZZ_LAYOUT is defined
 * the first line of the input is the layout of raw samples, which --raw says, and the file is what follows. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "format.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void read_it(const char *path, const char *layout)
{
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    params.raw = layout;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    static struct pel_file_info info;
    memset(&info, 0, sizeof info);
    pel_volume_init(&volume);
    bool ok = PEL_FUZZ_FORMAT.read(path, &params, &volume, &info, &error) && pel_volume_check(&volume, &error);
    if (ok) {
        /* What a caller does next with any volume: every sample is looked at. */
        pel_volume_update_range(&volume);
        pel_volume_detect_labels(&volume);
    } else if (error.code == PEL_ERROR_NONE || !error.message[0] || strchr(error.message, '\n')) {
        fprintf(stderr, "a failure without one line that says why: \"%s\"\n", error.message);
        abort();
    }
    pel_volume_finish(&volume);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char path[64];
#ifdef PEL_FUZZ_LAYOUT
    char layout[128];
    const uint8_t *end = memchr(bytes, '\n', size);
    size_t length = end ? (size_t)(end - bytes) : size;
    if (length >= sizeof layout || memchr(bytes, 0, length))
        return 0;
    memcpy(layout, bytes, length);
    layout[length] = 0;
    bytes += end ? length + 1 : length;
    size -= end ? length + 1 : length;
#endif
    int fd = memfd_create("input", 0);
    if (fd < 0)
        return 0;
    for (size_t done = 0; done < size;) {
        ssize_t n = write(fd, bytes + done, size - done);
        if (n <= 0)
            abort();
        done += (size_t)n;
    }
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
#ifdef PEL_FUZZ_LAYOUT
    read_it(path, layout);
#else
    read_it(path, NULL);
#endif
    close(fd);
    return 0;
}
