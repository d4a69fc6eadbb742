/* SPDX-License-Identifier: MIT */
/* Transfer functions that show what is in a volume without being asked twice. survey.c says where the object's values lie; here they
 * get colours and opacities, by three rules:
 *   - background and noise are clear;
 *   - what is common is translucent and what is rare is dense (flesh hides bone, bone does not hide flesh), scaled to the object's size, so that
 *     a ray through the object is neither empty nor stopped at once;
 *   - values that lie on boundaries (great mean gradient) are denser than those inside a material, so that surfaces show. */
#include <pellucid/transfer.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fail.h"
#include "survey.h"

enum { KNOTS = 33 };

static double clamp01(double x)
{
    return x > 0 ? x < 1 ? x : 1 : 0;
}

/* Opacity of the object's values from the threshold to the top. */
static void object_opacities(const struct pel_survey *s, struct pel_opacity_point points[KNOTS])
{
    int first = pel_survey_bin(s, s->threshold);
    double base = fmin(1 - exp(-4.6 / s->extent), 0.3), dense = 0.5, total = 0, below = 0;
    for (int i = first; i < s->bins; i++)
        total += s->count[i];
    for (int k = 0, bin = first; k < KNOTS; k++) {
        double value = s->threshold + (s->top - s->threshold) * k / (KNOTS - 1);
        for (; bin < s->bins && pel_survey_value(s, bin) < value; bin++)
            below += s->count[bin];
        double rank = total > 0 ? below / total : 0, rare = clamp01((rank - 0.6) / 0.4);
        double rise = clamp01((value - s->threshold) / (s->isovalue - s->threshold));
        double edge = s->kind == PEL_SURVEY_FULL ? 1 : 0.2 + 0.8 * s->gradient[pel_survey_bin(s, value)];
        points[k].value = value;
        points[k].opacity = clamp01(rise * (base + (dense - base) * rare * sqrt(rare)) * edge);
    }
    points[0].opacity = 0;
}

static bool composite(struct pel_transfer *transfer, const struct pel_survey *s, struct pel_error *error)
{
    struct pel_opacity_point points[KNOTS];
    object_opacities(s, points);
    const char *map = s->kind == PEL_SURVEY_MATERIALS ? "ct" : "plasma";
    return pel_transfer_set_colormap(transfer, map, s->threshold, s->top, error) &&
           pel_transfer_set_opacities(transfer, points, KNOTS, error);
}

bool pel_transfer_automatic(struct pel_transfer *transfer, const struct pel_volume *volume, enum pel_transfer_purpose purpose,
                            struct pel_error *error)
{
    (void)purpose;
    struct pel_survey survey;
    pel_survey_volume(volume, &survey);
    transfer->unit_distance = pel_volume_mean_spacing(volume);
    return composite(transfer, &survey, error);
}

double pel_isovalue_automatic(const struct pel_volume *volume)
{
    struct pel_survey survey;
    pel_survey_volume(volume, &survey);
    return survey.isovalue;
}
