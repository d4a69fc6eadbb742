// SPDX-License-Identifier: MIT
// Which tiles of 8x8 pixels have a mask that is not empty, in a list for each strip of them, the groups of its dispatch: where no ray has a segment none is cast. An invocation a tile.
#include "peel_block.glsl"
layout(local_size_x = 64) in;
layout(binding = 5) uniform usampler2DArray masks;
layout(location = 0) uniform ivec4 strips; // tiles: columns, rows; rows of a strip; strips
layout(std430, binding = 8) buffer Tiles { uint tiles[]; }; // a strip's dispatch (n, 1, 1, 0) for each; then a strip's tiles for each: x + 65536 y

void main()
{
    int number = int(gl_GlobalInvocationID.x), layers = (peel.major.z + peel.major.w - 1) / peel.major.w;
    ivec2 at = ivec2(number % strips.x, number / strips.x);
    if (at.y >= strips.y)
        return;
    uint seen = 0u;
    for (int i = 0; i < 64 && seen == 0u; i++)
        for (int layer = 0; layer < layers; layer++)
            seen |= texelFetch(masks, ivec3(8 * at + ivec2(i & 7, i >> 3), layer), 0).r;
    if (seen == 0u)
        return;
    int strip = at.y / strips.z;
    uint place = uint(4 * strips.w + strip * strips.x * strips.z) + atomicAdd(tiles[4 * strip], 1u);
    tiles[place] = uint(at.x) | uint(at.y) << 16;
}
