// SPDX-License-Identifier: MIT
// Isosurfaces: crossings between the ends of segments, in the order of the ray; the root by regula falsi (Illinois) on the reconstructed signal.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"

#define ENDS
vec4 sum;
float seen_at, front, segment_front, segment_back; // the next segment's front; this one's ends
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

// Root of value = iso in [a, b] (steps), between f and g on different sides.
float find_root(const Ray r, float iso, float a, float f, float b, float g)
{
    f -= iso;
    g -= iso;
    for (int i = 0; i < 6; i++) {
        float root = clamp(a + (b - a) * (f / (f == g ? 1.0 : f - g)), a, b);
        float h = linear(r.o + root * r.d) - iso;
        if (isnan(h))
            return h;
        if ((h < 0.0) == (f < 0.0)) { // the root lies behind
            a = root;
            f = h;
            g *= 0.5;
        } else {
            b = root;
            g = h;
            f *= 0.5;
        }
    }
    return clamp(a + (b - a) * (f / (f == g ? 1.0 : f - g)), a, b);
}

float end_of(const Ray r, int k)
{
    return float(k) + (k == r.n - 1 ? r.fraction : 1.0);
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
    segment_front = have_front ? front : linear(p);
    segment_back = linear(r.o + end_of(r, k) * r.d);
    front = segment_back;
    have_front = true;
    if (isnan(segment_front) || isnan(segment_back))
        return GO_ON;
    bool crossed = false;
    for (int i = 0; i < job.counts.y; i++)
        crossed = crossed || (segment_front < job.iso[i].x) != (segment_back < job.iso[i].x);
    return crossed ? TAKE : GO_ON;
}

bool march_take(const Ray r, int k, float at, vec3 p)
{
    for (int j = 0; j < job.counts.y; j++) {
        int i = segment_back > segment_front ? j : job.counts.y - 1 - j;
        float iso = job.iso[i].x;
        if ((segment_front < iso) == (segment_back < iso))
            continue;
        float root = find_root(r, iso, at, segment_front, end_of(r, k), segment_back), alpha = job.iso[i].y;
        if (isnan(root)) // the search met a void
            continue;
        vec3 color = shade(r, gradient(r.o + root * r.d), alpha, alpha * job.iso_color[i].rgb);
        sum += (1.0 - sum.a) * vec4(color, alpha);
        if (seen_at < 0.0)
            seen_at = root;
        if (sum.a >= job.gradient.z || alpha >= 1.0)
            return false;
    }
    return true;
}

void march_end(const Ray r)
{
    result = sum;
    result_depth = seen_at;
}

#include "march.glsl"
