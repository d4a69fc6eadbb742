/* SPDX-License-Identifier: MIT */
/* VTK XML ImageData: what the XML part of a file says (vti_scan.c) for the part that reads samples (vti.c) and the one that writes
 * (vti_write.c). */
#ifndef PEL_IO_VTI_H
#define PEL_IO_VTI_H

#include "format.h"

/* What a volume has and ImageData has not is kept in FieldData, in arrays of these names. */
#define PEL_VTI_UNITS "pellucid_units"
#define PEL_VTI_SPACE "pellucid_space"
#define PEL_VTI_VOID "pellucid_void"
#define PEL_VTI_LABELS "pellucid_labels"

struct pel_vti_array {
    char name[128];
    int type; /* enum pel_type or pel_file_type */
    int components;
    bool cells; /* of the cells, not of the points */
    int rank;   /* the highest is read where nobody chose */
    enum { PEL_VTI_ASCII, PEL_VTI_BINARY, PEL_VTI_APPENDED } format;
    uint64_t offset; /* ASCII and BINARY: in the (unpacked) file, of the first number; APPENDED: from the beginning of the appended data */
};

struct pel_vti_header {
    long long extent[6];                        /* of the piece: first and last index along x, y, z */
    double origin[3], spacing[3], direction[9]; /* of index 0, 0, 0; direction: rows of a matrix whose columns are the axes */
    bool big_endian, compressed;
    int word;          /* bytes of a number in a block header: 4 or 8 */
    bool base64;       /* appended data are in base64, else raw */
    uint64_t appended; /* place in the (unpacked) file behind the tag AppendedData; 0: there is none */
    struct pel_vti_array arrays[PEL_MAX_ARRAYS];
    int array_count;
    char units[16], space[16]; /* from FieldData */
    bool has_void, labels;
    double void_value;
};

/* Reads the XML part. `header` must be zeroed. Succeeds only where extents make sense and there is at least one array. */
bool pel_vti_scan(const char *path, struct pel_vti_header *header, struct pel_file_info *info, struct pel_error *error);

/* Samples along an axis of an array. */
uint64_t pel_vti_dim(const struct pel_vti_header *header, bool cells, int axis);

bool pel_vti_write(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error);

#endif
