/* SPDX-License-Identifier: MIT */
#include "raycast_gpu.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "classify.h"
#include "distance_map.h"
#include "fail.h"
#include "gpu_volume.h"
#include "objects.h"
#include "parallel.h"
#include "rays.h"
#include "timer.h"

/* The shaders' JobBlock (job.glsl), in the same order. */
struct job {
    float p0[4], px[4], py[4], d0[4], dx[4], dy[4], w0[4], wx[4], wy[4];
    float ray[4], box_lo[4], box_hi[4];
    int32_t picture[4];
    float planes[12][4];
    int32_t dims[4], cells[4];
    float raw[4], table[4], light[4], all_diffuse[4], all_specular[4], gradient[4];
    float to_world[3][4], normal[3][4], metric[2][4];
    int32_t counts[4];
    float light_direction[4][4], light_diffuse[4][4], light_specular[4][4];
    float range[4], slice_plane[4];
    float iso[PEL_MAX_ISOSURFACES][4], iso_color[PEL_MAX_ISOSURFACES][4];
};

/* The look-up table's texture (transfer.glsl): rows of 4096 entries, four for the same entries. */
enum { TABLE_WIDTH = 4096, TABLE_ROWS = 4 };

/* Bindings, as the shaders name them. */
enum { UNIT_VOLUME, UNIT_DISTANCES, UNIT_GRID, UNIT_FROM, UNIT_ENTRIES };
enum { BUFFER_COUNTERS = 2, BUFFER_SEEN, BUFFER_RANGE };

#define MAX_PROGRAMS 64
#define CELL_GROUP 4 /* cells of a work group along each axis */
#define PIXEL_GROUP 8

struct program {
    unsigned key;
    GLuint name;
};

struct pel_gpu_raycaster {
    struct pel_device *device;
    struct pel_gpu_volume volume;
    struct pel_classification_state tables;
    struct pel_job job;
    int cells[3];
    size_t cell_count;
    unsigned octants; /* whose distance maps are there */
    struct pel_texture entries, grid, marks, scratch[2], distances, picture, depth;
    struct pel_buffer block, counters, seen, range;
    struct program programs[MAX_PROGRAMS];
    int program_count;
    struct pel_gpu_timer timer;
    uint32_t visible_cells;
};

struct pel_gpu_raycaster *pel_gpu_raycaster_create(struct pel_device *device, struct pel_error *error)
{
    struct pel_gpu_raycaster *rc = pel_alloc(1, sizeof *rc, "GPU ray caster", error);
    if (rc)
        rc->device = device;
    return rc;
}

void pel_gpu_raycaster_destroy(struct pel_gpu_raycaster *rc)
{
    if (!rc)
        return;
    struct pel_texture *textures[] = { &rc->entries,    &rc->grid,      &rc->marks,   &rc->scratch[0],
                                       &rc->scratch[1], &rc->distances, &rc->picture, &rc->depth };
    struct pel_buffer *buffers[] = { &rc->block, &rc->counters, &rc->seen, &rc->range };
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(rc->device, textures[i]);
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(rc->device, buffers[i]);
    for (int i = 0; i < rc->program_count; i++)
        pel_program_destroy(rc->device, rc->programs[i].name);
    pel_gpu_volume_destroy(rc->device, &rc->volume);
    pel_gpu_timer_destroy(rc->device, &rc->timer);
    pel_classify_finish(&rc->tables);
    free(rc);
}

/* ---- programs ---- */

/* What a program is compiled for, as bits of its key. */
enum {
    HAS_VOIDS = 1,
    HAS_NEAREST = 2,
    HAS_SHADE = 4,
    HAS_HEADLIGHTS = 8,
    HAS_PRE = 16,
    HAS_MINIMUM = 32,
    KEY_MODE = 64,
    KEY_FILE = 64 * 16
};

static const char *const shader_names[] = { "composite.glsl",  "preintegrated.glsl", "extreme.glsl", "average.glsl",  "xray.glsl",
                                            "isosurface.glsl", "slice.glsl",         "minmax.glsl",  "classify.glsl", "distance.glsl" };
enum shader {
    SHADER_COMPOSITE,
    SHADER_PREINTEGRATED,
    SHADER_EXTREME,
    SHADER_AVERAGE,
    SHADER_XRAY,
    SHADER_ISOSURFACE,
    SHADER_SLICE,
    SHADER_MINMAX,
    SHADER_CLASSIFY,
    SHADER_DISTANCE
};

static GLuint find_program(struct pel_gpu_raycaster *rc, enum shader shader, unsigned has, enum pel_mode mode, struct pel_error *error)
{
    static const char *const words[] = { "VOIDS", "NEAREST", "SHADE", "HEADLIGHTS", "PRE", "MINIMUM" };
    unsigned key = (unsigned)shader * KEY_FILE + (unsigned)mode * KEY_MODE + has;
    for (int i = 0; i < rc->program_count; i++)
        if (rc->programs[i].key == key)
            return rc->programs[i].name;
    char defines[512];
    int length =
        snprintf(defines, sizeof defines, "#define MODE_MIP %d\n#define MODE_MINIP %d\n#define MODE_ISOSURFACE %d\n#define MODE %d\n",
                 PEL_MODE_MIP, PEL_MODE_MINIP, PEL_MODE_ISOSURFACE, mode);
    for (unsigned i = 0; i < sizeof words / sizeof *words; i++)
        if (has & 1u << i)
            length += snprintf(defines + length, sizeof defines - (size_t)length, "#define %s\n", words[i]);
    GLuint name = pel_program_create(rc->device, shader_names[shader], defines, error);
    if (!name)
        return 0;
    if (rc->program_count == MAX_PROGRAMS) /* more kinds of picture than anyone draws with one renderer: forget the oldest */
        pel_program_destroy(rc->device, rc->programs[0].name),
            memmove(rc->programs, rc->programs + 1, sizeof *rc->programs * --rc->program_count);
    rc->programs[rc->program_count++] = (struct program){ key, name };
    return name;
}

/* The program that draws the job. */
static GLuint drawing_program(struct pel_gpu_raycaster *rc, struct pel_error *error)
{
    const struct pel_job *job = &rc->job;
    unsigned has = (rc->volume.voids ? HAS_VOIDS : 0) | (job->headlight_only ? HAS_HEADLIGHTS : 0);
    enum shader shader = SHADER_COMPOSITE;
    switch (job->mode) {
    case PEL_MODE_COMPOSITE:
        has |= (job->shade ? HAS_SHADE : 0) | (job->nearest ? HAS_NEAREST : 0);
        if (!job->nearest && job->classification == PEL_CLASSIFICATION_PREINTEGRATED)
            shader = SHADER_PREINTEGRATED;
        else if (!job->nearest && job->classification == PEL_CLASSIFICATION_PRE)
            has |= HAS_PRE;
        break;
    case PEL_MODE_ISOSURFACE:
        shader = SHADER_ISOSURFACE;
        break;
    case PEL_MODE_MIP:
    case PEL_MODE_MINIP:
        shader = SHADER_EXTREME;
        has |= job->mode == PEL_MODE_MINIP ? HAS_MINIMUM : 0;
        break;
    case PEL_MODE_AVERAGE:
        shader = SHADER_AVERAGE;
        break;
    case PEL_MODE_XRAY:
        shader = SHADER_XRAY;
        break;
    case PEL_MODE_SLICE:
        shader = SHADER_SLICE;
        break;
    }
    if (job->mode != PEL_MODE_COMPOSITE && job->nearest)
        has |= HAS_NEAREST;
    return find_program(rc, shader, has, job->mode, error);
}

/* ---- the job ---- */

static void put3(float to[4], const double from[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = (float)from[i];
}

static void fill_rays(struct job *to, const struct pel_job *job)
{
    put3(to->p0, job->p0), put3(to->px, job->px), put3(to->py, job->py);
    put3(to->d0, job->d0), put3(to->dx, job->dx), put3(to->dy, job->dy);
    put3(to->w0, job->w0), put3(to->wx, job->wx), put3(to->wy, job->wy);
    to->ray[0] = (float)job->s_base, to->ray[1] = (float)fmax(job->s_least, -1e30), to->ray[2] = (float)job->step;
    to->ray[3] = (float)fmax(job->along, 1e-30);
    put3(to->box_lo, job->box_lo), put3(to->box_hi, job->box_hi);
    to->picture[0] = job->width, to->picture[1] = job->height, to->picture[2] = job->plane_count, to->picture[3] = job->jitter;
    for (int i = 0; i < job->plane_count; i++)
        for (int j = 0; j < 4; j++)
            to->planes[i][j] = (float)job->planes[i][j];
    for (int j = 0; j < 4; j++)
        to->slice_plane[j] = (float)job->slice_plane[j];
}

static void fill_optics(struct job *to, const struct pel_job *job)
{
    to->light[0] = job->ambient, to->light[1] = job->power, to->light[2] = job->specular, to->light[3] = job->steps_a_voxel;
    memcpy(to->all_diffuse, job->all_diffuse, sizeof job->all_diffuse);
    memcpy(to->all_specular, job->all_specular, sizeof job->all_specular);
    for (int i = 0; i < 3; i++) {
        memcpy(to->to_world[i], job->to_world[i], sizeof job->to_world[i]);
        memcpy(to->normal[i], job->normal[i], sizeof job->normal[i]);
    }
    memcpy(to->metric[0], job->metric, 4 * sizeof(float));
    memcpy(to->metric[1], job->metric + 4, 2 * sizeof(float));
    to->counts[0] = job->light_count, to->counts[1] = job->iso_count;
    for (int l = 0; l < job->light_count; l++) {
        memcpy(to->light_direction[l], job->lights[l].direction, sizeof job->lights[l].direction);
        to->light_direction[l][3] = job->lights[l].headlight;
        for (int c = 0; c < 3; c++) {
            to->light_diffuse[l][c] = job->diffuse * job->lights[l].color[c];
            to->light_specular[l][c] = job->specular * job->lights[l].color[c];
        }
    }
    for (int i = 0; i < job->iso_count; i++) {
        to->iso[i][0] = job->iso[i], to->iso[i][1] = job->iso_opacity[i];
        memcpy(to->iso_color[i], job->iso_color[i], sizeof job->iso_color[i]);
    }
}

static bool send_job(struct pel_gpu_raycaster *rc, const struct pel_scene *scene, struct pel_error *error)
{
    const struct pel_job *job = &rc->job;
    const struct pel_gpu_volume *v = &rc->volume;
    struct job to = { .p0 = { 0 } };
    fill_rays(&to, job);
    fill_optics(&to, job);
    for (int a = 0; a < 3; a++) {
        to.dims[a] = (int32_t)scene->volume->dims[a];
        to.cells[a] = rc->cells[a];
    }
    to.cells[3] = job->skip;
    to.raw[0] = v->texel_scale, to.raw[1] = v->texel_offset, to.raw[2] = v->void_raw, to.raw[3] = v->void_by_value;
    to.table[0] = job->table_scale, to.table[1] = job->table_offset, to.table[2] = (float)job->table_last,
    to.table[3] = job->step_over_unit;
    to.gradient[0] = v->gradient_scale, to.gradient[1] = v->voids, to.gradient[2] = job->termination, to.gradient[3] = job->invert;
    to.counts[2] = scene->linear_light && job->mode != PEL_MODE_XRAY;
    to.range[0] = v->least, to.range[1] = v->most;
    return pel_buffer_fill(rc->device, &rc->block, &to, sizeof to, error);
}

/* The four rows' worth of one entry, TABLE_WIDTH apart. */
static void put_entry(const struct pel_classification_state *t, size_t i, float (*to)[4])
{
    float (*step)[4] = to, (*point)[4] = to + TABLE_WIDTH, (*sums)[4] = to + 2 * TABLE_WIDTH, (*extinction)[4] = to + 3 * TABLE_WIDTH;
    for (int c = 0; c < 3; c++) {
        (*step)[c] = t->alpha_color[c][i];
        (*point)[c] = t->color[c][i];
        (*sums)[c] = t->sum_color[c][i];
        (*extinction)[c] = 0;
    }
    (*step)[3] = t->alpha[i], (*point)[3] = t->table.opacity[i], (*sums)[3] = t->sum_tau[i];
    (*extinction)[0] = t->tau[i], (*extinction)[3] = 0;
}

static bool send_tables(struct pel_gpu_raycaster *rc, struct pel_error *error)
{
    const struct pel_classification_state *t = &rc->tables;
    size_t count = t->table.count, levels = (size_t)t->table.range.levels, row = count * levels; /* count: a multiple of TABLE_WIDTH */
    int height = (int)(count / TABLE_WIDTH) * TABLE_ROWS;
    float (*entries)[4] = pel_alloc_aligned(count * TABLE_ROWS, sizeof *entries, "look-up table", error);
    int32_t *range = entries ? pel_alloc_aligned(row + 2, sizeof *range, "range table", error) : NULL;
    bool ok = range && pel_texture_reserve(rc->device, &rc->entries, GL_RGBA32F, TABLE_WIDTH, height, 0, GL_NEAREST, error);
    if (ok) {
        for (size_t i = 0; i < count; i++)
            put_entry(t, i, entries + i / TABLE_WIDTH * TABLE_WIDTH * TABLE_ROWS + i % TABLE_WIDTH);
        glTextureSubImage2D(rc->entries.name, 0, 0, 0, TABLE_WIDTH, height, GL_RGBA, GL_FLOAT, entries);
        range[0] = (int32_t)count, range[1] = (int32_t)levels;
        memcpy(range + 2, t->table.range.most, row * sizeof(float));
        ok = pel_buffer_fill(rc->device, &rc->range, range, (row + 2) * sizeof *range, error);
    }
    free(range);
    free(entries);
    return ok;
}

/* ---- stages ---- */

static void bind(const struct pel_gpu_raycaster *rc)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, rc->block.name);
    const struct pel_buffer *buffers[] = { [BUFFER_COUNTERS] = &rc->counters, [BUFFER_SEEN] = &rc->seen, [BUFFER_RANGE] = &rc->range };
    for (GLuint i = BUFFER_COUNTERS; i <= BUFFER_RANGE; i++)
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]->name);
    glBindTextureUnit(UNIT_VOLUME, rc->volume.texture.name);
    glBindTextureUnit(UNIT_DISTANCES, rc->distances.name);
    glBindTextureUnit(UNIT_GRID, rc->grid.name);
    glBindTextureUnit(UNIT_ENTRIES, rc->entries.name);
}

static void dispatch_cells(const struct pel_gpu_raycaster *rc)
{
    GLuint groups[3];
    for (int a = 0; a < 3; a++)
        groups[a] = (GLuint)(rc->cells[a] + CELL_GROUP - 1) / CELL_GROUP;
    glDispatchCompute(groups[0], groups[1], groups[2]);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

/* The same grid made by the CPU, which in software does it twenty times as fast. */
static bool send_grid(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_minmax minmax;
    const struct pel_raw_scale raw = rc->volume.raw;
    float(*pairs)[2] = NULL;
    bool ok = pel_minmax_init(&minmax, frame->scene->volume, frame->threads, error) &&
              (pairs = pel_alloc_aligned(rc->cell_count, sizeof *pairs, "min-max grid", error)) &&
              pel_texture_reserve(rc->device, &rc->grid, GL_RG32F, rc->cells[0], rc->cells[1], rc->cells[2], GL_NEAREST, error);
    if (ok) {
        for (size_t i = 0; i < rc->cell_count; i++) {
            pairs[i][0] = (float)((minmax.cells.least[i] - raw.offset) / raw.scale);
            pairs[i][1] = (float)((minmax.cells.most[i] - raw.offset) / raw.scale);
        }
        glTextureSubImage3D(rc->grid.name, 0, 0, 0, 0, rc->cells[0], rc->cells[1], rc->cells[2], GL_RG, GL_FLOAT, pairs);
        ok = pel_device_check(rc->device, "min-max grid", error);
    }
    free(pairs);
    pel_minmax_finish(&minmax);
    return ok;
}

static bool build_grid(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    if (rc->device->info.software)
        return send_grid(rc, frame, error);
    GLuint program = find_program(rc, SHADER_MINMAX, rc->volume.voids ? HAS_VOIDS : 0, PEL_MODE_COMPOSITE, error);
    if (!program || !pel_texture_reserve(rc->device, &rc->grid, GL_RG32F, rc->cells[0], rc->cells[1], rc->cells[2], GL_NEAREST, error))
        return false;
    bind(rc);
    glUseProgram(program);
    glBindImageTexture(0, rc->grid.name, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG32F);
    dispatch_cells(rc);
    return pel_device_check(rc->device, "min-max grid", error);
}

static bool mark_cells(struct pel_gpu_raycaster *rc, struct pel_error *error)
{
    const uint32_t none = 0;
    enum pel_mode mode = rc->job.mode;
    bool special = mode == PEL_MODE_ISOSURFACE || mode == PEL_MODE_MIP || mode == PEL_MODE_MINIP;
    GLuint program = find_program(rc, SHADER_CLASSIFY, 0, special ? mode : PEL_MODE_COMPOSITE, error);
    if (!program || !pel_texture_reserve(rc->device, &rc->marks, GL_R8UI, rc->cells[0], rc->cells[1], rc->cells[2], GL_NEAREST, error) ||
        !pel_buffer_fill(rc->device, &rc->seen, &none, sizeof none, error))
        return false;
    bind(rc);
    glUseProgram(program);
    glBindImageTexture(0, rc->marks.name, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    dispatch_cells(rc);
    rc->octants = 0;
    return pel_device_check(rc->device, "classify", error);
}

/* The distance map of one octant, in three passes: x, y and z; the last writes into its place among the octants' maps. */
static bool map_octant(struct pel_gpu_raycaster *rc, GLuint program, int octant, struct pel_error *error)
{
    const struct pel_texture *from[3] = { &rc->marks, &rc->scratch[0], &rc->scratch[1] },
                             *to[3] = { &rc->scratch[0], &rc->scratch[1], &rc->distances };
    glUseProgram(program);
    for (int axis = 0; axis < 3; axis++) {
        glProgramUniform4i(program, 0, axis, 0, octant, axis == 2 ? octant * rc->cells[2] : 0);
        glBindTextureUnit(UNIT_FROM, from[axis]->name);
        glBindImageTexture(0, to[axis]->name, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
        dispatch_cells(rc);
    }
    return pel_device_check(rc->device, "distance map", error);
}

struct mapping {
    const uint8_t *marks;
    size_t dims[3];
    uint8_t *maps; /* eight, one above the other */
    unsigned wanted;
    bool failed[8];
};

static void map_on_cpu(void *context, size_t octant, int thread)
{
    (void)thread;
    struct mapping *m = context;
    size_t slice = m->dims[0] * m->dims[1];
    if (m->wanted & 1u << octant)
        m->failed[octant] =
            !pel_distance_map(m->marks, m->dims, m->dims[0], slice, (unsigned)octant, m->maps + octant * slice * m->dims[2], NULL);
}

/* The same maps made by the CPU, which in software does it ten times as fast. */
static bool send_maps(struct pel_gpu_raycaster *rc, unsigned wanted, int threads, struct pel_error *error)
{
    const int *c = rc->cells;
    uint8_t *marks = pel_alloc_aligned(rc->cell_count * 9, 1, "distance maps", error);
    if (!marks)
        return false;
    struct mapping m = { marks, { (size_t)c[0], (size_t)c[1], (size_t)c[2] }, marks + rc->cell_count, wanted, { false } };
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glGetTextureImage(rc->marks.name, 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, (GLsizei)rc->cell_count, marks);
    pel_parallel_for(threads, 8, map_on_cpu, &m);
    bool ok = true;
    for (int o = 0; o < 8; o++) {
        ok &= !m.failed[o];
        if (wanted & 1u << o)
            glTextureSubImage3D(rc->distances.name, 0, 0, 0, o * c[2], c[0], c[1], c[2], GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                                m.maps + (size_t)o * rc->cell_count);
    }
    free(marks);
    return ok ? pel_device_check(rc->device, "distance maps", error) : pel_fail(error, PEL_ERROR_MEMORY, "distance maps: no memory");
}

static bool make_maps(struct pel_gpu_raycaster *rc, unsigned wanted, struct pel_error *error)
{
    const int *c = rc->cells;
    GLuint program = find_program(rc, SHADER_DISTANCE, 0, PEL_MODE_COMPOSITE, error);
    if (!program || !pel_texture_reserve(rc->device, &rc->scratch[0], GL_R8UI, c[0], c[1], c[2], GL_NEAREST, error) ||
        !pel_texture_reserve(rc->device, &rc->scratch[1], GL_R8UI, c[0], c[1], c[2], GL_NEAREST, error))
        return false;
    bind(rc);
    for (int o = 0; o < 8; o++)
        if (wanted & 1u << o && !map_octant(rc, program, o, error))
            return false;
    return true;
}

/* Sees to it that there are maps for all octants into which rays go. */
static bool map_octants(struct pel_gpu_raycaster *rc, unsigned octants, int threads, struct pel_error *error)
{
    const int *c = rc->cells;
    unsigned wanted = octants & ~rc->octants;
    if (!pel_texture_reserve(rc->device, &rc->distances, GL_R8UI, c[0], c[1], c[2] * 8, GL_NEAREST, error))
        return false;
    if (wanted && !(rc->device->info.software ? send_maps(rc, wanted, threads, error) : make_maps(rc, wanted, error)))
        return false;
    rc->octants |= wanted;
    return true;
}

/* ---- frames ---- */

static bool set_volume(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_volume *volume = frame->scene->volume;
    double start = pel_now_ms();
    if (!pel_gpu_volume_upload(rc->device, &rc->volume, volume, frame->threads, error))
        return false;
    rc->cell_count = 1;
    for (int a = 0; a < 3; a++) {
        rc->cells[a] = (int)((volume->dims[a] - 1) / PEL_CELL_SIZE + 1);
        rc->cell_count *= (size_t)rc->cells[a];
    }
    pel_frame_stage(frame, "upload", start);
    return true;
}

bool pel_gpu_raycaster_prepare(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    unsigned changes = frame->changes;
    bool reclassify = changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_SETTINGS);
    if (changes & PEL_CHANGE_VOLUME && !set_volume(rc, frame, error))
        return false;
    double start = pel_now_ms();
    if (reclassify) {
        if (!pel_classify_tables(&rc->tables, scene, rc->volume.raw, &rc->job, error) || !send_tables(rc, error))
            return false;
        pel_frame_stage(frame, "tables", start);
        start = pel_now_ms();
    }
    pel_rays_setup(&rc->job, scene, frame->image->width, frame->image->height);
    if (rc->cells[2] * 8 > rc->device->info.max_texture_3d) /* no room for eight maps above each other: nothing is passed over */
        rc->job.skip = false;
    bool maps = pel_mode_has_map(rc->job.mode) && rc->job.skip;
    if (!send_job(rc, scene, error) || (changes & PEL_CHANGE_VOLUME && !build_grid(rc, frame, error)))
        return false;
    if (changes & PEL_CHANGE_VOLUME) {
        pel_frame_stage(frame, "min-max grid", start);
        start = pel_now_ms();
    }
    if (reclassify && maps) {
        if (!mark_cells(rc, error))
            return false;
        pel_frame_stage(frame, "classify", start);
        start = pel_now_ms();
    }
    if (maps && !map_octants(rc, pel_rays_octants(&rc->job), frame->threads, error))
        return false;
    pel_frame_stage(frame, "distance maps", start);
    return true;
}

static bool read_back(struct pel_gpu_raycaster *rc, struct pel_image *image, struct pel_error *error)
{
    GLsizei pixels = image->width * image->height;
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetTextureImage(rc->picture.name, 0, GL_RGBA, GL_FLOAT, pixels * 4 * (GLsizei)sizeof(float), image->rgba);
    if (image->depth)
        glGetTextureImage(rc->depth.name, 0, GL_RED, GL_FLOAT, pixels * (GLsizei)sizeof(float), image->depth);
    return pel_device_check(rc->device, "reading the picture back", error);
}

static bool cast_rays(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const uint32_t none[4] = { 0 };
    struct pel_image *image = frame->image;
    const int most = rc->device->info.max_texture_2d;
    if (image->width > most || image->height > most || (uint64_t)image->width * (uint64_t)image->height > INT32_MAX / (4 * sizeof(float)))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a picture of %d x %d is more than the GPU engine draws; use --device cpu", image->width,
                        image->height);
    GLuint program = drawing_program(rc, error);
    if (!program || !pel_texture_reserve(rc->device, &rc->picture, GL_RGBA32F, image->width, image->height, 0, GL_NEAREST, error) ||
        !pel_texture_reserve(rc->device, &rc->depth, GL_R32F, image->width, image->height, 0, GL_NEAREST, error) ||
        !pel_buffer_fill(rc->device, &rc->counters, none, sizeof none, error))
        return false;
    double start = pel_now_ms();
    pel_gpu_timer_begin(rc->device, &rc->timer, "raycast: cast rays");
    bind(rc);
    glUseProgram(program);
    glBindImageTexture(0, rc->picture.name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, rc->depth.name, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute((GLuint)(image->width + PIXEL_GROUP - 1) / PIXEL_GROUP, (GLuint)(image->height + PIXEL_GROUP - 1) / PIXEL_GROUP, 1);
    pel_gpu_timer_end(&rc->timer);
    double gpu_ms = pel_gpu_timer_ms(&rc->timer);
    pel_frame_stage_gpu(frame, "cast rays", start, gpu_ms);
    start = pel_now_ms();
    bool ok = read_back(rc, image, error);
    pel_frame_stage(frame, "read back", start);
    return ok;
}

bool pel_gpu_raycaster_draw(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    uint32_t counted[4] = { 0 };
    bool ok = cast_rays(rc, frame, error);
    if (ok) {
        glGetNamedBufferSubData(rc->counters.name, 0, sizeof counted, counted);
        if (rc->seen.name)
            glGetNamedBufferSubData(rc->seen.name, 0, sizeof rc->visible_cells, &rc->visible_cells);
        ok = pel_device_check(rc->device, "counters", error);
    }
    uint64_t taken = counted[0] | (uint64_t)counted[1] << 32, in_box = counted[2] | (uint64_t)counted[3] << 32;
    pel_frame_count(frame, "samples taken", taken);
    pel_frame_count(frame, "samples skipped", in_box > taken ? in_box - taken : 0);
    pel_frame_count(frame, "cells", rc->cell_count);
    pel_frame_count(frame, "cells that may be seen", rc->visible_cells);
    pel_frame_count(frame, "bytes on the device", rc->device->bytes);
    return ok;
}
