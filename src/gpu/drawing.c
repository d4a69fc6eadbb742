/* SPDX-License-Identifier: MIT */
#include "drawing.h"

#include "fail.h"

bool pel_target_set(struct pel_device *device, struct pel_target *target, const struct pel_texture *color, const struct pel_texture *depth,
                    struct pel_error *error)
{
    if (!target->name) {
        glCreateFramebuffers(1, &target->name);
        if (!target->name)
            return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more framebuffers");
        device->objects++;
    }
    GLuint color_name = color ? color->name : 0, depth_name = depth ? depth->name : 0;
    glNamedFramebufferTexture(target->name, GL_COLOR_ATTACHMENT0, color_name, 0);
    bool stencil = depth && depth->format == GL_DEPTH24_STENCIL8;
    glNamedFramebufferTexture(target->name, GL_DEPTH_STENCIL_ATTACHMENT, 0, 0);
    glNamedFramebufferTexture(target->name, stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT, depth_name, 0);
    glNamedFramebufferDrawBuffer(target->name, color_name ? GL_COLOR_ATTACHMENT0 : GL_NONE);
    GLenum status = glCheckNamedFramebufferStatus(target->name, GL_DRAW_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE)
        return pel_device_check(device, "target", error);
    return pel_device_check(device, "target", error) &&
           pel_fail(error, PEL_ERROR_UNSUPPORTED, "the driver cannot draw to such a target (0x%x)", status);
}

void pel_target_destroy(struct pel_device *device, struct pel_target *target)
{
    if (!target->name)
        return;
    if (pel_device_is_current(device))
        glDeleteFramebuffers(1, &target->name);
    device->objects--;
    *target = (struct pel_target) { 0 };
}

static void set(GLenum what, bool on)
{
    if (on)
        glEnable(what);
    else
        glDisable(what);
}

static void set_state(const struct pel_pass *pass)
{
    set(GL_DEPTH_TEST, pass->depth_func != 0);
    if (pass->depth_func)
        glDepthFunc(pass->depth_func);
    glDepthMask(pass->depth_write);
    GLboolean color = pass->color_write;
    glColorMask(color, color, color, color);
    set(GL_BLEND, pass->blending != PEL_BLEND_NONE);
    glBlendEquation(GL_FUNC_ADD);
    if (pass->blending == PEL_BLEND_BEHIND)
        glBlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    else if (pass->blending == PEL_BLEND_OVER)
        glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    set(GL_COLOR_LOGIC_OP, pass->logic_or);
    glLogicOp(pass->logic_or ? GL_OR : GL_COPY);
    set(GL_STENCIL_TEST, pass->stencil_write || pass->stencil_test);
    glStencilMask(pass->stencil_write ? 0xff : 0);
    glStencilFunc(pass->stencil_test ? GL_GEQUAL : GL_ALWAYS, 0, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, pass->stencil_write ? GL_REPLACE : GL_KEEP);
}

void pel_pass_begin(const struct pel_target *target, const struct pel_pass *pass, int width, int height)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target->name);
    glViewportIndexedf(0, 0, 0, (GLfloat)width, (GLfloat)height);
    set_state(pass);
}

void pel_pass_stencil(int reference)
{
    glStencilFunc(GL_GEQUAL, reference, 0xff);
}

void pel_pass_defaults(void)
{
    const struct pel_pass pass = { .depth_write = true, .color_write = true };
    set_state(&pass);
    glBlendFunc(GL_ONE, GL_ZERO);
    glDepthFunc(GL_LESS);
    glStencilMask(~0u);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBindVertexArray(0);
}

bool pel_vertices_bind(struct pel_device *device, struct pel_vertices *vertices, struct pel_error *error)
{
    if (!vertices->name) {
        glCreateVertexArrays(1, &vertices->name);
        if (!vertices->name)
            return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more vertex arrays");
        device->objects++;
    }
    glBindVertexArray(vertices->name);
    return true;
}

bool pel_vertices_bind_buffer(struct pel_device *device, struct pel_vertices *vertices, enum pel_vertices_kind kind,
                              const struct pel_buffer *buffer, struct pel_error *error)
{
    const bool pairs = kind == PEL_VERTICES_PAIRS;
    if (!pel_vertices_bind(device, vertices, error))
        return false;
    glVertexArrayVertexBuffer(vertices->name, 0, buffer->name, 0, pairs ? 2 * sizeof(GLuint) : 4 * sizeof(GLfloat));
    if (pairs)
        glVertexArrayAttribIFormat(vertices->name, 0, 2, GL_UNSIGNED_INT, 0);
    else
        glVertexArrayAttribFormat(vertices->name, 0, 4, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vertices->name, 0, 0);
    glVertexArrayBindingDivisor(vertices->name, 0, pairs);
    glEnableVertexArrayAttrib(vertices->name, 0);
    return pel_device_check(device, "vertex array", error);
}

void pel_vertices_destroy(struct pel_device *device, struct pel_vertices *vertices)
{
    if (!vertices->name)
        return;
    if (pel_device_is_current(device))
        glDeleteVertexArrays(1, &vertices->name);
    device->objects--;
    vertices->name = 0;
}

bool pel_pairs_texture(struct pel_device *device, GLuint *texture, const struct pel_buffer *pairs, struct pel_error *error)
{
    if (!*texture) {
        glCreateTextures(GL_TEXTURE_BUFFER, 1, texture);
        if (!*texture)
            return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more textures");
        device->objects++;
    }
    glTextureBuffer(*texture, GL_RG32UI, pairs->name);
    return pel_device_check(device, "buffer texture", error);
}

void pel_pairs_texture_destroy(struct pel_device *device, GLuint *texture)
{
    if (!*texture)
        return;
    if (pel_device_is_current(device))
        glDeleteTextures(1, texture);
    device->objects--;
    *texture = 0;
}

size_t pel_pairs_limit(void)
{
    GLint limit = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    return (size_t)limit;
}

void pel_gpu_counter_begin(struct pel_device *device, struct pel_gpu_counter *counter)
{
    if (!counter->query) {
        glCreateQueries(GL_SAMPLES_PASSED, 1, &counter->query);
        device->objects++;
    }
    glBeginQuery(GL_SAMPLES_PASSED, counter->query);
}

void pel_gpu_counter_end(struct pel_gpu_counter *counter)
{
    (void)counter;
    glEndQuery(GL_SAMPLES_PASSED);
}

uint64_t pel_gpu_counter_value(struct pel_gpu_counter *counter)
{
    GLuint64 count = 0;
    if (counter->query)
        glGetQueryObjectui64v(counter->query, GL_QUERY_RESULT, &count);
    return count;
}

void pel_gpu_counter_destroy(struct pel_device *device, struct pel_gpu_counter *counter)
{
    if (!counter->query)
        return;
    if (pel_device_is_current(device))
        glDeleteQueries(1, &counter->query);
    device->objects--;
    counter->query = 0;
}
