// SPDX-License-Identifier: MIT
// MIP and MinIP (MINIMUM): the greatest or least sample.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"

#ifdef MINIMUM
const float sign_of = -1.0;
#else
const float sign_of = 1.0;
#endif
float best, best_at;

void march_begin(const Ray r)
{
#ifdef VOIDS
    best = -3.4e38;
    best_at = -1.0;
#else
    best = sign_of > 0.0 ? job.range.x : -job.range.y; // every sample is at least the volume's own least value
    best_at = min(r.offset, r.last);
#endif
}

// No sample of the volume can beat it.
bool is_extreme()
{
    return best >= (sign_of > 0.0 ? job.range.y : -job.range.x);
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
    float value = sign_of * reconstruct(p);
    if (value > best) { // false for a void
        best = value;
        best_at = at;
    }
    return is_extreme() ? END : GO_ON;
}

bool march_load(const Ray r, vec4 kept, float at)
{
    best = kept.x;
    best_at = at;
    return !is_extreme();
}

vec4 march_save(out float at)
{
    at = best_at;
    return vec4(best);
}

void march_end(const Ray r)
{
    if (best_at >= 0.0)
        show_value(sign_of * best, best_at);
}

#include "march.glsl"
