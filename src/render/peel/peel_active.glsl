// SPDX-License-Identifier: MIT
// Section 4.1, whenever an isovalue changes: which macro-cells are active, as the counts at the base of a HistoPyramid, 1 or 0. An invocation asks for 16 cells that follow each other.
#include "job.glsl"
#include "isovalues.glsl"
#include "sampling.glsl"
#include "peel_block.glsl"
#include "histopyramid_base.glsl"
layout(binding = 2) uniform sampler3D ranges;

bool active_cell(ivec3 cell)
{
    vec2 range = texelFetch(ranges, cell, 0).rg;
    return peel.wide.x != 0 || (range.x <= range.y && holds_isovalue(texel_to_raw(range.x), texel_to_raw(range.y)));
}

void main()
{
    uint group = histo_invocation(), items = uint(peel.grid.x) * uint(peel.grid.y) * uint(peel.grid.z);
    if (16u * group >= items)
        return;
    uint row = 16u * group / uint(peel.grid.x);
    ivec3 cell = ivec3(16u * group - row * uint(peel.grid.x), row % uint(peel.grid.y), row / uint(peel.grid.y));
    uvec4 counts = uvec4(0u);
    for (int i = 0; i < 16 && 16u * group + uint(i) < items; i++) {
        counts[i >> 2] |= uint(active_cell(cell)) << (8 * (i & 3));
        if (++cell.x == peel.grid.x) {
            cell.x = 0;
            if (++cell.y == peel.grid.y) {
                cell.y = 0;
                cell.z++;
            }
        }
    }
    histo_base[group] = counts;
}
