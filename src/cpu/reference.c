/* SPDX-License-Identifier: MIT */
/* The double-precision reference: docs/optics.md word for word, so that a reader can hold the one against the other; paragraphs in
 * quotes are its. Every sample is taken, nothing is remembered, nothing is skipped: it is what the engines are measured against, and
 * its only virtue is that it is plain. Equation numbers are those of the dissertation (paper 002). */
#include "reference.h"

#include <math.h>
#include <string.h>

#include "fail.h"
#include "jitter.h"
#include "parallel.h"
#include "reference_parts.h"
#include "vec.h"

struct reference {
    const struct pel_scene *scene;
    struct pel_reference_signal signal;
    enum pel_classification classification;
    struct pel_reference_integral integral; /* preintegrated classification only */
    struct pel_image *image;
    double dt;       /* world length of a full segment */
    int jitter;
    int first_row;   /* of the band that is being drawn */
    double solid;    /* opacity from which on a composite has a depth */
};

/* "Ray": world and index space share the parameter t. */
struct ray {
    double origin[3], direction[3];             /* world; direction has unit length */
    double index_origin[3], index_direction[3];
    double a, b;                                /* the stretch to integrate; a < b */
    size_t segments;
    double fraction;                            /* of a segment at which its sample lies */
    uint64_t samples;                           /* taken so far */
};

struct segment {
    double t0, t1, t; /* ends, and the sample between them */
    double length;
};

/* What a ray comes to: premultiplied colour, alpha, depth. */
struct pixel {
    double rgb[3], alpha, depth;
};

/* Narrows the stretch to where p + t q >= 0. */
static void keep(struct ray *ray, double p, double q)
{
    if (q > 0)
        ray->a = fmax(ray->a, -p / q);
    else if (q < 0)
        ray->b = fmin(ray->b, -p / q);
    else if (p < 0)
        ray->b = -INFINITY;
}

/* "Ray": the stretch inside the volume's box, the clip box and all clip planes. */
static void clip(const struct reference *r, struct ray *ray)
{
    const struct pel_scene *scene = r->scene;
    ray->a = scene->camera.parallel ? -INFINITY : 0;
    ray->b = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        keep(ray, ray->index_origin[axis] - r->signal.lo[axis], ray->index_direction[axis]);
        keep(ray, r->signal.hi[axis] - ray->index_origin[axis], -ray->index_direction[axis]);
        if (scene->clip_box_enabled) {
            keep(ray, ray->origin[axis] - scene->clip_box[2 * axis], ray->direction[axis]);
            keep(ray, scene->clip_box[2 * axis + 1] - ray->origin[axis], -ray->direction[axis]);
        }
    }
    for (int i = 0; i < scene->clip_plane_count; i++) {
        double from[3];
        pel_sub(ray->origin, scene->clip_planes[i].origin, from);
        keep(ray, pel_dot(from, scene->clip_planes[i].normal), pel_dot(ray->direction, scene->clip_planes[i].normal));
    }
}

/* Makes the ray of a pixel; false where it misses. */
static bool make_ray(const struct reference *r, double x, double y, struct ray *ray)
{
    const struct pel_scene *scene = r->scene;
    double from[3];
    memset(ray, 0, sizeof *ray);
    pel_camera_ray(&scene->camera, r->image->width, r->image->height, x, y, ray->origin, ray->direction);
    pel_sub(ray->origin, scene->volume->origin, from);
    for (int axis = 0; axis < 3; axis++) {
        ray->index_origin[axis] = pel_dot(r->signal.to_index[axis], from);
        ray->index_direction[axis] = pel_dot(r->signal.to_index[axis], ray->direction);
    }
    clip(r, ray);
    if (!(ray->a < ray->b))
        return false;
    /* "Samples": a last segment shorter than a thousandth of dt belongs to the one before it. */
    double n = ceil((ray->b - ray->a) / r->dt - 0.001);
    ray->segments = n < 1 ? 1 : (size_t)n;
    ray->fraction = r->jitter ? (double)pel_jitter((int)x, (int)y, r->jitter - 1) : 0.5;
    return true;
}

static struct segment segment_at(const struct reference *r, const struct ray *ray, size_t i)
{
    struct segment s;
    s.t0 = ray->a + (double)i * r->dt;
    s.t1 = i + 1 == ray->segments ? ray->b : ray->a + (double)(i + 1) * r->dt;
    s.length = s.t1 - s.t0;
    s.t = s.t0 + ray->fraction * s.length;
    return s;
}

static void index_at(const struct ray *ray, double t, double index[3])
{
    for (int axis = 0; axis < 3; axis++)
        index[axis] = ray->index_origin[axis] + t * ray->index_direction[axis];
}

/* The value at t; false where void. */
static bool value_at(const struct reference *r, struct ray *ray, double t, double *value)
{
    double index[3];
    index_at(ray, t, index);
    ray->samples++;
    return pel_reference_value(&r->signal, index, value);
}

/* "Shading": Blinn-Phong, two-sided. */
static void shade(const struct reference *r, const struct ray *ray, double t, double rgb[3])
{
    const struct pel_render_settings *s = &r->scene->render;
    double index[3], normal[3], view[3], light[3] = { 0, 0, 0 }, highlight[3] = { 0, 0, 0 };
    index_at(ray, t, index);
    bool has_normal = pel_reference_normal(&r->signal, index, normal);
    for (int i = 0; i < 3; i++)
        view[i] = -ray->direction[i];
    if (has_normal && pel_dot(normal, view) < 0)
        for (int i = 0; i < 3; i++)
            normal[i] = -normal[i];
    for (int i = 0; i < r->scene->light_count; i++) {
        const struct pel_light *l = &r->scene->lights[i];
        double to_light[3], half[3], lambert = 1, gloss = 0;
        memcpy(to_light, l->headlight ? view : l->direction, sizeof to_light);
        pel_normalize(to_light);
        if (has_normal) {
            for (int j = 0; j < 3; j++)
                half[j] = to_light[j] + view[j];
            pel_normalize(half);
            lambert = fmax(pel_dot(normal, to_light), 0);
            gloss = pow(fmax(pel_dot(normal, half), 0), s->specular_power);
        }
        for (int c = 0; c < 3; c++) {
            light[c] += s->diffuse * lambert * l->color[c];
            highlight[c] += s->specular * gloss * l->color[c];
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = pel_clamp(rgb[c] * (s->ambient + light[c]) + highlight[c], 0, 1);
}

/* Puts a sample behind what the pixel already has (equation 1.8, front to back). */
static void put_behind(struct pixel *pixel, double alpha, const double rgb[3])
{
    for (int c = 0; c < 3; c++)
        pixel->rgb[c] += (1 - pixel->alpha) * alpha * rgb[c];
    pixel->alpha += (1 - pixel->alpha) * alpha;
}

/* "Classification" and "Opacity": alpha and colour of one segment; false where void. */
static bool classify(const struct reference *r, struct ray *ray, const struct segment *s, double *alpha, double rgb[3])
{
    double unit = r->scene->transfer.unit_distance, index[3], opacity, f, g, extinction;
    bool found;
    if (r->classification == PEL_CLASSIFICATION_PREINTEGRATED) {
        if (!value_at(r, ray, s->t0, &f) || !value_at(r, ray, s->t1, &g))
            return false;
        pel_reference_integrate(&r->integral, f, g, &extinction, rgb);
        *alpha = 1 - exp(-extinction * s->length);
        return true;
    }
    ray->samples++;
    index_at(ray, s->t, index);
    if (r->classification == PEL_CLASSIFICATION_PRE)
        found = pel_reference_classify_pre(&r->signal, index, &opacity, rgb);
    else
        found = pel_reference_classify_post(&r->signal, index, &opacity, rgb);
    if (found)
        *alpha = 1 - pow(1 - opacity, s->length / unit);
    return found;
}

static void draw_composite(const struct reference *r, struct ray *ray, struct pixel *pixel)
{
    if (r->classification == PEL_CLASSIFICATION_PREINTEGRATED)
        ray->fraction = 0.5; /* jitter does not apply */
    for (size_t i = 0; i < ray->segments; i++) {
        struct segment s = segment_at(r, ray, i);
        double alpha, rgb[3];
        if (!classify(r, ray, &s, &alpha, rgb) || !(alpha > 0))
            continue;
        if (r->scene->render.shade)
            shade(r, ray, s.t, rgb);
        put_behind(pixel, alpha, rgb);
        if (pixel->alpha >= r->solid && pixel->depth == INFINITY)
            pixel->depth = s.t;
    }
}

/* Mip, minip, average and each plane of slice show one value: its opacity as alpha, whatever the step. */
static void show_value(const struct reference *r, double value, struct pixel *pixel)
{
    double rgb[3];
    pel_reference_color(&r->scene->transfer, r->scene->linear_light, value, rgb);
    put_behind(pixel, pel_transfer_opacity(&r->scene->transfer, value), rgb);
}

static void draw_extreme(const struct reference *r, struct ray *ray, struct pixel *pixel)
{
    bool least = r->scene->render.mode == PEL_MODE_MINIP, any = false;
    double value, extreme = 0;
    for (size_t i = 0; i < ray->segments; i++) {
        struct segment s = segment_at(r, ray, i);
        if (!value_at(r, ray, s.t, &value) || (any && !(least ? value < extreme : value > extreme)))
            continue;
        any = true;
        extreme = value;
        pixel->depth = s.t;
    }
    if (any)
        show_value(r, extreme, pixel);
}

static void draw_average(const struct reference *r, struct ray *ray, struct pixel *pixel)
{
    double value, sum = 0, length = 0;
    for (size_t i = 0; i < ray->segments; i++) {
        struct segment s = segment_at(r, ray, i);
        if (!value_at(r, ray, s.t, &value))
            continue;
        sum += value * s.length;
        length += s.length;
    }
    if (length > 0)
        show_value(r, sum / length, pixel);
}

/* Equations 1.2 to 1.4: transparency is exp(-integral of tau). */
static void draw_xray(const struct reference *r, struct ray *ray, struct pixel *pixel)
{
    const struct pel_transfer *transfer = &r->scene->transfer;
    double value, thickness = 0;
    for (size_t i = 0; i < ray->segments; i++) {
        struct segment s = segment_at(r, ray, i);
        if (value_at(r, ray, s.t, &value))
            thickness += pel_reference_extinction(pel_transfer_opacity(transfer, value), transfer->unit_distance) * s.length;
    }
    double shown = r->scene->render.invert ? 1 : 0, rgb[3] = { shown, shown, shown };
    put_behind(pixel, 1 - exp(-thickness), rgb);
}

/* Finds where the signal passes the isovalue between t0 and t1, by halving; false where a void is met on the way. */
static bool find_root(const struct reference *r, struct ray *ray, double t0, double t1, bool below, double isovalue, double *root)
{
    double lo = t0, hi = t1, value;
    for (int i = 0; i < 42; i++) { /* 2^-42 of the segment */
        double middle = lo + 0.5 * (hi - lo);
        if (!value_at(r, ray, middle, &value))
            return false;
        if ((value < isovalue) == below)
            lo = middle;
        else
            hi = middle;
    }
    *root = lo + 0.5 * (hi - lo);
    return true;
}

/* The crossings of one segment, f and g being the values at its ends, in the order of the ray. */
static void draw_crossings(const struct reference *r, struct ray *ray, const struct segment *s, double f, double g, struct pixel *pixel)
{
    struct {
        double t;
        const struct pel_isosurface *surface;
    } crossings[PEL_MAX_ISOSURFACES];
    int count = 0;
    for (int i = 0; i < r->scene->isosurface_count; i++) {
        const struct pel_isosurface *surface = &r->scene->isosurfaces[i];
        double t;
        if ((f < surface->value) == (g < surface->value) || !find_root(r, ray, s->t0, s->t1, f < surface->value, surface->value, &t))
            continue;
        int at = count++;
        for (; at > 0 && crossings[at - 1].t > t; at--)
            crossings[at] = crossings[at - 1];
        crossings[at].t = t;
        crossings[at].surface = surface;
    }
    for (int i = 0; i < count; i++) {
        double rgb[3];
        for (int c = 0; c < 3; c++) {
            double display = crossings[i].surface->color[c];
            rgb[c] = r->scene->linear_light ? pel_reference_decode(display) : display;
        }
        shade(r, ray, crossings[i].t, rgb);
        put_behind(pixel, crossings[i].surface->opacity, rgb);
        pixel->depth = fmin(pixel->depth, crossings[i].t);
    }
}

static void draw_isosurfaces(const struct reference *r, struct ray *ray, struct pixel *pixel)
{
    double f, g;
    bool has_f = value_at(r, ray, ray->a, &f);
    for (size_t i = 0; i < ray->segments; i++) {
        struct segment s = segment_at(r, ray, i);
        bool has_g = value_at(r, ray, s.t1, &g);
        if (has_f && has_g)
            draw_crossings(r, ray, &s, f, g, pixel);
        f = g;
        has_f = has_g;
    }
}

/* Where the ray meets the planes inside its stretch, in their order along it; gives their number. */
static int meet_planes(const struct reference *r, const struct ray *ray, double places[PEL_MAX_SLICES])
{
    int count = 0;
    for (int i = 0; i <= r->scene->more_slice_count; i++) {
        const struct pel_plane *plane = i ? &r->scene->more_slices[i - 1] : &r->scene->slice;
        double to_plane[3];
        pel_sub(plane->origin, ray->origin, to_plane);
        double t = pel_dot(to_plane, plane->normal) / pel_dot(ray->direction, plane->normal);
        if (!(t >= ray->a && t <= ray->b)) /* not finite where the ray runs along the plane */
            continue;
        int at = count++;
        for (; at > 0 && places[at - 1] > t; at--)
            places[at] = places[at - 1];
        places[at] = t;
    }
    return count;
}

static void draw_slices(const struct reference *r, struct ray *ray, struct pixel *pixel)
{
    double places[PEL_MAX_SLICES], value;
    int count = meet_planes(r, ray, places);
    for (int i = 0; i < count; i++) {
        if (!value_at(r, ray, places[i], &value))
            continue;
        show_value(r, value, pixel);
        if (pixel->alpha > 0)
            pixel->depth = fmin(pixel->depth, places[i]);
    }
}

/* "Modes", "Light", and of "Depth" that where nothing is seen there is none. */
static void draw_pixel(const struct reference *r, double x, double y, struct pixel *pixel, uint64_t *samples)
{
    struct ray ray;
    *pixel = (struct pixel){ .depth = INFINITY };
    if (!make_ray(r, x, y, &ray))
        return;
    switch (r->scene->render.mode) {
    case PEL_MODE_COMPOSITE: draw_composite(r, &ray, pixel); break;
    case PEL_MODE_MIP:
    case PEL_MODE_MINIP: draw_extreme(r, &ray, pixel); break;
    case PEL_MODE_AVERAGE: draw_average(r, &ray, pixel); break;
    case PEL_MODE_XRAY: draw_xray(r, &ray, pixel); break;
    case PEL_MODE_ISOSURFACE: draw_isosurfaces(r, &ray, pixel); break;
    case PEL_MODE_SLICE: draw_slices(r, &ray, pixel); break;
    }
    if (!(pixel->alpha > 0))
        pixel->depth = INFINITY;
    if (r->scene->linear_light && pixel->alpha > 0)
        for (int c = 0; c < 3; c++)
            pixel->rgb[c] = pel_reference_encode(pixel->rgb[c] / pixel->alpha) * pixel->alpha;
    *samples += ray.samples;
}

enum { BAND = 32 }; /* rows drawn between two reports of progress */

struct band {
    const struct reference *r;
    uint64_t samples[BAND]; /* of each row, so that no two threads share a sum */
};

static void draw_row(void *context, size_t item, int thread)
{
    struct band *band = context;
    struct pel_image *image = band->r->image;
    int y = band->r->first_row + (int)item;
    (void)thread;
    for (int x = 0; x < image->width; x++) {
        size_t at = (size_t)y * (size_t)image->width + (size_t)x;
        struct pixel pixel;
        draw_pixel(band->r, x, y, &pixel, &band->samples[item]);
        for (int c = 0; c < 3; c++)
            image->rgba[4 * at + (size_t)c] = (float)pixel.rgb[c];
        image->rgba[4 * at + 3] = (float)pixel.alpha;
        if (image->depth)
            image->depth[at] = (float)pixel.depth;
    }
}

/* What all rays share; to be finished with pel_reference_integral_finish in either case. */
static bool begin(struct reference *r, const struct pel_scene *scene, struct pel_image *image, struct pel_error *error)
{
    *r = (struct reference){ .scene = scene, .image = image, .classification = scene->render.classification, .solid = 0.5 };
    pel_reference_signal_init(&r->signal, scene);
    r->dt = scene->render.step * pel_volume_least_spacing(scene->volume);
    if (r->signal.nearest && r->classification == PEL_CLASSIFICATION_PREINTEGRATED)
        r->classification = PEL_CLASSIFICATION_POST; /* nothing lies between the values of two voxels */
    return r->classification != PEL_CLASSIFICATION_PREINTEGRATED ||
           pel_reference_integral_init(&r->integral, &scene->transfer, scene->linear_light, error);
}

bool pel_reference_draw(const struct pel_scene *scene, int jitter, int threads, const struct pel_progress *progress,
                        struct pel_image *image, uint64_t *samples, struct pel_error *error)
{
    struct reference r;
    uint64_t total = 0;
    bool done = false;
    if (!begin(&r, scene, image, error))
        goto cleanup;
    r.jitter = jitter;
    for (int y = 0; y < image->height; y += BAND) {
        struct band band = { .r = &r };
        int rows = image->height - y < BAND ? image->height - y : BAND;
        r.first_row = y;
        if (!pel_progress_report(progress, (double)y / image->height, error))
            goto cleanup;
        pel_parallel_for(threads, (size_t)rows, draw_row, &band);
        for (int i = 0; i < rows; i++)
            total += band.samples[i];
    }
    if (samples)
        *samples = total;
    done = true;
cleanup:
    pel_reference_integral_finish(&r.integral);
    return done;
}

bool pel_reference_pick(const struct pel_scene *scene, int width, int height, double x, double y, double opacity, struct pel_reference_pick *pick,
                        struct pel_error *error)
{
    struct pel_image size = { .width = width, .height = height };
    struct reference r;
    struct pixel pixel;
    struct ray ray;
    uint64_t samples = 0;
    *pick = (struct pel_reference_pick){ .distance = INFINITY };
    bool ok = begin(&r, scene, &size, error);
    if (ok && (pick->inside = make_ray(&r, x, y, &ray))) {
        r.solid = opacity;
        draw_pixel(&r, x, y, &pixel, &samples);
        pick->distance = pixel.depth;
        for (int i = 0; i < 3; i++)
            pick->world[i] = ray.origin[i] + pixel.depth * ray.direction[i];
        index_at(&ray, pixel.depth, pick->index);
        pick->valued = isfinite(pixel.depth) && pel_reference_value(&r.signal, pick->index, &pick->value);
    }
    pel_reference_integral_finish(&r.integral);
    return ok;
}
