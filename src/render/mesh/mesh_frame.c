/* SPDX-License-Identifier: MIT */
/* The way of a frame: what the volume decides, what the isovalues decide, what the view decides, each made again only when it changed;
 * then the passes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "gpu_view.h"
#include "mesh_render.h"
#include "rays.h"
#include "timer.h"

struct pel_mesh_renderer *pel_mesh_renderer_create(struct pel_device *device, struct pel_error *error)
{
    struct pel_mesh_renderer *m = pel_alloc(1, sizeof *m, "mesh renderer", error);
    if (m)
        m->device = device;
    return m;
}

void pel_mesh_renderer_destroy(struct pel_mesh_renderer *m)
{
    if (!m)
        return;
    struct pel_device *d = m->device;
    struct pel_texture *textures[] = { &m->picture, &m->finished, &m->z, &m->depth };
    struct pel_target *targets[] = { &m->surface_target, &m->finished_target };
    struct pel_buffer *buffers[] = { &m->block, &m->mesh_block, &m->heads, &m->links, &m->nodes };
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++)
        pel_target_destroy(d, targets[i]);
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(d, textures[i]);
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(d, buffers[i]);
    pel_gpu_stages_destroy(d, m->stages, PEL_MESH_STAGES);
    pel_vertices_destroy(d, &m->whole);
    pel_mesh_surfaces_finish(m);
    pel_mesh_extraction_finish(d, &m->extraction);
    pel_programs_finish(d, &m->programs);
    pel_minmax_finish(&m->minmax);
    pel_classify_finish(&m->tables);
    free(m);
}

/* ---- preparing ---- */

static bool take_volume(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_volume *v = frame->scene->volume;
    double start = pel_now_ms();
    m->format = pel_gpu_format_of(m->device, v, frame->threads);
    pel_gpu_box_whole(&m->box, v);
    m->extraction.ready = false;
    pel_minmax_finish(&m->minmax);
    memset(&m->minmax, 0, sizeof m->minmax);
    if (!pel_minmax_init(&m->minmax, v, frame->threads, error))
        return false;
    pel_frame_stage(frame, "min-max grid", start);
    return true;
}

/* The z-buffer holds near / view depth, and in parallel a straight line from 1 at the nearest place to 0 beyond the farthest: greater is
 * nearer, and floats are finest where surfaces are many. */
static void set_depth(struct pel_mesh_block *b, const struct pel_gpu_view *view, const struct pel_job *job, bool parallel)
{
    double least = INFINITY, most = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        double at = view->depth[3];
        for (int a = 0; a < 3; a++)
            at += view->depth[a] * (corner >> a & 1 ? job->box_hi[a] : job->box_lo[a]);
        least = fmin(least, at);
        most = fmax(most, at);
    }
    double margin = 1e-3 * fmax(most - least, 1e-30), range = most - least + 2 * margin;
    double near = parallel ? 0 : fmax(least, 1e-6 * fmax(most, 1e-30));
    for (int i = 0; i < 4; i++) {
        b->depth[i] = (float)view->depth[i];
        b->clip_z[i] = parallel ? (float)((i == 3 ? most + margin - view->depth[3] : -view->depth[i]) / range) : i == 3 ? (float)near : 0;
    }
    b->from_z[0] = (float)(parallel ? most + margin : near);
    b->from_z[1] = (float)-range;
    b->room[1] = !parallel;
}

static bool set_view(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_gpu_view view;
    pel_rays_setup(&m->job, frame->scene, 0, frame->image->width, frame->image->height);
    if (!pel_gpu_view_setup(&view, &m->job, frame->scene->camera.parallel))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "mesh: the camera sees no picture plane");
    memcpy(m->view.clip_x, view.clip_x, sizeof view.clip_x);
    memcpy(m->view.clip_y, view.clip_y, sizeof view.clip_y);
    memcpy(m->view.clip_w, view.clip_w, sizeof view.clip_w);
    set_depth(&m->view, &view, &m->job, frame->scene->camera.parallel);
    const struct pel_gpu_job job = { &m->job, frame->scene, &m->format, &m->box };
    return pel_gpu_job_send(m->device, &job, &m->block, error) &&
           pel_buffer_fill(m->device, &m->mesh_block, &m->view, sizeof m->view, error);
}

bool pel_mesh_renderer_prepare(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    const unsigned changes = frame->changes;
    m->options = *(const struct pel_mesh_options *)frame->options;
    if ((changes & PEL_CHANGE_VOLUME) && !take_volume(m, frame, error))
        return false;
    if ((changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_SETTINGS | PEL_CHANGE_STEP | PEL_CHANGE_ISOSURFACES)) &&
        !pel_classify_tables(&m->tables, frame->scene, m->format.raw, &m->job, error))
        return false;
    if (!set_view(m, frame, error))
        return false;
    return !(changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_OPTIONS)) || pel_mesh_surfaces_make(m, frame, error);
}

/* ---- drawing ---- */

static bool reserve(struct pel_mesh_renderer *m, const struct pel_image *image, struct pel_error *error)
{
    struct pel_device *d = m->device;
    const int w = image->width, h = image->height;
    return pel_gpu_check_picture(d, image, "", error) &&
           pel_texture_reserve(d, &m->picture, GL_RGBA32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &m->finished, GL_RGBA32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &m->z, GL_DEPTH_COMPONENT32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &m->depth, GL_R32F, w, h, 0, GL_NEAREST, error) &&
           pel_target_set(d, &m->surface_target, &m->picture, &m->z, error) &&
           pel_target_set(d, &m->finished_target, &m->finished, NULL, error);
}

static bool draw_passes(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, m->block.name);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, m->mesh_block.name);
    pel_gpu_stages_clear(m->stages, PEL_MESH_STAGES);
    pel_gpu_stage_begin(m->device, &m->stages[PEL_MESH_OPAQUE], "mesh: opaque surfaces");
    bool ok = pel_mesh_draw_opaque(m, error);
    pel_gpu_stage_end(m->device, &m->stages[PEL_MESH_OPAQUE]);
    pel_gpu_stage_begin(m->device, &m->stages[PEL_MESH_TRANSLUCENT], "mesh: translucent surfaces");
    ok = ok && pel_mesh_draw_translucent(m, error);
    pel_gpu_stage_end(m->device, &m->stages[PEL_MESH_TRANSLUCENT]);
    pel_gpu_stage_begin(m->device, &m->stages[PEL_MESH_FINISH], "mesh: depth and display");
    ok = ok && (!frame->image->depth || pel_mesh_find_depth(m, error)) && (!frame->scene->linear_light || pel_mesh_to_display(m, error));
    pel_gpu_stage_end(m->device, &m->stages[PEL_MESH_FINISH]);
    return ok;
}

static void note(struct pel_mesh_renderer *m, const struct pel_frame *frame)
{
    static const char *const names[] = { "opaque surfaces", "translucent surfaces", "depth and display" };
    for (int i = 0; i < PEL_MESH_STAGES; i++)
        pel_gpu_stage_note(m->device, &m->stages[i], frame, names[i]);
    uint64_t vertices = 0, triangles = 0;
    for (int i = 0; i < m->job.iso_count; i++) {
        vertices += m->surfaces[i].vertex_count;
        triangles += m->surfaces[i].element_count / 3;
    }
    pel_frame_count(frame, "vertices", vertices);
    pel_frame_count(frame, "triangles", triangles);
    pel_frame_count(frame, "fragments in lists", m->listed);
    pel_frame_count(frame, "bytes on the device", m->device->bytes);
}

bool pel_mesh_renderer_draw(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    if (!reserve(m, frame->image, error))
        return false;
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE); /* floats are fine about 0 alone */
    bool ok = draw_passes(m, frame, error);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    double start = pel_now_ms();
    ok = ok && pel_gpu_read_back(m->device, frame->scene->linear_light ? &m->finished : &m->picture, &m->depth, frame->image, error);
    if (ok) {
        pel_frame_stage(frame, "read back", start);
        note(m, frame);
    }
    pel_pass_defaults();
    return ok && pel_device_check(m->device, "mesh", error);
}
