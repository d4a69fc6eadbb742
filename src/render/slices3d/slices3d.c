/* SPDX-License-Identifier: MIT */
/* The way of a frame: what the volume decides, what the transfer function decides, what the view decides, each made again only when it
 * changed; then the passes. */
#include "slices3d.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "rays.h"
#include "timer.h"

/* What may still shine through where a ray is said to be opaque, and how far it is followed to find out. */
#define WALK_CLEAR (1.0f / 1024)
#define WALK_SLICES 64

struct pel_slices3d *pel_slices3d_create(struct pel_device *device, struct pel_error *error)
{
    struct pel_slices3d *s = pel_alloc(1, sizeof *s, "slices", error);
    if (s) {
        s->device = device;
        s->stencil = epoxy_has_gl_extension("GL_ARB_shader_stencil_export");
    }
    return s;
}

static void release_faces(struct pel_device *device, struct pel_cube_faces *faces)
{
    pel_pairs_texture_destroy(device, &faces->texture);
    pel_buffer_destroy(device, &faces->buffer);
}

void pel_slices3d_destroy(struct pel_slices3d *s)
{
    if (!s)
        return;
    struct pel_device *d = s->device;
    struct pel_texture *textures[] = { &s->volume, &s->entries, &s->opacities, &s->picture, &s->z,
                                       &s->near,   &s->stretch, &s->depth,     &s->finished };
    struct pel_target *targets[] = { &s->target, &s->near_target, &s->z_target, &s->stretch_target, &s->depth_target, &s->finished_target };
    struct pel_buffer *buffers[] = { &s->range, &s->block, &s->slice_block };
    struct pel_cube_faces *faces[] = { &s->faces_t, &s->faces_p, &s->faces_box };
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++)
        pel_target_destroy(d, targets[i]);
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(d, textures[i]);
    for (size_t i = 0; i < 3; i++) {
        pel_buffer_destroy(d, buffers[i]);
        release_faces(d, faces[i]);
    }
    pel_gpu_stages_destroy(d, s->stages, PEL_STAGES);
    for (size_t i = 0; i < sizeof s->counters / sizeof *s->counters; i++)
        pel_gpu_counter_destroy(d, &s->counters[i]);
    pel_vertices_destroy(d, &s->vertices);
    pel_programs_finish(d, &s->programs);
    pel_cubes_finish(&s->phi_t);
    pel_cubes_finish(&s->phi_p);
    pel_octree_finish(&s->octree);
    pel_classify_finish(&s->tables);
    free(s);
}

/* ---- with the volume ---- */

static bool fits(const struct pel_slices3d *s, const struct pel_volume *v, struct pel_error *error)
{
    bool numbered = v->dims[0] <= 65535 && v->dims[1] <= 65535 && v->dims[2] <= 65535;
    return (numbered && pel_gpu_volume_fits(s->device, &s->format, v, 0)) ||
           pel_fail(error, PEL_ERROR_UNSUPPORTED,
                    "slices3d keeps the whole volume on the device, which does not hold it; use the technique raycast");
}

static bool take_volume(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    const struct pel_volume *v = frame->scene->volume;
    s->format = pel_gpu_format_of(s->device, v, frame->threads);
    pel_octree_finish(&s->octree);
    pel_gpu_box_whole(&s->box, v);
    if (!fits(s, v, error) ||
        !pel_gpu_volume_upload(s->device, &s->format, v, s->box.origin, s->box.size, frame->threads, &s->volume, error))
        return false;
    pel_frame_stage(frame, "upload", start);
    return true;
}

/* ---- with the transfer function ---- */

static bool needs_t(const struct pel_slices3d_options *o)
{
    return (o->cull != PEL_CULL_NONE && o->cull != PEL_CULL_ERT) || o->show == PEL_SHOW_PHI_T;
}

static bool needs_p(const struct pel_slices3d_options *o)
{
    return o->cull == PEL_CULL_ERT || o->cull == PEL_CULL_ESS_ERT || o->cull == PEL_CULL_BAND || o->show == PEL_SHOW_PHI_P;
}

static bool make_octree(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    int leaf = pel_octree_level_of(s->options.cube_t < s->options.cube_p ? s->options.cube_t : s->options.cube_p);
    if (s->octree.levels[PEL_OCTREE_LEVELS - 1].lo && s->octree.leaf <= leaf)
        return true;
    double start = pel_now_ms();
    pel_octree_finish(&s->octree);
    if (!pel_octree_init(&s->octree, frame->scene->volume, leaf, frame->threads, error))
        return false;
    pel_frame_stage(frame, "octree", start);
    return true;
}

/* Faces that are more than the device's buffer textures hold are left out: then nothing is culled by them. */
static bool send_faces(struct pel_slices3d *s, struct pel_cube_faces *to, const struct pel_cube_face *faces, size_t count, bool *there,
                       struct pel_error *error)
{
    *there = count <= pel_pairs_limit() && count < INT32_MAX / 6;
    size_t bytes = (*there && count ? count : 1) * sizeof *faces;
    static const struct pel_cube_face none = { 0, 0 };
    return pel_buffer_fill(s->device, &to->buffer, *there && count ? faces : &none, bytes, error) &&
           pel_pairs_texture(s->device, &to->texture, &to->buffer, error);
}

static bool send_opacities(struct pel_slices3d *s, struct pel_error *error)
{
    const int *n = s->phi_p.solid.dims;
    if (!pel_texture_reserve(s->device, &s->opacities, GL_R8, n[0], n[1], n[2], GL_NEAREST, error))
        return false;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage3D(s->opacities.name, 0, 0, 0, 0, n[0], n[1], n[2], GL_RED, GL_UNSIGNED_BYTE, s->phi_p.opacity);
    return true;
}

/* Both surfaces, as far as the options want them; the extraction whose times the papers tell in section 5. */
static bool extract(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_slices3d_options *o = &s->options;
    if (!needs_t(o) && !needs_p(o))
        return true;
    if (!make_octree(s, frame, error))
        return false;
    double start = pel_now_ms();
    pel_cube_table_build(&s->cube_table, &s->octree, &s->tables.table);
    if (needs_t(o) && (!pel_cubes_extract_t(&s->phi_t, &s->octree, &s->cube_table, pel_octree_level_of(o->cube_t), frame->threads, error) ||
                       !send_faces(s, &s->faces_t, s->phi_t.faces, s->phi_t.first[6], &s->has_t, error)))
        return false;
    pel_frame_stage(frame, "phi_t", start);
    start = pel_now_ms();
    if (needs_p(o) && (!pel_cubes_extract_p(&s->phi_p, &s->octree, &s->cube_table, pel_octree_level_of(o->cube_p), o->opaque,
                                            o->phi_p != PEL_PHI_P_ORIGINAL, frame->threads, error) ||
                       !send_faces(s, &s->faces_p, s->phi_p.faces, s->phi_p.first[6], &s->has_p, error) || !send_opacities(s, error)))
        return false;
    pel_frame_stage(frame, "phi_p", start);
    return true;
}

static bool send_box_faces(struct pel_slices3d *s, struct pel_error *error)
{
    struct pel_cube_face faces[6];
    bool there;
    for (uint32_t d = 0; d < 6; d++)
        faces[d] = (struct pel_cube_face) { 0, d << 16 | 1u << 19 };
    return s->faces_box.buffer.name || send_faces(s, &s->faces_box, faces, 6, &there, error);
}

/* ---- with the view ---- */

static void shrink_box(const struct pel_slices3d *s, struct pel_slice_block *b)
{
    float size = (float)(1 << s->phi_t.level), reach = s->job.classification == PEL_CLASSIFICATION_PREINTEGRATED ? INFINITY : 1;
    for (int a = 0; a < 3; a++) {
        b->lo[a] = fmaxf(b->lo[a], (float)s->phi_t.lo[a] * size - b->inflate[a] * reach);
        b->hi[a] = fminf(b->hi[a], (float)s->phi_t.hi[a] * size + b->inflate[a] * reach);
    }
}

bool pel_slices3d_use_box(struct pel_slices3d *s, bool shrunk, struct pel_error *error)
{
    struct pel_slice_block block = s->view.block;
    if (shrunk)
        shrink_box(s, &block);
    return pel_buffer_fill(s->device, &s->slice_block, &block, sizeof block, error);
}

/* With pre-integration the three places at which a slab's cubes are looked up must lie in cubes that touch. */
static bool slabs_too_long(const struct pel_slices3d *s, const struct pel_volume *v)
{
    double least = fmin(fmin(v->spacing[0], v->spacing[1]), v->spacing[2]) * s->options.cube_p;
    return s->job.classification == PEL_CLASSIFICATION_PREINTEGRATED && 1.5 * s->job.step > least / 2;
}

static bool set_view(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    pel_rays_setup(&s->job, scene, frame->jitter, frame->image->width, frame->image->height);
    if (!pel_slice_view_setup(&s->view, &s->job, scene->camera.parallel, frame->jitter, error))
        return false;
    struct pel_slice_block *b = &s->view.block;
    for (int a = 0; a < 3 && needs_p(&s->options); a++)
        b->cubes[a] = s->phi_p.solid.dims[a];
    b->cubes[3] = 1 << s->phi_p.level;
    b->walk[0] = WALK_CLEAR, b->walk[1] = slabs_too_long(s, scene->volume) ? 0 : WALK_SLICES;
    const struct pel_gpu_job job = { &s->job, scene, &s->format, &s->box };
    return pel_gpu_job_send(s->device, &job, &s->block, error) &&
           pel_slices3d_use_box(s, s->options.cull == PEL_CULL_BAND && s->has_t && s->options.shrink, error);
}

bool pel_slices3d_prepare(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    const unsigned changes = frame->changes;
    s->options = *(const struct pel_slices3d_options *)frame->options;
    if ((changes & PEL_CHANGE_VOLUME) && !take_volume(s, frame, error))
        return false;
    double start = pel_now_ms();
    if (changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_SETTINGS | PEL_CHANGE_STEP)) {
        if (!pel_classify_tables(&s->tables, frame->scene, s->format.raw, &s->job, error) ||
            !pel_gpu_tables_send(s->device, &s->tables, &s->entries, &s->range, error))
            return false;
        pel_frame_stage(frame, "tables", start);
    }
    if ((changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_OPTIONS)) && !extract(s, frame, error))
        return false;
    if (!send_box_faces(s, error) || !set_view(s, frame, error))
        return false;
    return true;
}

/* ---- drawing ---- */

static bool reserve(struct pel_slices3d *s, const struct pel_image *image, struct pel_error *error)
{
    static const GLenum formats[] = { GL_RGBA32F, GL_RGBA16F, GL_RGBA8 };
    struct pel_device *d = s->device;
    const int w = image->width, h = image->height;
    return pel_gpu_check_picture(d, image, "", error) &&
           pel_texture_reserve(d, &s->picture, formats[s->options.target], w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &s->finished, GL_RGBA32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &s->depth, GL_R32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &s->stretch, GL_RGBA32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &s->z, s->stencil ? GL_DEPTH24_STENCIL8 : GL_DEPTH_COMPONENT32F, w, h, 0, GL_NEAREST, error) &&
           pel_texture_reserve(d, &s->near, GL_DEPTH_COMPONENT32F, w, h, 0, GL_NEAREST, error) &&
           pel_target_set(d, &s->target, &s->picture, &s->z, error) && pel_target_set(d, &s->near_target, NULL, &s->near, error) &&
           pel_target_set(d, &s->z_target, NULL, &s->z, error) && pel_target_set(d, &s->stretch_target, &s->stretch, NULL, error) &&
           pel_target_set(d, &s->depth_target, &s->depth, NULL, error) && pel_target_set(d, &s->finished_target, &s->finished, NULL, error);
}

static bool draw_passes(struct pel_slices3d *s, const struct pel_frame *frame, bool to_display, struct pel_error *error)
{
    const enum pel_cull cull = s->options.cull;
    bool ok = pel_slices3d_bind(s, error);
    pel_gpu_stages_clear(s->stages, PEL_STAGES);
    pel_gpu_stage_begin(s->device, &s->stages[PEL_STAGE_VIEW], "slices3d: stretches of rays");
    ok = ok && pel_slices3d_measure_stretches(s, cull, error);
    pel_gpu_stage_end(s->device, &s->stages[PEL_STAGE_VIEW]);
    pel_gpu_stage_begin(s->device, &s->stages[PEL_STAGE_SURFACES], "slices3d: z-buffer");
    ok = ok && pel_slices3d_init_z(s, cull, error);
    pel_gpu_stage_end(s->device, &s->stages[PEL_STAGE_SURFACES]);
    pel_gpu_stage_begin(s->device, &s->stages[PEL_STAGE_SLICES], "slices3d: slices");
    ok = ok && (s->options.show ? pel_slices3d_show(s, error) : pel_slices3d_draw_slices(s, cull, s->options.slab, error));
    pel_gpu_stage_end(s->device, &s->stages[PEL_STAGE_SLICES]);
    pel_gpu_stage_begin(s->device, &s->stages[PEL_STAGE_FINISH], "slices3d: depth and display");
    ok = ok && (!frame->image->depth || pel_slices3d_find_depth(s, error)) && (!to_display || pel_slices3d_to_display(s, error));
    pel_gpu_stage_end(s->device, &s->stages[PEL_STAGE_FINISH]);
    return ok;
}

static void note(struct pel_slices3d *s, const struct pel_frame *frame)
{
    static const char *const names[] = { "stretches", "z-buffer", "slices", "depth and display" };
    for (int i = 0; i < 4; i++)
        pel_gpu_stage_note(s->device, &s->stages[i], frame, names[i]);
    pel_frame_count(frame, "slices", (uint64_t)s->view.count);
    pel_frame_count(frame, "fragments drawn", pel_gpu_counter_value(&s->counters[2]));
    if (s->has_t && needs_t(&s->options)) {
        pel_frame_count(frame, "cubes of phi_t", s->phi_t.cubes);
        pel_frame_count(frame, "faces of phi_t", s->phi_t.first[6]);
    }
    if (s->has_p && needs_p(&s->options)) {
        pel_frame_count(frame, "cubes of phi_p", s->phi_p.cubes);
        pel_frame_count(frame, "faces of phi_p", s->phi_p.first[6]);
    }
    if (s->stops)
        pel_frame_count(frame, "stops between slabs", (uint64_t)s->stops);
    pel_frame_count(frame, "bytes on the device", s->device->bytes);
    pel_frame_count(frame, "bytes of the octree", pel_octree_bytes(&s->octree));
}

bool pel_slices3d_draw(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    bool to_display = frame->scene->linear_light && !s->options.show;
    bool finished = to_display || s->options.show == PEL_SHOW_DEPTH || s->options.show == PEL_SHOW_NEAR;
    if (!reserve(s, frame->image, error))
        return false;
    bool ok = draw_passes(s, frame, to_display, error);
    double start = pel_now_ms();
    ok = ok && pel_gpu_read_back(s->device, finished ? &s->finished : &s->picture, &s->depth, frame->image, error);
    if (ok) {
        pel_frame_stage(frame, "read back", start);
        note(s, frame);
        ok = !s->options.cost || pel_slices3d_note_cost(s, frame, error);
    }
    pel_pass_defaults();
    return ok && pel_device_check(s->device, "slices", error);
}
