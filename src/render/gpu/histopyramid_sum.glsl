// SPDX-License-Identifier: MIT
// One level of a HistoPyramid from the one below it: with BASE sums over 16 counts, else over four sums. An invocation writes four of them.
#define HISTO_ACCESS
#include "histopyramid_levels.glsl"
#include "histopyramid_invocation.glsl"
layout(std430, binding = 5) readonly buffer HistoBase { uvec4 histo_base[]; };
layout(location = 0) uniform uvec4 level; // sums that it has; where they start; where those below start; 1 for the highest

uint below(uint i)
{
    if (i >= level.x)
        return 0u;
#ifdef BASE
    uvec4 pairs = (histo_base[i] & 0x00ff00ffu) + (histo_base[i] >> 8 & 0x00ff00ffu);
    uint both = pairs.x + pairs.y + pairs.z + pairs.w;
    return (both & 0xffffu) + (both >> 16);
#else
    uvec4 four = histo_levels[level.z + i];
    return four.x + four.y + four.z + four.w;
#endif
}

void main()
{
    uint i = histo_invocation();
    if (4u * i >= level.x)
        return;
    uvec4 sums = uvec4(below(4u * i), below(4u * i + 1u), below(4u * i + 2u), below(4u * i + 3u));
    histo_levels[level.y + i] = sums;
    if (level.w != 0u) // it is a single uvec4 then
        histo_total = sums.x + sums.y + sums.z + sums.w;
}
