/* SPDX-License-Identifier: MIT */
/* Object-aligned slices on the GPU engine: against the reference, the ray caster and their own CPU half; that n slices a polygon give the
 * picture of one; what is refused; and that nothing is left behind. Skipped, loudly, where no device is usable. */
#include "on_device.h"

#include "device_gl.h"

static void set(struct pel_renderer *renderer, const char *name, const char *value)
{
    set_option_of(renderer, "slices2d", name, value);
}

static void draw_slices_sized(struct pel_renderer *renderer, const struct pel_scene *scene, int width, int height, struct pel_image *image)
{
    draw_by(renderer, scene, "slices2d", width, height, true, image);
}

static void draw_slices(struct pel_renderer *renderer, const struct pel_scene *scene, struct pel_image *image)
{
    draw_slices_sized(renderer, scene, WIDTH, HEIGHT, image);
}

static struct pel_renderer *cpu_renderer(void)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *renderer = pel_renderer_create(NULL, &error);
    assert_non_null(renderer);
    return renderer;
}

/* The 26 directions to a cube's faces, edges and corners. */
static void look_along(struct pel_scene *scene, int direction, bool parallel)
{
    double to[3] = { direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1 };
    struct pel_camera *c = &scene->camera;
    pel_camera_fit(c, scene->volume, WIDTH, HEIGHT);
    double length = 0, distance = 0;
    for (int i = 0; i < 3; i++) {
        length += to[i] * to[i];
        distance += (c->position[i] - c->focal_point[i]) * (c->position[i] - c->focal_point[i]);
    }
    for (int i = 0; i < 3; i++) {
        c->position[i] = c->focal_point[i] - to[i] * sqrt(distance / length);
        c->view_up[i] = i == (fabs(to[2]) > 0.8 * sqrt(length) ? 1 : 2);
    }
    c->parallel = parallel;
}

/* At half a voxel from slice to slice. */
static void test_reference(void **state)
{
    (void)state;
    need_device();
    const struct {
        enum pel_type type;
        formula *f;
    } volumes[] = { { PEL_U8, blob }, { PEL_I16, blob }, { PEL_F64, blob }, { PEL_F32, holed } };
    struct pel_renderer *renderer = gpu_renderer();
    set(renderer, "supersampling", "2");
    for (int i = 0; i < 4; i++)
        for (int variant = 0; variant < 8; variant++) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_image truth, gpu;
            make_typed(&volume, &scene, volumes[i].type, volumes[i].f);
            scene.render.step = 0.5;
            scene.render.shade = variant & 1;
            scene.camera.parallel = variant & 2;
            scene.render.classification = variant & 4 ? PEL_CLASSIFICATION_PRE : PEL_CLASSIFICATION_POST;
            scene.linear_light = variant == 3;
            draw(&scene, "reference", WIDTH, HEIGHT, &truth);
            draw_slices(renderer, &scene, &gpu);
            check_at_least(psnr(&truth, &gpu), 40, "%s, variant %d: PSNR of slices against the reference, dB",
                           pel_type_name(volumes[i].type), variant);
            pel_image_finish(&truth);
            pel_image_finish(&gpu);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(device), 0);
}

/* From all sides, turned volumes with unequal spacing: the reference's picture. */
static void test_directions(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    set(renderer, "supersampling", "2");
    scene.render.shade = true;
    for (int direction = 0; direction < 27; direction++) {
        struct pel_image truth, gpu;
        if (direction == 13)
            continue;
        look_along(&scene, direction, direction & 1);
        draw(&scene, "raycast", WIDTH, HEIGHT, &truth);
        draw_slices(renderer, &scene, &gpu);
        check_at_least(psnr(&truth, &gpu), 40, "direction %d: PSNR of slices against ray casting, dB", direction);
        pel_image_finish(&truth);
        pel_image_finish(&gpu);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Depth is the ray caster's to within the distance between slices; for surfaces, exactly. */
static void test_depth(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    set(renderer, "supersampling", "4");
    for (int variant = 0; variant < 8; variant++) {
        struct pel_image truth, gpu;
        const bool surface = variant & 1;
        int both = 0, alike = 0;
        scene.render.mode = surface ? PEL_MODE_ISOSURFACE : PEL_MODE_COMPOSITE;
        look_along(&scene, 3 * variant + 2, variant & 2);
        draw(&scene, "raycast", WIDTH, HEIGHT, &truth);
        draw_slices(renderer, &scene, &gpu);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            if (isfinite(truth.depth[i]) && isfinite(gpu.depth[i])) {
                both++;
                alike += fabs((double)truth.depth[i] - (double)gpu.depth[i]) < (surface ? 0.02 : 1);
            }
        check_at_least(both, 100, "variant %d: pixels with a depth", variant);
        check_at_least(alike, 0.97 * both, "variant %d: pixels with the ray caster's depth", variant);
        pel_image_finish(&truth);
        pel_image_finish(&gpu);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* n slices a polygon: the picture of one, in perspective, close by, and where planes and a box cut. */
static void check_polygons(struct pel_renderer *renderer, const struct pel_scene *scene, const char *what)
{
    struct pel_image one, several;
    set(renderer, "slices-per-polygon", "1");
    draw_slices(renderer, scene, &one);
    for (int n = 2; n <= 8; n *= 2) {
        char text[8];
        snprintf(text, sizeof text, "%d", n);
        set(renderer, "slices-per-polygon", text);
        draw_slices(renderer, scene, &several);
        check_at_least(psnr(&one, &several), 55, "%s: PSNR of %d slices a polygon against one, dB", what, n);
        check_at_most(largest_depth_difference(&one, &several), 0.02, "%s: depth with %d slices a polygon", what, n);
        pel_image_finish(&several);
    }
    pel_image_finish(&one);
}

static void test_slices_a_polygon(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int variant = 0; variant < 16; variant++) {
        char what[64];
        look_along(&scene, 3 * variant % 13, variant & 1);
        scene.render.mode = variant & 2 ? PEL_MODE_ISOSURFACE : PEL_MODE_COMPOSITE;
        scene.render.shade = variant & 8;
        scene.clip_plane_count = scene.clip_box_enabled = 0;
        if (variant & 4)
            clip(&scene);
        set(renderer, "supersampling", variant % 5 ? "1" : "3");
        snprintf(what, sizeof what, "variant %d", variant);
        check_polygons(renderer, &scene, what);
    }
    /* The eye among the slices, in a view so wide that it takes several stacks. */
    scene.render.mode = PEL_MODE_COMPOSITE;
    scene.camera.parallel = false;
    for (int i = 0; i < 3; i++)
        scene.camera.position[i] = scene.camera.focal_point[i] + 2.3 + i;
    for (int angle = 30; angle <= 120; angle += 90) {
        struct pel_image truth, gpu;
        scene.camera.view_angle = angle;
        check_polygons(renderer, &scene, "inside");
        set(renderer, "supersampling", "4");
        draw(&scene, "raycast", WIDTH, HEIGHT, &truth);
        draw_slices(renderer, &scene, &gpu);
        check_at_least(psnr(&truth, &gpu), 35, "inside, %d degrees: PSNR of slices against ray casting, dB", angle);
        pel_image_finish(&truth);
        pel_image_finish(&gpu);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Shear-warp with a fine intermediate image takes the same samples. */
static void test_against_cpu(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *gpu = gpu_renderer(), *cpu = cpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    set(cpu, "intermediate", "picture");
    set(cpu, "rays", "4");
    for (int variant = 0; variant < 24; variant++) {
        struct pel_image a, b;
        look_along(&scene, 5 * variant % 13, variant & 1);
        scene.render.shade = variant & 2;
        scene.clip_plane_count = scene.clip_box_enabled = 0;
        if (variant & 4)
            clip(&scene);
        scene.render.reconstruction = variant >= 16 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
        const char *correction = variant & 8 ? "linear" : "exact", *between = variant % 3 ? "1" : "2";
        set(gpu, "opacity-correction", correction), set(cpu, "opacity-correction", correction);
        set(gpu, "supersampling", between), set(cpu, "supersampling", between);
        draw_slices_sized(cpu, &scene, 4 * WIDTH, 4 * HEIGHT, &a);
        draw_slices_sized(gpu, &scene, 4 * WIDTH, 4 * HEIGHT, &b);
        /* Voxels as blocks and cut faces have edges, which the warp smoothes. */
        check_at_least(psnr(&a, &b),
                       variant >= 16 ? 33
                       : variant & 4 ? 40
                                     : 45,
                       "variant %d: PSNR of the GPU's slices against the CPU's, dB", variant);
        pel_image_finish(&a);
        pel_image_finish(&b);
    }
    pel_renderer_destroy(gpu);
    pel_renderer_destroy(cpu);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Section 9's strips are the ray caster's slice. */
static void test_arbitrary_slices(void **state)
{
    (void)state;
    need_device();
    const double normals[6][3] = { { 1, -2, 0.5 }, { 0, 0, 1 }, { 1, 0, 0 }, { 0.3, 1, 0.1 }, { 1, 1, 1 }, { -2, 1, 1 } };
    struct pel_renderer *renderer = gpu_renderer();
    for (int i = 0; i < 3; i++) {
        struct pel_volume volume;
        struct pel_scene scene;
        make_typed(&volume, &scene, i == 2 ? PEL_F32 : PEL_U8, i == 2 ? holed : blob);
        scene.render.mode = PEL_MODE_SLICE;
        scene.render.reconstruction = i == 1 ? PEL_RECONSTRUCTION_NEAREST : PEL_RECONSTRUCTION_LINEAR;
        for (int variant = 0; variant < 24; variant++) {
            struct pel_image cast, strips;
            memcpy(scene.slice.normal, normals[variant % 6], sizeof scene.slice.normal);
            for (int k = 0; k < PEL_MAX_SLICES - 1; k++) { /* 1 to 8 planes that cross one another */
                scene.more_slices[k] = scene.slice;
                memcpy(scene.more_slices[k].normal, normals[(variant + k + 1) % 6], sizeof scene.slice.normal);
                for (int a = 0; a < 3; a++) /* none through the eye: of a plane that is edge on, rounding picks the pixels */
                    scene.more_slices[k].origin[a] += (k * 1.3 - 2) * (1 + 0.3 * a);
            }
            scene.more_slice_count = variant % PEL_MAX_SLICES;
            look_along(&scene, (7 * variant + 1) % 13, variant & 1);
            scene.clip_plane_count = 0;
            if (variant >= 12)
                clip(&scene), scene.clip_box_enabled = false;
            draw_gpu(renderer, &scene, WIDTH, HEIGHT, &cast);
            draw_slices(renderer, &scene, &strips);
            if (i != 1) /* nearest voxels: ties fall either way */
                check_at_most(largest_difference(&cast, &strips), 1.0 / 255, "volume %d, variant %d: strips", i, variant);
            check_at_least(psnr(&cast, &strips), 45, "volume %d, variant %d: PSNR of strips, dB", i, variant);
            if (i != 1)
                check_at_most(largest_depth_difference(&cast, &strips), 0.01, "volume %d, variant %d: depth of strips", i, variant);
            pel_image_finish(&cast);
            pel_image_finish(&strips);
        }
        pel_scene_finish(&scene);
        pel_volume_finish(&volume);
    }
    pel_renderer_destroy(renderer);
}

/* Crossings between slices are the ray caster's surfaces; the paper's alpha test is behind them. */
static void test_surfaces(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image truth, crossing, tested;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    scene.render.mode = PEL_MODE_ISOSURFACE;
    scene.light_count = 2;
    scene.lights[0].color[2] = 0.2;
    scene.lights[1] = (struct pel_light) { .headlight = false, .direction = { 1, 2, -1 }, .color = { 0.6, 0.5, 0.9 } };
    set(renderer, "supersampling", "2");
    draw(&scene, "reference", WIDTH, HEIGHT, &truth);
    draw_slices(renderer, &scene, &crossing);
    check_at_least(psnr(&truth, &crossing), 40, "PSNR of translucent surfaces, dB");
    pel_image_finish(&truth);
    pel_image_finish(&crossing);
    scene.isosurface_count = 1;
    scene.isosurfaces[0].opacity = 1;
    draw(&scene, "reference", WIDTH, HEIGHT, &truth);
    draw_slices(renderer, &scene, &crossing);
    set(renderer, "surface", "alpha-test");
    draw_slices(renderer, &scene, &tested);
    check_at_least(psnr(&truth, &crossing), 40, "PSNR of a surface, dB");
    check_at_least(psnr(&crossing, &tested), 18, "the alpha test's surface");
    check_at_most(psnr(&truth, &tested), psnr(&truth, &crossing) - 3, "the alpha test is less exact: PSNR, dB");
    pel_image_finish(&truth);
    pel_image_finish(&crossing);
    pel_image_finish(&tested);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Across the switch of stacks a blend changes by little what a switch changes at once. */
static void test_blend(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    double jumps[2];
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int a = 0; a < 3; a++)
        volume.spacing[a] = 1;
    memcpy(volume.direction[1], (double[3]) { 0, 1, 0 }, sizeof volume.direction[1]);
    for (int i = 0; i < 2; i++) {
        struct pel_image before, behind;
        set(renderer, "blend", i ? "10" : "0");
        look_parallel(&scene, (double[3]) { 1, 0.996, 0.2 }, 60, 18);
        draw_slices(renderer, &scene, &before);
        look_parallel(&scene, (double[3]) { 0.996, 1, 0.2 }, 60, 18);
        draw_slices(renderer, &scene, &behind);
        jumps[i] = psnr(&before, &behind);
        pel_image_finish(&before);
        pel_image_finish(&behind);
    }
    check_at_least(jumps[1], jumps[0] + 3, "likeness before and behind the switch with a blend, against %.1f without, dB", jumps[0]);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Cells that cannot be seen are left out, and that is not seen. */
static void test_skipping(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_renderer *renderer = gpu_renderer();
    make_sized(&volume, &scene, (const size_t[3]) { 45, 41, 38 }, PEL_U8, blob);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "40:0,60:0.4", NULL));
    for (int direction = 0; direction < 27; direction += 2) {
        struct pel_image with, without;
        uint64_t fragments[2];
        look_along(&scene, direction, direction & 4);
        scene.render.mode = direction % 3 ? PEL_MODE_COMPOSITE : PEL_MODE_ISOSURFACE;
        scene.render.skip = true;
        draw_slices(renderer, &scene, &with);
        fragments[0] = pel_renderer_stats(renderer)->counters[0].value;
        scene.render.skip = false;
        draw_slices(renderer, &scene, &without);
        fragments[1] = pel_renderer_stats(renderer)->counters[0].value;
        check_at_most(largest_difference(&with, &without), 1e-6, "direction %d: skipping", direction);
        check_at_most((double)fragments[0], 0.8 * (double)fragments[1], "direction %d: fragments", direction);
        pel_image_finish(&with);
        pel_image_finish(&without);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

static void check_refused(struct pel_renderer *renderer, const struct pel_scene *scene, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_renderer_draw(renderer, scene, "slices2d", image, &error));
    if (!strstr(error.message, "raycast"))
        fail_msg("does not name raycast: %s", error.message);
}

/* What cannot be drawn is refused by an error that names what can draw it; stacks come when they are needed. */
static void test_refusals_and_stacks(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image image;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, WIDTH, HEIGHT, false, NULL));
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        if (mode != PEL_MODE_COMPOSITE && mode != PEL_MODE_ISOSURFACE && mode != PEL_MODE_SLICE) {
            scene.render.mode = (enum pel_mode)mode;
            check_refused(renderer, &scene, &image);
        }
    scene.render.mode = PEL_MODE_COMPOSITE;
    scene.render.classification = PEL_CLASSIFICATION_PREINTEGRATED;
    check_refused(renderer, &scene, &image);
    scene.render.classification = PEL_CLASSIFICATION_POST;
    int side = device->info.max_texture_2d;
    device->info.max_texture_2d = 26;
    check_refused(renderer, &scene, &image);
    device->info.max_texture_2d = side;
    uint64_t bytes = 0;
    for (int axis = 0; axis < 3; axis++) {
        look_parallel(&scene, (double[3]) { axis == 0, axis == 1, axis == 2 }, 60, 18);
        assert_true(pel_renderer_draw(renderer, &scene, "slices2d", &image, NULL));
        for (int i = 0; i < pel_renderer_stats(renderer)->counter_count; i++)
            if (!strcmp(pel_renderer_stats(renderer)->counters[i].name, "bytes of slices")) {
                uint64_t now = pel_renderer_stats(renderer)->counters[i].value;
                check_at_least((double)now, (double)bytes + 29 * 25 * 27, "bytes of slices with stack %d", axis);
                bytes = now;
            }
    }
    pel_image_finish(&image);
    pel_renderer_destroy(renderer);
    assert_int_equal(pel_device_objects(device), 0);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* A slice for two or three slices of voxels is a coarser picture of the same. */
static void test_slice_step(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image fine, coarse;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    assert_true(pel_transfer_parse_opacity(&scene.transfer, "10:0,90:0.2", NULL));
    for (int direction = 0; direction < 13; direction += 3) {
        look_along(&scene, direction, direction & 1);
        set(renderer, "slice-step", "1");
        draw_slices(renderer, &scene, &fine);
        uint64_t fragments = pel_renderer_stats(renderer)->counters[0].value;
        for (int step = 2; step <= 3; step++) {
            set(renderer, "slice-step", step == 2 ? "2" : "3");
            draw_slices(renderer, &scene, &coarse);
            check_at_least(psnr(&fine, &coarse), 30, "direction %d: PSNR of slice step %d, dB", direction, step);
            check_at_most((double)pel_renderer_stats(renderer)->counters[0].value, 0.8 * (double)fragments, "fragments of slice step %d",
                          step);
            pel_image_finish(&coarse);
        }
        pel_image_finish(&fine);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* State of a host program that would mislead us, and that it finds again. */
static const GLenum odd_switches[] = { GL_DEPTH_TEST, GL_CULL_FACE, GL_STENCIL_TEST, GL_SCISSOR_TEST, GL_COLOR_LOGIC_OP };

static void draw_oddly(GLuint array)
{
    for (size_t i = 0; i < sizeof odd_switches / sizeof *odd_switches; i++)
        glEnable(odd_switches[i]);
    glDepthFunc(GL_NEVER);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    glViewport(1, 2, 3, 4);
    glScissor(1, 1, 1, 1);
    glBlendFunc(GL_ZERO, GL_DST_COLOR);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glBindVertexArray(array);
}

static void check_odd(GLuint array)
{
    GLint got[4];
    GLboolean mask[4];
    for (size_t i = 0; i < sizeof odd_switches / sizeof *odd_switches; i++)
        assert_true(glIsEnabled(odd_switches[i]));
    const GLenum names[] = { GL_DEPTH_FUNC,           GL_CLIP_ORIGIN,     GL_BLEND_SRC_RGB,           GL_BLEND_DST_RGB,
                             GL_VERTEX_ARRAY_BINDING, GL_CURRENT_PROGRAM, GL_DRAW_FRAMEBUFFER_BINDING };
    const GLint values[] = { GL_NEVER, GL_UPPER_LEFT, GL_ZERO, GL_DST_COLOR, (GLint)array, 0, 0 };
    for (int i = 0; i < 7; i++) {
        glGetIntegerv(names[i], got);
        assert_int_equal(got[0], values[i]);
    }
    glGetIntegerv(GL_VIEWPORT, got);
    for (int i = 0; i < 4; i++)
        assert_int_equal(got[i], 1 + i);
    glGetBooleanv(GL_COLOR_WRITEMASK, mask);
    assert_false(mask[0]);
    assert_true(mask[1]);
}

static void test_borrowed(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image own, borrowed;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer *renderer = gpu_renderer();
    make_typed(&volume, &scene, PEL_U8, blob);
    for (int mode = 0; mode < 3; mode++) {
        scene.render.mode = mode == 0 ? PEL_MODE_COMPOSITE : mode == 1 ? PEL_MODE_ISOSURFACE : PEL_MODE_SLICE;
        draw_slices(renderer, &scene, &own);
        struct pel_device *host = pel_device_create(-1, NULL, &error); /* its context plays the host program's */
        assert_non_null(host);
        assert_true(pel_device_begin(host, &error));
        struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
        params.device = pel_device_wrap_current(&error);
        assert_non_null(params.device);
        struct pel_renderer *guest = pel_renderer_create(&params, &error);
        assert_non_null(guest);
        GLuint array;
        glGenVertexArrays(1, &array);
        draw_oddly(array);
        draw_slices(guest, &scene, &borrowed);
        check_odd(array);
        check_at_most(largest_difference(&own, &borrowed), 0, "mode %d: in a host's context", mode);
        pel_renderer_destroy(guest);
        check_odd(array);
        assert_int_equal(pel_device_objects(params.device), 0);
        pel_device_destroy(params.device);
        pel_device_end(host);
        pel_device_destroy(host);
        pel_image_finish(&own);
        pel_image_finish(&borrowed);
    }
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* The paper's ways show what they are for: light, a global ambient colour, displaced slices. */
static void test_paper_ways(void **state)
{
    (void)state;
    need_device();
    struct pel_volume volume;
    struct pel_scene scene;
    struct pel_image plain, other;
    struct pel_renderer *renderer = gpu_renderer();
    const char *const ways[][2] = { { "lighting", "global" }, { "lighting", "voxel" }, { "texture-coordinates", "shared" } };
    make_typed(&volume, &scene, PEL_U8, blob);
    scene.render.shade = true;
    draw_slices(renderer, &scene, &plain);
    for (int i = 0; i < 3; i++) {
        set(renderer, ways[i][0], ways[i][1]);
        draw_slices(renderer, &scene, &other);
        check_at_most(psnr(&plain, &other), 40, "%s %s is another picture", ways[i][0], ways[i][1]);
        check_at_least(psnr(&plain, &other), 8, "%s %s is a picture of the same", ways[i][0], ways[i][1]);
        set(renderer, "lighting", "scene");
        pel_image_finish(&other);
    }
    pel_image_finish(&plain);
    pel_renderer_destroy(renderer);
    pel_scene_finish(&scene);
    pel_volume_finish(&volume);
}

/* Volumes of one voxel along an axis or two. Seen along it there is one slice for all of it, so that the CPU's slices are what they are
 * held to. */
static void test_thin(void **state)
{
    (void)state;
    need_device();
    struct pel_renderer *renderer = gpu_renderer(), *cpu = cpu_renderer();
    const size_t sizes[5][3] = { { 1, 20, 20 }, { 20, 1, 20 }, { 20, 20, 1 }, { 1, 1, 20 }, { 2, 30, 3 } };
    set(cpu, "intermediate", "picture");
    set(cpu, "rays", "4");
    for (int i = 0; i < 5; i++)
        for (int direction = 0; direction < 13; direction += 3) {
            struct pel_volume volume;
            struct pel_scene scene;
            struct pel_image truth, gpu;
            make_sized(&volume, &scene, sizes[i], PEL_U8, blob);
            assert_true(pel_transfer_parse_opacity(&scene.transfer, "0:0.1,8:0.6", NULL));
            look_along(&scene, direction, false);
            draw_slices(cpu, &scene, &truth);
            draw_slices(renderer, &scene, &gpu);
            check_at_least(psnr(&truth, &gpu), 35, "volume %d, direction %d: PSNR, dB", i, direction);
            pel_image_finish(&truth);
            pel_image_finish(&gpu);
            pel_scene_finish(&scene);
            pel_volume_finish(&volume);
        }
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(cpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_directions),
        cmocka_unit_test(test_slices_a_polygon),
        cmocka_unit_test(test_against_cpu),
        cmocka_unit_test(test_arbitrary_slices),
        cmocka_unit_test(test_surfaces),
        cmocka_unit_test(test_blend),
        cmocka_unit_test(test_skipping),
        cmocka_unit_test(test_refusals_and_stacks),
        cmocka_unit_test(test_paper_ways),
        cmocka_unit_test(test_thin),
        cmocka_unit_test(test_slice_step),
        cmocka_unit_test(test_borrowed),
        cmocka_unit_test(test_depth),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
