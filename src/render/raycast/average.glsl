// SPDX-License-Identifier: MIT
// The mean of all samples, weighted by their segments' lengths.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"

#define MAPLESS
float total, weight;

void march_begin(const Ray r)
{
    total = weight = 0.0;
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
    float raw = reconstruct(p), length = k == r.n - 1 ? r.fraction : 1.0;
    if (!isnan(raw)) {
        total += raw * length;
        weight += length;
    }
    return GO_ON;
}

bool march_load(const Ray r, vec4 kept, float at)
{
    total = kept.x;
    weight = kept.y;
    return true;
}

vec4 march_save(out float at)
{
    at = 0.0;
    return vec4(total, weight, 0.0, 0.0);
}

void march_end(const Ray r)
{
    if (weight > 0.0)
        show_value(total / weight, -1.0);
}

#include "march.glsl"
