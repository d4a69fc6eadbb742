/* SPDX-License-Identifier: MIT */
/* Multi-layer depth peeling by single-pass rasterisation (Liu, Clapworthy and Dong 2010), on the GPU engine. The paper's three stages:
 *
 *   1 active cells (4.1)     peel_cells.c, peel_ranges.c, peel_range.glsl, peel_active.glsl,
 *                            ../gpu/histopyramid*                            when an isovalue changes
 *   2 masks (4.2)            peel_masks.c, peel_cover.glsl and the shaders of its two ways           every frame
 *   3 segments, rays (4.3)   peel.c, peel_tiles.c, peel_segments.glsl, peel_cast.glsl, cells.glsl    every frame
 *
 * peel.c makes a frame of them; peel_technique.c has the options and says what is refused. */
#ifndef PEL_PEEL_H
#define PEL_PEEL_H

#include "drawing.h"
#include "gpu_frame.h"
#include "gpu_job.h"
#include "histopyramid.h"
#include "technique.h"

enum pel_peel_cover { PEL_COVER_DISC, PEL_COVER_BOX };
enum pel_mask_path { PEL_MASKS_AUTO, PEL_MASKS_RASTER, PEL_MASKS_COMPUTE };

struct pel_peel_options {
    int granularity; /* voxel steps along an edge of a macro-cell */
    bool interior;   /* skip what is empty between the first layer and the last, too */
    enum pel_peel_cover cover;
    enum pel_mask_path path;
    bool bisect;     /* the refinement of the paper, where surfaces are found by steps */
    enum pel_peel_skipping { PEL_BY_MASKS, PEL_BY_TREE } skipping;
};

enum { PEL_TREE_LEVELS = 12 };

/* The shaders' PeelBlock (peel_block.glsl), in the same order. */
struct pel_peel_block {
    float to_pixel[3][4], from[4];
    int32_t grid[4], major[4], tile[4], wide[4], tree[PEL_TREE_LEVELS];
};

/* Texture units and buffers beside those of gpu_job.h. */
enum {
    PEL_UNIT_RANGES = 2,
    PEL_UNIT_MASKS = 5,
    PEL_UNIT_MASK_TABLE = 6,
    PEL_BUFFER_PEEL_COUNTERS = 7,
    PEL_BUFFER_TREE,
    PEL_BUFFER_TILES = PEL_BUFFER_TREE, /* with a tree there are no masks to list tiles by */
    PEL_BLOCK_PEEL = 1
};
enum pel_peel_stage { PEL_STAGE_ACTIVE, PEL_STAGE_MASKS, PEL_STAGE_CAST, PEL_PEEL_STAGES };

struct pel_peel {
    struct pel_device *device;
    struct pel_programs programs;
    struct pel_peel_options options; /* of the frame; set by prepare */

    /* With the volume. */
    struct pel_gpu_format format;
    struct pel_gpu_box box;
    struct pel_texture volume;
    struct pel_texture ranges; /* of macro-cells */
    int granularity;           /* that they have; 0: there are none */
    struct pel_buffer tree;    /* levels above them; only where the options ask for it */
    bool planted;              /* it is that of the ranges */

    /* With the isovalues. */
    struct pel_histopyramid pyramid;
    bool counted; /* its cells are those of the present isovalues */

    /* With the view. */
    struct pel_job job;
    struct pel_peel_block view;
    bool skip;     /* of the frame; else whole rays */
    int screen[4]; /* of the picture: the rectangle on to which the volume projects, by whole tiles of 8; [2] is 0 where it is nowhere */
    struct pel_buffer block, view_block, counters, segments, listed;
    struct pel_texture masks[2], mask_table, picture, depth; /* masks: of the two ways to make them */
    struct pel_target target;
    struct pel_vertices vertices;

    enum pel_mask_path chosen; /* by measuring; PEL_MASKS_AUTO: not yet */
    struct pel_gpu_stage stages[PEL_PEEL_STAGES];
    int tiles; /* of the screen, each with masks of its own */
};

/* ---- peel.c ---- */

struct pel_peel *pel_peel_create(struct pel_device *device, struct pel_error *error);
void pel_peel_destroy(struct pel_peel *peel); /* accepts NULL */
bool pel_peel_prepare(struct pel_peel *peel, const struct pel_frame *frame, struct pel_error *error);
bool pel_peel_draw(struct pel_peel *peel, const struct pel_frame *frame, struct pel_error *error);

/* Bytes of the volume, of what was made of its cells, and of the tree: what the memory allowed is held against. */
uint64_t pel_peel_held(const struct pel_peel *peel);

/* Sends the PeelBlock with this rectangle of the screen as its tile, and binds it. */
bool pel_peel_send_view(struct pel_peel *peel, const int tile[4], struct pel_error *error);

/* ---- peel_view.c ---- */

/* Where index positions are on the screen, the major axis and its sign, and the rectangle that the volume covers. The job's rays are set
 * up, the macro-cells' size is granularity. */
bool pel_peel_view_setup(struct pel_peel *peel, bool parallel, struct pel_error *error);
/* The grid of macro-cells, and the slices along the major axis. */
void pel_peel_grid(const struct pel_job *job, int granularity, int grid[4]);

/* ---- peel_cells.c: stage 1 ---- */

/* The macro-cells' ranges, where they are not there yet: by a shader, or on software devices by the CPU. */
bool pel_peel_find_ranges(struct pel_peel *peel, const struct pel_frame *frame, struct pel_error *error);
/* The active ones among them, in the pyramid. */
bool pel_peel_find_active(struct pel_peel *peel, struct pel_error *error);

/* The min-max tree over the ranges, where it is not there yet. */
bool pel_peel_plant_tree(struct pel_peel *peel, struct pel_error *error);

/* ---- peel_ranges.c: stage 1 by the CPU ---- */

/* Makes the macro-cells' ranges and sends them into their texture. */
bool pel_peel_send_ranges(struct pel_peel *peel, const struct pel_volume *volume, int threads, struct pel_error *error);

/* ---- peel_masks.c: stage 2 ---- */

/* Sides of the rectangles of the screen whose masks are made at once: as much as memory allows. False where it allows none. */
bool pel_peel_mask_tile(const struct pel_peel *peel, int sides[2], struct pel_error *error);
/* The masks of a rectangle by a way (not auto), which leaves them bound, and the layers that they have. */
bool pel_peel_make_masks(struct pel_peel *peel, enum pel_mask_path path, const int tile[4], struct pel_error *error);
/* The way that the options ask for; measured on this rectangle at first where they do not say. */
bool pel_peel_choose_path(struct pel_peel *peel, const int tile[4], enum pel_mask_path *path, struct pel_error *error);
/* The table that tells the runs of a mask, at its first use. */
bool pel_peel_mask_table(struct pel_peel *peel, struct pel_error *error);
int pel_peel_layers(const struct pel_peel *peel, enum pel_mask_path path);

/* ---- peel_tiles.c: stage 3, where rays are cast ---- */

/* A rectangle of the screen in strips of whole rows of tiles, a dispatch each. */
struct pel_peel_strips {
    int first[2];          /* tile of the picture */
    int columns, all_rows; /* tiles of the rectangle */
    int rows, count;       /* of a strip (the last may have fewer); strips */
};

/* Lists the tiles of the rectangle whose masks are bound that have any, and binds the list. */
bool pel_peel_list_tiles(struct pel_peel *peel, const struct pel_peel_strips *strips, struct pel_error *error);
/* Dispatches the current program over a strip's listed tiles. */
void pel_peel_dispatch_strip(const struct pel_peel_strips *strips, GLuint program, int strip);

#endif
