/* SPDX-License-Identifier: MIT */
/* Wavefront OBJ: text; a group a surface. Vertices and normals go in pairs, counted from 1. */
#include "mesh_io.h"

static size_t put_position(const struct pel_mesh_out *out, size_t vertex, char *to)
{
    double p[3];
    pel_mesh_world(out->mesh, vertex, p);
    int digits = out->wide ? 16 : 9;
    return (size_t)sprintf(to, "v %.*g %.*g %.*g\n", digits, p[0], digits, p[1], digits, p[2]);
}

static size_t put_normal(const struct pel_mesh_out *out, size_t vertex, char *to)
{
    const float *n = out->mesh->normals[vertex];
    return (size_t)sprintf(to, "vn %.6g %.6g %.6g\n", (double)n[0], (double)n[1], (double)n[2]);
}

static size_t put_face(const struct pel_mesh_out *out, size_t triangle, char *to)
{
    const struct pel_mesh *mesh = out->mesh;
    const uint32_t *t = mesh->triangles[triangle];
    size_t size = 0, a = (size_t)t[0] + 1, b = (size_t)t[1] + 1, c = (size_t)t[2] + 1;
    const struct pel_mesh_part *part = pel_mesh_part_of(mesh, t[0]);
    if (triangle == part->first_triangle)
        size = (size_t)sprintf(to, "g isovalue_%.9g\n", part->isovalue);
    return size + (size_t)sprintf(to + size, "f %zu//%zu %zu//%zu %zu//%zu\n", a, a, b, b, c, c);
}

static bool write(struct pel_mesh_out *out, struct pel_error *error)
{
    const struct pel_mesh *mesh = out->mesh;
    out->share = 1.0 / 3;
    return pel_mesh_write_records(out, mesh->vertex_count, put_position, error) &&
           pel_mesh_write_records(out, mesh->vertex_count, put_normal, error) &&
           pel_mesh_write_records(out, mesh->triangle_count, put_face, error);
}

const struct pel_mesh_format pel_mesh_format_obj = { ".obj", write };
