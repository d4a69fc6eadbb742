// SPDX-License-Identifier: MIT
// Isosurfaces from voxel cell to voxel cell, exactly. Stretches of the ray in which there may be one are told by the distance maps.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "shading.glsl"
#include "gather.glsl"
#include "tile.glsl"
#include "distances.glsl"

vec2 part;      // of the ray: the volume's, or that of the brick that is drawn
ivec3 coarse;   // cell of 4^3 voxel steps that is asked next
float coarse_at; // where the ray comes into it; beyond the part's end where there is none

// The next visible cell. Which cell comes next is told by the faces that the ray leaves by and not by its place, so that rounding passes over none.
bool next_segment(ivec2 pixel, const Ray r, out vec2 stretch)
{
    stretch = part;
    if (job.cells.w == 0) { // one stretch
        bool first = coarse_at <= part.y;
        coarse_at = 1e30;
        return first;
    }
    bvec3 down = lessThan(r.inverse, vec3(0.0));
    while (coarse_at <= part.y) {
        int distance = distance_of(r, coarse), reach = max(distance - 1, 0);
        ivec3 low = coarse - mix(ivec3(0), ivec3(reach), down), high = coarse + mix(ivec3(reach), ivec3(0), down);
        vec3 exits = (mix(vec3(high + 1), vec3(low), down) * 4.0 - r.o) * r.inverse;
        float leave = min(min(exits.x, exits.y), exits.z);
        stretch = vec2(coarse_at, leave) + vec2(-1e-2, 1e-2);
        coarse_at = max(coarse_at, leave);
        ivec3 across = clamp(ivec3(floor((r.o + coarse_at * r.d) * 0.25)), low, high);
        coarse = mix(across, mix(high + 1, low - 1, down), lessThanEqual(exits, vec3(leave)));
        if (any(lessThan(coarse, FIRST_CELL)) || any(greaterThanEqual(coarse, FIRST_CELL + job.cells.xyz)))
            coarse_at = 1e30;
        if (distance == 0)
            return true;
    }
    return false;
}

#define NEXT_SEGMENT next_segment
#include "cells.glsl"

void march_begin(const Ray r)
{
    gather_begin();
}

#define PLACED
void march_place(const Ray r)
{
    part = vec2(0.0, float(r.n - 1) + r.fraction);
#ifdef BRICKS
    vec3 a = (job.own_lo.xyz - r.o) * r.inverse, b = (job.own_hi.xyz - r.o) * r.inverse, near = min(a, b), far = max(a, b);
    part = vec2(max(part.x, max(max(near.x, near.y), near.z)), min(part.y, min(min(far.x, far.y), far.z)));
    if (part.x >= part.y)
        return;
#endif
    coarse_at = part.x;
    coarse = clamp(ivec3(floor((r.o + part.x * r.d) * 0.25)), FIRST_CELL, FIRST_CELL + job.cells.xyz - 1);
    uint looked_at = cast_cells(pixel_of(), r, part);
    COUNT_TAKEN(looked_at)
}

#include "march.glsl"
