/* SPDX-License-Identifier: MIT */
/* The min-max octree and the two cube sets of iSBVR, held to plain transcriptions of the paper's figures 5 and 8. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/pellucid.h>

#include "cubes.h"

static unsigned seed;

static double random_number(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / 16777216.0;
}

/* Lumps of different sizes, so that there are empty, mixed, full and opaque cubes. */
static double lumps(int x, int y, int z)
{
    return 120 + 70 * sin(x * 0.31) * cos(y * 0.23) + 60 * sin(z * 0.37 + x * 0.11) + 4 * random_number();
}

static void make(struct pel_volume *v, const size_t dims[3], enum pel_type type, bool holes)
{
    pel_volume_init(v);
    assert_true(pel_volume_allocate(v, dims, type, 1, NULL));
    size_t i = 0;
    for (int z = 0; z < (int)dims[2]; z++)
        for (int y = 0; y < (int)dims[1]; y++)
            for (int x = 0; x < (int)dims[0]; x++, i++) {
                double value = fmin(fmax(lumps(x, y, z), 0), 255);
                if (type == PEL_F32)
                    ((float *)v->data)[i] = holes && random_number() < 0.02 ? NAN : (float)(value * 3.7 - 200);
                else if (type == PEL_I16)
                    ((int16_t *)v->data)[i] = (int16_t)(value * 30 - 2000);
                else
                    ((uint8_t *)v->data)[i] = (uint8_t)value;
            }
    if (type == PEL_U8 && holes) {
        v->has_void = true;
        v->void_value = 130;
    }
    pel_volume_update_range(v);
}

static double value_at(const struct pel_volume *v, size_t i)
{
    double value = v->type == PEL_F32 ? (double)((const float *)v->data)[i] :
                   v->type == PEL_I16 ? ((const int16_t *)v->data)[i] : ((const uint8_t *)v->data)[i];
    return v->has_void && value == v->void_value ? NAN : value;
}

static int least_of(int a, int b)
{
    return a < b ? a : b;
}

/* The extremes of a node's voxels, voids apart. */
static void voxels_of(const struct pel_volume *v, int size, const int node[3], double *least, double *most, bool *voids)
{
    int end[3];
    *least = INFINITY, *most = -INFINITY, *voids = false;
    for (int a = 0; a < 3; a++)
        end[a] = least_of((node[a] + 1) * size, (int)v->dims[a] - 1);
    for (int z = node[2] * size; z <= end[2]; z++)
        for (int y = node[1] * size; y <= end[1]; y++)
            for (int x = node[0] * size; x <= end[0]; x++) {
                double value = value_at(v, ((size_t)z * v->dims[1] + (size_t)y) * v->dims[0] + (size_t)x);
                if (isnan(value)) {
                    *voids = true;
                    continue;
                }
                *least = fmin(*least, value);
                *most = fmax(*most, value);
            }
}

static void check_node(const struct pel_octree *o, const struct pel_volume *v, int level, size_t at, const int node[3])
{
    double least, most, a, b;
    bool voids;
    voxels_of(v, 1 << level, node, &least, &most, &voids);
    bool any = pel_octree_interval(o, o->levels[level].lo[at], o->levels[level].hi[at], &a, &b);
    assert_int_equal(any, most >= least);
    if (!any)
        return;
    assert_true(a <= least && b >= most);
    if (o->exact && !voids) {
        assert_true(a == least);
        assert_true(b == most);
    }
    if (voids)
        assert_true(o->levels[level].lo[at] == 0 && o->voids);
    else if (!o->exact)
        assert_true(least - a <= 1.01 * o->width && b - most <= 1.01 * o->width);
}

static void test_octree(void **state)
{
    (void)state;
    static const size_t dims[][3] = { { 37, 30, 41 }, { 33, 17, 9 }, { 2, 1, 5 }, { 70, 3, 3 } };
    for (int d = 0; d < 4; d++)
        for (int kind = 0; kind < 5; kind++) {
            struct pel_volume v;
            struct pel_octree o;
            make(&v, dims[d], kind < 2 ? PEL_U8 : kind < 4 ? PEL_F32 : PEL_I16, kind & 1);
            assert_true(pel_octree_init(&o, &v, d % 3, 2, NULL));
            assert_int_equal(o.exact, kind == 0 || (kind == 1 && v.range[1] - v.range[0] < 255));
            for (int l = o.leaf; l < PEL_OCTREE_LEVELS; l++) {
                const int *n = o.levels[l].dims;
                size_t at = 0;
                for (int z = 0; z < n[2]; z++)
                    for (int y = 0; y < n[1]; y++)
                        for (int x = 0; x < n[0]; x++, at++)
                            check_node(&o, &v, l, at, (const int[3]){ x, y, z });
                for (int a = 0; a < 3; a++) /* the last node reaches the last voxel */
                    assert_true(n[a] << l >= (int)dims[d][a] - 1 && (n[a] - 1) << l <= (int)dims[d][a] - 1);
            }
            pel_octree_finish(&o);
            pel_volume_finish(&v);
        }
}

/* ---- figures 5 and 8 ---- */

struct plain {
    int n[3];
    uint8_t *class, *opaque, *some_opaque, *in_set;
};

static size_t index_of(const struct plain *p, const int c[3])
{
    return ((size_t)c[2] * (size_t)p->n[1] + (size_t)c[1]) * (size_t)p->n[0] + (size_t)c[0];
}

static bool neighbour(const struct plain *p, const int c[3], int direction, int to[3])
{
    memcpy(to, c, 3 * sizeof *to);
    to[direction / 2] += direction % 2 ? 1 : -1;
    return to[direction / 2] >= 0 && to[direction / 2] < p->n[direction / 2];
}

#define EACH_CUBE(p, c)                                                                                                                    \
    for (int c[3] = { 0, 0, 0 }; c[2] < (p)->n[2]; c[2]++)                                                                                 \
        for (c[1] = 0; c[1] < (p)->n[1]; c[1]++)                                                                                           \
            for (c[0] = 0; c[0] < (p)->n[0]; c[0]++)

/* What the curves themselves say of the values between a cube's extremes, in small steps. */
static void classify(struct plain *p, const struct pel_volume *v, const struct pel_transfer *t, int level, double threshold)
{
    size_t count = (size_t)p->n[0] * (size_t)p->n[1] * (size_t)p->n[2];
    p->class = calloc(count * 4, 1);
    p->opaque = p->class + count, p->some_opaque = p->opaque + count, p->in_set = p->some_opaque + count;
    EACH_CUBE(p, c) {
        double least, most, none = INFINITY, all = -INFINITY;
        bool voids;
        voxels_of(v, 1 << level, c, &least, &most, &voids);
        if (most < least)
            continue;
        for (double value = least; value <= most; value += 0.125) {
            double o = pel_transfer_opacity(t, value);
            none = fmin(none, o), all = fmax(all, o);
        }
        p->class[index_of(p, c)] = all <= 0 ? PEL_CUBE_EMPTY : none > 0 && !voids ? PEL_CUBE_FULL : PEL_CUBE_MIXED;
        p->opaque[index_of(p, c)] = none >= threshold && !voids;
        p->some_opaque[index_of(p, c)] = all >= threshold;
    }
}

static bool at_boundary(const struct plain *p, const int c[3])
{
    for (int a = 0; a < 3; a++)
        if (c[a] == 0 || c[a] == p->n[a] - 1)
            return true;
    return false;
}

/* Figure 5. */
static size_t figure_5(struct plain *p)
{
    size_t count = 0;
    EACH_CUBE(p, d) {
        size_t at = index_of(p, d);
        if (p->class[at] == PEL_CUBE_MIXED) /* d contains isosurface */
            p->in_set[at] = 1;
        else if (p->class[at] == PEL_CUBE_FULL && at_boundary(p, d)) /* d is inside the isosurface and on the volume boundary */
            p->in_set[at] = 1;
        count += p->in_set[at];
    }
    return count;
}

/* Figure 8. E starts with the cubes that the surface runs through; a cube is put back into E once only, or the figure's loop never ends. Our
 * set also closes opaque stuff that is cut off by the volume's boundary, which the figure leaves open. */
static size_t figure_8(struct plain *p)
{
    size_t cubes = (size_t)p->n[0] * (size_t)p->n[1] * (size_t)p->n[2], in_e = 0, count = 0;
    int(*e)[3] = malloc(cubes * sizeof *e);
    uint8_t *was_in_e = calloc(cubes, 1);
    memset(p->in_set, 0, cubes);
    EACH_CUBE(p, d) {
        size_t at = index_of(p, d);
        if (p->some_opaque[at] && !p->opaque[at]) {
            memcpy(e[in_e++], d, sizeof d);
            was_in_e[at] = 1;
        }
    }
    while (in_e > 0) {
        int d[3], n[3];
        memcpy(d, e[--in_e], sizeof d); /* E = E - {d} */
        for (int j = 0; j < 6; j++) {
            if (!neighbour(p, d, j, n))
                continue;
            size_t at = index_of(p, n);
            if (p->opaque[at]) {
                p->in_set[at] = 1; /* T = T + {n} */
            } else if (p->some_opaque[at] && !was_in_e[at]) { /* along the shrinking direction: towards the opaque side */
                memcpy(e[in_e++], n, sizeof n);
                was_in_e[at] = 1;
            }
        }
    }
    EACH_CUBE(p, d)
        if (p->opaque[index_of(p, d)] && at_boundary(p, d))
            p->in_set[index_of(p, d)] = 1;
    for (size_t i = 0; i < cubes; i++)
        count += p->in_set[i];
    free(was_in_e);
    free(e);
    return count;
}

/* The faces are those of the set's cubes that have nothing of `solid` behind them, each once. */
static void check_faces(const struct pel_cube_set *set, const struct plain *p, const uint8_t *solid)
{
    size_t wanted = 0, got = 0;
    EACH_CUBE(p, c)
        for (int d = 0; d < 6; d++) {
            int n[3];
            wanted += solid[index_of(p, c)] && (!neighbour(p, c, d, n) || !solid[index_of(p, n)]);
        }
    for (int d = 0; d < 6; d++)
        for (size_t f = set->first[d]; f < set->first[d + 1]; f++) {
            uint32_t a = set->faces[f].a, b = set->faces[f].b;
            assert_int_equal(b >> 16 & 7, d);
            for (uint32_t i = 0; i < b >> 19; i++, got++) {
                int c[3] = { (int)(a & 0xffff) + (int)i, (int)(a >> 16), (int)(b & 0xffff) }, n[3];
                assert_true(p->in_set[index_of(p, c)]); /* of the figure's set */
                assert_true(!neighbour(p, c, d, n) || !solid[index_of(p, n)]);
                for (int k = 0; k < 3; k++)
                    assert_true(c[k] >= set->lo[k] && c[k] < set->hi[k]);
            }
        }
    assert_int_equal(got, wanted);
}

static void check_sets(const struct pel_volume *v, const char *opacity, double threshold)
{
    struct pel_transfer t;
    struct pel_transfer_table table = { 0 };
    struct pel_octree o;
    static struct pel_cube_table classes;
    struct pel_cube_set set_t = { 0 }, set_p = { 0 };
    assert_true(pel_transfer_init(&t, NULL) && pel_transfer_parse_opacity(&t, opacity, NULL));
    assert_true(pel_transfer_table_build(&table, &t, v->range[0], v->range[1], NULL));
    assert_true(pel_octree_init(&o, v, 1, 2, NULL));
    pel_cube_table_build(&classes, &o, &table);
    for (int level = 1; level <= 3; level++) {
        struct plain p;
        memcpy(p.n, o.levels[level].dims, sizeof p.n);
        classify(&p, v, &t, level, threshold);
        size_t count = figure_5(&p), cubes = (size_t)p.n[0] * (size_t)p.n[1] * (size_t)p.n[2];
        assert_true(pel_cubes_extract_t(&set_t, &o, &classes, level, 2, NULL));
        assert_int_equal(set_t.cubes, count);
        uint8_t *solid = calloc(cubes, 1);
        for (size_t i = 0; i < cubes; i++)
            solid[i] = p.class[i] != PEL_CUBE_EMPTY;
        check_faces(&set_t, &p, solid);
        count = figure_8(&p);
        assert_true(pel_cubes_extract_p(&set_p, &o, &classes, level, threshold, true, 2, NULL));
        assert_int_equal(set_p.cubes, count);
        check_faces(&set_p, &p, p.opaque);
        for (size_t i = 0; i < cubes; i++)
            assert_int_equal(set_p.opacity[i] > 0, p.opaque[i]);
        assert_true(pel_cubes_extract_p(&set_p, &o, &classes, level, threshold, false, 2, NULL));
        for (size_t i = 0; i < cubes; i++)
            assert_true(set_p.opacity[i] ? p.some_opaque[i] : !p.opaque[i]); /* between the two */
        free(solid);
        free(p.class);
    }
    pel_cubes_finish(&set_t);
    pel_cubes_finish(&set_p);
    pel_octree_finish(&o);
    pel_transfer_table_finish(&table);
    pel_transfer_finish(&t);
}

/* Values in steps of 1, so that both ways of classifying see the same opacities at the bins' ends; bands, shells, interiors below the
 * threshold; jumps lie between values. */
static void test_figures(void **state)
{
    (void)state;
    static const char *const curves[] = {
        "0:0,99.5:0,99.5:0.5,149.5:0.5,149.5:1,255:1",                          /* the paper's two thresholds */
        "0:1,79.5:1,79.5:0.3,119.5:0.3,119.5:0,255:0",                          /* interiors below the isovalue */
        "0:0,59.5:0,59.5:1,69.5:1,69.5:0,109.5:0,109.5:0.2,149.5:0.2,149.5:1,189.5:1,189.5:0,255:0", /* opaque shells in translucent stuff */
        "0:1,255:1", "0:0,255:0",
    };
    static const size_t dims[][3] = { { 37, 30, 41 }, { 140, 9, 11 } };
    for (int d = 0; d < 2; d++)
        for (int holes = 0; holes < 2; holes++) {
            struct pel_volume v;
            make(&v, dims[d], PEL_U8, holes);
            for (size_t i = 0; i < sizeof curves / sizeof *curves; i++)
                if (!holes || i > 2) /* with voids bins are wider than a value, and cubes at jumps are called mixed */
                    check_sets(&v, curves[i], 1);
            pel_volume_finish(&v);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_octree), cmocka_unit_test(test_figures) };
    return cmocka_run_group_tests_name("cubes", tests, NULL, NULL);
}
