// SPDX-License-Identifier: MIT
// Chebyshev distance from each cell to the nearest one that may be seen, towards one octant of directions (src/data/distance_map.h): separable, one pass an axis. The first reads the
// marks; each takes, along its axis, the least over i of the greater of i and what the pass before found i cells on.
#include "job.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 3) uniform usampler3D from;
layout(r8ui, binding = 0) writeonly uniform uimage3D to;
layout(location = 0) uniform ivec4 pass_of; // axis; octant; 1 in the last pass, which writes to the octant's place

const uint FAR = 250u;

void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, job.cells.xyz)))
        return;
    int axis = pass_of.x, side = (pass_of.y >> axis & 1) != 0 ? -1 : 1, room = side < 0 ? cell[axis] : job.cells[axis] - 1 - cell[axis];
    ivec3 step_of = ivec3(axis == 0, axis == 1, axis == 2) * side;
    uint best = FAR;
    for (int i = 0; i <= room && uint(i) < best; i++) {
        uint there = texelFetch(from, cell + i * step_of, 0).r;
        best = min(best, max(uint(i), axis == 0 ? (there == 0u ? 0u : FAR) : there));
    }
    imageStore(to, cell + pass_of.z * (ivec3(pass_of.y, pass_of.y >> 1, pass_of.y >> 2) & 1) * job.cells.xyz, uvec4(best));
}
