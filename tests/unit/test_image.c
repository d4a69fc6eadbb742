/* SPDX-License-Identifier: MIT */
/* Images: storage, and the metrics against values worked out by hand or by a plain two-dimensional loop. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/image.h>

static struct pel_image make(int width, int height, float value)
{
    struct pel_image image;
    pel_image_init(&image);
    assert_true(pel_image_allocate(&image, width, height, false, NULL));
    for (int i = 0; i < 4 * width * height; i++)
        image.rgba[i] = value;
    return image;
}

static void test_allocate(void **state)
{
    (void)state;
    struct pel_image image;
    struct pel_error error = PEL_ERROR_INIT;
    pel_image_init(&image);
    pel_image_finish(&image);
    assert_true(pel_image_allocate(&image, 7, 3, true, &error));
    for (int i = 0; i < 84; i++)
        assert_true(image.rgba[i] == 0);
    for (int i = 0; i < 21; i++)
        assert_true(isinf(image.depth[i]) && image.depth[i] > 0);
    const float *before = image.rgba;
    image.rgba[5] = 1;
    image.depth[5] = 1;
    assert_true(pel_image_allocate(&image, 7, 3, true, &error)); /* the same size: reused and cleared */
    assert_ptr_equal(image.rgba, before);
    assert_true(image.rgba[5] == 0 && isinf(image.depth[5]));
    assert_true(pel_image_allocate(&image, 7, 3, false, &error));
    assert_null(image.depth);
    assert_true(pel_image_allocate(&image, 3, 7, true, &error));
    assert_int_equal(image.width, 3);
    assert_int_equal(image.height, 7);
    static const int bad[][2] = { { 0, 1 }, { 1, 0 }, { -1, 5 }, { PEL_IMAGE_MAX + 1, 1 }, { 1, PEL_IMAGE_MAX + 1 } };
    for (int i = 0; i < 5; i++) {
        assert_false(pel_image_allocate(&image, bad[i][0], bad[i][1], true, &error));
        assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
        assert_int_equal(image.width, 3); /* what it held stays */
    }
    pel_image_finish(&image);
    assert_null(image.rgba);
}

static void test_equal(void **state)
{
    (void)state;
    struct pel_image a = make(20, 15, 0.25f), b = make(20, 15, 0.25f);
    struct pel_metrics m;
    assert_true(pel_image_compare(&a, &b, &m, NULL));
    assert_true(isinf(m.psnr) && m.psnr > 0 && fabs(m.ssim - 1) < 1e-12 && m.max_error == 0 && m.differing_pixels == 0);
    pel_image_finish(&a);
    pel_image_finish(&b);
}

static void test_known_errors(void **state)
{
    (void)state;
    struct pel_image a = make(20, 10, 0.5f), b = make(20, 10, 0.5f);
    struct pel_metrics m;
    b.rgba[4 * 57 + 2] = 0.75f; /* one channel of one pixel: mean square error 1/16 / 800 */
    assert_true(pel_image_compare(&a, &b, &m, NULL));
    assert_true(fabs(m.psnr - 10 * log10(16 * 800)) < 1e-9);
    assert_true(m.max_error == 0.25 && m.differing_pixels == 1);
    b.rgba[4 * 58] = 0.59f; /* below the limit of 0.1 */
    assert_true(pel_image_compare(&a, &b, &m, NULL));
    assert_int_equal(m.differing_pixels, 1);
    b.rgba[4 * 57 + 2] = 0.5f;
    b.rgba[4 * 58] = 0.5f;
    a.rgba[3] = 3;
    b.rgba[3] = 1; /* beyond 1 there is no difference */
    assert_true(pel_image_compare(&a, &b, &m, NULL));
    assert_true(m.max_error == 0);
    a.rgba[3] = NAN;
    assert_true(pel_image_compare(&a, &b, &m, NULL));
    assert_true(m.max_error == 1 && m.differing_pixels == 1);
    pel_image_finish(&a);
    pel_image_finish(&b);
}

static void test_sizes_differ(void **state)
{
    (void)state;
    struct pel_image a = make(20, 10, 0), b = make(10, 20, 0), empty;
    struct pel_metrics m;
    struct pel_error error = PEL_ERROR_INIT;
    pel_image_init(&empty);
    assert_false(pel_image_compare(&a, &b, &m, &error));
    assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    assert_string_equal(error.message, "the pictures differ in size: 20 x 10 and 10 x 20");
    assert_false(pel_image_compare(&a, &empty, &m, &error));
    pel_image_finish(&a);
    pel_image_finish(&b);
}

/* SSIM as the paper writes it: a full 11 x 11 window at each place where it fits. */
static double plain_ssim(const float *a, const float *b, int width, int height)
{
    double weight[11][11], sum = 0, total = 0;
    long places = 0;
    for (int j = 0; j < 11; j++)
        for (int i = 0; i < 11; i++)
            sum += weight[j][i] = exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
    for (int y = 0; y + 11 <= height; y++)
        for (int x = 0; x + 11 <= width; x++, places++) {
            double ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
            for (int j = 0; j < 11; j++)
                for (int i = 0; i < 11; i++) {
                    ma += weight[j][i] / sum * (double)a[(y + j) * width + x + i];
                    mb += weight[j][i] / sum * (double)b[(y + j) * width + x + i];
                }
            for (int j = 0; j < 11; j++)
                for (int i = 0; i < 11; i++) {
                    double da = (double)a[(y + j) * width + x + i] - ma, db = (double)b[(y + j) * width + x + i] - mb;
                    va += weight[j][i] / sum * da * da;
                    vb += weight[j][i] / sum * db * db;
                    cov += weight[j][i] / sum * da * db;
                }
            total += (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        }
    return total / (double)places;
}

static void test_ssim(void **state)
{
    (void)state;
    enum { W = 23, H = 17 };
    struct pel_image a = make(W, H, 1), b = make(W, H, 1);
    float la[W * H], lb[W * H];
    struct pel_metrics m;
    for (int i = 0; i < W * H; i++) { /* gray pixels, whose luma is the gray */
        la[i] = (float)(0.5 + 0.4 * sin(i * 0.37));
        lb[i] = (float)(0.5 + 0.3 * sin(i * 0.37 + 0.5) + 0.1 * cos(i * 1.7));
        for (int c = 0; c < 3; c++) {
            a.rgba[4 * i + c] = la[i];
            b.rgba[4 * i + c] = lb[i];
        }
    }
    assert_true(pel_image_compare(&a, &b, &m, NULL));
    double plain = plain_ssim(la, lb, W, H);
    assert_true(plain > 0.2 && plain < 0.9);
    assert_true(fabs(m.ssim - plain) < 1e-9);
    pel_image_finish(&a);
    pel_image_finish(&b);
}

/* Pictures smaller than the window: the window shrinks, nothing is read beyond them. */
static void test_ssim_of_small_pictures(void **state)
{
    (void)state;
    static const int sizes[][2] = { { 1, 1 }, { 1, 40 }, { 2, 3 }, { 10, 10 }, { 11, 11 }, { 40, 2 } };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct pel_image a = make(sizes[i][0], sizes[i][1], 0.2f), b = make(sizes[i][0], sizes[i][1], 0.8f);
        struct pel_metrics m;
        double ma = (double)0.2f, mb = (double)0.8f;
        assert_true(pel_image_compare(&a, &b, &m, NULL));
        assert_true(fabs(m.ssim - (2 * ma * mb + 1e-4) / (ma * ma + mb * mb + 1e-4)) < 1e-9); /* flat: the means alone differ */
        pel_image_finish(&a);
        pel_image_finish(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_allocate),
        cmocka_unit_test(test_equal),
        cmocka_unit_test(test_known_errors),
        cmocka_unit_test(test_sizes_differ),
        cmocka_unit_test(test_ssim),
        cmocka_unit_test(test_ssim_of_small_pictures),
    };
    return cmocka_run_group_tests_name("image", tests, NULL, NULL);
}
