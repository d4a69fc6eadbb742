/* SPDX-License-Identifier: MIT */
/* Pace: how large a picture of motion may be, and how long its steps, to fit a budget of milliseconds. Sizes come in levels of half an octave of pixels. What a level costs is measured
 * whenever it is drawn, other levels are guessed from their pixels until they were drawn, and every measurement moves them all, for the view
 * has changed for all. So a cost that does not shrink with the picture (a shear-warp's slices) does not drive the picture to nothing. */
#ifndef VIEWER_PACE_H
#define VIEWER_PACE_H

#include <stdbool.h>

enum { PACE_LEVELS = 12 };

/* The camera moved alone, or the scene changed, too, so that the technique has to prepare. */
enum pace_kind { PACE_CAMERA, PACE_SCENE, PACE_KINDS };

struct pace {
    double budget_ms;
    double pixels;                        /* of the whole picture */
    double ms[PACE_KINDS][PACE_LEVELS];   /* 0: never drawn */
    int level[PACE_KINDS];                /* in use */
};

/* Forgets: another volume, technique or mode. */
void pace_init(struct pace *pace, double budget_ms);

/* The size for a picture of motion of a w x h picture; gives the level. */
int pace_choose(struct pace *pace, enum pace_kind kind, const int whole[2], int size[2]);
void pace_measured(struct pace *pace, enum pace_kind kind, int level, double ms);

/* The step at a level: the scene's at level 0, else twice that, but at most two voxels more. */
double pace_step(int level, double step);

#endif
