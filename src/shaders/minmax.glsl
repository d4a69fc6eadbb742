// SPDX-License-Identifier: MIT
// The min-max grid: least and greatest voxel of each cell of 4^3 voxel steps (src/data/minmax.h); 1, 0 where a cell holds nothing but voids.
#include "job.glsl"
#include "sampling.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(rg32f, binding = 0) writeonly uniform image3D grid;

void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, job.cells.xyz)))
        return;
    vec2 found = vec2(3.4e38, -3.4e38);
    ivec3 last = min(cell * 4 + 4, job.dims.xyz - 1);
    for (int z = cell.z * 4; z <= last.z; z++)
        for (int y = cell.y * 4; y <= last.y; y++)
            for (int x = cell.x * 4; x <= last.x; x++) {
                float raw = voxel(ivec3(x, y, z));
                if (!isnan(raw))
                    found = vec2(min(found.x, raw), max(found.y, raw));
            }
    imageStore(grid, cell, vec4(found, 0.0, 0.0));
}
