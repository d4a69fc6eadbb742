/* SPDX-License-Identifier: MIT */
/* A slab of a surface: what lies in one layer of the min-max grid's cells ("bricks" here, of 4^3 cells of eight voxels). Slabs know nothing
 * of one another, so threads can make them in any order; mesh_extract.c then joins them at their seams. */
#ifndef PEL_DATA_MESH_SLAB_H
#define PEL_DATA_MESH_SLAB_H

#include <pellucid/mesh.h>

#include "cell_table.h"
#include "minmax.h"

/* What all slabs of a surface share. */
struct pel_mesh_work {
    const struct pel_volume *volume;
    const struct pel_minmax *minmax;
    const struct pel_cell_table *table;
    double isovalue;
    double tolerance;      /* as in struct pel_mesh_params */
    double to_world[3][3]; /* columns: a step along each index axis, in the world */
    double normal[3][3];   /* from an index gradient to a world one: the inverse transpose */
    bool mirrored;         /* the axes are left-handed: triangles turn the other way in the world */
};

/* A vertex on the lowest or highest voxel plane of a slab. Both slabs beside a seam have it; the keys are in rising order, and alike. */
struct pel_mesh_seam {
    uint64_t key;
    uint32_t vertex;
};

struct pel_mesh_slab {
    size_t vertex_count, triangle_count, seam_count[2];
    float (*positions)[3], (*normals)[3]; /* owned, as all arrays here; as in struct pel_mesh */
    uint32_t (*triangles)[3];             /* vertices of this slab */
    struct pel_mesh_seam *seams[2];       /* lowest plane, highest plane */
    size_t vertex_room, triangle_room, seam_room[2];
};

/* Bytes of what a thread needs for its slabs. */
size_t pel_mesh_scratch_bytes(const struct pel_minmax *minmax);

/* Makes the slab of the bricks in layer bz. The slab must be zeroed. */
bool pel_mesh_slab_make(struct pel_mesh_slab *slab, const struct pel_mesh_work *work, size_t bz, void *scratch, struct pel_error *error);
void pel_mesh_slab_finish(struct pel_mesh_slab *slab); /* accepts a zeroed one */

/* Append to the slab. */
bool pel_mesh_add_vertices(struct pel_mesh_slab *slab, const float (*positions)[3], const float (*normals)[3], size_t count, uint32_t *first,
                           struct pel_error *error);
/* Room for this many triangles more. */
bool pel_mesh_reserve_triangles(struct pel_mesh_slab *slab, size_t count, struct pel_error *error);
bool pel_mesh_add_triangle(struct pel_mesh_slab *slab, uint32_t a, uint32_t b, uint32_t c, struct pel_error *error);

#endif
