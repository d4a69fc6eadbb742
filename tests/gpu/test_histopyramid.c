/* SPDX-License-Identifier: MIT */
/* The HistoPyramid: every output of many items is found again, whatever the counts, the number of items and the items that give nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "histopyramid.h"
#include "shader_source.h"

static struct pel_device *device;

static int open_device(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    device = pel_device_create(-1, NULL, &error);
    if (!device)
        print_message("SKIPPED: %s\n", error.message);
    return 0;
}

static int close_device(void **state)
{
    (void)state;
    pel_device_destroy(device);
    return 0;
}

/* histopyramid.glsl and a main of our own, which writes what it finds. */
static GLuint finder(void)
{
    static const char *const body = "layout(local_size_x = 64) in;\n"
                                    "layout(std430, binding = 2) writeonly buffer Found { uvec2 found[]; };\n"
                                    "void main()\n"
                                    "{\n"
                                    "    uint i = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;\n"
                                    "    if (i < histo_total)\n"
                                    "        found[i] = histo_find(i);\n"
                                    "}\n";
    struct pel_error error = PEL_ERROR_INIT;
    char *text = pel_shader_compose("histopyramid.glsl", "", &error);
    if (!text)
        fail_msg("%s", error.message);
    const char *parts[2] = { text, body };
    GLuint program = glCreateShaderProgramv(GL_COMPUTE_SHADER, 2, parts);
    char log[512] = "";
    glGetProgramInfoLog(program, sizeof log, NULL, log);
    if (log[0])
        fail_msg("%s", log);
    free(text);
    return program;
}

enum counts { NONE, ONES, SPARSE, MIXED, LAST, COUNTS };

static uint8_t count_of(enum counts kind, size_t i, size_t items)
{
    uint32_t h = (uint32_t)i * 2654435761u;
    h ^= h >> 15;
    switch (kind) {
    case ONES:
        return 1;
    case SPARSE:
        return h % 97 == 0;
    case MIXED:
        return h % 5 == 0 ? 255 : (uint8_t)(h >> 8) % 7;
    case LAST:
        return i == items - 1 ? 200 : 0;
    default:
        return 0;
    }
}

/* Every output, in the items' order. */
static void check_outputs(struct pel_histopyramid *p, GLuint program, const uint8_t *counts, const char *what)
{
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_buffer found = { 0 };
    size_t total = p->total, number = 0;
    uint32_t (*places)[2] = malloc((total + 1) * sizeof *places);
    assert_non_null(places);
    assert_true(pel_buffer_fill(device, &found, NULL, (total + 1) * sizeof *places, &error));
    glUseProgram(program);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, found.name);
    pel_histopyramid_bind(p);
    pel_histopyramid_dispatch(total);
    glGetNamedBufferSubData(found.name, 0, (GLsizeiptr)(total * sizeof *places), places);
    for (uint32_t i = 0; i < p->items; i++)
        for (uint32_t k = 0; k < counts[i]; k++, number++)
            if (places[number][0] != i || places[number][1] != k)
                fail_msg("%s: output %zu is %u of item %u, not %u of %u", what, number, places[number][1], places[number][0], k, i);
    assert_int_equal(number, total);
    pel_buffer_destroy(device, &found);
    free(places);
}

static void check(struct pel_programs *programs, struct pel_histopyramid *p, GLuint program, size_t items, enum counts kind)
{
    struct pel_error error = PEL_ERROR_INIT;
    size_t room = (items + PEL_HISTO_GROUP - 1) / PEL_HISTO_GROUP * PEL_HISTO_GROUP;
    uint8_t *counts = calloc(room, 1);
    uint64_t total = 0;
    char what[64];
    snprintf(what, sizeof what, "%zu items, kind %d", items, kind);
    assert_non_null(counts);
    for (size_t i = 0; i < items; i++)
        total += counts[i] = count_of(kind, i, items);
    if (!pel_histopyramid_reserve(device, p, items, &error))
        fail_msg("%s: %s", what, error.message);
    glNamedBufferSubData(p->base.name, 0, (GLsizeiptr)room, counts);
    if (!pel_histopyramid_build(device, programs, p, &error))
        fail_msg("%s: %s", what, error.message);
    assert_int_equal(p->total, total);
    check_outputs(p, program, counts, what);
    free(counts);
}

static void test_outputs(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    static const size_t sizes[] = { 1, 15, 16, 17, 63, 64, 65, 255, 257, 1023, 1025, 4097, 65537, 300001, 1, 17 };
    if (!device)
        skip();
    assert_true(pel_device_begin(device, &error));
    struct pel_programs programs = { .count = 0 };
    struct pel_histopyramid pyramid = { .items = 0 };
    GLuint program = finder();
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (enum counts kind = NONE; kind < COUNTS; kind++)
            check(&programs, &pyramid, program, sizes[i], kind);
    check(&programs, &pyramid, program, 3000017, ONES); /* outputs for more groups than one row of a dispatch has */
    glDeleteProgram(program);
    pel_histopyramid_finish(device, &pyramid);
    pel_programs_finish(device, &programs);
    assert_int_equal(pel_device_objects(device), 0);
    pel_device_end(device);
}

static void test_too_many(void **state)
{
    (void)state;
    struct pel_error error = PEL_ERROR_INIT;
    struct pel_histopyramid pyramid = { .items = 0 };
    if (!device)
        skip();
    assert_true(pel_device_begin(device, &error));
    assert_false(pel_histopyramid_reserve(device, &pyramid, (size_t)-1, &error));
    assert_int_equal(error.code, PEL_ERROR_UNSUPPORTED);
    assert_false(pel_histopyramid_reserve(device, &pyramid, (size_t)1 << 40, &error));
    assert_non_null(strstr(error.message, "cells are more than"));
    pel_histopyramid_finish(device, &pyramid);
    pel_device_end(device);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_outputs), cmocka_unit_test(test_too_many) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
