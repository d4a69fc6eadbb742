/* SPDX-License-Identifier: MIT */
/* The bricks of a volume, and what of them is on the device: voxels, cells and marks come when a brick is drawn, and where the device has
 * room for some only, they go again (bricks.h says where bricks lie). A volume that fits is a set of one brick. */
#ifndef PEL_RENDER_BRICK_SET_H
#define PEL_RENDER_BRICK_SET_H

#include "bricks.h"
#include "gpu_cells.h"
#include "technique.h"

struct pel_brick {
    struct pel_gpu_box box;
    struct pel_texture texture;
    struct pel_gpu_cells cells;
    bool marked;    /* for the transfer function of now */
    bool empty;     /* nothing in it can be seen */
    uint64_t drawn; /* the pass that last used it */
};

struct pel_brick_set {
    struct pel_gpu_cell_maker maker; /* with the device */
    struct pel_gpu_format format;
    struct pel_brick_plan plan;
    struct pel_brick *bricks; /* owned */
    int count;
    struct pel_minmax minmax; /* of the whole volume, where the device does not make its own */
    uint64_t budget, taken;   /* bytes that bricks may take on the device (0: any), and that they take */
    uint64_t passes, uploads;
    uint64_t this_frame, last_frame; /* their first passes */
    struct pel_brick_times {
        double upload, grid, classify, maps; /* milliseconds since they were noted */
    } times;
};

/* The device and the programs are borrowed. */
void pel_brick_set_init(struct pel_brick_set *set, struct pel_device *device, struct pel_programs *programs);
void pel_brick_set_finish(struct pel_brick_set *set);

/* Takes a volume: forgets what was on the device, and plans bricks for the memory that there is. */
bool pel_brick_set_volume(struct pel_brick_set *set, const struct pel_frame *frame, struct pel_error *error);
/* Plans anew for the scene's step; `cut`: in bricks even where the whole would fit. */
bool pel_brick_set_plan(struct pel_brick_set *set, const struct pel_scene *scene, bool cut, struct pel_error *error);

/* After a new classification: marks are to be made anew. */
void pel_brick_set_unmark(struct pel_brick_set *set);
/* Finds the bricks in which nothing can be seen, from the whole volume's grid; none where the job passes over nothing. */
bool pel_brick_set_find_empty(struct pel_brick_set *set, struct pel_classification_state *tables, const struct pel_job *job,
                              const struct pel_frame *frame, struct pel_error *error);

/* Begins a frame in which bricks are brought. */
void pel_brick_set_frame(struct pel_brick_set *set);
/* Makes room on the device by the brick whose turn is farthest, but not by this one. False: there is none. */
bool pel_brick_set_make_room(struct pel_brick_set *set, const struct pel_brick *but);
/* Sees to it that the brick's voxels are on the device, if need be in place of other bricks'. */
bool pel_brick_set_bring(struct pel_brick_set *set, struct pel_brick *brick, const struct pel_frame *frame, struct pel_error *error);
/* Then, with the brick's uniform block and voxels bound: its marks and distance maps, where the job passes over cells. */
bool pel_brick_set_map(struct pel_brick_set *set, struct pel_brick *brick, struct pel_classification_state *tables,
                       const struct pel_job *job, const struct pel_frame *frame, struct pel_error *error);

/* Milliseconds spent since they were noted. */
double pel_brick_set_spent(const struct pel_brick_set *set);
/* Notes the times as stages of the frame, and begins anew. */
void pel_brick_set_note(struct pel_brick_set *set, const struct pel_frame *frame);

#endif
