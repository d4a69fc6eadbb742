/* SPDX-License-Identifier: MIT */
#include "raycast_gpu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "brick_set.h"
#include "fail.h"
#include "gpu_frame.h"
#include "gpu_rate.h"
#include "rays.h"
#include "timer.h"

#define COUNTER_ROWS 64
#define STRIP_SAMPLES 3e8 /* in one dispatch: no driver may take it for a hang */

struct pel_gpu_raycaster {
    struct pel_device *device;
    struct pel_programs programs;
    struct pel_brick_set set;
    int *order; /* of the bricks, from front to back */
    int order_room;
    struct pel_classification_state tables;
    struct pel_job job;
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
    pel_brick_set_init(&rc->set, device, &rc->programs);
    return rc;
}

void pel_gpu_raycaster_destroy(struct pel_gpu_raycaster *rc)
{
    if (!rc)
        return;
    pel_brick_set_finish(&rc->set);
    struct pel_texture *textures[] = { &rc->entries, &rc->picture, &rc->depth };
    struct pel_buffer *buffers[] = { &rc->block, &rc->counters, &rc->range };
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        pel_texture_destroy(rc->device, textures[i]);
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        pel_buffer_destroy(rc->device, buffers[i]);
    pel_programs_finish(rc->device, &rc->programs);
    pel_gpu_timer_destroy(rc->device, &rc->timer);
    pel_classify_finish(&rc->tables);
    free(rc->order);
    free(rc);
}

static bool in_bricks(const struct pel_gpu_raycaster *rc)
{
    return rc->set.count > 1;
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
    unsigned has = (rc->set.format.voids ? PEL_HAS_VOIDS : 0) | (job->headlight_only ? PEL_HAS_HEADLIGHTS : 0) |
                   (job->nearest ? PEL_HAS_NEAREST : 0) | (job->mode == PEL_MODE_MINIP ? PEL_HAS_MINIMUM : 0) |
                   (in_bricks(rc) ? PEL_HAS_BRICKS : 0);
    if (job->mode == PEL_MODE_COMPOSITE) {
        has |= job->shade ? PEL_HAS_SHADE : 0;
        if (!job->nearest && job->classification == PEL_CLASSIFICATION_PREINTEGRATED)
            file = "preintegrated.glsl";
        else if (!job->nearest && job->classification == PEL_CLASSIFICATION_PRE)
            has |= PEL_HAS_PRE;
    }
    if (job->mode == PEL_MODE_ISOSURFACE) {
        has |= job->iso_count == 1 ? PEL_HAS_ONE_ISOVALUE : 0;
        if (job->roots == PEL_ROOTS_CUBIC)
            file = "isosurface_cells.glsl";
    }
    return pel_gpu_program(rc->device, &rc->programs, file, has, job->mode, error);
}

/* ---- preparing a frame ---- */

static bool send_job(struct pel_gpu_raycaster *rc, const struct pel_scene *scene, const struct pel_brick *brick, struct pel_error *error)
{
    const struct pel_gpu_job job = { &rc->job, scene, &rc->set.format, &brick->box };
    return pel_gpu_job_send(rc->device, &job, &rc->block, error);
}

/* Binding nothing would empty the unit of a host's textures of all kinds. */
static void bind_texture(GLuint unit, const struct pel_texture *texture)
{
    if (texture->name)
        glBindTextureUnit(unit, texture->name);
}

static void bind(const struct pel_gpu_raycaster *rc, const struct pel_brick *brick)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, rc->block.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_COUNTERS, rc->counters.name);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_BUFFER_RANGE, rc->range.name);
    bind_texture(PEL_UNIT_VOLUME, &brick->texture);
    bind_texture(PEL_UNIT_DISTANCES, &brick->cells.distances);
    bind_texture(PEL_UNIT_ENTRIES, &rc->entries);
}

static bool try_ready(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_brick *brick, struct pel_error *error)
{
    if (!pel_brick_set_bring(&rc->set, brick, frame, error) || !send_job(rc, frame->scene, brick, error))
        return false;
    bind(rc, brick);
    if (!pel_brick_set_map(&rc->set, brick, &rc->tables, &rc->job, frame, error))
        return false;
    bind(rc, brick); /* with the maps that there are now */
    return true;
}

/* Sees to it that all of a brick that the job needs is on the device, and bound: in place of other bricks where memory is short. */
static bool make_ready(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_brick *brick, struct pel_error *error)
{
    struct pel_error why = PEL_ERROR_INIT;
    bool ok;
    while (!(ok = try_ready(rc, frame, brick, &why)) && why.code == PEL_ERROR_MEMORY && pel_brick_set_make_room(&rc->set, brick))
        why = (struct pel_error)PEL_ERROR_INIT;
    return ok || pel_fail(error, why.code, "%s", why.message);
}

/* The whole volume at once; in bricks after all, where the device has less memory than it told. */
static bool make_whole_ready(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    struct pel_error why = PEL_ERROR_INIT;
    bool ok = make_ready(rc, frame, &rc->set.bricks[0], &why);
    if (ok || (why.code == PEL_ERROR_MEMORY && pel_brick_set_plan(&rc->set, frame->scene, true, NULL) && in_bricks(rc)))
        return true;
    return pel_fail(error, why.code, "%s", why.message);
}

bool pel_gpu_raycaster_prepare(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    const struct pel_scene *scene = frame->scene;
    unsigned changes = frame->changes;
    bool reclassify = changes & (PEL_CHANGE_VOLUME | PEL_CHANGE_TRANSFER | PEL_CHANGE_ISOSURFACES | PEL_CHANGE_SETTINGS),
         new_tables = reclassify || changes & PEL_CHANGE_STEP;
    if (changes & PEL_CHANGE_VOLUME) {
        if (!pel_brick_set_volume(&rc->set, frame, error))
            return false;
    } else if (in_bricks(rc) && pel_bricks_border(scene) > rc->set.plan.border && !pel_brick_set_plan(&rc->set, scene, true, error)) {
        return false;
    }
    double start = pel_now_ms();
    if (reclassify)
        pel_brick_set_unmark(&rc->set);
    if (new_tables) {
        if (!pel_classify_tables(&rc->tables, scene, rc->set.format.raw, &rc->job, error) ||
            !pel_gpu_tables_send(rc->device, &rc->tables, &rc->entries, &rc->range, error))
            return false;
        pel_frame_stage(frame, "tables", start);
    }
    pel_rays_setup(&rc->job, scene, frame->jitter, frame->image->width, frame->image->height);
    bool ok = in_bricks(rc) || make_whole_ready(rc, frame, error);
    /* A longer step may end skipping, and with it what is empty. */
    ok = ok && (!in_bricks(rc) || !new_tables || pel_brick_set_find_empty(&rc->set, &rc->tables, &rc->job, frame, error));
    if (ok)
        pel_brick_set_note(&rc->set, frame);
    return ok;
}

/* ---- drawing ---- */

static bool reserve_picture(struct pel_gpu_raycaster *rc, const struct pel_image *image, struct pel_error *error)
{
    const uint32_t none[COUNTER_ROWS][4] = { { 0 } };
    return pel_gpu_check_picture(rc->device, image, "; use --device cpu", error) &&
           pel_texture_reserve(rc->device, &rc->picture, GL_RGBA32F, image->width, image->height, 0, GL_NEAREST, error) &&
           pel_texture_reserve(rc->device, &rc->depth, GL_R32F, image->width, image->height, 0, GL_NEAREST, error) &&
           pel_buffer_fill(rc->device, &rc->counters, none, sizeof none, error);
}

/* Tile rows in one dispatch, from the samples that rays can have. */
static int strip_rows(const struct pel_gpu_raycaster *rc, const struct pel_frame *frame, int columns)
{
    double bounds[6], diagonal = 0;
    pel_volume_bounds(frame->scene->volume, bounds);
    for (int a = 0; a < 3; a++)
        diagonal += (bounds[2 * a + 1] - bounds[2 * a]) * (bounds[2 * a + 1] - bounds[2 * a]);
    double row = (sqrt(diagonal) / rc->job.step + 1) * columns * PEL_TILE_SIDE * PEL_TILE_SIDE;
    return (int)fmin(fmax(STRIP_SAMPLES / row, 1), 1 << 20);
}

/* Draws the tiles from (x0, y0) up to (x1, y1), in strips; `fractions` of the frame are done before and after. */
static bool draw_tiles(const struct pel_gpu_raycaster *rc, const struct pel_frame *frame, GLuint program, const int tiles[4], bool finish,
                       const double fractions[2], struct pel_error *error)
{
    GLenum access = in_bricks(rc) ? GL_READ_WRITE : GL_WRITE_ONLY;
    int rows = finish ? tiles[3] : strip_rows(rc, frame, tiles[2] - tiles[0]);
    glUseProgram(program);
    glBindImageTexture(0, rc->picture.name, 0, GL_FALSE, 0, access, GL_RGBA32F);
    glBindImageTexture(1, rc->depth.name, 0, GL_FALSE, 0, access, GL_R32F);
    for (int y = tiles[1]; y < tiles[3]; y += rows) {
        int count = tiles[3] - y < rows ? tiles[3] - y : rows;
        double done = (double)(y - tiles[1]) / (tiles[3] - tiles[1]);
        if (!pel_progress_report(frame->progress, fractions[0] + done * (fractions[1] - fractions[0]), error))
            return false;
        glProgramUniform4i(program, 0, tiles[0], y, finish, 0);
        glDispatchCompute((GLuint)(tiles[2] - tiles[0]), (GLuint)count, 1);
        glFlush();
    }
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    return true;
}

/* All tiles of the picture. */
static void whole_picture(const struct pel_image *image, int tiles[4])
{
    tiles[0] = tiles[1] = 0;
    tiles[2] = (image->width - 1) / PEL_TILE_SIDE + 1;
    tiles[3] = (image->height - 1) / PEL_TILE_SIDE + 1;
}

/* Does any of the slices' planes meet the brick? */
static bool meets_slice(const struct pel_job *job, const double lo[3], const double hi[3])
{
    bool meets = false;
    for (int i = 0; i < job->slice_count; i++) {
        const double *plane = job->slice_planes[i];
        double least = plane[3], most = plane[3];
        for (int a = 0; a < 3; a++) {
            least += fmin(plane[a] * lo[a], plane[a] * hi[a]);
            most += fmax(plane[a] * lo[a], plane[a] * hi[a]);
        }
        meets |= least <= 0 && most >= 0;
    }
    return meets;
}

/* The tiles of the picture that a brick's samples can fall on; false: none. */
static bool brick_tiles(const struct pel_gpu_raycaster *rc, const struct pel_scene *scene, const struct pel_brick *brick, int tiles[4])
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
        tiles[i] = rectangle[i] / PEL_TILE_SIDE;
        tiles[2 + i] = (rectangle[2 + i] - 1) / PEL_TILE_SIDE + 1;
    }
    return true;
}

static bool reserve_order(struct pel_gpu_raycaster *rc, struct pel_error *error)
{
    if (rc->order_room >= rc->set.count)
        return true;
    free(rc->order);
    rc->order = pel_alloc((size_t)rc->set.count, sizeof *rc->order, "the order of bricks", error);
    rc->order_room = rc->order ? rc->set.count : 0;
    return rc->order;
}

/* From front to back, each gathering on in the picture what those before it left; then what was gathered becomes the picture. */
static bool draw_bricks(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, GLuint program, struct pel_error *error)
{
    const float nothing[4] = { 0 }, nowhere = -1;
    const int count = rc->set.count;
    int tiles[4];
    glClearTexImage(rc->picture.name, 0, GL_RGBA, GL_FLOAT, nothing);
    glClearTexImage(rc->depth.name, 0, GL_RED, GL_FLOAT, &nowhere);
    if (!reserve_order(rc, error) || !pel_bricks_sort(&rc->set.plan, &rc->job, frame->scene->camera.parallel, rc->order, error))
        return false;
    pel_brick_set_frame(&rc->set);
    for (int i = 0; i < count; i++) {
        struct pel_brick *brick = &rc->set.bricks[rc->order[i]];
        const double fractions[2] = { (double)i / count, (i + 1.0) / count };
        if (brick_tiles(rc, frame->scene, brick, tiles) && (!make_ready(rc, frame, brick, error) ||
                                                            !draw_tiles(rc, frame, program, tiles, false, fractions, error)))
            return false;
    }
    if (!send_job(rc, frame->scene, &rc->set.bricks[0], error))
        return false;
    bind(rc, &rc->set.bricks[0]);
    whole_picture(frame->image, tiles);
    return draw_tiles(rc, frame, program, tiles, true, (const double[2]){ 1, 1 }, error);
}

static bool cast_rays(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    int tiles[4];
    GLuint program = drawing_program(rc, error);
    if (!program)
        return false;
    double start = pel_now_ms();
    pel_gpu_timer_begin(rc->device, &rc->timer, "raycast: cast rays");
    bool ok, many = in_bricks(rc);
    if (many) {
        ok = draw_bricks(rc, frame, program, error);
    } else {
        bind(rc, &rc->set.bricks[0]);
        whole_picture(frame->image, tiles);
        ok = draw_tiles(rc, frame, program, tiles, false, (const double[2]){ 0, 1 }, error);
    }
    pel_gpu_timer_end(&rc->timer);
    glFinish();
    /* Bricks are sent and mapped in between: that has stages of its own, and the GPU's clock does not tell it apart. */
    pel_frame_stage_gpu(frame, "cast rays", start + pel_brick_set_spent(&rc->set),
                        many || rc->device->info.software ? -1 : pel_gpu_timer_ms(&rc->timer));
    pel_brick_set_note(&rc->set, frame);
    return ok;
}

static void note_counters(struct pel_gpu_raycaster *rc, const struct pel_frame *frame)
{
    uint32_t counted[COUNTER_ROWS][4] = { { 0 } };
    glGetNamedBufferSubData(rc->counters.name, 0, sizeof counted, counted);
    uint64_t taken = 0, in_box = 0, cells = 1;
    for (int i = 0; i < COUNTER_ROWS; i++) {
        taken += counted[i][0] | (uint64_t)counted[i][1] << 32;
        in_box += counted[i][2] | (uint64_t)counted[i][3] << 32;
    }
    int resident = 0;
    for (int a = 0; a < 3; a++)
        cells *= (uint64_t)((rc->set.plan.dims[a] - 1) / PEL_CELL_SIZE + 1);
    for (int i = 0; i < rc->set.count; i++)
        resident += rc->set.bricks[i].texture.name != 0;
    pel_frame_count(frame, "samples taken", taken);
    pel_frame_count(frame, "samples skipped", in_box > taken ? in_box - taken : 0);
    pel_frame_count(frame, "cells", cells);
    if (!in_bricks(rc)) /* else those of bricks that are not there are not known */
        pel_frame_count(frame, "cells that may be seen", pel_gpu_cells_visible(&rc->set.maker, &rc->set.bricks[0].cells));
    pel_frame_count(frame, "bytes on the device", rc->device->bytes);
    if (in_bricks(rc)) {
        pel_frame_count(frame, "bricks", (uint64_t)rc->set.count);
        pel_frame_count(frame, "bricks on the device", (uint64_t)resident);
        pel_frame_count(frame, "bricks sent", rc->set.uploads);
    }
    rc->set.uploads = 0;
}

bool pel_gpu_raycaster_draw(struct pel_gpu_raycaster *rc, const struct pel_frame *frame, struct pel_error *error)
{
    if (!reserve_picture(rc, frame->image, error) || !cast_rays(rc, frame, error))
        return false;
    double start = pel_now_ms();
    bool ok = pel_gpu_read_back(rc->device, &rc->picture, &rc->depth, frame->image, error);
    pel_frame_stage(frame, "read back", start);
    note_counters(rc, frame);
    return ok && pel_device_check(rc->device, "counters", error);
}

bool pel_gpu_raycaster_sample_limit(struct pel_gpu_raycaster *rc, double *samples_per_second, struct pel_error *error)
{
    if (in_bricks(rc) || !rc->set.count || !rc->set.bricks[0].texture.name || !rc->picture.name)
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "the device does not hold the volume whole");
    const GLenum filter = rc->set.format.voids ? GL_NEAREST : GL_LINEAR;
    const struct pel_gpu_rate rate = { &rc->programs, &rc->set.bricks[0].texture, filter, &rc->picture, &rc->counters };
    bind(rc, &rc->set.bricks[0]);
    return pel_gpu_rate_measure(rc->device, &rate, samples_per_second, error);
}
