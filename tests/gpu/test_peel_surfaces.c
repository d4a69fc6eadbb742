/* SPDX-License-Identifier: MIT */
/* Peeling, held to surfaces that are known: a sphere, a torus and a gyroid. Hits lie within a hundredth of a voxel of them, normals within a
 * degree. And on real volumes to the ray casters on both engines. Skipped, loudly, where no device is usable, and where there is no data. */
#include "on_device.h"

#define SIDE 128

/* Signed distance, or a formula of the surface; and its gradient. */
struct surface {
    const char *name;
    formula *value;
    void (*gradient)(const double at[3], double to[3]);
    double isovalue;
};

static const double middle[3] = { 61.3, 64.2, 62.9 };
enum { RING = 36, TUBE = 20 };
#define WAVE (2 * 3.14159265358979323846 / 110)

static double sphere(const double at[3])
{
    double d[3] = { at[0] - middle[0], at[1] - middle[1], at[2] - middle[2] };
    return sqrt(dot3(d, d));
}

static void sphere_gradient(const double at[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = (at[i] - middle[i]) / sphere(at);
}

static double torus(const double at[3])
{
    double ring = hypot(at[0] - middle[0], at[1] - middle[1]) - RING, z = at[2] - middle[2];
    return hypot(ring, z);
}

static void torus_gradient(const double at[3], double to[3])
{
    double x = at[0] - middle[0], y = at[1] - middle[1], z = at[2] - middle[2], out = hypot(x, y), ring = out - RING, far = hypot(ring, z);
    to[0] = ring / far * x / out;
    to[1] = ring / far * y / out;
    to[2] = z / far;
}

static double gyroid(const double at[3])
{
    double x = WAVE * at[0], y = WAVE * at[1], z = WAVE * at[2];
    return (sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)) / WAVE;
}

static void gyroid_gradient(const double at[3], double to[3])
{
    double x = WAVE * at[0], y = WAVE * at[1], z = WAVE * at[2];
    to[0] = cos(x) * cos(y) - sin(z) * sin(x);
    to[1] = cos(y) * cos(z) - sin(x) * sin(y);
    to[2] = cos(z) * cos(x) - sin(y) * sin(z);
}

static const struct surface surfaces[] = {
    { "sphere", sphere, sphere_gradient, 47.3 },
    { "torus", torus, torus_gradient, TUBE },
    { "gyroid", gyroid, gyroid_gradient, 0 },
};

static void draw_on(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, int size, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    pel_image_init(image);
    if (!pel_image_allocate(image, size, size, true, &error) || !pel_renderer_draw(renderer, scene, technique, image, &error))
        fail_msg("%s: %s", technique, error.message);
}

/* Three lights along the axes, one of each colour, and no other light: a pixel's colour is its normal, where all of it points that way. */
static void light_axes(struct pel_scene *scene)
{
    scene->light_count = 3;
    memset(scene->lights, 0, sizeof scene->lights);
    for (int l = 0; l < 3; l++)
        scene->lights[l].direction[l] = scene->lights[l].color[l] = 1;
    scene->render.ambient = scene->render.specular = 0;
    scene->render.diffuse = 1;
    scene->isosurfaces[0] = (struct pel_isosurface){ 0, { 1, 1, 1 }, 1 };
    scene->isosurface_count = 1;
    scene->render.mode = PEL_MODE_ISOSURFACE;
}

/* Distance of a hit from the surface, in voxels; and the cosine between its normal and the surface's, 2 where the colour does not tell. */
static void look_at_hit(const struct surface *surface, const struct pel_scene *scene, const struct pel_image *image, int x, int y, double *off,
                        double *cosine)
{
    double origin[3], direction[3], t[2], at[3], gradient[3], normal[3];
    ray_stretch(scene, image->width, image->height, x, y, origin, direction, t);
    for (int i = 0; i < 3; i++) {
        at[i] = origin[i] + depth_at(image, x, y) * direction[i];
        normal[i] = channel(image, x, y, i);
    }
    surface->gradient(at, gradient);
    double length = sqrt(dot3(gradient, gradient)), bright = sqrt(dot3(normal, normal));
    *off = fabs(surface->value(at) - surface->isovalue) / length;
    bool tells = normal[0] > 0.02 && normal[1] > 0.02 && normal[2] > 0.02 && bright < 1.01;
    for (int i = 0; i < 3; i++)
        tells &= at[i] > 1 && at[i] < SIDE - 2; /* differences are one-sided at the volume's faces */
    *cosine = tells ? fabs(dot3(normal, gradient)) / (length * bright) : 2;
}

static void check_surface(const struct surface *surface, struct pel_renderer *renderer, struct pel_scene *scene)
{
    enum { SIZE = 160 };
    struct pel_image image;
    double farthest = 0, widest = 1;
    int hits = 0, told = 0;
    scene->isosurfaces[0].value = surface->isovalue;
    draw_on(renderer, scene, "peel", SIZE, &image);
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            double off, cosine;
            if (!isfinite(depth_at(&image, x, y)))
                continue;
            look_at_hit(surface, scene, &image, x, y, &off, &cosine);
            hits++;
            farthest = fmax(farthest, off);
            told += cosine < 2;
            widest = fmin(widest, cosine < 2 ? cosine : 1);
        }
    check_at_least(hits, SIZE * SIZE / 16, "%s: hits", surface->name);
    check_at_least(told, hits / 10, "%s: normals", surface->name);
    check_at_most(farthest, 0.01, "%s: voxels between a hit and the surface", surface->name);
    check_at_most(acos(fmin(widest, 1)) * 180 / 3.14159265358979323846, 1, "%s: degrees between a normal and the surface's", surface->name);
    pel_image_finish(&image);
}

static void test_known_surfaces(void **state)
{
    (void)state;
    need_device();
    for (size_t s = 0; s < sizeof surfaces / sizeof *surfaces; s++) {
        struct pel_volume volume;
        struct pel_scene scene;
        struct pel_renderer *renderer = gpu_renderer();
        make_volume(&volume, SIDE, SIDE, SIDE, PEL_F32, surfaces[s].value);
        make_scene(&scene, &volume, NULL);
        light_axes(&scene);
        for (int view = 0; view < 3; view++) {
            const double from[3][3] = { { 200, 160, 180 }, { 90, 260, 100 }, { 150, 80, 300 } };
            memcpy(scene.camera.position, from[view], sizeof from[view]);
            memcpy(scene.camera.view_up, (double[3]){ 0.1, 0.2, 1 }, sizeof scene.camera.view_up);
            scene.camera.parallel = view == 2;
            check_surface(&surfaces[s], renderer, &scene);
        }
        pel_renderer_destroy(renderer);
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    assert_int_equal(pel_device_objects(device), 0);
}

/* Pixels where one picture alone has a surface. */
static int silhouette(const struct pel_image *a, const struct pel_image *b)
{
    int count = 0;
    for (int i = 0; i < a->width * a->height; i++)
        count += (a->rgba[4 * i + 3] > 0) != (b->rgba[4 * i + 3] > 0);
    return count;
}

/* By steps peeling gives brute force's bytes; by exact roots peeling, the CPU engine and the triangles cover the same pixels, but for one in a
 * thousand. */
static void check_real(const char *name, double isovalue)
{
    enum { SIZE = 320 };
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image brute, steps, exact, cpu, triangles;
    if (!read_real(&volume, name))
        return;
    struct pel_renderer *renderer = gpu_renderer();
    make_scene(&scene, &volume, NULL);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.isosurfaces[0] = (struct pel_isosurface){ isovalue, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 1;
    draw_on(renderer, &scene, "peel", SIZE, &exact);
    draw_on(renderer, &scene, "mesh", SIZE, &triangles);
    draw(&scene, "raycast", SIZE, SIZE, &cpu);
    const double most = SIZE * SIZE / 1000.0;
    check_at_most(silhouette(&cpu, &exact), most, "%s: pixels where the CPU engine or peeling alone has a surface", name);
    check_at_most(silhouette(&cpu, &triangles), most, "%s: pixels where the CPU engine or the triangles alone have a surface", name);
    check_at_most(silhouette(&exact, &triangles), most, "%s: pixels where peeling or the triangles alone have a surface", name);
    scene.render.roots = PEL_ROOTS_STEPS;
    draw_on(renderer, &scene, "peel", SIZE, &steps);
    scene.render.skip = false;
    draw_on(renderer, &scene, "raycast", SIZE, &brute);
    check_same_bytes(&brute, &steps, name);
    struct pel_image *images[] = { &brute, &steps, &exact, &cpu, &triangles };
    for (size_t i = 0; i < sizeof images / sizeof *images; i++)
        pel_image_finish(images[i]);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static double up(const double index[3])
{
    return index[2];
}

/* One ray a row of voxels, along them: the outermost run in the volume's faces, all of them along edges of cells. */
static void test_rays_in_faces(void **state)
{
    (void)state;
    need_device();
    struct pel_renderer *renderer = gpu_renderer();
    struct pel_volume volume;
    struct pel_scene scene;
    make_volume(&volume, 9, 9, 9, PEL_F32, up);
    make_scene(&scene, &volume, NULL);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.isosurfaces[0] = (struct pel_isosurface){ 4.3, { 1, 1, 1 }, 1 };
    scene.isosurface_count = 1;
    for (int side = -1; side <= 1; side += 2)
        for (int t = 0; t < 2; t++) {
            struct pel_image image;
            int seen = 0;
            look_parallel(&scene, (double[3]){ 0, 0, -side }, 20, 4.5);
            draw_on(renderer, &scene, t ? "raycast" : "peel", 9, &image);
            for (int i = 0; i < 81; i++)
                seen += image.rgba[4 * i + 3] > 0;
            check_at_least(seen, 81, "%s: rays along rows of voxels that hit, side %d", t ? "raycast" : "peel", side);
            pel_image_finish(&image);
        }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void test_real_volumes(void **state)
{
    (void)state;
    need_device();
    check_real("bonsai.nii.gz", 40);
    check_real("aneurism.nrrd", 48.5);
    check_real("neghip.nrrd", 60.5);
    check_real("carotid.vtk", 100.5);
    check_real("cthead", 100.5);
    check_real("tooth.nhdr", 500.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_known_surfaces), cmocka_unit_test(test_rays_in_faces), cmocka_unit_test(test_real_volumes) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
