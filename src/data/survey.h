/* SPDX-License-Identifier: MIT */
/* What a volume's values tell about what is in it: where the background lies, where the object begins, which materials there are. The
 * automatic transfer functions and isovalue are read off this. */
#ifndef PEL_DATA_SURVEY_H
#define PEL_DATA_SURVEY_H

#include <pellucid/volume.h>

enum pel_survey_kind {
    PEL_SURVEY_EMPTY,     /* no finite value, or one alone */
    PEL_SURVEY_MATERIALS, /* a background and materials of a value each, with boundaries between them (CT, MR) */
    PEL_SURVEY_FIELD,     /* a background out of which values rise smoothly (densities, flow in a vessel) */
    PEL_SURVEY_SIGNED,    /* the same, to both sides of the background */
    PEL_SURVEY_FULL,      /* no background: values all over the box (weather) */
};

enum { PEL_SURVEY_BINS = 512 }; /* at most */

struct pel_survey {
    enum pel_survey_kind kind;
    double lo, hi; /* what the bins span; a few outliers may lie outside. lo < hi */
    int bins;
    double count[PEL_SURVEY_BINS];    /* share of the samples that lie in lo..hi; sums to 1 */
    double smooth[PEL_SURVEY_BINS];   /* the same, smoothed */
    double gradient[PEL_SURVEY_BINS]; /* mean gradient at each value, smoothed, as a fraction of the greatest */
    double background;                /* value of the background's peak; lo where there is none */
    double threshold;                 /* values below are background and noise; background < threshold <= isovalue */
    double isovalue;                  /* the object's outer boundary */
    double top;                       /* all but a hundredth or a thousandth of the object lies below */
    double common;                    /* all but a few hundredths do */
    double extent;                    /* the object's size in voxels: the cube root of how many there are of it, at least 1 */
    double fill;                      /* share of the samples above the threshold */
};

/* Takes some milliseconds: large volumes are looked at in slabs. Never fails: without memory the answer is EMPTY. */
void pel_survey_volume(const struct pel_volume *volume, struct pel_survey *survey);

static inline double pel_survey_value(const struct pel_survey *survey, double bin)
{
    return survey->lo + (survey->hi - survey->lo) * ((bin + 0.5) / survey->bins);
}

static inline int pel_survey_bin(const struct pel_survey *survey, double value)
{
    double at = (value - survey->lo) / (survey->hi - survey->lo) * survey->bins;
    return at >= survey->bins - 1 ? survey->bins - 1 : at > 0 ? (int)at : 0;
}

#endif
