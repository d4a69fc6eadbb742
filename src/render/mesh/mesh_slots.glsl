// SPDX-License-Identifier: MIT
// Gives the bricks that a surface may pass through their slots, and slots their bricks.
#define MESH_BRICKS
#include "mesh_cells.glsl"
#include "histopyramid.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) writeonly buffer BrickSlots { uint brick_slot[]; };

void main()
{
    uint slot = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
    if (slot >= count)
        return;
    uint brick = histo_find(slot).x;
    brick_list[slot] = brick;
    brick_slot[brick] = slot;
}
