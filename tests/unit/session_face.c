/* SPDX-License-Identifier: MIT */
#include "session_face.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

const char *const good_commands[] = {
    "{\"do\":\"size\",\"size\":[64,80]}",
    "{\"do\":\"hold\"}",
    "{\"do\":\"rotate\",\"by\":[0.1,-0.2],\"gesture\":3,\"id\":17}",
    "{\"do\":\"pan\",\"by\":[0.01,0.02],\"gesture\":4}",
    "{\"do\":\"release\"}",
    "{\"do\":\"zoom\",\"by\":1.5}",
    "{\"do\":\"zoom\",\"by\":0.5,\"at\":[0.2,0.9]}",
    "{\"do\":\"roll\",\"by\":10}",
    "{\"do\":\"view\",\"axis\":\"-z\"}",
    "{\"do\":\"reset\"}",
    "{\"do\":\"focus\",\"at\":[0.5,0.5]}",
    "{\"do\":\"set\",\"scene\":{\"render\":{\"shade\":true}}}",
    "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"isosurface\"}}}",
    "{\"do\":\"set\",\"scene\":{\"isosurfaces\":[{\"value\":0.4},{\"value\":0.6,\"opacity\":0.5}]}}",
    "{\"do\":\"set\",\"scene\":{\"clip-box\":[-1,1,-1,1,-1,0.5]}}",
    "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"composite\"},\"clip-box\":null}}",
    "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"slices2d\",\"options\":{\"blend\":5}}}}",
    "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"raycast\"}}}",
    "{\"do\":\"automatic\",\"what\":\"transfer\"}",
    "{\"do\":\"automatic\",\"what\":\"isosurfaces\"}",
    "{\"do\":\"automatic\",\"what\":\"slice\"}",
    "{\"do\":\"automatic\",\"what\":\"camera\"}",
    "{\"do\":\"colormap\",\"name\":\"viridis\",\"range\":[0,1]}",
    "{\"do\":\"import\",\"text\":\"[{\\\"Name\\\":\\\"a\\\",\\\"ColorSpace\\\":\\\"RGB\\\",\\\"RGBPoints\\\":[0,1,0,0,1,0,0,1]}]\"}",
    "{\"do\":\"export\"}",
    "{\"do\":\"scene\"}",
    "{\"do\":\"undo\"}",
    "{\"do\":\"redo\"}",
    "{\"do\":\"probe\",\"at\":[0.5,0.5]}",
    "{\"do\":\"slices\",\"at\":[0,0,0],\"size\":[32,32],\"window\":[0.2,0.8]}",
    "{\"do\":\"slices\",\"at\":[0.1,0,0]}",
    "{\"do\":\"slices\",\"at\":[0.1,0,0],\"views\":[null,{\"center\":[0,0,0],\"scale\":0.1},{\"center\":[9e99,0,0],\"scale\":1e-99}]}",
    "{\"do\":\"slices\",\"at\":null}",
    "{\"do\":\"device\",\"device\":\"cpu\"}",
    "{\"do\":\"list\"}",
    "{\"do\":\"cancel\"}",
    NULL,
};

static void on_frame(void *user, const struct session_frame *frame)
{
    struct face *face = user;
    pthread_mutex_lock(&face->lock);
    face->frames++;
    if (!strstr(face->views, frame->view))
        strcat(strcat(face->views, " "), frame->view);
    if (strcmp(frame->view, "main") != 0) {
        face->slices++;
        face->slice_clients = 0;
        for (int i = 0; i < frame->client_count; i++)
            face->slice_clients |= 1 << frame->clients[i].client;
    }
    if (strcmp(frame->view, "main") == 0) {
        face->full += strstr(frame->header, "\"quality\":\"full\"") != NULL;
        face->moving += strstr(frame->header, "\"quality\":\"moving\"") != NULL;
        face->final = strstr(frame->header, "\"final\":true") != NULL;
        face->finals += face->final;
        for (int i = 0; i < frame->client_count; i++)
            if (frame->clients[i].client == 1)
                face->id = frame->clients[i].id;
        if (frame->lossless) {
            free(face->picture);
            face->picture = malloc(frame->size);
            memcpy(face->picture, frame->bytes, frame->size);
            face->size = frame->size;
        }
    }
    pthread_mutex_unlock(&face->lock);
}

static void on_event(void *user, int client, const char *text)
{
    struct face *face = user;
    json_t *event = json_loads(text, 0, NULL);
    assert_non_null(event);
    json_object_set_new(event, "_to", json_integer(client));
    pthread_mutex_lock(&face->lock);
    json_array_append_new(face->events, event);
    pthread_mutex_unlock(&face->lock);
}

static bool on_wanted(void *user)
{
    struct face *face = user;
    pthread_mutex_lock(&face->lock);
    bool wanted = !face->unwanted;
    pthread_mutex_unlock(&face->lock);
    return wanted;
}

bool compute(struct pel_volume *volume, struct pel_error *error)
{
    const struct pel_dataset *dataset = pel_dataset_find("marschner-lobb");
    void *params = pel_dataset_create_params(dataset);
    assert_true(pel_option_set(pel_option_find(dataset->options, "size"), params, "24", error));
    pel_volume_init(volume);
    bool fine = pel_dataset_make(dataset, params, volume, error);
    free(params);
    return fine;
}

bool open_computed(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    (void)user, (void)progress;
    if (!compute(&opened->volume, error) || !pel_scene_init(&opened->scene, error))
        return false;
    opened->scene.volume = &opened->volume;
    opened->scene.render.refine = 2;
    opened->fit_camera = true;
    return pel_scene_choose(&opened->scene, &(struct pel_scene_parts) { .transfer = true, .slice = true, .camera = true }, 96, 64, error);
}

void start_with(struct face *face, const char *const *paths, FILE *record,
                bool (*open)(void *, struct session_opened *, const struct pel_progress *, struct pel_error *), void *open_user)
{
    struct pel_error error = PEL_ERROR_INIT;
    *face = (struct face) { .lock = PTHREAD_MUTEX_INITIALIZER, .events = json_array() };
    const struct session_params params = { .user = face,
                                           .frame = on_frame,
                                           .event = on_event,
                                           .wanted = on_wanted,
                                           .open = open,
                                           .open_user = open_user,
                                           .paths = paths,
                                           .threads = 1,
                                           .budget_ms = 33,
                                           .record = record };
    face->session = session_create(&params, &error);
    if (!face->session)
        fail_msg("%s", error.message);
    assert_true(session_settle(face->session, false));
}

bool say(struct face *face, int client, const char *text)
{
    return session_command_text(face->session, client, text, strlen(text));
}

void start(struct face *face)
{
    start_with(face, NULL, NULL, open_computed, NULL);
    assert_true(say(face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
}

void finish(struct face *face)
{
    session_destroy(face->session);
    json_decref(face->events);
    free(face->picture);
}

json_t *last(struct face *face, const char *kind)
{
    json_t *found = NULL;
    pthread_mutex_lock(&face->lock);
    for (size_t i = json_array_size(face->events); i-- > 0 && !found;) {
        json_t *event = json_array_get(face->events, i);
        if (strcmp(json_string_value(json_object_get(event, "event")), kind) == 0)
            found = event;
    }
    pthread_mutex_unlock(&face->lock);
    return found;
}

json_t *scene(struct face *face)
{
    session_settle(face->session, true);
    return json_object_get(last(face, "state"), "scene");
}

json_t *part(struct face *face, const char *a, const char *b)
{
    return json_object_get(json_object_get(scene(face), a), b);
}

void *rest(struct face *face, size_t *size)
{
    assert_true(session_settle(face->session, true));
    pthread_mutex_lock(&face->lock);
    assert_non_null(face->picture);
    assert_true(face->final);
    void *copy = malloc(face->size);
    memcpy(copy, face->picture, face->size);
    *size = face->size;
    pthread_mutex_unlock(&face->lock);
    return copy;
}

bool same(struct face *face, const void *picture, size_t size)
{
    size_t now_size;
    void *now = rest(face, &now_size);
    bool equal = now_size == size && memcmp(now, picture, size) == 0;
    free(now);
    return equal;
}

int errors(struct face *face)
{
    int count = 0;
    pthread_mutex_lock(&face->lock);
    for (size_t i = 0; i < json_array_size(face->events); i++)
        count += strcmp(json_string_value(json_object_get(json_array_get(face->events, i), "event")), "error") == 0;
    pthread_mutex_unlock(&face->lock);
    return count;
}

void make(struct files *f)
{
    struct pel_volume volume;
    strcpy(f->folder, "/tmp/pellucid-session-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    snprintf(f->a, sizeof f->a, "%s/a.nrrd", f->folder);
    snprintf(f->b, sizeof f->b, "%s/b.nrrd", f->folder);
    assert_true(compute(&volume, NULL));
    assert_true(pel_write_volume(f->a, &volume, NULL, NULL));
    for (size_t i = 0; i < volume.dims[0] * volume.dims[1] * volume.dims[2]; i++)
        ((float *)volume.data)[i] *= (float)(i % volume.dims[0]); /* another thing to see */
    pel_volume_update_range(&volume);
    assert_true(pel_write_volume(f->b, &volume, NULL, NULL));
    pel_volume_finish(&volume);
}

void begin(struct files *f)
{
    make(f);
    start_with(&f->face, (const char *const[]) { f->folder, NULL }, NULL, NULL, NULL);
    assert_true(say(&f->face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
}

bool say_of(struct files *f, const char *format, const char *path)
{
    char text[512];
    snprintf(text, sizeof text, format, path);
    return say(&f->face, 1, text);
}

void show(struct files *f, const char *path)
{
    assert_true(say_of(f, "{\"do\":\"open\",\"path\":\"%s\"}", path));
    assert_true(session_settle(f->face.session, false));
    assert_string_equal(json_string_value(json_object_get(last(&f->face, "volume"), "path")), path);
}

void done(struct files *f)
{
    finish(&f->face);
    unlink(f->a);
    unlink(f->b);
    rmdir(f->folder);
}

int steps(struct files *f, const char *which)
{
    session_settle(f->face.session, true);
    return (int)json_integer_value(json_object_get(last(&f->face, "state"), which));
}

void put(const char *folder, const char *name, size_t at, const char *bytes)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    int fd = open(path, O_CREAT | O_WRONLY, 0600);
    assert_int_equal(pwrite(fd, bytes, strlen(bytes), (off_t)at), (ssize_t)strlen(bytes));
    close(fd);
}
