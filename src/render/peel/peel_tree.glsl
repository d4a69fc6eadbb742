// SPDX-License-Identifier: MIT
// The rival: segments by traversing a min-max tree along each ray, in the spirit of kd-jump (Hughes and Lim 2009; section 6.1.1). No stack: a ray goes down where its node may hold a surface,
// passes over the node where it does not, and then looks one level higher. A new isovalue needs no new tree.
#define TREE_ACCESS readonly
#include "peel_nodes.glsl"
#include "isovalues.glsl"

uint segments;   // stretches given so far
ivec3 leaf;      // the macro-cell in which the ray is
int level;       // of the node around it that is asked next
float tree_at;   // steps along the ray
bool tree_left;  // the ray is out of the tree

void segments_begin(const Ray r)
{
    segments = 0u;
    level = peel.wide.y - 1;
    leaf = clamp(ivec3(floor(r.o / float(peel.grid.w))), ivec3(0), peel.grid.xyz - 1);
    tree_at = 0.0;
    tree_left = false;
}

bool node_holds(ivec3 node, int level)
{
    vec2 range = node_range(node, level);
    return peel.wide.x != 0 || (range.x <= range.y && holds_isovalue(range.x, range.y));
}

bool next_segment(ivec2 pixel, const Ray r, out vec2 stretch)
{
    vec3 side = mix(vec3(1.0), vec3(0.0), lessThan(r.inverse, vec3(0.0))), slow = abs(r.inverse);
    bvec3 single = equal(job.dims.xyz, ivec3(1));
    float beyond = 8e-3 * min(min(slow.x, slow.y), slow.z);
    while (!tree_left) {
        ivec3 node = leaf >> level, low = node << level, high = low + (1 << level) - 1;
        bool holds = node_holds(node, level);
        if (holds && level > 0) {
            level--;
            continue;
        }
        vec3 exits = mix(((vec3(node) + side) * float(peel.grid.w << level) - r.o) * r.inverse, vec3(1e30), single);
        float leave = min(min(exits.x, exits.y), exits.z);
        stretch = vec2(tree_at - beyond, max(tree_at, leave) + beyond);
        tree_at = max(tree_at, leave);
        // The next leaf is behind the face by which the ray leaves, and across it within the node.
        ivec3 across = clamp(ivec3(floor((r.o + tree_at * r.d) / float(peel.grid.w))), low, high), behind = mix(low - 1, high + 1, greaterThan(side, vec3(0.5)));
        leaf = mix(across, behind, lessThanEqual(exits, vec3(leave)));
        tree_left = tree_at > float(r.n) || any(lessThan(leaf, ivec3(0))) || any(greaterThanEqual(leaf, peel.grid.xyz));
        if (holds) {
            segments++;
            return true;
        }
        level = min(level + 1, peel.wide.y - 1);
    }
    return false;
}
