/* SPDX-License-Identifier: MIT */
/* Between stages 2 and 3: the tiles of the screen in which rays have segments. The paper's rays without any end at once; a work group that
 * has none but such is not begun at all, which matters most where there is no hardware to begin it. */
#include <stdlib.h>

#include "alloc.h"
#include "peel.h"

bool pel_peel_list_tiles(struct pel_peel *p, const struct pel_peel_strips *strips, struct pel_error *error)
{
    const size_t tiles = (size_t)strips->columns * (size_t)strips->rows * (size_t)strips->count;
    uint32_t(*commands)[4] = pel_alloc((size_t)strips->count, sizeof *commands, "dispatches", error);
    GLuint program = commands ? pel_programs_find(p->device, &p->programs, "peel_tiles.glsl", "", error) : 0;
    bool ok = program && pel_buffer_fill(p->device, &p->listed, NULL, (size_t)strips->count * sizeof *commands + tiles * 4, error);
    if (ok) {
        for (int i = 0; i < strips->count; i++)
            commands[i][0] = commands[i][3] = 0, commands[i][1] = commands[i][2] = 1;
        glNamedBufferSubData(p->listed.name, 0, (GLsizeiptr)((size_t)strips->count * sizeof *commands), commands);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_TILES, p->listed.name);
        glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, p->listed.name);
        glUseProgram(program);
        glProgramUniform4i(program, 0, strips->columns, strips->all_rows, strips->rows, strips->count);
        glDispatchCompute((GLuint)(((size_t)strips->columns * (size_t)strips->all_rows + 63) / 64), 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    }
    free(commands);
    return ok;
}

void pel_peel_dispatch_strip(const struct pel_peel_strips *strips, GLuint program, int strip)
{
    glProgramUniform4i(program, 0, strips->first[0], strips->first[1], 0, 4 * strips->count + strip * strips->columns * strips->rows);
    glDispatchComputeIndirect((GLintptr)strip * 16);
}
