/* SPDX-License-Identifier: MIT */
#include "gpu_cells.h"

#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "distance_map.h"
#include "fail.h"
#include "parallel.h"

#define GROUP 4 /* cells of a work group along each axis */

static size_t total(const int count[3])
{
    return (size_t)count[0] * (size_t)count[1] * (size_t)count[2];
}

uint64_t pel_gpu_cells_bytes(const int count[3])
{
    return total(count) * (8 + 1 + 8 + 2); /* grid, marks, eight maps, scratch */
}

static bool reserve(struct pel_device *device, struct pel_texture *texture, GLenum format, const int count[3], int maps, /* along each axis */
                    struct pel_error *error)
{
    return pel_texture_reserve(device, texture, format, count[0] * maps, count[1] * maps, count[2] * maps, GL_NEAREST, error);
}

/* Scratch may be larger than it need be: bricks at the volume's end are smaller than the others. */
static bool reserve_scratch(struct pel_device *device, struct pel_texture *texture, const int count[3], struct pel_error *error)
{
    const int *have = texture->size;
    bool fits = texture->name && have[0] >= count[0] && have[1] >= count[1] && have[2] >= count[2];
    return fits || reserve(device, texture, GL_R8UI, count, 1, error);
}

static void dispatch(const int count[3])
{
    glDispatchCompute((GLuint)(count[0] + GROUP - 1) / GROUP, (GLuint)(count[1] + GROUP - 1) / GROUP, (GLuint)(count[2] + GROUP - 1) / GROUP);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                    GL_TEXTURE_UPDATE_BARRIER_BIT);
}

bool pel_gpu_cells_build(const struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, const struct pel_gpu_box *box, bool voids,
                         struct pel_error *error)
{
    GLuint program =
        pel_gpu_program(maker->device, maker->programs, "minmax.glsl", voids ? PEL_HAS_VOIDS : 0, PEL_MODE_COMPOSITE, error);
    if (!program || !reserve(maker->device, &cells->grid, GL_RG32F, box->cells, 1, error))
        return false;
    memcpy(cells->count, box->cells, sizeof cells->count);
    glUseProgram(program);
    glBindImageTexture(0, cells->grid.name, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG32F);
    dispatch(cells->count);
    return pel_device_check(maker->device, "min-max grid", error);
}

bool pel_gpu_cells_mark(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, enum pel_mode mode, struct pel_error *error)
{
    const uint32_t none = 0;
    bool special = mode == PEL_MODE_ISOSURFACE || mode == PEL_MODE_MIP || mode == PEL_MODE_MINIP;
    GLuint program = pel_gpu_program(maker->device, maker->programs, "classify.glsl", 0, special ? mode : PEL_MODE_COMPOSITE, error);
    cells->octants = 0;
    if (!program || !reserve(maker->device, &cells->marks, GL_R8UI, cells->count, 1, error) ||
        !pel_buffer_fill(maker->device, &maker->seen, &none, sizeof none, error))
        return false;
    glUseProgram(program);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_SEEN, maker->seen.name);
    glBindTextureUnit(PEL_UNIT_GRID, cells->grid.name);
    glBindImageTexture(0, cells->marks.name, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    dispatch(cells->count);
    cells->counted = false;
    return pel_device_check(maker->device, "classify", error);
}

bool pel_gpu_cells_mark_by_cpu(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, const struct pel_gpu_box *box,
                               const struct pel_gpu_marking *marking, struct pel_error *error)
{
    memcpy(cells->count, box->cells, sizeof cells->count);
    cells->octants = 0;
    if (!cells->host_marks && !(cells->host_marks = pel_alloc_aligned(total(box->cells), 1, "visible cells", error)))
        return false;
    cells->counted = true;
    cells->visible = (uint32_t)pel_classify_box(marking->tables, marking->scene, marking->minmax, marking->raw, marking->job,
                                                box->first_cell, box->cells, maker->threads, cells->host_marks);
    if (maker->device->info.software)
        return true;
    if (!reserve(maker->device, &cells->marks, GL_R8UI, cells->count, 1, error))
        return false;
    glTextureSubImage3D(cells->marks.name, 0, 0, 0, 0, cells->count[0], cells->count[1], cells->count[2], GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                        cells->host_marks);
    free(cells->host_marks);
    cells->host_marks = NULL;
    return pel_device_check(maker->device, "visible cells", error);
}

/* The distance map of one octant, in three passes: x, y and z; the last writes into its place among the octants' maps. */
static bool make_map(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, GLuint program, int octant, struct pel_error *error)
{
    const struct pel_texture *from[3] = { &cells->marks, &maker->scratch[0], &maker->scratch[1] },
                             *to[3] = { &maker->scratch[0], &maker->scratch[1], &cells->distances };
    glUseProgram(program);
    for (int axis = 0; axis < 3; axis++) {
        glProgramUniform4i(program, 0, axis, octant, axis == 2, 0);
        glBindTextureUnit(PEL_UNIT_FROM, from[axis]->name);
        glBindImageTexture(0, to[axis]->name, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
        dispatch(cells->count);
    }
    return pel_device_check(maker->device, "distance map", error);
}

static bool make_maps(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, unsigned wanted, struct pel_error *error)
{
    GLuint program = pel_gpu_program(maker->device, maker->programs, "distance.glsl", 0, PEL_MODE_COMPOSITE, error);
    if (!program || !reserve_scratch(maker->device, &maker->scratch[0], cells->count, error) ||
        !reserve_scratch(maker->device, &maker->scratch[1], cells->count, error))
        return false;
    for (int o = 0; o < 8; o++)
        if (wanted & 1u << o && !make_map(maker, cells, program, o, error))
            return false;
    return true;
}

struct mapping {
    const uint8_t *marks;
    size_t dims[3];
    uint8_t *maps; /* one after the other */
    unsigned octants[8];
    bool failed[8];
};

static void map_on_cpu(void *context, size_t i, int thread)
{
    (void)thread;
    struct mapping *m = context;
    size_t slice = m->dims[0] * m->dims[1];
    m->failed[i] = !pel_distance_map(m->marks, m->dims, m->dims[0], slice, m->octants[i], m->maps + i * slice * m->dims[2], NULL);
}

static bool send_maps(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, unsigned wanted, struct pel_error *error)
{
    const int *c = cells->count;
    struct mapping m = { .marks = cells->host_marks, .dims = { (size_t)c[0], (size_t)c[1], (size_t)c[2] } };
    size_t count = 0;
    for (unsigned o = 0; o < 8; o++)
        if (wanted & 1u << o)
            m.octants[count++] = o;
    m.maps = pel_alloc_aligned(total(c) * count, 1, "distance maps", error);
    if (!m.maps)
        return false;
    pel_parallel_for(maker->threads, count, map_on_cpu, &m);
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        const int o = (int)m.octants[i];
        ok &= !m.failed[i];
        glTextureSubImage3D(cells->distances.name, 0, (o & 1) * c[0], (o >> 1 & 1) * c[1], (o >> 2) * c[2], c[0], c[1], c[2],
                            GL_RED_INTEGER, GL_UNSIGNED_BYTE, m.maps + i * total(c));
    }
    free(m.maps);
    return ok ? pel_device_check(maker->device, "distance maps", error) : pel_fail(error, PEL_ERROR_MEMORY, "distance maps: no memory");
}

bool pel_gpu_cells_map(struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells, unsigned octants, struct pel_error *error)
{
    unsigned wanted = octants & ~cells->octants;
    if (!reserve(maker->device, &cells->distances, GL_R8UI, cells->count, 2, error))
        return false;
    if (wanted && !(cells->host_marks ? send_maps(maker, cells, wanted, error) : make_maps(maker, cells, wanted, error)))
        return false;
    cells->octants |= wanted;
    return true;
}

uint32_t pel_gpu_cells_visible(const struct pel_gpu_cell_maker *maker, struct pel_gpu_cells *cells)
{
    if (!cells->counted && maker->seen.name)
        glGetNamedBufferSubData(maker->seen.name, 0, sizeof cells->visible, &cells->visible);
    cells->counted = true;
    return cells->visible;
}

void pel_gpu_cells_finish(struct pel_device *device, struct pel_gpu_cells *cells)
{
    pel_texture_destroy(device, &cells->grid);
    pel_texture_destroy(device, &cells->marks);
    pel_texture_destroy(device, &cells->distances);
    free(cells->host_marks);
    memset(cells, 0, sizeof *cells);
}

void pel_gpu_cell_maker_finish(struct pel_gpu_cell_maker *maker)
{
    pel_texture_destroy(maker->device, &maker->scratch[0]);
    pel_texture_destroy(maker->device, &maker->scratch[1]);
    pel_buffer_destroy(maker->device, &maker->seen);
}
