/* SPDX-License-Identifier: MIT */
/* Renderer: draws scenes with a technique, and remembers what it prepared, so that only what changed is prepared again. */
#ifndef PELLUCID_RENDERER_H
#define PELLUCID_RENDERER_H

#include <stdint.h>

#include <pellucid/device.h>
#include <pellucid/image.h>
#include <pellucid/scene.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Engines a technique runs on. */
enum { PEL_ENGINE_CPU = 1 << 0, PEL_ENGINE_GPU = 1 << 1 };

/* What is public of a technique. */
struct pel_technique_info {
    const char *name;     /* "raycast" */
    const char *summary;  /* one line */
    const char *citation; /* the paper and section, or NULL */
    unsigned engines;     /* PEL_ENGINE_* it runs on */
    const struct pel_option *options; /* its own rows, beyond pel_render_options; an empty table where it has none */
    size_t options_size; /* bytes of the object that they describe (pel_renderer_options); 0 where there are none */
};

/* The techniques in the order in which they are listed; NULL at the end. */
const struct pel_technique_info *pel_technique_at(size_t index);
const struct pel_technique_info *pel_technique_find(const char *name);

#define PEL_MAX_STAGES 16
#define PEL_MAX_COUNTERS 32

/* What a frame cost and how much it skipped. */
struct pel_frame_stats {
    const char *technique; /* that drew: where it was to be "auto", which one that took */
    const char *reason;    /* why "auto" took it, one line; NULL where the technique was named. Lives as long as these statistics */
    const char *device; /* "cpu", or the GPU's name */
    const char *isa;    /* "x86-64-v3": the instruction set of the CPU kernels, or NULL */
    int threads;
    int stage_count;
    struct {
        const char *name;
        double cpu_ms;
        double gpu_ms; /* negative: not measured */
    } stages[PEL_MAX_STAGES];
    int counter_count;
    struct {
        const char *name; /* "samples taken", "samples skipped", "rays culled", "bytes beside the volume", "frames averaged" */
        uint64_t value;
    } counters[PEL_MAX_COUNTERS];
};

struct pel_renderer_params {
    int threads; /* for the CPU engine; 0: as many as the machine (or OMP_NUM_THREADS) says */
    struct pel_progress progress; /* of each draw */
    struct pel_device *device; /* borrowed, must outlive the renderer; NULL: the CPU engine. Techniques that have no GPU engine draw on the
                                  CPU all the same */
};
#define PEL_RENDERER_PARAMS_INIT { 0, { 0, 0 }, 0 }

struct pel_renderer;

/* A renderer may be used from one thread at a time; several may live side by side. */
struct pel_renderer *pel_renderer_create(const struct pel_renderer_params *params, struct pel_error *error);
void pel_renderer_destroy(struct pel_renderer *renderer);

/* Draws the scene into `image`, whose size says the picture's. Depth is filled where the image has it. The background is not painted:
 * the image keeps its alpha, see pel_image_write_params. `technique` NULL: "raycast".
 *
 * "auto" draws with "raycast", but for mode isosurface on a GPU: there it takes "raycast" and "peel" for three frames each, and then stays
 * with the one whose frames were faster, until the volume, the number of isosurfaces, render.skip, render.roots or the picture's size (by a
 * factor of four in pixels or so) changes. Where peeling refuses, ray casting draws. The options that it draws with are the defaults. */
bool pel_renderer_draw(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, struct pel_image *image,
                       struct pel_error *error);

/* Refinement at rest: where scene->render.refine is N > 0, the first draw of a view is as the settings say. Each further draw of the same
 * scene, technique and size draws one more frame, with jitter and a step of half a voxel at most, each frame with its samples elsewhere,
 * and returns the mean of these frames so far. The counter "frames averaged" tells their number: 0 at first. Once it is N (after
 * three frames where these are equal to the last bit, since jitter moves nothing then) the picture is returned without drawing. Depth stays the first draw's. Any change
 * starts over, also asking for depth where the first draw was not asked. A draw that fails adds no frame. The renderer holds a copy of the
 * picture for it.
 *
 * True where another draw of the scene last drawn would change nothing: it was drawn, and refine is 0 or N frames are averaged. */
bool pel_renderer_finished(const struct pel_renderer *renderer);

/* The technique's own options: the object that the rows of pel_technique_info.options describe. It belongs to the renderer, starts with the
 * rows' defaults, and each draw reads it; set it with pel_option_set. NULL where the technique has no options or does not exist. */
void *pel_renderer_options(struct pel_renderer *renderer, const char *technique);

/* Sets the options that a scene names for its technique, and leaves the others; all or none. Refuses a technique that there is none of, an
 * option that it does not have, a value that this does not take; messages begin with the key, "technique.options.blend: ". `renderer` NULL:
 * only checks. */
bool pel_renderer_take_technique(struct pel_renderer *renderer, const struct pel_technique_choice *choice, struct pel_error *error);

/* Can the technique that the scene names (none: "raycast") draw it, with the options that it names for it and else the defaults, on a GPU or
 * on the CPU? It tells what the scene itself decides (its mode and classification); that a GPU has too little memory, a draw tells. The
 * scene has its volume. */
bool pel_technique_check(const struct pel_scene *scene, bool gpu, struct pel_error *error);

/* The other way: a technique with all its options, which are in the object that its rows describe (NULL where it has none). */
void pel_technique_tell(const struct pel_technique_info *technique, const void *options, struct pel_technique_choice *choice);

/* Statistics of the last draw; valid until the next. */
const struct pel_frame_stats *pel_renderer_stats(const struct pel_renderer *renderer);

/* How many trilinear samples of the volume a second the GPU takes along the rays of the last draw where it does nothing else: what the
 * samples of a frame are held to. PEL_ERROR_UNSUPPORTED where that was drawn on the CPU, or the GPU cannot hold the volume whole. */
bool pel_renderer_sample_limit(struct pel_renderer *renderer, double *samples_per_second, struct pel_error *error);

/* Forgets what was prepared from the volume: call it after changing samples in place. */
void pel_renderer_invalidate(struct pel_renderer *renderer);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
