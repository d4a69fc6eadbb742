/* SPDX-License-Identifier: MIT */
/* PLY (Turk, The PLY Polygon File Format, 1994), binary: vertices with normals, and where there are several surfaces the isovalue of each.
 */
#include <string.h>

#include "format.h"
#include "mesh_io.h"

static size_t put_vertex(const struct pel_mesh_out *out, size_t vertex, char *to)
{
    size_t size = pel_mesh_put_position(out, vertex, to);
    memcpy(to + size, out->mesh->normals[vertex], sizeof *out->mesh->normals);
    size += sizeof *out->mesh->normals;
    if (out->mesh->part_count > 1) {
        double isovalue = pel_mesh_part_of(out->mesh, vertex)->isovalue;
        memcpy(to + size, &isovalue, sizeof isovalue);
        size += sizeof isovalue;
    }
    return size;
}

static size_t put_face(const struct pel_mesh_out *out, size_t triangle, char *to)
{
    to[0] = 3;
    memcpy(to + 1, out->mesh->triangles[triangle], sizeof *out->mesh->triangles);
    return 1 + sizeof *out->mesh->triangles;
}

static bool write(struct pel_mesh_out *out, struct pel_error *error)
{
    const struct pel_mesh *mesh = out->mesh;
    FILE *file = out->file.file;
    const char *real = out->wide ? "double" : "float";
    fprintf(file, "ply\nformat binary_%s_endian 1.0\n", PEL_HOST_BIG_ENDIAN ? "big" : "little");
    for (int i = 0; i < mesh->part_count; i++)
        fprintf(file, "comment isovalue %.17g\n", mesh->parts[i].isovalue);
    if (mesh->space != PEL_SPACE_UNKNOWN)
        fprintf(file, "comment axes %s\n", pel_space_name(mesh->space));
    if (strcmp(mesh->units, "mm") == 0) /* any other text may hold what a header must not */
        fputs("comment units mm\n", file);
    fprintf(file, "element vertex %zu\nproperty %s x\nproperty %s y\nproperty %s z\n", mesh->vertex_count, real, real, real);
    fputs("property float nx\nproperty float ny\nproperty float nz\n", file);
    if (mesh->part_count > 1)
        fputs("property double isovalue\n", file);
    /* Some readers know signed indices alone. */
    fprintf(file, "element face %zu\nproperty list uchar %s vertex_indices\nend_header\n", mesh->triangle_count,
            mesh->vertex_count <= INT32_MAX ? "int" : "uint");
    out->share = 0.5;
    return pel_mesh_write_records(out, mesh->vertex_count, put_vertex, error) &&
           pel_mesh_write_records(out, mesh->triangle_count, put_face, error);
}

const struct pel_mesh_format pel_mesh_format_ply = { ".ply", write };
