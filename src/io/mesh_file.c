/* SPDX-License-Identifier: MIT */
/* pel_write_mesh: the format that the name's ending says, and what the formats share. */
#include <math.h>
#include <string.h>

#include "fail.h"
#include "format.h"
#include "mesh_io.h"

enum { RECORD = 256, PIECE = 1 << 16 };

static const struct pel_mesh_format *const formats[] = { &pel_mesh_format_ply, &pel_mesh_format_stl, &pel_mesh_format_obj,
                                                         &pel_mesh_format_vtp, NULL };

bool pel_mesh_write_records(struct pel_mesh_out *out, size_t count, pel_mesh_record *one, struct pel_error *error)
{
    char piece[PIECE];
    size_t filled = 0;
    for (size_t i = 0; i < count; i++) {
        filled += one(out, i, piece + filled);
        if (filled <= PIECE - RECORD)
            continue;
        if (!pel_safe_file_write(&out->file, piece, filled, error) ||
            !pel_progress_report(out->progress, out->fraction + out->share * (double)i / (double)count, error))
            return false;
        filled = 0;
    }
    out->fraction += out->share;
    return pel_safe_file_write(&out->file, piece, filled, error);
}

void pel_mesh_world(const struct pel_mesh *mesh, size_t vertex, double world[3])
{
    for (int i = 0; i < 3; i++)
        world[i] = mesh->origin[i] + (double)mesh->positions[vertex][i];
}

size_t pel_mesh_put_position(const struct pel_mesh_out *out, size_t vertex, char *to)
{
    double world[3];
    pel_mesh_world(out->mesh, vertex, world);
    if (out->wide) {
        memcpy(to, world, sizeof world);
        return sizeof world;
    }
    const float near[3] = { (float)world[0], (float)world[1], (float)world[2] };
    memcpy(to, near, sizeof near);
    return sizeof near;
}

const struct pel_mesh_part *pel_mesh_part_of(const struct pel_mesh *mesh, size_t vertex)
{
    int part = 0;
    while (part < mesh->part_count - 1 && vertex >= mesh->parts[part].first_vertex + mesh->parts[part].vertex_count)
        part++;
    return &mesh->parts[part];
}

/* A float has 24 bits; where fewer than 16 are left for places on the surface, it is too coarse. */
static bool is_far(const struct pel_mesh *mesh)
{
    double bounds[6], extent = 0, most = 0;
    if (!pel_mesh_bounds(mesh, bounds))
        return false;
    for (int a = 0; a < 3; a++) {
        extent = fmax(extent, bounds[2 * a + 1] - bounds[2 * a]);
        most = fmax(most, fmax(fabs(bounds[2 * a]), fabs(bounds[2 * a + 1])));
    }
    return most > 256 * extent;
}

bool pel_write_mesh(const char *path, const struct pel_mesh *mesh, const struct pel_progress *progress, struct pel_error *error)
{
    const struct pel_mesh_format *format = NULL;
    for (size_t i = 0; formats[i]; i++)
        if (pel_path_has_ending(path, formats[i]->endings))
            format = formats[i];
    if (!format)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: the name's ending says no format of surfaces; use .ply, .stl, .obj or .vtp", path);
    static const struct pel_progress silent = { NULL, NULL };
    struct pel_mesh_out out = { .mesh = mesh, .progress = progress ? progress : &silent, .wide = is_far(mesh) };
    bool ok = pel_safe_file_open(&out.file, path, error) && format->write(&out, error) && pel_safe_file_commit(&out.file, error);
    pel_safe_file_abort(&out.file);
    return ok || pel_fail_in(error, "%s: ", path);
}
