/* SPDX-License-Identifier: MIT */
/* Refinement at rest: the mean of jittered frames is nearer to the truth, any change starts over, and nothing of it is seen where it is
 * off. */
#include "pictures.h"

enum { WIDTH = 57, HEIGHT = 43, FRAMES = 16 };

static struct pel_renderer *make_renderer(int threads, struct pel_progress progress)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.threads = threads;
    params.progress = progress;
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    if (!renderer)
        fail_msg("%s", error.message);
    return renderer;
}

static void make_image(struct pel_image *image, int width, int height, bool with_depth)
{
    pel_image_init(image);
    assert_true(pel_image_allocate(image, width, height, with_depth, NULL));
}

static void draw_next(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_renderer_draw(renderer, scene, technique, image, &error))
        fail_msg("%s: %s", technique, error.message);
}

static int counter(const struct pel_renderer *renderer, const char *name)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    for (int i = 0; i < stats->counter_count; i++)
        if (!strcmp(stats->counters[i].name, name))
            return (int)stats->counters[i].value;
    return -1;
}

/* Shells: thin against a step of a voxel and a half. */
static double shells(const double index[3])
{
    double x = index[0] - 13, y = index[1] - 12, z = index[2] - 14, r = sqrt(x * x + y * y + z * z);
    return r > 12 ? 0 : 60 + 50 * cos(1.7 * r) + 8 * sin(x * 0.8);
}

struct view {
    struct pel_volume volume;
    struct pel_scene scene;
};

static int make_view(void **state)
{
    struct view *v = calloc(1, sizeof *v);
    make_volume(&v->volume, 27, 26, 29, PEL_U8, shells);
    memcpy(v->volume.spacing, (double[3]){ 1, 1.2, 0.9 }, sizeof v->volume.spacing);
    make_scene(&v->scene, &v->volume, "20:0,50:0.05,80:0.3,105:0.6");
    assert_true(pel_transfer_set_colormap(&v->scene.transfer, "viridis", 0, 118, NULL));
    v->scene.isosurfaces[0] = (struct pel_isosurface){ 70.5, { 1, 0.9, 0.8 }, 0.5 };
    v->scene.isosurface_count = 1;
    pel_volume_index_to_world(&v->volume, (const double[3]){ 13, 12, 14 }, v->scene.slice.origin);
    memcpy(v->scene.slice.normal, (double[3]){ 1, -2, 0.5 }, sizeof v->scene.slice.normal);
    v->scene.render.shade = true;
    v->scene.render.step = 1.5;
    *state = v;
    return 0;
}

static int finish_view(void **state)
{
    struct view *v = *state;
    pel_scene_finish(&v->scene);
    pel_volume_finish(&v->volume);
    free(v);
    return 0;
}

/* Against a sixteenth of a voxel: the mean is nearer than the first frame and than one frame at half a voxel. */
static void test_nearer(void **state)
{
    struct view *v = *state;
    const enum pel_mode modes[] = { PEL_MODE_COMPOSITE, PEL_MODE_MIP, PEL_MODE_AVERAGE, PEL_MODE_XRAY };
    for (int t = 0; techniques[t]; t++)
        for (int m = 0; m < 4; m++) {
            struct pel_image truth, half, first, image;
            struct pel_renderer *renderer = make_renderer(2, (struct pel_progress){ 0 });
            make_image(&image, WIDTH, HEIGHT, true);
            v->scene.render.mode = modes[m];
            v->scene.render.step = 1.0 / 16;
            draw(&v->scene, techniques[t], WIDTH, HEIGHT, &truth);
            v->scene.render.step = 0.5;
            draw(&v->scene, techniques[t], WIDTH, HEIGHT, &half);
            v->scene.render.step = 1.5;
            draw(&v->scene, techniques[t], WIDTH, HEIGHT, &first);
            v->scene.render.refine = FRAMES;
            draw_next(renderer, &v->scene, techniques[t], &image);
            check_same_bytes(&first, &image, "the first frame is as the settings say");
            for (int i = 1; i <= FRAMES; i++) {
                assert_false(pel_renderer_finished(renderer));
                draw_next(renderer, &v->scene, techniques[t], &image);
                assert_int_equal(counter(renderer, "frames averaged"), i);
            }
            assert_true(pel_renderer_finished(renderer));
            assert_memory_equal(first.depth, image.depth, sizeof(float) * WIDTH * HEIGHT);
            double before = psnr(&truth, &first), at_half = psnr(&truth, &half), after = psnr(&truth, &image);
            print_message("%s, mode %d: %.1f dB at 1.5 voxels, %.1f dB at half a voxel, %.1f dB refined\n", techniques[t], modes[m], before,
                          at_half, after);
            double gain = modes[m] == PEL_MODE_MIP ? 0.5 : 6; /* the mean of maxima is below the greatest */
            check_at_least(after, before + 6, "%s, mode %d: PSNR of the refined picture against the first", techniques[t], modes[m]);
            check_at_least(after, at_half + gain, "%s, mode %d: PSNR against one frame at half a voxel", techniques[t], modes[m]);

            struct pel_image again;
            make_image(&again, WIDTH, HEIGHT, true);
            draw_next(renderer, &v->scene, techniques[t], &again);
            check_same_bytes(&image, &again, "the finished picture stays");
            assert_int_equal(counter(renderer, "frames averaged"), FRAMES);
            assert_int_equal(counter(renderer, "samples taken"), -1); /* nothing was drawn */
            v->scene.render.refine = 0;
            draw_next(renderer, &v->scene, techniques[t], &again);
            check_same_bytes(&first, &again, "without refinement it is the first frame again");
            assert_int_equal(counter(renderer, "frames averaged"), -1);
            assert_true(pel_renderer_finished(renderer));
            struct pel_image *all[] = { &truth, &half, &first, &image, &again };
            for (int i = 0; i < 5; i++)
                pel_image_finish(all[i]);
            pel_renderer_destroy(renderer);
        }
}

/* One refined frame is what the same settings draw by themselves: what is kept from the coarse step must not be seen, nor, after it, what
 * is kept from the fine one. */
static void test_steps(void **state)
{
    struct view *v = *state;
    const double steps[] = { 0.3, 0.9, 6 }; /* at 6, cells are not passed over where segments' ends count */
    struct pel_renderer *renderer = make_renderer(2, (struct pel_progress){ 0 });
    for (int mode = 0; mode <= PEL_MODE_SLICE; mode++)
        for (int c = 0; c < (mode == PEL_MODE_COMPOSITE ? 3 : 1); c++)
            for (int s = 0; s < 3; s++) {
                struct pel_image coarse, fine, image;
                char what[96];
                snprintf(what, sizeof what, "mode %d, classification %d, step %g", mode, c, steps[s]);
                v->scene.render.mode = (enum pel_mode)mode;
                v->scene.render.classification = (enum pel_classification)c;
                v->scene.render.step = steps[s];
                draw(&v->scene, "raycast", WIDTH, HEIGHT, &coarse);
                v->scene.render.step = fmin(steps[s], 0.5);
                v->scene.render.jitter = true;
                draw(&v->scene, "raycast", WIDTH, HEIGHT, &fine);
                v->scene.render.step = steps[s];
                v->scene.render.jitter = false;
                v->scene.render.refine = 1;
                make_image(&image, WIDTH, HEIGHT, true);
                draw_next(renderer, &v->scene, "raycast", &image);
                check_same_bytes(&coarse, &image, what);
                draw_next(renderer, &v->scene, "raycast", &image);
                for (int i = 0; i < pel_renderer_stats(renderer)->stage_count; i++) /* which cells may be seen does not hang on the step */
                    assert_string_not_equal(pel_renderer_stats(renderer)->stages[i].name, "classify");
                memcpy(fine.depth, coarse.depth, sizeof(float) * WIDTH * HEIGHT);
                check_same_bytes(&fine, &image, what);
                v->scene.render.refine = 0;
                pel_image_finish(&coarse);
                pel_image_finish(&fine);
                pel_image_finish(&image);
            }
    pel_renderer_destroy(renderer);
}

static void turn(struct pel_scene *scene) { pel_camera_azimuth(&scene->camera, 20); }
static void edit(struct pel_scene *scene) { assert_true(pel_transfer_parse_opacity(&scene->transfer, "30:0,90:0.7", NULL)); }
static void move_isovalue(struct pel_scene *scene) { scene->isosurfaces[0].value += 1; }
static void change_step(struct pel_scene *scene) { scene->render.step = 0.8; }
static void change_jitter(struct pel_scene *scene) { scene->render.jitter = !scene->render.jitter; }
static void change_refine(struct pel_scene *scene) { scene->render.refine++; }
static void change_shade(struct pel_scene *scene) { scene->render.shade = !scene->render.shade; }
static void change_light(struct pel_scene *scene) { scene->lights[0].color[1] = 0.5; }
static void clip(struct pel_scene *scene)
{
    scene->clip_box_enabled = true;
    memcpy(scene->clip_box, (double[6]){ 3, 20, 2, 40, -1, 22 }, sizeof scene->clip_box);
}
static void keep(struct pel_scene *scene) { (void)scene; }

/* After some refined frames a change is made: the next picture is a new renderer's, and so is the one after. */
static void test_restart(void **state)
{
    struct view *v = *state;
    static const struct {
        const char *name;
        void (*change)(struct pel_scene *scene);
        bool invalidate;
        const char *technique;
        int width;
        bool with_depth;
    } changes[] = {
        { "turned", turn },
        { "opacity", edit },
        { "isovalue", move_isovalue },
        { "step", change_step },
        { "jitter", change_jitter },
        { "refine", change_refine },
        { "shading", change_shade },
        { "light", change_light },
        { "clip box", clip },
        { "samples", keep, .invalidate = true },
        { "technique", keep, .technique = "reference" },
        { "size", keep, .width = WIDTH + 3 },
        { "depth asked for", keep, .with_depth = true },
    };
    struct pel_renderer *renderer = make_renderer(2, (struct pel_progress){ 0 });
    v->scene.render.refine = 5;
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        const char *technique = changes[i].technique ? changes[i].technique : "raycast";
        int width = changes[i].width ? changes[i].width : WIDTH;
        struct pel_image image, fresh;
        make_image(&image, WIDTH, HEIGHT, false);
        pel_renderer_invalidate(renderer); /* so that each round begins with a first frame */
        for (int k = 0; k < 4; k++)
            draw_next(renderer, &v->scene, "raycast", &image);
        assert_int_equal(counter(renderer, "frames averaged"), 3);
        pel_image_finish(&image);
        changes[i].change(&v->scene);
        if (changes[i].invalidate)
            pel_renderer_invalidate(renderer);
        make_image(&image, width, HEIGHT, true);
        make_image(&fresh, width, HEIGHT, true);
        if (!changes[i].with_depth) { /* so that asking for it is no change */
            free(image.depth);
            image.depth = NULL;
        }
        struct pel_renderer *other = make_renderer(1, (struct pel_progress){ 0 });
        for (int k = 0; k < 3; k++) {
            draw_next(renderer, &v->scene, technique, &image);
            draw_next(other, &v->scene, technique, &fresh);
            assert_int_equal(counter(renderer, "frames averaged"), k);
            check_at_most(largest_difference(&image, &fresh), 0, "%s, %d frames averaged", changes[i].name, k);
        }
        pel_renderer_destroy(other);
        pel_image_finish(&image);
        pel_image_finish(&fresh);
    }
    pel_renderer_destroy(renderer);
}

static void test_threads(void **state)
{
    struct view *v = *state;
    v->scene.render.refine = 3;
    for (int t = 0; techniques[t]; t++) {
        struct pel_image images[3];
        for (int threads = 1; threads <= 3; threads++) {
            struct pel_renderer *renderer = make_renderer(threads, (struct pel_progress){ 0 });
            make_image(&images[threads - 1], WIDTH, HEIGHT, true);
            do
                draw_next(renderer, &v->scene, techniques[t], &images[threads - 1]);
            while (!pel_renderer_finished(renderer));
            pel_renderer_destroy(renderer);
        }
        check_same_bytes(&images[0], &images[1], "1 thread against 2");
        check_same_bytes(&images[0], &images[2], "1 thread against 3");
        for (int i = 0; i < 3; i++)
            pel_image_finish(&images[i]);
    }
}

/* Where jitter moves nothing, three equal frames say so. */
static void test_still(void **state)
{
    struct view *v = *state;
    v->scene.render.refine = 200;
    for (int i = 0; i < 3; i++) {
        struct pel_renderer *renderer = make_renderer(2, (struct pel_progress){ 0 });
        struct pel_image image, half;
        v->scene.render.mode = i == 0 ? PEL_MODE_ISOSURFACE : i == 1 ? PEL_MODE_SLICE : PEL_MODE_COMPOSITE;
        v->scene.render.classification = i == 2 ? PEL_CLASSIFICATION_PREINTEGRATED : PEL_CLASSIFICATION_POST;
        make_image(&image, WIDTH, HEIGHT, false);
        int draws = 0;
        do {
            draw_next(renderer, &v->scene, "raycast", &image);
            draws++;
        } while (!pel_renderer_finished(renderer) && draws < 10);
        assert_int_equal(draws, 4);
        assert_int_equal(counter(renderer, "frames averaged"), 200);
        v->scene.render.step = 0.5;
        v->scene.render.refine = 0;
        draw(&v->scene, "raycast", WIDTH, HEIGHT, &half);
        check_at_most(largest_difference(&half, &image), 1e-6, "mode %d: against one frame at half a voxel", v->scene.render.mode);
        v->scene.render.step = 1.5;
        v->scene.render.refine = 200;
        draw_next(renderer, &v->scene, "raycast", &image);
        pel_image_finish(&image);
        pel_image_finish(&half);
        pel_renderer_destroy(renderer);
    }
}

static bool no_more(void *user, double fraction)
{
    (void)fraction;
    return !*(bool *)user;
}

/* A frame that was cancelled is drawn again, be it the first or a later one. */
static void test_cancelled(void **state)
{
    struct view *v = *state;
    bool stop = false;
    struct pel_renderer *renderer = make_renderer(1, (struct pel_progress){ no_more, &stop }),
                        *other = make_renderer(1, (struct pel_progress){ 0 });
    struct pel_image image, fresh;
    v->scene.render.refine = 3;
    make_image(&image, WIDTH, HEIGHT, true);
    make_image(&fresh, WIDTH, HEIGHT, true);
    for (int k = 0; k <= 3; k++) {
        struct pel_error error = PEL_ERROR_INIT;
        stop = true;
        assert_false(pel_renderer_draw(renderer, &v->scene, "raycast", &image, &error));
        assert_int_equal(error.code, PEL_ERROR_CANCELLED);
        assert_false(pel_renderer_finished(renderer));
        stop = false;
        draw_next(renderer, &v->scene, "raycast", &image);
        draw_next(other, &v->scene, "raycast", &fresh);
        check_same_bytes(&image, &fresh, "after a cancelled frame");
    }
    assert_true(pel_renderer_finished(renderer));
    pel_image_finish(&image);
    pel_image_finish(&fresh);
    pel_renderer_destroy(renderer);
    pel_renderer_destroy(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_nearer, make_view, finish_view),
        cmocka_unit_test_setup_teardown(test_steps, make_view, finish_view),
        cmocka_unit_test_setup_teardown(test_restart, make_view, finish_view),
        cmocka_unit_test_setup_teardown(test_threads, make_view, finish_view),
        cmocka_unit_test_setup_teardown(test_still, make_view, finish_view),
        cmocka_unit_test_setup_teardown(test_cancelled, make_view, finish_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
