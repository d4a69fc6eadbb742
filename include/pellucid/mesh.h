/* SPDX-License-Identifier: MIT */
/* Mesh: isosurfaces as triangles, in the world, for programs that want surfaces and not pictures (printing, simulation, other viewers).
 *
 * The triangles are those of marching cubes, with the ambiguous faces of cells decided by the trilinear signal, so that neighbours agree: a
 * surface has no cracks, and every edge inside the volume belongs to exactly two triangles. A surface is open where it leaves the
 * volume's box or meets a void. Triangles go counter-clockwise, and normals point, to the side of the lesser values.
 * The same volume and isovalue give the same bytes on any number of threads. */
#ifndef PELLUCID_MESH_H
#define PELLUCID_MESH_H

#include <stdint.h>

#include <pellucid/scene.h>
#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The surface of one isovalue: a run of vertices and the run of triangles that use them. */
struct pel_mesh_part {
    double isovalue;
    size_t first_vertex, vertex_count;
    size_t first_triangle, triangle_count; /* both counts 0 where no cell has values on both sides of the isovalue */
};

struct pel_mesh {
    double origin[3];      /* world; the volume's */
    size_t vertex_count;   /* at most 2^32 - 1 */
    float (*positions)[3]; /* owned; world = origin + position, in the volume's units. As offsets, floats are fine enough anywhere */
    float (*normals)[3];   /* owned; unit, world: the gradient of the ray caster (docs/optics.md), turned to the lesser values */
    size_t triangle_count;
    uint32_t (*triangles)[3]; /* owned; vertices of each */
    int part_count;
    struct pel_mesh_part parts[PEL_MAX_ISOSURFACES]; /* in the order of the isovalues asked for */
    enum pel_space space;                            /* what the volume says of its world */
    char units[16], name[128];
};

struct pel_mesh_params {
    double isovalues[PEL_MAX_ISOSURFACES]; /* finite */
    int isovalue_count;                    /* at least 1 */
    double tolerance; /* voxels: triangles are added where they would lie farther from the surface of the trilinear signal, which is curved
                         within cells: one vertex more on a side or amidst a loop. 0: marching cubes' own, with vertices on edges alone */
    int threads;      /* 0: as many as the machine (or OMP_NUM_THREADS) says */
    struct pel_progress progress;
};
#define PEL_MESH_PARAMS_INIT                                                                                                               \
    {                                                                                                                                      \
        { 0 }, 0, 0, 0,                                                                                                                    \
        {                                                                                                                                  \
            0, 0                                                                                                                           \
        }                                                                                                                                  \
    }

/* Extracts surfaces from a volume of one component and at least two samples along each axis. An isovalue that no cell reaches gives an
 * empty part, and is no error. The caller destroys the mesh. NULL on failure: PEL_ERROR_ARGUMENT for no or bad isovalues or several
 * components, PEL_ERROR_UNSUPPORTED for a flat volume or more vertices than 2^32 - 1, PEL_ERROR_MEMORY, PEL_ERROR_CANCELLED. */
struct pel_mesh *pel_mesh_extract(const struct pel_volume *volume, const struct pel_mesh_params *params, struct pel_error *error);
void pel_mesh_destroy(struct pel_mesh *mesh); /* accepts NULL */

/* World bounds of the vertices: xmin, xmax, ymin, ymax, zmin, zmax. False where there are none. */
bool pel_mesh_bounds(const struct pel_mesh *mesh, double bounds[6]);

/* Whether it is so far from the world's zero that floats are too coarse for places in the world: of their 24 bits fewer than 16 would be
 * left for places on the mesh. PLY and VTP are then written with doubles, OBJ with more digits; STL has floats alone. */
bool pel_mesh_is_far(const struct pel_mesh *mesh);

/* Makes vertices one that lie at one place and are joined by an edge: where voxels are exactly an isovalue, every edge that is cut there
 * has its vertex at the voxel, and triangles between them have no area. It is done where the surface stays what it was (closed where it
 * was closed, each part's V - E + F as before); what is all at one place is no surface, and left out (2 less in V - E + F where it was
 * closed). `flat_left` (nullable): triangles with two corners at one place that had to stay, as edges would have come to belong to four
 * triangles; a row of such voxels, with the surface all about it, has some. Parts and counts are set anew. False, with the mesh as it
 * was: PEL_ERROR_MEMORY. */
bool pel_mesh_collapse(struct pel_mesh *mesh, size_t *flat_left, struct pel_error *error);

/* Edges that belong to one triangle alone: 0 for a closed surface; negative: out of memory. Visits all edges. */
int64_t pel_mesh_open_edges(const struct pel_mesh *mesh);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
