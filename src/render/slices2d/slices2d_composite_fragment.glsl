// SPDX-License-Identifier: MIT
// Emission and absorption by slices: sections 4 to 6, shaded as in section 8.
#include "job.glsl"
#include "space.glsl"
#include "slices2d_space.glsl"
#include "slices2d_stack.glsl"
#include "transfer.glsl"
#include "classified.glsl"
#include "slices2d_gather.glsl"
#ifdef SHADE
#include "slices2d_lighting.glsl"
#endif
layout(location = 0) flat in int first_slice;

// A slice stands for the slab half way to its neighbours; of a slab that the box, a clip plane or the eye cuts only the part inside counts. `length` of it
// along the ray, in steps: colour times opacity, and opacity.
vec4 classify(vec3 s, float length)
{
#ifdef PRE
    vec4 mixed = pre_interpolate(s.FROM_STACK); // the paper's palette before interpolation
    if (!(mixed.a > 0.0))
        return vec4(0.0);
    vec4 point = vec4(mixed.rgb / mixed.a, min(mixed.a, 1.0));
#else
#ifdef NEAREST
    float raw = voxel(nearest_voxel(s));
#else
    float raw = on_slice(s);
#endif
    if (isnan(raw))
        return vec4(0.0);
#endif
#if defined(LINEAR_CORRECTION) && !defined(PRE)
    vec4 point = entry(entry_of(raw), POINT);
#endif
#if defined(LINEAR_CORRECTION)
    float alpha = min(point.a * length * job.table.w, 1.0); // section 4: "scaling the values linearly"
    return vec4(alpha * point.rgb, alpha);
#elif defined(PRE)
    float alpha = alpha_of_length(point.a, length * job.table.w);
    return vec4(alpha * point.rgb, alpha);
#else
    vec4 slab = entry(entry_of(raw), SLAB); // exact: 1 - (1 - opacity)^(length / unit)
    float alpha = 1.0 - exp2(-slab.a * length);
    return vec4(alpha * slab.rgb, alpha);
#endif
}

// The sample of slice m; no opacity where the ray does not run there.
vec4 sample_slice(const SliceRay s, int m, out vec3 place)
{
    float share = min(s.to, float(m) + 0.5) - max(s.from, float(m) - 0.5);
    place = slice_place(s, float(m));
#ifdef DISPLACED
    // What figure 13 shows without the correction: all slices with the texture coordinates of the polygon's own place.
    place.xy = s.at + (float(first_slice) + 0.5 * float(slices.polygons.x - 1)) * s.by;
#endif
    place = clamp(place, vec3(0.0), vec3(job.dims.xyz.TO_STACK - 1)); // beside the box: cut off at its faces
    return share > 0.0 ? classify(place, share * s.steps) : vec4(0.0);
}

void main()
{
    SliceRay s;
    Ray r;
    if (!slice_ray(gl_FragCoord.xy - 0.5, s, r))
        discard;
    gather_begin();
    int m = first_slice, end = first_slice + slices.polygons.x;
#ifdef SHADE
    while (m < end) { // software runs both sides of branches: neighbours look for their next visible slice first, and shade together
        vec4 color = vec4(0.0);
        vec3 place;
        for (; m < end; m++) {
            color = sample_slice(s, m, place);
            if (color.a > 0.0)
                break;
        }
        if (m >= end)
            break;
#ifdef NEAREST
        vec3 g = opacity_gradient(nearest_voxel(place));
#else
        vec3 g = gradient(place);
#endif
        put_behind(vec4(light_sample(r, g, color.a, color.rgb), color.a), float(m));
        m++;
    }
#else
    for (; m < end; m++) {
        vec3 place;
        put_behind(sample_slice(s, m, place), float(m));
    }
#endif
    gather_end(s);
}
