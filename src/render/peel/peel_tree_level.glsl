// SPDX-License-Identifier: MIT
// A level of the min-max tree from the one below it.
#define TREE_ACCESS
#include "job.glsl"
#include "sampling.glsl"
#include "peel_block.glsl"
#include "peel_nodes.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(location = 0) uniform int level;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID), last = grid_of(level - 1) - 1;
    if (any(greaterThanEqual(node, grid_of(level))))
        return;
    vec2 range = vec2(3.4e38, -3.4e38);
    for (int i = 0; i < 8; i++) {
        vec2 child = node_range(min(2 * node + (ivec3(i, i >> 1, i >> 2) & 1), last), level - 1);
        if (child.x <= child.y) // else voids alone
            range = vec2(min(range.x, child.x), max(range.y, child.y));
    }
    tree_nodes[node_index(node, level)] = range;
}
