/* SPDX-License-Identifier: MIT */
#include "raycast_gpu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "bricks.h"
#include "fail.h"
#include "gpu_cells.h"
#include "gpu_rate.h"
#include "parallel.h"
#include "rays.h"
#include "timer.h"

#define PIXEL_GROUP 8

/* A brick and what of it is on the device. */
struct brick {
    struct pel_gpu_box box;
    struct pel_texture texture;
    struct pel_gpu_cells cells;
    bool marked; /* for the transfer function of now */
    bool empty;  /* nothing in it can be seen */
    uint64_t drawn; /* the brick pass that last used it */
};

/* Milliseconds spent on bricks in a frame. */
struct spent {
    double upload, grid, classify, maps;
};

struct pel_gpu_raycaster {
    struct pel_device *device;
    struct pel_programs programs;
    struct pel_gpu_format format;
    struct pel_brick_plan plan;
    struct brick *bricks;
    int *order;
    int brick_count;
    bool in_bricks;       /* there are several */
    struct pel_minmax minmax; /* of the whole volume, where the device does not make its own */
    uint64_t budget;      /* bytes that bricks may take on the device; 0: any */
    uint64_t taken;       /* that they take */
    uint64_t passes, uploads;
    struct pel_classification_state tables;
    struct pel_job job;
    struct pel_gpu_cell_maker maker;
    struct pel_texture entries, picture, depth;
    struct pel_buffer block, counters, range;
    struct pel_gpu_timer timer;
};

struct pel_gpu_raycaster *pel_gpu_raycaster_create(struct pel_device *device, struct pel_error *error)
{
    struct pel_gpu_raycaster *rc = pel_alloc(1, sizeof *rc, "GPU ray caster", error);
    if (!rc)
        return NULL;
    rc->device = device;
    rc->maker.device = device;
    rc->maker.programs = &rc->programs;
    return rc;
}

static void release_brick(struct pel_gpu_raycaster *rc, struct brick *brick)
{
    if (brick->texture.name)
        rc->taken -= pel_bricks_bytes(&brick->box, rc->format.bytes);
    pel_texture_destroy(rc->device, &brick->texture);
    pel_gpu_cells_finish(rc->device, &brick->cells);
    brick->marked = false;
}

static void release_volume(struct pel_gpu_raycaster *rc)
{
    for (int i = 0; i < rc->brick_count; i++)
        release_brick(rc, &rc->bricks[i]);
    free(rc->bricks);
    free(rc->order);
    rc->bricks = NULL;
    rc->order = NULL;
    rc->brick_count = 0;
    pel_minmax_finish(&rc->minmax);
}

void pel_gpu_raycaster_destroy(struct pel_gpu_raycaster *rc)
{
    if (!rc)
        return;
    release_volume(rc);
    struct pel_texture *textures[] = { &rc->entries, &rc->picture, &rc->depth };
    struct pel_buffer *buffers[] = { &rc->block, &rc->counters, &rc->range };
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(rc->device, textures[i]);
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(rc->device, buffers[i]);
    pel_gpu_cell_maker_finish(&rc->maker);
    pel_programs_finish(rc->device, &rc->programs);
    pel_gpu_timer_destroy(rc->device, &rc->timer);
    pel_classify_finish(&rc->tables);
    free(rc);
}

/* The program that draws the job. */
static GLuint drawing_program(struct pel_gpu_raycaster *rc, struct pel_error *error)
{
    static const char *const files[] = {
        [PEL_MODE_COMPOSITE] = "composite.glsl", [PEL_MODE_MIP] = "extreme.glsl", [PEL_MODE_MINIP] = "extreme.glsl",
        [PEL_MODE_AVERAGE] = "average.glsl",     [PEL_MODE_XRAY] = "xray.glsl",   [PEL_MODE_ISOSURFACE] = "isosurface.glsl",
        [PEL_MODE_SLICE] = "slice.glsl",
    };
    const struct pel_job *job = &rc->job;
    const char *file = files[job->mode];
    unsigned has = (rc->format.voids ? PEL_HAS_VOIDS : 0) | (job->headlight_only ? PEL_HAS_HEADLIGHTS : 0) |
                   (job->nearest ? PEL_HAS_NEAREST : 0) | (job->mode == PEL_MODE_MINIP ? PEL_HAS_MINIMUM : 0) |
                   (rc->in_bricks ? PEL_HAS_BRICKS : 0);
    if (job->mode == PEL_MODE_COMPOSITE) {
        has |= job->shade ? PEL_HAS_SHADE : 0;
        if (!job->nearest && job->classification == PEL_CLASSIFICATION_PREINTEGRATED)
            file = "preintegrated.glsl";
        else if (!job->nearest && job->classification == PEL_CLASSIFICATION_PRE)
            has |= PEL_HAS_PRE;
    }
    return pel_gpu_program(rc->device, &rc->programs, file, has, job->mode, error);
}

/* ---- bricks on the device ---- */

static bool send_job(struct pel_gpu_raycaster *rc, const struct pel_scene *scene, const struct brick *brick, const int tile[2], bool finish,
                     struct pel_error *error)
{
    struct pel_gpu_job job = { &rc->job, scene, &rc->format, &brick->box, finish, { tile[0], tile[1] } };
    return pel_gpu_job_send(rc->device, &job, &rc->block, error);
}

static void bind(const struct pel_gpu_raycaster *rc, const struct brick *brick)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, rc->block.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_COUNTERS, rc->counters.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_RANGE, rc->range.name);
    glBindTextureUnit(PEL_UNIT_VOLUME, brick->texture.name);
    glBindTextureUnit(PEL_UNIT_DISTANCES, brick->cells.distances.name);
    glBindTextureUnit(PEL_UNIT_ENTRIES, rc->entries.name);
}

/* Makes room by the brick whose turn is farthest: of those drawn in this frame the last, else any other. False where there is none. */
static bool evict_one(struct pel_gpu_raycaster *rc, const struct brick *but)
{
    struct brick *victim = NULL;
    for (int i = 0; i < rc->brick_count; i++) {
        struct brick *b = &rc->bricks[i];
        if (b->texture.name && b != but && (!victim || b->empty > victim->empty || (b->empty == victim->empty && b->drawn > victim->drawn)))
            victim = b;
    }
    if (victim)
        release_brick(rc, victim);
    return victim;
}

static bool upload(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct brick *brick, struct pel_error *error)
{
    uint64_t need = pel_bricks_bytes(&brick->box, rc->format.bytes);
    while (rc->budget && rc->taken + need > rc->budget && evict_one(rc, brick))
        continue;
    for (;;) {
        struct pel_error why = PEL_ERROR_INIT;
        if (pel_gpu_volume_upload(rc->device, &rc->format, frame->scene->volume, brick->box.origin, brick->box.size, frame->threads,
                                  &brick->texture, &why)) {
            rc->uploads++;
            rc->taken += need;
            return true;
        }
        pel_texture_destroy(rc->device, &brick->texture);
        if (why.code != PEL_ERROR_MEMORY || !evict_one(rc, brick))
            return pel_fail(error, why.code, "%s", why.message);
    }
}

/* Hardware makes the grid of a whole volume itself; else the CPU keeps it. */
static bool grid_on_device(const struct pel_gpu_raycaster *rc)
{
    return !rc->in_bricks && !rc->device->info.software;
}

static bool make_grid(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct brick *brick, struct pel_error *error)
{
    if (grid_on_device(rc))
        return brick->cells.grid.name || pel_gpu_cells_build(&rc->maker, &brick->cells, &brick->box, rc->format.voids, error);
    return rc->minmax.cells.least || pel_minmax_init(&rc->minmax, frame->scene->volume, frame->threads, error);
}

static bool mark(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct brick *brick, struct pel_error *error)
{
    if (grid_on_device(rc))
        return pel_gpu_cells_mark(&rc->maker, &brick->cells, rc->job.mode, error);
    const struct pel_gpu_marking marking = { &rc->tables, frame->scene, &rc->minmax, rc->format.raw, &rc->job };
    return pel_gpu_cells_mark_by_cpu(&rc->maker, &brick->cells, &brick->box, &marking, error);
}

/* Sees to it that all of a brick that the job needs is on the device. */
static bool make_ready(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct brick *brick, const int tile[2],
                       struct spent *spent, struct pel_error *error)
{
    bool maps = pel_mode_has_map(rc->job.mode) && rc->job.skip;
    double start = pel_now_ms();
    if (!brick->texture.name && !upload(rc, frame, brick, error))
        return false;
    spent->upload += pel_now_ms() - start;
    if (!send_job(rc, frame->scene, brick, tile, false, error))
        return false;
    bind(rc, brick);
    start = pel_now_ms();
    if (maps && !make_grid(rc, frame, brick, error))
        return false;
    spent->grid += pel_now_ms() - start;
    start = pel_now_ms();
    if (maps && !brick->marked && !mark(rc, frame, brick, error))
        return false;
    brick->marked |= maps;
    spent->classify += pel_now_ms() - start;
    start = pel_now_ms();
    if (maps && !pel_gpu_cells_map(&rc->maker, &brick->cells, pel_rays_octants(&rc->job), error))
        return false;
    spent->maps += pel_now_ms() - start;
    bind(rc, brick); /* with the maps that there are now */
    return true;
}

static void note_spent(const struct pel_frame *frame, const struct spent *spent)
{
    const struct {
        const char *name;
        double ms;
    } stages[] = { { "upload", spent->upload }, { "min-max grid", spent->grid }, { "classify", spent->classify }, { "distance maps", spent->maps } };
    for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
        if (stages[i].ms > 0.001)
            pel_frame_stage(frame, stages[i].name, pel_now_ms() - stages[i].ms);
}

/* ---- preparing a frame ---- */

/* Bytes that a volume may take: what the caller allows, else most of what the driver says is free. */
static uint64_t find_budget(const struct pel_gpu_raycaster *rc)
{
    if (rc->device->params.memory_limit)
        return rc->device->params.memory_limit;
    uint64_t free_bytes = pel_device_free_bytes(rc->device);
    return free_bytes / 10 * 9;
}

/* Cuts the volume, where it must be or `cut` says so, and forgets what was on the device. */
static bool plan_bricks(struct pel_gpu_raycaster *rc, const struct pel_scene *scene, bool cut, struct pel_error *error)
{
    release_volume(rc);
    const struct pel_brick_limits limits = { rc->device->info.max_texture_3d, rc->budget, rc->format.bytes };
    if (!pel_bricks_plan(&rc->plan, scene->volume, pel_bricks_border(scene), &limits, cut, error))
        return false;
    int count = pel_bricks_count(&rc->plan);
    rc->in_bricks = count > 1;
    rc->bricks = pel_alloc((size_t)count, sizeof *rc->bricks, "bricks", error);
    rc->order = pel_alloc((size_t)count, sizeof *rc->order, "bricks", error);
    if (!rc->bricks || !rc->order)
        return false;
    rc->brick_count = count;
    for (int i = 0; i < count; i++)
        pel_bricks_box(&rc->plan, i, &rc->bricks[i].box);
    return true;
}

struct looking {
    struct pel_gpu_raycaster *rc;
    const struct pel_scene *scene;
};

static void look_into(void *context, size_t i, int thread)
{
    (void)thread;
    const struct looking *l = context;
    struct brick *brick = &l->rc->bricks[i];
    brick->empty = !pel_classify_box(&l->rc->tables, l->scene, &l->rc->minmax, l->rc->format.raw, &l->rc->job, brick->box.first_cell,
                                     brick->box.cells, 1, NULL);
}

/* Which bricks may be seen at all, from the whole volume's grid; all of them where nothing is passed over. */
static bool find_empty_bricks(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const bool passing = pel_mode_has_map(rc->job.mode) && rc->job.skip;
    for (int i = 0; i < rc->brick_count; i++)
        rc->bricks[i].empty = false;
    if (!passing)
        return true;
    if (!rc->minmax.cells.least) {
        double start = pel_now_ms();
        if (!pel_minmax_init(&rc->minmax, frame->scene->volume, frame->threads, error))
            return false;
        pel_frame_stage(frame, "min-max grid", start);
    }
    struct looking looking = { rc, frame->scene };
    pel_parallel_for(frame->threads, (size_t)rc->brick_count, look_into, &looking);
    return true;
}

/* The whole volume at once; in bricks after all, where the device has less memory than it told. */
static bool make_whole_ready(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    struct spent spent = { 0, 0, 0, 0 };
    struct pel_error why = PEL_ERROR_INIT;
    bool ok = make_ready(rc, frame, &rc->bricks[0], (const int[2]){ 0, 0 }, &spent, &why);
    note_spent(frame, &spent);
    if (ok)
        return true;
    if (why.code != PEL_ERROR_MEMORY || !plan_bricks(rc, frame->scene, true, NULL) || !rc->in_bricks)
        return pel_fail(error, why.code, "%s", why.message);
    return true;
}

bool pel_gpu_raycaster_prepare(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    unsigned changes = frame->changes;
    bool reclassify = changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_SETTINGS);
    rc->maker.threads = frame->threads;
    if (changes & PEL_CHANGE_VOLUME) {
        release_volume(rc);
        rc->format = pel_gpu_format_of(rc->device, scene->volume, frame->threads);
        rc->budget = find_budget(rc);
        if (!plan_bricks(rc, scene, false, error))
            return false;
    } else if (rc->in_bricks && pel_bricks_border(scene) > rc->plan.border) {
        if (!plan_bricks(rc, scene, true, error))
            return false;
        reclassify = true;
    }
    double start = pel_now_ms();
    for (int i = 0; reclassify && i < rc->brick_count; i++)
        rc->bricks[i].marked = false;
    if (reclassify || changes & PEL_CHANGE_STEP) {
        if (!pel_classify_tables(&rc->tables, scene, rc->format.raw, &rc->job, error) ||
            !pel_gpu_tables_send(rc->device, &rc->tables, &rc->entries, &rc->range, error))
            return false;
        pel_frame_stage(frame, "tables", start);
    }
    pel_rays_setup(&rc->job, scene, frame->jitter, frame->image->width, frame->image->height);
    if (!rc->in_bricks && !make_whole_ready(rc, frame, error))
        return false;
    return !rc->in_bricks || !reclassify || find_empty_bricks(rc, frame, error);
}

/* ---- drawing ---- */

static bool reserve_picture(struct pel_gpu_raycaster *rc, const struct pel_image *image, struct pel_error *error)
{
    const uint32_t none[4] = { 0 };
    const int most = rc->device->info.max_texture_2d;
    if (image->width > most || image->height > most || (uint64_t)image->width * (uint64_t)image->height > INT32_MAX / (4 * sizeof(float)))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "a picture of %d x %d is more than the GPU engine draws; use --device cpu", image->width,
                        image->height);
    return pel_texture_reserve(rc->device, &rc->picture, GL_RGBA32F, image->width, image->height, 0, GL_NEAREST, error) &&
           pel_texture_reserve(rc->device, &rc->depth, GL_R32F, image->width, image->height, 0, GL_NEAREST, error) &&
           pel_buffer_fill(rc->device, &rc->counters, none, sizeof none, error);
}

/* The tiles from (x0, y0) up to (x1, y1). */
static void dispatch_tiles(const struct pel_gpu_raycaster *rc, GLuint program, int x0, int y0, int x1, int y1)
{
    GLenum access = rc->in_bricks ? GL_READ_WRITE : GL_WRITE_ONLY;
    glUseProgram(program);
    glBindImageTexture(0, rc->picture.name, 0, GL_FALSE, 0, access, GL_RGBA32F);
    glBindImageTexture(1, rc->depth.name, 0, GL_FALSE, 0, access, GL_R32F);
    glDispatchCompute((GLuint)(x1 - x0), (GLuint)(y1 - y0), 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

/* Does the slice's plane meet the brick? */
static bool meets_slice(const struct pel_job *job, const double lo[3], const double hi[3])
{
    double least = job->slice_plane[3], most = job->slice_plane[3];
    for (int a = 0; a < 3; a++) {
        least += fmin(job->slice_plane[a] * lo[a], job->slice_plane[a] * hi[a]);
        most += fmax(job->slice_plane[a] * lo[a], job->slice_plane[a] * hi[a]);
    }
    return least <= 0 && most >= 0;
}

/* The tiles of the picture that a brick's samples can fall on; false: none. */
static bool brick_tiles(const struct pel_gpu_raycaster *rc, const struct pel_scene *scene, const struct brick *brick, int tiles[4])
{
    double lo[3], hi[3];
    int rectangle[4];
    for (int a = 0; a < 3; a++) { /* with a margin for the places' rounding */
        lo[a] = fmax(brick->box.first[a], rc->job.box_lo[a]) - 0.01;
        hi[a] = fmin(brick->box.last[a], rc->job.box_hi[a]) + 0.01;
    }
    if (brick->empty || (rc->job.mode == PEL_MODE_SLICE && !meets_slice(&rc->job, lo, hi)) ||
        !pel_rays_rectangle(&rc->job, scene->camera.parallel, lo, hi, rectangle))
        return false;
    for (int i = 0; i < 2; i++) {
        tiles[i] = rectangle[i] / PIXEL_GROUP;
        tiles[2 + i] = (rectangle[2 + i] - 1) / PIXEL_GROUP + 1;
    }
    return true;
}

/* From front to back, each gathering on in the picture what those before it left; then what was gathered becomes the picture. */
static bool draw_bricks(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, GLuint program, struct pel_error *error)
{
    const float nothing[4] = { 0 }, nowhere = -1;
    const int none[2] = { 0, 0 };
    struct spent spent = { 0, 0, 0, 0 };
    glClearTexImage(rc->picture.name, 0, GL_RGBA, GL_FLOAT, nothing);
    glClearTexImage(rc->depth.name, 0, GL_RED, GL_FLOAT, &nowhere);
    if (!pel_bricks_sort(&rc->plan, &rc->job, frame->scene->camera.parallel, rc->order, error))
        return false;
    for (int i = 0; i < rc->brick_count; i++) {
        struct brick *brick = &rc->bricks[rc->order[i]];
        int tiles[4];
        if (!brick_tiles(rc, frame->scene, brick, tiles))
            continue;
        brick->drawn = ++rc->passes;
        if (!make_ready(rc, frame, brick, tiles, &spent, error))
            return false;
        dispatch_tiles(rc, program, tiles[0], tiles[1], tiles[2], tiles[3]);
    }
    const struct pel_image *image = frame->image;
    if (!send_job(rc, frame->scene, &rc->bricks[0], none, true, error))
        return false;
    bind(rc, &rc->bricks[0]);
    dispatch_tiles(rc, program, 0, 0, (image->width - 1) / PIXEL_GROUP + 1, (image->height - 1) / PIXEL_GROUP + 1);
    note_spent(frame, &spent);
    return true;
}

static bool cast_rays(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_image *image = frame->image;
    GLuint program = drawing_program(rc, error);
    if (!program)
        return false;
    double start = pel_now_ms();
    pel_gpu_timer_begin(rc->device, &rc->timer, "raycast: cast rays");
    bool ok = true;
    if (rc->in_bricks) {
        ok = draw_bricks(rc, frame, program, error);
    } else {
        bind(rc, &rc->bricks[0]);
        dispatch_tiles(rc, program, 0, 0, (image->width - 1) / PIXEL_GROUP + 1, (image->height - 1) / PIXEL_GROUP + 1);
    }
    pel_gpu_timer_end(&rc->timer);
    double gpu_ms = pel_gpu_timer_ms(&rc->timer);
    pel_frame_stage_gpu(frame, "cast rays", start, gpu_ms);
    return ok;
}

static bool read_back(struct pel_gpu_raycaster *rc, struct pel_image *image, struct pel_error *error)
{
    GLsizei pixels = image->width * image->height;
    glGetTextureImage(rc->picture.name, 0, GL_RGBA, GL_FLOAT, pixels * 4 * (GLsizei)sizeof(float), image->rgba);
    if (image->depth)
        glGetTextureImage(rc->depth.name, 0, GL_RED, GL_FLOAT, pixels * (GLsizei)sizeof(float), image->depth);
    return pel_device_check(rc->device, "reading the picture back", error);
}

static void note_counters(struct pel_gpu_raycaster *rc, const struct pel_frame *frame)
{
    uint32_t counted[4] = { 0 };
    glGetNamedBufferSubData(rc->counters.name, 0, sizeof counted, counted);
    uint64_t taken = counted[0] | (uint64_t)counted[1] << 32, in_box = counted[2] | (uint64_t)counted[3] << 32, cells = 1;
    int resident = 0;
    for (int a = 0; a < 3; a++)
        cells *= (uint64_t)((rc->plan.dims[a] - 1) / PEL_CELL_SIZE + 1);
    for (int i = 0; i < rc->brick_count; i++)
        resident += rc->bricks[i].texture.name != 0;
    pel_frame_count(frame, "samples taken", taken);
    pel_frame_count(frame, "samples skipped", in_box > taken ? in_box - taken : 0);
    pel_frame_count(frame, "cells", cells);
    if (!rc->in_bricks) /* else those of bricks that are not there are not known */
        pel_frame_count(frame, "cells that may be seen", rc->bricks[0].cells.visible);
    pel_frame_count(frame, "bytes on the device", rc->device->bytes);
    if (rc->in_bricks) {
        pel_frame_count(frame, "bricks", (uint64_t)rc->brick_count);
        pel_frame_count(frame, "bricks on the device", (uint64_t)resident);
        pel_frame_count(frame, "bricks sent", rc->uploads);
    }
    rc->uploads = 0;
}

bool pel_gpu_raycaster_draw(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    if (!reserve_picture(rc, frame->image, error) || !cast_rays(rc, frame, error))
        return false;
    double start = pel_now_ms();
    bool ok = read_back(rc, frame->image, error);
    pel_frame_stage(frame, "read back", start);
    note_counters(rc, frame);
    return ok && pel_device_check(rc->device, "counters", error);
}

bool pel_gpu_raycaster_sample_limit(struct pel_gpu_raycaster *rc, double *samples_per_second, struct pel_error *error)
{
    if (rc->in_bricks || !rc->brick_count || !rc->bricks[0].texture.name || !rc->picture.name)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the device does not hold the volume whole");
    const GLenum filter = rc->format.voids ? GL_NEAREST : GL_LINEAR;
    const struct pel_gpu_rate rate = { &rc->programs, &rc->bricks[0].texture, filter, &rc->picture, &rc->counters };
    bind(rc, &rc->bricks[0]);
    return pel_gpu_rate_measure(rc->device, &rate, samples_per_second, error);
}
