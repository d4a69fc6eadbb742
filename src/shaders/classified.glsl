// SPDX-License-Identifier: MIT
// Classification before interpolation, and the slope of labels: what ray caster and slices share beyond the look-up of a value.
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
