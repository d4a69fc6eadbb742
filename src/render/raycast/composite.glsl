// SPDX-License-Identifier: MIT
// Emission and absorption (equation 1.8), post- or pre-classified; nearest reconstruction of labels.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"
#include "classified.glsl"
#include "gather.glsl"

#define TAKES
#ifndef SHADE
#define CHEAP
#endif
vec4 color; // of the sample

void march_begin(const Ray r)
{
    gather_begin();
}

int march_probe(const Ray r, int k, float at, vec3 p)
{
#ifdef PRE
    color = pre_classify(p);
#else
    float raw = reconstruct(p);
    color = isnan(raw) ? vec4(0.0) : entry(entry_of(raw), STEP);
#endif
    return color.a > 0.0 ? TAKE : GO_ON;
}

bool march_take(const Ray r, int k, float at, vec3 p)
{
    if (k == r.n - 1) {
        float shorter = alpha_of_length(color.a, r.fraction);
        color *= shorter / color.a;
    }
#ifdef SHADE
#ifdef NEAREST
    color.rgb = shade(r, opacity_gradient(nearest_voxel(p)), color.a, color.rgb);
#else
    color.rgb = shade(r, gradient(p), color.a, color.rgb);
#endif
#endif
    put_behind(color, at);
    return sum.a < job.gradient.z;
}

#include "march.glsl"
