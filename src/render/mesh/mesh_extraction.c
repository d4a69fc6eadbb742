/* SPDX-License-Identifier: MIT */
#include "mesh_extraction.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "cell_table.h"
#include "fail.h"

/* Buffers, as the shaders name them; 5 and 6 are the pyramid's. */
enum { BINDING_TABLE, BINDING_LIST, BINDING_SLOTS, BINDING_FIRST, BINDING_POINTS, BINDING_OUTPUT = 7 };
enum { ENTRY_WORDS = 13, BRICK_ITEMS = 64, BRICK_BYTES = 14 /* of bounds, slot and counts */ };
#define INSTEAD "extract the surface on the CPU"

/* The shaders' CellTable (mesh_cells.glsl). */
struct device_table {
    uint32_t cases[256], entries[PEL_CELL_ENTRIES][ENTRY_WORDS];
};

/* ---- with the volume ---- */

/* A loop that cannot be filled is a fan around its centre; there is one at most in a cell. */
static void put_entry(uint32_t to[ENTRY_WORDS], const struct pel_cell_entry *from)
{
    uint32_t count = 0, centre = 0;
    for (int l = 0; l < from->loops; l++) {
        const struct pel_cell_loop *loop = &from->loop[l];
        const uint8_t *edges = from->edges + loop->first;
        for (int i = loop->first_triangle; i < loop->first_triangle + loop->triangles; i++)
            to[1 + count++] = from->triangles[i][0] | (uint32_t)from->triangles[i][1] << 4 | (uint32_t)from->triangles[i][2] << 8;
        for (int i = 0; !loop->triangles && i < loop->count; i++) {
            centre |= 1u << edges[i];
            to[1 + count++] = edges[i] | (uint32_t)edges[(i + 1) % loop->count] << 4 | 12u << 8;
        }
    }
    to[0] = count | centre << 8;
}

static bool send_table(struct pel_device *device, struct pel_buffer *to, struct pel_error *error)
{
    struct pel_cell_table *table = pel_alloc(1, sizeof *table, "the table of cells", error);
    struct device_table *words = table ? pel_alloc(1, sizeof *words, "the table of cells", error) : NULL;
    if (words) {
        pel_cell_table_init(table);
        for (int i = 0; i < 256; i++)
            words->cases[i] = table->first[i] | (uint32_t)table->ambiguous[i] << 16;
        for (int i = 0; i < table->count; i++)
            put_entry(words->entries[i], &table->entries[i]);
    }
    bool ok = words && pel_buffer_fill(device, to, words, sizeof *words, error);
    free(words);
    free(table);
    return ok;
}

/* In the shaders' raw values, and a little wider than they are: rounding must not lose a brick. */
static bool send_bounds(struct pel_device *device, struct pel_mesh_extraction *x, const struct pel_gpu_format *format,
                        const struct pel_minmax *minmax, struct pel_error *error)
{
    const struct pel_minmax_level *cells = &minmax->cells;
    const double margin = 1e-5 * fabs((double)format->most - (double)format->least);
    x->brick_count = cells->dims[0] * cells->dims[1] * cells->dims[2];
    float(*bounds)[2] = pel_alloc_aligned(x->brick_count, sizeof *bounds, "bounds of bricks", error);
    if (!bounds)
        return false;
    for (size_t i = 0; i < x->brick_count; i++) {
        bounds[i][0] = (float)(((double)cells->least[i] - format->raw.offset) / format->raw.scale - margin);
        bounds[i][1] = (float)(((double)cells->most[i] - format->raw.offset) / format->raw.scale + margin);
    }
    bool ok = pel_buffer_fill(device, &x->bounds, bounds, x->brick_count * sizeof *bounds, error);
    free(bounds);
    return ok;
}

bool pel_mesh_extraction_take(struct pel_device *device, struct pel_mesh_extraction *x, const struct pel_gpu_format *format,
                              const struct pel_gpu_box *box, const struct pel_volume *volume, const struct pel_minmax *minmax, int threads,
                              struct pel_error *error)
{
    x->voids = format->voids;
    const uint64_t bricks = (uint64_t)minmax->cells.dims[0] * minmax->cells.dims[1] * minmax->cells.dims[2];
    if (!pel_gpu_volume_fits(device, format, volume, bricks * BRICK_BYTES + sizeof(struct device_table)))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the device does not hold the whole volume; extract the surface on the CPU");
    if (!pel_gpu_check_room(device, 0, bricks * 2 * sizeof(float), "bounds of the volume's bricks", INSTEAD, error))
        return false;
    x->ready = (x->table.name || send_table(device, &x->table, error)) && send_bounds(device, x, format, minmax, error) &&
               pel_gpu_volume_upload(device, format, volume, box->origin, box->size, threads, &x->volume, error);
    return x->ready;
}

/* ---- with an isovalue ---- */

struct run {
    struct pel_device *device;
    struct pel_programs *programs;
    struct pel_mesh_extraction *x;
    int surface;
};

/* Runs a pass; the caller has bound its buffers. */
static bool run_pass(const struct run *r, const char *file, size_t invocations, struct pel_error *error)
{
    GLuint program = pel_programs_find(r->device, r->programs, file, r->x->voids ? "#define VOIDS\n" : "", error);
    if (!program)
        return false;
    glUseProgram(program);
    glProgramUniform1i(program, 0, r->surface);
    glProgramUniform1ui(program, 1, (GLuint)invocations);
    if (!strcmp(file, "mesh_bricks.glsl"))
        glProgramUniform1ui(program, 2, (GLuint)r->x->brick_count);
    pel_histopyramid_dispatch(invocations);
    return pel_device_check(r->device, file, error);
}

uint64_t pel_mesh_extraction_held(const struct pel_mesh_extraction *x)
{
    const struct pel_buffer *buffers[] = { &x->bounds,         &x->table,           &x->list,
                                           &x->slots,          &x->first,           &x->bricks.base,
                                           &x->bricks.levels,  &x->vertices.base,   &x->vertices.levels,
                                           &x->triangles.base, &x->triangles.levels };
    uint64_t bytes = x->volume.bytes;
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        bytes += buffers[i]->bytes;
    return bytes;
}

/* Room in a buffer that is one of ours or will be, where there may be so much. */
static bool reserve(const struct run *r, struct pel_buffer *buffer, uint64_t beside, size_t bytes, const char *what,
                    struct pel_error *error)
{
    if (buffer->bytes >= bytes)
        return true;
    pel_buffer_destroy(r->device, buffer);
    return pel_gpu_check_room(r->device, r->x->beside + pel_mesh_extraction_held(r->x) + beside, bytes, what, INSTEAD, error) &&
           pel_buffer_fill(r->device, buffer, NULL, bytes, error);
}

static bool reserve_pyramid(const struct run *r, struct pel_histopyramid *pyramid, size_t items, const char *what, struct pel_error *error)
{
    const uint64_t bytes = pel_histopyramid_bytes(items);
    if (pyramid->base.bytes + pyramid->levels.bytes < bytes) {
        pel_histopyramid_finish(r->device, pyramid);
        if (r->device->params.memory_limit &&
            !pel_gpu_check_room(r->device, r->x->beside + pel_mesh_extraction_held(r->x), bytes, what, INSTEAD, error))
            return false;
    }
    return pel_histopyramid_reserve(r->device, pyramid, items, error);
}

static void bind(GLuint binding, const struct pel_buffer *buffer)
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer->name);
}

static size_t groups_of(size_t items)
{
    return (items + PEL_HISTO_GROUP - 1) / PEL_HISTO_GROUP;
}

/* The bricks that the surface may pass through, each with a slot. */
static bool find_bricks(const struct run *r, struct pel_error *error)
{
    struct pel_mesh_extraction *x = r->x;
    if (!reserve_pyramid(r, &x->bricks, x->brick_count, "counts of bricks", error) ||
        !reserve(r, &x->slots, 0, x->brick_count * sizeof(uint32_t), "slots of bricks", error))
        return false;
    pel_histopyramid_bind(&x->bricks);
    bind(BINDING_TABLE, &x->bounds);
    if (!run_pass(r, "mesh_bricks.glsl", groups_of(x->brick_count), error) ||
        !pel_histopyramid_build(r->device, r->programs, &x->bricks, error) ||
        !reserve(r, &x->list, 0, ((size_t)x->bricks.total + 1) * sizeof(uint32_t), "a list of bricks", error))
        return false;
    bind(BINDING_TABLE, &x->table);
    bind(BINDING_LIST, &x->list);
    bind(BINDING_SLOTS, &x->slots);
    return run_pass(r, "mesh_slots.glsl", x->bricks.total, error);
}

/* How many vertices and triangles come from where. */
static bool count_all(const struct run *r, struct pel_error *error)
{
    struct pel_mesh_extraction *x = r->x;
    size_t items = (size_t)x->bricks.total * BRICK_ITEMS;
    if (items > UINT32_MAX)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a surface through %zu cells is more than the GPU extracts; extract it on the CPU",
                        items);
    if (!reserve_pyramid(r, &x->vertices, items, "counts of vertices", error) ||
        !reserve_pyramid(r, &x->triangles, items, "counts of triangles", error) ||
        !reserve(r, &x->first, 0, (items + 1) * sizeof(uint32_t), "the cells' first vertices", error))
        return false;
    bind(PEL_BUFFER_HISTO_BASE, &x->vertices.base);
    bind(BINDING_OUTPUT, &x->triangles.base);
    return run_pass(r, "mesh_counts.glsl", groups_of(items), error) &&
           pel_histopyramid_build(r->device, r->programs, &x->vertices, error) &&
           pel_histopyramid_build(r->device, r->programs, &x->triangles, error);
}

static bool make_all(const struct run *r, struct pel_mesh_surface *to, struct pel_error *error)
{
    struct pel_mesh_extraction *x = r->x;
    const size_t vertices = x->vertices.total, triangles = x->triangles.total;
    if (vertices >= 1u << 28 || triangles > UINT32_MAX / 3)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a surface of %zu triangles is more than the GPU extracts; extract it on the CPU",
                        triangles);
    if (!reserve(r, &to->vertices, 0, (vertices + 1) * 6 * sizeof(float), "the surface's vertices", error) ||
        !reserve(r, &to->elements, to->vertices.bytes, (triangles + 1) * 3 * sizeof(uint32_t), "the surface's triangles", error))
        return false;
    bind(BINDING_FIRST, &x->first);
    bind(BINDING_POINTS, &to->vertices);
    bind(BINDING_OUTPUT, &to->elements);
    pel_histopyramid_bind(&x->vertices);
    if (!run_pass(r, "mesh_points.glsl", vertices, error))
        return false;
    pel_histopyramid_bind(&x->triangles);
    if (!run_pass(r, "mesh_corners.glsl", triangles, error))
        return false;
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT);
    to->vertex_count = vertices;
    to->element_count = 3 * triangles;
    to->base = 0;
    return true;
}

bool pel_mesh_extraction_run(struct pel_device *device, struct pel_programs *programs, struct pel_mesh_extraction *x, int number,
                             struct pel_mesh_surface *to, struct pel_error *error)
{
    const struct run r = { device, programs, x, number };
    glBindTextureUnit(PEL_UNIT_VOLUME, x->volume.name);
    to->vertex_count = to->element_count = 0;
    if (!find_bricks(&r, error))
        return false;
    return !x->bricks.total || (count_all(&r, error) && make_all(&r, to, error));
}

void pel_mesh_extraction_finish(struct pel_device *device, struct pel_mesh_extraction *x)
{
    struct pel_buffer *buffers[] = { &x->bounds, &x->table, &x->list, &x->slots, &x->first };
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(device, buffers[i]);
    pel_texture_destroy(device, &x->volume);
    pel_histopyramid_finish(device, &x->bricks);
    pel_histopyramid_finish(device, &x->vertices);
    pel_histopyramid_finish(device, &x->triangles);
    x->ready = false;
}
