/* SPDX-License-Identifier: MIT */
/* A vector field: read (or computed), turned into the length of its vectors, drawn with a colour map and an opacity of one's own.
 *
 *   flow OUTPUT.png [INPUT]
 *
 * Without a file it takes Crawfis's tornado. */
#include <stdio.h>
#include <stdlib.h>

#include <pellucid/pellucid.h>

static bool load(const char *path, struct pel_volume *field, struct pel_error *error)
{
    if (path)
        return pel_read_volume(path, &(struct pel_read_params)PEL_READ_PARAMS_INIT, field, NULL, error);
    const struct pel_dataset *tornado = pel_dataset_find("tornado");
    void *params = pel_dataset_create_params(tornado);
    bool ok = params && pel_dataset_make(tornado, params, field, error);
    free(params);
    return ok;
}

/* Slow flow unseen, fast flow dense. Opacity is per unit distance, so the picture does not depend on the step. */
static bool classify(struct pel_transfer *transfer, const struct pel_volume *speed, struct pel_error *error)
{
    double lo = speed->range[0], hi = speed->range[1];
    struct pel_opacity_point points[] = { { lo + 0.3 * (hi - lo), 0 }, { lo + 0.6 * (hi - lo), 0.05 }, { hi, 0.6 } };
    transfer->unit_distance = pel_volume_mean_spacing(speed);
    return pel_transfer_set_colormap(transfer, "plasma", lo, hi, error) &&
           pel_transfer_set_opacities(transfer, points, sizeof points / sizeof *points, error);
}

int main(int argc, char **argv)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume field, speed;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = NULL;
    bool ok = false;

    if (argc < 2 || argc > 3) {
        fprintf(stderr, "usage: flow OUTPUT.png [INPUT]\n");
        return 2;
    }
    pel_volume_init(&field);
    pel_volume_init(&speed);
    pel_image_init(&image);
    if (!pel_scene_init(&scene, &error) || !load(argc > 2 ? argv[2] : NULL, &field, &error) ||
        !pel_volume_magnitude(&field, &speed, &error) || !classify(&scene.transfer, &speed, &error))
        goto done;
    scene.volume = &speed;
    pel_scene_fit_camera(&scene, 800, 800);
    renderer = pel_renderer_create(&(struct pel_renderer_params)PEL_RENDERER_PARAMS_INIT, &error);
    ok = renderer && pel_image_allocate(&image, 800, 800, false, &error) && pel_renderer_draw(renderer, &scene, NULL, &image, &error) &&
         pel_write_image(argv[1], &image, &(struct pel_image_write_params)PEL_IMAGE_WRITE_PARAMS_INIT, &error);

done:
    if (!ok)
        fprintf(stderr, "flow: %s\n", error.message);
    pel_renderer_destroy(renderer);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&speed);
    pel_volume_finish(&field);
    return ok ? 0 : 1;
}
