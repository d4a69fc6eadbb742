// SPDX-License-Identifier: MIT
// The masks of section 4.2 without a rasteriser: an invocation an active cell, which goes over the pixels that it covers; cells that cover many are left for the whole work group.
#include "peel_cover.glsl"
#include "histopyramid_invocation.glsl"
layout(r32ui, binding = 0) coherent uniform uimage2DArray masks; // 32 slices a layer: atomics have no 16 bits
layout(location = 0) uniform uint active_cells;

const int MANY = 256; // pixels
shared uint large_count;
shared Cover large[64];

// The pixels number `i`, `i` + `step`, ... of a cover.
void mark(Cover cover, int i, int step)
{
    ivec2 first = ivec2(ceil(cover.bound.xy)), size = ivec2(floor(cover.bound.zw)) - first + 1;
    for (; i < size.x * size.y; i += step) {
        ivec2 pixel = first + ivec2(i % size.x, i / size.x);
#ifdef DISC
        vec2 away = vec2(pixel) - cover.disc.xy;
        if (dot(away, away) > cover.disc.z * cover.disc.z)
            continue;
#endif
        ivec3 at = ivec3(pixel, cover.layer);
        if ((imageLoad(masks, at).r & cover.bit) == 0u)
            imageAtomicOr(masks, at, cover.bit);
    }
}

void main()
{
    uint number = histo_invocation();
    if (gl_LocalInvocationIndex == 0u)
        large_count = 0u;
    barrier();
    Cover cover;
    if (number < active_cells && cover_of(histo_find(number).x, cover)) {
        vec2 size = cover.bound.zw - cover.bound.xy + 1.0;
        if (size.x * size.y > float(MANY))
            large[atomicAdd(large_count, 1u)] = cover;
        else
            mark(cover, 0, 1);
    }
    barrier();
    for (uint i = 0u; i < large_count; i++)
        mark(large[i], int(gl_LocalInvocationIndex), 64);
}
