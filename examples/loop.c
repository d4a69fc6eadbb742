/* SPDX-License-Identifier: MIT */
/* A renderer that is kept: the camera turns, the transfer function changes, and only what changed is prepared again.
 *
 *   loop [INPUT]
 *
 * Prints what each frame took. Without a file it draws a computed hydrogen orbital. */
#include <stdio.h>
#include <stdlib.h>

#include <pellucid/pellucid.h>

static bool load(const char *path, struct pel_volume *volume, struct pel_error *error)
{
    if (path)
        return pel_read_volume(path, &(struct pel_read_params)PEL_READ_PARAMS_INIT, volume, NULL, error);
    const struct pel_dataset *hydrogen = pel_dataset_find("hydrogen");
    void *params = pel_dataset_create_params(hydrogen);
    bool ok = params && pel_dataset_make(hydrogen, params, volume, error);
    free(params);
    return ok;
}

/* Draws, and adds up the stages that the frame says it had. */
static bool frame(struct pel_renderer *renderer, const struct pel_scene *scene, struct pel_image *image, const char *what,
                  struct pel_error *error)
{
    if (!pel_renderer_draw(renderer, scene, "raycast", image, error))
        return false;
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    double total = 0;
    for (int i = 0; i < stats->stage_count; i++)
        total += stats->stages[i].cpu_ms;
    printf("%-28s %7.1f ms:", what, total);
    for (int i = 0; i < stats->stage_count; i++)
        printf("  %s %.1f", stats->stages[i].name, stats->stages[i].cpu_ms);
    printf("\n");
    return true;
}

/* All opacities halved: an edit as a user's slider makes it. */
static bool halve_opacity(struct pel_transfer *transfer, struct pel_error *error)
{
    struct pel_opacity_point *points = malloc(transfer->opacity_count * sizeof *points);
    if (!points)
        return false;
    for (size_t i = 0; i < transfer->opacity_count; i++) {
        points[i] = transfer->opacities[i];
        points[i].opacity /= 2;
    }
    bool ok = pel_transfer_set_opacities(transfer, points, transfer->opacity_count, error);
    free(points);
    return ok;
}

int main(int argc, char **argv)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = NULL;
    bool ok = false;

    pel_volume_init(&volume);
    pel_image_init(&image);
    if (!pel_scene_init(&scene, &error) || !load(argc > 1 ? argv[1] : NULL, &volume, &error))
        goto done;
    scene.volume = &volume;
    renderer = pel_renderer_create(&(struct pel_renderer_params)PEL_RENDERER_PARAMS_INIT, &error);
    if (!renderer || !pel_image_allocate(&image, 512, 512, false, &error) ||
        !pel_transfer_automatic(&scene.transfer, &volume, PEL_TRANSFER_COMPOSITE, &error))
        goto done;
    pel_scene_fit_camera(&scene, image.width, image.height);

    if (!frame(renderer, &scene, &image, "first frame", &error))
        goto done;
    for (int i = 0; i < 5; i++) {
        pel_camera_azimuth(&scene.camera, 5);
        if (!frame(renderer, &scene, &image, "camera turned by 5 degrees", &error))
            goto done;
    }
    for (int i = 0; i < 3; i++)
        if (!halve_opacity(&scene.transfer, &error) || !frame(renderer, &scene, &image, "opacities halved", &error))
            goto done;
    ok = true;

done:
    if (!ok)
        fprintf(stderr, "loop: %s\n", error.message);
    pel_renderer_destroy(renderer);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    return ok ? 0 : 1;
}
