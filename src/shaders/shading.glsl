// SPDX-License-Identifier: MIT
// Blinn-Phong from a gradient, two-sided (docs/optics.md, src/cpu/shade.h). Where there is no gradient: fully lit, no highlight.
float highlight(float cosine)
{
    return job.light.z > 0.0 ? pow(max(cosine, 1e-30), job.light.y) : 0.0;
}

vec3 shade(const Ray r, vec3 g, float alpha, vec3 color)
{
    vec3 lit = job.all_diffuse.xyz, shine = vec3(0.0);
#ifdef HEADLIGHTS
    float length2 = dot(job.metric[0].xyz, g * g) + job.metric[0].w * g.x * g.y + job.metric[1].x * g.x * g.z + job.metric[1].y * g.y * g.z;
    if (length2 > 1e-30 && length2 <= 3.4e38) {
        float cosine = min(abs(dot(g, r.d)) * job.light.w * inversesqrt(length2), 1.0);
        lit *= cosine;
        shine = job.all_specular.xyz * highlight(cosine);
    }
#else
    vec3 n = vec3(dot(job.normal[0].xyz, g), dot(job.normal[1].xyz, g), dot(job.normal[2].xyz, g));
    vec3 v = -job.light.w * vec3(dot(job.to_world[0].xyz, r.d), dot(job.to_world[1].xyz, r.d), dot(job.to_world[2].xyz, r.d));
    float length2 = dot(n, n);
    if (length2 > 1e-30 && length2 <= 3.4e38) {
        n *= (dot(n, v) < 0.0 ? -1.0 : 1.0) * inversesqrt(length2);
        lit = vec3(0.0);
        for (int l = 0; l < job.counts.x; l++) {
            vec3 to = job.light_direction[l].w != 0.0 ? v : job.light_direction[l].xyz, h = to + v;
            float cosine = max(dot(n, to), 0.0), between = max(dot(n, h), 0.0) * inversesqrt(max(dot(h, h), 1e-12));
            lit += job.light_diffuse[l].xyz * cosine;
            shine += job.light_specular[l].xyz * highlight(min(between, 1.0));
        }
    }
#endif
    return min(color * (job.light.x + lit) + alpha * shine, vec3(alpha));
}
