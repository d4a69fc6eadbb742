/* SPDX-License-Identifier: MIT */
/* From isovalues to triangles on the device. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "mesh_extract.h"
#include "mesh_render.h"
#include "parallel.h"
#include "timer.h"
#include "vec.h"

/* A vertex as the shaders have it: index space. */
struct vertex {
    float place[3], gradient[3];
};

struct conversion {
    const struct pel_mesh *mesh;
    struct vertex *to;
    double to_index[3][3], to_world[3][3];
    size_t slabs;
};

/* Which surface of the scene is job.iso[i]: the job has them by rising value. */
static void order_of(const struct pel_mesh_renderer *m, const struct pel_scene *scene, int order[PEL_MAX_ISOSURFACES])
{
    const struct pel_raw_scale raw = m->format.raw;
    for (int i = 0; i < scene->isosurface_count; i++) {
        float value = (float)((scene->isosurfaces[i].value - raw.offset) / raw.scale);
        int at = i;
        for (; at > 0 && (float)((scene->isosurfaces[order[at - 1]].value - raw.offset) / raw.scale) > value; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

/* Positions by the inverse of the placement; an index gradient is the transpose times the world's. */
static void convert_slab(void *context, size_t slab, int thread)
{
    (void)thread;
    const struct conversion *c = context;
    size_t count = c->mesh->vertex_count, each = count / c->slabs + 1, end = (slab + 1) * each < count ? (slab + 1) * each : count;
    for (size_t v = slab * each; v < end; v++) {
        const float *p = c->mesh->positions[v], *n = c->mesh->normals[v];
        for (int i = 0; i < 3; i++) {
            double place = 0, gradient = 0;
            for (int j = 0; j < 3; j++) {
                place += c->to_index[i][j] * (double)p[j];
                gradient += c->to_world[j][i] * (double)n[j];
            }
            c->to[v].place[i] = (float)place;
            c->to[v].gradient[i] = (float)gradient;
        }
    }
}

static struct vertex *convert(const struct pel_mesh *mesh, const struct pel_volume *v, int threads, struct pel_error *error)
{
    struct conversion c = { .mesh = mesh, .slabs = 64 };
    for (int i = 0; i < 3; i++) /* gradients in units of the least spacing: far from what float cannot hold */
        for (int a = 0; a < 3; a++)
            c.to_world[i][a] = v->direction[a][i] * v->spacing[a] / pel_volume_least_spacing(v);
    pel_invert3((const double(*)[3])c.to_world, c.to_index);
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            c.to_index[i][a] /= pel_volume_least_spacing(v);
    c.to = pel_alloc_aligned(mesh->vertex_count + 1, sizeof *c.to, "vertices", error);
    if (c.to)
        pel_parallel_for(threads, c.slabs, convert_slab, &c);
    return c.to;
}

/* The two attributes of a vertex, and the corners. */
static bool make_array(struct pel_mesh_renderer *m, struct pel_mesh_surface *s, struct pel_error *error)
{
    if (!s->array) {
        glCreateVertexArrays(1, &s->array);
        if (!s->array)
            return pel_fail(error, PEL_ERROR_MEMORY, "GPU: no more vertex arrays");
        m->device->objects++;
    }
    glVertexArrayVertexBuffer(s->array, 0, s->vertices.name, 0, sizeof(struct vertex));
    for (GLuint i = 0; i < 2; i++) {
        glVertexArrayAttribFormat(s->array, i, 3, GL_FLOAT, GL_FALSE, i ? offsetof(struct vertex, gradient) : 0);
        glVertexArrayAttribBinding(s->array, i, 0);
        glEnableVertexArrayAttrib(s->array, i);
    }
    glVertexArrayElementBuffer(s->array, s->elements.name);
    return pel_device_check(m->device, "vertex array", error);
}

void pel_mesh_surfaces_finish(struct pel_mesh_renderer *m)
{
    for (int i = 0; i < PEL_MAX_ISOSURFACES; i++) {
        struct pel_mesh_surface *s = &m->surfaces[i];
        if (s->array) {
            if (pel_device_is_current(m->device))
                glDeleteVertexArrays(1, &s->array);
            m->device->objects--;
        }
        pel_buffer_destroy(m->device, &s->vertices);
        pel_buffer_destroy(m->device, &s->elements);
        memset(s, 0, sizeof *s);
    }
}

uint64_t pel_mesh_held(const struct pel_mesh_renderer *m)
{
    uint64_t bytes = pel_mesh_extraction_held(&m->extraction) + m->links.bytes + m->nodes.bytes;
    for (int i = 0; i < PEL_MAX_ISOSURFACES; i++)
        bytes += m->surfaces[i].vertices.bytes + m->surfaces[i].elements.bytes;
    return bytes;
}

/* What the last surfaces had. Where memory is allowed for by the byte, nothing larger than need be is kept, nor what is no longer used. */
static void clear(struct pel_mesh_renderer *m)
{
    const bool limited = m->device->params.memory_limit;
    for (int i = 0; i < PEL_MAX_ISOSURFACES; i++) {
        struct pel_mesh_surface *s = &m->surfaces[i];
        s->vertex_count = s->element_count = 0;
        if (limited) {
            pel_buffer_destroy(m->device, &s->vertices);
            pel_buffer_destroy(m->device, &s->elements);
        }
    }
    if (limited && m->options.extract == PEL_MESH_EXTRACT_CPU)
        pel_mesh_extraction_finish(m->device, &m->extraction);
    if (limited) {
        pel_buffer_destroy(m->device, &m->links);
        pel_buffer_destroy(m->device, &m->nodes);
        m->view.room[0] = 0;
    }
}

/* ---- by the CPU ---- */

static bool fits(const struct pel_mesh_renderer *m, const struct pel_mesh *mesh, struct pel_error *error)
{
    const uint64_t limit = m->device->params.memory_limit, held = pel_mesh_held(m),
                   bytes = (uint64_t)mesh->vertex_count * sizeof(struct vertex) + (uint64_t)mesh->triangle_count * sizeof *mesh->triangles;
    bool counts = mesh->vertex_count <= INT32_MAX; /* as `base`, the number where a part's vertices begin, is a GLint and taken off */
    return (counts && (!limit || held + bytes <= limit)) ||
           pel_fail(error, PEL_ERROR_UNSUPPORTED, "the surface takes %llu MB, more than the GPU may hold; use the technique raycast",
                    (unsigned long long)(bytes >> 20));
}

static bool send_part(struct pel_mesh_renderer *m, const struct pel_mesh *mesh, int i, const struct vertex *vertices,
                      struct pel_error *error)
{
    const struct pel_mesh_part *part = &mesh->parts[i];
    struct pel_mesh_surface *s = &m->surfaces[i];
    s->vertex_count = part->vertex_count;
    s->element_count = 3 * part->triangle_count;
    s->base = -(GLint)part->first_vertex;
    if (!part->triangle_count)
        return true;
    return pel_buffer_fill(m->device, &s->vertices, vertices + part->first_vertex, part->vertex_count * sizeof *vertices, error) &&
           pel_buffer_fill(m->device, &s->elements, mesh->triangles + part->first_triangle, part->triangle_count * sizeof *mesh->triangles,
                           error);
}

static bool make_by_cpu(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    struct pel_mesh_params params = { .isovalue_count = scene->isosurface_count,
                                      .tolerance = m->options.tolerance,
                                      .threads = frame->threads,
                                      .progress = *frame->progress };
    int order[PEL_MAX_ISOSURFACES];
    double start = pel_now_ms();
    order_of(m, scene, order);
    for (int i = 0; i < scene->isosurface_count; i++)
        params.isovalues[i] = scene->isosurfaces[order[i]].value;
    struct pel_mesh *mesh = pel_mesh_extract_by(scene->volume, &m->minmax, &params, error);
    if (!mesh)
        return false;
    pel_frame_stage(frame, "extraction", start);
    start = pel_now_ms();
    struct vertex *vertices = fits(m, mesh, error) ? convert(mesh, scene->volume, frame->threads, error) : NULL;
    bool ok = vertices;
    for (int i = 0; i < mesh->part_count && ok; i++)
        ok = send_part(m, mesh, i, vertices, error);
    free(vertices);
    pel_mesh_destroy(mesh);
    pel_frame_stage(frame, "surfaces to the device", start);
    return ok;
}

/* ---- by the GPU ---- */

static bool make_by_gpu(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    double start = pel_now_ms();
    if (!m->extraction.ready) {
        if (!pel_mesh_extraction_take(m->device, &m->extraction, &m->format, &m->box, frame->scene->volume, &m->minmax, frame->threads,
                                      error))
            return false;
        pel_frame_stage(frame, "upload", start);
        start = pel_now_ms();
    }
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, m->block.name);
    for (int i = 0; i < m->job.iso_count; i++) {
        m->extraction.beside = pel_mesh_held(m) - pel_mesh_extraction_held(&m->extraction);
        if (!pel_mesh_extraction_run(m->device, &m->programs, &m->extraction, i, &m->surfaces[i], error))
            return false;
    }
    if (m->device->info.software)
        glFinish();
    pel_frame_stage(frame, "extraction", start);
    return true;
}

bool pel_mesh_surfaces_make(struct pel_mesh_renderer *m, const struct pel_frame *frame, struct pel_error *error)
{
    const bool gpu = m->options.extract == PEL_MESH_EXTRACT_GPU;
    clear(m);
    if (!(gpu ? make_by_gpu(m, frame, error) : make_by_cpu(m, frame, error)))
        return false;
    for (int i = 0; i < m->job.iso_count; i++)
        if (m->surfaces[i].element_count && !make_array(m, &m->surfaces[i], error))
            return false;
    return true;
}
