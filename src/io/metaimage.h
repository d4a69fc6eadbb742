/* SPDX-License-Identifier: MIT */
/* MetaImage headers (.mha, .mhd): lines of "Key = Value", the last of which says where the samples are. */
#ifndef PEL_IO_METAIMAGE_H
#define PEL_IO_METAIMAGE_H

#include "sample_layout.h"

#define PEL_METAIMAGE_MAX_FILES 65536

struct pel_metaimage {
    int dims; /* axes, 1 to 7 */
    uint64_t sizes[8];
    double spacing[8], offset[8], matrix[64];
    bool has_spacing, has_element_size, has_matrix;
    double element_size[8];
    uint64_t channels;
    int type; /* enum pel_type or pel_file_type, -1: not said */
    bool binary, big_endian, compressed;
    uint64_t compressed_size; /* 0: not said */
    long long header_size;    /* bytes before the samples in the data file; -1: the samples are its last bytes */
    char orientation[16];     /* "RAI", "???", or "" */
    char units[16], name[128];
    bool has_void;
    double void_value;
    bool local;       /* samples follow the header */
    char **files;     /* owned */
    size_t file_count;
};

/* Reads the header from the beginning of a stream, up to the byte behind the line ElementDataFile (or the list of names below it). */
bool pel_metaimage_read_header(struct pel_stream *stream, struct pel_metaimage *head, struct pel_error *error);
void pel_metaimage_finish(struct pel_metaimage *head); /* accepts a zeroed one */

bool pel_write_metaimage(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error);

#endif
