/* SPDX-License-Identifier: MIT */
/* Stage 1 (section 4.1): which cells are active. */
#include <string.h>

#include "fail.h"
#include "peel.h"

#define GROUP 4 /* cells of a work group along each axis */

/* Ranges are kept in the volume's own type. */
static GLenum range_format(GLenum voxel)
{
    return voxel == GL_R8 ? GL_RG8 : voxel == GL_R16 ? GL_RG16 : GL_RG32F;
}

static bool dispatch_ranges(struct pel_peel *p, struct pel_error *error)
{
    const int *grid = p->view.grid;
    GLuint program =
        pel_gpu_program(p->device, &p->programs, "peel_range.glsl", p->format.voids ? PEL_HAS_VOIDS : 0, PEL_MODE_ISOSURFACE, error);
    if (!program)
        return false;
    glUseProgram(program);
    glBindTextureUnit(PEL_UNIT_VOLUME, p->volume.name);
    glBindImageTexture(0, p->ranges.name, 0, GL_TRUE, 0, GL_WRITE_ONLY, p->ranges.format);
    glDispatchCompute((GLuint)(grid[0] + GROUP - 1) / GROUP, (GLuint)(grid[1] + GROUP - 1) / GROUP, (GLuint)(grid[2] + GROUP - 1) / GROUP);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return pel_device_check(p->device, "ranges of cells", error);
}

bool pel_peel_find_ranges(struct pel_peel *p, const struct pel_frame *frame, struct pel_error *error)
{
    const int *grid = p->view.grid;
    p->granularity = 0;
    p->planted = false;
    if (!pel_texture_reserve(p->device, &p->ranges, range_format(p->format.texture), grid[0], grid[1], grid[2], GL_NEAREST, error) ||
        !(p->device->info.software ? pel_peel_send_ranges(p, frame->scene->volume, frame->threads, error) : dispatch_ranges(p, error)))
        return false;
    p->granularity = grid[3];
    return true;
}

bool pel_peel_find_active(struct pel_peel *p, struct pel_error *error)
{
    const int *grid = p->view.grid;
    size_t cells = (size_t)grid[0] * (size_t)grid[1] * (size_t)grid[2];
    GLuint program = pel_gpu_program(p->device, &p->programs, "peel_active.glsl", 0, PEL_MODE_ISOSURFACE, error);
    p->counted = false;
    if (!program || !pel_histopyramid_reserve(p->device, &p->pyramid, cells, error))
        return false;
    glUseProgram(program);
    glBindTextureUnit(PEL_UNIT_RANGES, p->ranges.name);
    pel_histopyramid_bind(&p->pyramid);
    pel_histopyramid_dispatch((cells + PEL_HISTO_GROUP - 1) / PEL_HISTO_GROUP);
    if (!pel_histopyramid_build(p->device, &p->programs, &p->pyramid, error))
        return false;
    if (p->pyramid.total > INT32_MAX) /* glDrawArrays and gl_VertexID count no further */
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "peel: %u active cells are more than are drawn at once; take a coarser granularity",
                        (unsigned)p->pyramid.total);
    p->counted = true;
    return true;
}

/* Nodes of a level along an axis. */
static int nodes(const struct pel_peel *p, int level, int axis)
{
    return ((p->view.grid[axis] - 1) >> level) + 1;
}

/* Where levels start in the buffer; up to a single node. */
static bool lay_tree(struct pel_peel *p, uint64_t *whole)
{
    *whole = 0;
    for (int level = 1; level < PEL_TREE_LEVELS; level++) {
        uint64_t count = 1;
        for (int a = 0; a < 3; a++)
            count *= (uint64_t)nodes(p, level, a);
        p->view.tree[level] = (int32_t)*whole;
        *whole += count;
        p->view.wide[1] = level + 1;
        if (*whole * 8 > p->device->info.max_storage_buffer_bytes)
            return false;
        if (count == 1)
            return true;
    }
    return true;
}

bool pel_peel_plant_tree(struct pel_peel *p, struct pel_error *error)
{
    uint64_t whole;
    if (p->planted)
        return true;
    if (!lay_tree(p, &whole))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the device's buffers do not hold the min-max tree; take a coarser granularity");
    if (p->tree.bytes < whole * 8 && !pel_gpu_check_room(p->device, pel_peel_held(p) - p->tree.bytes, whole * 8, "peel: a min-max tree",
                                                         "take a coarser granularity", error))
        return false;
    GLuint program = pel_gpu_program(p->device, &p->programs, "peel_tree_level.glsl", 0, PEL_MODE_ISOSURFACE, error);
    if (!program || !pel_buffer_fill(p->device, &p->tree, NULL, (size_t)whole * 8, error) || !pel_peel_send_view(p, p->screen, error))
        return false;
    glUseProgram(program);
    glBindTextureUnit(PEL_UNIT_RANGES, p->ranges.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_TREE, p->tree.name);
    for (int level = 1; level < p->view.wide[1]; level++) {
        glProgramUniform1i(program, 0, level);
        glDispatchCompute((GLuint)(nodes(p, level, 0) + GROUP - 1) / GROUP, (GLuint)(nodes(p, level, 1) + GROUP - 1) / GROUP,
                          (GLuint)(nodes(p, level, 2) + GROUP - 1) / GROUP);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
    p->planted = true;
    return pel_device_check(p->device, "min-max tree", error);
}
