// SPDX-License-Identifier: MIT
// A triangle of the surface: the numbers of its corners, which belong to voxels of this or of neighbouring bricks.
#define MESH_BRICKS readonly
#include "mesh_cells.glsl"
#include "histopyramid.glsl"
#include "histopyramid_invocation.glsl"
layout(std430, binding = 2) readonly buffer BrickSlots { uint brick_slot[]; };
layout(std430, binding = 3) readonly buffer FirstVertices { uint first_vertex[]; };
layout(std430, binding = 7) writeonly buffer Elements { uint elements[]; };

// Vertex of a voxel: of its edge along an axis, or the centre in its cell (3).
uint vertex_of(ivec3 at, int which)
{
    ivec3 b = at >> 2, local = at & 3;
    uint slot = brick_slot[b.x + job.cells.x * (b.y + job.cells.y * b.z)], word = first_vertex[64u * slot + uint(local.x + 4 * local.y + 16 * local.z)];
    return (word & 0x0fffffffu) + uint(bitCount(word >> 28 & ((1u << which) - 1u)));
}

void main()
{
    uint number = histo_invocation();
    if (number >= count)
        return;
    uvec2 from = histo_find(number);
    ivec3 at = voxel_of(from.x);
    float v[8];
    load_cell(at, v);
    uint corners = cell_entry[entry_of(v, case_of(v))][1u + from.y];
    for (int i = 0; i < 3; i++) {
        int edge = int(corners >> 4 * i & 15u), axis = edge >> 2;
        int low = (edge & 1) << (axis == 0 ? 1 : 0) | (edge >> 1 & 1) << (axis == 2 ? 1 : 2);
        elements[3u * number + uint(i)] = edge == 12 ? vertex_of(at, 3) : vertex_of(at + offset_of(low), axis);
    }
}
