/* SPDX-License-Identifier: MIT */
/* libFuzzer target for the picture reader (PNG and float NRRD). */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <pellucid/io.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char path[64];
    struct pel_image image;
    struct pel_error error = PEL_ERROR_INIT;
    int fd = memfd_create("input", 0);
    if (fd < 0)
        return 0;
    if (write(fd, bytes, size) != (ssize_t)size)
        abort();
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    pel_image_init(&image);
    if (!pel_read_image(path, &image, &error) && (error.code == PEL_ERROR_NONE || strchr(error.message, '\n')))
        abort();
    pel_image_finish(&image);
    close(fd);
    return 0;
}
