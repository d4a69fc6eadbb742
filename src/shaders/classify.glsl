// SPDX-License-Identifier: MIT
// Which cells may be seen: the greatest opacity over the cell's interval of values from the range table in O(1), or an isovalue in it. 0: may be seen.
#include "job.glsl"
#include "isovalues.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 2) uniform sampler3D grid;
layout(r8ui, binding = 0) writeonly uniform uimage3D marks;
layout(std430, binding = 3) buffer Seen { uint seen_cells; };
// Greatest opacity of the 2^level entries from an entry on; `levels` rows of `count`.
layout(std430, binding = 4) readonly buffer Range { int count; int levels; float most[]; };

bool may_be_seen(float least, float greatest)
{
    if (least > greatest)
        return false; // voids only
#if MODE == MODE_ISOSURFACE
    return holds_isovalue(least, greatest);
#elif MODE == MODE_MIP
    return job.gradient.y != 0.0 || greatest > job.range.x;
#elif MODE == MODE_MINIP
    return job.gradient.y != 0.0 || least < job.range.y;
#else
    int from = clamp(int(least * job.table.x + job.table.y - 0.01), 0, count - 1), to = clamp(int(greatest * job.table.x + job.table.y + 0.01), 0, count - 1);
    int level = findMSB(uint(to - from + 1));
    return max(most[level * count + from], most[level * count + to + 1 - (1 << level)]) > 0.0;
#endif
}

void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, job.cells.xyz)))
        return;
    vec2 range = texelFetch(grid, cell, 0).rg;
    bool seen = may_be_seen(range.x, range.y);
    imageStore(marks, cell, uvec4(seen ? 0u : 1u));
    if (seen)
        atomicAdd(seen_cells, 1u);
}
