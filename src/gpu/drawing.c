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
    glNamedFramebufferTexture(target->name, GL_DEPTH_ATTACHMENT, depth_name, 0);
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
    glDeleteFramebuffers(1, &target->name);
    device->objects--;
    *target = (struct pel_target){ 0 };
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
    set(GL_CULL_FACE, pass->cull != 0);
    if (pass->cull)
        glCullFace(pass->cull);
}

void pel_pass_begin(const struct pel_target *target, const struct pel_pass *pass, int width, int height)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target->name);
    glViewportIndexedf(0, 0, 0, (GLfloat)width, (GLfloat)height);
    set_state(pass);
}

void pel_pass_defaults(void)
{
    const struct pel_pass pass = { .depth_write = true, .color_write = true };
    set_state(&pass);
    glBlendFunc(GL_ONE, GL_ZERO);
    glDepthFunc(GL_LESS);
    glCullFace(GL_BACK);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBindVertexArray(0);
}

bool pel_instances_bind(struct pel_device *device, struct pel_instances *instances, const struct pel_buffer *pairs, struct pel_error *error)
{
    if (!instances->name) {
        glCreateVertexArrays(1, &instances->name);
        if (!instances->name)
            return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more vertex arrays");
        device->objects++;
    }
    GLuint array = instances->name;
    if (pairs) {
        glVertexArrayVertexBuffer(array, 0, pairs->name, 0, 2 * sizeof(GLuint));
        glVertexArrayAttribIFormat(array, 0, 2, GL_UNSIGNED_INT, 0);
        glVertexArrayAttribBinding(array, 0, 0);
        glVertexArrayBindingDivisor(array, 0, 1);
        glEnableVertexArrayAttrib(array, 0);
    } else {
        glDisableVertexArrayAttrib(array, 0);
    }
    glBindVertexArray(array);
    return pel_device_check(device, "vertex array", error);
}

void pel_instances_destroy(struct pel_device *device, struct pel_instances *instances)
{
    if (!instances->name)
        return;
    glDeleteVertexArrays(1, &instances->name);
    device->objects--;
    instances->name = 0;
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
    glDeleteQueries(1, &counter->query);
    device->objects--;
    counter->query = 0;
}
