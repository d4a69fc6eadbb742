/* SPDX-License-Identifier: MIT */
/* Pace: how large a picture of motion may be to fit a budget of milliseconds. What a picture costs is taken to be a constant and a part
 * that grows with its pixels; both come from the last pictures, by least squares that forget. So a cost that does not shrink with the
 * picture (a shear-warp's slices, a changed transfer function) does not drive it to nothing. */
#ifndef VIEWER_PACE_H
#define VIEWER_PACE_H

#include <stdbool.h>

/* The camera moved alone, or the scene changed, too, so that the technique has to prepare. */
enum pace_kind { PACE_CAMERA, PACE_SCENE, PACE_KINDS };

struct pace {
    double budget_ms;
    struct pace_sums {
        double n, x, y, xx, xy; /* weighted sums over pictures: x their megapixels, y their milliseconds */
    } sums[PACE_KINDS];
    int level[PACE_KINDS]; /* the last one chosen; half as many pixels every two levels */
};

/* Forgets: another volume, technique or mode. */
void pace_init(struct pace *pace, double budget_ms);

/* The size for a picture of motion in place of a whole one. Nothing was measured: the whole size. */
void pace_choose(struct pace *pace, enum pace_kind kind, const int whole[2], int size[2]);

/* What a picture of this size took. */
void pace_measured(struct pace *pace, enum pace_kind kind, const int size[2], double ms);

#endif
