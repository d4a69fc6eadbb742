/* SPDX-License-Identifier: MIT */
/* The Shepp-Logan head in 3D: ten ellipsoids whose densities add up, with the contrast that Toft gave it so that the eye can tell the
 * inside apart. Skull 1, brain 0.2, ventricles 0, tumours 0.3. Hard edges would alias into steps, so each voxel is the mean of
 * subvoxels. */
#include "fail.h"
#include "formula.h"
#include "grid.h"

struct head {
    int size, subvoxels;
};

struct ellipsoid {
    double density, axes[3], centre[3], degrees; /* turned about z */
};

static const struct ellipsoid ellipsoids[10] = {
    { 1, { 0.69, 0.92, 0.81 }, { 0, 0, 0 }, 0 },
    { -0.8, { 0.6624, 0.874, 0.78 }, { 0, -0.0184, 0 }, 0 },
    { -0.2, { 0.11, 0.31, 0.22 }, { 0.22, 0, 0 }, -18 },
    { -0.2, { 0.16, 0.41, 0.28 }, { -0.22, 0, 0 }, 18 },
    { 0.1, { 0.21, 0.25, 0.41 }, { 0, 0.35, -0.15 }, 0 },
    { 0.1, { 0.046, 0.046, 0.05 }, { 0, 0.1, 0.25 }, 0 },
    { 0.1, { 0.046, 0.046, 0.05 }, { 0, -0.1, 0.25 }, 0 },
    { 0.1, { 0.046, 0.023, 0.05 }, { -0.08, -0.605, 0 }, 0 },
    { 0.1, { 0.023, 0.023, 0.02 }, { 0, -0.606, 0 }, 0 },
    { 0.1, { 0.023, 0.046, 0.02 }, { 0.06, -0.605, 0 }, 0 },
};

struct prepared {
    int subvoxels;
    double voxel;
    double cosine[10], sine[10];
    double reach[10]; /* how much the scaled distance from the centre can change within half a voxel's diagonal */
};

/* Distance from an ellipsoid's centre, scaled so that 1 is its surface, squared. */
static double scaled_distance2(const struct prepared *head, int i, double x, double y, double z)
{
    const struct ellipsoid *e = &ellipsoids[i];
    double dx = x - e->centre[0], dy = y - e->centre[1], w = (z - e->centre[2]) / e->axes[2];
    double u = (dx * head->cosine[i] + dy * head->sine[i]) / e->axes[0], v = (dy * head->cosine[i] - dx * head->sine[i]) / e->axes[1];
    return u * u + v * v + w * w;
}

static int count_inside(const struct prepared *head, int ellipsoid, const double p[3])
{
    int n = head->subvoxels, inside = 0;
    double step = head->voxel / n, first = (step - head->voxel) / 2;
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++)
                inside += scaled_distance2(head, ellipsoid, p[0] + first + i * step, p[1] + first + j * step, p[2] + first + k * step) <= 1;
    return inside;
}

/* All densities are tenths: summed as integers over the subvoxels, flat regions come out exact. */
static void sample(const void *context, const double p[3], float *out)
{
    const struct prepared *head = context;
    int all = head->subvoxels * head->subvoxels * head->subvoxels, sum = 0;
    for (int i = 0; i < 10; i++) {
        double distance = sqrt(scaled_distance2(head, i, p[0], p[1], p[2]));
        int inside = distance > 1 + head->reach[i] ? 0 : distance < 1 - head->reach[i] ? all : count_inside(head, i, p);
        sum += (int)floor(ellipsoids[i].density * 10 + 0.5) * inside;
    }
    *out = (float)(sum / (10.0 * all));
}

static bool make(const void *params, struct pel_volume *volume, struct pel_error *error)
{
    const struct head *h = params;
    if (h->subvoxels < 1 || h->subvoxels > 8)
        return pel_fail(error, PEL_ERROR_ARGUMENT, "subvoxels: %d is not from 1 to 8", h->subvoxels);
    struct prepared head = { .subvoxels = h->subvoxels, .voxel = 2.0 / (h->size > 1 ? h->size - 1 : 1) };
    for (int i = 0; i < 10; i++) {
        head.cosine[i] = pel_cos(ellipsoids[i].degrees * PEL_PI / 180);
        head.sine[i] = pel_sin(ellipsoids[i].degrees * PEL_PI / 180);
        double least = fmin(ellipsoids[i].axes[0], fmin(ellipsoids[i].axes[1], ellipsoids[i].axes[2]));
        head.reach[i] = head.voxel * 0.8661 / least; /* just over half the square root of 3 */
    }
    return pel_dataset_fill(volume, h->size, 1, 0, 1, sample, &head, error);
}

static const struct pel_option options[] = {
    PEL_DATASET_SIZE_ROW(struct head, "64"),
    { "subvoxels", "Subvoxels", "Points along each axis whose mean is a voxel; 1 gives hard edges", PEL_OPTION_INT,
      offsetof(struct head, subvoxels), 1, 8, "4", NULL, NULL },
    { NULL },
};

const struct pel_dataset pel_dataset_shepp_logan = {
    "shepp-logan", "The Shepp-Logan head phantom in 3D, densities 0 to 1 over [-1,1]^3",
    "Shepp, Logan: The Fourier Reconstruction of a Head Section, IEEE Transactions on Nuclear Science 21, 1974; contrast after Toft, 1996",
    options, sizeof(struct head), make,
};
