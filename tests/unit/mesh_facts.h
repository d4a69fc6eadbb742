/* SPDX-License-Identifier: MIT */
/* What the tests of meshes share: volumes of noise, extraction that must not fail, and facts of what came of it. */
#ifndef PEL_TESTS_MESH_FACTS_H
#define PEL_TESTS_MESH_FACTS_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/pellucid.h>

/* The same numbers wherever the test runs, 0 to 1. */
extern unsigned seed;
double random_number(void);

/* Floats from 0 to 1 (smooth), or bytes of which many are the isovalue itself. */
void make_noise(struct pel_volume *v, size_t nx, size_t ny, size_t nz, bool smooth);

struct pel_mesh *extract(const struct pel_volume *v, double isovalue, int threads);
struct pel_mesh *extract_within(const struct pel_volume *v, double isovalue, double tolerance, int threads);
void expect_same(const struct pel_mesh *a, const struct pel_mesh *b);

/* An edge as a triangle goes along it. */
struct edge {
    uint32_t a, b;
};
int compare_edges(const void *p, const void *q);
struct edge *sorted_edges(const struct pel_mesh *mesh); /* of all triangles; free it */

/* The index position of a vertex. */
void index_of(const struct pel_volume *v, const struct pel_mesh *mesh, size_t vertex, double index[3]);

/* No crack and nothing twice: each edge is gone along once in each direction, but for those on the volume's border, which are gone
 * along once in all. Every vertex is used. Returns V - E + F. */
long expect_watertight(const struct pel_volume *v, const struct pel_mesh *mesh);

/* Six times the volume that a closed mesh encloses: positive where its triangles look outwards. */
double enclosed(const struct pel_mesh *mesh);

#endif
