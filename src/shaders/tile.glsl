// SPDX-License-Identifier: MIT
// Work groups that are tiles of 8x8 pixels, and counters that all of them share.
layout(local_size_x = 64) in;
layout(location = 0) uniform ivec4 tile; // the first tile's place; z: see march.glsl; w: see below

// The group's tile, counted from the first.
#ifdef LISTED
layout(std430, binding = 8) readonly buffer Tiles { uint tiles[]; }; // peel_tiles.glsl; those of this dispatch begin at tile.w

ivec2 tile_of()
{
    uint listed = tiles[uint(tile.w) + gl_WorkGroupID.x];
    return ivec2(listed & 0xffffu, listed >> 16);
}
#else
ivec2 tile_of()
{
    return ivec2(gl_WorkGroupID.xy);
}
#endif

// Neighbouring lanes in blocks of 4x2 and 8x4 pixels: their rays go alike.
ivec2 pixel_of()
{
    int lane = int(gl_LocalInvocationIndex);
    return (tile.xy + tile_of()) * 8 + ivec2((lane & 3) | (lane >> 1 & 4), (lane >> 2 & 1) | (lane >> 3 & 6));
}

// Samples taken and samples in the box, low and high words; groups far apart share a row, so that few wait for each other.
layout(std430, binding = 2) buffer Counters { uvec4 counters[64]; };

#define COUNT(low, high, more)                                                  \
    {                                                                           \
        uint row = (gl_WorkGroupID.x + gl_WorkGroupID.y * 11u) & 63u;           \
        if (atomicAdd(counters[row].low, more) > 0xffffffffu - (more))          \
            atomicAdd(counters[row].high, 1u);                                  \
    }
#define COUNT_TAKEN(more) COUNT(x, y, more)
#define COUNT_IN_BOX(more) COUNT(z, w, more)
