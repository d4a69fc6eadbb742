/* SPDX-License-Identifier: MIT */
#include "pictures.h"

const char *const techniques[] = { "reference", "raycast", NULL };

void check_at_most(double measured, double allowed, const char *format, ...)
{
    char what[256];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    if (!(measured <= allowed))
        fail_msg("%s: measured %.9g, at most %.9g allowed", what, measured, allowed);
}

void check_at_least(double measured, double wanted, const char *format, ...)
{
    char what[256];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    if (!(measured >= wanted))
        fail_msg("%s: measured %.9g, at least %.9g wanted", what, measured, wanted);
}

static void put(struct pel_volume *volume, size_t i, double value)
{
    switch (volume->type) {
    case PEL_U8: ((uint8_t *)volume->data)[i] = (uint8_t)value; break;
    case PEL_I8: ((int8_t *)volume->data)[i] = (int8_t)value; break;
    case PEL_U16: ((uint16_t *)volume->data)[i] = (uint16_t)value; break;
    case PEL_I16: ((int16_t *)volume->data)[i] = (int16_t)value; break;
    case PEL_U32: ((uint32_t *)volume->data)[i] = (uint32_t)value; break;
    case PEL_I32: ((int32_t *)volume->data)[i] = (int32_t)value; break;
    case PEL_F32: ((float *)volume->data)[i] = (float)value; break;
    default: ((double *)volume->data)[i] = value; break;
    }
}

void fill_volume(struct pel_volume *volume, formula *f)
{
    size_t i = 0;
    for (size_t z = 0; z < volume->dims[2]; z++)
        for (size_t y = 0; y < volume->dims[1]; y++)
            for (size_t x = 0; x < volume->dims[0]; x++)
                put(volume, i++, f((const double[3]){ (double)x, (double)y, (double)z }));
    pel_volume_update_range(volume);
}

void make_volume(struct pel_volume *volume, size_t nx, size_t ny, size_t nz, enum pel_type type, formula *f)
{
    struct pel_error error = PEL_ERROR_INIT;
    pel_volume_init(volume);
    if (!pel_volume_allocate(volume, (const size_t[3]){ nx, ny, nz }, type, 1, &error))
        fail_msg("%s", error.message);
    fill_volume(volume, f);
}

double constant_one(const double index[3])
{
    (void)index;
    return 1;
}

void make_scene(struct pel_scene *scene, const struct pel_volume *volume, const char *opacity)
{
    struct pel_error error = PEL_ERROR_INIT;
    assert_true(pel_scene_init(scene, &error));
    scene->volume = volume;
    pel_camera_fit(&scene->camera, volume, 64, 64);
    if (opacity && !pel_transfer_parse_opacity(&scene->transfer, opacity, &error))
        fail_msg("%s", error.message);
    scene->transfer.unit_distance = pel_volume_mean_spacing(volume);
    scene->render.shade = false;
    scene->render.step = 0.5;
    scene->render.termination = 1;
}

void set_flat_color(struct pel_scene *scene, double r, double g, double b)
{
    const struct pel_color_point point = { 0, { r, g, b } };
    assert_true(pel_transfer_set_colors(&scene->transfer, &point, 1, NULL));
}

void look_parallel(struct pel_scene *scene, const double forward[3], double distance, double scale)
{
    const struct pel_volume *volume = scene->volume;
    double middle[3], center[3], length = sqrt(dot3(forward, forward));
    for (int i = 0; i < 3; i++)
        middle[i] = (double)(volume->dims[i] - 1) / 2;
    pel_volume_index_to_world(volume, middle, center);
    for (int i = 0; i < 3; i++) {
        scene->camera.focal_point[i] = center[i];
        scene->camera.position[i] = center[i] - forward[i] / length * distance;
    }
    bool along_y = fabs(forward[0]) < 1e-9 && fabs(forward[2]) < 1e-9;
    memcpy(scene->camera.view_up, along_y ? (double[3]){ 0, 0, 1 } : (double[3]){ 0, 1, 0 }, sizeof scene->camera.view_up);
    scene->camera.parallel = true;
    scene->camera.parallel_scale = scale;
}

void draw_with(const struct pel_scene *scene, const char *technique, int threads, int width, int height, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    params.threads = threads;
    pel_image_init(image);
    if (!pel_image_allocate(image, width, height, true, &error))
        fail_msg("%s", error.message);
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    if (!renderer)
        fail_msg("%s", error.message);
    if (!pel_renderer_draw(renderer, scene, technique, image, &error))
        fail_msg("%s: %s", technique, error.message);
    pel_renderer_destroy(renderer);
}

void draw(const struct pel_scene *scene, const char *technique, int width, int height, struct pel_image *image)
{
    draw_with(scene, technique, 2, width, height, image);
}

int available_isas(const char *names[3])
{
    int count = 0;
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt"))
        names[count++] = "x86-64-v2";
#if !defined(ONE_ISA)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
        names[count++] = "x86-64-v3";
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512cd"))
        names[count++] = "x86-64-v4";
#endif
#else
    (void)names;
#endif
    return count;
}

void draw_isa(const struct pel_scene *scene, const char *isa, int width, int height, struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_renderer_params params = PEL_RENDERER_PARAMS_INIT;
    char old[64] = "";
    if (getenv("PELLUCID_ISA"))
        snprintf(old, sizeof old, "%s", getenv("PELLUCID_ISA"));
    params.threads = 2;
    setenv("PELLUCID_ISA", isa, 1);
    struct pel_renderer *renderer = pel_renderer_create(&params, &error);
    if (!renderer)
        fail_msg("%s: %s", isa, error.message);
    pel_image_init(image);
    if (!pel_image_allocate(image, width, height, true, &error) || !pel_renderer_draw(renderer, scene, "raycast", image, &error))
        fail_msg("%s: %s", isa, error.message);
    assert_string_equal(pel_renderer_stats(renderer)->isa, isa);
    pel_renderer_destroy(renderer);
    if (*old)
        setenv("PELLUCID_ISA", old, 1);
    else
        unsetenv("PELLUCID_ISA");
}

double largest_difference(const struct pel_image *a, const struct pel_image *b)
{
    double largest = 0;
    assert_true(a->width == b->width && a->height == b->height);
    for (size_t i = 0; i < 4 * (size_t)a->width * (size_t)a->height; i++) {
        double difference = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        if (!(difference <= largest))
            largest = isnan(difference) ? INFINITY : difference;
    }
    return largest;
}

double largest_depth_difference(const struct pel_image *a, const struct pel_image *b)
{
    double largest = 0;
    for (size_t i = 0; i < (size_t)a->width * (size_t)a->height; i++) {
        if (isinf(a->depth[i]) && isinf(b->depth[i]))
            continue;
        double difference = fabs((double)a->depth[i] - (double)b->depth[i]);
        if (!(difference <= largest))
            largest = isnan(difference) ? INFINITY : difference;
    }
    return largest;
}

double psnr(const struct pel_image *a, const struct pel_image *b)
{
    struct pel_metrics metrics;
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_image_compare(a, b, &metrics, &error))
        fail_msg("%s", error.message);
    return metrics.psnr;
}

void check_same_bytes(const struct pel_image *a, const struct pel_image *b, const char *what)
{
    size_t pixels = (size_t)a->width * (size_t)a->height, differing = 0, first = 0;
    assert_true(a->width == b->width && a->height == b->height);
    for (size_t i = pixels; i-- > 0;)
        if (memcmp(a->rgba + 4 * i, b->rgba + 4 * i, 4 * sizeof(float)) || memcmp(a->depth + i, b->depth + i, sizeof(float))) {
            differing++;
            first = i;
        }
    if (differing)
        fail_msg("%s: %zu of %zu pixels differ, the first at (%zu, %zu): "
                 "%.9g %.9g %.9g %.9g depth %.9g against %.9g %.9g %.9g %.9g depth %.9g",
                 what, differing, pixels, first % (size_t)a->width, first / (size_t)a->width, (double)a->rgba[4 * first],
                 (double)a->rgba[4 * first + 1], (double)a->rgba[4 * first + 2], (double)a->rgba[4 * first + 3], (double)a->depth[first],
                 (double)b->rgba[4 * first], (double)b->rgba[4 * first + 1], (double)b->rgba[4 * first + 2],
                 (double)b->rgba[4 * first + 3], (double)b->depth[first]);
}

/* Keeps the part of [t[0], t[1]] where (origin + t direction - point) . normal >= 0. */
static void cut(const double origin[3], const double direction[3], const double point[3], const double normal[3], double t[2])
{
    double from[3] = { origin[0] - point[0], origin[1] - point[1], origin[2] - point[2] };
    double height = dot3(from, normal), slope = dot3(direction, normal);
    if (slope > 0 && -height / slope > t[0])
        t[0] = -height / slope;
    if (slope < 0 && -height / slope < t[1])
        t[1] = -height / slope;
    if (slope == 0 && height < 0)
        t[1] = -INFINITY;
}

bool ray_stretch(const struct pel_scene *scene, int width, int height, int x, int y, double origin[3], double direction[3], double t[2])
{
    const struct pel_volume *volume = scene->volume;
    pel_camera_ray(&scene->camera, width, height, x, y, origin, direction);
    t[0] = scene->camera.parallel ? -1e30 : 0;
    t[1] = 1e30;
    for (int axis = 0; axis < 3; axis++) {
        /* The faces across an axis are spanned by the two others, whatever the angles between them. */
        const double *u = volume->direction[(axis + 1) % 3], *v = volume->direction[(axis + 2) % 3];
        double normal[3] = { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
        double sign = dot3(normal, volume->direction[axis]) > 0 ? 1 : -1;
        double last = (double)(volume->dims[axis] - 1), index[2][3] = { { 0, 0, 0 }, { 0, 0, 0 } };
        index[0][axis] = last > 0 ? 0 : -0.5;
        index[1][axis] = last > 0 ? last : 0.5;
        for (int side = 0; side < 2; side++) {
            double point[3], inward[3];
            pel_volume_index_to_world(volume, index[side], point);
            for (int i = 0; i < 3; i++)
                inward[i] = side ? -sign * normal[i] : sign * normal[i];
            cut(origin, direction, point, inward, t);
        }
        if (scene->clip_box_enabled)
            for (int side = 0; side < 2; side++) {
                double point[3] = { 0, 0, 0 }, inward[3] = { 0, 0, 0 };
                point[axis] = scene->clip_box[2 * axis + side];
                inward[axis] = side ? -1 : 1;
                cut(origin, direction, point, inward, t);
            }
    }
    for (int i = 0; i < scene->clip_plane_count; i++)
        cut(origin, direction, scene->clip_planes[i].origin, scene->clip_planes[i].normal, t);
    return t[0] < t[1];
}

double reconstruct(const struct pel_volume *volume, const double world[3])
{
    double index[3], sum = 0;
    pel_volume_world_to_index(volume, world, index);
    for (int k = 0; k < 2; k++)
        for (int j = 0; j < 2; j++)
            for (int i = 0; i < 2; i++) {
                const int step[3] = { i, j, k };
                double weight = 1;
                size_t at[3];
                for (int axis = 0; axis < 3; axis++) {
                    double last = (double)(volume->dims[axis] - 1), p = fmin(fmax(index[axis], 0), last), base = floor(p);
                    weight *= step[axis] ? p - base : 1 - (p - base);
                    at[axis] = (size_t)fmin(base + step[axis], last);
                }
                sum += weight * pel_volume_get(volume, at[0], at[1], at[2], 0);
            }
    return sum;
}

void draw_by(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, int width, int height, bool depth,
             struct pel_image *image)
{
    struct pel_error error = PEL_ERROR_INIT;
    pel_image_init(image);
    if (!pel_image_allocate(image, width, height, depth, &error) || !pel_renderer_draw(renderer, scene, technique, image, &error))
        fail_msg("%s: %s", technique, error.message);
}

void set_option_of(struct pel_renderer *renderer, const char *technique, const char *name, const char *value)
{
    struct pel_error error = PEL_ERROR_INIT;
    const struct pel_option *row = pel_option_find(pel_technique_find(technique)->options, name);
    assert_non_null(row);
    if (!pel_option_set(row, pel_renderer_options(renderer, technique), value, &error))
        fail_msg("%s", error.message);
}

void expect_refusal_by(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, const char *word)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_image image;
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 16, 16, false, &error));
    assert_false(pel_renderer_draw(renderer, scene, technique, &image, &error));
    if (!strstr(error.message, word))
        fail_msg("'%s' does not say '%s'", error.message, word);
    pel_image_finish(&image);
}

uint64_t frame_counter(const struct pel_renderer *renderer, const char *name)
{
    const struct pel_frame_stats *stats = pel_renderer_stats(renderer);
    for (int i = 0; i < stats->counter_count; i++)
        if (!strcmp(stats->counters[i].name, name))
            return stats->counters[i].value;
    fail_msg("there is no counter %s", name);
    return 0;
}

bool read_real(struct pel_volume *volume, const char *name)
{
    const char *folder = getenv("PELLUCID_TEST_DATA");
    struct pel_error error = PEL_ERROR_INIT;
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder ? folder : "", name);
    FILE *there = folder ? fopen(path, "rb") : NULL;
    if (!there) {
        print_message("SKIPPED: no real data: set PELLUCID_TEST_DATA to a folder with %s\n", name);
        return false;
    }
    fclose(there);
    const struct pel_read_params params = PEL_READ_PARAMS_INIT;
    pel_volume_init(volume);
    if (!pel_read_volume(path, &params, volume, NULL, &error))
        fail_msg("%s", error.message);
    return true;
}
