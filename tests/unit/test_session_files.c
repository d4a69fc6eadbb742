/* SPDX-License-Identifier: MIT */
/* The viewer's session and its files: steps of undo from one to another, and what may become of a file meanwhile. */
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "downloads.h"
#include "movie.h"
#include "session_face.h"

static void test_open(void **state)
{
    (void)state;
    char folder[] = "/tmp/pellucid-session-XXXXXX", path[256], text[512], outside[256];
    struct pel_volume volume;
    struct face face;
    size_t size;
    assert_non_null(mkdtemp(folder));
    assert_true(compute(&volume, NULL));
    snprintf(path, sizeof path, "%s/a.nrrd", folder);
    assert_true(pel_write_volume(path, &volume, NULL, NULL));
    snprintf(outside, sizeof outside, "%s-b.nrrd", folder);
    assert_true(pel_write_volume(outside, &volume, NULL, NULL));
    pel_volume_finish(&volume);
    start_with(&face, (const char *const[]) { folder, NULL }, NULL, NULL, NULL);
    assert_true(say(&face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
    assert_true(json_is_true(json_object_get(last(&face, "hello"), "empty")));
    assert_false(say(&face, 1, "{\"do\":\"rotate\",\"by\":[0,0]}")); /* nothing is open */
    for (int i = 0; i < 2; i++) {                                    /* answered by another thread, for a disk may be slow */
        snprintf(text, sizeof text, "{\"do\":\"list\",\"path\":\"%s\",\"id\":%d}", i ? "/no/such" : "/", i);
        assert_true(say(&face, 1, text));
        session_settle(face.session, false);
        assert_int_equal(json_integer_value(json_object_get(last(&face, "error"), "id")), i);
        assert_null(last(&face, "files"));
    }
    snprintf(text, sizeof text, "{\"do\":\"list\",\"path\":\"%s\"}", folder);
    assert_true(say(&face, 1, text));
    session_settle(face.session, false);
    assert_int_equal(json_array_size(json_object_get(last(&face, "files"), "entries")), 1);
    assert_true(json_is_null(json_object_get(last(&face, "files"), "parent")));
    snprintf(text, sizeof text, "{\"do\":\"open\",\"path\":\"%s/../%s\",\"id\":9}", folder, strrchr(outside, '/') + 1);
    assert_true(say(&face, 1, text)); /* answered by another thread, too */
    session_settle(face.session, false);
    assert_int_equal(json_integer_value(json_object_get(last(&face, "error"), "id")), 9);
    assert_null(last(&face, "volume"));
    snprintf(text, sizeof text, "{\"do\":\"open\",\"path\":\"%s\"}", path);
    assert_true(say(&face, 1, text));
    void *picture = rest(&face, &size);
    assert_true(say(&face, 1, "{\"do\":\"view\",\"axis\":\"-y\"}"));
    assert_false(same(&face, picture, size));
    assert_true(say(&face, 1, text)); /* again: with all of it chosen anew */
    assert_true(same(&face, picture, size));
    assert_true(say(&face, 1, "{\"do\":\"undo\"}"));
    assert_true(say(&face, 1, "{\"do\":\"undo\"}"));
    assert_true(same(&face, picture, size));
    free(picture);
    finish(&face);
    unlink(path);
    unlink(outside);
    rmdir(folder);
}

static int count(struct files *f, const char *kind)
{
    int found = 0;
    pthread_mutex_lock(&f->face.lock);
    for (size_t i = 0; i < json_array_size(f->face.events); i++)
        found += strcmp(json_string_value(json_object_get(json_array_get(f->face.events, i), "event")), kind) == 0;
    pthread_mutex_unlock(&f->face.lock);
    return found;
}

/* The last picture that was saved, owned. */
static void *saved(struct files *f, uint64_t *size)
{
    const char *type, *url = json_string_value(json_object_get(last(&f->face, "download"), "url"));
    char name[128];
    assert_non_null(url);
    int fd = session_download(f->face.session, (unsigned)atoi(url + strlen("download/")), name, &type, size);
    void *bytes = malloc(*size);
    assert_int_equal(pread(fd, bytes, *size, 0), (ssize_t)*size);
    close(fd);
    return bytes;
}

/* A picture that is saved is of what was open when it was asked for, and comes to its end whatever is opened meanwhile. */
static void test_picture_across_open(void **state)
{
    static const char picture[] = "{\"do\":\"picture\",\"size\":[120,80]}";
    (void)state;
    struct files f;
    uint64_t size, again;
    begin(&f);
    show(&f, f.a);
    assert_true(say(&f.face, 1, picture));
    session_settle(f.face.session, true);
    void *before = saved(&f, &size);
    assert_true(say(&f.face, 1, "{\"do\":\"hold\"}")); /* so that it is not drawn yet */
    assert_true(say(&f.face, 1, picture));
    show(&f, f.b);
    assert_true(say(&f.face, 1, "{\"do\":\"release\"}"));
    session_settle(f.face.session, true);
    assert_int_equal(count(&f, "download"), 2);
    void *after = saved(&f, &again);
    assert_int_equal(again, size);
    assert_memory_equal(after, before, size);
    assert_true(say(&f.face, 1, picture)); /* of the other one */
    session_settle(f.face.session, true);
    free(after);
    after = saved(&f, &again);
    assert_true(again != size || memcmp(after, before, size) != 0);
    assert_int_equal(errors(&f.face), 0);
    free(before);
    free(after);
    done(&f);
}

/* Back in a file `reset` leads to its own start, be that fitted or said by a scene file. */
static void test_reset_across_open(void **state)
{
    static const char reset[] = "{\"do\":\"reset\"}", turn[] = "{\"do\":\"rotate\",\"by\":[0.2,0.1]}", undo[] = "{\"do\":\"undo\"}";
    static const char text[] = "{\"volume\":{\"path\":\"a.nrrd\"},\"camera\":{\"camera-position\":[7,1,2]}}";
    (void)state;
    struct files f;
    char path[256];
    size_t size;
    begin(&f);
    show(&f, f.a);
    void *picture = rest(&f.face, &size);
    assert_true(say(&f.face, 1, turn));
    show(&f, f.b);
    assert_true(say(&f.face, 1, undo));
    assert_false(same(&f.face, picture, size));
    assert_true(say(&f.face, 1, reset));
    assert_true(same(&f.face, picture, size));
    assert_true(say(&f.face, 1, "{\"do\":\"size\",\"size\":[64,96]}"));
    json_t *fitted = json_deep_copy(part(&f.face, "camera", "camera-position"));
    show(&f, f.a);
    assert_true(json_equal(part(&f.face, "camera", "camera-position"), fitted));
    json_decref(fitted);
    snprintf(path, sizeof path, "%s/scene.json", f.folder);
    put(f.folder, "scene.json", 0, text);
    assert_true(say_of(&f, "{\"do\":\"open\",\"path\":\"%s\"}", path));
    json_t *said = json_deep_copy(part(&f.face, "camera", "camera-position"));
    assert_true(json_number_value(json_array_get(said, 0)) == 7);
    show(&f, f.b);
    assert_true(say(&f.face, 1, undo));
    session_settle(f.face.session, true);
    assert_true(say(&f.face, 1, turn));
    assert_false(json_equal(part(&f.face, "camera", "camera-position"), said));
    assert_true(say(&f.face, 1, reset));
    assert_true(json_equal(part(&f.face, "camera", "camera-position"), said));
    assert_int_equal(errors(&f.face), 0);
    json_decref(said);
    unlink(path);
    free(picture);
    done(&f);
}

/* Steps of a file that is gone are left out, and undo and redo go on. */
static void test_undo_to_a_file_that_is_gone(void **state)
{
    (void)state;
    struct files f;
    size_t size;
    begin(&f);
    show(&f, f.a);
    assert_true(say(&f.face, 1, "{\"do\":\"roll\",\"by\":10}"));
    assert_true(say(&f.face, 1, "{\"do\":\"roll\",\"by\":10}"));
    show(&f, f.b);
    void *picture = rest(&f.face, &size);
    assert_true(say(&f.face, 1, "{\"do\":\"roll\",\"by\":10}"));
    assert_int_equal(steps(&f, "undo"), 4);
    unlink(f.a);
    assert_true(say(&f.face, 1, "{\"do\":\"undo\"}"));
    assert_true(same(&f.face, picture, size));
    assert_true(say(&f.face, 1, "{\"do\":\"undo\"}"));
    assert_int_equal(steps(&f, "undo"), 0);
    assert_int_equal(steps(&f, "redo"), 1);
    assert_non_null(strstr(json_string_value(json_object_get(last(&f.face, "error"), "message")), "3 steps of undo are left out"));
    assert_true(same(&f.face, picture, size));
    assert_true(say(&f.face, 1, "{\"do\":\"redo\"}"));
    assert_false(same(&f.face, picture, size));
    assert_true(say(&f.face, 1, "{\"do\":\"undo\"}"));
    assert_true(same(&f.face, picture, size));
    free(picture);
    done(&f);
}

/* While undo reads a file no edit comes between; the hand may go on. */
static void test_edit_while_undo_reads(void **state)
{
    (void)state;
    struct files f;
    begin(&f);
    show(&f, f.a);
    show(&f, f.b);
    unlink(f.a);
    assert_int_equal(mkfifo(f.a, 0600), 0);
    int writer = open(f.a, O_RDWR); /* whoever reads it waits for this one */
    assert_true(writer >= 0);
    assert_true(say(&f.face, 1, "{\"do\":\"undo\"}"));
    assert_false(say(&f.face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"mip\"}}}"));
    assert_false(say(&f.face, 1, "{\"do\":\"undo\"}"));
    assert_false(say(&f.face, 1, "{\"do\":\"redo\"}"));
    assert_true(say(&f.face, 1, "{\"do\":\"rotate\",\"by\":[0.1,0]}"));
    unlink(f.a);
    close(writer);
    assert_int_equal(steps(&f, "undo"), 0);
    assert_int_equal(steps(&f, "redo"), 0);
    assert_true(say(&f.face, 1, "{\"do\":\"set\",\"scene\":{\"render\":{\"mode\":\"mip\"}}}"));
    assert_int_equal(steps(&f, "undo"), 1);
    done(&f);
}

/* A name that JSON cannot say is reached by a link alone: then the link is what scenes tell. */
static void test_names_that_are_no_text(void **state)
{
    (void)state;
    struct files f;
    char bad[256], bad_folder[256], link_to_folder[256];
    begin(&f);
    snprintf(bad, sizeof bad, "%s/\xff.nrrd", f.folder);
    snprintf(bad_folder, sizeof bad_folder, "%s/\xfe", f.folder);
    snprintf(link_to_folder, sizeof link_to_folder, "%s/folder", f.folder);
    assert_int_equal(rename(f.a, bad), 0);
    assert_int_equal(symlink(bad, f.a), 0);
    assert_int_equal(mkdir(bad_folder, 0700), 0);
    assert_int_equal(symlink(bad_folder, link_to_folder), 0);
    show(&f, f.a);
    assert_true(say(&f.face, 1, "{\"do\":\"roll\",\"by\":10}"));
    assert_string_equal(json_string_value(part(&f.face, "volume", "path")), f.a);
    show(&f, f.b);
    assert_true(say(&f.face, 1, "{\"do\":\"undo\"}"));
    assert_string_equal(json_string_value(part(&f.face, "volume", "path")), f.a);
    assert_int_equal(errors(&f.face), 0);
    assert_true(say_of(&f, "{\"do\":\"list\",\"path\":\"%s\"}", f.folder));
    session_settle(f.face.session, false);
    assert_int_equal(json_array_size(json_object_get(last(&f.face, "files"), "entries")), 3); /* what can be asked for */
    assert_true(say_of(&f, "{\"do\":\"list\",\"path\":\"%s\"}", link_to_folder));
    session_settle(f.face.session, false);
    assert_int_equal(errors(&f.face), 1);
    unlink(link_to_folder);
    unlink(bad);
    rmdir(bad_folder);
    done(&f);
}

static void test_downloads_expire(void **state)
{
    (void)state;
    struct downloads downloads = { .last = 0 };
    int fd = download_file(NULL);
    unsigned number = downloads_add(&downloads, fd, "a", "text/plain", 1000)->number;
    downloads_expire(&downloads, 1000 + DOWNLOADS_MS);
    assert_non_null(downloads_find(&downloads, number, 1000 + DOWNLOADS_MS));
    downloads_expire(&downloads, 1001 + DOWNLOADS_MS);
    assert_null(downloads_find(&downloads, number, 1000));
    assert_int_equal(close(fd), -1); /* closed already */
    downloads_finish(&downloads);
}

static json_t *entry(struct files *f, const char *name)
{
    json_t *entries = json_object_get(last(&f->face, "files"), "entries"), *found = NULL;
    for (size_t i = 0; i < json_array_size(entries); i++)
        if (strcmp(json_string_value(json_object_get(json_array_get(entries, i), "name")), name) == 0)
            found = json_array_get(entries, i);
    return found;
}

static void drop(const char *folder, const char *const *names)
{
    char path[2048];
    for (; *names; names++) {
        snprintf(path, sizeof path, "%s/%s", folder, *names);
        assert_int_equal(unlink(path), 0);
    }
    assert_int_equal(rmdir(folder), 0);
}

static void assert_refused(struct files *f, const char *path, const char *why)
{
    int before = errors(&f->face);
    assert_true(say_of(f, "{\"do\":\"open\",\"path\":\"%s\",\"id\":7}", path));
    session_settle(f->face.session, false);
    assert_int_equal(errors(&f->face), before + 1);
    json_t *error = last(&f->face, "error");
    assert_non_null(strstr(json_string_value(json_object_get(error, "message")), why));
    assert_int_equal(json_integer_value(json_object_get(error, "_to")), 1); /* who asked */
    assert_int_equal(json_integer_value(json_object_get(error, "id")), 7);
    assert_string_equal(json_string_value(json_object_get(error, "do")), "open");
    assert_null(json_object_get(error, "code"));
}

/* What is named at the start is read with whatever it names, as the first file is; what else lies beside it is not. A pipe would keep its
 * reader for ever. */
static void test_named_and_refused(void **state)
{
    static const char *const names[] = { "head.nhdr", "other.nhdr", "head.raw", "scene.json", NULL };
    static const char header[] = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: head.raw\n";
    (void)state;
    struct files f;
    char outside[] = "/tmp/pellucid-session-XXXXXX", named[64], scene_file[64], other[64], pipe_path[256], leak[256], text[256];
    make(&f);
    assert_non_null(mkdtemp(outside));
    put(outside, "head.nhdr", 0, header);
    put(outside, "other.nhdr", 0, header);
    put(outside, "head.raw", 0, "abcdefghijklmnopqrstuvwx");
    put(outside, "scene.json", 0, "{\"volume\":{\"path\":\"other.nhdr\"}}");
    snprintf(named, sizeof named, "%s/head.nhdr", outside);
    snprintf(other, sizeof other, "%s/other.nhdr", outside);
    snprintf(scene_file, sizeof scene_file, "%s/scene.json", outside);
    snprintf(pipe_path, sizeof pipe_path, "%s/pipe.nrrd", f.folder);
    snprintf(leak, sizeof leak, "%s/leak.json", f.folder);
    snprintf(text, sizeof text, "{\"volume\":{\"path\":\"%s\"}}", other);
    put(f.folder, "leak.json", 0, text);
    start_with(&f.face, (const char *const[]) { f.folder, named, scene_file, NULL }, NULL, NULL, NULL);
    assert_true(say(&f.face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
    assert_true(say(&f.face, 2, "{\"do\":\"hello\",\"size\":[96,64]}"));
    show(&f, named);
    assert_true(say_of(&f, "{\"do\":\"open\",\"path\":\"%s\"}", scene_file));
    session_settle(f.face.session, false);
    assert_string_equal(json_string_value(json_object_get(last(&f.face, "volume"), "path")), other);
    assert_int_equal(errors(&f.face), 0);
    assert_refused(&f, other, "may be opened");
    assert_refused(&f, leak, "may be opened");
    assert_refused(&f, outside, "may be opened");
    assert_int_equal(mkfifo(pipe_path, 0600), 0);
    assert_refused(&f, pipe_path, "neither a file nor a folder");
    show(&f, f.b);
    unlink(pipe_path);
    unlink(leak);
    drop(outside, names);
    done(&f);
}

/* A file of nothing, as long as it is asked to be. */
static int hollow(off_t size)
{
    int fd = download_file(NULL);
    assert_int_equal(ftruncate(fd, size), 0);
    return fd;
}

/* What is kept has room for so much; the oldest goes first, the newest never. */
static void test_downloads_bytes(void **state)
{
    (void)state;
    const off_t some = (off_t)(DOWNLOADS_BYTES / 8 * 3);
    struct downloads downloads = { .last = 0 };
    unsigned numbers[4];
    for (int i = 0; i < 4; i++)
        numbers[i] = downloads_add(&downloads, hollow(i == 2 ? 100 : some), "a", "text/plain", 0)->number;
    assert_null(downloads_find(&downloads, numbers[0], 0));
    for (int i = 1; i < 4; i++)
        assert_non_null(downloads_find(&downloads, numbers[i], 0));
    unsigned newest = downloads_add(&downloads, hollow(3 * some), "a", "text/plain", 0)->number;
    assert_non_null(downloads_find(&downloads, newest, 0));
    for (int i = 0; i < 4; i++)
        assert_null(downloads_find(&downloads, numbers[i], 0));
    downloads_finish(&downloads);
}

/* One that grows beyond its share ends with an error. */
static void test_movie_too_large(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_image image;
    struct encoder *encoder = encoder_create(&error);
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 16, 16, false, &error));
    int fd = open("/dev/null", O_RDONLY); /* the movie's file gets the same number */
    close(fd);
    struct movie *movie = movie_begin(movie_format("png"), (const int[2]) { 16, 16 }, &error);
    assert_non_null(movie);
    assert_true(movie_add(movie, encoder, &image, NULL, &error));
    assert_int_equal(ftruncate(fd, (off_t)(DOWNLOADS_BYTES / 2 + 1)), 0);
    assert_false(movie_add(movie, encoder, &image, NULL, &error));
    assert_non_null(strstr(error.message, "after 2 frames"));
    movie_destroy(movie);
    encoder_destroy(encoder);
    pel_image_finish(&image);
}

static bool three_rows(void *user, double fraction)
{
    (void)fraction;
    return ++*(int *)user <= 3;
}

/* A picture is packed no further than it is wanted. */
static void test_packing_stops(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_image image;
    struct encoder *encoder = encoder_create(&error);
    const void *bytes;
    size_t size;
    int rows = 0;
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, 16, 16, false, &error));
    assert_false(encode_png(encoder, &image, NULL, false, &(struct pel_progress) { three_rows, &rows }, &bytes, &size, &error));
    assert_int_equal(error.code, PEL_ERROR_CANCELLED);
    assert_int_equal(rows, 4);
    assert_true(encode_png(encoder, &image, NULL, false, NULL, &bytes, &size, &error));
    encoder_destroy(encoder);
    pel_image_finish(&image);
}

/* A list tells which folders are opened as a whole. */
static void test_series(void **state)
{
    static const char *const names[] = { "named", "unnamed", "one", "other" };
    static const char *const files[][3] = { { "1.dcm", "2.dcm" }, { "IM0001", "1.2.840.7" }, { "1.tif", "text" }, { "a.nrrd", "b.nrrd" } };
    struct files f;
    char path[4][256];
    (void)state;
    begin(&f);
    for (int i = 0; i < 4; i++) {
        snprintf(path[i], sizeof path[i], "%s/%s", f.folder, names[i]);
        assert_int_equal(mkdir(path[i], 0700), 0);
        for (int k = 0; k < 2; k++)
            put(path[i], files[i][k], 128, i == 1 ? "DICM" : "none");
    }
    assert_true(say_of(&f, "{\"do\":\"list\",\"path\":\"%s\"}", f.folder));
    session_settle(f.face.session, false);
    assert_true(json_is_false(json_object_get(last(&f.face, "files"), "series")));
    assert_true(json_is_false(json_object_get(entry(&f, "a.nrrd"), "series")));
    for (int i = 0; i < 4; i++)
        assert_int_equal(json_is_true(json_object_get(entry(&f, names[i]), "series")), i < 2);
    assert_true(say_of(&f, "{\"do\":\"list\",\"path\":\"%s\"}", path[1]));
    session_settle(f.face.session, false);
    assert_true(json_is_true(json_object_get(last(&f.face, "files"), "series")));
    for (int i = 0; i < 4; i++)
        drop(path[i], files[i]);
    done(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_open),
        cmocka_unit_test(test_picture_across_open),
        cmocka_unit_test(test_undo_to_a_file_that_is_gone),
        cmocka_unit_test(test_edit_while_undo_reads),
        cmocka_unit_test(test_names_that_are_no_text),
        cmocka_unit_test(test_downloads_expire),
        cmocka_unit_test(test_series),
        cmocka_unit_test(test_downloads_bytes),
        cmocka_unit_test(test_movie_too_large),
        cmocka_unit_test(test_packing_stops),
        cmocka_unit_test(test_reset_across_open),
        cmocka_unit_test(test_named_and_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
