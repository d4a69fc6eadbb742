/* SPDX-License-Identifier: MIT */
#include "gpu_job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"

void pel_gpu_box_whole(struct pel_gpu_box *box, const struct pel_volume *volume)
{
    const int far = 1 << 28;
    for (int a = 0; a < 3; a++) {
        box->origin[a] = box->first_cell[a] = 0;
        box->size[a] = (int)volume->dims[a];
        box->cells[a] = (int)((volume->dims[a] - 1) / PEL_CELL_SIZE + 1);
        box->first[a] = -far;
        box->last[a] = far;
    }
}

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
    float range[4], slice_planes[PEL_MAX_SLICES][4];
    float iso[PEL_MAX_ISOSURFACES][4], iso_color[PEL_MAX_ISOSURFACES][4];
    int32_t brick[4], brick_size[4], first_cell[4];
    float own_lo[4], own_hi[4];
};

/* What job.glsl writes as numbers; the block's size there is held to this one by check_shaders.py. */
_Static_assert(PEL_MAX_CLIP_PLANES + 6 == 12 && PEL_MAX_LIGHTS == 4 && PEL_MAX_ISOSURFACES == 16 && PEL_MAX_SLICES == 8, "job.glsl");
enum { JOB_BYTES = 1600 };
_Static_assert(sizeof(struct job) == JOB_BYTES, "job.glsl");

/* The look-up table's texture (transfer.glsl): rows of 4096 entries, five for the same entries. */
enum { TABLE_WIDTH = 4096, TABLE_ROWS = 5 };

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
    to->counts[3] = job->slice_count;
    for (int i = 0; i < job->slice_count; i++)
        for (int j = 0; j < 4; j++)
            to->slice_planes[i][j] = (float)job->slice_planes[i][j];
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

static void fill_volume(struct job *to, const struct pel_job *job, const struct pel_volume *volume, const struct pel_gpu_format *f)
{
    for (int a = 0; a < 3; a++)
        to->dims[a] = (int32_t)volume->dims[a];
    to->raw[0] = f->texel_scale, to->raw[1] = f->texel_offset, to->raw[2] = f->void_raw, to->raw[3] = f->void_within;
    to->table[0] = job->table_scale, to->table[1] = job->table_offset, to->table[2] = (float)job->table_last,
    to->table[3] = job->step_over_unit;
    to->gradient[0] = f->gradient_scale, to->gradient[1] = f->voids, to->gradient[2] = job->termination, to->gradient[3] = job->invert;
    to->range[0] = f->least, to->range[1] = f->most;
}

static void fill_box(struct job *to, const struct pel_gpu_box *box)
{
    for (int a = 0; a < 3; a++) {
        to->cells[a] = box->cells[a];
        to->brick[a] = box->origin[a];
        to->brick_size[a] = box->size[a];
        to->first_cell[a] = box->first_cell[a];
        to->own_lo[a] = (float)box->first[a];
        to->own_hi[a] = (float)box->last[a];
    }
}

bool pel_gpu_job_send(struct pel_device *device, const struct pel_gpu_job *job, struct pel_buffer *to, struct pel_error *error)
{
    struct job block = { .p0 = { 0 } };
    fill_rays(&block, job->job);
    fill_optics(&block, job->job);
    fill_volume(&block, job->job, job->scene->volume, job->format);
    fill_box(&block, job->box);
    block.cells[3] = job->job->skip;
    block.counts[2] = job->scene->linear_light && job->job->mode != PEL_MODE_XRAY;
    return pel_buffer_fill(device, to, &block, sizeof block, error);
}

/* The five rows' worth of one entry, TABLE_WIDTH apart. */
static void put_entry(const struct pel_classification_state *t, size_t i, float (*to)[4])
{
    float (*step)[4] = to, (*point)[4] = to + TABLE_WIDTH, (*sums)[4] = to + 2 * TABLE_WIDTH, (*extinction)[4] = to + 3 * TABLE_WIDTH,
          (*slab)[4] = to + 4 * TABLE_WIDTH;
    for (int c = 0; c < 3; c++) {
        (*step)[c] = t->alpha_color[c][i];
        (*point)[c] = t->color[c][i];
        (*sums)[c] = t->sum_color[c][i];
        (*extinction)[c] = 0;
        (*slab)[c] = t->color[c][i];
    }
    (*step)[3] = t->alpha[i], (*point)[3] = t->table.opacity[i], (*sums)[3] = t->sum_tau[i];
    (*extinction)[0] = t->tau[i], (*extinction)[3] = 0;
    (*slab)[3] = t->alpha[i] < 1 ? -log2f(1 - t->alpha[i]) : 1e6f; /* opaque at any length */
}

bool pel_gpu_tables_send(struct pel_device *device, const struct pel_classification_state *t, struct pel_texture *to,
                         struct pel_buffer *range_buffer, struct pel_error *error)
{
    size_t count = t->table.count, levels = (size_t)t->table.range.levels, row = count * levels; /* count: a multiple of TABLE_WIDTH */
    int height = (int)(count / TABLE_WIDTH) * TABLE_ROWS;
    float (*entries)[4] = pel_alloc_aligned(count * TABLE_ROWS, sizeof *entries, "look-up table", error);
    int32_t *range = entries ? pel_alloc_aligned(row + 2, sizeof *range, "range table", error) : NULL;
    bool ok = range && pel_texture_reserve(device, to, GL_RGBA32F, TABLE_WIDTH, height, 0, GL_NEAREST, error);
    if (ok) {
        for (size_t i = 0; i < count; i++)
            put_entry(t, i, entries + i / TABLE_WIDTH * TABLE_WIDTH * TABLE_ROWS + i % TABLE_WIDTH);
        glTextureSubImage2D(to->name, 0, 0, 0, TABLE_WIDTH, height, GL_RGBA, GL_FLOAT, entries);
        range[0] = (int32_t)count, range[1] = (int32_t)levels;
        memcpy(range + 2, t->table.range.most, row * sizeof(float));
        ok = pel_buffer_fill(device, range_buffer, range, (row + 2) * sizeof *range, error);
    }
    free(range);
    free(entries);
    return ok;
}

static void write_defines(char *to, size_t size, unsigned has, enum pel_mode mode)
{
    static const char *const words[] = { "VOIDS",         "NEAREST", "SHADE",     "HEADLIGHTS", "PRE",     "MINIMUM",     "BRICKS",
                                         "PREINTEGRATED", "BAND",    "EARLY_OUT", "SHOW",       "GREATER", "ONE_ISOVALUE" };
    int length = snprintf(to, size, "#define MODE_MIP %d\n#define MODE_MINIP %d\n#define MODE_ISOSURFACE %d\n#define MODE %d\n",
                          PEL_MODE_MIP, PEL_MODE_MINIP, PEL_MODE_ISOSURFACE, mode);
    for (unsigned i = 0; i < sizeof words / sizeof *words; i++)
        if (has & 1u << i)
            length += snprintf(to + length, size - (size_t)length, "#define %s\n", words[i]);
}

GLuint pel_gpu_program(struct pel_device *device, struct pel_programs *programs, const char *file, unsigned has, enum pel_mode mode,
                       struct pel_error *error)
{
    char defines[512];
    write_defines(defines, sizeof defines, has, mode);
    return pel_programs_find(device, programs, file, defines, error);
}

GLuint pel_gpu_program_drawing(struct pel_device *device, struct pel_programs *programs, const char *vertex, const char *fragment,
                               unsigned has, struct pel_error *error)
{
    char defines[512];
    write_defines(defines, sizeof defines, has, PEL_MODE_COMPOSITE);
    return pel_programs_find_drawing(device, programs, vertex, fragment, defines, error);
}
