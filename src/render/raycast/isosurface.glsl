// SPDX-License-Identifier: MIT
// Isosurfaces: crossings between the ends of segments, in the order of the ray; the root by regula falsi (Illinois) on the reconstructed signal.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"
#include "gather.glsl"
#include "segments.glsl"

#define TAKES
vec2 ends; // of the segment

void march_begin(const Ray r)
{
    gather_begin();
    march_gap();
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

int march_probe(const Ray r, int k, float at, vec3 p)
{
    ends = segment_ends(r, k, p);
    if (isnan(ends.x) || isnan(ends.y))
        return GO_ON;
    bool crossed = false;
    for (int i = 0; i < job.counts.y; i++)
        crossed = crossed || (ends.x < job.iso[i].x) != (ends.y < job.iso[i].x);
    return crossed ? TAKE : GO_ON;
}

bool march_take(const Ray r, int k, float at, vec3 p)
{
    for (int j = 0; j < job.counts.y; j++) {
        int i = ends.y > ends.x ? j : job.counts.y - 1 - j;
        float iso = job.iso[i].x;
        if ((ends.x < iso) == (ends.y < iso))
            continue;
        float root = find_root(r, iso, at, ends.x, at + segment_length(r, k), ends.y), alpha = job.iso[i].y;
        if (isnan(root)) // the search met a void
            continue;
        vec3 color = shade(r, gradient(r.o + root * r.d), alpha, alpha * job.iso_color[i].rgb);
        if (seen_at < 0.0) // the depth is the first surface's, however faint
            seen_at = root;
        put_behind(vec4(color, alpha), root);
        if (sum.a >= job.gradient.z || alpha >= 1.0)
            return false;
    }
    return true;
}

#include "march.glsl"
