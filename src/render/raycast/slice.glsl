// SPDX-License-Identifier: MIT
// An oblique slice: the value where the ray meets the plane.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"

#define MAPLESS
void march_begin(const Ray r)
{
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
    return END; // one place alone counts
}

void march_end(const Ray r)
{
    float from = dot(job.slice_plane.xyz, r.o) + job.slice_plane.w, along = dot(job.slice_plane.xyz, r.d), length = float(r.n - 1) + r.fraction;
    if (abs(along) <= 1e-9 * job.ray.z) // world lengths a step
        return;
    float at = -from / along;
    if (at < -1e-4 || at > length + 1e-4)
        return;
    at = clamp(at, 0.0, length);
    float raw = reconstruct(r.o + at * r.d);
    if (!isnan(raw))
        show_value(raw, at);
}

#include "march.glsl"
