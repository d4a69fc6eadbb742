// SPDX-License-Identifier: MIT
// Emission and absorption with pre-integrated segments: mean extinction and mean colour between the values at a segment's ends, from integrals over the table.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"
#include "integrals.glsl"
#include "gather.glsl"
#include "segments.glsl"

#define TAKES
#ifndef SHADE
#define CHEAP
#endif
vec4 color; // of the segment

void march_begin(const Ray r)
{
    gather_begin();
    march_gap();
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
    vec2 ends = segment_ends(r, k, p);
    color = isnan(ends.x) || isnan(ends.y) ? vec4(0.0) : pre_integrate(ends.x, ends.y, segment_length(r, k));
    return color.a > 0.0 ? TAKE : GO_ON;
}

bool march_take(const Ray r, int k, float at, vec3 p)
{
    float middle = at + 0.5 * segment_length(r, k);
#ifdef SHADE
    color.rgb = shade(r, gradient(r.o + middle * r.d), color.a, color.rgb);
#endif
    put_behind(color, middle);
    return sum.a < job.gradient.z;
}

#include "march.glsl"
