/* SPDX-License-Identifier: MIT */
/* ParaView colour maps: JSON and XML in, JSON out; colour spaces against values worked out elsewhere; damage. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "color_space.h"

static struct pel_transfer transfer;

static int make(void **state)
{
    (void)state;
    return pel_transfer_init(&transfer, NULL) ? 0 : -1;
}

static int drop(void **state)
{
    (void)state;
    pel_transfer_finish(&transfer);
    return 0;
}

static void parse_ok(const char *text, const char *name, double lo, double hi)
{
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_transfer_from_text(text, strlen(text), name, lo, hi, &transfer, &error))
        fail_msg("%s", error.message);
}

static void expect_color(double value, double r, double g, double b, double tolerance)
{
    double rgb[3];
    pel_transfer_color(&transfer, value, rgb);
    if (!(fabs(rgb[0] - r) <= tolerance && fabs(rgb[1] - g) <= tolerance && fabs(rgb[2] - b) <= tolerance))
        fail_msg("at %g: %g %g %g, not %g %g %g", value, rgb[0], rgb[1], rgb[2], r, g, b);
}

static void expect_opacity(double value, double opacity)
{
    if (!(fabs(pel_transfer_opacity(&transfer, value) - opacity) < 1e-6))
        fail_msg("at %g: opacity %g, not %g", value, pel_transfer_opacity(&transfer, value), opacity);
}

static void json_presets(void **state)
{
    (void)state;
    static const char text[] = "[{\"Name\":\"first\",\"ColorSpace\":\"RGB\",\"NanColor\":[1,1,0],\"RGBPoints\":[0,0,0,0, 1,1,0.5,0]},"
                               "{\"Name\":\"second\",\"Creator\":\"ParaView\",\"RGBPoints\":[-5,0,1,0, 15,0,0,1],"
                               "\"Points\":[-5,0,0.5,0, 15,0.8,0.5,0]}]";
    parse_ok(text, NULL, 100, 200); /* 0 to 1: stretched */
    assert_string_equal(transfer.colormap, "first");
    expect_color(150, 0.5, 0.25, 0, 1e-9);
    expect_opacity(0.5, 0.5);           /* the file has none: as it was */
    parse_ok(text, "second", 100, 200); /* data values: as they are */
    expect_color(5, 0, 0.5, 0.5, 1e-9);
    expect_opacity(5, 0.4);
    parse_ok("{\"RGBPoints\":[0,0,0,0, 1,1,1,1],\"Points\":[0,0,0.5,0, 0.5,1,0.5,0, 1,0,0.5,0]}", NULL, 10, 20);
    expect_opacity(12.5, 0.5);
    expect_opacity(15, 1);
    parse_ok(text, "first", NAN, NAN);
    expect_color(0.5, 0.5, 0.25, 0, 1e-9);
}

static void indexed_and_step(void **state)
{
    (void)state;
    parse_ok("[{\"Name\":\"categories\",\"IndexedColors\":[1,0,0, 0,1,0, 0,0,1]}]", NULL, 0, 30);
    expect_color(5, 1, 0, 0, 0);
    expect_color(15, 0, 1, 0, 0);
    expect_color(29, 0, 0, 1, 0);
    parse_ok("{\"ColorSpace\":\"Step\",\"RGBPoints\":[2,1,0,0, 4,0,1,0, 6,0,0,1]}", NULL, 0, 1);
    expect_color(3.99, 1, 0, 0, 1e-9);
    expect_color(4, 0, 1, 0, 1e-9);
    expect_color(5.99, 0, 1, 0, 1e-9);
}

/* The published sRGB values of Moreland's cool to warm map. */
static void diverging_is_morelands(void **state)
{
    (void)state;
    static const int published[][3] = { { 59, 76, 192 },   { 98, 130, 234 },  { 141, 176, 254 }, { 184, 208, 249 }, { 221, 221, 221 },
                                        { 245, 196, 173 }, { 244, 154, 123 }, { 222, 96, 77 },   { 180, 4, 38 } };
    parse_ok("{\"ColorSpace\":\"Diverging\",\"RGBPoints\":[0,0.230,0.299,0.754, 8,0.706,0.016,0.150]}", NULL, 0, 1);
    for (int i = 0; i < 9; i++)
        expect_color(i, published[i][0] / 255.0, published[i][1] / 255.0, published[i][2] / 255.0, 0.008);
}

static void other_spaces(void **state)
{
    (void)state;
    double rgb[3];
    static const double red[3] = { 1, 0, 0 }, green[3] = { 0, 1, 0 }, magenta[3] = { 1, 0, 1 }, black[3] = { 0, 0, 0 },
                        white[3] = { 1, 1, 1 };
    pel_color_between(PEL_COLOR_SPACE_HSV, false, red, green, 0.5, rgb); /* yellow */
    assert_true(fabs(rgb[0] - 1) < 1e-9 && fabs(rgb[1] - 1) < 1e-9 && fabs(rgb[2]) < 1e-9);
    pel_color_between(PEL_COLOR_SPACE_HSV, true, red, magenta, 0.5, rgb); /* the short way: between red and magenta */
    assert_true(fabs(rgb[0] - 1) < 1e-9 && rgb[1] < 1e-9 && fabs(rgb[2] - 0.5) < 1e-9);
    pel_color_between(PEL_COLOR_SPACE_HSV, false, red, magenta, 0.5, rgb); /* the long way: by green */
    assert_true(rgb[1] > 0.9 && rgb[0] < 0.6);
    pel_color_between(PEL_COLOR_SPACE_LAB, false, black, white, 0.5, rgb); /* L* = 50 is sRGB 0.4663 */
    for (int c = 0; c < 3; c++)
        assert_true(fabs(rgb[c] - 0.4663) < 0.001);
    for (int space = PEL_COLOR_SPACE_RGB; space <= PEL_COLOR_SPACE_STEP; space++)
        for (int i = 0; i < 8; i++) { /* every way starts and ends where it should, and stays in range */
            const double a[3] = { i & 1, i >> 1 & 1, i >> 2 }, b[3] = { 0.3, 0.6, 0.2 };
            for (int k = 0; k <= 10; k++) {
                pel_color_between((enum pel_color_space)space, true, a, b, k / 10.0, rgb);
                for (int c = 0; c < 3; c++) {
                    assert_true(rgb[c] >= 0 && rgb[c] <= 1);
                    if (k == 0 || k == 10)
                        assert_true(fabs(rgb[c] - (k ? b[c] : a[c])) < 0.002);
                }
            }
        }
}

static void opacity_bends(void **state)
{
    (void)state;
#define MAP(points) "{\"RGBPoints\":[10,0,0,0, 20,1,1,1],\"Points\":[" points "]}"
    parse_ok(MAP("10,0,0.25,0, 20,1,0.5,0"), NULL, 0, 1); /* half way up at a quarter */
    expect_opacity(12.5, 0.5);
    expect_opacity(16.25, 0.75);
    parse_ok(MAP("10,0.2,0.3,1, 20,1,0.5,0"), NULL, 0, 1); /* a step */
    expect_opacity(12.9, 0.2);
    expect_opacity(13.1, 1);
    parse_ok(MAP("10,0,0.5,0.5, 20,1,0.5,0"), NULL, 0, 1); /* an S */
    expect_opacity(15, 0.5);
    assert_true(pel_transfer_opacity(&transfer, 12.5) < 0.1 && pel_transfer_opacity(&transfer, 17.5) > 0.9);
    parse_ok(MAP("10,0,0,0, 20,1,1,1"), NULL, 0, 1); /* midpoints at the very end divide by nothing */
    assert_true(isfinite(pel_transfer_opacity(&transfer, 15)));
}

static void xml_maps(void **state)
{
    (void)state;
    static const char text[] = "\xef\xbb\xbf<?xml version=\"1.0\"?>\n<ColorMaps>\n"
                               "<ColorMap name=\"a\" space=\"RGB\"><Point x=\"0\" o=\"1\" r=\"0\" g=\"0\" b=\"0\"/>"
                               "<Point x=\"1\" o=\"1\" r=\"1\" g=\"0\" b=\"0\"/><NaN r=\"1\" g=\"1\" b=\"0\"/></ColorMap>\n"
                               "<ColorMap name=\"b\" space=\"Lab\"><Point x=\"-1\" o=\"0.5\" r=\"0\" g=\"0\" b=\"0\"/>"
                               "<Point x=\"1\" o=\"0\" r=\"1\" g=\"1\" b=\"1\"/></ColorMap></ColorMaps>";
    parse_ok(text, NULL, 0, 10);
    assert_string_equal(transfer.colormap, "a");
    expect_color(5, 0.5, 0, 0, 1e-9);
    expect_opacity(0.25, 0.25); /* 1 everywhere says nothing */
    parse_ok(text, "b", 0, 10);
    expect_color(0, 0.4663, 0.4663, 0.4663, 0.001);
    expect_opacity(0, 0.25);
}

static void round_trip(void **state)
{
    (void)state;
    struct pel_transfer back;
    struct pel_error error = PEL_ERROR_INIT;
    assert_true(pel_transfer_set_colormap(&transfer, "inferno", -0.1, 1.0 / 3, NULL));
    assert_true(pel_transfer_parse_opacity(&transfer, "0.1:0,0.2:0.123456789012345678,0.2:1", NULL));
    assert_true(pel_transfer_init(&back, NULL));
    if (!pel_write_transfer(scratch("map.json"), &transfer, &error) || !pel_read_transfer(scratch("map.json"), NULL, 7, 9, &back, &error))
        fail_msg("%s", error.message);
    assert_true(pel_transfer_equal(&transfer, &back));
    assert_false(pel_write_transfer(scratch("no/such/folder.json"), &transfer, &error));
    assert_non_null(strstr(error.message, "folder.json"));
    transfer.unit_distance = 1;
    transfer.colors[0].value = NAN;
    assert_false(pel_write_transfer(scratch("nan.json"), &transfer, &error));
    assert_false(pel_read_transfer(scratch("nan.json"), NULL, 0, 1, &back, &error)); /* no half file */
    assert_int_equal(error.code, PEL_ERROR_IO);
    pel_transfer_finish(&back);
}

static void damage(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",
        " ",
        "[",
        "{}",
        "[]",
        "null",
        "3",
        "[[]]",
        "{\"RGBPoints\":[]}",
        "{\"RGBPoints\":[0,0,0]}",
        "{\"RGBPoints\":[0,0,0,2]}",
        "{\"RGBPoints\":[0,0,0,\"x\"]}",
        "{\"RGBPoints\":7}",
        "{\"RGBPoints\":[1,0,0,0, 0,1,1,1]}",
        "{\"RGBPoints\":[1e999,0,0,0]}",
        "{\"RGBPoints\":[0,0,0,0],\"Points\":[0,0,0]}",
        "{\"RGBPoints\":[0,0,0,0],\"Points\":[0,7,0.5,0]}",
        "{\"IndexedColors\":[1,2]}",
        "<",
        "<ColorMap>",
        "<ColorMap/>",
        "<a></a>",
        "<ColorMap><Point x='0'/></ColorMap>",
        "<ColorMap><Point x='0' r='nan' g='0' b='0'/></ColorMap>",
        "<ColorMap><Point x='0' r='9' g='0' b='0'/></ColorMap>",
        "<!DOCTYPE a [<!ENTITY b 'c'>]><ColorMap><Point x='0' r='0' g='0' b='0'/></ColorMap>",
        "<ColorMap><Point x='1' r='0' g='0' b='0'/><Point x='0' r='0' g='0' b='0'/></ColorMap>",
    };
    struct pel_transfer before;
    assert_true(pel_transfer_init(&before, NULL));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct pel_error error = PEL_ERROR_INIT;
        if (pel_transfer_from_text(bad[i], strlen(bad[i]), NULL, 0, 1, &transfer, &error))
            fail_msg("accepted: %s", bad[i]);
        assert_true(error.code == PEL_ERROR_FORMAT || error.code == PEL_ERROR_UNSUPPORTED);
        assert_true(error.message[0] && !strchr(error.message, '\n'));
        assert_true(pel_transfer_equal(&transfer, &before));
    }
    struct pel_error error = PEL_ERROR_INIT;
    assert_false(pel_transfer_from_text("[]", 2, "viridis", 0, 1, &transfer, &error));
    assert_non_null(strstr(error.message, "viridis"));
    assert_false(pel_read_transfer(scratch("none.json"), NULL, 0, 1, &transfer, &error));
    assert_int_equal(error.code, PEL_ERROR_IO);
    pel_transfer_finish(&before);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make, drop)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(json_presets), TEST(indexed_and_step), TEST(diverging_is_morelands), TEST(other_spaces), TEST(opacity_bends), TEST(xml_maps),
        TEST(round_trip),   TEST(damage),
    };
    return cmocka_run_group_tests(tests, make_scratch, remove_scratch);
}
