// SPDX-License-Identifier: MIT
// Section 4.1, once a volume: least and greatest voxel of each macro-cell, as texels. A surface that is cut by voids ends in cells that have values on one side of it only: where a cell has
// a void, its neighbours' voxels count, too. 1, 0 (of floats: greatest, least) where a cell holds nothing but voids.
#include "job.glsl"
#include "sampling.glsl"
#include "peel_block.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 0) writeonly uniform image3D ranges;

// Gives whether there is a void among the voxels from `first` to `last`.
bool gather_range(ivec3 first, ivec3 last, inout vec2 range)
{
    bool voids = false;
    for (int z = first.z; z <= last.z; z++)
        for (int y = first.y; y <= last.y; y++)
            for (int x = first.x; x <= last.x; x++) {
#ifdef VOIDS
                if (isnan(voxel(ivec3(x, y, z)))) {
                    voids = true;
                    continue;
                }
#endif
                float texel = texelFetch(volume, ivec3(x, y, z), 0).r;
                range = vec2(min(range.x, texel), max(range.y, texel));
            }
    return voids;
}

void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, peel.grid.xyz)))
        return;
    ivec3 most = job.dims.xyz - 1, first = cell * peel.grid.w, last = min(first + peel.grid.w, most);
    vec2 range = vec2(3.4e38, -3.4e38);
    if (gather_range(first, last, range))
        gather_range(max(first - 1, ivec3(0)), min(last + 1, most), range);
    imageStore(ranges, cell, vec4(range, 0.0, 0.0));
}
