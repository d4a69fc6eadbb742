// SPDX-License-Identifier: MIT
// Section 4.3.2: rays cast within their valid segments alone. With STEPPING by uniform steps, the ray caster's own samples; else cell by cell, exactly.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "shading.glsl"
#include "gather.glsl"
#include "tile.glsl"
#include "root.glsl"
#include "surface.glsl"
#include "peel_block.glsl"
#ifdef TREE
#include "peel_tree.glsl"
#else
#include "peel_segments.glsl"
#endif
layout(std430, binding = 7) buffer PeelCounters { uvec4 peel_counters[64]; }; // x: rays that have segments; y, z: segments, low and high

#ifdef WHOLE
#define NEXT_SEGMENT whole_ray
// Brute force: one stretch, whatever the masks would say.
bool whole_ray(ivec2 pixel, const Ray r, out vec2 stretch)
{
    bool first = segments == 0u;
    stretch = vec2(0.0, 1e30);
    segments = 1u;
    return first;
}
#else
#define NEXT_SEGMENT next_segment
#endif

#ifdef STEPPING
#ifdef BINARY_SEARCH
#define FIND_ROOT binary_search
// The refinement of the paper: halves the step ten times.
float binary_search(const Ray r, float iso, float a, float f, float b, float g)
{
    for (int i = 0; i < 10; i++) {
        float middle = 0.5 * (a + b), value = linear(r.o + middle * r.d);
        if (isnan(value))
            return value;
        if ((value < iso) == (f < iso))
            a = middle;
        else
            b = middle;
    }
    return 0.5 * (a + b);
}
#endif
#include "crossings.glsl"

// The next step from k on that is in a segment, or the end of the ray.
bool next_steps(ivec2 pixel, const Ray r, inout int k, inout int end)
{
    vec2 stretch;
    while (NEXT_SEGMENT(pixel, r, stretch)) {
        int first = max(int(floor(clamp(stretch.x, 0.0, float(r.n)))), k);
        end = int(ceil(clamp(stretch.y, 0.0, float(r.n))));
        if (first > k)
            march_gap();
        k = first;
        if (k < end)
            return true;
    }
    return false;
}

uint cast_ray(ivec2 pixel, const Ray r)
{
    uint samples = 0u;
    int k = 0, end = 0;
    bool going = true;
    march_gap();
    while (going) {
        int what = GO_ON;
        float at;
        vec3 p;
        while (what == GO_ON) {
            if (k >= end && !next_steps(pixel, r, k, end)) {
                what = END;
                break;
            }
            samples++;
            at = float(k);
            p = r.o + at * r.d;
            what = march_probe(r, k, at, p);
            k++;
        }
        going = what == TAKE && march_take(r, k - 1, at, p);
    }
    return samples;
}

#else
#include "cells.glsl"

uint cast_ray(ivec2 pixel, const Ray r)
{
    return cast_cells(pixel, r, vec2(0.0, float(r.n - 1) + r.fraction));
}
#endif

void march_begin(const Ray r)
{
    gather_begin();
}

#define PLACED
void march_place(const Ray r)
{
    segments_begin(r);
    uint looked_at = cast_ray(pixel_of(), r);
    COUNT_TAKEN(looked_at)
    if (segments > 0u) {
        uint row = (gl_WorkGroupID.x + gl_WorkGroupID.y * 11u) & 63u;
        atomicAdd(peel_counters[row].x, 1u);
        if (atomicAdd(peel_counters[row].y, segments) > 0xffffffffu - segments)
            atomicAdd(peel_counters[row].z, 1u);
    }
}

#undef COUNT_IN_BOX // samples that tiles without rays leave out are not counted, so the others need not be
#define COUNT_IN_BOX(more)
#include "march.glsl"
