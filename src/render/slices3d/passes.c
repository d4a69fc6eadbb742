/* SPDX-License-Identifier: MIT */
/* The passes of a frame. Colour is written in the volume pass alone; everything before it only prepares the z-buffer: "nothing is ever
 * skipped", but the GPU discards early what the z-buffer hides. */
#include "slices3d.h"

/* Slices that phi_t keeps to each side for rounding; with pre-integration a slab reaches as far as its neighbours' middles. */
#define MARGIN 0.02f
#define MARGIN_PREINTEGRATED 1.02f

static const float one = 1, zero = 0;

/* What the scene and the options make of the shaders that sample. */
static unsigned sampling_has(const struct pel_slices3d *s)
{
    const struct pel_job *job = &s->job;
    unsigned has = (s->format.voids ? PEL_HAS_VOIDS : 0) | (job->headlight_only ? PEL_HAS_HEADLIGHTS : 0) |
                   (job->nearest ? PEL_HAS_NEAREST : 0) | (job->shade ? PEL_HAS_SHADE : 0);
    if (!job->nearest && job->classification == PEL_CLASSIFICATION_PREINTEGRATED)
        has |= PEL_HAS_PREINTEGRATED;
    else if (!job->nearest && job->classification == PEL_CLASSIFICATION_PRE)
        has |= PEL_HAS_PRE;
    return has;
}

static bool use(struct pel_slices3d *s, const char *vertex, const char *fragment, unsigned has, GLuint *program, struct pel_error *error)
{
    *program = pel_gpu_program_drawing(s->device, &s->programs, vertex, fragment, has, error);
    if (*program)
        glUseProgram(*program);
    return *program != 0;
}

static void begin(const struct pel_slices3d *s, const struct pel_target *target, const struct pel_pass *pass)
{
    pel_pass_begin(target, pass, s->job.width, s->job.height);
}

bool pel_slices3d_bind(struct pel_slices3d *s, struct pel_error *error)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, s->block.name);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, s->slice_block.name);
    glBindTextureUnit(PEL_UNIT_VOLUME, s->volume.name);
    glBindTextureUnit(PEL_UNIT_ENTRIES, s->entries.name);
    glBindTextureUnit(PEL_UNIT_OPACITIES, s->opacities.name);
    glBindTextureUnit(PEL_UNIT_STRETCHES, s->stretch.name);
    glBindTextureUnit(PEL_UNIT_NEAR, s->near.name);
    glBindTextureUnit(PEL_UNIT_PICTURE, s->picture.name);
    return pel_vertices_bind(s->device, &s->vertices, error);
}

/* A pass over the whole picture that writes colour. */
static bool draw_whole(struct pel_slices3d *s, const struct pel_target *target, const char *fragment, unsigned has, struct pel_error *error)
{
    GLuint program;
    const struct pel_pass pass = { .color_write = true };
    if (!use(s, "whole_vertex.glsl", fragment, has, &program, error))
        return false;
    begin(s, target, &pass);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return pel_device_check(s->device, fragment, error);
}

/* ---- cubes' faces ---- */

/* Faces in the directions of `which`, a range of the list each. */
static void draw_faces(const struct pel_slices3d *s, GLuint program, const struct pel_cube_faces *faces, const size_t first[7], int edge,
                       bool front, bool inflated)
{
    glBindTextureUnit(PEL_UNIT_FACES, faces->texture);
    for (int d = 0; d < 6; d++) {
        size_t count = first[d + 1] - first[d];
        if (!count || !(s->view.faces[front] & 1u << d))
            continue;
        glProgramUniform4i(program, 0, (GLint)first[d], edge, front, inflated);
        glDrawArrays(GL_TRIANGLES, 0, (GLsizei)count * 6);
    }
}

/* Phi_t's faces, moved by some slices. */
static bool draw_phi_t(struct pel_slices3d *s, GLenum func, bool front, float shift, struct pel_error *error)
{
    GLuint program;
    if (!use(s, "cube_vertex.glsl", "cube_fragment.glsl", 0, &program, error))
        return false;
    glDepthFunc(func);
    glProgramUniform4f(program, 1, shift, 0, 0, 0);
    draw_faces(s, program, &s->faces_t, s->phi_t.first, 1 << s->phi_t.level, front, true);
    return true;
}

static float margin(const struct pel_slices3d *s)
{
    return sampling_has(s) & PEL_HAS_PREINTEGRATED ? MARGIN_PREINTEGRATED : MARGIN;
}

/* Front faces of the volume's box: one cube, far larger than the volume and clamped to it. */
static bool draw_box(struct pel_slices3d *s, struct pel_error *error)
{
    static const size_t first[7] = { 0, 1, 2, 3, 4, 5, 6 };
    GLuint program;
    if (!use(s, "cube_vertex.glsl", "cube_fragment.glsl", 0, &program, error))
        return false;
    glDepthFunc(GL_LESS);
    glProgramUniform4f(program, 1, -MARGIN, 0, 0, 0);
    draw_faces(s, program, &s->faces_box, first, 1 << 24, true, true);
    return true;
}

/* ---- z-buffer initialisation ---- */

/* Section 3.1: pseudo early ray-termination. */
static bool init_ert(struct pel_slices3d *s, struct pel_error *error)
{
    GLuint program;
    bool followed = s->options.phi_p == PEL_PHI_P_FOLLOWED;
    if (!s->has_p)
        return true;
    if (!use(s, "cube_vertex.glsl", followed ? "opaque_fragment.glsl" : "cube_fragment.glsl",
             followed ? sampling_has(s) & PEL_HAS_PREINTEGRATED : 0, &program, error))
        return false;
    if (!followed)
        glProgramUniform4f(program, 1, 0, 0, 0, 0);
    glDepthFunc(GL_LESS); /* step 2 */
    pel_gpu_counter_begin(s->device, &s->counters[1]);
    draw_faces(s, program, &s->faces_p, s->phi_p.first, 1 << s->phi_p.level, true, false); /* step 3 */
    pel_gpu_counter_end(&s->counters[1]);
    return true;
}

/* Section 3.3: exit-based leaping, which removes the empty rays, too (3.4). `all_or_nothing`: only that. */
static bool init_ess(struct pel_slices3d *s, bool all_or_nothing, struct pel_error *error)
{
    if (!s->has_t)
        return true;
    if (s->view.eye_inside || all_or_nothing)
        glClearNamedFramebufferfv(s->target.name, GL_DEPTH, 0, &zero); /* 3.4: "zero or the front faces of the volume" */
    else if (!draw_box(s, error))                                      /* step 2 */
        return false;
    pel_gpu_counter_begin(s->device, &s->counters[0]);
    bool ok = draw_phi_t(s, GL_GREATER, false, all_or_nothing ? 1e9f : margin(s), error); /* steps 3 and 4 */
    pel_gpu_counter_end(&s->counters[0]);
    return ok;
}

/* Front faces of phi_t into a z-buffer that begins far away (section 3.2); the eye's own slab has no front face to be seen. */
static bool init_front(struct pel_slices3d *s, const struct pel_target *target, struct pel_error *error)
{
    bool none = s->view.eye_inside || !s->has_t;
    glClearNamedFramebufferfv(target->name, GL_DEPTH, 0, none ? &zero : &one);
    return none || draw_phi_t(s, GL_LESS, true, -margin(s), error);
}

bool pel_slices3d_measure_stretches(struct pel_slices3d *s, enum pel_cull cull, struct pel_error *error)
{
    const struct pel_pass pass = { .depth_func = GL_LESS, .depth_write = true };
    bool band = cull == PEL_CULL_BAND;
    if (band) {
        begin(s, &s->near_target, &pass);
        if (!init_front(s, &s->near_target, error))
            return false;
    }
    return draw_whole(s, &s->stretch_target, "stretch_fragment.glsl", band ? PEL_HAS_BAND : 0, error);
}

/* Slices a group that the eight bits of a stencil buffer tell apart. */
static int group_of(const struct pel_slices3d *s)
{
    return (s->view.count + 254) / 255;
}

/* The second z-buffer for the stencil test. */
static bool init_stencil(struct pel_slices3d *s, struct pel_error *error)
{
    GLuint program;
    const struct pel_pass pass = { .stencil_write = true };
    if (!use(s, "whole_vertex.glsl", "near_fragment.glsl", 0, &program, error))
        return false;
    begin(s, &s->target, &pass);
    glProgramUniform4f(program, 1, (GLfloat)group_of(s), 0, 0, 0);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return true;
}

bool pel_slices3d_init_z(struct pel_slices3d *s, enum pel_cull cull, struct pel_error *error)
{
    const struct pel_pass pass = { .depth_func = GL_LESS, .depth_write = true }; /* step 1: no colour */
    bool ok = cull != PEL_CULL_BAND || !s->stencil || init_stencil(s, error);
    begin(s, &s->target, &pass);
    glClearNamedFramebufferfv(s->target.name, GL_DEPTH, 0, &one);
    if (cull == PEL_CULL_FRONT)
        ok = ok && init_front(s, &s->target, error);
    if (cull == PEL_CULL_ERR || cull == PEL_CULL_ESS || cull == PEL_CULL_ESS_ERT || cull == PEL_CULL_BAND)
        ok = ok && init_ess(s, cull == PEL_CULL_ERR, error);
    if (cull == PEL_CULL_ERT || cull == PEL_CULL_ESS_ERT || cull == PEL_CULL_BAND)
        ok = ok && init_ert(s, error);
    return ok && pel_device_check(s->device, "z-buffer", error);
}

/* ---- slices ---- */

/* Slices first .. first + count - 1 in the order of drawing. */
static void draw_slices(const struct pel_slices3d *s, GLuint program, int first, int count)
{
    bool reverse = s->options.back_to_front;
    glProgramUniform4i(program, 0, reverse ? s->view.count - 1 - first : first, reverse ? -1 : 1, 0, 0);
    glDrawArraysInstanced(GL_TRIANGLE_FAN, 0, 6, count);
}

/* The same, group by group, where a stencil test knows groups. */
static void draw_groups(const struct pel_slices3d *s, GLuint program, bool stencil, int first, int count)
{
    const int last = s->view.count - 1, group = group_of(s);
    if (!stencil) {
        draw_slices(s, program, first, count);
        return;
    }
    for (int i = first, end; i < first + count; i = end) {
        int number = (s->options.back_to_front ? last - i : i) / group;
        for (end = i + 1; end < first + count && (s->options.back_to_front ? last - end : end) / group == number;)
            end++;
        pel_pass_stencil(number);
        draw_slices(s, program, i, end - i);
    }
}

static bool by_stencil(const struct pel_slices3d *s, enum pel_cull cull)
{
    return s->stencil && cull == PEL_CULL_BAND;
}

static void begin_volume(const struct pel_slices3d *s, enum pel_cull cull, bool stops, bool color)
{
    struct pel_pass pass = { .color_write = color, .stencil_test = by_stencil(s, cull) };
    pass.depth_func = cull == PEL_CULL_FRONT ? GL_GREATER : cull == PEL_CULL_NONE && !stops ? 0 : GL_LESS; /* step 2 */
    if (color)
        pass.blending = s->options.back_to_front ? PEL_BLEND_OVER : PEL_BLEND_BEHIND;
    begin(s, &s->target, &pass);
}

/* Full pixels to where no later fragment passes: over a slice's own polygon (section 2), or over the whole picture. */
static void stop_full(struct pel_slices3d *s, GLuint program, bool polygon, int last, bool greater)
{
    const struct pel_pass pass = { .depth_func = greater ? GL_GREATER : GL_LESS, .depth_write = true };
    begin(s, &s->z_target, &pass);
    glUseProgram(program);
    if (polygon)
        draw_slices(s, program, last, 1);
    else
        glDrawArrays(GL_TRIANGLES, 0, 3);
    s->stops++;
}

bool pel_slices3d_draw_slices(struct pel_slices3d *s, enum pel_cull cull, int slab, struct pel_error *error)
{
    static const GLfloat nothing[4] = { 0, 0, 0, 0 };
    bool greater = cull == PEL_CULL_FRONT, stencil = by_stencil(s, cull), polygon = slab == 1;
    unsigned has =
        sampling_has(s) | (cull == PEL_CULL_BAND && !stencil ? PEL_HAS_BAND : 0) | (s->options.early_out ? PEL_HAS_EARLY_OUT : 0);
    GLuint stop = 0, program;
    if (slab &&
        !use(s, polygon ? "slice_vertex.glsl" : "whole_vertex.glsl", "stop_fragment.glsl", greater ? PEL_HAS_GREATER : 0, &stop, error))
        return false;
    if (!use(s, "slice_vertex.glsl", "slice_fragment.glsl", has, &program, error)) /* step 3 */
        return false;
    begin_volume(s, cull, slab > 0, true); /* step 1 */
    glClearNamedFramebufferfv(s->target.name, GL_COLOR, 0, nothing);
    int part = slab ? slab : s->view.count;
    s->stops = 0;
    pel_gpu_counter_begin(s->device, &s->counters[2]);
    for (int first = 0; first < s->view.count; first += part) {
        int count = first + part < s->view.count ? part : s->view.count - first;
        draw_groups(s, program, stencil, first, count); /* step 4 */
        if (first + count == s->view.count)
            break;
        stop_full(s, stop, polygon, first + count - 1, greater);
        begin_volume(s, cull, true, true);
        glUseProgram(program);
    }
    pel_gpu_counter_end(&s->counters[2]);
    return pel_device_check(s->device, "slices", error);
}

bool pel_slices3d_count(struct pel_slices3d *s, enum pel_cull cull, struct pel_gpu_counter *counter, struct pel_error *error)
{
    GLuint program;
    if (!use(s, "slice_vertex.glsl", "plain_fragment.glsl", cull == PEL_CULL_BAND && !by_stencil(s, cull) ? PEL_HAS_BAND : 0, &program,
             error))
        return false;
    begin_volume(s, cull, false, false);
    pel_gpu_counter_begin(s->device, counter);
    draw_groups(s, program, by_stencil(s, cull), 0, s->view.count);
    pel_gpu_counter_end(counter);
    return pel_device_check(s->device, "counting", error);
}

bool pel_slices3d_count_faces(struct pel_slices3d *s, bool p, struct pel_gpu_counter *counter, struct pel_error *error)
{
    GLuint program;
    const struct pel_pass pass = { .depth_func = 0 };
    const struct pel_cube_set *set = p ? &s->phi_p : &s->phi_t;
    if (!use(s, "cube_vertex.glsl", "cube_fragment.glsl", 0, &program, error))
        return false;
    begin(s, &s->target, &pass);
    pel_gpu_counter_begin(s->device, counter);
    if (p ? s->has_p : s->has_t)
        draw_faces(s, program, p ? &s->faces_p : &s->faces_t, set->first, 1 << set->level, p, !p);
    pel_gpu_counter_end(counter);
    return pel_device_check(s->device, "counting faces", error);
}

/* ---- after the slices ---- */

bool pel_slices3d_find_depth(struct pel_slices3d *s, struct pel_error *error)
{
    return draw_whole(s, &s->depth_target, "half_fragment.glsl", sampling_has(s), error);
}

bool pel_slices3d_to_display(struct pel_slices3d *s, struct pel_error *error)
{
    return draw_whole(s, &s->finished_target, "finish_fragment.glsl", 0, error);
}

bool pel_slices3d_show(struct pel_slices3d *s, struct pel_error *error)
{
    enum pel_show show = s->options.show;
    if (show == PEL_SHOW_DEPTH || show == PEL_SHOW_NEAR) {
        glBindTextureUnit(PEL_UNIT_PICTURE, show == PEL_SHOW_DEPTH ? s->z.name : s->near.name);
        return draw_whole(s, &s->finished_target, "show_fragment.glsl", 0, error);
    }
    bool t = show == PEL_SHOW_PHI_T, there = t ? s->has_t : s->has_p;
    static const GLfloat nothing[4] = { 0, 0, 0, 0 };
    const struct pel_pass pass = { .depth_func = t ? GL_GREATER : GL_LESS, .depth_write = true, .color_write = true };
    GLuint program;
    if (!use(s, "cube_vertex.glsl", "cube_fragment.glsl", PEL_HAS_SHOW, &program, error))
        return false;
    begin(s, &s->target, &pass);
    glClearNamedFramebufferfv(s->target.name, GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(s->target.name, GL_DEPTH, 0, t ? &zero : &one);
    if (t)
        glProgramUniform4f(program, 1, 0, 0.55f, 0.7f, 1);
    else
        glProgramUniform4f(program, 1, 0, 1, 0.6f, 0.5f);
    if (there && t)
        draw_faces(s, program, &s->faces_t, s->phi_t.first, 1 << s->phi_t.level, false, true);
    else if (there)
        draw_faces(s, program, &s->faces_p, s->phi_p.first, 1 << s->phi_p.level, true, false);
    return pel_device_check(s->device, "cubes", error);
}
