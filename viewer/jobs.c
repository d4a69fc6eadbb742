/* SPDX-License-Identifier: MIT */
/* Pictures and movies to be saved: drawn frame by frame by the thread that draws, when it has nothing more urgent, of the scene as it was
 * when they were asked for. A command stops the frame under way, which is drawn again later. A thread of its own packs each frame that is
 * drawn. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "movie.h"
#include "session_inside.h"

enum { MOST_JOBS = 16, MOST_MOVIE_PIXELS = 1 << 23 };
/* Less than a gigabyte of memory for a WebP, which is kept there until it is whole. */
#define MOST_MOVIE_PIXELS_IN_ALL 0x1p32
/* Pictures up to so many pixels are packed as small as can be; larger ones would be waited for too long. */
#define SMALL_PIXELS (1 << 22)
/* Between two reports of how far a job is. */
#define TOLD_MS 100.0

struct session_job {
    struct session_job *next;
    struct session *session;
    int client;
    bool has_id;
    int64_t id;
    const char *what;        /* "picture", "movie" */
    bool cancelled, packing; /* under the lock; packing: a thread has it, and nobody else touches it */
    bool background;
    int size[2], frames, done, draws;
    double degrees, told_ms; /* when its progress was told last */
    struct pel_scene scene;  /* its transfer function is a copy of its own */
    struct session_volume *volume;
    struct pel_image image;
    struct encoder *encoder;
    const struct movie_format *format; /* NULL: a picture */
    struct movie *movie;               /* from its first frame on */
};

/* With the lock held. */
static void job_free(struct session_job *job)
{
    pel_transfer_finish(&job->scene.transfer);
    pel_image_finish(&job->image);
    encoder_destroy(job->encoder);
    movie_destroy(job->movie);
    session_volume_release(job->volume);
    free(job);
}

void session_jobs_finish(struct session *s)
{
    while (s->jobs) {
        struct session_job *job = s->jobs;
        s->jobs = job->next;
        job_free(job);
    }
}

static bool add(struct call *call, struct session_job *job)
{
    struct session *s = call->session;
    struct session_job **last = &s->jobs;
    int count = 0;
    for (; *last; last = &(*last)->next)
        count++;
    job->session = s;
    job->client = call->client->number;
    job->has_id = call->has_id;
    job->id = call->id;
    job->volume = s->volume;
    s->volume->users++;
    pel_image_init(&job->image);
    bool fine = session_copy_scene(s, &job->scene, call->error) && (job->encoder = encoder_create(call->error));
    if (fine && count >= MOST_JOBS)
        fine = session_fail(call->error, PEL_ERROR_ARGUMENT, "%d pictures are waiting to be drawn; wait, or cancel them", count);
    if (!fine) {
        job_free(job);
        return false;
    }
    *last = job;
    session_tell_progress(s, job->client, job->what, 0);
    return true;
}

bool session_check_memory(const int size[2], struct pel_error *error)
{
    double bytes = (double)size[0] * size[1] * (2 * 4 * sizeof(float) + 8),
           memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    return bytes <= 0.5 * memory ||
           session_fail(error, PEL_ERROR_MEMORY, "size: a picture of %dx%d needs %.1f GB; this machine has %.1f GB", size[0], size[1],
                        bytes / 1e9, memory / 1e9);
}

static struct session_job *job_new(struct call *call, const char *what, const int size[2], bool background)
{
    struct session_job *job = session_check_memory(size, call->error) ? calloc(1, sizeof *job) : NULL;
    if (job)
        *job = (struct session_job) { .what = what, .size = { size[0], size[1] }, .background = background, .frames = 1 };
    else if (!call->error->code)
        session_fail(call->error, PEL_ERROR_MEMORY, "no memory for another picture");
    return job;
}

static bool read_background(struct call *call, bool *background)
{
    const json_t *value = json_object_get(call->json, "background");
    *background = !value || json_is_true(value);
    return !value || json_is_boolean(value) || session_fail(call->error, PEL_ERROR_ARGUMENT, "background: it must be true or false");
}

bool run_picture(struct call *call)
{
    int size[2];
    bool background;
    if (!call_size(call, "size", SESSION_MOST_PICTURE_PIXELS, SESSION_MOST_PICTURE_PIXELS, size) || !read_background(call, &background))
        return false;
    if (size[0] > PEL_IMAGE_MAX || size[1] > PEL_IMAGE_MAX)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "size: a side is longer than %d pixels", PEL_IMAGE_MAX);
    struct session_job *job = job_new(call, "picture", size, background);
    return job && add(call, job);
}

bool run_movie(struct call *call)
{
    int size[2];
    double frames, degrees = 360;
    bool background;
    const char *word = call_has(call, "format") ? call_text(call, "format", 16) : "webp";
    if (!word || !call_size(call, "size", SESSION_MOST_SIDE, MOST_MOVIE_PIXELS, size) || !read_background(call, &background) ||
        !call_number(call, "frames", 2, 3600, &frames) ||
        (call_has(call, "degrees") && !call_number(call, "degrees", -36000, 36000, &degrees)))
        return false;
    const struct movie_format *format = movie_format(word);
    if (!format)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "format: \"%s\" is no kind of movie; give \"webp\" or \"png\"", word);
    if (!background && !format->alpha)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "background: a movie of the format \"%s\" has one; give \"png\"", word);
    if (frames != floor(frames))
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "frames: %g is no whole number", frames);
    if (frames * size[0] * size[1] > MOST_MOVIE_PIXELS_IN_ALL)
        return session_fail(call->error, PEL_ERROR_ARGUMENT,
                            "size: %g frames of %dx%d are more than %g pixels; ask for fewer or smaller ones", frames, size[0], size[1],
                            MOST_MOVIE_PIXELS_IN_ALL);
    struct session_job *job = job_new(call, "movie", size, background);
    if (!job)
        return false;
    job->format = format;
    job->frames = (int)frames;
    job->degrees = degrees;
    return add(call, job);
}

bool run_cancel(struct call *call)
{
    struct session *s = call->session;
    const char *what = NULL;
    if (call_has(call, "what") && !(what = call_text(call, "what", 16)))
        return false;
    if (what && strcmp(what, "picture") != 0 && strcmp(what, "movie") != 0 && strcmp(what, "open") != 0)
        return session_fail(call->error, PEL_ERROR_ARGUMENT, "what: \"%s\" is not \"picture\", \"movie\" or \"open\"", what);
    session_jobs_cancel(s, call->client->number, what);
    if (!what || strcmp(what, "open") == 0)
        session_open_cancel(s); /* anybody's: all wait for it */
    return true;
}

void session_jobs_cancel(struct session *s, int client, const char *what)
{
    for (struct session_job *job = s->jobs; job; job = job->next)
        job->cancelled |= job->client == client && (!what || strcmp(job->what, what) == 0);
    session_interrupt(s);
}

/* ---- a step ---- */

static const double *background(const struct session_job *job)
{
    return job->background ? job->scene.background : NULL;
}

static bool add_movie_frame(struct session_job *job, struct pel_error *error)
{
    if (!job->movie)
        job->movie = movie_begin(job->format, job->size, error);
    return job->movie && movie_add(job->movie, job->encoder, &job->image, background(job), error);
}

/* A file of the picture; -1 on failure. */
static int picture_file(struct session_job *job, struct pel_error *error)
{
    const void *bytes = NULL;
    size_t size = 0;
    bool small = (double)job->size[0] * job->size[1] <= SMALL_PIXELS;
    int fd = encode_png(job->encoder, &job->image, background(job), small, NULL, &bytes, &size, error) ? download_file(error) : -1;
    if (fd >= 0 && !download_write(fd, bytes, size, error)) {
        close(fd);
        fd = -1;
    }
    return fd;
}

/* With the lock held. */
static void finish_job(struct session *s, struct session_job *job, int fd, const struct pel_error *error)
{
    const struct call call = { .name = job->what, .has_id = job->has_id, .id = job->id };
    for (struct session_job **at = &s->jobs; *at; at = &(*at)->next)
        if (*at == job) {
            *at = job->next;
            break;
        }
    session_tell_progress(s, job->client, job->what, 1);
    if (fd >= 0)
        session_offer(s, job->client, fd, job->format ? job->format->name : "picture.png", job->format ? job->format->type : "image/png",
                      &call);
    else
        session_tell_error(s, job->client, error, &call);
    job_free(job);
}

void session_job_fail(struct session *s, const struct pel_error *error)
{
    finish_job(s, s->jobs, -1, error);
}

uint64_t session_job_volume(const struct session *s)
{
    return s->jobs->volume->number;
}

static void aim(struct session_job *job, struct pel_scene *scene)
{
    *scene = job->scene;
    if (job->format) {
        scene->render.refine = 0;
        pel_camera_azimuth(&scene->camera, job->degrees * job->done / job->frames);
    }
}

/* One draw; `whole`: a frame of it is finished. */
static bool draw(struct session_job *job, struct pel_renderer *renderer, bool *whole, struct pel_error *error)
{
    const char *technique = session_technique(&job->scene);
    struct pel_scene scene;
    aim(job, &scene);
    if (!pel_image_allocate(&job->image, job->size[0], job->size[1], false, error) ||
        !session_take_options(renderer, &scene, technique, error) || !pel_renderer_draw(renderer, &scene, technique, &job->image, error))
        return false;
    *whole = pel_renderer_finished(renderer);
    return true;
}

static void tell_how_far(struct session *s, struct session_job *job)
{
    int draws = job->format ? job->frames : 1 + job->scene.render.refine;
    double now = session_now();
    if (now - job->told_ms < TOLD_MS)
        return;
    job->told_ms = now;
    session_tell_progress(s, job->client, job->what, 0.999 * job->draws / (draws > job->draws ? draws : job->draws));
}

/* Packs what was drawn: the thread, so that the next picture of the scene does not wait for it. */
static void *pack(void *user)
{
    struct session_job *job = user;
    struct session *s = job->session;
    struct pel_error error = PEL_ERROR_INIT;
    int fd = -1;
    bool fine = !job->format || add_movie_frame(job, &error);
    job->done += fine;
    bool ends = !fine || job->done == job->frames;
    if (fine && ends)
        fd = job->format ? movie_end(job->movie, &error) : picture_file(job, &error);
    pthread_mutex_lock(&s->lock);
    job->packing = false;
    if (job->cancelled) {
        if (fd >= 0)
            close(fd);
        fd = -1;
        session_fail(&error, PEL_ERROR_CANCELLED, "cancelled");
        ends = true;
    }
    if (ends)
        finish_job(s, job, fd, &error);
    else
        tell_how_far(s, job);
    session_thread_ends(s);
    pthread_mutex_unlock(&s->lock);
    return NULL;
}

bool session_job_due(const struct session *s)
{
    return s->jobs && !s->jobs->packing;
}

void session_job_step(struct session *s, struct pel_renderer *renderer)
{
    struct pel_error error = PEL_ERROR_INIT;
    bool whole = false;
    pthread_mutex_lock(&s->lock);
    struct session_job *job = s->jobs;
    bool ends = job->cancelled;
    pthread_mutex_unlock(&s->lock);
    bool fine = ends ? session_fail(&error, PEL_ERROR_CANCELLED, "cancelled") : draw(job, renderer, &whole, &error);
    job->draws += fine;
    pthread_mutex_lock(&s->lock);
    if (fine && whole)
        fine = job->packing = session_thread(s, pack, job, &error);
    else if (fine)
        tell_how_far(s, job);
    if (!fine && (ends || error.code != PEL_ERROR_CANCELLED)) /* else what came instead is more urgent */
        finish_job(s, job, -1, &error);
    pthread_mutex_unlock(&s->lock);
}
