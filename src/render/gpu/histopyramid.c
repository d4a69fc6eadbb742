/* SPDX-License-Identifier: MIT */
#include "histopyramid.h"

#include <string.h>

#include "fail.h"

#define LOCAL 64          /* invocations of a work group */
#define MOST_GROUPS 32768 /* along x; GL allows 65535 */

/* What lies before the sums in their buffer; HistoLevels of histopyramid.glsl. */
struct head {
    uint32_t total, top, padding[2];
    uint32_t offsets[PEL_HISTO_LEVELS];
};

/* The levels, up to one whose sums are a single uvec4; false: too many. In uvec4s, of all together. */
static bool lay_levels(struct pel_histopyramid *p, size_t *whole)
{
    uint64_t count = (p->items + PEL_HISTO_GROUP - 1) / PEL_HISTO_GROUP, offset = 0;
    for (p->level_count = 0; p->level_count < PEL_HISTO_LEVELS && count <= UINT32_MAX; p->level_count++) {
        p->sizes[p->level_count] = (uint32_t)count;
        p->offsets[p->level_count] = (uint32_t)offset;
        offset += (count + 3) / 4;
        if (count <= 4) {
            p->level_count++;
            *whole = (size_t)offset;
            return true;
        }
        count = (count + 3) / 4;
    }
    return false;
}

bool pel_histopyramid_reserve(struct pel_device *device, struct pel_histopyramid *p, size_t items, struct pel_error *error)
{
    size_t whole = 0;
    p->items = items ? items : 1;
    p->total = 0;
    bool fits = p->items <= (size_t)-1 - PEL_HISTO_GROUP && lay_levels(p, &whole);
    size_t base = fits ? (p->items + PEL_HISTO_GROUP - 1) / PEL_HISTO_GROUP * PEL_HISTO_GROUP : 0,
           levels = sizeof(struct head) + whole * 4 * sizeof(uint32_t);
    const uint64_t most = device->info.max_storage_buffer_bytes;
    if (!fits || base > most || levels > most)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED,
                        "%zu cells are more than the device counts in a buffer of %llu bytes; take coarser ones", items,
                        (unsigned long long)most);
    struct head head = { .top = (uint32_t)p->level_count - 1 };
    memcpy(head.offsets, p->offsets, sizeof p->offsets);
    if (!pel_buffer_fill(device, &p->base, NULL, base, error) || !pel_buffer_fill(device, &p->levels, NULL, levels, error))
        return false;
    glNamedBufferSubData(p->levels.name, 0, sizeof head, &head);
    return pel_device_check(device, "HistoPyramid", error);
}

uint64_t pel_histopyramid_bytes(size_t items)
{
    struct pel_histopyramid p = { .items = items ? items : 1 };
    size_t whole = 0;
    lay_levels(&p, &whole);
    return (p.items + PEL_HISTO_GROUP - 1) / PEL_HISTO_GROUP * PEL_HISTO_GROUP + sizeof(struct head) +
           (uint64_t)whole * 4 * sizeof(uint32_t);
}

void pel_histopyramid_bind(const struct pel_histopyramid *p)
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_HISTO_BASE, p->base.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_HISTO_LEVELS, p->levels.name);
}

void pel_histopyramid_dispatch(size_t count)
{
    size_t groups = (count + LOCAL - 1) / LOCAL, rows = (groups + MOST_GROUPS - 1) / MOST_GROUPS;
    if (groups)
        glDispatchCompute((GLuint)(rows > 1 ? MOST_GROUPS : groups), (GLuint)rows, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

bool pel_histopyramid_build(struct pel_device *device, struct pel_programs *programs, struct pel_histopyramid *p, struct pel_error *error)
{
    GLuint base = pel_programs_find(device, programs, "histopyramid_sum.glsl", "#define BASE\n", error),
           sums = base ? pel_programs_find(device, programs, "histopyramid_sum.glsl", "", error) : 0;
    if (!sums)
        return false;
    pel_histopyramid_bind(p);
    for (int l = 0; l < p->level_count; l++) {
        const GLuint program = l ? sums : base;
        glUseProgram(program);
        glProgramUniform4ui(program, 0, p->sizes[l], p->offsets[l], l ? p->offsets[l - 1] : 0, l == p->level_count - 1);
        pel_histopyramid_dispatch((p->sizes[l] + 3) / 4);
    }
    glGetNamedBufferSubData(p->levels.name, 0, sizeof p->total, &p->total);
    return pel_device_check(device, "HistoPyramid", error);
}

void pel_histopyramid_finish(struct pel_device *device, struct pel_histopyramid *p)
{
    pel_buffer_destroy(device, &p->base);
    pel_buffer_destroy(device, &p->levels);
    memset(p, 0, sizeof *p);
}
