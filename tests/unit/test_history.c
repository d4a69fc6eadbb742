/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "history.h"

static void expect(char *text, const char *wanted)
{
    assert_non_null(text);
    assert_string_equal(text, wanted);
    free(text);
}

static void test_there_and_back(void **state)
{
    (void)state;
    struct history h = { .client = 0 };
    assert_null(history_undo(&h, strdup("a")));
    assert_null(history_redo(&h, strdup("a")));
    history_push(&h, 1, 0, strdup("a"));
    history_push(&h, 1, 0, strdup("b"));
    expect(history_undo(&h, strdup("c")), "b");
    expect(history_undo(&h, strdup("b")), "a");
    assert_null(history_undo(&h, strdup("a")));
    expect(history_redo(&h, strdup("a")), "b");
    assert_int_equal(h.undo.count, 1);
    assert_int_equal(h.redo.count, 1);
    history_push(&h, 1, 0, strdup("b"));
    assert_int_equal(h.redo.count, 0); /* what was undone is gone */
    history_finish(&h);
}

static void test_gestures(void **state)
{
    (void)state;
    struct history h = { .client = 0 };
    assert_true(history_begins(&h, 1, 7));
    history_push(&h, 1, 7, strdup("a"));
    assert_false(history_begins(&h, 1, 7));
    assert_true(history_begins(&h, 1, 8));
    assert_true(history_begins(&h, 2, 7)); /* another client's */
    assert_true(history_begins(&h, 1, 0)); /* none: each change is a step */
    expect(history_undo(&h, strdup("b")), "a");
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
        history_push(&h, 1, 0, strdup(text));
    }
    assert_int_equal(h.undo.count, HISTORY_MOST_STEPS);
    expect(history_undo(&h, strdup("now")), text);
    size_t large = HISTORY_MOST_BYTES / 2;
    for (int i = 0; i < 3; i++) {
        char *whole = malloc(large + 1);
        memset(whole, 'x', large);
        whole[large] = 0;
        history_push(&h, 1, 0, whole);
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
