// SPDX-License-Identifier: MIT
// Emission and absorption with pre-integrated segments: mean extinction and mean colour between the values at a segment's ends, from integrals over the table.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"
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

struct Integral {
    float entry, tau;
    vec4 sums;
    vec3 color;
};

// The integrals up to a value: the sum at the nearest entry, and on from there with its extinction, also beyond the table's ends.
Integral integral_to(float raw)
{
    Integral t;
    int i = entry_of(raw);
    t.entry = raw * job.table.x + job.table.y - 0.5;
    t.tau = entry(i, EXTINCTION).x;
    float beyond = (t.entry - float(i)) * t.tau;
    t.color = entry(i, POINT).rgb;
    t.sums = entry(i, SUMS) + beyond * vec4(t.color, 1.0);
    return t;
}

vec4 pre_integrate(float a, float b, float length)
{
    Integral f = integral_to(a), g = integral_to(b);
    float span = g.entry - f.entry;
    if (abs(span) < 0.25) {
        float alpha = 1.0 - exp(-max(f.tau, 0.0) * length);
        return vec4(alpha * f.color, alpha);
    }
    float tau = max((g.sums.a - f.sums.a) / span, 0.0), alpha = 1.0 - exp(-tau * length);
    vec3 color = (g.sums.rgb - f.sums.rgb) * (alpha / (tau > 0.0 ? tau * span : 1.0));
    return vec4(clamp(color, vec3(0.0), vec3(alpha)), alpha);
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
