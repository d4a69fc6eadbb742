/* SPDX-License-Identifier: MIT */
#include "on_device.h"

struct pel_device *device;

int open_device(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    device = pel_device_create(-1, NULL, &error);
    if (device)
        print_message("on %s\n", pel_device_describe(device)->name);
    else
        print_message("SKIPPED: %s\n", error.message);
    return 0;
}

int close_device(void **state)
{
    (void)state;
    pel_device_destroy(device);
    return 0;
}

void need_device(void)
{
    if (!device)
        skip();
}

struct pel_renderer *gpu_renderer(void)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.device = device;
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    if (!renderer)
        fail_msg("%s", error.message);
    return renderer;
}

void draw_gpu(struct pel_renderer *renderer, const struct pel_scene *scene, int width, int height, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    pel_image_init(image);
    if (!pel_image_allocate(image, width, height, true, &error) || !pel_renderer_draw(renderer, scene, "raycast", image, &error))
        fail_msg("%s", error.message);
    assert_string_equal(pel_renderer_stats(renderer)->device, pel_device_describe(device)->name);
}

void check_against_cpu(struct pel_renderer *renderer, const struct pel_scene *scene, const char *what)
{
    struct pel_image cpu, gpu;
    draw(scene, "raycast", WIDTH, HEIGHT, &cpu);
    draw_gpu(renderer, scene, WIDTH, HEIGHT, &gpu);
    check_at_least(psnr(&cpu, &gpu), 45, "%s: PSNR of the GPU against the CPU, dB", what);
    pel_image_finish(&cpu);
    pel_image_finish(&gpu);
}

double blob(const double index[3])
{
    double x = index[0] - 14, y = index[1] - 12, z = index[2] - 13, r = sqrt(x * x + y * y + z * z);
    return fmax(0, 110 - 12 * r) + 4 + 4 * sin(0.6 * x + 0.4 * y);
}

double holed(const double index[3])
{
    return (int)index[0] % 9 == 4 && (int)index[1] % 7 == 3 ? NAN : blob(index);
}

void make_typed(struct pel_volume *volume, struct pel_scene *scene, enum pel_type type, formula *f)
{
    make_sized(volume, scene, (const size_t[3]){ 29, 25, 27 }, type, f); /* sides of 4 n + 1 and of others: cells at the end */
}

void make_sized(struct pel_volume *volume, struct pel_scene *scene, const size_t dims[3], enum pel_type type, formula *f)
{
    make_volume(volume, dims[0], dims[1], dims[2], type, f);
    memcpy(volume->spacing, (double[3]){ 1, 1.2, 0.9 }, sizeof volume->spacing);
    memcpy(volume->direction[1], (double[3]){ 0.28, 0.96, 0 }, sizeof volume->direction[1]);
    make_scene(scene, volume, "12:0,30:0.1,60:0.05,100:0.6");
    assert_true(pel_transfer_set_colormap(&scene->transfer, "viridis", 0, 110, NULL));
    scene->isosurfaces[0] = (struct pel_isosurface){ 40.3, { 1, 0.9, 0.8 }, 0.4 };
    scene->isosurfaces[1] = (struct pel_isosurface){ 71.7, { 0.4, 0.6, 1 }, 1 };
    scene->isosurface_count = 2;
    pel_volume_index_to_world(volume, (const double[3]){ (double)dims[0] / 2 - 0.5, (double)dims[1] / 2 - 0.5, (double)dims[2] / 2 - 0.5 }, scene->slice.origin);
    memcpy(scene->slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof scene->slice.normal);
    scene->more_slices[0] = scene->more_slices[1] = scene->slice; /* two more that cross it: through other bricks */
    memcpy(scene->more_slices[0].normal, (double[3]){ 1, 0.1, 0 }, sizeof scene->slice.normal);
    memcpy(scene->more_slices[1].normal, (double[3]){ 0.2, 0.3, 1 }, sizeof scene->slice.normal);
    scene->more_slice_count = 2;
}


void clip(struct pel_scene *scene)
{
    double bounds[6];
    scene->clip_plane_count = 1;
    memcpy(scene->clip_planes[0].origin, scene->slice.origin, sizeof scene->slice.origin);
    memcpy(scene->clip_planes[0].normal, (double[3]) { 1, 1, 0.3 }, sizeof scene->clip_planes[0].normal);
    pel_volume_bounds(scene->volume, bounds);
    for (int i = 0; i < 6; i++)
        scene->clip_box[i] = bounds[i] + (i % 2 ? -0.15 : 0.1) * (bounds[i | 1] - bounds[i & ~1]);
    scene->clip_box_enabled = true;
}
