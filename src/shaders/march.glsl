// SPDX-License-Identifier: MIT
// The ray marcher: one invocation a pixel. What is done at a sample is a filling, a file that gives
//   void march_begin(Ray r);                           before the first sample
//   int march_probe(Ray r, int k, float at, vec3 p);   looks at sample k, `at` steps from the entry, at index position p: GO_ON, TAKE or END
//   bool march_take(Ray r, int k, float at, vec3 p);   what is done where the probe said TAKE; false ends the ray (only where a probe says so: #define TAKES)
//   void march_end(Ray r);                             sets `result` and `result_depth`
//   bool march_load(Ray r, vec4 kept, float at);       BRICKS: takes up what march_save gave in the brick before; false where the ray has ended
//   vec4 march_save(out float at);                     what it has gathered so far; at >= 0 where that is anything
// and says with #define ENDS that samples lie at the segments' ends (k steps from the entry; march_gap() tells it that samples were left out), and with #define MAPLESS that no cell may be
// passed over. Each ray looks for its next visible sample, then neighbouring rays take theirs together: few lanes idle in the costly part, and a software rasteriser, which runs both sides
// of every branch, runs it only when it is due. Where taking is cheap (#define CHEAP) nobody waits. With #define PLACED there is nothing to march: march_place(Ray r) does it all.
//
// BRICKS: a volume in parts (bricks.h), from front to back a dispatch a part, and one that makes the picture of what they gathered. A sample has the same place along its ray in whichever
// part, and belongs to one of them; a segment to that of its front. tile.z is 1 in the last dispatch.
#include "tile.glsl"
#ifdef BRICKS
layout(rgba32f, binding = 0) uniform image2D picture; // what fillings keep, in the end the picture
layout(r32f, binding = 1) uniform image2D depth;
#else
layout(rgba32f, binding = 0) writeonly uniform image2D picture;
layout(r32f, binding = 1) writeonly uniform image2D depth;
#endif

#include "display.glsl"

#include "distances.glsl"

#ifndef PLACED
// The last sample (at its number + offset steps) that surely lies before an exit.
int samples_before(float exit, float offset)
{
    return int(clamp(exit * (1.0 - 4e-7) - offset - 1e-3, 0.0, 1e9));
}

// Looks at the cell of sample k: gives the next sample to go to, and in `look` the one at which to ask again, which is behind it where the cell may be seen.
int pass_over(const Ray r, int k, vec3 p, inout int look)
{
    ivec3 cell = clamp(ivec3(p) >> 2, FIRST_CELL, FIRST_CELL + job.cells.xyz - 1);
    int reach = distance_of(r, cell);
#ifdef ENDS
    int to = max(samples_before(cube_exit(r, cell, max(reach - 1, 0), 4.0), 0.0), k);
    bool jump = reach > 0 && to > k; // the segment that ends beyond the exit must be looked at
    if (jump)
        march_gap();
    look = jump ? to : to + 1;
    return jump ? to : k;
#else
    int to = max(samples_before(cube_exit(r, cell, max(reach - 1, 0), 4.0), r.offset), k) + 1;
    look = to;
    return reach > 0 ? to : k;
#endif
}

vec3 place(const Ray r, int k, out float at)
{
#ifdef ENDS
    at = float(k);
#else
    at = min(float(k) + r.offset, r.last);
#endif
    return r.o + at * r.d;
}

// Marches over the samples from k up to, not including, `end`; gives how many were looked at.
uint march(const Ray r, int k, int end)
{
    uint samples = 0u;
    int look = k;
#ifdef MAPLESS
    const bool maps = false;
#else
    bool maps = job.cells.w != 0;
#endif
    while (k < end) {
        int what = GO_ON;
        float at;
        vec3 p;
        while (k < end) {
            p = place(r, k, at);
#ifndef MAPLESS
            if (maps && k >= look)
                k = pass_over(r, k, p, look);
            if (maps && k >= look)
                continue;
#endif
            samples++;
            what = march_probe(r, k, at, p);
#ifdef CHEAP
            if (what == TAKE)
                what = march_take(r, k, at, p) ? GO_ON : END;
#endif
            if (what != GO_ON)
                break;
            k++;
        }
#if defined(TAKES) && !defined(CHEAP)
        if (what == TAKE && !march_take(r, k, at, p))
            what = END;
#endif
        if (what == END)
            break;
        k += what;
    }
    return samples;
}

#endif // PLACED

void show(ivec2 pixel, const Ray r)
{
    if (job.counts.z != 0 && result.a > 0.0)
        result.rgb = to_display(result.rgb / result.a) * result.a;
    imageStore(picture, pixel, result);
    imageStore(depth, pixel, vec4(result_depth >= 0.0 && result.a > 0.0 ? r.entry + result_depth * job.ray.z : uintBitsToFloat(0x7f800000u)));
}

#ifdef BRICKS
// How many samples lie before `t` steps from the entry.
int samples_until(const Ray r, float t)
{
#ifdef ENDS
    return int(clamp(ceil(t), 0.0, float(r.n)));
#else
    int k = int(clamp(ceil(t - r.offset), 0.0, float(r.n - 1)));
    return k == r.n - 1 && r.last < t ? r.n : k;
#endif
}

// The samples that the brick takes: axis by axis, so that two bricks count the samples before the face between them alike.
ivec2 samples_of(const Ray r)
{
    ivec2 range = ivec2(0, r.n);
    vec3 a = (job.own_lo.xyz - r.o) * r.inverse, b = (job.own_hi.xyz - r.o) * r.inverse;
    for (int i = 0; i < 3; i++)
        range = ivec2(max(range.x, samples_until(r, min(a[i], b[i]))), min(range.y, samples_until(r, max(a[i], b[i]))));
    return range;
}

void march_brick(ivec2 pixel, const Ray r)
{
    ivec2 range = samples_of(r);
#ifndef PLACED
    if (range.x >= range.y)
        return;
#endif
    float at = imageLoad(depth, pixel).r;
    if (at >= 0.0 && !march_load(r, imageLoad(picture, pixel), at))
        return;
#ifdef PLACED
    march_place(r);
#else
    uint samples = march(r, range.x, range.y);
    COUNT_TAKEN(samples)
#endif
    imageStore(picture, pixel, march_save(at));
    imageStore(depth, pixel, vec4(at));
}

void finish_bricks(ivec2 pixel, const Ray r)
{
    float at = imageLoad(depth, pixel).r;
    if (at >= 0.0)
        march_load(r, imageLoad(picture, pixel), at);
    march_end(r);
    COUNT_IN_BOX(uint(r.n))
}
#endif

void main()
{
    ivec2 pixel = pixel_of();
    if (any(greaterThanEqual(pixel, job.picture.xy)))
        return;
    result = vec4(0.0);
    result_depth = -1.0;
    Ray r;
    bool met = ray_of(pixel, r);
    if (met)
        march_begin(r);
#ifdef BRICKS
    if (tile.z == 0) {
        if (met)
            march_brick(pixel, r);
        return;
    }
    if (met)
        finish_bricks(pixel, r);
#else
    if (met) {
#ifdef PLACED
        march_place(r);
#else
        uint samples = march(r, 0, r.n);
        COUNT_TAKEN(samples)
#endif
        march_end(r);
        COUNT_IN_BOX(uint(r.n))
    }
#endif
    show(pixel, r);
}
