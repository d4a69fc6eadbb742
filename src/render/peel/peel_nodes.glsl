// SPDX-License-Identifier: MIT
// Ranges of values of the min-max tree's nodes: level 0 are the macro-cells, each further level has one node for eight.
layout(binding = 2) uniform sampler3D ranges;
layout(std430, binding = 8) TREE_ACCESS buffer Tree { vec2 tree_nodes[]; }; // raw values

ivec3 grid_of(int level)
{
    return (peel.grid.xyz - 1 >> level) + 1;
}

int node_index(ivec3 node, int level)
{
    ivec3 grid = grid_of(level);
    return peel.tree[level >> 2][level & 3] + node.x + grid.x * (node.y + grid.y * node.z);
}

vec2 node_range(ivec3 node, int level)
{
    if (level > 0)
        return tree_nodes[node_index(node, level)];
    vec2 texels = texelFetch(ranges, node, 0).rg;
    return vec2(texel_to_raw(texels.x), texel_to_raw(texels.y));
}
