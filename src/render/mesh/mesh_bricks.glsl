// SPDX-License-Identifier: MIT
// Which bricks a surface may pass through: counts for the pyramid of bricks.
#include "job.glsl"
#include "histopyramid_base.glsl"
layout(location = 0) uniform int surface;
layout(location = 1) uniform uint count;                                           // groups of 16 bricks
layout(location = 2) uniform uint bricks;
layout(std430, binding = 0) readonly buffer BrickBounds { vec2 brick_bounds[]; }; // least and greatest raw value

void main()
{
    uint g = histo_invocation();
    if (g >= count)
        return;
    uvec4 counts = uvec4(0u);
    for (uint i = 0u; i < 16u; i++)
        if (16u * g + i < bricks) {
            vec2 bounds = brick_bounds[16u * g + i];
            counts[i >> 2] |= uint(bounds.x < job.iso[surface].x && bounds.y >= job.iso[surface].x) << 8u * (i & 3u);
        }
    histo_base[g] = counts;
}
