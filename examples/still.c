/* SPDX-License-Identifier: MIT */
/* The smallest complete program: one file, one picture.
 *
 *   still INPUT OUTPUT.png
 *
 * Everything that is not said is chosen from the volume: the transfer function from its histogram, the camera so that all of it is seen.
 *   cc still.c $(pkg-config --cflags --libs pellucid) -o still */
#include <stdio.h>

#include <pellucid/pellucid.h>

int main(int argc, char **argv)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = NULL;
    bool ok = false;

    if (argc != 3) {
        fprintf(stderr, "usage: still INPUT OUTPUT.png\n");
        return 2;
    }
    pel_volume_init(&volume);
    pel_image_init(&image);
    if (!pel_scene_init(&scene, &error))
        goto done;

    if (!pel_read_volume(argv[1], &(struct pel_read_params)PEL_READ_PARAMS_INIT, &volume, NULL, &error))
        goto done;
    scene.volume = &volume;
    if (!pel_transfer_automatic(&scene.transfer, &volume, PEL_TRANSFER_COMPOSITE, &error))
        goto done;
    pel_scene_fit_camera(&scene, 800, 600);

    renderer = pel_renderer_create(&(struct pel_renderer_params)PEL_RENDERER_PARAMS_INIT, &error);
    ok = renderer && pel_image_allocate(&image, 800, 600, false, &error) &&
         pel_renderer_draw(renderer, &scene, "raycast", &image, &error) &&
         pel_write_image(argv[2], &image, &(struct pel_image_write_params)PEL_IMAGE_WRITE_PARAMS_INIT, &error);

done:
    if (!ok)
        fprintf(stderr, "still: %s\n", error.message);
    pel_renderer_destroy(renderer);
    pel_image_finish(&image);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
    return ok ? 0 : 1;
}
