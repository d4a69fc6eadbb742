// SPDX-License-Identifier: MIT
// A vertex of the surface: where its edge is cut, or the mean of the cuts around a centre; with the gradient there. The first of an item also leaves word where the item's vertices begin.
#define MESH_BRICKS readonly
#include "mesh_cells.glsl"
#include "histopyramid.glsl"
#include "histopyramid_invocation.glsl"
layout(std430, binding = 3) writeonly buffer FirstVertices { uint first_vertex[]; }; // number of an item's first vertex, and from bit 28 on which there are: of its edges, of its cell
layout(std430, binding = 4) writeonly buffer Points { float points[]; };             // place and gradient, index space

// Central difference; beyond the volume is the last voxel, and a void counts as the voxel itself (mesh_cell.c).
vec3 slope(ivec3 at)
{
    float here = voxel(at);
    vec3 g;
    for (int a = 0; a < 3; a++) {
        ivec3 e = ivec3(a == 0, a == 1, a == 2);
        float low = voxel(at - e), high = voxel(at + e);
        g[a] = (isnan(high) ? here : high) - (isnan(low) ? here : low);
    }
    return g * (0.5 * job.gradient.x);
}

float cut_at(float low, float high)
{
    return clamp(low / (low - high), 0.0, 1.0);
}

// The mean of the cuts of a loop's edges, in the cell.
vec3 middle_of(const float v[8], uint edges)
{
    vec3 sum = vec3(0.0);
    for (int edge = 0; edge < 12; edge++) {
        if ((edges >> edge & 1u) == 0u)
            continue;
        int axis = edge >> 2, low = (edge & 1) << (axis == 0 ? 1 : 0) | (edge >> 1 & 1) << (axis == 2 ? 1 : 2);
        vec3 place = vec3(offset_of(low));
        place[axis] = cut_at(v[low], v[low | 1 << axis]);
        sum += place;
    }
    return sum / float(bitCount(edges));
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
    uint cuts = cuts_of(at, v[0], vec3(v[1], v[2], v[4])), inside = case_of(v), head = 0u;
    if (is_cell(at) && inside != 0u && inside != 255u)
        head = cell_entry[entry_of(v, inside)][0];
    if (from.y == 0u)
        first_vertex[from.x] = number | (cuts | (head > 255u ? 8u : 0u)) << 28;
    vec3 place, g;
    if (from.y < uint(bitCount(cuts))) {
        int axis = findLSB(cuts);
        for (uint k = 0u; k < from.y; k++)
            axis = findLSB(cuts & ~((2u << axis) - 1u));
        ivec3 e = ivec3(axis == 0, axis == 1, axis == 2);
        float part = cut_at(v[0], v[1 << axis]);
        place = part * vec3(e);
        g = mix(slope(at), slope(at + e), part);
        if (g == vec3(0.0)) // the differences cancel (mesh_cell.c)
            g[axis] = v[0] >= 0.0 ? -1.0 : 1.0;
    } else {
        place = middle_of(v, head >> 8);
        g = vec3(0.0);
        for (int corner = 0; corner < 8; corner++) {
            vec3 o = vec3(offset_of(corner)), w = o * place + (1.0 - o) * (1.0 - place);
            g += w.x * w.y * w.z * slope(at + offset_of(corner));
        }
    }
    if (g == vec3(0.0))
        for (int corner = 0; corner < 8; corner++)
            g += (2.0 * vec3(offset_of(corner)) - 1.0) * (v[corner] >= 0.0 ? 1.0 : -1.0);
    // Of unit length in the world: between vertices directions are to be mixed, and not how steep the signal is.
    float length2 = dot(job.metric[0].xyz, g * g) + job.metric[0].w * g.x * g.y + job.metric[1].x * g.x * g.z + job.metric[1].y * g.y * g.z;
    g *= length2 > 1e-30 && length2 <= 3.4e38 ? inversesqrt(length2) : 1.0;
    place += vec3(at);
    for (int a = 0; a < 3; a++) {
        points[6u * number + uint(a)] = place[a];
        points[6u * number + 3u + uint(a)] = g[a];
    }
}
