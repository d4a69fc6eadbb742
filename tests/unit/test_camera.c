/* SPDX-License-Identifier: MIT */
/* Cameras: VTK's moves at hand-computed angles, rays against the projection that they invert, and views that frame the whole volume
 * tightly. */
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/camera.h>

#include "vec.h"

#define NEAR(a, b) assert_true(fabs((a) - (b)) < 1e-9)

static void check_vector(const double v[3], double x, double y, double z)
{
    if (!(fabs(v[0] - x) < 1e-9 && fabs(v[1] - y) < 1e-9 && fabs(v[2] - z) < 1e-9))
        fail_msg("(%g, %g, %g) is not (%g, %g, %g)", v[0], v[1], v[2], x, y, z);
}

static struct pel_volume make_volume(size_t x, size_t y, size_t z)
{
    struct pel_volume v;
    pel_volume_init(&v);
    assert_true(pel_volume_allocate(&v, (size_t[3]){ x, y, z }, PEL_U8, 1, NULL));
    return v;
}

static void test_basis(void **state)
{
    (void)state;
    struct pel_camera c = PEL_CAMERA_INIT;
    double right[3], up[3], forward[3];
    pel_camera_basis(&c, right, up, forward);
    check_vector(right, 1, 0, 0);
    check_vector(up, 0, 0, 1);
    check_vector(forward, 0, 1, 0);
    memcpy(c.view_up, (double[3]){ 0.3e-100, 5e-100, 2e-100 }, sizeof c.view_up); /* neither unit nor square to the view */
    pel_camera_basis(&c, right, up, forward);
    NEAR(pel_dot(right, up), 0);
    NEAR(pel_dot(right, forward), 0);
    NEAR(pel_dot(up, forward), 0);
    NEAR(pel_length(right), 1);
    NEAR(pel_length(up), 1);
    assert_true(up[2] > 0);
}

/* vtkCamera with position (0,-5,0), focal point at the origin and view-up +z gives these positions. */
static void test_moves(void **state)
{
    (void)state;
    struct pel_camera c = PEL_CAMERA_INIT;
    pel_camera_azimuth(&c, 90); /* the camera goes to its right, the scene turns to the left */
    check_vector(c.position, 5, 0, 0);
    check_vector(c.view_up, 0, 0, 1);
    c = (struct pel_camera)PEL_CAMERA_INIT;
    pel_camera_elevation(&c, 30); /* the camera rises */
    check_vector(c.position, 0, -5 * cos(30 * 3.14159265358979323846 / 180), 2.5);
    check_vector(c.view_up, 0, 0, 1);
    c = (struct pel_camera)PEL_CAMERA_INIT;
    pel_camera_roll(&c, 90); /* about +y, right-handed: +z becomes +x */
    check_vector(c.view_up, 1, 0, 0);
    check_vector(c.position, 0, -5, 0);

    c = (struct pel_camera)PEL_CAMERA_INIT;
    memcpy(c.focal_point, (double[3]){ 1, 2, 3 }, sizeof c.focal_point);
    memcpy(c.position, (double[3]){ 1, 0, 3 }, sizeof c.position);
    memcpy(c.view_up, (double[3]){ 0, 0, 7 }, sizeof c.view_up);
    pel_camera_azimuth(&c, 90);
    check_vector(c.position, 3, 2, 3);
    for (int i = 0; i < 3; i++)
        pel_camera_azimuth(&c, 90);
    check_vector(c.position, 1, 0, 3);
}

static void test_zoom(void **state)
{
    (void)state;
    struct pel_camera c = PEL_CAMERA_INIT;
    pel_camera_zoom(&c, 2);
    NEAR(c.view_angle, 15);
    NEAR(c.parallel_scale, 1);
    pel_camera_zoom(&c, 0);
    pel_camera_zoom(&c, NAN);
    pel_camera_zoom(&c, -1);
    NEAR(c.view_angle, 15);
    pel_camera_zoom(&c, 1e-9);
    assert_true(pel_camera_check(&c, NULL));
    c.parallel = true;
    pel_camera_zoom(&c, 4);
    NEAR(c.parallel_scale, 0.25);
}

static void test_rays(void **state)
{
    (void)state;
    struct pel_camera c = PEL_CAMERA_INIT;
    double origin[3], direction[3];
    c.view_angle = 90;
    pel_camera_ray(&c, 5, 5, 2, 2, origin, direction); /* the middle pixel of an odd picture looks straight ahead */
    check_vector(origin, 0, -5, 0);
    check_vector(direction, 0, 1, 0);
    pel_camera_ray(&c, 4, 2, 0, 0, origin, direction); /* top left: u = -3/4 * 2, v = 1/2 */
    double length = sqrt(1.5 * 1.5 + 1 + 0.25);
    check_vector(direction, -1.5 / length, 1 / length, 0.5 / length);
    pel_camera_ray(&c, 4, 2, 3, 1, origin, direction); /* bottom right */
    check_vector(direction, 1.5 / length, 1 / length, -0.5 / length);
    c.parallel = true;
    c.parallel_scale = 3;
    pel_camera_ray(&c, 4, 2, 0, 0, origin, direction);
    check_vector(origin, -4.5, -5, 1.5);
    check_vector(direction, 0, 1, 0);
}

/* Where a world point falls in the picture: -1 to 1 from edge to edge in x and y. */
static void project(const struct pel_camera *c, double aspect, const double p[3], double out[2])
{
    double right[3], up[3], forward[3], d[3];
    pel_camera_basis(c, right, up, forward);
    pel_sub(p, c->position, d);
    double depth = pel_dot(d, forward), half = c->parallel ? c->parallel_scale : tan(c->view_angle * 3.14159265358979323846 / 360) * depth;
    assert_true(depth > 0);
    out[0] = pel_dot(d, right) / half / aspect;
    out[1] = pel_dot(d, up) / half;
}

static void check_fit(const struct pel_volume *v, bool parallel, double angle, int width, int height)
{
    struct pel_camera c = PEL_CAMERA_INIT;
    c.parallel = parallel;
    c.view_angle = angle;
    pel_camera_fit(&c, v, width, height);
    struct pel_error error = PEL_ERROR_INIT;
    if (!pel_camera_check(&c, &error))
        fail_msg("%s", error.message);
    assert_true(c.parallel == parallel && c.view_angle == angle);
    double most = 0;
    for (int corner = 0; corner < 8; corner++) {
        double index[3], world[3], at[2];
        for (int a = 0; a < 3; a++) {
            double last = v->dims[a] > 1 ? (double)(v->dims[a] - 1) : 0.5;
            index[a] = corner >> a & 1 ? last : v->dims[a] > 1 ? 0 : -0.5;
        }
        pel_volume_index_to_world(v, index, world);
        project(&c, (double)width / height, world, at);
        most = fmax(most, fmax(fabs(at[0]), fabs(at[1])));
    }
    if (!(most > 0.899 && most < 0.901))
        fail_msg("the volume fills %g of a %d x %d picture at %g degrees", most, width, height, angle);
}

static void test_fit(void **state)
{
    (void)state;
    static const size_t dims[][3] = { { 64, 64, 64 }, { 256, 256, 20 }, { 3, 500, 7 }, { 1, 1, 1 }, { 100, 1, 100 }, { 2, 2, 2000 } };
    static const int sizes[][2] = { { 512, 512 }, { 1920, 1080 }, { 100, 900 }, { 1, 1 } };
    for (size_t i = 0; i < sizeof dims / sizeof *dims; i++) {
        struct pel_volume v = make_volume(dims[i][0], dims[i][1], dims[i][2]);
        memcpy(v.origin, (double[3]){ 100, -2000, 3 }, sizeof v.origin);
        memcpy(v.spacing, (double[3]){ 0.1, 0.5, 2 }, sizeof v.spacing);
        memcpy(v.direction, (double[3][3]){ { 0, 1, 0 }, { -0.6, 0.8, 0 }, { 0, 0.6, 0.8 } }, sizeof v.direction);
        for (int space = 0; space < 3; space++)
            for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
                v.space = (enum pel_space)space;
                check_fit(&v, false, 30, sizes[s][0], sizes[s][1]);
                check_fit(&v, false, 5, sizes[s][0], sizes[s][1]);
                check_fit(&v, true, 30, sizes[s][0], sizes[s][1]);
            }
        pel_volume_finish(&v);
    }
}

/* Anterior faces the camera, superior is up, and the camera stands a little aside and above. */
static void test_fit_faces_the_patient(void **state)
{
    (void)state;
    struct pel_volume v = make_volume(64, 64, 64);
    struct pel_camera c = PEL_CAMERA_INIT;
    static const double anterior[3] = { -1, 1, -1 }; /* sign of y: unknown data is seen from -y, as if that were its front */
    for (int space = 0; space < 3; space++) {
        v.space = (enum pel_space)space;
        pel_camera_fit(&c, &v, 512, 512);
        double right[3], up[3], forward[3], from[3];
        pel_camera_basis(&c, right, up, forward);
        pel_sub(c.position, c.focal_point, from);
        pel_normalize(from);
        check_vector(c.view_up, 0, 0, 1);
        check_vector(c.focal_point, 31.5, 31.5, 31.5);
        NEAR(asin(from[2]) * 180 / 3.14159265358979323846, 20);
        NEAR(anterior[space] * from[1], cos(20 * 3.14159265358979323846 / 180) * cos(30 * 3.14159265358979323846 / 180));
        NEAR(right[0] * anterior[space], -cos(30 * 3.14159265358979323846 / 180)); /* the patient's left is at the picture's right */
    }
    pel_volume_finish(&v);
}

static void test_check_refuses(void **state)
{
    (void)state;
    for (int fault = 0; fault < 10; fault++) {
        struct pel_camera c = PEL_CAMERA_INIT;
        struct pel_error error = PEL_ERROR_INIT;
        assert_true(pel_camera_check(&c, &error));
        switch (fault) {
        case 0: c.position[0] = NAN; break;
        case 1: c.focal_point[2] = INFINITY; break;
        case 2: memcpy(c.focal_point, c.position, sizeof c.position); break;
        case 3: memcpy(c.view_up, (double[3]){ 0, -3, 0 }, sizeof c.view_up); break;
        case 4: memset(c.view_up, 0, sizeof c.view_up); break;
        case 5: c.view_angle = 0; break;
        case 6: c.view_angle = 180; break;
        case 7: c.view_angle = NAN; break;
        case 8: c.parallel_scale = 0; break;
        case 9: c.parallel_scale = INFINITY; break;
        }
        if (pel_camera_check(&c, &error))
            fail_msg("fault %d was let through", fault);
        assert_int_equal(error.code, PEL_ERROR_ARGUMENT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_basis),
        cmocka_unit_test(test_moves),
        cmocka_unit_test(test_zoom),
        cmocka_unit_test(test_rays),
        cmocka_unit_test(test_fit),
        cmocka_unit_test(test_fit_faces_the_patient),
        cmocka_unit_test(test_check_refuses),
    };
    return cmocka_run_group_tests_name("camera", tests, NULL, NULL);
}
