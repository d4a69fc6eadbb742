/* SPDX-License-Identifier: MIT */
/* Stage 2 (section 4.2): masks of the cell-slices that hold an active cell, a layer for each slab of slices. The rasteriser's way, and
 * that of GPUs that are poor at it. */
#include <math.h>
#include <stdlib.h>

#include "alloc.h"
#include "fail.h"
#include "peel.h"
#include "timer.h"

#define MOST_MASK_BYTES ((uint64_t)256 << 20) /* at once */

/* Slices of a layer: R16UI is drawn to, R32UI can be written by atomics. */
static int slices_a_layer(enum pel_mask_path path)
{
    return path == PEL_MASKS_COMPUTE ? 32 : 16;
}

int pel_peel_layers(const struct pel_peel *p, enum pel_mask_path path)
{
    int slices = slices_a_layer(path);
    return (p->view.major[2] + slices - 1) / slices;
}

bool pel_peel_mask_tile(const struct pel_peel *p, int sides[2], struct pel_error *error)
{
    const uint64_t limit = p->device->params.memory_limit, held = pel_peel_held(p);
    const int ways = p->options.path == PEL_MASKS_AUTO && p->chosen == PEL_MASKS_AUTO ? 2 : 1;                     /* to be measured */
    uint64_t room = MOST_MASK_BYTES, pixel = 4 * (uint64_t)pel_peel_layers(p, PEL_MASKS_COMPUTE) * (uint64_t)ways; /* in either way */
    if (limit && (held >= limit || limit - held < PEL_TILE_SIDE * PEL_TILE_SIDE * pixel))
        return pel_fail(
            error, PEL_ERROR_UNSUPPORTED,
            "peel keeps %.6g MB on the device, and masks beside them are more than the %.6g MB that it may take (--gpu-memory); "
            "take a coarser granularity, or the technique raycast",
            (double)held / 1e6, (double)limit / 1e6);
    if (limit && limit - held < room)
        room = limit - held;
    for (int i = 0; i < 2; i++)
        sides[i] = p->screen[2 + i];
    if ((uint64_t)sides[0] * (uint64_t)sides[1] * pixel <= room)
        return true;
    int side = (int)sqrt((double)room / (double)pixel) / PEL_TILE_SIDE * PEL_TILE_SIDE;
    for (int i = 0; i < 2; i++)
        if (sides[i] > side)
            sides[i] = side > PEL_TILE_SIDE ? side : PEL_TILE_SIDE;
    return true;
}

/* Bits start..end of a run, from the least, as nibbles: eight runs at most. Three numbers a mask, as printed: how many runs, where they
 * start, where they end. */
static void runs_of(unsigned mask, uint32_t to[4])
{
    to[0] = to[1] = to[2] = to[3] = 0;
    for (unsigned bit = 0; bit < 16; bit++) {
        bool set = mask >> bit & 1, before = bit && mask >> (bit - 1) & 1, after = bit < 15 && mask >> (bit + 1) & 1;
        if (set && !before)
            to[1] |= bit << 4 * to[0];
        if (set && !after)
            to[2] |= bit << 4 * to[0]++;
    }
}

bool pel_peel_mask_table(struct pel_peel *p, struct pel_error *error)
{
    if (p->mask_table.name)
        return true;
    uint32_t(*runs)[4] = pel_alloc(1 << 16, sizeof *runs, "mask table", error);
    if (!runs)
        return false;
    for (unsigned mask = 0; mask < 1 << 16; mask++)
        runs_of(mask, runs[mask]);
    bool ok = pel_texture_reserve(p->device, &p->mask_table, GL_RGBA32UI, 256, 256, 0, GL_NEAREST, error);
    if (ok)
        glTextureSubImage2D(p->mask_table.name, 0, 0, 0, 256, 256, GL_RGBA_INTEGER, GL_UNSIGNED_INT, runs);
    free(runs);
    return ok && pel_device_check(p->device, "mask table", error);
}

/* ---- the two ways ---- */

static const char *defines_of(const struct pel_peel *p)
{
    return p->options.cover == PEL_COVER_DISC ? "#define DISC\n" : "";
}

static bool rasterise(struct pel_peel *p, const struct pel_texture *masks, const int tile[4], struct pel_error *error)
{
    const struct pel_pass pass = { .color_write = true, .logic_or = true };
    GLuint program = pel_programs_find_layered(p->device, &p->programs, "peel_vertex.glsl", "peel_geometry.glsl", "peel_fragment.glsl",
                                               defines_of(p), error);
    if (!program || !pel_target_set(p->device, &p->target, masks, NULL, error) || !pel_vertices_bind(p->device, &p->vertices, error))
        return false;
    glUseProgram(program);
    pel_pass_begin(&p->target, &pass, tile[2], tile[3]);
    glDrawArrays(GL_POINTS, 0, (GLsizei)p->pyramid.total);
    pel_pass_defaults();
    return true;
}

static bool compute(struct pel_peel *p, const struct pel_texture *masks, struct pel_error *error)
{
    GLuint program = pel_programs_find(p->device, &p->programs, "peel_masks.glsl", defines_of(p), error);
    if (!program)
        return false;
    glUseProgram(program);
    glProgramUniform1ui(program, 0, p->pyramid.total);
    glBindImageTexture(0, masks->name, 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    pel_histopyramid_dispatch(p->pyramid.total);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
    return true;
}

bool pel_peel_make_masks(struct pel_peel *p, enum pel_mask_path path, const int tile[4], struct pel_error *error)
{
    const uint32_t none = 0;
    const bool computed = path == PEL_MASKS_COMPUTE;
    struct pel_texture *masks = &p->masks[computed];
    const int layers = pel_peel_layers(p, path);
    bool fits = masks->name && masks->size[0] >= tile[2] && masks->size[1] >= tile[3] && masks->size[2] == layers;
    if (!fits && !pel_texture_reserve_array(p->device, masks, computed ? GL_R32UI : GL_R16UI, tile[2], tile[3], layers, GL_NEAREST, error))
        return false;
    p->view.major[3] = slices_a_layer(path);
    if (!pel_peel_send_view(p, tile, error))
        return false;
    glClearTexSubImage(masks->name, 0, 0, 0, 0, tile[2], tile[3], layers, GL_RED_INTEGER, computed ? GL_UNSIGNED_INT : GL_UNSIGNED_SHORT,
                       &none);
    pel_histopyramid_bind(&p->pyramid);
    if (p->pyramid.total && !(computed ? compute(p, masks, error) : rasterise(p, masks, tile, error)))
        return false;
    glBindTextureUnit(PEL_UNIT_MASKS, masks->name);
    return pel_device_check(p->device, "masks", error);
}

/* Milliseconds of one way, after one time to warm up. */
static bool measure(struct pel_peel *p, enum pel_mask_path path, const int tile[4], double *milliseconds, struct pel_error *error)
{
    if (!pel_peel_make_masks(p, path, tile, error))
        return false;
    glFinish();
    *milliseconds = -pel_now_ms();
    if (!pel_peel_make_masks(p, path, tile, error))
        return false;
    glFinish();
    *milliseconds += pel_now_ms();
    return true;
}

/* Vertex shaders need not read buffers; then there is one way alone. */
static bool can_rasterise(void)
{
    GLint blocks = 0;
    glGetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &blocks);
    return blocks >= 2;
}

bool pel_peel_choose_path(struct pel_peel *p, const int tile[4], enum pel_mask_path *path, struct pel_error *error)
{
    double raster, computed;
    *path = p->options.path;
    if (*path == PEL_MASKS_RASTER && !can_rasterise())
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "this driver's vertex shaders read no buffers; use --mask-path compute");
    if (*path != PEL_MASKS_AUTO)
        return true;
    if (p->chosen == PEL_MASKS_AUTO && !can_rasterise())
        p->chosen = PEL_MASKS_COMPUTE;
    if (p->chosen == PEL_MASKS_AUTO && !p->pyramid.total) { /* nothing to measure by, and nothing to draw */
        *path = PEL_MASKS_COMPUTE;
        return true;
    }
    if (p->chosen == PEL_MASKS_AUTO) {
        if (!measure(p, PEL_MASKS_RASTER, tile, &raster, error) || !measure(p, PEL_MASKS_COMPUTE, tile, &computed, error))
            return false;
        p->chosen = computed < raster ? PEL_MASKS_COMPUTE : PEL_MASKS_RASTER;
        pel_texture_destroy(p->device, &p->masks[p->chosen == PEL_MASKS_RASTER]);
    }
    *path = p->chosen;
    return true;
}
