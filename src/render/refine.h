/* SPDX-License-Identifier: MIT */
/* Refinement at rest: frames of a view that does not change are averaged, each with its samples elsewhere in their steps, so that what the
 * step leaves (rings, noise, thin things missed) fades. What is kept is a sum of pictures, whatever drew them; the renderer decides when a
 * view is the same (renderer.c). */
#ifndef PEL_RENDER_REFINE_H
#define PEL_RENDER_REFINE_H

#include <pellucid/image.h>
#include <pellucid/scene.h>

struct pel_refinement {
    bool begun;         /* the view's first frame was drawn */
    size_t technique;   /* its number: a view belongs to one */
    int wanted, frames; /* jittered frames: that the picture shall hold, that the sum holds */
    bool moved, still;  /* the first three jittered frames differ; are equal, so that jitter is taken to move nothing */
    size_t pixels;      /* of the planes */
    float *sum;         /* owned, or NULL before the first jittered frame: RGBA of the frames, added */
    float *depth;       /* owned, or NULL where no depth was asked for: of the first frame */
};

/* Forgets the view; its memory is used again. */
void pel_refine_restart(struct pel_refinement *refinement);
void pel_refine_finish(struct pel_refinement *refinement); /* accepts a zeroed one */

/* May the view's next frame be a refined one of such a picture? Else it is a first frame. */
bool pel_refine_continues(const struct pel_refinement *refinement, size_t technique, const struct pel_image *image);

/* How refined frames are drawn: jittered, at half a voxel. */
void pel_refine_settings(struct pel_render_settings *settings);

/* Notes the first frame of a view, drawn into `image`. */
bool pel_refine_begin(struct pel_refinement *refinement, size_t technique, int wanted, const struct pel_image *image,
                      struct pel_error *error);

/* Sees to the sum's memory, before a refined frame is drawn. */
bool pel_refine_reserve(struct pel_refinement *refinement, struct pel_error *error);

/* Adds the refined frame that was drawn into `image`. */
void pel_refine_add(struct pel_refinement *refinement, int threads, const struct pel_image *image);

/* Puts the mean, and the first frame's depth, into `image`. */
void pel_refine_show(struct pel_refinement *refinement, int threads, struct pel_image *image);

/* How many frames the mean stands for; all that are wanted where jitter moves nothing. */
int pel_refine_count(const struct pel_refinement *refinement);
bool pel_refine_done(const struct pel_refinement *refinement);

#endif
