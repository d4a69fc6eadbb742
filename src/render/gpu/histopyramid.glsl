// SPDX-License-Identifier: MIT
// Looks outputs of a HistoPyramid up (histopyramid.h; Ziegler et al. 2006): from the top down, into the child whose outputs hold the one that is wanted.
#include "histopyramid_levels.glsl"
layout(std430, binding = 5) readonly buffer HistoBase { uvec4 histo_base[]; };

// Which of four the output falls into; what is left of its number is that within it.
uint histo_choose(uvec4 four, inout uint number)
{
    uvec3 ends = uvec3(four.x, four.x + four.y, four.x + four.y + four.z);
    uint before = number >= ends.z ? ends.z : number >= ends.y ? ends.y : number >= ends.x ? ends.x : 0u;
    uint child = uint(number >= ends.x) + uint(number >= ends.y) + uint(number >= ends.z);
    number -= before;
    return child;
}

// Item of an output, and which of the item's own outputs it is. `number` must be below histo_total.
uvec2 histo_find(uint number)
{
    uint at = 0u;
    for (int l = int(histo_top); l >= 0; l--)
        at = 4u * at + histo_choose(histo_levels[histo_offsets[l] + at], number);
    uvec4 bytes = histo_base[at], pairs = (bytes & 0x00ff00ffu) + (bytes >> 8 & 0x00ff00ffu);
    uint word = histo_choose((pairs & 0xffffu) + (pairs >> 16), number), four = bytes[word];
    uint item = histo_choose(uvec4(four, four >> 8, four >> 16, four >> 24) & 0xffu, number);
    return uvec2(16u * at + 4u * word + item, number);
}
