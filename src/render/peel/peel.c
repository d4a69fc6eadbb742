/* SPDX-License-Identifier: MIT */
/* The way of a frame: what the volume decides, what the isovalues decide, what the view decides, each made again only when it changed;
 * then masks, and rays within them (stage 3, section 4.3). */
#include "peel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "rays.h"
#include "timer.h"

#define COUNTER_ROWS 64
#define STRIP_SAMPLES 3e8 /* in one dispatch: no driver may take it for a hang */

struct pel_peel *pel_peel_create(struct pel_device *device, struct pel_error *error)
{
    struct pel_peel *p = pel_alloc(1, sizeof *p, "peeling", error);
    if (p)
        p->device = device;
    return p;
}

void pel_peel_destroy(struct pel_peel *p)
{
    if (!p)
        return;
    struct pel_device *d = p->device;
    struct pel_texture *textures[] = { &p->volume, &p->ranges, &p->masks[0], &p->masks[1], &p->mask_table, &p->picture, &p->depth };
    struct pel_buffer *buffers[] = { &p->block, &p->view_block, &p->counters, &p->segments, &p->listed, &p->tree };
    pel_target_destroy(d, &p->target);
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(d, textures[i]);
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(d, buffers[i]);
    pel_gpu_stages_destroy(d, p->stages, PEL_PEEL_STAGES);
    pel_histopyramid_finish(d, &p->pyramid);
    pel_vertices_destroy(d, &p->vertices);
    pel_programs_finish(d, &p->programs);
    free(p);
}

/* ---- preparing a frame ---- */

uint64_t pel_peel_held(const struct pel_peel *p)
{
    return p->volume.bytes + p->ranges.bytes + p->pyramid.base.bytes + p->pyramid.levels.bytes + p->tree.bytes;
}

/* The volume, the macro-cells' ranges and the counts over them must all fit. */
static bool fits(const struct pel_peel *p, const struct pel_volume *v, struct pel_error *error)
{
    uint64_t cells = 1;
    int grid[4];
    pel_peel_grid(&p->job, p->options.granularity, grid);
    for (int a = 0; a < 3; a++)
        cells *= (uint64_t)grid[a];
    return pel_gpu_volume_fits(p->device, &p->format, v, cells * 2 * (uint64_t)p->format.bytes + pel_histopyramid_bytes((size_t)cells)) ||
           pel_fail(error, PEL_ERROR_UNSUPPORTED,
                    "peel keeps the whole volume on the device, which does not hold it; use the technique raycast");
}

static bool take_volume(struct pel_peel *p, const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    const struct pel_volume *v = frame->scene->volume;
    p->format = pel_gpu_format_of(p->device, v, frame->threads);
    p->granularity = 0;
    p->chosen = PEL_MASKS_AUTO;
    pel_gpu_box_whole(&p->box, v);
    for (int a = 0; a < 3; a++)
        p->job.dims[a] = (int32_t)v->dims[a];
    if (!fits(p, v, error) ||
        !pel_gpu_volume_upload(p->device, &p->format, v, p->box.origin, p->box.size, frame->threads, &p->volume, error))
        return false;
    pel_frame_stage(frame, "upload", start);
    return true;
}

/* Neighbours of cells with voids are looked at a voxel away (peel_range.glsl); a longer segment may reach over more of them. */
static bool steps_over_voids(const struct pel_peel *p, const struct pel_volume *v)
{
    double least = fmin(fmin(v->spacing[0], v->spacing[1]), v->spacing[2]);
    return p->format.voids && p->job.roots == PEL_ROOTS_STEPS && p->job.step > least;
}

bool pel_peel_send_view(struct pel_peel *p, const int tile[4], struct pel_error *error)
{
    for (int i = 0; i < 4; i++)
        p->view.tile[i] = tile[i];
    if (!pel_buffer_fill(p->device, &p->view_block, &p->view, sizeof p->view, error))
        return false;
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, p->block.name);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_PEEL, p->view_block.name);
    return true;
}

/* Stage 1, as far as it is not done already. */
static bool find_cells(struct pel_peel *p, const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    if (!pel_peel_send_view(p, p->screen, error))
        return false;
    if (p->granularity != p->options.granularity) {
        p->counted = false;
        if (!pel_peel_find_ranges(p, frame, error))
            return false;
        glFinish();
        pel_frame_stage(frame, "ranges of cells", start);
    }
    if (p->options.skipping == PEL_BY_TREE)
        return pel_peel_plant_tree(p, error);
    if (p->counted)
        return true;
    pel_gpu_stage_begin(p->device, &p->stages[PEL_STAGE_ACTIVE], "peel: active cells");
    bool ok = pel_peel_find_active(p, error);
    pel_gpu_stage_end(p->device, &p->stages[PEL_STAGE_ACTIVE]);
    return ok;
}

bool pel_peel_prepare(struct pel_peel *p, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    pel_gpu_stages_clear(p->stages, PEL_PEEL_STAGES);
    p->options = *(const struct pel_peel_options *)frame->options;
    p->skip = scene->render.skip;
    if ((frame->changes & PEL_CHANGE_VOLUME) && !take_volume(p, frame, error))
        return false;
    if (frame->changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_TRANSFER | PEL_CHANGE_SETTINGS)) {
        pel_classify_isosurfaces(scene, p->format.raw, &p->job);
        p->counted &= !(frame->changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_ISOSURFACES));
    }
    pel_rays_setup(&p->job, scene, frame->jitter, frame->image->width, frame->image->height);
    const int32_t wide = steps_over_voids(p, scene->volume);
    p->counted &= wide == p->view.wide[0];
    p->view.wide[0] = wide;
    pel_peel_grid(&p->job, p->options.granularity, p->view.grid);
    const struct pel_gpu_job job = { &p->job, scene, &p->format, &p->box };
    return pel_peel_view_setup(p, scene->camera.parallel, error) && pel_gpu_job_send(p->device, &job, &p->block, error) &&
           (!p->skip || find_cells(p, frame, error));
}

/* ---- drawing ---- */

/* Whole rays need no masks, nor does a tree. */
static bool masked(const struct pel_peel *p)
{
    return p->skip && p->options.skipping == PEL_BY_MASKS;
}

static bool reserve(struct pel_peel *p, const struct pel_image *image, struct pel_error *error)
{
    const uint32_t none[COUNTER_ROWS][4] = { { 0 } };
    const float nothing[4] = { 0 }, nowhere = INFINITY;
    if (!pel_gpu_check_picture(p->device, image, "; use --device cpu", error) ||
        !pel_texture_reserve(p->device, &p->picture, GL_RGBA32F, image->width, image->height, 0, GL_NEAREST, error) ||
        !pel_texture_reserve(p->device, &p->depth, GL_R32F, image->width, image->height, 0, GL_NEAREST, error) ||
        !pel_buffer_fill(p->device, &p->counters, none, sizeof none, error) ||
        !pel_buffer_fill(p->device, &p->segments, none, sizeof none, error) || !pel_peel_mask_table(p, error))
        return false;
    glClearTexImage(p->picture.name, 0, GL_RGBA, GL_FLOAT, nothing);
    glClearTexImage(p->depth.name, 0, GL_RED, GL_FLOAT, &nowhere);
    return true;
}

static GLuint casting_program(struct pel_peel *p, struct pel_error *error)
{
    const struct {
        const char *word;
        bool on;
    } words[] = {
        { "VOIDS", p->format.voids },
        { "HEADLIGHTS", p->job.headlight_only },
        { "ONE_ISOVALUE", p->job.iso_count == 1 },
        { "STEPPING", p->job.roots == PEL_ROOTS_STEPS },
        { "BINARY_SEARCH", p->options.bisect },
        { "EXTERIOR", !p->options.interior },
        { "WHOLE", !p->skip },
        { "LISTED", masked(p) },
        { "TREE", p->skip && p->options.skipping == PEL_BY_TREE },
    };
    char defines[256] = "";
    int length = 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (words[i].on)
            length += snprintf(defines + length, sizeof defines - (size_t)length, "#define %s\n", words[i].word);
    return pel_programs_find(p->device, &p->programs, "peel_cast.glsl", defines, error);
}

/* A rectangle in dispatches of so many samples, as rays can have them, and groups, as there may be in a row. */
static struct pel_peel_strips strips_of(const struct pel_peel *p, const struct pel_frame *frame, const int tile[4])
{
    struct pel_peel_strips strips = { { tile[0] / PEL_TILE_SIDE, tile[1] / PEL_TILE_SIDE },
                                      tile[2] / PEL_TILE_SIDE,
                                      tile[3] / PEL_TILE_SIDE };
    double bounds[6], diagonal = 0;
    pel_volume_bounds(frame->scene->volume, bounds);
    for (int a = 0; a < 3; a++)
        diagonal += (bounds[2 * a + 1] - bounds[2 * a]) * (bounds[2 * a + 1] - bounds[2 * a]);
    double row = (sqrt(diagonal) / p->job.step + 1) * tile[2] * PEL_TILE_SIDE;
    strips.rows = (int)fmin(fmax(fmin(STRIP_SAMPLES / row, 65535.0 / strips.columns), 1), strips.all_rows);
    strips.count = (strips.all_rows + strips.rows - 1) / strips.rows;
    return strips;
}

/* Casts the rays of a rectangle, whose masks are bound. */
static bool cast_rays(struct pel_peel *p, const struct pel_frame *frame, GLuint program, const int tile[4], struct pel_error *error)
{
    const struct pel_peel_strips strips = strips_of(p, frame, tile);
    const int total = p->screen[3] / PEL_TILE_SIDE;
    if (masked(p) && !pel_peel_list_tiles(p, &strips, error))
        return false;
    glUseProgram(program);
    glBindTextureUnit(PEL_UNIT_VOLUME, p->volume.name);
    glBindTextureUnit(PEL_UNIT_MASK_TABLE, p->mask_table.name);
    if (p->skip && !masked(p)) {
        glBindTextureUnit(PEL_UNIT_RANGES, p->ranges.name);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_TREE, p->tree.name);
    }
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_COUNTERS, p->counters.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_PEEL_COUNTERS, p->segments.name);
    glBindImageTexture(0, p->picture.name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, p->depth.name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    for (int i = 0; i < strips.count; i++) {
        const int y = i * strips.rows;
        if (!pel_progress_report(frame->progress, fmin((double)((tile[1] - p->screen[1]) / PEL_TILE_SIDE + y) / total, 1), error))
            return false;
        if (masked(p)) {
            pel_peel_dispatch_strip(&strips, program, i);
        } else {
            const int left = strips.all_rows - y;
            glProgramUniform4i(program, 0, strips.first[0], strips.first[1] + y, 0, 0);
            glDispatchCompute((GLuint)strips.columns, (GLuint)(left < strips.rows ? left : strips.rows), 1);
        }
        glFlush();
    }
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    return true;
}

/* Masks and rays of a rectangle of the screen. */
static bool draw_tile(struct pel_peel *p, const struct pel_frame *frame, GLuint program, enum pel_mask_path path, const int tile[4],
                      struct pel_error *error)
{
    bool ok = true;
    if (masked(p)) {
        pel_gpu_stage_begin(p->device, &p->stages[PEL_STAGE_MASKS], "peel: masks");
        ok = pel_peel_make_masks(p, path, tile, error);
        pel_gpu_stage_end(p->device, &p->stages[PEL_STAGE_MASKS]);
    } else {
        ok = pel_peel_send_view(p, tile, error);
    }
    pel_gpu_stage_begin(p->device, &p->stages[PEL_STAGE_CAST], "peel: cast rays");
    ok = ok && cast_rays(p, frame, program, tile, error);
    pel_gpu_stage_end(p->device, &p->stages[PEL_STAGE_CAST]);
    p->tiles++;
    return ok;
}

static bool draw_tiles(struct pel_peel *p, const struct pel_frame *frame, enum pel_mask_path *path, struct pel_error *error)
{
    const int *screen = p->screen;
    int sides[2] = { screen[2], screen[3] };
    GLuint program = casting_program(p, error);
    p->tiles = 0;
    if (!program || !screen[2])
        return program != 0;
    if (masked(p)) {
        if (!pel_peel_mask_tile(p, sides, error))
            return false;
        const int first[4] = { screen[0], screen[1], sides[0], sides[1] };
        if (!pel_peel_choose_path(p, first, path, error))
            return false;
    }
    for (int y = 0; y < screen[3]; y += sides[1])
        for (int x = 0; x < screen[2]; x += sides[0]) {
            const int tile[4] = { screen[0] + x, screen[1] + y, screen[2] - x < sides[0] ? screen[2] - x : sides[0],
                                  screen[3] - y < sides[1] ? screen[3] - y : sides[1] };
            if (!draw_tile(p, frame, program, *path, tile, error))
                return false;
        }
    return true;
}

static void note_stages(struct pel_peel *p, const struct pel_frame *frame)
{
    static const char *const names[] = { "active cells", "masks", "cast rays" };
    for (int i = 0; i < PEL_PEEL_STAGES; i++)
        pel_gpu_stage_note(p->device, &p->stages[i], frame, names[i]);
}

static void note(struct pel_peel *p, const struct pel_frame *frame, enum pel_mask_path path)
{
    uint32_t counted[COUNTER_ROWS][4], peeled[COUNTER_ROWS][4];
    uint64_t taken = 0, rays = 0, segments = 0, cells = 1;
    glGetNamedBufferSubData(p->counters.name, 0, sizeof counted, counted);
    glGetNamedBufferSubData(p->segments.name, 0, sizeof peeled, peeled);
    for (int i = 0; i < COUNTER_ROWS; i++) {
        taken += counted[i][0] | (uint64_t)counted[i][1] << 32;
        rays += peeled[i][0];
        segments += peeled[i][1] | (uint64_t)peeled[i][2] << 32;
    }
    for (int a = 0; a < 3; a++)
        cells *= (uint64_t)p->view.grid[a];
    note_stages(p, frame);
    pel_frame_count(frame, p->job.roots == PEL_ROOTS_CUBIC ? "voxel cells looked into" : "samples taken", taken);
    pel_frame_count(frame, "rays with segments", rays);
    pel_frame_count(frame, "segments", segments);
    if (masked(p)) {
        pel_frame_count(frame, "cells", cells);
        pel_frame_count(frame, "active cells", p->pyramid.total);
        pel_frame_count(frame, "cell-slices", (uint64_t)p->view.major[2]);
        pel_frame_count(frame, "layers of masks", (uint64_t)pel_peel_layers(p, path));
        pel_frame_count(frame, "masks by the rasteriser", path == PEL_MASKS_RASTER);
        pel_frame_count(frame, "tiles of the screen", (uint64_t)p->tiles);
    }
    pel_frame_count(frame, "bytes on the device", p->device->bytes);
}

bool pel_peel_draw(struct pel_peel *p, const struct pel_frame *frame, struct pel_error *error)
{
    enum pel_mask_path path = PEL_MASKS_RASTER;
    bool ok = reserve(p, frame->image, error) && draw_tiles(p, frame, &path, error);
    double start = pel_now_ms();
    ok = ok && pel_gpu_read_back(p->device, &p->picture, &p->depth, frame->image, error);
    if (ok) {
        pel_frame_stage(frame, "read back", start);
        note(p, frame, path);
    }
    return ok && pel_device_check(p->device, "peeling", error);
}
