// SPDX-License-Identifier: MIT
// Emission and absorption with pre-integrated segments: mean extinction and mean colour between the values at a segment's ends, from integrals over the table.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"

#define ENDS
#ifndef SHADE
#define CHEAP
#endif
vec4 sum, color; // gathered; the segment's
float seen_at, front, length_of;
bool have_front;

void march_begin(const Ray r)
{
    sum = vec4(0.0);
    seen_at = -1.0;
    have_front = false;
}

void march_gap()
{
    have_front = false;
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
    if (!have_front)
        front = linear(p);
    length_of = k == r.n - 1 ? r.fraction : 1.0;
    float back = linear(r.o + (at + length_of) * r.d);
    color = isnan(front) || isnan(back) ? vec4(0.0) : pre_integrate(front, back, length_of);
    front = back;
    have_front = true;
    return color.a > 0.0 ? TAKE : GO_ON;
}

bool march_take(const Ray r, int k, float at, vec3 p)
{
    float middle = at + 0.5 * length_of;
#ifdef SHADE
    color.rgb = shade(r, gradient(r.o + middle * r.d), color.a, color.rgb);
#endif
    sum += (1.0 - sum.a) * color;
    if (seen_at < 0.0 && sum.a >= 0.5)
        seen_at = middle;
    return sum.a < job.gradient.z;
}

void march_end(const Ray r)
{
    result = sum;
    result_depth = seen_at;
}

#include "march.glsl"
