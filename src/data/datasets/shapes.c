/* SPDX-License-Identifier: MIT */
/* Shapes with analytic answers over [-1,1]^3. The value is the signed distance to the surface, positive inside: the isosurface at 0 is
 * exactly the shape, and at d it is the shape shrunk by d. `constant` is a homogeneous cube, for which the optics have closed forms. */
#include "fail.h"
#include "formula.h"
#include "grid.h"

struct shape {
    int size;
    double radius;
    double thickness;    /* shell */
    double tube;         /* torus */
    double half_edge[3]; /* box */
    double value;        /* constant */
};

static double length2(double x, double y)
{
    return sqrt(x * x + y * y);
}

static double length3(const double p[3])
{
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
}

static void sample_sphere(const void *context, const double p[3], float *out)
{
    const struct shape *s = context;
    *out = (float)(s->radius - length3(p));
}

static void sample_shell(const void *context, const double p[3], float *out)
{
    const struct shape *s = context;
    *out = (float)(s->thickness / 2 - fabs(length3(p) - s->radius));
}

static void sample_box(const void *context, const double p[3], float *out)
{
    const struct shape *s = context;
    double beyond[3], nearest = -INFINITY; /* how far outside each pair of faces; outside, the distance to the edge or corner */
    for (int a = 0; a < 3; a++) {
        double d = fabs(p[a]) - s->half_edge[a];
        nearest = d > nearest ? d : nearest;
        beyond[a] = d > 0 ? d : 0;
    }
    *out = (float)(nearest > 0 ? -length3(beyond) : -nearest);
}

static void sample_torus(const void *context, const double p[3], float *out)
{
    const struct shape *s = context;
    *out = (float)(s->tube - length2(length2(p[0], p[1]) - s->radius, p[2]));
}

static void sample_constant(const void *context, const double p[3], float *out)
{
    (void)p;
    *out = (float)((const struct shape *)context)->value;
}

static bool check(double value, double least, const char *name, struct pel_error *error)
{
    if (value >= least && value <= 10)
        return true;
    return pel_fail(error, PEL_ERROR_ARGUMENT, "%s: %g is not a number from %g to 10", name, value, least);
}

static bool make_sphere(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct shape *s = params;
    return check(s->radius, 0, "radius", error) && pel_dataset_fill(volume, s->size, 1, 0, 1, sample_sphere, s, error);
}

static bool make_shell(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct shape *s = params;
    return check(s->radius, 0, "radius", error) && check(s->thickness, 0, "thickness", error) &&
           pel_dataset_fill(volume, s->size, 1, 0, 1, sample_shell, s, error);
}

static bool make_box(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct shape *s = params;
    for (int a = 0; a < 3; a++)
        if (!check(s->half_edge[a], 0, "half-edge", error))
            return false;
    return pel_dataset_fill(volume, s->size, 1, 0, 1, sample_box, s, error);
}

static bool make_torus(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct shape *s = params;
    return check(s->radius, 0, "radius", error) && check(s->tube, 0, "tube", error) &&
           pel_dataset_fill(volume, s->size, 1, 0, 1, sample_torus, s, error);
}

static bool make_constant(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct shape *s = params;
    if (!(fabs(s->value) <= 1e30))
        return pel_fail(error, PEL_ERROR_ARGUMENT, "value: %g is not a number from -1e30 to 1e30", s->value);
    return pel_dataset_fill(volume, s->size, 1, 0, 1, sample_constant, s, error);
}

#define RADIUS_ROW(fallback)                                                                                                               \
    { "radius", "Radius", "Radius", PEL_OPTION_DOUBLE, offsetof(struct shape, radius), 0, 10, fallback, NULL, "world length" }

static const struct pel_option sphere_options[] = { PEL_DATASET_SIZE_ROW(struct shape, "64"), RADIUS_ROW("0.7"), { NULL } };

static const struct pel_option shell_options[] = {
    PEL_DATASET_SIZE_ROW(struct shape, "64"),
    RADIUS_ROW("0.7"),
    { "thickness", "Thickness", "From the inner to the outer surface; the radius lies midway", PEL_OPTION_DOUBLE,
      offsetof(struct shape, thickness), 0, 10, "0.2", NULL, "world length" },
    { NULL },
};

static const struct pel_option box_options[] = {
    PEL_DATASET_SIZE_ROW(struct shape, "64"),
    { "half-edge", "Half edges", "Half the edges along x, y and z", PEL_OPTION_VEC3, offsetof(struct shape, half_edge), 0, 10,
      "0.7,0.5,0.4", NULL, "world length" },
    { NULL },
};

static const struct pel_option torus_options[] = {
    PEL_DATASET_SIZE_ROW(struct shape, "64"),
    { "radius", "Radius", "Radius of the circle in the middle of the tube", PEL_OPTION_DOUBLE, offsetof(struct shape, radius), 0, 10, "0.6",
      NULL, "world length" },
    { "tube", "Tube radius", "Radius of the tube", PEL_OPTION_DOUBLE, offsetof(struct shape, tube), 0, 10, "0.25", NULL, "world length" },
    { NULL },
};

static const struct pel_option constant_options[] = {
    PEL_DATASET_SIZE_ROW(struct shape, "32"),
    { "value", "Value", "The value of every sample", PEL_OPTION_DOUBLE, offsetof(struct shape, value), -1e30, 1e30, "1", NULL, NULL },
    { NULL },
};

const struct pel_dataset pel_dataset_sphere = {
    "sphere", "Signed distance to a sphere, positive inside, over [-1,1]^3", NULL, sphere_options, sizeof(struct shape), make_sphere,
};
const struct pel_dataset pel_dataset_shell = {
    "shell", "Signed distance to a spherical shell, positive inside the wall, over [-1,1]^3", NULL, shell_options, sizeof(struct shape),
    make_shell,
};
const struct pel_dataset pel_dataset_box = {
    "box", "Signed distance to a box, positive inside, over [-1,1]^3", NULL, box_options, sizeof(struct shape), make_box,
};
const struct pel_dataset pel_dataset_torus = {
    "torus", "Signed distance to a torus about the z axis, positive inside, over [-1,1]^3", NULL, torus_options, sizeof(struct shape),
    make_torus,
};
const struct pel_dataset pel_dataset_constant = {
    "constant", "The same value everywhere in [-1,1]^3: a homogeneous medium", NULL, constant_options, sizeof(struct shape), make_constant,
};
