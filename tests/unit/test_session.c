/* SPDX-License-Identifier: MIT */
/* The viewer's session with no face: commands in, frames and events out. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "session.h"
#include "session_face.h"

static void test_hello(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    session_settle(face.session, true);
    json_t *hello = last(&face, "hello"), *volume = last(&face, "volume");
    assert_non_null(hello);
    assert_int_equal(json_integer_value(json_object_get(hello, "_to")), 1);
    assert_true(json_array_size(json_object_get(hello, "techniques")) >= 3);
    assert_true(json_array_size(json_object_get(hello, "colormaps")) > 5);
    assert_true(json_array_size(json_object_get(json_object_get(hello, "options"), "camera")) == 6);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(volume, "dims"), 0)), 24);
    assert_true(json_array_size(json_object_get(json_object_get(volume, "histogram"), "counts")) > 0);
    assert_non_null(part(&face, "camera", "camera-position"));
    assert_non_null(face.picture);
    finish(&face);
}

static void test_good_commands(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    for (size_t i = 0; good_commands[i]; i++) {
        if (!say(&face, 1, good_commands[i]))
            fail_msg("%s: %s", good_commands[i], json_string_value(json_object_get(last(&face, "error"), "message")));
        assert_true(session_settle(face.session, i % 3 == 0 || strstr(good_commands[i], "slices")));
    }
    session_settle(face.session, true);
    assert_null(last(&face, "error"));
    assert_non_null(strstr(face.views, "slice-i"));
    assert_non_null(strstr(face.views, "slice-k"));
    assert_true(json_is_true(json_object_get(last(&face, "probe"), "inside")));
    finish(&face);
}

/* What the volume holds at a place between two voxels; `by` from the first to the second. */
static json_t *probe_world(struct face *face, double by)
{
    json_t *matrix = json_object_get(last(face, "volume"), "index_to_world");
    double index[] = { 3 + by, 4, 5, 1 }, world[3] = { 0, 0, 0 };
    char text[200];
    for (size_t i = 0; i < 12; i++)
        world[i / 4] += json_number_value(json_array_get(matrix, i)) * index[i % 4];
    snprintf(text, sizeof text, "{\"do\":\"probe\",\"world\":[%.17g,%.17g,%.17g]}", world[0], world[1], world[2]);
    assert_true(say(face, 1, text));
    return last(face, "probe");
}

static void test_probe_world(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    double value[3];
    for (int i = 0; i < 3; i++) {
        const json_t *event = probe_world(&face, 0.5 * i);
        assert_true(json_is_true(json_object_get(event, "hit")));
        assert_true(fabs(json_number_value(json_array_get(json_object_get(event, "index"), 0)) - 3 - 0.5 * i) < 1e-9);
        value[i] = json_number_value(json_object_get(event, "value"));
    }
    assert_true(value[0] != value[2] && fabs(value[1] - (value[0] + value[2]) / 2) < 1e-9);
    assert_true(json_is_false(json_object_get(probe_world(&face, 1e6), "hit")));
    assert_null(json_object_get(last(&face, "probe"), "value"));
    finish(&face);
}

static const char *const bad[] = {
    "",
    "{",
    "[]",
    "null",
    "17",
    "{}",
    "{\"do\":17}",
    "{\"do\":\"dance\"}",
    "{\"do\":\"rotate\"}",
    "{\"do\":\"rotate\",\"by\":[1]}",
    "{\"do\":\"rotate\",\"by\":[1,\"2\"]}",
    "{\"do\":\"rotate\",\"by\":[1,2,3]}",
    "{\"do\":\"rotate\",\"by\":[1e300,0]}",
    "{\"do\":\"rotate\",\"by\":[NaN,0]}",
    "{\"do\":\"rotate\",\"by\":[1e999,0]}",
    "{\"do\":\"rotate\",\"by\":[0,0],\"speed\":1}",
    "{\"do\":\"rotate\",\"by\":[0,0],\"by\":[0,0]}",
    "{\"do\":\"rotate\",\"by\":[0,0],\"gesture\":1.5}",
    "{\"do\":\"rotate\",\"by\":[0,0],\"gesture\":-1}",
    "{\"do\":\"rotate\",\"by\":[0,0],\"id\":\"x\"}",
    "{\"do\":\"pan\",\"by\":[1e99,1e99]}",
    "{\"do\":\"zoom\",\"by\":0}",
    "{\"do\":\"zoom\",\"by\":-1}",
    "{\"do\":\"zoom\",\"by\":true}",
    "{\"do\":\"roll\",\"by\":\"ten\"}",
    "{\"do\":\"view\",\"axis\":\"x\"}",
    "{\"do\":\"view\",\"axis\":\"+w\"}",
    "{\"do\":\"view\"}",
    "{\"do\":\"focus\",\"at\":[2,0]}",
    "{\"do\":\"size\",\"size\":[100000,100000]}",
    "{\"do\":\"size\",\"size\":[8192,8192]}",
    "{\"do\":\"size\",\"size\":[96.5,64]}",
    "{\"do\":\"size\",\"size\":[0,64]}",
    "{\"do\":\"size\",\"size\":[-96,64]}",
    "{\"do\":\"size\",\"size\":\"96x64\"}",
    "{\"do\":\"size\"}",
    "{\"do\":\"hello\"}",
    "{\"do\":\"set\"}",
    "{\"do\":\"set\",\"scene\":[]}",
    "{\"do\":\"set\",\"scene\":{\"volume\":{\"path\":\"/etc/passwd\"}}}",
    "{\"do\":\"set\",\"scene\":{\"cloud\":1}}",
    "{\"do\":\"set\",\"scene\":{\"render\":{\"step\":-1}}}",
    "{\"do\":\"set\",\"scene\":{\"render\":{\"step\":1e9}}}",
    "{\"do\":\"set\",\"scene\":{\"camera\":{\"camera-position\":[0,0]}}}",
    "{\"do\":\"set\",\"scene\":{\"camera\":{\"camera-view-up\":[0,0,0]}}}",
    "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"mip\"},\"isosurfaces\":[{\"value\":\"x\"}]}}",
    "{\"do\":\"set\",\"scene\":{\"transfer\":{\"opacities\":[[0,2]]}}}",
    "{\"do\":\"set\",\"scene\":{\"transfer\":{\"opacities\":[]}}}",
    "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"magic\"}}}",
    "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"mesh\"}}}",
    "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"slices2d\",\"options\":{\"blend\":1e9}}}}",
    "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"slices2d\"},\"render\":{\"mode\":\"mip\"}}}",
    "{\"do\":\"automatic\",\"what\":\"everything\"}",
    "{\"do\":\"automatic\"}",
    "{\"do\":\"colormap\",\"name\":\"mauve\",\"range\":[0,1]}",
    "{\"do\":\"colormap\",\"name\":\"viridis\"}",
    "{\"do\":\"import\",\"text\":\"nonsense\"}",
    "{\"do\":\"import\",\"text\":17}",
    "{\"do\":\"undo\"}",
    "{\"do\":\"redo\"}",
    "{\"do\":\"probe\",\"at\":[0.5,0.5],\"opacity\":0}",
    "{\"do\":\"probe\"}",
    "{\"do\":\"slices\",\"at\":[0,0],\"size\":[32,32]}",
    "{\"do\":\"slices\",\"at\":[0,0,0],\"size\":[32000,32000]}",
    "{\"do\":\"slices\",\"at\":[0,0,0],\"window\":[1,0]}",
    "{\"do\":\"slices\",\"at\":[0,0,0],\"views\":[null,null]}",
    "{\"do\":\"slices\",\"at\":[0,0,0],\"views\":[null,null,{\"center\":[0,0,0]}]}",
    "{\"do\":\"slices\",\"at\":[0,0,0],\"views\":[null,null,{\"center\":[0,0,0],\"scale\":0}]}",
    "{\"do\":\"probe\",\"world\":[0,0]}",
    "{\"do\":\"probe\",\"world\":[0,0,0],\"at\":[0.5,0.5]}",
    "{\"do\":\"picture\",\"size\":[100000,100000]}",
    "{\"do\":\"picture\",\"size\":[64,64],\"background\":1}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":1}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":2.7}",
    "{\"do\":\"movie\",\"size\":[4096,2048],\"frames\":3600}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":1e6,\"degrees\":360}",
    "{\"do\":\"movie\",\"size\":[8192,4096],\"frames\":10,\"degrees\":360}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":2,\"format\":\"gif\"}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":2,\"format\":7}",
    "{\"do\":\"cancel\",\"what\":\"probe\"}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":2,\"background\":false}",
    "{\"do\":\"movie\",\"size\":[64,64],\"frames\":2,\"format\":\"png\",\"background\":1}",
    "{\"do\":\"list\",\"path\":\"\"}",
    "{\"do\":\"device\"}",
    "{\"do\":\"device\",\"device\":7}",
    "{\"do\":\"device\",\"device\":\"tpu\"}",
    "{\"do\":\"device\",\"device\":\"gpu:\"}",
    "{\"do\":\"device\",\"device\":\"gpu:-1\"}",
    "{\"do\":\"device\",\"device\":\"gpu:1x\"}",
    "{\"do\":\"open\",\"path\":\"\"}",
    "{\"do\":\"open\"}",
    "{\"do\":\"shown\",\"frame\":1}",
};

static void test_bad_commands(void **state)
{
    (void)state;
    struct face face;
    size_t size;
    start(&face);
    void *picture = rest(&face, &size);
    json_t *before = json_deep_copy(scene(&face));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int count = errors(&face);
        if (say(&face, 1, bad[i]))
            fail_msg("taken: %s", bad[i]);
        assert_int_equal(errors(&face), count + 1);
        json_t *error = last(&face, "error");
        assert_int_equal(json_integer_value(json_object_get(error, "_to")), 1);
        const char *message = json_string_value(json_object_get(error, "message"));
        assert_true(message && message[0] && !strchr(message, '\n'));
        const char *code = json_string_value(json_object_get(error, "code"));
        bool nothing = strstr(bad[i], "undo") || strstr(bad[i], "redo");
        assert_true(nothing ? code && strcmp(code, "nothing") == 0 : !code);
    }
    assert_false(say(&face, 2, "{\"do\":\"rotate\",\"by\":[0,0]}")); /* before hello */
    assert_true(same(&face, picture, size));
    assert_true(json_equal(before, scene(&face)));
    assert_int_equal(json_integer_value(json_object_get(last(&face, "state"), "undo")), 0);
    char *large = malloc(SESSION_MOST_BYTES + 2);
    memset(large, ' ', SESSION_MOST_BYTES + 1);
    assert_false(session_command_text(face.session, 1, large, SESSION_MOST_BYTES + 1));
    free(large);
    json_decref(before);
    free(picture);
    finish(&face);
}

static void test_undo(void **state)
{
    (void)state;
    struct face face;
    size_t size;
    start(&face);
    void *picture = rest(&face, &size);
    json_t *before = json_deep_copy(scene(&face));
    say(&face, 1, "{\"do\":\"hold\"}");
    for (int i = 0; i < 5; i++)
        assert_true(say(&face, 1, "{\"do\":\"rotate\",\"by\":[0.03,0.01],\"gesture\":1}"));
    say(&face, 1, "{\"do\":\"release\"}");
    assert_false(same(&face, picture, size));
    assert_int_equal(json_integer_value(json_object_get(last(&face, "state"), "undo")), 1);
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"mip\"},\"lights\":[],\"clip-box\":[-1,1,-1,1,0,1]}}"));
    assert_true(say(&face, 1, "{\"do\":\"colormap\",\"name\":\"viridis\",\"range\":[0,0.9]}"));
    size_t changed_size;
    void *changed = rest(&face, &changed_size);
    for (int i = 0; i < 3; i++)
        assert_true(say(&face, 1, "{\"do\":\"undo\"}"));
    assert_true(json_equal(before, scene(&face)));
    assert_true(same(&face, picture, size));
    for (int i = 0; i < 3; i++)
        assert_true(say(&face, 1, "{\"do\":\"redo\"}"));
    assert_true(same(&face, changed, changed_size));
    json_decref(before);
    free(changed);
    free(picture);
    finish(&face);
}

/* Each change ends in one picture that says that it is the last, refined or not, and whether it was drawn before or not. */
static void test_final(void **state)
{
    static const char *const changes[] = {
        "{\"do\":\"rotate\",\"by\":[0.1,0]}",
        "{\"do\":\"rotate\",\"by\":[0,0]}",
        "{\"do\":\"set\",\"scene\":{\"render\":{\"refine\":0}}}",
        "{\"do\":\"rotate\",\"by\":[0,0]}",
        "{\"do\":\"set\",\"scene\":{\"render\":{\"refine\":5}}}",
        "{\"do\":\"set\",\"scene\":{\"technique\":{\"name\":\"slices2d\"}}}",
        "{\"do\":\"undo\"}",
        "{\"do\":\"size\",\"size\":[64,64]}",
        "{\"do\":\"hello\",\"size\":[64,64]}",
    };
    (void)state;
    struct face face;
    start(&face);
    session_settle(face.session, true);
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        int before = face.finals;
        assert_true(say(&face, 1 + (i == 8), changes[i]));
        assert_true(session_settle(face.session, true));
        if (!face.final || face.finals != before + 1)
            fail_msg("%s: %d final pictures", changes[i], face.finals - before);
    }
    finish(&face);
}

/* While no face can take a picture commands gather, and then one picture shows them all. */
static void test_merging(void **state)
{
    (void)state;
    struct face face;
    char text[128];
    start(&face);
    session_settle(face.session, true);
    pthread_mutex_lock(&face.lock);
    face.unwanted = true;
    int before = face.frames;
    pthread_mutex_unlock(&face.lock);
    say(&face, 1, "{\"do\":\"hold\"}");
    for (int i = 1; i <= 200; i++) {
        snprintf(text, sizeof text, "{\"do\":\"rotate\",\"by\":[0.001,0],\"gesture\":1,\"id\":%d}", i);
        assert_true(say(&face, 1, text));
    }
    pthread_mutex_lock(&face.lock);
    assert_int_equal(face.frames, before);
    face.unwanted = false;
    pthread_mutex_unlock(&face.lock);
    session_wake(face.session);
    session_settle(face.session, false);
    pthread_mutex_lock(&face.lock);
    assert_int_equal(face.frames, before + 1);
    assert_int_equal(face.id, 200);
    pthread_mutex_unlock(&face.lock);
    session_leave(face.session, 1); /* and its hold is released */
    say(&face, 2, "{\"do\":\"hello\",\"size\":[96,64]}");
    session_settle(face.session, true);
    assert_true(json_is_false(json_object_get(last(&face, "state"), "held")));
    finish(&face);
}

static void test_reset_and_views(void **state)
{
    (void)state;
    struct face face;
    size_t size;
    start(&face);
    void *picture = rest(&face, &size);
    say(&face, 1, "{\"do\":\"view\",\"axis\":\"+x\"}");
    const json_t *at = part(&face, "camera", "camera-position"), *to = part(&face, "camera", "camera-focal-point");
    assert_true(json_number_value(json_array_get(at, 0)) > json_number_value(json_array_get(to, 0)));
    assert_true(fabs(json_number_value(json_array_get(at, 1)) - json_number_value(json_array_get(to, 1))) < 1e-9);
    say(&face, 1, "{\"do\":\"pan\",\"by\":[0.3,0.3]}");
    say(&face, 1, "{\"do\":\"reset\"}");
    assert_true(same(&face, picture, size));
    free(picture);
    finish(&face);
}

static void read_vector(json_t *camera, const char *key, double out[3])
{
    for (size_t i = 0; i < 3; i++)
        out[i] = json_number_value(json_array_get(json_object_get(camera, key), i));
}

/* How far from the middle of the picture the box goes: 1 is an edge. */
static double reach(struct face *face, double aspect)
{
    json_t *told = json_object_get(scene(face), "camera"), *bounds = json_object_get(last(face, "volume"), "bounds");
    struct pel_camera camera = PEL_CAMERA_INIT;
    double right[3], up[3], forward[3], most = 0;
    read_vector(told, "camera-position", camera.position);
    read_vector(told, "camera-focal-point", camera.focal_point);
    read_vector(told, "camera-view-up", camera.view_up);
    pel_camera_basis(&camera, right, up, forward);
    for (int corner = 0; corner < 8; corner++) {
        double x = 0, y = 0, z = 0;
        for (int a = 0; a < 3; a++) {
            double from = json_number_value(json_array_get(bounds, (size_t)(2 * a + (corner >> a & 1)))) - camera.position[a];
            x += from * right[a];
            y += from * up[a];
            z += from * forward[a];
        }
        double edge = z * tan(camera.view_angle / 360 * 3.14159265358979);
        most = fmax(most, fmax(fabs(x) / (edge * aspect), fabs(y) / edge));
    }
    return most;
}

/* Until somebody moves the camera, each size of the picture holds the whole box, and most of the picture is for it. */
static void test_fit(void **state)
{
    (void)state;
    static const char *const sizes[] = { "[96,64]", "[400,64]", "[64,400]", "[800,600]" };
    static const double aspects[] = { 1.5, 6.25, 0.16, 4 / 3.0 };
    struct face face;
    char text[64];
    start(&face);
    for (int i = 0; i < 4; i++) {
        snprintf(text, sizeof text, "{\"do\":\"size\",\"size\":%s}", sizes[i]);
        assert_true(say(&face, 1, text));
        double r = reach(&face, aspects[i]);
        assert_true(r > 0.8 && r < 0.95);
    }
    assert_true(say(&face, 1, "{\"do\":\"zoom\",\"by\":2}"));
    json_t *moved = json_deep_copy(part(&face, "camera", "camera-position"));
    assert_true(say(&face, 1, "{\"do\":\"size\",\"size\":[64,400]}"));
    assert_true(json_equal(moved, part(&face, "camera", "camera-position")));
    assert_true(say(&face, 1, "{\"do\":\"automatic\",\"what\":\"camera\"}"));
    assert_true(reach(&face, 0.16) < 0.95);
    json_decref(moved);
    finish(&face);
}

/* What lies under a point of the picture stays there when one zooms at it, and comes to the middle as the focal point. */
static void test_zoom_and_focus_at(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    assert_true(say(&face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"isosurface\"},\"isosurfaces\":[{\"value\":0.5}],\"camera\":{\"parallel\":true}}}"));
    assert_true(say(&face, 1, "{\"do\":\"probe\",\"at\":[0.45,0.4]}"));
    json_t *before = json_deep_copy(json_object_get(last(&face, "probe"), "world"));
    assert_int_equal(json_array_size(before), 3);
    assert_true(say(&face, 1, "{\"do\":\"zoom\",\"by\":2,\"at\":[0.45,0.4]}"));
    assert_true(say(&face, 1, "{\"do\":\"probe\",\"at\":[0.45,0.4]}"));
    const json_t *after = json_object_get(last(&face, "probe"), "world");
    for (size_t i = 0; i < 3; i++)
        assert_true(fabs(json_number_value(json_array_get(before, i)) - json_number_value(json_array_get(after, i))) < 1e-6);
    assert_true(say(&face, 1, "{\"do\":\"focus\",\"at\":[0.45,0.4]}"));
    const json_t *focal = part(&face, "camera", "camera-focal-point");
    for (size_t i = 0; i < 3; i++)
        assert_true(fabs(json_number_value(json_array_get(before, i)) - json_number_value(json_array_get(focal, i))) < 1e-6);
    json_decref(before);
    finish(&face);
}

static size_t downloaded(struct face *face, char bytes[64], const char *name)
{
    const json_t *event = last(face, "download");
    const char *type, *url = json_string_value(json_object_get(event, "url"));
    char kept[128];
    uint64_t size;
    assert_non_null(url);
    assert_string_equal(json_string_value(json_object_get(event, "name")), name);
    int fd = session_download(face->session, (unsigned)atoi(url + strlen("download/")), kept, &type, &size);
    assert_true(fd >= 0);
    assert_string_equal(kept, name);
    assert_true(pread(fd, bytes, 64, 0) > 8);
    close(fd);
    return size;
}

static void test_downloads(void **state)
{
    (void)state;
    struct face face;
    char bytes[64], kept[128];
    const char *type;
    uint64_t size;
    start(&face);
    say(&face, 1, "{\"do\":\"export\"}");
    downloaded(&face, bytes, "transfer.json");
    assert_int_equal(bytes[0], '[');
    say(&face, 1, "{\"do\":\"scene\"}");
    downloaded(&face, bytes, "scene.json");
    assert_int_equal(bytes[0], '{');
    say(&face, 1, "{\"do\":\"picture\",\"size\":[120,80],\"background\":false,\"id\":5}");
    session_settle(face.session, true);
    downloaded(&face, bytes, "picture.png");
    assert_memory_equal(bytes, "\x89PNG", 4);
    assert_int_equal(bytes[19], 120);
    assert_int_equal(bytes[25], 6); /* with alpha */
    assert_int_equal(json_integer_value(json_object_get(last(&face, "download"), "id")), 5);
    say(&face, 1, "{\"do\":\"movie\",\"size\":[64,48],\"frames\":5,\"degrees\":360}");
    session_settle(face.session, true);
    downloaded(&face, bytes, "turn.webp");
    assert_memory_equal(bytes, "RIFF", 4);
    assert_memory_equal(bytes + 8, "WEBPVP8X", 8);
    say(&face, 1, "{\"do\":\"movie\",\"size\":[64,48],\"frames\":3,\"degrees\":90,\"format\":\"png\",\"background\":false}");
    session_settle(face.session, true);
    downloaded(&face, bytes, "turn.zip");
    assert_memory_equal(bytes, "PK\3\4", 4);
    assert_memory_equal(bytes + 30, "turn_0000.png\x89PNG", 17); /* stored, after the header of its entry */
    for (int i = 0; i < 8; i++)
        say(&face, 1, "{\"do\":\"export\"}");
    assert_true(session_download(face.session, 1, kept, &type, &size) < 0); /* eight newer ones came */
    assert_true(session_download(face.session, 0, kept, &type, &size) < 0);
    assert_true(session_download(face.session, 99, kept, &type, &size) < 0);
    finish(&face);
}

static void test_cancel(void **state)
{
    (void)state;
    struct face face;
    start(&face);
    say(&face, 1, "{\"do\":\"hold\"}"); /* so that it cannot be drawn yet */
    assert_true(say(&face, 1, "{\"do\":\"movie\",\"size\":[64,48],\"frames\":3600,\"degrees\":360,\"id\":8}"));
    assert_true(say(&face, 1, "{\"do\":\"picture\",\"size\":[32,32],\"id\":9}"));
    assert_true(say(&face, 1, "{\"do\":\"cancel\",\"what\":\"movie\"}"));
    say(&face, 1, "{\"do\":\"release\"}");
    session_settle(face.session, true);
    assert_int_equal(json_integer_value(json_object_get(last(&face, "download"), "id")), 9); /* the picture was not meant */
    assert_int_equal(json_integer_value(json_object_get(last(&face, "error"), "id")), 8);
    assert_string_equal(json_string_value(json_object_get(last(&face, "error"), "code")), "cancelled");
    finish(&face);
}

/* It ends in the midst of whatever is under way. */
static void test_ends_at_any_time(void **state)
{
    (void)state;
    for (int i = 0; i < 6; i++) {
        struct face face;
        start(&face);
        say(&face, 1, "{\"do\":\"size\",\"size\":[512,512]}");
        say(&face, 1, "{\"do\":\"movie\",\"size\":[64,48],\"frames\":3600,\"degrees\":360}");
        usleep((useconds_t)i * 15000);
        finish(&face);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hello),     cmocka_unit_test(test_good_commands), cmocka_unit_test(test_probe_world),   cmocka_unit_test(test_bad_commands),
        cmocka_unit_test(test_undo),      cmocka_unit_test(test_merging),         cmocka_unit_test(test_reset_and_views),
        cmocka_unit_test(test_zoom_and_focus_at), cmocka_unit_test(test_downloads), cmocka_unit_test(test_cancel),
        cmocka_unit_test(test_ends_at_any_time),
        cmocka_unit_test(test_final),     cmocka_unit_test(test_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
