/* SPDX-License-Identifier: MIT */
/* STL, binary (3D Systems, StereoLithography Interface Specification, 1989): little-endian floats, a normal a triangle, nothing shared. */
#include <string.h>

#include "fail.h"
#include "format.h"
#include "mesh_io.h"
#include "vec.h"

/* The triangle's own normal; of one without area, that of its first corner. */
static void facet_normal(const struct pel_mesh *mesh, const uint32_t corners[3], float normal[3])
{
    double sides[2][3], n[3];
    for (int s = 0; s < 2; s++)
        for (int i = 0; i < 3; i++)
            sides[s][i] = (double)mesh->positions[corners[s + 1]][i] - (double)mesh->positions[corners[0]][i];
    pel_cross(sides[0], sides[1], n);
    bool flat = pel_normalize(n) > 0;
    for (int i = 0; i < 3; i++)
        normal[i] = flat ? (float)n[i] : mesh->normals[corners[0]][i];
}

static size_t put_facet(const struct pel_mesh_out *out, size_t triangle, char *to)
{
    const uint32_t *corners = out->mesh->triangles[triangle];
    float numbers[4][3];
    facet_normal(out->mesh, corners, numbers[0]);
    for (int c = 0; c < 3; c++) {
        double world[3];
        pel_mesh_world(out->mesh, corners[c], world);
        for (int i = 0; i < 3; i++)
            numbers[1 + c][i] = (float)world[i];
    }
    memcpy(to, numbers, sizeof numbers);
    if (PEL_HOST_BIG_ENDIAN)
        pel_swap_bytes(to, 12, 4);
    memset(to + sizeof numbers, 0, 2); /* attribute bytes: none */
    return sizeof numbers + 2;
}

static bool write(struct pel_mesh_out *out, struct pel_error *error)
{
    char header[84] = "isosurface"; /* not "solid", by which text is known */
    if (out->mesh->triangle_count > UINT32_MAX)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%zu triangles are more than STL counts; write .ply or .vtp",
                        out->mesh->triangle_count);
    uint32_t count = (uint32_t)out->mesh->triangle_count;
    memcpy(header + 80, &count, sizeof count);
    if (PEL_HOST_BIG_ENDIAN)
        pel_swap_bytes(header + 80, 1, 4);
    out->share = 1;
    return pel_safe_file_write(&out->file, header, sizeof header, error) &&
           pel_mesh_write_records(out, out->mesh->triangle_count, put_facet, error);
}

const struct pel_mesh_format pel_mesh_format_stl = { ".stl", write };
