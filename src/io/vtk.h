/* SPDX-License-Identifier: MIT */
/* A legacy VTK file: what its text says (vtk_scan.c) for the part that reads samples (vtk.c). */
#ifndef PEL_IO_VTK_H
#define PEL_IO_VTK_H

#include "format.h"
#include "text.h"

enum pel_vtk_kind { PEL_VTK_SCALARS, PEL_VTK_VECTORS, PEL_VTK_OTHER };

struct pel_vtk_array {
    char name[128];
    int type;  /* enum pel_type or pel_file_type */
    bool bits; /* type u8, but stored as one bit a number, highest first, if the file is binary */
    bool unit; /* type u8, but text has colours from 0 to 1 (COLOR_SCALARS in ASCII) */
    enum pel_vtk_kind kind;
    int components;
    bool cells;      /* of the cells, not of the points */
    uint64_t offset; /* of the first number in the (unpacked) file */
};

struct pel_vtk_header {
    struct pel_text *text;
    struct pel_error *error;
    struct pel_file_info *info;
    bool binary;
    uint64_t dims[3]; /* of points; 0 until DIMENSIONS was met */
    double origin[3], spacing[3];
    enum pel_vtk_section { PEL_VTK_NOWHERE, PEL_VTK_POINTS, PEL_VTK_CELLS } section;
    uint64_t tuples; /* samples that each array of the section has; 0 before the first section */
    struct pel_vtk_array arrays[PEL_MAX_ARRAYS];
    int array_count;
};

/* Walks the whole file and lists the arrays of samples in it; the text stands at the file's beginning. */
bool pel_vtk_scan(struct pel_vtk_header *header);

/* Bytes that `count` numbers take in a binary file; false on overflow. */
bool pel_vtk_stored_bytes(const struct pel_vtk_array *array, uint64_t count, uint64_t *bytes);

#endif
