/* SPDX-License-Identifier: MIT */
#include "slices2d_gpu.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "alloc.h"
#include "drawing.h"
#include "encode.h"
#include "fail.h"
#include "gpu_frame.h"
#include "gpu_job.h"
#include "rays.h"
#include "slices2d.h"
#include "slices2d_polygons.h"
#include "timer.h"
#include "vec.h"

enum { UNIT_SO_FAR = 5, BLOCK_SLICES = 1, IMAGE_PICTURE = 0, IMAGE_DEPTH = 1 };
enum { UNIFORM_FIRST = 0, UNIFORM_WEIGHT = 0 };
#define GROUP 8

struct pel_gpu_slices2d {
    struct pel_device *device;
    struct pel_programs programs;
    struct pel_gpu_format format;
    struct pel_texture stacks[3]; /* by axis, each sent when it is first needed */
    struct pel_minmax minmax;
    struct pel_classification_state state;
    struct pel_job job;
    struct pel_slices2d_part parts[PEL_SHEAR_PARTS];
    int part_count;
    struct pel_texture entries, picture, layer, depth;
    struct pel_target target;
    struct pel_buffer block, slices_block, range, seen, corners;
    struct pel_vertices polygons_array, strips_array;
    struct pel_gpu_timer timer;
    struct pel_gpu_counter fragments;
    uint64_t slices, polygons;
};

struct pel_gpu_slices2d *pel_gpu_slices2d_create(struct pel_device *device, struct pel_error *error)
{
    struct pel_gpu_slices2d *s = pel_alloc(1, sizeof *s, "slices", error);
    if (s)
        s->device = device;
    return s;
}

static void release_volume(struct pel_gpu_slices2d *s)
{
    for (int a = 0; a < 3; a++)
        pel_texture_destroy(s->device, &s->stacks[a]);
    pel_minmax_finish(&s->minmax);
}

void pel_gpu_slices2d_destroy(struct pel_gpu_slices2d *s)
{
    if (!s)
        return;
    release_volume(s);
    struct pel_texture *textures[] = { &s->entries, &s->picture, &s->layer, &s->depth };
    struct pel_buffer *buffers[] = { &s->block, &s->slices_block, &s->range, &s->seen, &s->corners };
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(s->device, textures[i]);
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(s->device, buffers[i]);
    pel_target_destroy(s->device, &s->target);
    pel_vertices_destroy(s->device, &s->polygons_array);
    pel_vertices_destroy(s->device, &s->strips_array);
    pel_gpu_timer_destroy(s->device, &s->timer);
    pel_gpu_counter_destroy(s->device, &s->fragments);
    pel_programs_finish(s->device, &s->programs);
    pel_classify_finish(&s->state);
    free(s);
}

/* ---- preparing a frame ---- */

static bool check_size(const struct pel_gpu_slices2d *s, const struct pel_frame *frame, struct pel_error *error)
{
    const size_t *dims = frame->scene->volume->dims;
    GLint layers = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
    for (int a = 0; a < 3; a++)
        if (dims[a] > (size_t)s->device->info.max_texture_2d || dims[a] > (size_t)layers)
            return pel_fail(
                error, PEL_ERROR_UNSUPPORTED,
                "slices2d: %zu x %zu x %zu voxels are more than the GPU's stacks hold (%d a side, %d slices); use the technique raycast",
                dims[0], dims[1], dims[2], s->device->info.max_texture_2d, layers);
    return true;
}

static bool classify(struct pel_gpu_slices2d *s, const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    if (!s->minmax.cells.least) {
        if (!pel_minmax_init(&s->minmax, frame->scene->volume, frame->threads, error))
            return false;
        pel_frame_stage(frame, "min-max grid", start);
        start = pel_now_ms();
    }
    if (!pel_classify(&s->state, frame->scene, &s->minmax, s->format.raw, frame->threads, &s->job, error) ||
        !pel_gpu_tables_send(s->device, &s->state, &s->entries, &s->range, error))
        return false;
    pel_frame_stage(frame, "classify", start);
    return true;
}

/* Section 9's strips are fewest in the stack that the planes are most along. */
static void choose_stack_of_planes(struct pel_gpu_slices2d *s)
{
    double along[3] = { 0 };
    int axis = 0;
    for (int i = 0; i < s->job.slice_count; i++) {
        const double *plane = s->job.slice_planes[i], length = pel_length(plane);
        for (int a = 0; a < 3; a++)
            along[a] += fabs(plane[a]) / length;
    }
    for (int a = 1; a < 3; a++)
        if (along[a] > along[axis])
            axis = a;
    s->parts[0] = (struct pel_slices2d_part) { axis, 1, false, 1 };
    s->part_count = 1;
}

/* Stacks that are there and this one: bytes on the device. */
static bool fits(const struct pel_gpu_slices2d *s, const struct pel_volume *v, struct pel_error *error)
{
    const uint64_t limit = s->device->params.memory_limit, each = (uint64_t)s->format.bytes * v->dims[0] * v->dims[1] * v->dims[2];
    uint64_t bytes = each;
    for (int a = 0; a < 3; a++)
        bytes += s->stacks[a].name ? each : 0;
    return !limit || bytes <= limit ||
           pel_fail(error, PEL_ERROR_UNSUPPORTED,
                    "slices2d keeps a copy of the volume on the device for each axis it is seen along, %.0f MB, which is more than it may take; use the technique raycast",
                    (double)bytes / 1e6);
}

static bool send_stacks(struct pel_gpu_slices2d *s, const struct pel_frame *frame, struct pel_error *error)
{
    for (int i = 0; i < s->part_count; i++) {
        const int axis = s->parts[i].axis;
        double start = pel_now_ms();
        if (s->stacks[axis].name)
            continue;
        if (!fits(s, frame->scene->volume, error))
            return false;
        if (!pel_gpu_stack_upload(s->device, &s->format, frame->scene->volume, axis, frame->threads, &s->stacks[axis], error)) {
            pel_texture_destroy(s->device, &s->stacks[axis]);
            return false;
        }
        pel_frame_stage(frame, "upload", start);
    }
    return true;
}

bool pel_gpu_slices2d_prepare(struct pel_gpu_slices2d *s, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    const struct pel_slices2d_options *o = frame->options;
    if (!check_size(s, frame, error))
        return false;
    if (frame->changes & PEL_CHANGE_VOLUME) {
        release_volume(s);
        s->format = pel_gpu_format_of(s->device, scene->volume, frame->threads);
        for (int a = 0; a < 3; a++)
            s->job.dims[a] = (int32_t)scene->volume->dims[a];
    }
    if (frame->changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_SETTINGS |
                          PEL_CHANGE_STEP) &&
        !classify(s, frame, error))
        return false;
    pel_rays_setup(&s->job, scene, frame->jitter, frame->image->width, frame->image->height);
    if (scene->render.mode == PEL_MODE_SLICE)
        choose_stack_of_planes(s);
    else
        s->part_count = pel_slices2d_parts(&s->job, !scene->camera.parallel, o->blend, s->parts);
    return send_stacks(s, frame, error);
}

/* ---- drawing ---- */

/* A frame on its way. */
struct drawing {
    struct pel_gpu_slices2d *s;
    const struct pel_frame *frame;
    const struct pel_slices2d_options *options;
    struct pel_slices2d_layout layout;
    bool perspective, depth;
};

static GLuint program(const struct drawing *d, const struct pel_slices2d_part *part, bool depth, struct pel_error *error)
{
    static const char *const fragments[] = { [PEL_MODE_COMPOSITE] = "slices2d_composite_fragment.glsl",
                                             [PEL_MODE_ISOSURFACE] = "slices2d_isosurface_fragment.glsl",
                                             [PEL_MODE_SLICE] = "slices2d_strip_fragment.glsl" };
    const struct pel_job *job = &d->s->job;
    const enum pel_mode mode = job->mode;
    const bool composite = mode == PEL_MODE_COMPOSITE,
               alpha_test = mode == PEL_MODE_ISOSURFACE && d->options->surface == PEL_SURFACE_ALPHA_TEST;
    const struct {
        const char *word;
        bool on;
    } words[] = {
        { "VOIDS", d->s->format.voids },
        { "NEAREST", job->nearest },
        { "SHADE", composite && job->shade },
        { "HEADLIGHTS", job->headlight_only && mode != PEL_MODE_SLICE },
        { "ONE_ISOVALUE", mode == PEL_MODE_ISOSURFACE && job->iso_count == 1 },
        { "PRE", composite && !job->nearest && job->classification == PEL_CLASSIFICATION_PRE },
        { "LINEAR_CORRECTION", composite && d->options->correction == PEL_CORRECTION_LINEAR },
        { "DISPLACED", composite && d->options->coordinates == PEL_COORDINATES_SHARED },
        { "ALPHA_TEST", alpha_test },
        { "PLAIN", (composite || alpha_test) && d->options->supersampling == 1 },
        { "DEPTH", depth },
    };
    char defines[512];
    int length = snprintf(defines, sizeof defines, "#define AXIS %d\n#define LIGHTING %d\n", part->axis,
                          mode == PEL_MODE_SLICE ? 0 : d->options->lighting);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (words[i].on)
            length += snprintf(defines + length, sizeof defines - (size_t)length, "#define %s\n", words[i].word);
    return pel_programs_find_drawing(d->s->device, &d->s->programs,
                                     mode == PEL_MODE_SLICE ? "slices2d_strip_vertex.glsl" : "slices2d_vertex.glsl", fragments[mode],
                                     defines, error);
}

static bool send_blocks(const struct drawing *d, const struct pel_slices2d_part *part, int *polygons, struct pel_error *error)
{
    struct pel_gpu_slices2d *s = d->s;
    struct pel_gpu_box box = { .last = { 1 << 28, 1 << 28, 1 << 28 } };
    for (int a = 0; a < 3; a++) {
        box.size[a] = s->job.dims[a];
        box.cells[a] = s->job.cell_dims[a];
    }
    const struct pel_gpu_job job = { .job = &s->job, .scene = d->frame->scene, .format = &s->format, .box = &box };
    struct pel_slices2d_block block;
    *polygons = pel_slices2d_lay(&s->job, d->perspective, part, &d->layout, &block);
    for (int c = 0; c < 3; c++)
        block.ambient[c] = (float)d->options->ambient_color[c];
    if (!pel_gpu_job_send(s->device, &job, &s->block, error) || !pel_buffer_fill(s->device, &s->slices_block, &block, sizeof block, error))
        return false;
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, s->block.name);
    glBindBufferBase(GL_UNIFORM_BUFFER, BLOCK_SLICES, s->slices_block.name);
    glBindTextureUnit(PEL_UNIT_VOLUME, s->stacks[part->axis].name);
    glBindTextureUnit(PEL_UNIT_ENTRIES, s->entries.name);
    return true;
}

/* All polygons by one call. With depth each by its own: it must see what those before it have left, to know where half the light is
 * gathered. */
static void draw_polygons(const struct drawing *d, const struct pel_texture *color, int polygons, bool depth, uint32_t (*seen)[2])
{
    if (!depth) {
        glUniform1i(UNIFORM_FIRST, 0);
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, polygons);
        return;
    }
    glBindTextureUnit(UNIT_SO_FAR, color->name);
    glBindImageTexture(IMAGE_DEPTH, d->s->depth.name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    for (int i = 0; i < polygons; i++) {
        if (!seen[i][0] && !seen[i][1])
            continue;
        glUniform1i(UNIFORM_FIRST, i);
        glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, 1, (GLuint)i);
        glTextureBarrier();
    }
}

static bool draw_slices(const struct drawing *d, const struct pel_slices2d_part *part, const struct pel_texture *color, bool depth,
                        int polygons, struct pel_error *error)
{
    struct pel_gpu_slices2d *s = d->s;
    uint32_t(*seen)[2] = pel_alloc_aligned((size_t)polygons, sizeof *seen, "polygons", error);
    bool all = !d->frame->scene->render.skip || !s->state.map_bytes;
    int count = seen ? pel_slices2d_seen(&s->job, part, &d->layout, polygons, all, seen, error) : -1;
    bool ok = count >= 0 && pel_buffer_fill(s->device, &s->seen, seen, (size_t)polygons * sizeof *seen, error) &&
              pel_vertices_bind_buffer(s->device, &s->polygons_array, PEL_VERTICES_PAIRS, &s->seen, error);
    if (ok) {
        draw_polygons(d, color, polygons, depth, seen);
        s->polygons += (uint64_t)count;
        s->slices += (uint64_t)polygons * (uint64_t)d->layout.each;
    }
    free(seen);
    return ok;
}

/* From front to back, by one call. With depth a call for each piece of a plane, since it asks whether a nearer one is to be seen. */
static bool draw_strips(const struct drawing *d, const struct pel_slices2d_part *part, const struct pel_texture *color, bool depth,
                        struct pel_error *error)
{
    struct pel_gpu_slices2d *s = d->s;
    struct pel_slices2d_strips strips;
    if (!pel_slices2d_strips(&s->job, d->perspective, part->axis, &strips, error))
        return false;
    size_t bytes = (size_t)strips.count * sizeof *strips.corners;
    bool ok = bytes == 0 || (pel_buffer_fill(s->device, &s->corners, strips.corners, bytes, error) &&
                             pel_vertices_bind_buffer(s->device, &s->strips_array, PEL_VERTICES_CORNERS, &s->corners, error));
    if (ok && depth) {
        glBindTextureUnit(UNIT_SO_FAR, color->name);
        glBindImageTexture(IMAGE_DEPTH, s->depth.name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
        for (int i = 0, from = 0; i < strips.pieces; from = strips.ends[i++]) {
            glDrawArrays(GL_TRIANGLES, from, strips.ends[i] - from);
            glTextureBarrier();
        }
    } else if (ok && strips.count > 0) {
        glDrawArrays(GL_TRIANGLES, 0, strips.count);
    }
    s->polygons += (uint64_t)(strips.count / 3);
    pel_slices2d_strips_finish(&strips);
    return ok;
}

static bool draw_part(const struct drawing *d, const struct pel_slices2d_part *part, const struct pel_texture *color, bool depth,
                      struct pel_error *error)
{
    const struct pel_pass pass = { .color_write = true, .blending = PEL_BLEND_BEHIND };
    struct pel_gpu_slices2d *s = d->s;
    GLuint name = program(d, part, depth, error);
    int polygons;
    if (!name || !send_blocks(d, part, &polygons, error) || !pel_target_set(s->device, &s->target, color, NULL, error))
        return false;
    glUseProgram(name);
    pel_pass_begin(&s->target, &pass, s->job.width, s->job.height);
    return s->job.mode == PEL_MODE_SLICE ? draw_strips(d, part, color, depth, error) : draw_slices(d, part, color, depth, polygons, error);
}

/* Adds a stack's picture to the others', by its weight. */
static bool blend_in(const struct drawing *d, const struct pel_slices2d_part *part, struct pel_error *error)
{
    struct pel_gpu_slices2d *s = d->s;
    GLuint name = pel_programs_find(s->device, &s->programs, "slices2d_blend.glsl", "", error);
    if (!name)
        return false;
    glUseProgram(name);
    glBindTextureUnit(UNIT_SO_FAR, s->layer.name);
    glBindImageTexture(IMAGE_PICTURE, s->picture.name, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glUniform1f(UNIFORM_WEIGHT, (float)part->weight);
    glDispatchCompute((GLuint)(s->job.width - 1) / GROUP + 1, (GLuint)(s->job.height - 1) / GROUP + 1, 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
    return true;
}

static bool draw_parts(const struct drawing *d, struct pel_error *error)
{
    struct pel_gpu_slices2d *s = d->s;
    const float nothing[4] = { 0 };
    const bool blended = s->part_count > 1 && !s->parts[0].split;
    for (int i = 0; i < s->part_count; i++) {
        const struct pel_slices2d_part *part = &s->parts[i];
        if (blended)
            glClearTexImage(s->layer.name, 0, GL_RGBA, GL_FLOAT, nothing);
        if (!draw_part(d, part, blended ? &s->layer : &s->picture, d->depth && (i == 0 || !blended), error) ||
            (blended && !blend_in(d, part, error)))
            return false;
    }
    return true;
}

static bool reserve_picture(struct pel_gpu_slices2d *s, const struct pel_image *image, struct pel_error *error)
{
    const float nothing[4] = { 0 }, nowhere = INFINITY;
    if (!pel_gpu_check_picture(s->device, image, "; use --device cpu", error) ||
        !pel_texture_reserve(s->device, &s->picture, GL_RGBA32F, image->width, image->height, 0, GL_NEAREST, error) ||
        (s->part_count > 1 && !pel_texture_reserve(s->device, &s->layer, GL_RGBA32F, image->width, image->height, 0, GL_NEAREST, error)) ||
        (image->depth && !pel_texture_reserve(s->device, &s->depth, GL_R32F, image->width, image->height, 0, GL_NEAREST, error)))
        return false;
    glClearTexImage(s->picture.name, 0, GL_RGBA, GL_FLOAT, nothing);
    if (image->depth)
        glClearTexImage(s->depth.name, 0, GL_RED, GL_FLOAT, &nowhere);
    return true;
}

static bool read_back(struct pel_gpu_slices2d *s, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_image *image = frame->image;
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    if (!pel_gpu_read_back(s->device, &s->picture, &s->depth, image, error))
        return false;
    s->job.rgba = image->rgba;
    if (frame->scene->linear_light)
        pel_encode_picture(&s->job, frame->threads);
    return true;
}

static void note_counters(struct pel_gpu_slices2d *s, const struct pel_frame *frame)
{
    uint64_t stacks = 0;
    for (int a = 0; a < 3; a++)
        stacks += s->stacks[a].bytes;
    pel_frame_count(frame, "fragments", pel_gpu_counter_value(&s->fragments));
    pel_frame_count(frame, "slices", s->slices);
    pel_frame_count(frame, "polygons", s->polygons);
    pel_frame_count(frame, "cells", (uint64_t)s->job.cell_dims[0] * (uint64_t)s->job.cell_dims[1] * (uint64_t)s->job.cell_dims[2]);
    pel_frame_count(frame, "cells that may be seen", s->state.visible_cells);
    pel_frame_count(frame, "bytes of slices", stacks);
    pel_frame_count(frame, "bytes on the device", s->device->bytes);
}

bool pel_gpu_slices2d_draw(struct pel_gpu_slices2d *s, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_slices2d_options *o = frame->options;
    const struct drawing d = { .s = s,
                               .frame = frame,
                               .options = o,
                               .perspective = !frame->scene->camera.parallel,
                               .depth = frame->image->depth,
                               .layout = { o->supersampling, o->every, 1 << o->slices_per_polygon,
                                           s->job.mode == PEL_MODE_ISOSURFACE && o->surface == PEL_SURFACE_CROSSING } };
    s->slices = s->polygons = 0;
    if (!reserve_picture(s, frame->image, error))
        return false;
    double start = pel_now_ms();
    pel_gpu_timer_begin(s->device, &s->timer, "slices2d: draw slices");
    pel_gpu_counter_begin(s->device, &s->fragments);
    bool ok = draw_parts(&d, error);
    pel_pass_defaults();
    pel_gpu_counter_end(&s->fragments);
    pel_gpu_timer_end(&s->timer);
    double gpu_ms = pel_gpu_timer_ms(&s->timer);
    pel_frame_stage_gpu(frame, "draw slices", start, gpu_ms);
    start = pel_now_ms();
    ok = ok && read_back(s, frame, error);
    pel_frame_stage(frame, "read back", start);
    note_counters(s, frame);
    return ok && pel_device_check(s->device, "slices2d", error);
}
