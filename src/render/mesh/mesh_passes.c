/* SPDX-License-Identifier: MIT */
/* The passes of a frame. What is opaque goes through a z-buffer. What is translucent and not hidden by it is gathered in a list a pixel,
 * each list then composited in order: one pass over the triangles whatever the number of layers, where depth peeling takes one a layer. */
#include <string.h>

#include "fail.h"
#include "gpu_volume.h"
#include "mesh_render.h"

enum { BINDING_HEADS = 0, BINDING_LINKS = 1, BINDING_NODES = 7 };
enum { LIST_HEADER = 4 }; /* words before the heads */
enum { LINK_BYTES = 2 * sizeof(uint32_t), NODE_BYTES = 4 * sizeof(float) };

static bool is_opaque(const struct pel_mesh_renderer *m, int surface)
{
    return m->job.iso_opacity[surface] >= 1;
}

static bool any_translucent(const struct pel_mesh_renderer *m)
{
    for (int i = 0; i < m->job.iso_count; i++)
        if (!is_opaque(m, i) && m->surfaces[i].element_count)
            return true;
    return false;
}

/* `vertex` NULL: a program that computes. */
static bool use(struct pel_mesh_renderer *m, const char *vertex, const char *file, bool list, GLuint *program, struct pel_error *error)
{
    char defines[64] = "";
    if (m->job.headlight_only)
        strcat(defines, "#define HEADLIGHTS\n");
    if (list)
        strcat(defines, "#define LIST\n");
    *program = vertex ? pel_programs_find_drawing(m->device, &m->programs, vertex, file, defines, error)
                      : pel_programs_find(m->device, &m->programs, file, defines, error);
    if (*program)
        glUseProgram(*program);
    return *program != 0;
}

static void begin(const struct pel_mesh_renderer *m, const struct pel_target *target, const struct pel_pass *pass)
{
    pel_pass_begin(target, pass, m->job.width, m->job.height);
}

/* Computes something for each pixel, into a texture. */
static bool compute_whole(struct pel_mesh_renderer *m, const char *file, const struct pel_texture *to, bool list, struct pel_error *error)
{
    enum { GROUP = 8 };
    GLuint program;
    if (!use(m, NULL, file, list, &program, error))
        return false;
    glBindImageTexture(0, to->name, 0, GL_FALSE, 0, GL_READ_WRITE, to->format);
    glDispatchCompute((GLuint)(m->job.width - 1) / GROUP + 1, (GLuint)(m->job.height - 1) / GROUP + 1, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
    return pel_device_check(m->device, file, error);
}

/* The triangles of all surfaces that are opaque, or of all that are not. */
static void draw_surfaces(const struct pel_mesh_renderer *m, GLuint program, bool opaque)
{
    const size_t most = 3 << 28; /* elements a call */
    for (int i = 0; i < m->job.iso_count; i++) {
        const struct pel_mesh_surface *s = &m->surfaces[i];
        if (is_opaque(m, i) != opaque || !s->element_count)
            continue;
        glBindVertexArray(s->array);
        glProgramUniform1i(program, 0, i);
        for (size_t done = 0; done < s->element_count; done += most) {
            size_t count = s->element_count - done < most ? s->element_count - done : most;
            glDrawElementsBaseVertex(GL_TRIANGLES, (GLsizei)count, GL_UNSIGNED_INT, (const char *)NULL + done * sizeof(GLuint), s->base);
        }
    }
}

bool pel_mesh_draw_opaque(struct pel_mesh_renderer *m, struct pel_error *error)
{
    static const GLfloat nothing[4] = { 0, 0, 0, 0 };
    const struct pel_pass pass = { .depth_func = GL_GREATER, .depth_write = true, .color_write = true };
    GLuint program;
    if (!use(m, "mesh_vertex.glsl", "mesh_fragment.glsl", false, &program, error))
        return false;
    begin(m, &m->surface_target, &pass);
    glClearNamedFramebufferfv(m->surface_target.name, GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(m->surface_target.name, GL_DEPTH, 0, nothing); /* 0 is infinitely far */
    draw_surfaces(m, program, true);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    return pel_device_check(m->device, "opaque surfaces", error);
}

/* ---- lists ---- */

bool pel_mesh_reserve_lists(struct pel_mesh_renderer *m, uint64_t fragments, struct pel_error *error)
{
    const uint64_t others = pel_mesh_held(m) - m->links.bytes - m->nodes.bytes;
    if (fragments > UINT32_MAX - 1)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "%llu translucent fragments are more than are counted; draw a smaller picture",
                        (unsigned long long)fragments);
    if (!pel_gpu_check_room(m->device, others + fragments * LINK_BYTES, fragments * NODE_BYTES, "lists of translucent fragments",
                            "draw a smaller picture", error))
        return false;
    m->view.room[0] = 0; /* until there is */
    if (!pel_buffer_fill(m->device, &m->links, NULL, (size_t)fragments * LINK_BYTES, error) ||
        !pel_buffer_fill(m->device, &m->nodes, NULL, (size_t)fragments * NODE_BYTES, error))
        return false;
    m->view.room[0] = (uint32_t)fragments;
    return pel_buffer_fill(m->device, &m->mesh_block, &m->view, sizeof m->view, error);
}

static void bind_lists(const struct pel_mesh_renderer *m)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, m->mesh_block.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_HEADS, m->heads.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_LINKS, m->links.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_NODES, m->nodes.name);
}

/* Two fragments a pixel, where there is room for them. */
static uint64_t first_guess(const struct pel_mesh_renderer *m)
{
    const uint64_t limit = m->device->params.memory_limit, held = pel_mesh_held(m) - m->links.bytes - m->nodes.bytes,
                   pixels = (uint64_t)m->job.width * (uint64_t)m->job.height,
                   room = limit ? limit > held ? (limit - held) / (LINK_BYTES + NODE_BYTES) : 0 : UINT32_MAX,
                   most = m->device->info.max_storage_buffer_bytes / NODE_BYTES, least = room < most ? room : most;
    return 2 * pixels < least ? 2 * pixels : least ? least : 1;
}

/* Once, or where the lists turn out to be too small, twice. */
static bool gather(struct pel_mesh_renderer *m, struct pel_error *error)
{
    const struct pel_pass pass = { .depth_func = GL_GREATER };
    const uint32_t end = ~0u, none = 0;
    GLuint program;
    for (int round = 0;; round++) {
        if (!use(m, "mesh_vertex.glsl", "mesh_fragment.glsl", true, &program, error))
            return false;
        bind_lists(m);
        glClearNamedBufferData(m->heads.name, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &end);
        glNamedBufferSubData(m->heads.name, 0, sizeof none, &none);
        begin(m, &m->surface_target, &pass);
        draw_surfaces(m, program, false);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(m->heads.name, 0, sizeof m->listed, &m->listed);
        if (!pel_device_check(m->device, "translucent surfaces", error))
            return false;
        if (m->listed <= m->view.room[0])
            return true;
        if (round || !pel_mesh_reserve_lists(m, m->listed + (m->device->params.memory_limit ? 0 : (uint64_t)m->listed / 8), error))
            return round ? pel_fail(error, PEL_ERROR_UNSUPPORTED, "the GPU drew two different pictures of one view") : false;
    }
}

bool pel_mesh_draw_translucent(struct pel_mesh_renderer *m, struct pel_error *error)
{
    m->listed = 0;
    if (!any_translucent(m))
        return true;
    const size_t pixels = (size_t)m->job.width * (size_t)m->job.height;
    if (!pel_buffer_fill(m->device, &m->heads, NULL, (LIST_HEADER + pixels) * sizeof(uint32_t), error) ||
        (!m->view.room[0] && !pel_mesh_reserve_lists(m, first_guess(m), error)) || !gather(m, error))
        return false;
    return compute_whole(m, "mesh_resolve.glsl", &m->picture, true, error);
}

/* ---- after the surfaces ---- */

bool pel_mesh_find_depth(struct pel_mesh_renderer *m, struct pel_error *error)
{
    glBindTextureUnit(PEL_UNIT_PICTURE, m->z.name);
    return compute_whole(m, "mesh_depth.glsl", &m->depth, any_translucent(m), error);
}

bool pel_mesh_to_display(struct pel_mesh_renderer *m, struct pel_error *error)
{
    const struct pel_pass pass = { .color_write = true };
    GLuint program;
    if (!use(m, "whole_vertex.glsl", "finish_fragment.glsl", false, &program, error) || !pel_vertices_bind(m->device, &m->whole, error))
        return false;
    glBindTextureUnit(PEL_UNIT_PICTURE, m->picture.name);
    begin(m, &m->finished_target, &pass);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return pel_device_check(m->device, "display values", error);
}
