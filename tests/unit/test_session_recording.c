/* SPDX-License-Identifier: MIT */
/* Recordings of the viewer's session: what comes of them is what came of the commands. */
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <nifti/nifti1.h>

#include "record.h"
#include "session_face.h"

static bool open_recorded(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    const struct recording *recording = user;
    bool fine = session_open_snapshot(recording->scene, opened, progress, error);
    opened->fit_camera = recording->fitted;
    return fine;
}

/* A volume with a file, for a recording tells a path. */
static bool open_file(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    const char *path = user;
    if (!open_computed(NULL, opened, progress, error))
        return false;
    snprintf(opened->scene.source.path, sizeof opened->scene.source.path, "%s", path);
    return pel_write_volume(path, &opened->volume, NULL, error);
}

static void test_replay(void **state)
{
    (void)state;
    char folder[] = "/tmp/pellucid-session-XXXXXX", path[256], record_path[256];
    struct face face;
    struct recording recording;
    struct pel_error error = PEL_ERROR_INIT;
    size_t size;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a.nrrd", folder);
    snprintf(record_path, sizeof record_path, "%s/record", folder);
    FILE *record = fopen(record_path, "w");
    start_with(&face, NULL, record, open_file, path);
    assert_true(say(&face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
    for (size_t i = 0; good_commands[i]; i++)
        if (!strstr(good_commands[i], "list")) /* of which there is no folder */
            assert_true(say(&face, 1, good_commands[i]));
    assert_false(say(&face, 1, "{\"do\":\"zoom\",\"by\":-1}")); /* a refused one is recorded, and refused again */
    for (int i = 2; i < 70; i++) {                              /* pages come and go */
        assert_true(say(&face, i, "{\"do\":\"hello\",\"size\":[96,64]}"));
        session_leave(face.session, i);
    }
    void *picture = rest(&face, &size);
    finish(&face);
    fclose(record);
    if (!recording_read(record_path, &recording, &error))
        fail_msg("%s", error.message);
    assert_non_null(recording.scene);
    assert_int_equal(recording.error_count, 1);
    assert_string_equal(recording.errors[0].command, "zoom");
    start_with(&face, NULL, NULL, open_recorded, &recording);
    for (size_t i = 0; i < recording.count; i++)
        if (recording.commands[i].command)
            session_command(face.session, recording.commands[i].client, recording.commands[i].command);
        else
            session_leave(face.session, recording.commands[i].client);
    assert_true(same(&face, picture, size));
    assert_int_equal(errors(&face), 1);
    finish(&face);
    recording_finish(&recording);
    free(picture);
    record = fopen(record_path, "w");
    fputs("{\"pellucid-recording\": 1, \"files\": []}\n{\"at_ms\": 1, \"client\": 0, \"command\": {}}\n", record);
    fclose(record);
    assert_false(recording_read(record_path, &recording, &error));
    assert_non_null(strstr(error.message, "line 2"));
    unlink(path);
    unlink(record_path);
    rmdir(folder);
}

/* A NIfTI pair whose samples come from a pipe: it is read as long as the test likes. */
struct slow {
    char header[96], samples[96];
};

enum { SIDE = 12 };

static void write_samples(int fd)
{
    unsigned char bytes[SIDE * SIDE * SIDE];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (unsigned char)(i * 7 % 251);
    assert_int_equal(write(fd, bytes, sizeof bytes), sizeof bytes);
    close(fd);
}

static void make_slow(struct files *f, struct slow *slow)
{
    nifti_1_header header = {
        .sizeof_hdr = 348, .dim = { 3, SIDE, SIDE, SIDE }, .datatype = 2, .bitpix = 8, .pixdim = { 1, 1, 1, 1 }, .magic = "ni1"
    };
    snprintf(slow->header, sizeof slow->header, "%s/slow.hdr", f->folder);
    snprintf(slow->samples, sizeof slow->samples, "%s/slow.img", f->folder);
    FILE *file = fopen(slow->header, "wb");
    assert_int_equal(fwrite(&header, 1, sizeof header, file), 348);
    fclose(file);
    assert_int_equal(mkfifo(slow->samples, 0600), 0);
}

/* Whoever reads them is at it from here on. */
static void feed(const struct slow *slow)
{
    int fd = open(slow->samples, O_WRONLY);
    assert_true(fd >= 0);
    write_samples(fd);
}

static void cancel(struct files *f, const struct slow *slow)
{
    int fd = open(slow->samples, O_WRONLY);
    assert_true(fd >= 0);
    assert_true(say(&f->face, 1, "{\"do\":\"cancel\"}"));
    close(fd);
}

/* Commands that come while a file is read, and what comes of them. */
static void work_meanwhile(struct files *f, const struct slow *slow)
{
    static const char turn[] = "{\"do\":\"rotate\",\"by\":[0.1,0]}", roll[] = "{\"do\":\"roll\",\"by\":20}", undo[] = "{\"do\":\"undo\"}";
    show(f, f->a);
    assert_true(say_of(f, "{\"do\":\"open\",\"path\":\"%s\"}", slow->header));
    assert_true(say(&f->face, 1, turn));
    assert_false(say(&f->face, 1, undo));
    assert_false(say_of(f, "{\"do\":\"open\",\"path\":\"%s\"}", f->b));
    feed(slow);
    assert_int_equal(steps(f, "undo"), 2);
    assert_true(say(&f->face, 1, roll));
    show(f, f->b);
    assert_true(say(&f->face, 1, undo));
    assert_true(say(&f->face, 1, turn));
    feed(slow);
    assert_int_equal(steps(f, "undo"), 3);
    assert_true(say_of(f, "{\"do\":\"open\",\"path\":\"%s\"}", slow->header));
    assert_true(say(&f->face, 1, turn));
    cancel(f, slow);
    assert_int_equal(steps(f, "undo"), 4);
    assert_string_equal(json_string_value(json_object_get(last(&f->face, "error"), "code")), "cancelled");
}

/* A recording tells what a command found, however long files took to be read. */
static void test_replay_of_slow_files(void **state)
{
    (void)state;
    struct files f;
    struct slow slow;
    struct recording recording;
    struct pel_error error = PEL_ERROR_INIT;
    char path[96];
    size_t size;
    make(&f);
    make_slow(&f, &slow);
    snprintf(path, sizeof path, "%s/record", f.folder);
    FILE *file = fopen(path, "w");
    start_with(&f.face, (const char *const[]) { f.folder, slow.header, NULL }, file, NULL, NULL);
    assert_true(say(&f.face, 1, "{\"do\":\"hello\",\"size\":[96,64]}"));
    work_meanwhile(&f, &slow);
    void *picture = rest(&f.face, &size);
    finish(&f.face);
    fclose(file);
    unlink(slow.samples);
    write_samples(open(slow.samples, O_WRONLY | O_CREAT, 0600)); /* as a file, at another pace */
    if (!recording_read(path, &recording, &error))
        fail_msg("%s", error.message);
    start_with(&f.face, (const char *const[]) { f.folder, slow.header, NULL }, NULL, NULL, NULL);
    for (size_t i = 0; i < recording.count; i++) {
        if (recording.commands[i].client)
            assert_true(session_command(f.face.session, recording.commands[i].client, recording.commands[i].command));
        session_settle(f.face.session, false);
    }
    assert_true(same(&f.face, picture, size));
    assert_int_equal(steps(&f, "undo"), 4);
    assert_int_equal(errors(&f.face), 0);
    recording_finish(&recording);
    free(picture);
    unlink(path);
    unlink(slow.header);
    unlink(slow.samples);
    done(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_replay),
        cmocka_unit_test(test_replay_of_slow_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
