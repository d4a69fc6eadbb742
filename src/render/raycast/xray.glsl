// SPDX-License-Identifier: MIT
// X-ray: absorption only (equation 1.3).
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"

float total;

void march_begin(const Ray r)
{
    total = 0.0;
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
    float raw = reconstruct(p);
    if (!isnan(raw))
        total += entry(entry_of(raw), EXTINCTION).x * (k == r.n - 1 ? r.fraction : 1.0);
    return GO_ON;
}

bool march_load(const Ray r, vec4 kept, float at)
{
    total = kept.x;
    return true;
}

vec4 march_save(out float at)
{
    at = 0.0;
    return vec4(total);
}

void march_end(const Ray r)
{
    float alpha = 1.0 - exp(-total);
    result = vec4(vec3(job.gradient.w != 0.0 ? alpha : 0.0), alpha);
}

#include "march.glsl"
