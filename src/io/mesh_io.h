/* SPDX-License-Identifier: MIT */
/* Mesh formats: one file each, a descriptor in the table of mesh_file.c. Numbers are written in this machine's byte order where a format
 * can say which that is. Messages name no path; mesh_file.c puts it in front. */
#ifndef PEL_IO_MESH_IO_H
#define PEL_IO_MESH_IO_H

#include <pellucid/mesh.h>

#include "safe_file.h"

/* What a writer has to work with. */
struct pel_mesh_out {
    struct pel_safe_file file;
    const struct pel_mesh *mesh;
    const struct pel_progress *progress;
    double fraction, share; /* of the file that is written; of it that each step makes up */
    bool wide; /* so far from the world's zero that floats would be coarse there: positions are written as doubles where a format can */
};

struct pel_mesh_format {
    const char *endings; /* ".ply" */
    bool (*write)(struct pel_mesh_out *out, struct pel_error *error);
};

extern const struct pel_mesh_format pel_mesh_format_ply, pel_mesh_format_stl, pel_mesh_format_obj, pel_mesh_format_vtp;

/* Calls `one` for each number below `count`; it puts up to 256 bytes into `to` and returns how many. They are written in pieces, between
 * which progress is told. */
typedef size_t pel_mesh_record(const struct pel_mesh_out *out, size_t number, char *to);
bool pel_mesh_write_records(struct pel_mesh_out *out, size_t count, pel_mesh_record *one, struct pel_error *error);

/* A vertex in the world. */
void pel_mesh_world(const struct pel_mesh *mesh, size_t vertex, double world[3]);
/* The same as bytes: three floats, or three doubles where the mesh is far away; returns how many bytes. */
size_t pel_mesh_put_position(const struct pel_mesh_out *out, size_t vertex, char *to);

/* The part that a vertex belongs to. */
const struct pel_mesh_part *pel_mesh_part_of(const struct pel_mesh *mesh, size_t vertex);

#endif
