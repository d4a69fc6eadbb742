/* SPDX-License-Identifier: MIT */
/* The machine's own limit, for bench/run: how many samples a second the same kernels take where nothing can hold them up. A volume that
 * fits the first-level cache, nothing skipped, no ray ended early, a step so small that the setting up of rays does not count. Prints one
 * JSON object. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <pellucid/pellucid.h>

enum { SIDE = 24, PICTURE = 256, FRAMES = 9 };

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Bytes that rise along all axes: every sample and every gradient is another one. */
static bool make_volume(struct pel_volume *volume, struct pel_error *error)
{
    const size_t dims[3] = { SIDE, SIDE, SIDE };
    if (!pel_volume_allocate(volume, dims, PEL_U8, 1, error))
        return false;
    unsigned char *data = volume->data;
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++)
                data[(z * SIDE + y) * SIDE + x] = (unsigned char)(3 * x + 3 * y + 4 * z);
    pel_volume_update_range(volume);
    return true;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double samples_taken(const struct pel_renderer *renderer)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    for (int i = 0; i < stats->counter_count; i++)
        if (!strcmp(stats->counters[i].name, "samples taken"))
            return (double)stats->counters[i].value;
    return 0;
}

/* The median of some frames, after one that is not counted. */
static bool measure(struct pel_renderer *renderer, const struct pel_scene *scene, struct pel_image *image, double *rate,
                    struct pel_error *error)
{
    double seconds[FRAMES];
    for (int i = -1; i < FRAMES; i++) {
        double start = now_s();
        if (!pel_renderer_draw(renderer, scene, "raycast", image, error))
            return false;
        if (i >= 0)
            seconds[i] = now_s() - start;
    }
    qsort(seconds, FRAMES, sizeof *seconds, ascending);
    *rate = samples_taken(renderer) / seconds[FRAMES / 2];
    return true;
}

static bool measure_all(struct pel_renderer *renderer, struct pel_scene *scene, struct pel_image *image, struct pel_error *error)
{
    static const struct {
        const char *name;
        enum pel_mode mode;
        bool shade;
    } kinds[] = { { "dvr", PEL_MODE_COMPOSITE, false },
                  { "dvr_shade", PEL_MODE_COMPOSITE, true },
                  { "mip", PEL_MODE_MIP, false },
                  { "xray", PEL_MODE_XRAY, false },
                  { "iso", PEL_MODE_ISOSURFACE, true } };
    double rate;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        scene->render.mode = kinds[i].mode;
        scene->render.shade = kinds[i].shade;
        if (!measure(renderer, scene, image, &rate, error))
            return false;
        printf("%s\"%s\": %.0f", i ? ", " : "", kinds[i].name, rate);
    }
    return true;
}

int main(void)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = NULL;
    bool ok = false;

    pel_volume_init(&volume);
    pel_image_init(&image);
    if (!pel_scene_init(&scene, &error) || !make_volume(&volume, &error))
        goto done;
    scene.volume = &volume;
    scene.render.skip = false;
    scene.render.termination = 1;
    scene.render.step = 0.05;
    /* A surface that no ray meets: what is measured is the search for it. */
    scene.isosurfaces[0] = (struct pel_isosurface) { .value = 1000, .color = { 1, 1, 1 }, .opacity = 1 };
    scene.isosurface_count = 1;
    if (!pel_transfer_set_colormap(&scene.transfer, "viridis", 0, 255, &error) ||
        !pel_transfer_parse_opacity(&scene.transfer, "0:0.001,255:0.02", &error))
        goto done;
    pel_camera_fit(&scene.camera, &volume, PICTURE, PICTURE);
    renderer = pel_renderer_create(&(struct pel_renderer_params)PEL_RENDERER_PARAMS_INIT, &error);
    if (!renderer || !pel_image_allocate(&image, PICTURE, PICTURE, false, &error))
        goto done;
    printf("{\"samples_per_second\": {");
    ok = measure_all(renderer, &scene, &image, &error);
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    if (ok)
        printf("}, \"isa\": \"%s\", \"threads\": %d}\n", stats->isa ? stats->isa : "", stats->threads);

done:
    if (!ok)
        fprintf(stderr, "limit: %s\n", error.message);
    pel_renderer_destroy(renderer);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    return ok ? 0 : 1;
}
