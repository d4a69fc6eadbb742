// SPDX-License-Identifier: MIT
// How many vertices and how many triangles each item gives, for their pyramids; an invocation does a layer of a brick.
#define MESH_BRICKS readonly
#include "mesh_cells.glsl"
#include "histopyramid_base.glsl"
layout(std430, binding = 7) writeonly buffer TriangleCounts { uvec4 triangle_counts[]; };

void main()
{
    uint g = histo_invocation();
    if (g >= count)
        return;
    ivec3 first = voxel_of(16u * g);
    float layer[50];
    for (int i = 0; i < 50; i++)
        layer[i] = value_at(first + ivec3(i % 5, i / 5 % 5, i / 25));
    uvec4 vertices = uvec4(0u), triangles = uvec4(0u);
    for (int i = 0; i < 16; i++) {
        ivec3 at = first + ivec3(i & 3, i >> 2, 0);
        if (any(greaterThanEqual(at, job.dims.xyz)))
            continue;
        int corner = i % 4 + 5 * (i / 4);
        uint cuts = cuts_of(at, layer[corner], vec3(layer[corner + 1], layer[corner + 5], layer[corner + 25])), head = 0u;
        if (is_cell(at)) {
            float v[8];
            for (int k = 0; k < 8; k++)
                v[k] = layer[corner + (k & 1) + 5 * (k >> 1 & 1) + 25 * (k >> 2)];
            uint inside = case_of(v);
            if (inside != 0u && inside != 255u)
                head = cell_entry[entry_of(v, inside)][0];
        }
        uint shift = 8u * uint(i & 3);
        vertices[i >> 2] |= (uint(bitCount(cuts)) + uint(head > 255u)) << shift;
        triangles[i >> 2] |= (head & 255u) << shift;
    }
    histo_base[g] = vertices;
    triangle_counts[g] = triangles;
}
