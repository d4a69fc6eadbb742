/* SPDX-License-Identifier: MIT */
/* Three slices square to the volume's own axes, each a scene of its own: mode slice, a parallel camera that looks at the plane face on. A
 * renderer of their own draws them, so that the main picture's keeps what it prepared. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "session_inside.h"

enum { MOST_SIDE = 4096, MOST_PIXELS = 1 << 22 };

struct slices_drawer {
    struct pel_renderer *renderer;
    struct pel_image image;
    struct pel_scene scene;
    uint64_t volume; /* number of the one that was drawn */
};

void session_slices_leave(struct session *s)
{
    bool asked = false;
    for (int i = 0; i < SESSION_MOST_CLIENTS; i++)
        asked |= s->clients[i].number && s->clients[i].slices;
    s->slices.on &= asked;
}

bool session_slices_due(const struct session *s)
{
    return s->slices.on && (s->slices_shown != s->slices_revision || (s->slices_moving && !session_held(s)));
}

/* A part of each slice that is seen, or null for the whole. */
static bool read_views(struct call *call, struct session_slices *slices)
{
    const json_t *list = json_object_get(call->json, "views");
    if (!call_has(call, "views"))
        return true;
    if (!json_is_array(list) || json_array_size(list) != 3)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "views: it must be a list of three, each null or with center and scale");
    for (size_t i = 0; i < 3; i++) {
        struct call part = *call;
        part.json = json_array_get(list, i);
        if (json_is_null(part.json))
            continue;
        if (!json_is_object(part.json) || json_object_size(part.json) != 2)
            return session_fail(call->error, PEL_ERROR_ARGUMENT, "views: entry %zu must be null or have center and scale", i + 1);
        if (!call_numbers(&part, "center", 3, slices->views[i].center) ||
            !call_number(&part, "scale", 1e-100, 1e100, &slices->views[i].scale))
            return false;
        slices->views[i].on = true;
    }
    return true;
}

bool run_slices(struct call *call)
{
    struct session *s = call->session;
    struct session_slices slices = { .on = call_has(call, "at"), .size = { 256, 256 } };
    if (slices.on) {
        if (s->slices.on)
            memcpy(slices.size, s->slices.size, sizeof slices.size);
        if (!call_numbers(call, "at", 3, slices.at) ||
            (call_has(call, "size") && !call_size(call, "size", MOST_SIDE, MOST_PIXELS, slices.size)))
            return false;
        slices.windowed = call_has(call, "window");
        if (slices.windowed && !call_numbers(call, "window", 2, slices.window))
            return false;
        if (slices.windowed && !(slices.window[0] < slices.window[1]))
            return session_fail(call->error, PEL_ERROR_ARGUMENT, "window: it goes from %g to %g; give the lower end first",
                                slices.window[0], slices.window[1]);
        if (!read_views(call, &slices))
            return false;
    }
    call->client->slices = slices.on;
    if (!slices.on) {
        session_slices_leave(s);
        return true;
    }
    s->slices = slices;
    s->slices_revision++;
    session_interrupt(s); /* a large picture may be under way */
    return true;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Which way up a slice between the axes p and q (p before q) is shown, as directions of the world. Where the world is a patient, as
 * radiology shows it: the head or, of axial slices, the front is up; the patient's left, or of sagittal slices the back, is at the right.
 * Else q is up, p to the right. */
static void orient(const struct pel_volume *volume, int p, int q, double right[3], double up[3])
{
    const double(*d)[3] = volume->direction;
    double normal[3], left[3] = { volume->space == PEL_SPACE_RAS ? -1 : 1, 0, 0 }, back[3] = { 0, left[0], 0 }, head[3] = { 0, 0, 1 };
    memcpy(right, d[p], 3 * sizeof *right);
    memcpy(up, d[q], 3 * sizeof *up);
    if (volume->space == PEL_SPACE_UNKNOWN)
        return;
    cross(d[p], d[q], normal);
    bool axial = fabs(normal[2]) >= fabs(normal[0]) && fabs(normal[2]) >= fabs(normal[1]);
    bool sagittal = !axial && fabs(normal[0]) >= fabs(normal[1]);
    const double *upwards = axial ? back : head, *rightwards = sagittal ? back : left;
    bool swap = fabs(dot(d[p], upwards)) > fabs(dot(d[q], upwards));
    double up_sign = dot(d[swap ? p : q], upwards) * (axial ? -1 : 1), right_sign = dot(d[swap ? q : p], rightwards);
    for (int i = 0; i < 3; i++) {
        up[i] = (up_sign < 0 ? -1 : 1) * d[swap ? p : q][i];
        right[i] = (right_sign < 0 ? -1 : 1) * d[swap ? q : p][i];
    }
}

/* The plane through `at` across an axis, and a camera that sees all of it, or the part that was asked for. */
static void look_at(struct pel_scene *scene, int axis, const struct session_slices *asked)
{
    const struct pel_volume *volume = scene->volume;
    struct pel_camera *camera = &scene->camera;
    int p = axis == 0, q = axis == 2 ? 1 : 2;
    double right[3], up[3], forward[3], index[3], middle[3], center[3], half[2] = { 0, 0 }, far = 1;
    bool part = asked->views[axis].on;
    orient(volume, p, q, right, up);
    cross(up, right, forward);
    double length = sqrt(dot(forward, forward)), last[3];
    pel_volume_world_to_index(volume, asked->at, index);
    pel_volume_world_to_index(volume, asked->views[axis].center, center);
    for (int a = 0; a < 3; a++) {
        forward[a] /= length;
        last[a] = (double)(volume->dims[a] - 1);
        middle[a] = a == axis ? fmin(fmax(index[a], 0), last[a]) : part ? fmin(fmax(center[a], 0), last[a]) : last[a] / 2;
        far += (last[a] + 1) * volume->spacing[a];
    }
    pel_volume_index_to_world(volume, middle, camera->focal_point);
    for (int a = 0; a < 3; a++)
        camera->position[a] = camera->focal_point[a] - far * forward[a];
    memcpy(camera->view_up, up, sizeof camera->view_up);
    double basis[2][3];
    pel_camera_basis(camera, basis[0], basis[1], forward);
    for (int k = 0; k < 2; k++)
        for (int a = 0; a < 3; a++)
            half[k] += a == axis ? 0 : 0.5 * fmax(last[a], 1) * volume->spacing[a] * fabs(dot(volume->direction[a], basis[k]));
    camera->parallel = true;
    camera->parallel_scale = 1.02 * fmax(half[1], half[0] * asked->size[1] / asked->size[0]);
    if (part) /* not so near that places are no more told apart */
        camera->parallel_scale = fmin(fmax(asked->views[axis].scale, 1e-4 * camera->parallel_scale), 4 * camera->parallel_scale);
    memcpy(scene->slice.origin, camera->focal_point, sizeof scene->slice.origin);
    memcpy(scene->slice.normal, forward, sizeof scene->slice.normal);
}

static bool prepare(struct slices_drawer *d, const struct session_slices *asked, const struct frame_facts *facts, struct pel_error *error)
{
    const struct pel_scene *from = facts->scene;
    struct pel_transfer transfer = d->scene.transfer;
    const struct pel_color_point gray[] = { { asked->window[0], { 0, 0, 0 } }, { asked->window[1], { 1, 1, 1 } } };
    const struct pel_opacity_point opaque = { 0, 1 };
    if (d->volume != facts->volume)
        pel_renderer_invalidate(d->renderer);
    d->volume = facts->volume;
    bool fine = pel_transfer_copy(&transfer, &from->transfer, error) && pel_transfer_set_opacities(&transfer, &opaque, 1, error) &&
                (!asked->windowed || pel_transfer_set_colors(&transfer, gray, 2, error));
    memcpy(&d->scene, from, sizeof d->scene);
    d->scene.transfer = transfer;
    d->scene.render.mode = PEL_MODE_SLICE;
    d->scene.render.refine = 0;
    d->scene.more_slice_count = d->scene.clip_plane_count = 0;
    d->scene.clip_box_enabled = false;
    return fine;
}

/* They are drawn to their end, or none would be seen while a hand goes through the volume; but not beyond the session's. */
static bool go_on(void *user, double fraction)
{
    const struct session *s = user;
    (void)fraction;
    return atomic_load(&s->abort) != SESSION_ENDS;
}

static struct slices_drawer *create(struct session *s, struct pel_error *error)
{
    const struct pel_renderer_params params = { .threads = s->params.threads, .progress = { go_on, s } };
    struct slices_drawer *d = calloc(1, sizeof *d);
    if (!d) {
        session_fail(error, PEL_ERROR_MEMORY, "no memory to draw slices");
        return NULL;
    }
    pel_image_init(&d->image);
    d->renderer = pel_renderer_create(&params, error);
    if (d->renderer && pel_scene_init(&d->scene, error))
        return d;
    session_slices_finish(d);
    return NULL;
}

void session_slices_draw(struct session *s, struct slices_drawer **drawer, struct encoder *encoder, const struct session_slices *asked,
                         const struct frame_facts *facts)
{
    static const char *const views[] = { "slice-i", "slice-j", "slice-k" };
    struct pel_error error = PEL_ERROR_INIT;
    if (!*drawer)
        *drawer = create(s, &error);
    struct slices_drawer *d = *drawer;
    bool fine = d && prepare(d, asked, facts, &error) && pel_image_allocate(&d->image, asked->size[0], asked->size[1], false, &error);
    for (int axis = 0; fine && axis < 3; axis++) {
        struct frame_facts f = *facts;
        double start = session_now();
        look_at(&d->scene, axis, asked);
        fine = pel_renderer_draw(d->renderer, &d->scene, NULL, &d->image, &error);
        if (!fine)
            break;
        f.view = views[axis];
        f.of[0] = asked->size[0];
        f.of[1] = asked->size[1];
        f.scene = &d->scene;
        f.stats = pel_renderer_stats(d->renderer);
        f.draw_ms = session_now() - start;
        fine = session_send_frame(s, encoder, &d->image, &f, &(struct pel_progress) { go_on, s }, &error);
    }
    if (fine || error.code == PEL_ERROR_CANCELLED)
        return;
    pthread_mutex_lock(&s->lock);
    session_tell_error(s, 0, &error, NULL);
    pthread_mutex_unlock(&s->lock);
}

void session_slices_finish(struct slices_drawer *d)
{
    if (!d)
        return;
    pel_renderer_destroy(d->renderer);
    pel_image_finish(&d->image);
    pel_scene_finish(&d->scene);
    free(d);
}
