/* SPDX-License-Identifier: MIT */
/* ParaView's colour maps from memory: what pel_read_transfer does once it has the file's bytes. */
#ifndef PEL_IO_COLORMAP_FILE_H
#define PEL_IO_COLORMAP_FILE_H

#include <stddef.h>

#include <pellucid/transfer.h>

/* `text` ends with a 0 behind its `size` bytes. Messages name no path. See pel_read_transfer for the rest. */
bool pel_colormap_parse(const char *text, size_t size, const char *name, double lo, double hi, struct pel_transfer *transfer,
                        struct pel_error *error);

#endif
