/* SPDX-License-Identifier: MIT */
/* The viewer's session and more than one client: what is whose, and what waits for whom. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "session_face.h"
#include "session_inside.h"

/* Events of a kind to a client. */
static int told(struct face *face, int client, const char *kind)
{
    int count = 0;
    pthread_mutex_lock(&face->lock);
    for (size_t i = 0; i < json_array_size(face->events); i++) {
        const json_t *event = json_array_get(face->events, i);
        count += json_integer_value(json_object_get(event, "_to")) == client &&
                 strcmp(json_string_value(json_object_get(event, "event")), kind) == 0;
    }
    pthread_mutex_unlock(&face->lock);
    return count;
}

static void start_two(struct face *face)
{
    start(face);
    assert_true(say(face, 2, "{\"do\":\"hello\",\"size\":[96,64]}"));
    session_settle(face->session, true);
}

/* A picture is of who asked: it hears of it, cancels it, and takes it along. */
static void test_jobs(void **state)
{
    static const char movie[] = "{\"do\":\"movie\",\"size\":[64,48],\"frames\":3600,\"degrees\":360}";
    (void)state;
    struct face face;
    start_two(&face);
    say(&face, 1, "{\"do\":\"hold\"}"); /* so that nothing is drawn yet */
    assert_true(say(&face, 1, movie));
    assert_true(say(&face, 2, "{\"do\":\"picture\",\"size\":[64,48]}"));
    assert_true(say(&face, 2, movie));
    assert_true(say(&face, 1, "{\"do\":\"cancel\"}"));
    session_leave(face.session, 1);
    say(&face, 3, "{\"do\":\"hello\",\"size\":[96,64]}");
    for (int i = 0; i < 3000 && !told(&face, 2, "download"); i++)
        usleep(10000);
    assert_int_equal(told(&face, 2, "download"), 1); /* the picture; the first movie is gone, the second is not done */
    assert_int_equal(told(&face, 2, "error"), 0);
    assert_int_equal(told(&face, 1, "error"), 1);
    session_leave(face.session, 2);
    session_settle(face.session, true);
    assert_int_equal(told(&face, 1, "download") + told(&face, 2, "download"), 1);
    assert_true(told(&face, 2, "progress") > 0);
    assert_int_equal(told(&face, 3, "progress") + told(&face, 0, "progress"), 1); /* that the volume was read */
    finish(&face);
}

/* It is cancelled while it is packed, too. */
static void test_cancel_while_packing(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"refine\":0}}}"));
    session_settle(face.session, true);
    assert_true(say(&face, 1, "{\"do\":\"picture\",\"size\":[1024,1024]}"));
    for (bool packs = false; !packs;) { /* at rest no other thread of the session is at work */
        usleep(1000);
        pthread_mutex_lock(&face.session->lock);
        packs = face.session->readers > 0;
        pthread_mutex_unlock(&face.session->lock);
    }
    assert_true(say(&face, 1, "{\"do\":\"cancel\"}"));
    session_settle(face.session, true);
    assert_int_equal(told(&face, 1, "download"), 0);
    assert_string_equal(json_string_value(json_object_get(last(&face, "error"), "code")), "cancelled");
    finish(&face);
}

/* Slices are drawn while somebody asks for them, and sent to who does. */
static void test_slices(void **state)
{
    static const char at[] = "{\"do\":\"slices\",\"at\":[0,0,0],\"size\":[32,32]}", none[] = "{\"do\":\"slices\",\"at\":null}";
    static const char gray[] = "{\"do\":\"colormap\",\"name\":\"gray\",\"range\":[0,1]}";
    static const char viridis[] = "{\"do\":\"colormap\",\"name\":\"viridis\",\"range\":[0,1]}";
    (void)state;
    struct face face;
    start_two(&face);
    assert_true(say(&face, 2, none)); /* a page that shows none says so, and nothing comes of it */
    session_settle(face.session, true);
    assert_int_equal(face.slices, 0);
    assert_true(say(&face, 1, at));
    session_settle(face.session, true);
    assert_int_equal(face.slices, 3);
    assert_int_equal(face.slice_clients, 1 << 1);
    assert_true(say(&face, 2, at));
    session_settle(face.session, true);
    assert_int_equal(face.slices, 6);
    assert_int_equal(face.slice_clients, 1 << 1 | 1 << 2);
    assert_true(say(&face, 1, none));
    assert_true(say(&face, 1, gray));
    session_settle(face.session, true);
    assert_int_equal(face.slices, 9);
    assert_int_equal(face.slice_clients, 1 << 2);
    session_leave(face.session, 2);
    assert_true(say(&face, 1, viridis));
    session_settle(face.session, true);
    assert_int_equal(face.slices, 9);
    finish(&face);
}

/* From the next command on, which leaves session.abort as it is: until the thread that draws is at what came of it. */
static void wait_until_drawing(struct face *face)
{
    while (atomic_load(&face->session->abort))
        usleep(1000);
}

/* They do not wait for a large picture that is drawn to be saved. */
static void test_slices_stop_a_picture(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"refine\":0,\"step\":0.01}}}"));
    session_settle(face.session, true);
    atomic_store(&face.session->abort, SESSION_CHANGED);
    assert_true(say(&face, 1, "{\"do\":\"picture\",\"size\":[2048,2048]}")); /* seconds */
    wait_until_drawing(&face);
    assert_true(say(&face, 1, "{\"do\":\"slices\",\"at\":[0,0,0],\"size\":[32,32]}"));
    for (int i = 0, slices = 0; i < 6000 && slices < 3; i++) {
        usleep(5000);
        pthread_mutex_lock(&face.lock);
        slices = face.slices;
        pthread_mutex_unlock(&face.lock);
    }
    assert_int_equal(face.slices, 3);
    assert_int_equal(told(&face, 1, "download"), 0);
    assert_true(say(&face, 1, "{\"do\":\"cancel\"}"));
    session_settle(face.session, true);
    assert_int_equal(told(&face, 1, "download"), 0);
    finish(&face);
}

/* A hand that goes up while its last moves are not shown yet does not make the next hand wait for a picture in full quality. */
static void test_full_quality_is_stopped(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    session_settle(face.session, true);
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"refine\":0}}}"));
    session_settle(face.session, true);
    pthread_mutex_lock(&face.lock);
    face.unwanted = true; /* no picture of motion is drawn */
    int full = face.full;
    pthread_mutex_unlock(&face.lock);
    assert_true(say(&face, 1, "{\"do\":\"hold\"}"));
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"step\":0.01}}}")); /* seconds */
    assert_true(say(&face, 1, "{\"do\":\"size\",\"size\":[2048,2048]}"));
    assert_true(say(&face, 1, "{\"do\":\"release\"}"));
    wait_until_drawing(&face);
    assert_true(say(&face, 1, "{\"do\":\"hold\"}"));
    pthread_mutex_lock(&face.lock);
    face.unwanted = false;
    pthread_mutex_unlock(&face.lock);
    session_wake(face.session);
    session_settle(face.session, false);
    assert_int_equal(face.full, full);
    assert_true(face.moving > 0);
    finish(&face);
}

/* A volume that is longer than a stack of textures can be. */
static bool open_on_gpu(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    if (!open_computed(user, opened, progress, error))
        return false;
    pel_volume_finish(&opened->volume);
    pel_volume_init(&opened->volume);
    if (!pel_volume_allocate(&opened->volume, (const size_t[3]) { 70000, 2, 2 }, PEL_U8, 1, error))
        return false;
    memset(opened->volume.data, 200, 140000);
    pel_volume_update_range(&opened->volume);
    opened->device = pel_device_create(-1, NULL, NULL);
    return true;
}

/* What one technique cannot draw on the GPU is told to all, and the GPU goes on with the next. */
static void test_gpu_stays(void **state)
{
    (void)state;
    struct face face;
    start_with(&face, NULL, NULL, open_on_gpu, NULL);
    assert_true(say(&face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
    session_settle(face.session, true);
    const char *kind = json_string_value(json_object_get(json_object_get(last(&face, "hello"), "device"), "kind"));
    if (strcmp(kind, "cpu") == 0) {
        finish(&face);
        skip(); /* there is no GPU, not even one in software */
    }
    assert_int_equal(errors(&face), 0);
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"slices2d\"}}}"));
    session_settle(face.session, true);
    assert_true(told(&face, 0, "error") > 0);
    assert_non_null(strstr(json_string_value(json_object_get(last(&face, "error"), "message")), "stacks"));
    assert_int_equal(told(&face, 0, "devices"), 0);
    int finals = face.finals;
    assert_true(say(&face, 1, "{\"do\":\"undo\"}"));
    session_settle(face.session, true);
    assert_int_equal(face.finals, finals + 1);
    finish(&face);
}

static void assert_size(struct face *face, int width, int height)
{
    session_settle(face->session, true);
    json_t *size = json_object_get(last(face, "state"), "size");
    assert_int_equal(json_integer_value(json_array_get(size, 0)), width);
    assert_int_equal(json_integer_value(json_array_get(size, 1)), height);
    assert_true(face->final);
}

/* One picture for all: it has the widest shape, at the largest width, of those that are there. */
static void test_sizes(void **state)
{
    struct face face;
    size_t size;
    (void)state;
    start(&face);
    void *alone = rest(&face, &size);
    assert_true(say(&face, 2, "{\"do\":\"hello\",\"size\":[40,80]}"));
    assert_true(same(&face, alone, size)); /* a narrow page cuts nothing off for the wide one */
    assert_true(say(&face, 2, "{\"do\":\"size\",\"size\":[120,240]}"));
    assert_size(&face, 120, 80);
    assert_true(say(&face, 3, "{\"do\":\"hello\",\"size\":[60,30]}"));
    assert_size(&face, 120, 60);
    assert_false(say(&face, 3, "{\"do\":\"size\",\"size\":[8,30]}"));
    assert_size(&face, 120, 60);
    session_leave(face.session, 2);
    assert_size(&face, 96, 48);
    session_leave(face.session, 3);
    assert_size(&face, 96, 64);
    assert_true(same(&face, alone, size));
    session_leave(face.session, 1);
    assert_size(&face, 96, 64);
    free(alone);
    finish(&face);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_gpu_stays),
        cmocka_unit_test(test_jobs),
        cmocka_unit_test(test_cancel_while_packing),
        cmocka_unit_test(test_slices),
        cmocka_unit_test(test_slices_stop_a_picture),
        cmocka_unit_test(test_full_quality_is_stopped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
