/* SPDX-License-Identifier: MIT */
/* pel_write_mesh: the format that the name's ending says, and what the formats share. */
#include <stdio.h>
#include <string.h>

#include "c_locale.h"
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

static const struct pel_mesh_format *format_of(const char *path, struct pel_error *error)
{
    char endings[128] = "";
    size_t used = 0;
    for (size_t i = 0; formats[i]; i++)
        if (pel_path_has_ending(path, formats[i]->endings))
            return formats[i];
    for (size_t i = 0; formats[i] && used < sizeof endings; i++)
        used += (size_t)snprintf(endings + used, sizeof endings - used, "%s%s",
                                 !i               ? ""
                                 : formats[i + 1] ? ", "
                                                  : " or ",
                                 formats[i]->endings);
    pel_fail(error, PEL_ERROR_ARGUMENT, "%s: surfaces are written as %s; give one of these endings", path, endings);
    return NULL;
}

bool pel_check_mesh_path(const char *path, struct pel_error *error)
{
    return format_of(path, error);
}

/* Headers and OBJ are text: numbers with points. */
static bool write_to(struct pel_mesh_out *out, const struct pel_mesh_format *format, struct pel_error *error)
{
    const struct pel_c_locale locale = pel_c_locale_begin();
    bool ok = format->write(out, error);
    pel_c_locale_end(&locale);
    return ok;
}

bool pel_write_mesh(const char *path, const struct pel_mesh *mesh, const struct pel_progress *progress, struct pel_error *error)
{
    const struct pel_mesh_format *format = format_of(path, error);
    if (!format)
        return false;
    static const struct pel_progress silent = { NULL, NULL };
    struct pel_mesh_out out = { .mesh = mesh, .progress = progress ? progress : &silent, .wide = pel_mesh_is_far(mesh) };
    bool ok = pel_safe_file_open(&out.file, path, error) && write_to(&out, format, error) && pel_safe_file_commit(&out.file, error);
    pel_safe_file_abort(&out.file);
    return ok || pel_fail_in(error, "%s: ", path);
}
