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

bool pel_peel_find_ranges(struct pel_peel *p, struct pel_error *error)
{
    const int *grid = p->view.grid;
    GLuint program =
        pel_gpu_program(p->device, &p->programs, "peel_range.glsl", p->format.voids ? PEL_HAS_VOIDS : 0, PEL_MODE_ISOSURFACE, error);
    p->granularity = 0;
    if (!program || !pel_texture_reserve(p->device, &p->ranges, range_format(p->format.texture), grid[0], grid[1], grid[2], GL_NEAREST, error))
        return false;
    glUseProgram(program);
    glBindTextureUnit(PEL_UNIT_VOLUME, p->volume.name);
    glBindImageTexture(0, p->ranges.name, 0, GL_TRUE, 0, GL_WRITE_ONLY, p->ranges.format);
    glDispatchCompute((GLuint)(grid[0] + GROUP - 1) / GROUP, (GLuint)(grid[1] + GROUP - 1) / GROUP, (GLuint)(grid[2] + GROUP - 1) / GROUP);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    p->granularity = grid[3];
    return pel_device_check(p->device, "ranges of cells", error);
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
    p->counted = true;
    return true;
}
