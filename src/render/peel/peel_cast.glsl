// SPDX-License-Identifier: MIT
// Section 4.3.2: rays cast within their valid segments alone. With STEPPING by uniform steps, the ray caster's own samples; else cell by cell, exactly.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "shading.glsl"
#include "gather.glsl"
#include "tile.glsl"
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
#include "peel_cubic.glsl"

// The next place in a segment, from `at` on; a new place is in a new cell.
bool next_place(ivec2 pixel, const Ray r, float whole, inout float at, inout float end)
{
    vec2 stretch;
    while (NEXT_SEGMENT(pixel, r, stretch)) {
        float first = clamp(stretch.x, 0.0, whole);
        end = min(stretch.y, whole);
        if (first > at) {
            at = first;
            cell = clamp(ivec3(floor(r.o + at * r.d)), ivec3(0), max(job.dims.xyz - 2, ivec3(0)));
            carried = false;
        }
        if (at < end)
            return true;
    }
    return false;
}

uint cast_ray(ivec2 pixel, const Ray r)
{
    uint cells = 0u;
    float whole = float(r.n - 1) + r.fraction, at = -1.0, end = -1.0, from, to;
    vec3 side = mix(vec3(1.0), vec3(0.0), lessThan(r.inverse, vec3(0.0)));
    ivec3 onwards = ivec3(2.0 * side - 1.0), last = max(job.dims.xyz - 2, ivec3(0));
    bvec3 single = equal(job.dims.xyz, ivec3(1)); // a single voxel is all along its axis
    bool going = true;
    carried = false;
    while (going) {
        bool found = false;
        while (!found) {
            if (at >= end && !next_place(pixel, r, whole, at, end))
                break;
            vec3 exits = mix((vec3(cell) + side - r.o) * r.inverse, vec3(1e30), single);
            float leave = min(min(exits.x, exits.y), exits.z);
            from = at;
            to = min(leave, whole);
            if (to > from) {
                cells++;
                found = take_cell();
                at = to;
            }
            cell += mix(ivec3(0), onwards, lessThanEqual(exits, vec3(leave)));
            if (any(lessThan(cell, ivec3(0))) || any(greaterThan(cell, last)))
                at = 1e30; // out of the volume
        }
        going = found && add_surfaces(r, from, to);
    }
    return cells;
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

#include "march.glsl"
