// SPDX-License-Identifier: MIT
// The ray marcher: one invocation a pixel. What is done at a sample is a filling, a file that gives
//   void march_begin(Ray r);                           before the first sample
//   int march_probe(Ray r, int k, float at, vec3 p);   looks at sample k, `at` steps from the entry, at index position p: GO_ON, TAKE or END
//   bool march_take(Ray r, int k, float at, vec3 p);   what is done where the probe said TAKE; false ends the ray (only where a probe says so: #define TAKES)
//   void march_end(Ray r);                             sets `result` and `result_depth`
// and says with #define ENDS that samples lie at the segments' ends (k steps from the entry; march_gap() tells it that samples were left out), and with #define MAPLESS that no cell may be
// passed over. Each ray looks for its next visible sample, then neighbouring rays take theirs together: few lanes idle in the costly part, and a software rasteriser, which runs both sides
// of every branch, runs it only when it is due. Where taking is cheap (#define CHEAP) nobody waits.
layout(local_size_x = 64) in; // 8x8 pixels
layout(rgba32f, binding = 0) writeonly uniform image2D picture;
layout(r32f, binding = 1) writeonly uniform image2D depth;
layout(std430, binding = 2) buffer Counters { uvec2 taken, in_box; }; // low and high words

// Distances in cells to the nearest cell that may be seen, a map for each octant of directions above the other along z (distance.glsl).
layout(binding = 1) uniform usampler3D distances;

// Linear light back to display values (the sRGB curve): the colour without its opacity is encoded.
vec3 to_display(vec3 c)
{
    return mix(1.055 * pow(max(c, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// Steps to where the ray leaves the cube of cells from `cell - reach` to `cell + reach`, `size` voxels each.
float cube_exit(const Ray r, ivec3 cell, int reach, float size)
{
    vec3 side = mix(vec3(reach + 1), vec3(-reach), lessThan(r.inverse, vec3(0.0)));
    vec3 exits = ((vec3(cell) + side) * size - r.o) * r.inverse;
    return min(min(exits.x, exits.y), exits.z);
}

// The last sample (at its number + offset steps) that surely lies before an exit.
int samples_before(float exit, float offset)
{
    return int(clamp(exit * (1.0 - 4e-7) - offset - 1e-3, 0.0, 1e9));
}

// Looks at the cell of sample k: gives the next sample to go to, and in `look` the one at which to ask again, which is behind it where the cell may be seen.
int pass_over(const Ray r, int k, vec3 p, inout int look)
{
    ivec3 cell = clamp(ivec3(p) >> 2, ivec3(0), job.cells.xyz - 1);
    int reach = int(texelFetch(distances, cell + ivec3(0, 0, r.octant * job.cells.z), 0).r);
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

void main()
{
    // Neighbouring lanes in blocks of 4x2 and 8x4 pixels: their rays go alike.
    int lane = int(gl_LocalInvocationIndex);
    ivec2 pixel = ivec2(gl_WorkGroupID.xy) * 8 + ivec2((lane & 3) | (lane >> 1 & 4), (lane >> 2 & 1) | (lane >> 3 & 6));
    if (any(greaterThanEqual(pixel, job.picture.xy)))
        return;
    result = vec4(0.0);
    result_depth = -1.0;
    Ray r;
    if (ray_of(pixel, r)) {
        uint samples = 0u;
        int k = 0, look = 0;
#ifdef MAPLESS
        const bool maps = false;
#else
        bool maps = job.cells.w != 0;
#endif
        march_begin(r);
        while (k < r.n) {
            int what = GO_ON;
            float at;
            vec3 p;
            while (k < r.n) {
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
        march_end(r);
        if (atomicAdd(taken.x, samples) > 0xffffffffu - samples)
            atomicAdd(taken.y, 1u);
        if (atomicAdd(in_box.x, uint(r.n)) > 0xffffffffu - uint(r.n))
            atomicAdd(in_box.y, 1u);
    }
    if (job.counts.z != 0 && result.a > 0.0)
        result.rgb = to_display(result.rgb / result.a) * result.a;
    imageStore(picture, pixel, result);
    imageStore(depth, pixel, vec4(result_depth >= 0.0 && result.a > 0.0 ? r.entry + result_depth * job.ray.z : uintBitsToFloat(0x7f800000u)));
}
