// SPDX-License-Identifier: MIT
// Distances in cells to the nearest cell that may be seen: a map for each octant of directions, the eight side by side as the octants are (distance.glsl).
layout(binding = 1) uniform usampler3D distances;

#ifdef BRICKS
#define FIRST_CELL job.first_cell.xyz
#else
#define FIRST_CELL ivec3(0)
#endif

// Distance of a cell of the part that is drawn.
int distance_of(const Ray r, ivec3 cell)
{
    return int(texelFetch(distances, cell - FIRST_CELL + (ivec3(r.octant, r.octant >> 1, r.octant >> 2) & 1) * job.cells.xyz, 0).r);
}

// Steps to where the ray leaves the cube of cells from `cell - reach` to `cell + reach`, `size` voxels each.
float cube_exit(const Ray r, ivec3 cell, int reach, float size)
{
    vec3 side = mix(vec3(reach + 1), vec3(-reach), lessThan(r.inverse, vec3(0.0)));
    vec3 exits = ((vec3(cell) + side) * size - r.o) * r.inverse;
    return min(min(exits.x, exits.y), exits.z);
}
