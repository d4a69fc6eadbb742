/* SPDX-License-Identifier: MIT */
/* Isosurfaces where their place, slope and colour are known: spheres and planes, any grid, any step; shading and linear light. */
#include "pictures.h"

enum { SIZE = 64 };

static const struct pel_volume *placed; /* the volume that is being filled: formulas of the world need its placement */

static double distance_from_center(const double index[3])
{
    double world[3], center[3], d[3];
    const double middle[3] = { (double)(placed->dims[0] - 1) / 2, (double)(placed->dims[1] - 1) / 2, (double)(placed->dims[2] - 1) / 2 };
    pel_volume_index_to_world(placed, index, world);
    pel_volume_index_to_world(placed, middle, center);
    for (int i = 0; i < 3; i++)
        d[i] = world[i] - center[i];
    return sqrt(dot3(d, d));
}

enum grid { UNIT_GRID, ANISOTROPIC_GRID, SHEARED_GRID, LEFT_HANDED_GRID, GRID_COUNT };
static const char *const grid_names[] = { "unit", "anisotropic", "sheared", "left-handed" };

/* A grid whose box holds a sphere of radius 50 round its middle. */
static void place(struct pel_volume *volume, enum grid grid, formula *f)
{
    double spacing[3] = { 1, 1.25, 0.8 };
    if (grid == UNIT_GRID)
        spacing[0] = spacing[1] = spacing[2] = 1;
    double wider = grid == SHEARED_GRID ? 132 : 108;
    pel_volume_init(volume);
    memcpy(volume->spacing, spacing, sizeof spacing);
    memcpy(volume->origin, (double[3]){ -30, 12, 400 }, sizeof volume->origin);
    if (grid == SHEARED_GRID)
        memcpy(volume->direction[1], (double[3]){ 0.28, 0.96, 0 }, sizeof volume->direction[1]);
    if (grid == LEFT_HANDED_GRID)
        volume->direction[0][0] = -1;
    const size_t dims[3] = { (size_t)(wider / spacing[0]), (size_t)(108 / spacing[1]) + 4, (size_t)(108 / spacing[2]) };
    assert_true(pel_volume_allocate(volume, dims, PEL_F32, 1, NULL));
    placed = volume;
    fill_volume(volume, f);
}

static void center_of(const struct pel_volume *volume, double center[3])
{
    const double middle[3] = { (double)(volume->dims[0] - 1) / 2, (double)(volume->dims[1] - 1) / 2, (double)(volume->dims[2] - 1) / 2 };
    pel_volume_index_to_world(volume, middle, center);
}

/* What a picture of a sphere of radius 50 shows, against the sphere; `voxel` is the least spacing. */
static void check_sphere(const struct pel_scene *scene, const struct pel_image *image, const char *what)
{
    const double radius = 50, voxel = pel_volume_least_spacing(scene->volume);
    double center[3], origin[3], direction[3], s[2], worst_radius = 0, worst_depth = 0, worst_color = 0;
    int wrong = 0, hits = 0;
    center_of(scene->volume, center);
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            ray_stretch(scene, image->width, image->height, x, y, origin, direction, s);
            double to_center[3] = { center[0] - origin[0], center[1] - origin[1], center[2] - origin[2] }, hit[3], normal[3];
            double along = dot3(to_center, direction), off2 = dot3(to_center, to_center) - along * along, off = sqrt(fmax(off2, 0));
            double depth = depth_at(image, x, y);
            if (off > radius - 0.1 && off < radius + 0.1)
                continue; /* the outline may fall to either side */
            wrong += (off < radius) != isfinite(depth);
            if (off > radius || isinf(depth))
                continue;
            hits++;
            for (int i = 0; i < 3; i++) {
                hit[i] = origin[i] + depth * direction[i] - center[i];
                normal[i] = hit[i] / radius;
            }
            worst_radius = fmax(worst_radius, fabs(sqrt(dot3(hit, hit)) - radius));
            if (off < 0.8 * radius) {
                worst_depth = fmax(worst_depth, fabs(depth - (along - sqrt(radius * radius - off2))) * sqrt(1 - off2 / (radius * radius)));
                worst_color = fmax(worst_color, fabs(channel(image, x, y, 1) - 0.5 * (0.1 + 0.9 * fabs(dot3(normal, direction)))));
            }
        }
    check_at_least(hits, 600, "%s: pixels of the sphere", what);
    check_at_most(wrong, 0, "%s: pixels on the wrong side of the outline", what);
    check_at_most(worst_radius / voxel, 0.01, "%s: error of the radius in voxels", what);
    check_at_most(worst_depth / voxel, 0.01, "%s: error of the surface along its normal, from the depth, in voxels", what);
    check_at_most(worst_color, 2e-3, "%s: error of diffuse shading", what);
}

static void test_sphere(void **state)
{
    (void)state;
    for (int grid = 0; grid < GRID_COUNT; grid++) {
        struct pel_volume volume;
        struct pel_scene scene;
        place(&volume, (enum grid)grid, distance_from_center);
        make_scene(&scene, &volume, NULL);
        scene.render.mode = PEL_MODE_ISOSURFACE;
        scene.isosurfaces[0] = (struct pel_isosurface){ 50, { 1, 0.5, 0.25 }, 1 };
        scene.isosurface_count = 1;
        scene.render.ambient = 0.1, scene.render.diffuse = 0.9, scene.render.specular = 0;
        for (int t = 0; techniques[t]; t++)
            for (int variant = 0; variant < 4; variant++) {
                struct pel_image image;
                char what[96];
                scene.camera.parallel = variant & 1;
                scene.render.step = variant & 2 ? 2 : 0.5;
                draw(&scene, techniques[t], SIZE, SIZE, &image);
                snprintf(what, sizeof what, "%s: sphere, %s grid, %s, step %g", techniques[t], grid_names[grid],
                         variant & 1 ? "parallel" : "perspective", scene.render.step);
                check_sphere(&scene, &image, what);
                pel_image_finish(&image);
            }
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

/* A plane's height above the middle of the volume: trilinear reconstruction is exact, so are places and slopes. */
static const double plane_normal[3] = { 2.0 / 7, -3.0 / 7, 6.0 / 7 };

static double height(const double index[3])
{
    double world[3], center[3];
    pel_volume_index_to_world(placed, index, world);
    center_of(placed, center);
    return dot3(world, plane_normal) - dot3(center, plane_normal);
}

/* Keeps only the middle of the volume: within a voxel of its faces slopes are one-sided, and the formulas here know nothing of that. */
static void keep_middle(struct pel_scene *scene)
{
    double center[3];
    center_of(scene->volume, center);
    scene->clip_box_enabled = true;
    for (int axis = 0; axis < 3; axis++)
        scene->clip_box[2 * axis] = center[axis] - 30, scene->clip_box[2 * axis + 1] = center[axis] + 30;
    scene->camera.view_angle = 15;
    scene->camera.parallel_scale = 50;
}

static double decode(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static double encode(double c)
{
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}

/* Blinn-Phong of one colour channel with the scene's lights, from the formula in docs/optics.md. */
static double phong(const struct pel_scene *scene, int c, double color, const double direction[3])
{
    const struct pel_render_settings *r = &scene->render;
    double n[3], light = r->ambient, highlight = 0, side = dot3(plane_normal, direction) > 0 ? -1 : 1;
    for (int i = 0; i < 3; i++)
        n[i] = side * plane_normal[i];
    for (int i = 0; i < scene->light_count; i++) {
        double l[3], h[3], ll, hh;
        for (int j = 0; j < 3; j++)
            l[j] = scene->lights[i].headlight ? -direction[j] : scene->lights[i].direction[j];
        ll = sqrt(dot3(l, l));
        for (int j = 0; j < 3; j++)
            h[j] = l[j] / ll - direction[j];
        hh = sqrt(dot3(h, h));
        light += r->diffuse * fmax(dot3(n, l) / ll, 0) * scene->lights[i].color[c];
        highlight += r->specular * pow(fmax(dot3(n, h) / hh, 0), r->specular_power) * scene->lights[i].color[c];
    }
    return fmin(fmax(color * light + highlight, 0), 1);
}

/* Two or three translucent planes composited in the order of the ray, as their analytic colour says. */
static void check_planes(const struct pel_scene *scene, const char *technique, const char *what)
{
    struct pel_image image;
    double worst = 0, worst_depth = 0, origin[3], direction[3], s[2], center[3];
    int seen = 0;
    draw(scene, technique, SIZE, SIZE, &image);
    center_of(scene->volume, center);
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            double t[PEL_MAX_ISOSURFACES], C[3] = { 0, 0, 0 }, A = 0, first = INFINITY, dn;
            if (!ray_stretch(scene, SIZE, SIZE, x, y, origin, direction, s))
                continue;
            dn = dot3(direction, plane_normal);
            bool edge = false;
            for (int i = 0; i < scene->isosurface_count; i++) {
                t[i] = (scene->isosurfaces[i].value + dot3(center, plane_normal) - dot3(origin, plane_normal)) / dn;
                edge = edge || fabs(t[i] - s[0]) < 1e-3 || fabs(t[i] - s[1]) < 1e-3;
            }
            if (edge)
                continue;
            for (double after = s[0];;) { /* the next crossing along the ray, until there is none */
                int next = -1;
                for (int i = 0; i < scene->isosurface_count; i++)
                    if (t[i] > after && t[i] < s[1] && (next < 0 || t[i] < t[next]))
                        next = i;
                if (next < 0)
                    break;
                const struct pel_isosurface *surface = &scene->isosurfaces[next];
                for (int c = 0; c < 3; c++) {
                    double color = scene->linear_light ? decode(surface->color[c]) : surface->color[c];
                    C[c] += (1 - A) * surface->opacity * phong(scene, c, color, direction);
                }
                A += (1 - A) * surface->opacity;
                first = fmin(first, t[next]);
                after = t[next];
                seen++;
            }
            for (int c = 0; c < 3; c++) {
                double expected = scene->linear_light && A > 0 ? encode(C[c] / A) * A : C[c];
                worst = fmax(worst, fabs(channel(&image, x, y, c) - expected));
            }
            worst = fmax(worst, fabs(channel(&image, x, y, 3) - A));
            if (isfinite(first) || isfinite(depth_at(&image, x, y)))
                worst_depth = fmax(worst_depth, fabs(depth_at(&image, x, y) - first));
        }
    check_at_least(seen, 400, "%s: crossings seen, %s", technique, what);
    check_at_most(worst, 2e-3, "%s: error of colour or alpha, %s", technique, what);
    check_at_most(worst_depth, 2e-3, "%s: error of depth, %s", technique, what);
    pel_image_finish(&image);
}

static void test_translucent_planes(void **state)
{
    (void)state;
    const struct pel_isosurface surfaces[] = {
        { 6, { 1, 0.3, 0.1 }, 0.4 },
        { -5, { 0.1, 0.8, 0.2 }, 0.7 },
        { 11, { 0.2, 0.3, 0.9 }, 0.25 },
    };
    for (int grid = 0; grid < GRID_COUNT; grid++) {
        struct pel_volume volume;
        struct pel_scene scene;
        place(&volume, (enum grid)grid, height);
        make_scene(&scene, &volume, NULL);
        keep_middle(&scene);
        scene.render.mode = PEL_MODE_ISOSURFACE;
        memcpy(scene.isosurfaces, surfaces, sizeof surfaces);
        scene.isosurface_count = 3;
        for (int t = 0; techniques[t]; t++)
            for (int variant = 0; variant < 8; variant++) {
                char what[96];
                scene.camera.parallel = variant & 1;
                scene.render.step = variant & 2 ? 40 : 0.5; /* 40: all three in one segment */
                scene.linear_light = variant & 4;
                scene.render.ambient = 0.15, scene.render.diffuse = 0.7, scene.render.specular = 0.2, scene.render.specular_power = 12;
                snprintf(what, sizeof what, "planes, %s grid, %s, step %g%s", grid_names[grid], variant & 1 ? "parallel" : "perspective",
                         scene.render.step, variant & 4 ? ", linear light" : "");
                check_planes(&scene, techniques[t], what);
            }
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
}

static void test_lights(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    place(&volume, ANISOTROPIC_GRID, height);
    make_scene(&scene, &volume, NULL);
    keep_middle(&scene);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.isosurfaces[0] = (struct pel_isosurface){ 1, { 0.7, 0.6, 0.5 }, 0.8 };
    scene.isosurface_count = 1;
    scene.render.ambient = 0.1, scene.render.diffuse = 0.5, scene.render.specular = 0.6, scene.render.specular_power = 20;
    scene.light_count = 3;
    scene.lights[0] = (struct pel_light){ true, { 0, 0, 0 }, { 0.3, 0.3, 0.2 } };
    scene.lights[1] = (struct pel_light){ false, { 10, -20, 30 }, { 0.9, 0.5, 0.1 } };
    scene.lights[2] = (struct pel_light){ false, { -1, 0, -2 }, { 0.2, 0.4, 0.9 } };
    for (int t = 0; techniques[t]; t++)
        for (int count = 0; count <= 3; count++) {
            char what[32];
            scene.light_count = count;
            snprintf(what, sizeof what, "%d lights", count);
            check_planes(&scene, techniques[t], what);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Composite through the plane's ramp, shaded: every sample has the same slope, so the colour is the shaded one; with nearest reconstruction
 * and a constant opacity there is no slope at all, and the colour is ambient + diffuse. */
static void test_shaded_composite(void **state)
{
    (void)state;
    struct pel_volume volume;
    struct pel_scene scene;
    place(&volume, SHEARED_GRID, height);
    make_scene(&scene, &volume, "0.02");
    keep_middle(&scene);
    set_flat_color(&scene, 0.7, 0.6, 0.5);
    scene.render.shade = true;
    scene.render.ambient = 0.1, scene.render.diffuse = 0.5, scene.render.specular = 0.4, scene.render.specular_power = 20;
    const double color[3] = { 0.7, 0.6, 0.5 };
    for (int t = 0; techniques[t]; t++)
        for (int variant = 0; variant < 8; variant++) {
            struct pel_image image;
            double worst = 0, origin[3], direction[3], s[2];
            int seen = 0;
            scene.linear_light = variant >= 4;
            scene.render.classification = (enum pel_classification)(variant % 4 % 3);
            scene.render.reconstruction = variant % 4 == 3 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
            draw(&scene, techniques[t], SIZE, SIZE, &image);
            for (int y = 0; y < SIZE; y++)
                for (int x = 0; x < SIZE; x++) {
                    bool hit = ray_stretch(&scene, SIZE, SIZE, x, y, origin, direction, s);
                    double alpha = channel(&image, x, y, 3);
                    seen += hit && alpha > 0.5;
                    for (int c = 0; c < 3; c++) {
                        double base = scene.linear_light ? decode(color[c]) : color[c];
                        double lit = variant % 4 == 3 ? base * 0.6 : phong(&scene, c, base, direction);
                        worst = fmax(worst, fabs(channel(&image, x, y, c) - alpha * (scene.linear_light ? encode(lit) : lit)));
                    }
                }
            check_at_least(seen, 500, "%s: pixels seen", techniques[t]);
            check_at_most(worst, 2e-3, "%s: shaded composite, variant %d", techniques[t], variant);
            pel_image_finish(&image);
        }
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_translucent_planes),
        cmocka_unit_test(test_lights),
        cmocka_unit_test(test_shaded_composite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
