// SPDX-License-Identifier: MIT
// An oblique slice: the value where the ray meets the plane.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"

#define PLACED
float value, value_at;

void march_begin(const Ray r)
{
    value_at = -1.0;
}

void march_place(const Ray r)
{
    float from = dot(job.slice_plane.xyz, r.o) + job.slice_plane.w, along = dot(job.slice_plane.xyz, r.d), length = float(r.n - 1) + r.fraction;
    if (abs(along) <= 1e-9 * job.ray.z) // world lengths a step
        return;
    float at = -from / along;
    if (at < -1e-4 || at > length + 1e-4)
        return;
    at = clamp(at, 0.0, length);
    vec3 p = r.o + at * r.d;
#ifdef BRICKS
    if (any(lessThan(p, job.own_lo.xyz)) || any(greaterThanEqual(p, job.own_hi.xyz)))
        return;
#endif
    float raw = reconstruct(p);
    if (!isnan(raw)) {
        value = raw;
        value_at = at;
    }
}

bool march_load(const Ray r, vec4 kept, float at)
{
    value = kept.x;
    value_at = at;
    return false; // one place alone counts
}

vec4 march_save(out float at)
{
    at = value_at;
    return vec4(value);
}

void march_end(const Ray r)
{
    if (value_at >= 0.0)
        show_value(value, value_at);
}

#include "march.glsl"
