/* SPDX-License-Identifier: MIT */
/* The scheduler of section 10: "While user interaction events are scheduled in the event queue, performance optimization is used to provide
 * high frame rate. In consequence, if the event queue is empty, image quality is optimized." What frames cost is measured, not guessed. */
#ifndef PEL_RENDER_SLICES2D_SCHEDULE_H
#define PEL_RENDER_SLICES2D_SCHEDULE_H

#include <stdbool.h>

/* How a frame is drawn: options of slices2d. */
struct pel_slices2d_quality {
    int supersampling;      /* 1..10 */
    int every;              /* one slice for so many slices of voxels: 1 to 8 */
    int slices_per_polygon; /* 1, 2, 4, 8 */
};

struct pel_slices2d_scheduler {
    double ms_per_slice[4]; /* with 1, 2, 4 and 8 slices a polygon; 0: not measured yet. Zeroed to begin with */
    bool no_polygons;       /* slices a polygon make no difference: nothing is there to try */
};

/* Slices of a frame of that quality, where `voxels` slices of voxels lie along the view. */
int pel_slices2d_scheduled(const struct pel_slices2d_quality *quality, int voxels);

/* Takes in what a frame cost; a change of scene or size shows after some frames. */
void pel_slices2d_measured(struct pel_slices2d_scheduler *scheduler, const struct pel_slices2d_quality *quality, int voxels, double ms);

/* The next frame's quality. At rest: `best`, with the number of slices a polygon that costs least. Under interaction: the finest sampling,
 * at most the best, whose frame stays within the budget as far as is known; numbers of slices a polygon that were not tried yet are tried.
 */
struct pel_slices2d_quality pel_slices2d_schedule(const struct pel_slices2d_scheduler *scheduler, bool interacting, double budget_ms,
                                                  int voxels, const struct pel_slices2d_quality *best);

#endif
