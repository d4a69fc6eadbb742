/* SPDX-License-Identifier: MIT */
/* What holds for every format: how it is found, what is said where it is not, and that an output file appears whole or not at all. */
#include "support.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static void table(void **state)
{
    (void)state;
    size_t count = 0;
    while (pel_format_at(count)) {
        const struct pel_format_info *info = pel_format_at(count++);
        assert_true(info->name[0] && info->summary[0] && info->endings[0] == '.');
        assert_true(info->reads || info->writes);
    }
    assert_true(count >= 4);
    assert_null(pel_format_at(count + 100));
}

static void unknown_files(void **state)
{
    (void)state;
    write_text(scratch("a.dat"), "nothing that anybody knows");
    expect_bad(scratch("a.dat"), "no format that is known");
    expect_bad(scratch("a.dat"), "nrrd");
    write_text(scratch("a.dat"), "");
    expect_bad(scratch("a.dat"), "is empty");
    expect_bad(scratch("not there.nrrd"), "No such file");
    /* The name says what the content does not: the format's own words tell what is wrong. */
    write_text(scratch("a.nrrd"), "NR is not enough");
    expect_bad(scratch("a.nrrd"), "does not begin with NRRD");
}

static void arrays_by_name(void **state)
{
    (void)state;
    struct pel_volume v;
    struct pel_file_info info;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    fill_volume(&v, PEL_U8, 1);
    snprintf(v.name, sizeof v.name, "density");
    assert_true(pel_write_volume(scratch("n.nrrd"), &v, NULL, NULL));
    pel_volume_finish(&v);
    params.array = "density";
    assert_true(pel_read_volume(scratch("n.nrrd"), &params, &v, &info, NULL));
    assert_int_equal(info.array_count, 1);
    assert_string_equal(info.arrays[0].name, "density");
    pel_volume_finish(&v);
    params.array = "speed";
    assert_false(pel_read_volume(scratch("n.nrrd"), &params, &v, &info, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "density"));
    assert_null(v.data);
}

static bool stop_at_once(void *user, double fraction)
{
    assert_true(fraction >= 0 && fraction <= 1);
    ++*(int *)user;
    return false;
}

static void cancelled_reading(void **state)
{
    (void)state;
    struct pel_volume v;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_read_params params = PEL_READ_PARAMS_INIT;
    int calls = 0;
    fill_volume(&v, PEL_F64, 1);
    assert_true(pel_write_volume(scratch("c.nrrd"), &v, NULL, NULL));
    pel_volume_finish(&v);
    params.progress = (struct pel_progress){ stop_at_once, &calls };
    pel_volume_init(&v);
    assert_false(pel_read_volume(scratch("c.nrrd"), &params, &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_CANCELLED);
    assert_int_equal(calls, 1);
    assert_null(v.data);
}

static size_t files_in_scratch(void)
{
    size_t count = 0;
    DIR *dir = opendir(scratch("."));
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        count += entry->d_name[0] != '.' || strlen(entry->d_name) > 2;
    closedir(dir);
    return count;
}

static void cancelled_writing_leaves_nothing(void **state)
{
    (void)state;
    static const char *const names[] = { "gone.nrrd", "gone.nhdr", "gone.mha", "gone.mhd", "gone.raw" };
    struct pel_volume v;
    fill_volume(&v, PEL_F64, 1);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (int compress = 0; compress < 2; compress++) {
            struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
            struct pel_error error = PEL_ERROR_INIT;
            int calls = 0;
            size_t before = files_in_scratch();
            params.compress = compress;
            params.progress = (struct pel_progress){ stop_at_once, &calls };
            assert_false(pel_write_volume(scratch(names[i]), &v, &params, &error));
            assert_int_equal(error.code, PEL_ERROR_CANCELLED);
            assert_int_equal(files_in_scratch(), before);
        }
    pel_volume_finish(&v);
}

/* Data beside a detached header are replaced only where the header that is there names them. */
static void foreign_data_stay(void **state)
{
    (void)state;
    static const char *const names[] = { "own.nhdr", "own.mhd" }, *const data[] = { "own.raw.gz", "own.zraw" };
    struct pel_volume v;
    fill_volume(&v, PEL_U8, 1);
    for (int i = 0; i < 2; i++)
        for (int compress = 0; compress < 2; compress++) {
            struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
            struct pel_error error = PEL_ERROR_INIT;
            const char *beside = compress ? data[i] : "own.raw";
            size_t size;
            params.compress = compress;
            write_text(scratch(beside), "foreign");
            assert_false(pel_write_volume(scratch(names[i]), &v, &params, &error));
            assert_int_equal(error.code, PEL_ERROR_IO);
            assert_non_null(strstr(error.message, beside));
            assert_int_not_equal(access(scratch(names[i]), F_OK), 0);
            unsigned char *bytes = read_file(scratch(beside), &size);
            assert_int_equal(size, 7);
            assert_memory_equal(bytes, "foreign", 7);
            free(bytes);
            unlink(scratch(beside));
            for (int again = 0; again < 2; again++)
                assert_true(pel_write_volume(scratch(names[i]), &v, &params, &error));
            unlink(scratch(names[i]));
            unlink(scratch(beside));
        }
    pel_volume_finish(&v);
}

static bool kill_it(void *user, double fraction)
{
    (void)user;
    (void)fraction;
    raise(SIGKILL);
    return true;
}

/* Even a killed program leaves nothing behind where the file system has unnamed files. */
static void killed_writing_leaves_the_old_file(void **state)
{
    (void)state;
    struct pel_volume v;
    write_text(scratch("old.nrrd"), "old");
    size_t before = files_in_scratch(), size;
    fill_volume(&v, PEL_U8, 1);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct pel_write_params params = PEL_WRITE_PARAMS_INIT;
        params.progress = (struct pel_progress){ kill_it, NULL };
        pel_write_volume(scratch("old.nrrd"), &v, &params, NULL);
        _exit(0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    unsigned char *bytes = read_file(scratch("old.nrrd"), &size);
    assert_string_equal((char *)bytes, "old");
    free(bytes);
    assert_true(files_in_scratch() <= before + 1);
    pel_volume_finish(&v);
}

static void targets(void **state)
{
    (void)state;
    struct pel_volume v, again;
    struct pel_error error = PEL_ERROR_INIT;
    struct stat st;
    fill_volume(&v, PEL_U8, 1);
    /* Through a link, and with the mode that the file had. */
    write_text(scratch("real.nrrd"), "old");
    assert_int_equal(chmod(scratch("real.nrrd"), 0640), 0);
    assert_int_equal(symlink("real.nrrd", scratch("link.nrrd")), 0);
    assert_true(pel_write_volume(scratch("link.nrrd"), &v, NULL, NULL));
    assert_int_equal(lstat(scratch("link.nrrd"), &st), 0);
    assert_true(S_ISLNK(st.st_mode));
    assert_int_equal(stat(scratch("real.nrrd"), &st), 0);
    assert_int_equal(st.st_mode & 0777, 0640);
    read_ok(scratch("real.nrrd"), &again, NULL);
    expect_same(&v, &again);
    pel_volume_finish(&again);
    assert_false(pel_write_volume(scratch("no-folder/x.nrrd"), &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_IO);
    assert_false(pel_write_volume(scratch("x.bmp"), &v, NULL, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, ".nrrd"));
    /* A file that cannot take another byte. */
    if (access("/dev/full", W_OK) == 0) {
        assert_int_equal(symlink("/dev/full", scratch("full.nrrd")), 0);
        assert_false(pel_write_volume(scratch("full.nrrd"), &v, NULL, &error));
        assert_int_equal(error.code, PEL_ERROR_IO);
        assert_non_null(strstr(error.message, "No space"));
    }
    pel_volume_finish(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table),
        cmocka_unit_test(unknown_files),
        cmocka_unit_test(arrays_by_name),
        cmocka_unit_test(cancelled_reading),
        cmocka_unit_test(cancelled_writing_leaves_nothing),
        cmocka_unit_test(foreign_data_stay),
        cmocka_unit_test(killed_writing_leaves_the_old_file),
        cmocka_unit_test(targets),
    };
    return cmocka_run_group_tests_name("files", tests, make_scratch, remove_scratch);
}
