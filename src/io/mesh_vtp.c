/* SPDX-License-Identifier: MIT */
/* VTK XML PolyData (.vtp): appended raw arrays, each behind its number of bytes. */
#include <inttypes.h>
#include <string.h>

#include "fail.h"
#include "format.h"
#include "mesh_io.h"

static size_t put_normal(const struct pel_mesh_out *out, size_t vertex, char *to)
{
    memcpy(to, out->mesh->normals[vertex], sizeof *out->mesh->normals);
    return sizeof *out->mesh->normals;
}

static size_t put_isovalue(const struct pel_mesh_out *out, size_t vertex, char *to)
{
    double isovalue = pel_mesh_part_of(out->mesh, vertex)->isovalue;
    memcpy(to, &isovalue, sizeof isovalue);
    return sizeof isovalue;
}

/* VTK's indices are signed. */
static size_t put_corners(const struct pel_mesh_out *out, size_t triangle, char *to)
{
    int64_t corners[3];
    for (int c = 0; c < 3; c++)
        corners[c] = out->mesh->triangles[triangle][c];
    memcpy(to, corners, sizeof corners);
    return sizeof corners;
}

static size_t put_end(const struct pel_mesh_out *out, size_t triangle, char *to)
{
    (void)out;
    int64_t end = 3 * ((int64_t)triangle + 1);
    memcpy(to, &end, sizeof end);
    return sizeof end;
}

static bool write(struct pel_mesh_out *out, struct pel_error *error)
{
    const struct pel_mesh *mesh = out->mesh;
    FILE *file = out->file.file;
    const size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    const struct {
        const char *before, *type, *name, *after;
        int components;
        size_t count, bytes; /* records, and of each */
        pel_mesh_record *put;
    } arrays[] = {
        { "      <PointData Normals=\"Normals\" Scalars=\"isovalue\">\n", "Float32", "Normals", "", 3, vertices, 12, put_normal },
        { "", "Float64", "isovalue", "      </PointData>\n", 1, vertices, 8, put_isovalue },
        { "      <Points>\n", out->wide ? "Float64" : "Float32", "Points", "      </Points>\n", 3, vertices, out->wide ? 24 : 12,
          pel_mesh_put_position },
        { "      <Polys>\n", "Int64", "connectivity", "", 1, triangles, 24, put_corners },
        { "", "Int64", "offsets", "      </Polys>\n", 1, triangles, 8, put_end },
    };
    const size_t count = sizeof arrays / sizeof *arrays;
    fprintf(file, "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n",
            PEL_HOST_BIG_ENDIAN ? "BigEndian" : "LittleEndian");
    fprintf(file,
            "  <PolyData>\n    <Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
            "NumberOfPolys=\"%zu\">\n",
            vertices, triangles);
    uint64_t offset = 0;
    for (size_t i = 0; i < count; i++) {
        fprintf(file,
                "%s        <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%" PRIu64 "\"/>\n%s",
                arrays[i].before, arrays[i].type, arrays[i].name, arrays[i].components, offset, arrays[i].after);
        offset += sizeof(uint64_t) + (uint64_t)arrays[i].count * arrays[i].bytes;
    }
    fputs("    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n   _", file);
    out->share = 1.0 / (double)count;
    for (size_t i = 0; i < count; i++) {
        uint64_t bytes = (uint64_t)arrays[i].count * arrays[i].bytes;
        if (!pel_safe_file_write(&out->file, &bytes, sizeof bytes, error) ||
            !pel_mesh_write_records(out, arrays[i].count, arrays[i].put, error))
            return false;
    }
    static const char end[] = "\n  </AppendedData>\n</VTKFile>\n";
    return pel_safe_file_write(&out->file, end, sizeof end - 1, error);
}

const struct pel_mesh_format pel_mesh_format_vtp = { ".vtp", write };
