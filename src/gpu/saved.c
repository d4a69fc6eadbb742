/* SPDX-License-Identifier: MIT */
/* A host program's state, kept through our passes: what they bind, and what would mislead them. Some 350 queries, which no driver sends to
 * the GPU. */
#include "device_gl.h"

/* All that a unit has: binding nothing to a unit empties every one. */
static const struct {
    GLenum target, binding;
} targets[PEL_SAVED_TARGETS] = {
    { GL_TEXTURE_1D, GL_TEXTURE_BINDING_1D },
    { GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D },
    { GL_TEXTURE_3D, GL_TEXTURE_BINDING_3D },
    { GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY },
    { GL_TEXTURE_BUFFER, GL_TEXTURE_BINDING_BUFFER },
    { GL_TEXTURE_RECTANGLE, GL_TEXTURE_BINDING_RECTANGLE },
    { GL_TEXTURE_CUBE_MAP, GL_TEXTURE_BINDING_CUBE_MAP },
    { GL_TEXTURE_1D_ARRAY, GL_TEXTURE_BINDING_1D_ARRAY },
    { GL_TEXTURE_CUBE_MAP_ARRAY, GL_TEXTURE_BINDING_CUBE_MAP_ARRAY },
    { GL_TEXTURE_2D_MULTISAMPLE, GL_TEXTURE_BINDING_2D_MULTISAMPLE },
    { GL_TEXTURE_2D_MULTISAMPLE_ARRAY, GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY },
};

static const struct {
    GLenum name;
    GLint ours;
} stores[PEL_SAVED_STORES] = {
    { GL_UNPACK_ALIGNMENT, 1 }, { GL_UNPACK_ROW_LENGTH, 0 },  { GL_UNPACK_IMAGE_HEIGHT, 0 }, { GL_UNPACK_SKIP_PIXELS, 0 },
    { GL_UNPACK_SKIP_ROWS, 0 }, { GL_UNPACK_SKIP_IMAGES, 0 }, { GL_UNPACK_SWAP_BYTES, 0 },   { GL_UNPACK_LSB_FIRST, 0 },
    { GL_PACK_ALIGNMENT, 1 },   { GL_PACK_ROW_LENGTH, 0 },    { GL_PACK_IMAGE_HEIGHT, 0 },   { GL_PACK_SKIP_PIXELS, 0 },
    { GL_PACK_SKIP_ROWS, 0 },   { GL_PACK_SKIP_IMAGES, 0 },   { GL_PACK_SWAP_BYTES, 0 },     { GL_PACK_LSB_FIRST, 0 },
};

/* How many of `count` bindings the driver has. */
static int have(GLenum limit, int count)
{
    GLint most = 0;
    glGetIntegerv(limit, &most);
    return most < count ? most : count;
}

static void save_ranges(struct pel_gl_saved_range *ranges, int count, GLenum name, GLenum start, GLenum size)
{
    for (int i = 0; i < count; i++) {
        glGetIntegeri_v(name, (GLuint)i, &ranges[i].name);
        glGetInteger64i_v(start, (GLuint)i, &ranges[i].start);
        glGetInteger64i_v(size, (GLuint)i, &ranges[i].size);
    }
}

static void restore_ranges(const struct pel_gl_saved_range *ranges, int count, GLenum target)
{
    for (int i = 0; i < count; i++) {
        if (ranges[i].name && ranges[i].size > 0)
            glBindBufferRange(target, (GLuint)i, (GLuint)ranges[i].name, (GLintptr)ranges[i].start, (GLsizeiptr)ranges[i].size);
        else
            glBindBufferBase(target, (GLuint)i, (GLuint)ranges[i].name);
    }
}

static void save_textures(struct pel_gl_saved *saved)
{
    for (int unit = 0; unit < PEL_SAVED_UNITS; unit++) {
        glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
        for (int t = 0; t < PEL_SAVED_TARGETS; t++)
            glGetIntegerv(targets[t].binding, &saved->textures[unit][t]);
        glGetIntegerv(GL_SAMPLER_BINDING, &saved->samplers[unit]);
        glBindSampler((GLuint)unit, 0);
    }
    int images = have(GL_MAX_IMAGE_UNITS, PEL_SAVED_IMAGES);
    for (int i = 0; i < images; i++) {
        glGetIntegeri_v(GL_IMAGE_BINDING_NAME, (GLuint)i, &saved->images[i].name);
        glGetIntegeri_v(GL_IMAGE_BINDING_LEVEL, (GLuint)i, &saved->images[i].level);
        glGetIntegeri_v(GL_IMAGE_BINDING_LAYERED, (GLuint)i, &saved->images[i].layered);
        glGetIntegeri_v(GL_IMAGE_BINDING_LAYER, (GLuint)i, &saved->images[i].layer);
        glGetIntegeri_v(GL_IMAGE_BINDING_ACCESS, (GLuint)i, &saved->images[i].access);
        glGetIntegeri_v(GL_IMAGE_BINDING_FORMAT, (GLuint)i, &saved->images[i].format);
    }
}

static void restore_textures(const struct pel_gl_saved *saved)
{
    for (int unit = 0; unit < PEL_SAVED_UNITS; unit++) {
        glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
        for (int t = 0; t < PEL_SAVED_TARGETS; t++)
            glBindTexture(targets[t].target, (GLuint)saved->textures[unit][t]);
        glBindSampler((GLuint)unit, (GLuint)saved->samplers[unit]);
    }
    int images = have(GL_MAX_IMAGE_UNITS, PEL_SAVED_IMAGES);
    for (int i = 0; i < images; i++)
        glBindImageTexture((GLuint)i, (GLuint)saved->images[i].name, saved->images[i].level, saved->images[i].layered != 0,
                           saved->images[i].layer, (GLenum)saved->images[i].access, (GLenum)saved->images[i].format);
}

/* All are off while we draw, or we set them ourselves. */
static const GLenum switches[] = {
    GL_DEPTH_TEST,           GL_CULL_FACE,           GL_STENCIL_TEST,        GL_COLOR_LOGIC_OP,     GL_DEPTH_CLAMP,
    GL_RASTERIZER_DISCARD,   GL_FRAMEBUFFER_SRGB,    GL_POLYGON_OFFSET_FILL, GL_POLYGON_SMOOTH,     GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_ALPHA_TO_ONE,  GL_SAMPLE_COVERAGE,     GL_SAMPLE_MASK,         GL_CLIP_DISTANCE0,     GL_CLIP_DISTANCE0 + 1,
    GL_CLIP_DISTANCE0 + 2,   GL_CLIP_DISTANCE0 + 3,  GL_CLIP_DISTANCE0 + 4,  GL_CLIP_DISTANCE0 + 5, GL_CLIP_DISTANCE0 + 6,
    GL_CLIP_DISTANCE0 + 7,   GL_DEPTH_BOUNDS_TEST_EXT,
};
_Static_assert(sizeof switches / sizeof *switches == PEL_SAVED_SWITCHES, "a switch more or less");

static bool has_switch(int i)
{
    return switches[i] != GL_DEPTH_BOUNDS_TEST_EXT || epoxy_has_gl_extension("GL_EXT_depth_bounds_test");
}

static void set_switch(GLenum what, bool on)
{
    if (on)
        glEnable(what);
    else
        glDisable(what);
}

static void save_colors(struct pel_gl_saved_drawing *d)
{
    for (GLuint i = 0; i < (GLuint)have(GL_MAX_DRAW_BUFFERS, PEL_SAVED_COLORS); i++) {
        d->colors[i].blend = glIsEnabledi(GL_BLEND, i);
        glGetIntegeri_v(GL_BLEND_SRC_RGB, i, &d->colors[i].source);
        glGetIntegeri_v(GL_BLEND_DST_RGB, i, &d->colors[i].target);
        glGetIntegeri_v(GL_BLEND_SRC_ALPHA, i, &d->colors[i].alpha_source);
        glGetIntegeri_v(GL_BLEND_DST_ALPHA, i, &d->colors[i].alpha_target);
        glGetIntegeri_v(GL_BLEND_EQUATION_RGB, i, &d->colors[i].equation);
        glGetIntegeri_v(GL_BLEND_EQUATION_ALPHA, i, &d->colors[i].alpha_equation);
        glGetBooleani_v(GL_COLOR_WRITEMASK, i, d->colors[i].mask);
    }
}

static void restore_colors(const struct pel_gl_saved_drawing *d)
{
    for (GLuint i = 0; i < (GLuint)have(GL_MAX_DRAW_BUFFERS, PEL_SAVED_COLORS); i++) {
        const GLboolean *mask = d->colors[i].mask;
        if (d->colors[i].blend)
            glEnablei(GL_BLEND, i);
        else
            glDisablei(GL_BLEND, i);
        glBlendFuncSeparatei(i, (GLenum)d->colors[i].source, (GLenum)d->colors[i].target, (GLenum)d->colors[i].alpha_source,
                             (GLenum)d->colors[i].alpha_target);
        glBlendEquationSeparatei(i, (GLenum)d->colors[i].equation, (GLenum)d->colors[i].alpha_equation);
        glColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
    }
}

static const GLenum stencil_names[2][7] = {
    { GL_STENCIL_FUNC, GL_STENCIL_REF, GL_STENCIL_VALUE_MASK, GL_STENCIL_WRITEMASK, GL_STENCIL_FAIL, GL_STENCIL_PASS_DEPTH_FAIL,
      GL_STENCIL_PASS_DEPTH_PASS },
    { GL_STENCIL_BACK_FUNC, GL_STENCIL_BACK_REF, GL_STENCIL_BACK_VALUE_MASK, GL_STENCIL_BACK_WRITEMASK, GL_STENCIL_BACK_FAIL,
      GL_STENCIL_BACK_PASS_DEPTH_FAIL, GL_STENCIL_BACK_PASS_DEPTH_PASS },
};

static void save_stencil(struct pel_gl_saved_drawing *d)
{
    for (int side = 0; side < 2; side++) {
        GLint *to[7] = { &d->stencil[side].func, &d->stencil[side].reference, &d->stencil[side].value_mask, &d->stencil[side].write_mask,
                         &d->stencil[side].fail, &d->stencil[side].depth_fail, &d->stencil[side].pass };
        for (int i = 0; i < 7; i++)
            glGetIntegerv(stencil_names[side][i], to[i]);
    }
}

static void restore_stencil(const struct pel_gl_saved_drawing *d)
{
    for (int side = 0; side < 2; side++) {
        GLenum face = side ? GL_BACK : GL_FRONT;
        glStencilFuncSeparate(face, (GLenum)d->stencil[side].func, d->stencil[side].reference, (GLuint)d->stencil[side].value_mask);
        glStencilOpSeparate(face, (GLenum)d->stencil[side].fail, (GLenum)d->stencil[side].depth_fail, (GLenum)d->stencil[side].pass);
        glStencilMaskSeparate(face, (GLuint)d->stencil[side].write_mask);
    }
}

static void save_drawing(struct pel_gl_saved_drawing *d)
{
    for (int i = 0; i < PEL_SAVED_SWITCHES; i++)
        if (has_switch(i)) {
            d->switches[i] = glIsEnabled(switches[i]);
            glDisable(switches[i]);
        }
    d->scissor = glIsEnabledi(GL_SCISSOR_TEST, 0);
    glDisablei(GL_SCISSOR_TEST, 0);
    glGetIntegerv(GL_LOGIC_OP_MODE, &d->logic_op);
    glGetIntegerv(GL_DEPTH_FUNC, &d->depth_func);
    glGetIntegerv(GL_CULL_FACE_MODE, &d->cull_face);
    glGetIntegerv(GL_FRONT_FACE, &d->front_face);
    glGetIntegerv(GL_POLYGON_MODE, d->polygon_mode);
    glGetIntegerv(GL_CLIP_ORIGIN, &d->clip_origin);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &d->clip_depth);
    glGetBooleanv(GL_DEPTH_WRITEMASK, &d->depth_mask);
    glGetFloati_v(GL_DEPTH_RANGE, 0, d->depth_range);
    glGetFloati_v(GL_VIEWPORT, 0, d->viewport);
    save_colors(d);
    save_stencil(d);
    glFrontFace(GL_CCW);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glDepthRangeIndexed(0, 0, 1);
}

static void restore_drawing(const struct pel_gl_saved_drawing *d)
{
    for (int i = 0; i < PEL_SAVED_SWITCHES; i++)
        if (has_switch(i))
            set_switch(switches[i], d->switches[i]);
    if (d->scissor)
        glEnablei(GL_SCISSOR_TEST, 0);
    else
        glDisablei(GL_SCISSOR_TEST, 0);
    glLogicOp((GLenum)d->logic_op);
    glDepthFunc((GLenum)d->depth_func);
    glCullFace((GLenum)d->cull_face);
    glFrontFace((GLenum)d->front_face);
    glPolygonMode(GL_FRONT_AND_BACK, (GLenum)d->polygon_mode[0]);
    glClipControl((GLenum)d->clip_origin, (GLenum)d->clip_depth);
    glDepthMask(d->depth_mask);
    glDepthRangeIndexed(0, (GLdouble)d->depth_range[0], (GLdouble)d->depth_range[1]);
    glViewportIndexedf(0, d->viewport[0], d->viewport[1], d->viewport[2], d->viewport[3]);
    restore_colors(d);
    restore_stencil(d);
}

void pel_gl_save(struct pel_gl_saved *saved)
{
    *saved = (struct pel_gl_saved){ 0 };
    glGetIntegerv(GL_CURRENT_PROGRAM, &saved->program);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &saved->active_texture);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &saved->vertex_array);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &saved->draw_framebuffer);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &saved->read_framebuffer);
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &saved->pack_buffer);
    glGetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &saved->unpack_buffer);
    glGetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &saved->storage_buffer);
    glGetIntegerv(GL_UNIFORM_BUFFER_BINDING, &saved->uniform_buffer);
    glGetIntegerv(GL_DISPATCH_INDIRECT_BUFFER_BINDING, &saved->dispatch_buffer);
    save_ranges(saved->storage, have(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, PEL_SAVED_BUFFERS), GL_SHADER_STORAGE_BUFFER_BINDING,
                GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE);
    save_ranges(saved->uniform, PEL_SAVED_BUFFERS, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE);
    save_textures(saved);
    for (int i = 0; i < PEL_SAVED_STORES; i++) {
        glGetIntegerv(stores[i].name, &saved->stores[i]);
        glPixelStorei(stores[i].name, stores[i].ours);
    }
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    save_drawing(&saved->drawing);
}

void pel_gl_restore(const struct pel_gl_saved *saved)
{
    for (int i = 0; i < PEL_SAVED_STORES; i++)
        glPixelStorei(stores[i].name, saved->stores[i]);
    restore_textures(saved);
    restore_ranges(saved->storage, have(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, PEL_SAVED_BUFFERS), GL_SHADER_STORAGE_BUFFER);
    restore_ranges(saved->uniform, PEL_SAVED_BUFFERS, GL_UNIFORM_BUFFER);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, (GLuint)saved->dispatch_buffer);
    glBindBuffer(GL_UNIFORM_BUFFER, (GLuint)saved->uniform_buffer);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, (GLuint)saved->storage_buffer);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, (GLuint)saved->pack_buffer);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, (GLuint)saved->unpack_buffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)saved->draw_framebuffer);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)saved->read_framebuffer);
    restore_drawing(&saved->drawing);
    glBindVertexArray((GLuint)saved->vertex_array);
    glActiveTexture((GLenum)saved->active_texture);
    glUseProgram((GLuint)saved->program);
}
