/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "history.h"

static struct history_step step(const char *text)
{
    return (struct history_step) { .text = strdup(text), .fitted = text[0] == 'a' };
}

static void expect(struct history_step found, const char *wanted)
{
    assert_non_null(found.text);
    assert_string_equal(found.text, wanted);
    assert_int_equal(found.fitted, wanted[0] == 'a');
    free(found.text);
}

static void test_there_and_back(void **state)
{
    (void)state;
    struct history h = { .client = 0 };
    assert_null(history_undo(&h, step("a")).text);
    assert_null(history_redo(&h, step("a")).text);
    history_push(&h, 1, 0, step("a"));
    history_push(&h, 1, 0, step("b"));
    expect(history_undo(&h, step("c")), "b");
    expect(history_undo(&h, step("b")), "a");
    assert_null(history_undo(&h, step("a")).text);
    expect(history_redo(&h, step("a")), "b");
    assert_int_equal(h.undo.count, 1);
    assert_int_equal(h.redo.count, 1);
    history_push(&h, 1, 0, step("b"));
    assert_int_equal(h.redo.count, 0); /* what was undone is gone */
    history_finish(&h);
}

static void test_gestures(void **state)
{
    (void)state;
    struct history h = { .client = 0 };
    assert_true(history_begins(&h, 1, 7));
    history_push(&h, 1, 7, step("a"));
    assert_false(history_begins(&h, 1, 7));
    assert_true(history_begins(&h, 1, 8));
    assert_true(history_begins(&h, 2, 7)); /* another client's */
    assert_true(history_begins(&h, 1, 0)); /* none: each change is a step */
    expect(history_undo(&h, step("b")), "a");
    assert_true(history_begins(&h, 1, 7)); /* a step back ends it */
    history_finish(&h);
}

static void test_bounds(void **state)
{
    (void)state;
    struct history h = { .client = 0 };
    char text[16];
    for (int i = 0; i < HISTORY_MOST_STEPS + 10; i++) {
        snprintf(text, sizeof text, "%d", i);
        history_push(&h, 1, 0, step(text));
    }
    assert_int_equal(h.undo.count, HISTORY_MOST_STEPS);
    expect(history_undo(&h, step("now")), text);
    size_t large = HISTORY_MOST_BYTES / 2;
    for (int i = 0; i < 3; i++) {
        char *whole = malloc(large + 1);
        memset(whole, 'x', large);
        whole[large] = 0;
        history_push(&h, 1, 0, (struct history_step) { .text = whole });
    }
    assert_true(h.undo.bytes <= HISTORY_MOST_BYTES);
    assert_int_equal(h.undo.count, 1);
    history_finish(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_there_and_back),
        cmocka_unit_test(test_gestures),
        cmocka_unit_test(test_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
