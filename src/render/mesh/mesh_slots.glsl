// SPDX-License-Identifier: MIT
// Gives the bricks that a surface may pass through their slots, and slots their bricks.
#define MESH_BRICKS
#include "mesh_cells.glsl"
#include "histopyramid.glsl"
#include "histopyramid_invocation.glsl"
layout(std430, binding = 2) writeonly buffer BrickSlots { uint brick_slot[]; };

void main()
{
    uint slot = histo_invocation();
    if (slot >= count)
        return;
    uint brick = histo_find(slot).x;
    brick_list[slot] = brick;
    brick_slot[brick] = slot;
}
