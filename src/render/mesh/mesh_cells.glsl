// SPDX-License-Identifier: MIT
// Marching cubes on the device: what all passes of the extraction know of voxels and cells (mesh_extraction.c). A brick is a cell of the min-max grid, 4^3 cells of eight voxels; those that
// the surface may pass through have a slot each. Item 64 slot + x + 4 y + 16 z is the voxel (x, y, z) of a brick: the edges that go on from it along the axes, and the cell that begins there.
#include "job.glsl"
#include "sampling.glsl"
layout(location = 0) uniform int surface; // by rising isovalue
layout(location = 1) uniform uint count;  // invocations that have something to do
layout(std430, binding = 0) readonly buffer CellTable {
    uint cell_case[256];      // first entry, and from bit 16 on the faces that have two ways (cell_table.h)
    uint cell_entry[656][13]; // triangles, from bit 8 on the edges around a centre; then the corners of each triangle, four bits an edge, 12 for the centre
};
layout(std430, binding = 1) MESH_BRICKS buffer BrickList { uint brick_list[]; }; // brick of each slot

// Corners of the faces, counter-clockwise as seen from outside.
const int face_corner[24] = int[](4, 6, 2, 0, 1, 3, 7, 5, 1, 5, 4, 0, 2, 6, 7, 3, 2, 3, 1, 0, 4, 5, 7, 6);

ivec3 offset_of(int corner)
{
    return ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
}

ivec3 voxel_of(uint item)
{
    int brick = int(brick_list[item >> 6]), local = int(item & 63u);
    ivec3 b = ivec3(brick % job.cells.x, brick / job.cells.x % job.cells.y, brick / (job.cells.x * job.cells.y));
    return 4 * b + ivec3(local & 3, local >> 2 & 3, local >> 4);
}

// Less the isovalue; NaN for a void.
float value_at(ivec3 at)
{
    return voxel(at) - job.iso[surface].x;
}

bool is_cell(ivec3 at)
{
    return all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at + 1, job.dims.xyz));
}

// The cell's case; 0, which cuts nothing, where it has a void.
uint case_of(const float v[8])
{
    uint inside = 0u;
    bool whole = true;
    for (int i = 0; i < 8; i++) {
        inside |= v[i] >= 0.0 ? 1u << i : 0u;
        whole = whole && !isnan(v[i]);
    }
    return whole ? inside : 0u;
}

// Where insides join on a face that has two ways: the asymptotic decider, as mesh_cell.c has it. Both cells beside the face must come to the same.
uint entry_of(const float v[8], uint inside)
{
    uint known = cell_case[inside], way = 0u, ways = 0u;
    for (int face = 0; face < 6; face++) {
        if ((known >> (16 + face) & 1u) == 0u)
            continue;
        int c = 4 * face;
        precise float even = v[face_corner[c]] * v[face_corner[c + 2]], odd = v[face_corner[c + 1]] * v[face_corner[c + 3]];
        bool even_inside = (inside >> face_corner[c] & 1u) != 0u;
        way |= uint(even_inside ? even >= odd : odd >= even) << ways++;
    }
    return (known & 0xffffu) + way;
}

void load_cell(ivec3 at, out float v[8])
{
    for (int i = 0; i < 8; i++)
        v[i] = value_at(at + offset_of(i));
}

// Whether a cell without voids has the edge.
bool edge_counts(ivec3 at, int axis)
{
#ifdef VOIDS
    for (int side = 0; side < 4; side++) {
        ivec3 cell = at;
        cell[(axis + 1) % 3] -= side & 1;
        cell[(axis + 2) % 3] -= side >> 1;
        if (!is_cell(cell))
            continue;
        bool whole = true;
        for (int i = 0; i < 8; i++)
            whole = whole && !isnan(voxel(cell + offset_of(i)));
        if (whole)
            return true;
    }
    return false;
#else
    return true;
#endif
}

// Which of a voxel's edges are cut, given the values at it and one on along each axis; a bit each.
uint cuts_of(ivec3 at, float here, vec3 next)
{
    uint cuts = 0u;
    for (int axis = 0; axis < 3; axis++)
        if (at[axis] + 1 < job.dims[axis] && (here >= 0.0) != (next[axis] >= 0.0) && edge_counts(at, axis))
            cuts |= 1u << axis;
    return cuts;
}
