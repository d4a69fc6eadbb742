// SPDX-License-Identifier: MIT
// Emission and absorption (equation 1.8), post- or pre-classified; nearest reconstruction of labels.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"
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

#ifdef PRE
// Pre-classification: opacity-weighted colours of the eight voxels, interpolated. Colour and opacity of one step; negative opacity for a void.
vec4 pre_classify(vec3 p)
{
    ivec3 c = clamp(ivec3(floor(p)), ivec3(0), max(job.dims.xyz - 2, ivec3(0)));
    vec3 f = p - vec3(c);
    vec4 mixed = vec4(0.0);
    for (int i = 0; i < 8; i++) {
        ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2);
        float raw = voxel(c + corner);
        if (isnan(raw))
            return vec4(-1.0);
        vec3 w = mix(1.0 - f, f, vec3(corner));
        vec4 point = entry(entry_of(raw), POINT);
        mixed += w.x * w.y * w.z * vec4(point.rgb * point.a, point.a);
    }
    float alpha = mixed.a > 0.0 ? alpha_of_length(min(mixed.a, 1.0), job.table.w) : 0.0;
    return vec4(mixed.rgb * (alpha / (mixed.a > 0.0 ? mixed.a : 1.0)), alpha);
}
#endif

#ifdef NEAREST
// Of the neighbours' opacities, since labels have no slope.
vec3 opacity_gradient(ivec3 v)
{
    vec3 g;
    for (int a = 0; a < 3; a++) {
        ivec3 e = ivec3(a == 0, a == 1, a == 2);
        float before = voxel(v - e), behind = voxel(v + e);
        if (isnan(before) || isnan(behind))
            return vec3(0.0);
        g[a] = 0.5 * (entry(entry_of(behind), POINT).a - entry(entry_of(before), POINT).a);
    }
    return g;
}
#endif

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
