// SPDX-License-Identifier: MIT
// Oblique slices: the values where the ray meets the planes, composited from the nearest on.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "plane_place.glsl"

#define PLACED
vec4 gathered;
float gathered_at;

void march_begin(const Ray r)
{
    gathered = vec4(0.0);
    gathered_at = -1.0;
}

void gather(const Ray r, float at)
{
    vec3 p = r.o + at * r.d;
#ifdef BRICKS
    if (any(lessThan(p, job.own_lo.xyz)) || any(greaterThanEqual(p, job.own_hi.xyz)))
        return;
#endif
    float raw = reconstruct(p);
    if (isnan(raw))
        return;
    show_value(raw, at);
    if (result.a > 0.0 && gathered_at < 0.0)
        gathered_at = at;
    gathered += (1.0 - gathered.a) * result;
}

void march_place(const Ray r)
{
    uint done = 0u;
    for (int i = 0; i < job.counts.w; i++) {
        int nearest = -1;
        float least = 3e38;
        for (int p = 0; p < job.counts.w; p++) {
            float at = (done >> p & 1u) != 0u ? -1.0 : plane_place(r, p);
            if (at >= 0.0 && at < least) {
                nearest = p;
                least = at;
            }
        }
        if (nearest < 0)
            break;
        done |= 1u << nearest;
        gather(r, least);
    }
}

bool march_load(const Ray r, vec4 kept, float at)
{
    gathered = kept;
    gathered_at = at;
    return gathered.a < 1.0;
}

vec4 march_save(out float at)
{
    at = gathered_at;
    return gathered;
}

void march_end(const Ray r)
{
    result = gathered;
    result_depth = gathered_at;
}

#include "march.glsl"
