/* SPDX-License-Identifier: MIT */
/* What a technique is to the renderer: a const descriptor with a few functions, and a state that the renderer keeps for it between frames.
 * To add one: a folder with its file, and one line in techniques.c. */
#ifndef PEL_RENDER_TECHNIQUE_H
#define PEL_RENDER_TECHNIQUE_H

#include <pellucid/renderer.h>

/* What changed since this technique last drew. Everything has, at its first frame. */
enum pel_change {
    PEL_CHANGE_VOLUME = 1 << 0,      /* samples or placement */
    PEL_CHANGE_TRANSFER = 1 << 1,    /* curves, unit distance, linear light */
    PEL_CHANGE_ISOSURFACES = 1 << 2,
    PEL_CHANGE_SETTINGS = 1 << 3,    /* struct pel_render_settings, but for step and jitter */
    PEL_CHANGE_CAMERA = 1 << 4,
    PEL_CHANGE_SIZE = 1 << 5,
    PEL_CHANGE_CLIPPING = 1 << 6,    /* planes, box, slice */
    PEL_CHANGE_LIGHTS = 1 << 7,
    PEL_CHANGE_STEP = 1 << 8,        /* the step alone */
    PEL_CHANGE_OPTIONS = 1 << 9,     /* the technique's own */
    PEL_CHANGE_ALL = (1 << 10) - 1,
};

struct pel_frame {
    const struct pel_scene *scene; /* checked */
    struct pel_image *image;
    struct pel_device *device; /* to draw on, current while the technique runs; NULL: draw on the CPU */
    const void *options; /* what info.options describes, checked; NULL where there are none */
    int threads;
    int jitter; /* where samples lie in their segments: 0 in the middle, else 1 + the number of the jittered frame (docs/optics.md);
                   what scene->render.jitter asks for, or refinement; no change tells of it */
    unsigned changes;
    const struct pel_progress *progress;
    struct pel_frame_stats *stats; /* filled through pel_frame_stage and pel_frame_count */
};

struct pel_technique {
    struct pel_technique_info info;
    /* Can it draw this: by its mode, classification and options, on a GPU or on the CPU? What it cannot is refused, so that nobody takes
     * another picture for the one asked for. Comes before each prepare, and before anything is drawn at all (pel_technique_check). NULL:
     * any scene. */
    bool (*check)(const struct pel_scene *scene, const void *options, bool gpu, struct pel_error *error);
    /* `*state` starts as NULL; the technique allocates what it needs in prepare and frees it in finish. A failed prepare may leave a state
     * behind, and is asked again with all changes. */
    bool (*prepare)(void **state, const struct pel_frame *frame, struct pel_error *error);
    bool (*draw)(void *state, const struct pel_frame *frame, struct pel_error *error);
    void (*finish)(void *state); /* accepts NULL */
    bool (*sample_limit)(void *state, double *samples_per_second, struct pel_error *error); /* or NULL: pel_renderer_sample_limit */
};

/* The list; NULL at the end. */
extern const struct pel_technique *const pel_techniques[];

/* Notes a stage's time (since `start_ms` of pel_now_ms) or a counter; more than fit are dropped. Names must outlive the renderer. */
void pel_frame_stage(const struct pel_frame *frame, const char *name, double start_ms);
void pel_frame_stage_gpu(const struct pel_frame *frame, const char *name, double start_ms, double gpu_ms);
void pel_frame_count(const struct pel_frame *frame, const char *name, uint64_t value);

#endif
