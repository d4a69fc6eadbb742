/* SPDX-License-Identifier: MIT */
/* The double-precision reference as a technique, so that any picture can be checked with the shipped tool. */
#include "reference.h"
#include "technique.h"
#include "timer.h"

static const struct pel_option no_options[] = { { NULL } };

static bool prepare(void **state, const struct pel_frame *frame, struct pel_error *error)
{
    (void)state, (void)frame, (void)error; /* nothing is kept between frames */
    return true;
}

static bool draw(void *state, const struct pel_frame *frame, struct pel_error *error)
{
    (void)state;
    uint64_t samples = 0;
    double start = pel_now_ms();
    bool ok = pel_reference_draw(frame->scene, frame->jitter, frame->threads, frame->progress, frame->image, &samples, error);
    pel_frame_stage(frame, "cast rays", start);
    pel_frame_count(frame, "samples taken", samples);
    return ok;
}

static void finish(void *state)
{
    (void)state;
}

extern const struct pel_technique pel_technique_reference;
const struct pel_technique pel_technique_reference = {
    .info = {
        .name = "reference",
        .summary = "The same optics in double precision, plain and slow: what the others are held to",
        .citation = "Xue, Volume visualization using advanced graphics hardware shaders, 2008, equations 1.2 to 1.8",
        .engines = PEL_ENGINE_CPU,
        .options = no_options,
    },
    .prepare = prepare,
    .draw = draw,
    .finish = finish,
};
