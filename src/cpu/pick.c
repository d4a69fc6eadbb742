/* SPDX-License-Identifier: MIT */
/* Picking is the reference's ray, and so needs no picture: what a fast engine drew at a pixel agrees with it to within a sample. */
#include <pellucid/pick.h>

#include <math.h>
#include <string.h>

#include "fail.h"
#include "reference.h"

bool pel_scene_pick(const struct pel_scene *scene, int width, int height, double x, double y, double opacity, struct pel_pick *pick,
                    struct pel_error *error)
{
    struct pel_reference_pick found;
    struct pel_scene seen;
    if (!pel_scene_check(scene, error))
        return false;
    if (width < 1 || height < 1 || !(fabs(x) <= 1e9) || !(fabs(y) <= 1e9) || !(opacity > 0 && opacity <= 1))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "pick: the point (%g, %g) of %d x %d pixels at opacity %g is none", x, y, width, height, opacity);
    memcpy(&seen, scene, sizeof seen); /* the transfer function is borrowed */
    if (seen.render.mode == PEL_MODE_AVERAGE || seen.render.mode == PEL_MODE_XRAY)
        seen.render.mode = PEL_MODE_MIP;
    if (!pel_reference_pick(&seen, width, height, x - 0.5, y - 0.5, opacity, &found, error))
        return false;
    *pick = (struct pel_pick){ .inside = found.inside };
    if (!isfinite(found.distance))
        return true;
    pick->hit = true;
    pick->distance = found.distance;
    pick->value = found.valued ? found.value : NAN;
    memcpy(pick->world, found.world, sizeof pick->world);
    memcpy(pick->index, found.index, sizeof pick->index);
    return true;
}
