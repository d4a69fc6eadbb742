// SPDX-License-Identifier: MIT
// Lighting of a sample: the scene's Blinn-Phong (shading.glsl), or the paper's. `color` is multiplied by `alpha`, and so is what comes back.
#include "shading.glsl"

vec3 light_sample(const Ray r, vec3 g, float alpha, vec3 color)
{
#if LIGHTING == 0
    return shade(r, g, alpha, color);
#else
    // Equation 6: I = I_a + I_d (n . l), for as many coloured lights as there are. Section 8 (a): I_a is one for the whole volume (LIGHTING 1); (b): it is
    // the voxel's own colour (2), added to the diffuse light, not multiplied with it. The normal points out of what is dense; the other side stays dark.
    vec3 n = -vec3(dot(job.normal[0].xyz, g), dot(job.normal[1].xyz, g), dot(job.normal[2].xyz, g));
    vec3 v = -job.light.w * vec3(dot(job.to_world[0].xyz, r.d), dot(job.to_world[1].xyz, r.d), dot(job.to_world[2].xyz, r.d));
    float length2 = dot(n, n);
    vec3 lit = vec3(0.0);
    if (length2 > 1e-30 && length2 <= 3.4e38) {
        n *= inversesqrt(length2);
        for (int l = 0; l < job.counts.x; l++)
            lit += job.light_diffuse[l].xyz * max(dot(n, job.light_direction[l].w != 0.0 ? v : job.light_direction[l].xyz), 0.0);
    }
#if LIGHTING == 1
    color = alpha * slices.ambient.rgb;
#endif
    return min(color + alpha * lit, vec3(alpha));
#endif
}
